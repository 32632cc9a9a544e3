"""`rollerrig stability`: files, keys, messages."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from called import called
from reported import unexplained, unreported
from rollerrig.analysis import bifurcation
from rollerrig.analysis.limit_cycle_runs import LimitCycleSettings
from rollerrig.config import ConfigError, load_case
from rollerrig.results import load_run
from rollerrig.study.stability import MOST_CYCLE_SPEEDS, StabilityStudy, branch_sentences, cycle_speeds, line_sentences


def run(*arguments: str):
    return called("stability", *arguments)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("stability")
    options = ["--speeds-kmh", "100:260:80", "--tolerance-kmh", "50", "--longest", "8", "--processes", "1"]
    # With ellipses limit cycles begin 90 km/h below the linear critical speed: speeds far apart find them.
    paper = {"contact.normal": "hertz", "contact.creep": "kalker_saturated"}
    case = tmp_path_factory.mktemp("case") / "bogie.toml"
    case.write_text(load_case("bogie_rollers_constant").with_changes(paper).to_toml())
    result = run(str(case), *options, "--out", str(out))
    assert result.exit_code == 0, result.output
    return out


@pytest.mark.slow
def test_everything_is_written(folder) -> None:
    names = {path.name for path in folder.iterdir()}
    assert {"report.html", "stability.nc", "modes.csv", "shapes.csv", "limit_cycles.csv", "summary.json"} <= names


@pytest.mark.slow
def test_numbers_are_registered_and_those_of_the_bogie(folder) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    assert unexplained(StabilityStudy.quantities, summary) == []
    missing = [
        key
        for key in unreported(StabilityStudy.quantities, summary)
        if not key.startswith(("contact_effects", "diverging.*", "branch.", "sensitivity"))
    ]
    assert missing == ["crossings"]  # there are some
    assert summary["linear_critical_speed_kmh"] == pytest.approx(253.09, abs=0.01)
    cycles = summary["limit_cycles"]
    assert len(cycles["points"]) >= 6
    assert cycles["bifurcation"] == "subcritical"
    assert cycles["decays_kmh"] < cycles["critical_speed_by_continuation_kmh"] < summary["linear_critical_speed_kmh"]
    rows = (folder / "limit_cycles.csv").read_text().splitlines()
    assert rows[0].split(",") == list(cycles["points"][0])
    assert len(rows) == 1 + len(cycles["points"])


@pytest.mark.slow
def test_figures_are_drawn_and_shown(folder) -> None:
    drawn = {path.name for path in (folder / "figures").iterdir()}
    names = ("frequency", "damping", "damping_map", "root_locus", "limit_cycles", "mode_shapes")
    assert drawn == {f"{name}.svg" for name in names}
    text = (folder / "report.html").read_text()
    assert text.count("<img") == len(drawn)
    found = json.loads((folder / "summary.json").read_text())["linear_critical_speed_kmh"]
    assert f"Linear critical speed: {found:.1f} km/h" in text


@pytest.mark.slow
def test_the_data_are_those_of_the_table(folder) -> None:
    data = load_run(folder / "stability.nc")
    assert list(data["speed"].to_numpy()) == [100.0, 180.0, 260.0]
    rows = (folder / "modes.csv").read_text().splitlines()
    assert len(rows) == 1 + data.sizes["speed"] * data.sizes["mode"]


def test_bad_speeds_are_refused(tmp_path) -> None:
    for speeds in ("300:60:20", "0:60:20", "fast"):
        result = run("bogie_rollers_constant", "--speeds-kmh", speeds, "--out", str(tmp_path))
        assert result.exit_code == 2
        assert "--speeds-kmh" in result.output


def interrupt_at(fraction: float):
    def progress(done: float, _text: str) -> None:
        if done >= fraction:
            raise KeyboardInterrupt

    return progress


def test_ctrl_c_keeps_the_speeds_that_were_done(tmp_path) -> None:
    study = StabilityStudy(load_case("wheelset_rollers"), (20.0, 25.0, 30.0, 35.0), with_limit_cycles=False)
    outcome = study.run(progress=interrupt_at(0.4))  # two of four speeds; the modes are 0.8 of the whole
    assert outcome is not None
    assert outcome.interrupted
    assert outcome.results.modes["speed"].to_numpy().tolist() == [20.0, 25.0]
    outcome.write(tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text())["interrupted"] is True


@pytest.mark.slow
def test_ctrl_c_keeps_the_runs_that_were_done(tmp_path) -> None:
    # 0.1 the modes, then a sixth of 0.9 and the halvings for each run
    study = StabilityStudy(load_case("wheelset_rollers"), (20, 40, 60))
    outcome = study.run(folder=tmp_path / "cut", progress=interrupt_at(0.34))
    assert outcome is not None
    assert outcome.interrupted
    assert outcome.results.diagram is not None
    assert (len(outcome.results.diagram.down), len(outcome.results.diagram.up)) == (2, 1)
    outcome.write(tmp_path / "cut")
    assert "Interrupted" in (tmp_path / "cut" / "report.html").read_text()
    goes_on = study.run(folder=tmp_path / "cut")
    whole = study.run(folder=tmp_path / "whole")
    assert goes_on is not None
    assert whole is not None
    assert goes_on.taken_over == 2 + 3  # the modes, the search above their range, three runs
    goes_on.write(tmp_path / "cut")
    whole.write(tmp_path / "whole")
    for name in ("stability.nc", "limit_cycles.csv", "summary.json", "report.html"):
        assert (tmp_path / "cut" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
    assert not (tmp_path / "cut" / "jobs.jsonl").exists()


def test_another_case_is_refused_with_what_changed(tmp_path) -> None:
    case = load_case("wheelset_rollers")
    StabilityStudy(case, (20, 40, 60)).run(folder=tmp_path, progress=interrupt_at(0.15))
    changed = StabilityStudy(case, (20, 40, 60), settings=LimitCycleSettings(longest=8.0))
    with pytest.raises(ConfigError, match=r"settings\.longest: 16\.0 there, 8\.0 now"):
        changed.run(folder=tmp_path)


@pytest.mark.long
def test_a_killed_command_goes_on_in_the_middle_of_its_runs(tmp_path) -> None:
    options = ["wheelset_rollers", "--speeds-kmh", "20:200:20", "--longest", "30"]
    command = [sys.executable, "-c", "from rollerrig.cli import main; main()", "stability", *options]
    process = subprocess.Popen(
        [*command, "--out", str(tmp_path / "killed")], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    journal, limit = tmp_path / "killed" / "jobs.jsonl", time.monotonic() + 60.0
    while not (journal.exists() and journal.read_bytes().count(b"ward sweep, run") > 2):
        assert process.poll() is None
        assert time.monotonic() < limit
        time.sleep(0.01)
    process.kill()
    process.wait()
    kept = journal.read_bytes().count(b"\n")
    for name, processes in (("killed", "2"), ("whole", "1")):
        assert run(*options, "--processes", processes, "--out", str(tmp_path / name)).exit_code == 0
    assert (
        json.loads((tmp_path / "killed" / "timing.json").read_text())["jobs taken over"] == kept - 1
    )  # less the first line
    for name in ("stability.nc", "modes.csv", "limit_cycles.csv", "summary.json", "report.html"):
        assert (tmp_path / "killed" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


def test_without_limit_cycles_no_run_is_made(tmp_path) -> None:
    result = run("wheelset_rollers", "--speeds-kmh", "40:80:20", "--no-limit-cycles", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert "limit_cycles" not in json.loads((tmp_path / "summary.json").read_text())
    assert not (tmp_path / "limit_cycles.csv").exists()


def test_the_report_of_a_lone_wheelset_is_in_the_singular_and_draws_no_hunting(tmp_path) -> None:
    result = run("wheelset_rollers", "--speeds-kmh", "40:80:20", "--no-limit-cycles", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    text = " ".join((tmp_path / "report.html").read_text().split())
    assert "wheelset red" in text
    assert "wheelsets" not in text.partition("Limitations")[0]
    assert "hunting" not in text.partition("Limitations")[0]
    assert not (tmp_path / "figures" / "mode_shapes.svg").exists()


@pytest.mark.slow
def test_a_line_with_curves_is_said_to_be_that_of_its_first_segment(tmp_path) -> None:
    case = tmp_path / "bogie_curve.toml"
    case.write_text(load_case("vehicle_curve").with_changes({"vehicle.cut": "leading_bogie"}).to_toml())
    result = run(str(case), "--speeds-kmh", "100", "--no-limit-cycles", "--out", str(tmp_path / "out"))
    assert result.exit_code == 0, result.output
    sentence = (
        "The line of this case has 5 segments. Everything here belongs to the first, a straight, continued without end"
    )
    for text in (result.output, (tmp_path / "out" / "report.html").read_text()):
        assert sentence in " ".join(text.split())
    assert line_sentences(load_case("bogie_track")) == line_sentences(load_case("bogie_rollers_constant")) == []


@pytest.mark.slow
def test_a_critical_speed_above_the_range_is_found_and_said_to_be_there(tmp_path) -> None:
    """On track the bogie hunts at 263 km/h; asked for are 220 to 240 km/h."""
    options = ["--speeds-kmh", "220:240:20", "--no-limit-cycles", "--out", str(tmp_path)]
    result = run("bogie_track", *options)
    assert result.exit_code == 0, result.output
    summary = json.loads((tmp_path / "summary.json").read_text())
    found = summary["linear_critical_speed_kmh"]
    assert found == pytest.approx(266.4, abs=0.1)
    assert summary["linear_searched_to_kmh"] == 600.0
    assert summary["crossings"] == []
    text = " ".join((tmp_path / "report.html").read_text().split())
    assert f"Linear critical speed: {found:.1f} km/h" in text
    assert "It is above the speeds asked for, from 220 to 240 km/h." in text
    assert "No oscillation begins or ends to grow from 220 to 240 km/h." in text  # in place of a table without rows


def test_where_there_is_none_it_says_how_far_it_looked(tmp_path) -> None:
    result = run("wheelset_rollers", "--speeds-kmh", "560:580:20", "--no-limit-cycles", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert "No linear critical speed from 560 to 580 km/h, nor above up to 600 km/h" in " ".join(result.output.split())


def test_runs_are_spread_over_the_range() -> None:
    chosen = cycle_speeds(tuple(range(60, 301)))
    assert len(chosen) == MOST_CYCLE_SPEEDS
    assert (chosen[0], chosen[-1]) == (60.0, 300.0)
    assert cycle_speeds((80.0,)) == [80.0]


def test_ctrl_c_ends_the_command_with_130(tmp_path) -> None:
    """To the whole process group, as a terminal sends it, also while the workers are still starting."""
    command = [sys.executable, "-c", "from rollerrig.cli import main; main()", "stability", "wheelset_rollers"]
    options = ["--speeds-kmh", "20:400:20", "--longest", "600", "--disturbance-mm", "6", "--out", str(tmp_path)]
    process = subprocess.Popen([*command, *options], stderr=subprocess.PIPE, text=True, start_new_session=True)
    time.sleep(2.5)
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert "Traceback" not in errors


@pytest.mark.slow
def test_the_branch_of_limit_cycles_is_followed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bifurcation, "LONGEST_STEP", 3e-3)
    options = ("--speeds-kmh", "220:260:20", "--no-limit-cycles", "--branch-mm", "2", "--out", str(tmp_path))
    result = run("cooperrider_bogie", *options)
    assert result.exit_code == 0, result.output
    assert (
        "Unstable limit cycles begin at the linear critical speed, 247.32 km/h (subcritical). The branch ends at"
        in result.output
    )
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert unexplained(StabilityStudy.quantities, summary) == []
    assert summary["branch"]["nonlinear_critical_speed_kmh"] is None  # the fold is at 9.4 mm
    points = summary["branch"]["points"]
    assert [point["stable"] for point in points] == [False] * len(points)
    assert len((tmp_path / "branch.csv").read_text().splitlines()) == len(points) + 1
    assert "Branch of limit cycles" in (tmp_path / "report.html").read_text()


def test_what_moves_the_critical_speed_is_drawn_and_said(tmp_path: Path) -> None:
    options = ("--speeds-kmh", "200:220:20", "--no-limit-cycles", "--sensitivity", "--out", str(tmp_path))
    result = run("suspended_wheelset", *options)
    assert result.exit_code == 0, result.output
    assert "moved most by vehicle.element.suspension_*.x.stiffness: +0.91 km/h if that is 1 % larger." in result.output
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert unexplained(StabilityStudy.quantities, summary) == []
    along, across = summary["sensitivity"]
    assert (along["value"], along["unit"]) == (3e5, "N/m")
    assert along["change_kmh"] > across["change_kmh"] > 0.0
    assert along["relative_change"] == pytest.approx(along["change_kmh"] / summary["linear_critical_speed_kmh"])
    assert (tmp_path / "figures" / "sensitivity.svg").exists()
    rows = (tmp_path / "sensitivity.csv").read_text().splitlines()
    assert rows[0] == "parameter,value,unit,change_kmh,relative_change"
    assert len(rows) == 3


def test_the_nonlinear_critical_speed_is_said() -> None:
    folds = [{"speed_kmh": 230.0, "amplitude_mm": 1.0}, {"speed_kmh": 220.371, "amplitude_mm": 4.457}]
    branch = {"points": [{"stable": True}], "folds": folds, "ended": "there"}
    course = (
        "Stable limit cycles begin at the linear critical speed, 224.10 km/h (supercritical). The branch ends there."
    )
    lowest = "Nonlinear critical speed, the lowest with a stable limit cycle on the branch: 220.37 km/h."
    assert branch_sentences({**branch, "nonlinear_critical_speed_kmh": 220.371}, 224.1) == [lowest, course]
    none = branch_sentences({**branch, "nonlinear_critical_speed_kmh": None}, 224.1)
    assert none[0].endswith("on the branch: not found, none is stable as far as it was followed.")
    assert branch_sentences({"points": [], "folds": [], "ended": "at 0.00 mm"}, 224.1) == [
        "The branch of limit cycles cannot be followed, it ends at 0.00 mm."
    ]
