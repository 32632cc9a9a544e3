"""Every script of examples/ runs in an empty folder and gives its answer.

The first one runs as a reader starts it; the others in the process of the tests, which has loaded already what they need.
"""

from __future__ import annotations

import contextlib
import io
import re
import runpy
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"

ANSWERS = {
    # Hunting from 3 mm persists above 220 km/h, docs/studies/paper.md: exact contact.
    "01_first_run": ([r"160 km/h: 0\.00 mm .*, ok", r"240 km/h: 4\.[45]\d mm .*, ok"], ["run.nc", "motion.png"]),
    "02_rig_and_track": ([r"on track: 266\.5", r"0\.5 m: 210\.\d", r"0\.725 m: 224\.1", r"2 m: 248\.1"], ["damping.png"]),
    "03_own_controller": ([r"gain 0 .* 0\.0[89]\d %", r"gain 1000 .* 0\.0(?:19|20)\d* %", r"gain 4000 .* 0\.02\d %"], []),
    # One patch or two, both with their weights: the exact theory has its centre at +1.4 mm, docs/validation.md.
    "04_contact": ([r"hertz, \+0 mm: S = -7\.7 .*, S = \+3\.3", r"strips, \+0 mm: S = -7\.5 .*, S = \+1\.4 .*, S = \+2\.4"],
                   ["contact.png"]),
    "05_brake_on_low_adhesion": ([r"distance after the same time -?0\.0\d+ ", r"RMS over train speed 0\.02\d "],
                                 ["brake/report.html", "brake/summary.json"]),
    # Smooth contact: the raw load is the filtered one, where ellipses that come and go shook it down to 24 kN.
    "06_running_safety": ([r"largest Y/Q: 0\.22 at wheelset_1_right; .* 1\.34", r"load: 39\.5 kN; raw 39\.5 kN"],
                          ["quotient.png"]),
    # In lock-step at the sample time of the built-in controller it is the same run, read one sample of the rig later.
    "10_brake_controller": ([r"after 53\.\d+ s at 3\.6 km/h",
                             r"outside: 98\d\.\d\d m, built in: 98\d\.\d\d m, [+-]0\.00\d %"], []),
    "11_fmu": ([r"validation: nothing to say", r"after 8 s: 10[67]\.\d km/h",
                r"slip 1\d %, vented in 3\d\d of 1600"], ["bench.fmu"]),
    "12_fmu_controller": ([r"wsp\.fmu: adhesion_brake\.slide_protection, FMI 2\.0", r"vented in [1-9]\d*",
                           r"the same numbers: True"], ["wsp.fmu"]),
    "07_python_control": ([r"at its limit at 1\.[12]\d?e\+05", r"after 5\d ms", r"at most 1\.\d\d % of the step"], []),
    "08_to_matlab": ([r"vertical_force: time wheel, N", r"the same numbers: True"], ["run.mat", "run.csv", "run.parquet"]),
    "13_wide_curve": ([r"1445 mm, new rails: Y .* 24\.\d kN, .* 4[89]\d N", r"1435 mm, .* 24\.\d kN, .* 4[56]\d N",
                       r"right rail worn: .* 4[23]\d N"], ["worn_rail.txt"]),
    # Errors of the means are 0.003 to 0.015, docs/measured.md.
    "14_measured_adhesion": ([r"0\.5 %: measured 0\.251, here 0\.24\d", r"2\.9 %: .* here 0\.30\d, error -0\.00\d",
                              r"19\.0 %: .* error \+0\.00\d"], []),
    "15_replay": ([r"12\.2 ms late", r"wheelset_1: torque .* 0\.90\d times that by pressure",
                   r"wheelset_1: force off by 3\d N at the instant, [3-7] N without the delay"], ["replay/report.html"]),
    "09_gymnasium": ([r"always filled: .* slip 100 %", r"vent above 20 %: .* slip 2\d %"], []),
}  # fmt: skip
"""Script -> patterns of its output in their order, and files that it leaves."""


FEWER = {"05_brake_on_low_adhesion": {"STARTS": 2, "FINER_STARTS": 2, "MOST_STARTS": 2}}
"""Script -> constants of rollerrig.study.adhesion here: its answers are those of the first start of each ensemble."""


def test_every_example_has_its_answer_and_its_line_in_the_readme() -> None:
    scripts = {path.stem for path in EXAMPLES.glob("*.py")}
    assert scripts == ANSWERS.keys()
    assert set(re.findall(r"`(\d\d_\w+)\.py` \|", (EXAMPLES / "README.md").read_text())) == scripts


def printed(script: Path, *, alone: bool) -> str:
    """What a script prints in the current folder."""
    if alone:
        command = [sys.executable, "-W", "error::FutureWarning", str(script)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
        assert done.returncode == 0, done.stderr
        return done.stdout
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()) as out:
        warnings.simplefilter("error", FutureWarning)
        runpy.run_path(str(script), run_name="__main__")
    return out.getvalue()


@pytest.mark.slow
@pytest.mark.parametrize("name", ANSWERS)
def test_an_example_gives_its_answer(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if name == "10_brake_controller" and not sys.platform.startswith("linux"):
        pytest.skip("the server is written for Linux")
    monkeypatch.chdir(tmp_path)
    for constant, value in FEWER.get(name, {}).items():
        monkeypatch.setattr(f"rollerrig.study.adhesion.{constant}", value)
    text = printed(EXAMPLES / f"{name}.py", alone=name == "01_first_run")
    patterns, files = ANSWERS[name]
    assert re.search(".*".join(patterns), text, re.DOTALL), text
    for file in files:
        assert (tmp_path / file).stat().st_size > 500
