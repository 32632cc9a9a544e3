"""`rollerrig view`: a page, or one line that says what is wrong, and nothing half-written."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest
import xarray as xr

import rollerrig as rr
from called import called


def run(*args: object) -> tuple[int, str]:
    done = called("view", *args)
    return done.exit_code, done.output


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory, on_rig: xr.Dataset) -> Path:
    return rr.save_run(on_rig, tmp_path_factory.mktemp("run") / "run.nc")


def test_a_page_is_written_and_written_again_the_same(file: Path, tmp_path: Path) -> None:
    page = tmp_path / "view.html"
    assert run(file, "--out", page) == (0, f"{page}\n")
    first = page.read_bytes()
    assert run(file, "--out", page)[0] == 0
    assert page.read_bytes() == first
    assert len(first) < 1_300_000


def test_bad_input_is_one_line_and_leaves_nothing(file: Path, on_rig: xr.Dataset, tmp_path: Path) -> None:
    cut, other, modes = tmp_path / "cut.nc", tmp_path / "other.nc", tmp_path / "modes.nc"
    cut.write_bytes(file.read_bytes()[:100_000])
    rr.save_run(on_rig.drop_vars("lateral"), modes)
    rr.save_run(on_rig, other)
    import h5py

    with h5py.File(other, "r+") as raw:
        raw.attrs["format"] = 1
    mine = tmp_path / "mine.html"
    mine.write_text("<!doctype html>mine")
    for source, out, said in (
        (cut, "new.html", "no NetCDF file of results such as run.nc, or a damaged one"),
        (other, "new.html", "results of another version"),
        (modes, "new.html", "no motion of bodies (lateral); view takes the run.nc of a run"),
        (tmp_path / "none.nc", "new.html", "no such file"),
        (file, "", "there is a folder of that name"),
        (file, "mine.html", "not written by this program"),
    ):
        code, text = run(source, "--out", tmp_path / out)
        assert (code, text.count("\n")) == (2, 1), text
        assert said in text
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cut.nc", "mine.html", "modes.nc", "other.nc"]
    assert mine.read_text() == "<!doctype html>mine"


def test_a_folder_is_answered_by_the_file_in_it(file: Path, tmp_path: Path) -> None:
    code, text = run(file.parent, "--out", tmp_path / "view.html")
    assert code == 2
    assert text == f"rollerrig: {file.parent}: a folder; give the run.nc in it: {file}\n"
    for name in ("compensated.nc", "plain.nc"):
        (tmp_path / name).touch()
    assert run(tmp_path)[1].endswith(
        f"give the compensated.nc in it: {tmp_path / 'compensated.nc'}; or another one there: plain.nc\n"
    )
    (tmp_path / "empty").mkdir()
    assert run(tmp_path / "empty")[1].endswith("a folder; there is no NetCDF file of results such as run.nc in it\n")
    assert not (tmp_path / "view.html").exists()


def test_play_says_in_a_line_what_is_in_its_way(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        done = called("play", "wheelset_rollers", "--port", port, "--no-browser")
    assert (done.exit_code, done.output.count("\n")) == (2, 1), done.output
    assert "choose another one, or 0 for any free one" in done.output
    done = called("play", "no_such_case")
    assert done.exit_code == 2
