"""A run read back from the files of other programs is the run, to the last bit."""

from __future__ import annotations

import csv
import struct
from importlib import import_module
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest
import scipy.io
import xarray as xr

import rollerrig as rr
from called import called
from rollerrig.results import ResultsError, export
from rollerrig.results.logs import read_log


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return rr.simulate(rr.load_case("adhesion_brake").with_changes({"time.duration": "0.05 s"}))


@pytest.fixture(scope="module")
def file(run: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return rr.save_run(run, tmp_path_factory.mktemp("run") / "run.nc")


def command(*arguments: object) -> tuple[int, str]:
    done = called("export", *arguments)
    return done.exit_code, done.stderr


@pytest.mark.parametrize("kind", [10, 14, 200, 2**31 - 1])
def test_a_file_of_matlab_that_would_end_the_process_is_refused(kind: int, tmp_path: Path) -> None:
    """SciPy looks a number's type up in a table, and trusts the file."""
    path = tmp_path / "log.mat"
    scipy.io.savemat(path, {"time": np.arange(3.0)})
    path.write_bytes(path.read_bytes().replace(struct.pack("<II", 9, 24), struct.pack("<II", kind, 24)))
    with pytest.raises(ResultsError, match=r"log.mat: (a damaged file, or none of|no table of numbers)"):
        read_log(path)


@pytest.mark.slow
def test_matlab(run: xr.Dataset, file: Path) -> None:
    assert command(file, "--to", "mat") == (0, "")
    found = scipy.io.loadmat(file.with_suffix(".mat"))
    for name, variable in run.data_vars.items():
        expected = variable.to_numpy()
        np.testing.assert_array_equal(found[str(name)].reshape(expected.shape), expected)
    assert found["wheel"][0, 0].item() == "wheelset_1_left"
    assert found["units"]["vertical_force"].item().item() == "N"
    assert found["dimensions"]["vertical_force"].item().item() == "time wheel"
    first = file.with_suffix(".mat").read_bytes()
    assert command(file, "--to", "mat")[0] == 0
    assert file.with_suffix(".mat").read_bytes() == first


def test_csv(run: xr.Dataset, file: Path, tmp_path: Path) -> None:
    assert command(file, "--to", "csv", "--out", tmp_path / "a.csv") == (0, "")
    with (tmp_path / "a.csv").open() as text:
        rows = list(csv.DictReader(text))
    force = [float(row["wheelset_1_left.vertical_force [N]"]) for row in rows]
    np.testing.assert_array_equal(force, run["vertical_force"].sel(wheel="wheelset_1_left"))
    assert {row["wheelset_1_left.3.patch_normal [N]"] for row in rows} == {""}  # there is no fourth patch


def test_parquet(run: xr.Dataset, tmp_path: Path) -> None:
    table = pyarrow.parquet.read_table(export(run, tmp_path / "a.parquet", over="reading_time"))
    assert table.schema.metadata[b"case"] == b"adhesion_brake"
    found = table["wheelset_2_right.reading_vertical_force [N]"].to_numpy()
    np.testing.assert_array_equal(found, run["reading_vertical_force"].sel(wheel="wheelset_2_right"))


def test_parquet_without_pyarrow_says_what_to_install(
    run: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(import_module("rollerrig.results.other_formats"), "find_spec", lambda _: None)
    with pytest.raises(ResultsError, match=r"pip install \"rollerrig\[parquet\]\""):
        export(run, tmp_path / "a.parquet")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--to", "xlsx"], "--to xlsx; allowed: mat, csv, parquet"),
        (["--to", "csv", "--over", "tme"], "--over tme: not in these results; allowed: time, reading_time"),
    ],
)
def test_bad_options_are_one_line(file: Path, tmp_path: Path, options: list[str], message: str) -> None:
    code, text = command(file, "--out", tmp_path / "x", *options)
    assert (code, text.count("\n")) == (2, 1)
    assert message in text
    assert not list(tmp_path.iterdir())


def test_what_is_no_run_is_refused_and_foreign_files_stay(file: Path, tmp_path: Path) -> None:
    foreign = tmp_path / "a.csv"
    foreign.write_text("mine")
    assert command(foreign, "--to", "mat")[0] == 2
    code, text = command(file, "--to", "csv", "--out", foreign)
    assert (code, "--force" in text) == (2, True)
    assert foreign.read_text() == "mine"
