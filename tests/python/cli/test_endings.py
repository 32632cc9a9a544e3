"""However a command ends, nothing is half-written and the next one goes on: kill -9, full disks, closed pipes, other locales."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic_core import SchemaError

import rollerrig as rr
from called import call, called
from rollerrig.cli import main, termination
from rollerrig.results import read_manifest
from rollerrig.results.folder import checksum
from rollerrig.study.checkpoint import NAME as NAME_OF_JOBS
from rollerrig.study.frame import Outcome
from rollerrig.study.run import RunStudy

ENTRY = [sys.executable, "-c", "from rollerrig.cli import main; main()"]
STUDIES = {
    "envelope": "envelope adhesion_brake --torques-knm=-4,-6,-8 --adhesions 0.05,0.2 --loads 1 --duration 0.6 --refine 0",
    "wsp": "wsp adhesion_brake --quick --programme",
    "tune": "tune adhesion_brake --free rig_control.feedback.bandwidth=[0.3,3] --duration 1 --draws 2 --candidates 2",
}
"""Studies at their smallest; the programme of `wsp` is PROGRAMME."""
PROGRAMME = """
name = "drag"
starts = 4
stop = [{ name = "drag_30", kind = "drag", speed = "30 km/h", rail = "low", gradient = -0.04, duration = "2 s" }]
"""
CASE = """
name = "short"
vehicle = { use = "manchester_vehicle_1", cut = "leading_wheelset" }
support = { use = "full_scale_rig" }
contact = { material = "steel" }
motion = { speed = "40 km/h" }
disturbance = [{ body = "wheelset_1", lateral = "3 mm" }]
time = { duration = "0.05 s" }
"""


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "short.toml"
    path.write_text(CASE)
    return path


@pytest.fixture(scope="module")
def whole_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a run that nothing disturbs, made in this process."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "short.toml").write_text(CASE)
    assert call("run", folder / "short.toml", "--out", folder / "out")[0] == 0
    return folder / "out"


def contents(folder: Path) -> dict[str, bytes]:
    """All files but the one whose bytes differ between identical runs."""
    found = (path for path in folder.rglob("*") if path.is_file() and path.name != "timing.json")
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in found}


@pytest.mark.slow
@pytest.mark.parametrize("study", ["envelope", *(pytest.param(one, marks=pytest.mark.long) for one in ("wsp", "tune"))])
def test_a_study_ended_at_any_moment_goes_on_to_the_same_results(study: str, tmp_path: Path) -> None:
    """By Ctrl-C, then killed one job further and in the middle of another; the third time it ends by itself."""
    (tmp_path / "drag.toml").write_text(PROGRAMME)
    command = [*STUDIES[study].split(), *([str(tmp_path / "drag.toml")] if study == "wsp" else []), "--processes", "1"]
    assert call(*command, "--out", tmp_path / "whole")[0] == 0
    out = tmp_path / "out"

    def kept() -> int:
        return (out / NAME_OF_JOBS).read_bytes().count(b"\n") if (out / NAME_OF_JOBS).exists() else 0

    for ending, later in ((signal.SIGINT, 0.0), (signal.SIGKILL, 0.2)):
        before = kept()
        process = subprocess.Popen(
            [*ENTRY, *command, "--out", str(out)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
        while kept() <= max(before, 1):
            assert process.poll() is None
            time.sleep(0.005)
        time.sleep(later)
        os.killpg(process.pid, ending)
        errors = process.communicate()[1].decode()
        if ending == signal.SIGINT:
            assert "the same command continues" in errors
            assert "Traceback" not in errors
        assert process.returncode == (termination.INTERRUPTED if ending == signal.SIGINT else -signal.SIGKILL)
        for path in out.rglob("*.nc"):  # what is there under its name is whole
            rr.load_run(path)
    before = kept()
    assert call(*command, "--out", out)[0] == 0
    assert json.loads((out / "timing.json").read_text())["jobs taken over"] == before - 1  # less the first line
    assert contents(out) == contents(tmp_path / "whole")


@pytest.mark.slow
@pytest.mark.parametrize("moment", ["RunStudy.collect", "Outcome.write"])
def test_ctrl_c_after_the_last_step_keeps_the_whole_run(
    moment: str, case: Path, whole_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    owner, _, name = moment.partition(".")
    kind = {"RunStudy": RunStudy, "Outcome": Outcome}[owner]
    whole = getattr(kind, name)

    def pressed(*arguments: Any, **options: Any) -> Any:
        os.kill(os.getpid(), signal.SIGINT)
        return whole(*arguments, **options)

    monkeypatch.setattr(kind, name, pressed)
    assert call("run", case, "--out", tmp_path / "out")[0] == termination.INTERRUPTED
    assert contents(tmp_path / "out") == contents(whole_run)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.parametrize("module", ["typer", "rollerrig.cli.app", "rollerrig.cli.runs"])
def test_ctrl_c_while_modules_are_loaded_is_no_traceback(module: str) -> None:
    press = (
        "import os, signal, sys\n"
        "class Finder:\n"
        "    def find_spec(self, name, *rest):\n"
        f"        if name == {module!r}: os.kill(os.getpid(), signal.SIGINT)\n"
        "sys.meta_path.insert(0, Finder())\n"
    )
    command = [sys.executable, "-c", f"{press}{ENTRY[-1]}", "catalog"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (termination.INTERRUPTED, "", "")


@pytest.mark.slow
def test_a_run_that_becomes_infinite_keeps_what_was_finite(tmp_path: Path) -> None:
    changes = ("time.step=0.5 s", "motion.speed=400 km/h", "time.duration=2 s")
    options = [word for change in changes for word in ("--set", change)]
    code, text = call("run", "bogie_rollers_constant", *options, "--out", tmp_path / "out")
    assert code == termination.LEFT_VALIDITY
    assert "nan" not in text
    run = rr.load_run(tmp_path / "out" / "run.nc")
    assert run.attrs["status"] == "not_finite"
    assert run.sizes["time"] > 1
    assert not [name for name, values in run.items() if values.dtype.kind == "f" and np.isinf(values).any()]


def test_a_table_on_a_full_disk() -> None:
    code, text = call("contact", "contact_benchmark_track", "--lateral-mm=0", "--csv", "/dev/full")
    assert code == 2
    assert text.startswith("rollerrig: /dev/full: cannot be written: the disk is full; free some space or")


@pytest.mark.skipif(not Path("/sys/kernel").is_dir(), reason="needs a place that takes no files from anybody")
def test_a_folder_that_takes_no_files(case: Path) -> None:
    code, text = call("run", case, "--out", "/sys/kernel/out")
    assert code == 2
    assert re.fullmatch(r"rollerrig: /sys/kernel/out: cannot be written: [^\n]*; choose another folder\n", text)


@pytest.mark.slow
@pytest.mark.parametrize("progress", [False, True], ids=["results", "progress too"])
def test_a_closed_pipe_costs_no_results(progress: bool, case: Path, tmp_path: Path) -> None:
    """`rollerrig run ... | true`, and `2>&1 | head -1` where the run goes on for hours: what was computed is not lost."""
    out = tmp_path / "out"
    read, write = os.pipe()
    os.close(read)
    often = "import rollerrig.cli.progress as p; p.REPORT_SECONDS = 0.0; "
    command = [sys.executable, "-c", often + ENTRY[-1], "run", str(case), "--out", str(out)]
    done = subprocess.run(command, stdout=write, stderr=write if progress else subprocess.PIPE, check=False)
    os.close(write)
    assert done.returncode == termination.CLOSED
    assert b"Traceback" not in (done.stderr or b"")
    manifest = read_manifest(out)
    assert manifest is not None
    assert all(checksum(out / name) == sum_ for name, sum_ in manifest.files.items() if sum_ is not None)


def test_a_closed_pipe_ends_a_list_quietly() -> None:
    done = subprocess.run(
        ["bash", "-c", '"$@" | true; exit ${PIPESTATUS[0]}', "bash", *ENTRY, "catalog", "show", "manchester_vehicle_1"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode in (termination.OK, termination.CLOSED)
    assert done.stderr == ""


@pytest.mark.slow
@pytest.mark.parametrize(
    "environment",
    [
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": "ascii"},
        {"LC_ALL": "POSIX", "TZ": "Asia/Kathmandu", "PYTHONHASHSEED": "7"},
    ],
    ids=["ascii", "posix"],
)
def test_the_same_run_in_another_process_and_locale_is_the_same_bytes(
    case: Path, whole_run: Path, tmp_path: Path, environment: dict[str, str]
) -> None:
    command = [*ENTRY, "run", str(case), "--out", str(tmp_path / "there")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, **environment})
    assert done.returncode == 0, done.stderr
    assert contents(whole_run) == contents(tmp_path / "there")


def test_what_is_found_late_names_the_file_of_the_user(tmp_path: Path) -> None:
    own, further = tmp_path / "own.toml", tmp_path / "further.toml"
    own.write_text('base = "vehicle_track_irregular"\nvehicle.body.car_body.mass = "99900 t"\n')
    further.write_text('base = "own.toml"\n')
    for path in (own, further):
        done = called("check", path)
        assert done.exit_code == 2
        assert done.stderr.startswith(f"rollerrig: {path}: vehicle.element.primary_1_left: ")


def test_exit_codes_are_those_of_the_documentation() -> None:
    page = Path(__file__).resolve().parents[3] / "docs" / "reference" / "command_line.md"
    documented = {int(code) for code in re.findall(r"^\| (\d+) \|", page.read_text(), re.MULTILINE)}
    own = {value for name, value in vars(termination).items() if name.isupper() and isinstance(value, int)}
    assert documented == own
    shown = call("--help")[1]
    assert all(re.search(rf"\b{code}\b", shown) for code in own)


@pytest.mark.parametrize(
    ("message", "ends"), [('Error building "literal" validator:\n  KeyboardInterrupt: ', SystemExit), ("", SchemaError)]
)
def test_an_interrupt_while_models_are_built_ends_as_any_other(message: str, ends: type, monkeypatch) -> None:
    def interrupted() -> None:
        raise SchemaError(message)

    monkeypatch.setattr("rollerrig.cli.app.build_app", interrupted)
    with pytest.raises(ends) as error:
        main()
    assert getattr(error.value, "code", 130) == 130
