"""Own runs over each other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rollerrig as rr
from called import called


@pytest.fixture(scope="module")
def runs():
    case = rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.3 s", "time.output_step": "5 ms"})
    finer = {"time.output_step": "3 ms", "time.duration": "0.21 s", "contact.friction": 0.1}
    return {"dry": rr.simulate(case), "wet": rr.simulate(case.with_changes(finer))}


def test_signals_are_compared_at_the_times_of_the_first_run(runs) -> None:
    found = rr.compare_runs(runs)
    assert [name for name in found.data_vars if "time" in found[name].dims] == [
        "lateral:wheelset_1", "vertical_force:wheelset_1_left", "lateral_force:wheelset_1_left"
    ]  # fmt: skip
    assert float(found["time"][-1]) == pytest.approx(0.21, abs=5e-3)
    lateral = found["lateral:wheelset_1"]
    dry = runs["dry"]["lateral"].sel(body="wheelset_1").to_numpy()[: found.sizes["time"]]
    assert np.array_equal(lateral.sel(run="dry"), dry)
    largest = found["lateral:wheelset_1 largest difference"]
    assert float(largest.sel(run="wet")) == float(abs(lateral.sel(run="wet") - dry).max()) > 0
    assert float(largest.sel(run="dry")) == 0.0
    assert lateral.attrs["units"] == "m"


@pytest.mark.parametrize(
    ("signal", "line"),
    [
        ("laterl:wheelset_1", "dry: no signal 'laterl'; did you mean 'lateral'?"),
        ("lateral", "dry: 'lateral'; write lateral:NAME with one of front_frame, wheelset_1"),
        ("lateral:wheelset_2", "dry: 'lateral:wheelset_2'; write lateral:NAME"),
        ("speed:wheelset_1", "dry: 'speed:wheelset_1'; write speed alone"),
        ("patch_normal:1", "has one value for each wheel and patch"),
    ],
)
def test_a_signal_that_is_not_there_is_said(runs, signal: str, line: str) -> None:
    with pytest.raises(ValueError, match="dry: ") as error:
        rr.compare_runs(runs, [signal])
    assert line in str(error.value)


def test_files_of_one_name_are_told_apart_by_their_folders() -> None:
    from rollerrig.cli.runs import _labels

    def of(*names: str) -> list[str]:
        return _labels([Path(name) for name in names])

    assert of("a/dry.nc", "b/wet.nc") == ["dry", "wet"]
    assert of("my-rig/run.nc", "my-track/run.nc") == ["my-rig", "my-track"]
    assert of("1/rig/run.nc", "2/rig/run.nc") == ["1/rig", "2/rig"]
    assert of("1/rig.nc", "2/rig.nc", "2/track.nc") == ["1/rig", "2/rig", "2/track"]
    assert of("a/run.nc", "a/run.nc") == ["a/run.nc (1)", "a/run.nc (2)"]


def test_runs_without_names_are_refused(runs) -> None:
    first, second = runs.values()
    for given in ((first, second), ([first, second],)):
        with pytest.raises(ValueError, match="takes runs by name: compare_runs"):
            rr.compare_runs(*given)


def test_the_command_draws_runs_and_prints_their_differences(runs, tmp_path: Path) -> None:
    files = [str(rr.save_run(run, tmp_path / f"{name}.nc")) for name, run in runs.items()]
    out = tmp_path / "both.svg"
    done = called("compare-runs", *files, "--signal", "lateral:wheelset_1", "--out", out)
    assert done.exit_code == 0
    assert out.read_text().startswith("<?xml")
    assert "lateral:wheelset_1" in done.output
    assert " mm" in done.output
    alone = called("compare-runs", files[0], "--out", tmp_path / "no.svg")
    assert (alone.exit_code, (tmp_path / "no.svg").exists()) == (2, False)
    missing = called("compare-runs", files[0], "none.nc", "--out", tmp_path / "no.svg")
    assert (missing.exit_code, "none.nc: no such file" in missing.output) == (2, True)


def test_results_of_something_else_are_one_line(runs, tmp_path: Path) -> None:
    rr.save_run(runs["dry"], tmp_path / "run.nc")
    rr.save_run(rr.stability("wheelset_rollers", speeds_kmh=[50.0, 60.0]), tmp_path / "stability.nc")
    for order in (["stability", "run"], ["run", "stability"]):
        files = [str(tmp_path / f"{name}.nc") for name in order]
        answer = called("compare-runs", *files, "--out", tmp_path / "runs.svg")
        assert answer.exit_code == 2
        assert "stability: no run over time; needed: results of a run, such as its run.nc" in answer.stderr
        assert "Traceback" not in answer.output
