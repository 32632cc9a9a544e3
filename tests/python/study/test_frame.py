"""The frame of all studies: jobs survive a killed program, another plan is refused, Ctrl-C keeps what is finished."""

from __future__ import annotations

import json
import math
import operator
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

from rollerrig.config import ConfigError
from rollerrig.plot.style import new_figure
from rollerrig.results import OutputError
from rollerrig.study.checkpoint import NAME, Checkpoint
from rollerrig.study.frame import Study
from rollerrig.study.jobs import Done, Round, job
from rollerrig.study.quantities import Quantities, Quantity
from rollerrig.study.report import Picture, Section

CALLS: list[float] = []


def square(value: float) -> float:
    CALLS.append(value)
    if value == 13.0:
        raise KeyboardInterrupt
    return value * value


def nap(seconds: float) -> float:
    time.sleep(seconds)
    return seconds


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


class Runs(Squares):
    """One job, whose result is a Dataset."""

    def rounds(self, done: Done) -> Iterator[Round]:
        yield {"run": job(xr.Dataset, {"x": 1.0})}

    def numbers(self, results: dict[str, Any]) -> dict[str, Any]:
        return {"sum": 1.0, "missing": math.nan}


@pytest.fixture(autouse=True)
def _forget_calls() -> None:
    CALLS.clear()


def test_later_rounds_see_earlier_results_and_the_journal_goes_with_the_report(tmp_path: Path) -> None:
    outcome = Squares().run(folder=tmp_path)
    assert outcome is not None
    assert (tmp_path / NAME).exists()
    written = outcome.write(tmp_path)
    assert {path.relative_to(tmp_path).as_posix() for path in written} == {
        "figures/empty.png",
        "summary.json",
        "timing.json",
        "report.html",
    }
    assert not (tmp_path / NAME).exists()
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["sum"] == 14.0
    assert summary["missing"] is None
    assert summary["keys"]["sum"] == "of the squares [m^2]"
    assert not Squares.quantities.unexplained(summary)


def test_the_progress_rises_to_one() -> None:
    shown: list[float] = []
    Squares().run(progress=lambda fraction, _text: shown.append(fraction))
    assert shown == sorted(shown)
    assert shown[-1] == 1.0
    assert 0.5 in shown


def test_jobs_run_on_other_processes() -> None:
    class Products(Squares):
        def rounds(self, done: Done) -> Iterator[Round]:
            yield {str(k): job(operator.mul, k, 7) for k in range(3)}

    outcome = Products().run(processes=2)
    assert outcome is not None
    assert outcome.results == {"0": 0, "1": 7, "2": 14}


def test_results_are_in_the_order_of_the_jobs_not_of_their_ends() -> None:
    class Naps(Squares):
        def rounds(self, done: Done) -> Iterator[Round]:
            yield {"long": job(nap, 0.5), "short": job(nap, 0.0)}

    outcome = Naps().run(processes=2)
    assert outcome is not None
    assert list(outcome.results) == ["long", "short"]


def course(seconds: float) -> xr.Dataset:
    time.sleep(seconds)
    return xr.Dataset({"slept": ("time", [seconds])})


def test_kept_jobs_are_the_same_bytes_whichever_ended_first(tmp_path: Path) -> None:
    """Two processes finish the short one first; order and file names are those of the study."""

    class Courses(Squares):
        keeps_jobs = True

        def rounds(self, done: Done) -> Iterator[Round]:
            yield {"Long run": job(course, 0.6), "short": job(course, 0.0), "long run": job(course, 0.3)}

        def numbers(self, results: dict[str, Any]) -> dict[str, Any]:
            return {"sum": 0.0}

    for processes in (1, 2):
        outcome = Courses().run(folder=tmp_path / str(processes), processes=processes)
        assert outcome is not None
        outcome.write(tmp_path / str(processes))
    one, two = ({path.relative_to(tmp_path / name).as_posix(): path.read_bytes() for path in (tmp_path / name).rglob("*.*")}
                for name in "12")  # fmt: skip
    assert sum(name.startswith("jobs/") for name in one) == 3
    assert one.keys() == two.keys()
    assert [name for name in one if one[name] != two[name] and name != "timing.json"] == []
    again = Courses().run(folder=tmp_path / "2")
    assert again is not None
    assert again.taken_over == 3
    assert float(again.results["long run"]["slept"][0]) == 0.3  # type: ignore[index]


def test_ctrl_c_keeps_finished_jobs_for_the_same_command(tmp_path: Path) -> None:
    first = Squares((1.0, 2.0, 13.0)).run(folder=tmp_path)
    assert first is not None
    assert first.interrupted
    assert first.statuses == ["interrupted"]
    assert "Interrupted" in first.summary
    first.write(tmp_path)
    with pytest.raises(ConfigError, match=r"values\[2\]: 13.0 there, 3.0 now"):
        Squares().run(folder=tmp_path)
    CALLS.clear()
    again = Squares((1.0, 2.0, 13.0), note="another note changes no job").run(folder=tmp_path)
    assert again is not None
    assert again.taken_over == 2
    assert CALLS == [13.0]


