"""The frame of all studies: jobs survive a killed program, another plan is refused, Ctrl-C keeps what is finished."""

from __future__ import annotations

import json
import math
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from reported import unexplained
from rollerrig.config import ConfigError
from rollerrig.plot.style import new_figure
from rollerrig.results import OutputError
from rollerrig.study.checkpoint import NAME, Checkpoint
from rollerrig.study.frame import Outcome, Study
from rollerrig.study.jobs import Done, Round, job
from rollerrig.study.quantities import Quantities, Quantity
from rollerrig.study.report import Picture, Section

CALLS: list[float] = []


def square(value: float) -> float:
    CALLS.append(value)
    if value == 13.0:
        raise KeyboardInterrupt
    return value * value


@dataclass(frozen=True)
class Squares(Study[dict[str, float]]):
    """Squares of numbers, then their sum as a second round."""

    values: tuple[float, ...] = (1.0, 2.0, 3.0)
    note: str = ""

    command = "squares"
    quantities = Quantities(Quantity("sum", "of the squares", "m^2"), Quantity("missing", "no number"))
    irrelevant = ("note",)
    round_ends = (0.5, 1.0)

    @property
    def title(self) -> str:
        return "Squares"

    def rounds(self, done: Done) -> Iterator[Round]:
        yield {f"{v:g}": job(square, v) for v in self.values}
        yield {"sum": job(sum, [done[f"{v:g}"] for v in self.values])}

    def collect(self, done: Done) -> dict[str, float] | None:
        return done or None

    def numbers(self, results: dict[str, float]) -> dict[str, Any]:
        return {"sum": results.get("sum"), "missing": math.nan}

    def summary(self, results: dict[str, float], numbers: Mapping[str, Any]) -> list[str]:
        return [f"The sum is {numbers['sum']}."]

    def sections(self, results: dict[str, float], numbers: Mapping[str, Any]) -> list[Section]:
        return [Section("Squares", [Picture("empty", new_figure()[0], "nothing")])]


class Cubes(Squares):
    command = "cubes"


class Runs(Squares):
    """One job, whose result is a Dataset."""

    def rounds(self, done: Done) -> Iterator[Round]:
        yield {"run": job(xr.Dataset, {"x": 1.0})}

    def numbers(self, results: dict[str, Any]) -> dict[str, Any]:
        return {"sum": 1.0, "missing": math.nan}


def run(study: Study[Any], folder: Path | None = None, **options: Any) -> Outcome[Any]:
    CALLS.clear()
    outcome = study.run(folder=folder, **options)
    assert outcome is not None
    return outcome


def test_later_rounds_see_earlier_results_and_the_checkpoint_goes_with_the_report(tmp_path: Path) -> None:
    outcome = run(Squares(), tmp_path)
    assert (tmp_path / NAME).exists()
    written = {path.relative_to(tmp_path).as_posix() for path in outcome.write(tmp_path)}
    assert written == {"figures/empty.png", "summary.json", "timing.json", "report.html"}
    assert not (tmp_path / NAME).exists()
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert (summary["sum"], summary["missing"]) == (14.0, None)
    assert summary["keys"]["sum"] == "of the squares [m^2]"
    assert not unexplained(Squares.quantities, summary)
    assert repr(outcome) == "\n".join(("Squares", *outcome.summary.splitlines()))
    assert "<li>" in outcome._repr_html_()