def test_a_killed_program_goes_on_where_it_was(tmp_path: Path) -> None:
    script = f"""
import os, signal, sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
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
    outcome = Squares().run(folder=tmp_path)
    assert outcome is not None
    assert outcome.taken_over == 2
    assert CALLS == [3.0]
    assert outcome.results["sum"] == 14.0
    whole = Squares().run(folder=tmp_path)  # nothing of the torn line is left to spoil those after it
    assert whole is not None
    assert whole.taken_over == 4


def test_files_of_the_user_that_are_called_like_ours_stay(tmp_path: Path) -> None:
    """`--out .` where there is a folder jobs, or a file jobs.jsonl."""
    (tmp_path / "jobs").mkdir()
    (tmp_path / "jobs" / "mine.nc").write_text("mine")
    outcome = Runs().run(folder=tmp_path)
    assert outcome is not None
    kept = [path.name for path in (tmp_path / "jobs").iterdir() if path.name != "mine.nc"]
    assert len(kept) == 1
    (tmp_path / "jobs" / f"{Path(kept[0]).stem}.part").write_bytes(b"torn")  # what a killed program leaves
    outcome.write(tmp_path)
    assert [path.name for path in (tmp_path / "jobs").iterdir()] == ["mine.nc"]
    for text in ("my own list of jobs", "[1, 2]\n", "\n"):
        (tmp_path / NAME).write_text(text)
        with pytest.raises(ConfigError, match="not a checkpoint file of this program"):
            Squares().run(folder=tmp_path)
        assert (tmp_path / NAME).read_text() == text


def test_another_study_refuses_a_folder_before_it_begins(tmp_path: Path) -> None:
    class Cubes(Squares):
        command = "cubes"
        resumable = False

    done = Squares().run(folder=tmp_path)
    assert done is not None
    CALLS.clear()
    with pytest.raises(OutputError, match=r"jobs.jsonl: finished jobs of `rollerrig squares`"):
        Cubes().run(folder=tmp_path, force=True)
    done.write(tmp_path)
    with pytest.raises(OutputError, match=r"holds results of `rollerrig squares`; choose another --out"):
        Cubes().run(folder=tmp_path)
    (tmp_path / "report.html").write_text("mine")
    with pytest.raises(OutputError, match=r"report.html: not written by this program, or changed since"):
        Squares().run(folder=tmp_path)
    assert CALLS == []


def test_a_damaged_line_costs_its_job_alone(tmp_path: Path) -> None:
    Squares().run(folder=tmp_path)
    lines = (tmp_path / NAME).read_bytes().splitlines(keepends=True)
    (tmp_path / NAME).write_bytes(b"".join([lines[0], b"\xff{\n", *lines[2:]]))
    CALLS.clear()
    outcome = Squares().run(folder=tmp_path)
    assert outcome is not None
    assert CALLS == [1.0]


def test_the_jobs_of_another_study_are_refused(tmp_path: Path) -> None:
    class Cubes(Squares):
        command = "cubes"

    Squares().run(folder=tmp_path)
    with pytest.raises(ConfigError, match="study: 'squares' there, 'cubes' now"):
        Cubes().run(folder=tmp_path)
    (tmp_path / NAME).write_text('{"something": "else"}\n')
    with pytest.raises(ConfigError, match="not a checkpoint file of this program"):
        Squares().run(folder=tmp_path)


@dataclass(frozen=True)
class Nested:
    """Defined here, not in the package: a journal does not bring it back."""

    value: float


def test_results_come_back_from_a_journal_as_they_were(tmp_path: Path) -> None:
    run = xr.Dataset(
        {"y": (("time", "body"), [[1.0, math.nan]], {"units": "m"}), "name": ("body", ["a", "b"])},
        {"time": [0.5], "body": ["one", "two"]},
        {"status": "ok", "count": 3},
    )
    quantity = Quantity("key", "meaning", shown=("%", 100.0))
    results = {
        "dataset": run,
        "other": run.isel(body=[1]),
        "dataclass": quantity,
        "array": np.array([[1, 2]], dtype=np.int16),
        "scalar": np.float64(0.1),
        "nested": {"tuple": (1, (2.5, "x")), "list": [None, True, -math.inf]},
        "foreign": Nested(1.0),
    }
    with Checkpoint(tmp_path, "test", {}) as checkpoint:
        for name, result in results.items():
            checkpoint.add(name, result)
    found = Checkpoint(tmp_path, "test", {}).done
    assert "foreign" not in found
    xr.testing.assert_identical(found["dataset"], run)
    xr.testing.assert_identical(found["other"], results["other"])
    assert found["dataclass"] == quantity
    assert found["array"].dtype == np.int16
    assert found["array"].tolist() == [[1, 2]]
    assert found["scalar"] == 0.1
    assert found["nested"] == results["nested"]


def test_a_dataset_that_is_missing_is_computed_again(tmp_path: Path) -> None:
    with Checkpoint(tmp_path, "test", {}) as checkpoint:
        checkpoint.add("run", xr.Dataset({"x": 1.0}))
    for path in (tmp_path / "jobs").iterdir():
        path.unlink()
    assert Checkpoint(tmp_path, "test", {}).done == {}


def test_an_outcome_prints_what_was_found() -> None:
    outcome = Squares().run()
    assert outcome is not None
    assert repr(outcome) == "\n".join(("Squares", *outcome.summary.splitlines()))
    assert "<li>" in outcome._repr_html_()