def test_first_results_are_a_page_that_is_loaded_again_and_change_nothing_of_the_last_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Written after a job that is not the last, at most every so often; its summary says that something is missing."""
    monkeypatch.setattr("rollerrig.study.frame.PAGE_EVERY", 0.0)
    first: list[tuple[str, dict[str, Any], bool]] = []

    def write(found: Outcome[Any]) -> None:
        found.write(tmp_path)
        page, summary = ((tmp_path / name).read_text() for name in ("report.html", "summary.json"))
        first.append((page, json.loads(summary), (tmp_path / NAME).exists()))

    run(Squares(), tmp_path, first_results=write).write(tmp_path)
    page, summary, goes_on = first[0]
    assert goes_on, "a command that is killed now repeats everything"
    assert '<meta http-equiv="refresh"' in page
    assert "First results: the command goes on" in page
    assert (summary["sum"], summary["interrupted"]) == (None, True)
    whole = (tmp_path / "report.html").read_bytes()
    assert b"refresh" not in whole
    run(Squares(), tmp_path / "alone").write(tmp_path / "alone")
    assert (tmp_path / "alone" / "report.html").read_bytes() == whole
    monkeypatch.setattr("rollerrig.study.frame.PAGE_EVERY", 60.0)
    run(Squares(), first_results=lambda _: pytest.fail("too soon"))


def test_a_first_page_that_cannot_be_made_ends_no_study(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rollerrig.study.frame.PAGE_EVERY", 0.0)
    tried: list[Outcome[Any]] = []

    def broken(found: Outcome[Any]) -> None:
        tried.append(found)
        raise ValueError

    assert run(Squares(), first_results=broken).numbers["sum"] == 14.0
    assert tried


def test_the_progress_rises_to_one() -> None:
    shown: list[float] = []
    run(Squares(), progress=lambda fraction, _text: shown.append(fraction))
    assert shown == sorted(shown)
    assert {0.5, 1.0} <= set(shown)


def course(seconds: float) -> xr.Dataset:
    time.sleep(seconds)
    return xr.Dataset({"slept": ("time", [seconds])})


@pytest.mark.slow
def test_kept_jobs_are_the_same_bytes_whichever_ended_first(tmp_path: Path) -> None:
    """Two processes finish the short one first; order and file names are those of the study."""

    class Courses(Squares):
        keeps_jobs = True

        def rounds(self, done: Done) -> Iterator[Round]:
            yield {"Long run": job(course, 0.6), "short": job(course, 0.0), "long run": job(course, 0.3)}

    for processes in (1, 2):
        outcome = run(Courses(), tmp_path / str(processes), processes=processes)
        assert list(outcome.results) == ["Long run", "short", "long run"]
        outcome.write(tmp_path / str(processes))
    one, two = ({path.relative_to(tmp_path / name).as_posix(): path.read_bytes() for path in (tmp_path / name).rglob("*.*")}
                for name in "12")  # fmt: skip
    assert sum(name.startswith("jobs/") for name in one) == 3
    assert one.keys() == two.keys()
    assert [name for name in one if one[name] != two[name] and name != "timing.json"] == []
    again = run(Courses(), tmp_path / "2")
    assert again.taken_over == 3
    assert float(again.results["long run"]["slept"][0]) == 0.3


def test_ctrl_c_keeps_finished_jobs_for_the_same_command(tmp_path: Path) -> None:
    first = run(Squares((1.0, 2.0, 13.0)), tmp_path)
    assert first.interrupted
    assert first.statuses == ["interrupted"]
    assert "Interrupted" in first.summary
    first.write(tmp_path)
    with pytest.raises(ConfigError, match=r"values\[2\]: 13.0 there, 3.0 now"):
        run(Squares(), tmp_path)
    again = run(Squares((1.0, 2.0, 13.0), note="another note changes no job"), tmp_path)
    assert again.taken_over == 2
    assert CALLS == [13.0]


@pytest.mark.slow
def test_a_killed_program_goes_on_where_it_was(tmp_path: Path) -> None:
    script = f"""
import os, signal, sys
sys.path[:0] = {[str(Path(__file__).parent), str(Path(__file__).parents[2])]!r}
import test_frame as t
def kill(value):
    if value == 3.0:
        os.kill(os.getpid(), signal.SIGKILL)
    return value * value
t.square = kill
t.Squares().run(folder={str(tmp_path)!r})
"""
    killed = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    with (tmp_path / NAME).open("ab") as file:
        file.write(b'{"job": "3", "resu')  # what a killed program leaves of a line
    outcome = run(Squares(), tmp_path)
    assert outcome.taken_over == 2
    assert CALLS == [3.0]
    assert outcome.results["sum"] == 14.0
    assert run(Squares(), tmp_path).taken_over == 4, "nothing of the torn line is left to spoil those after it"
    lines = (tmp_path / NAME).read_bytes().splitlines(keepends=True)
    (tmp_path / NAME).write_bytes(b"".join([lines[0], b"\xff{\n", *lines[2:]]))
    run(Squares(), tmp_path)
    assert CALLS == [1.0], "a damaged line costs its job alone"


def test_files_of_the_user_that_are_called_like_ours_stay(tmp_path: Path) -> None:
    """`--out .` where there is a folder jobs, or a file jobs.jsonl."""
    (tmp_path / "jobs").mkdir()
    (tmp_path / "jobs" / "mine.nc").write_text("mine")
    outcome = run(Runs(), tmp_path)
    kept = [path.name for path in (tmp_path / "jobs").iterdir() if path.name != "mine.nc"]
    assert len(kept) == 1
    (tmp_path / "jobs" / f"{Path(kept[0]).stem}.part").write_bytes(b"torn")  # what a killed program leaves
    outcome.write(tmp_path)
    assert [path.name for path in (tmp_path / "jobs").iterdir()] == ["mine.nc"]
    for text in ("my own list of jobs", "[1, 2]\n", "\n", '{"something": "else"}\n'):
        (tmp_path / NAME).write_text(text)
        with pytest.raises(ConfigError, match="not a checkpoint file of this program"):
            run(Squares(), tmp_path)
        assert (tmp_path / NAME).read_text() == text


def test_another_study_refuses_a_folder_before_it_begins(tmp_path: Path) -> None:
    class Once(Cubes):
        resumable = False

    done = run(Squares(), tmp_path)
    with pytest.raises(ConfigError, match="study: 'squares' there, 'cubes' now"):
        run(Cubes(), tmp_path)
    with pytest.raises(OutputError, match=r"jobs.jsonl: finished jobs of `rollerrig squares`"):
        run(Once(), tmp_path, force=True)
    done.write(tmp_path)
    with pytest.raises(OutputError, match=r"holds results of `rollerrig squares`; choose another --out"):
        run(Once(), tmp_path)
    (tmp_path / "report.html").write_text("mine")
    with pytest.raises(OutputError, match=r"report.html: not written by this program, or changed since"):
        run(Squares(), tmp_path)
    assert CALLS == []


@dataclass(frozen=True)
class Nested:
    """Defined here, not in the package: a checkpoint does not bring it back."""

    value: float


def test_results_come_back_as_they_were(tmp_path: Path) -> None:
    data = xr.Dataset(
        {"y": (("time", "body"), [[1.0, math.nan]], {"units": "m"}), "name": ("body", ["a", "b"])},
        {"time": [0.5], "body": ["one", "two"]},
        {"status": "ok", "count": 3},
    )
    results = {
        "two": [data, data.isel(body=[1])],
        "dataclass": Quantity("key", "meaning", shown=("%", 100.0)),
        "array": np.array([[1, 2]], dtype=np.int16),
        "scalar": np.float64(0.1),
        "nested": {"tuple": (1, (2.5, "x")), "list": [None, True, -math.inf]},
        "foreign": Nested(1.0),
    }
    with Checkpoint(tmp_path, "test", {}) as checkpoint:
        for name, result in results.items():
            checkpoint.add(name, result)
    found = Checkpoint(tmp_path, "test", {}).done
    assert found.keys() == results.keys() - {"foreign"}
    for one, other in zip(found.pop("two"), results["two"], strict=True):
        xr.testing.assert_identical(one, other)
    array = found.pop("array")
    assert (array.dtype, array.tolist()) == (np.int16, [[1, 2]])
    assert found == {name: results[name] for name in found}
    for path in (tmp_path / "jobs").iterdir():
        path.unlink()
    assert "two" not in Checkpoint(tmp_path, "test", {}).done, "a Dataset that is missing is computed again"
