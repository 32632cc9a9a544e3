"""What this program did not write is not replaced; what belongs together says so; a killed program leaves whole files."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
import signal
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import h5py
import pytest
import xarray as xr

import rollerrig as rr
from called import call
from rollerrig.cli.app import build_app
from rollerrig.plot import figure_bytes
from rollerrig.plot.style import new_figure
from rollerrig.results import OutputError, ResultFolder, files, read_manifest, save_run, write_bytes, write_text
from rollerrig.results.folder import NAME, check_folder, locked

NO_CASES: Mapping[str, rr.Case] = {}


def write(path: Path, command: str = "run", *, force: bool = False, **contents: str) -> None:
    """Files of a command; `_` in a name stands for the point."""
    with ResultFolder(path, command, NO_CASES, force=force) as results:
        for name, content in contents.items():
            results.add(name.replace("_", "."), content.encode())
        results.commit()


def names(path: Path) -> set[str]:
    return {found.relative_to(path).as_posix() for found in path.rglob("*") if not found.is_dir()}


# ------------------------------------------------------------------------------------------------------ single files


def test_a_file_of_another_program_is_not_replaced(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("mine")
    with pytest.raises(OutputError, match=r"notes.txt: not written by this program; .*--force \(force=True\)"):
        write_text(path, "theirs")
    assert path.read_text() == "mine"
    write_text(path, "theirs", force=True)
    assert path.read_text() == "theirs"


def test_results_are_replaced_and_other_datasets_are_not(tmp_path: Path) -> None:
    one, two = xr.Dataset({"x": 1.0}), xr.Dataset({"x": 2.0})
    path = save_run(one, tmp_path / "run.nc")
    save_run(two, path)
    xr.testing.assert_identical(rr.load_run(path), two)
    with h5py.File(tmp_path / "other.nc", "w") as file:
        file["x"] = [1.0]
    (tmp_path / "text.nc").write_text("mine")
    for name in ("other.nc", "text.nc"):
        before = (tmp_path / name).read_bytes()
        with pytest.raises(OutputError, match="not written by this program"):
            save_run(one, tmp_path / name)
        assert (tmp_path / name).read_bytes() == before
        save_run(one, tmp_path / name, force=True)
        xr.testing.assert_identical(rr.load_run(tmp_path / name), one)


@pytest.mark.parametrize("kind", ["png", "svg"])
def test_figures_know_each_other(tmp_path: Path, kind: str) -> None:
    import matplotlib.pyplot as plt

    path = tmp_path / f"figure.{kind}"
    for _ in range(2):
        write_bytes(path, figure_bytes(new_figure()[0], kind))  # type: ignore[arg-type]
    plt.figure()
    plt.savefig(path)
    plt.close()
    with pytest.raises(OutputError, match="not written by this program"):
        write_bytes(path, figure_bytes(new_figure()[0], kind))  # type: ignore[arg-type]


def test_a_link_is_not_written_through(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    (tmp_path / "run.nc").symlink_to("mine.txt")
    with pytest.raises(OutputError, match="not written by this program"):
        save_run(xr.Dataset({"x": 1.0}), tmp_path / "run.nc")
    assert (tmp_path / "mine.txt").read_text() == "mine"


CONTACT = ("contact", "contact_benchmark_track", "--lateral-mm=0")


def test_the_table_of_a_command_does_not_replace_the_case(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text(rr.catalog_text("contact_benchmark_track"))
    before = case.read_bytes()
    for option, other in (("--csv", "--plot"), ("--plot", "--csv")):
        if option == "--plot":  # only pictures are asked for there
            case = case.rename(tmp_path / "case.png")
        code, text = call(
            "contact", "contact_benchmark_track", "--lateral-mm=0", option, case, other, tmp_path / "new.svg"
        )
        assert code == 2
        assert f"{case}: not written by this program" in text
        assert case.read_bytes() == before
        assert names(tmp_path) == {case.name}


def test_a_table_replaces_a_table(tmp_path: Path) -> None:
    table = tmp_path / "contact.csv"
    assert call(*CONTACT, "--csv", table)[0] == 0
    first = table.read_bytes()
    assert call("contact", "contact_benchmark_track", "--lateral-mm=1", "--csv", table)[0] == 0
    assert table.read_bytes() != first
    table.write_text("my,own,table\n1,2,3\n")
    code, text = call(*CONTACT, "--csv", table)
    assert code == 2
    assert "--force" in text
    assert call(*CONTACT, "--csv", table, "--force")[0] == 0
    assert table.read_bytes() == first


def test_the_second_file_of_a_comparison_is_looked_for_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "contact_creep.csv").write_text("mine")
    code, text = call(*CONTACT, "--compare", "--csv", tmp_path / "contact.csv")
    assert code == 2
    assert "contact_creep.csv: not written by this program" in text
    assert names(tmp_path) == {"contact_creep.csv"}


# --------------------------------------------------------------------------------------------------------- manifests


def test_the_manifest_says_what_belongs_together(tmp_path: Path) -> None:
    case = rr.load_case("wheelset_rollers")
    with ResultFolder(tmp_path, "run", {"mine": case}, interrupted=True) as results:
        assert results.add("data/a.csv", b"a") == tmp_path / "data" / "a.csv"
        results.add("times.json", b"1", varies=True)
        assert names(tmp_path).isdisjoint({"data/a.csv", "times.json"})
        results.commit()
    assert names(tmp_path) == {NAME, "data/a.csv", "times.json"}
    assert json.loads((tmp_path / NAME).read_text()) == {
        "program": "rollerrig",
        "version": rr.__version__,
        "command": "run",
        "cases": {"mine": hashlib.sha256(case.to_toml().encode()).hexdigest()},
        "interrupted": True,
        "files": {"data/a.csv": hashlib.sha256(b"a").hexdigest(), "times.json": None},
    }


def test_the_same_command_replaces_its_files_and_removes_those_it_does_not_write_again(tmp_path: Path) -> None:
    write(tmp_path, a_csv="1", b_csv="1")
    (tmp_path / "mine.csv").write_text("mine")
    write(tmp_path, a_csv="2", c_csv="2")
    assert names(tmp_path) == {NAME, "a.csv", "c.csv", "mine.csv"}
    assert (tmp_path / "a.csv").read_text() == "2"
    manifest = read_manifest(tmp_path)
    assert manifest is not None
    assert (set(manifest.files), manifest.replaced) == ({"a.csv", "c.csv"}, {})


def test_what_the_user_changed_is_the_users(tmp_path: Path) -> None:
    write(tmp_path, a_csv="1", b_csv="1")
    (tmp_path / "a.csv").write_text("edited")
    (tmp_path / "b.csv").write_text("edited")
    with pytest.raises(OutputError, match=r"a.csv, b.csv: not written by this program, or changed since"):
        check_folder(tmp_path, "run", ["*.csv"])
    with pytest.raises(OutputError, match=r"a.csv: not written by this program, or changed since"):
        write(tmp_path, a_csv="2")
    assert (tmp_path / "a.csv").read_text() == "edited"
    write(tmp_path, force=True, a_csv="2")
    assert (tmp_path / "a.csv").read_text() == "2"
    assert (tmp_path / "b.csv").read_text() == "edited", "not written again, and not ours to remove"


def test_results_of_another_command_are_refused(tmp_path: Path) -> None:
    write(tmp_path, "stability", a_csv="1", b_csv="1")
    for attempt in (lambda: check_folder(tmp_path, "run", []), lambda: write(tmp_path, "run", a_csv="2")):
        with pytest.raises(OutputError, match="holds results of `rollerrig stability`; choose another --out"):
            attempt()
    assert names(tmp_path) == {NAME, "a.csv", "b.csv"}
    write(tmp_path, "run", force=True, a_csv="2")
    assert names(tmp_path) == {NAME, "a.csv"}, "old and new are not mixed"


def test_a_file_without_a_manifest_is_the_users(tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text("mine")
    (tmp_path / "case.toml").write_text("mine")
    with pytest.raises(OutputError, match=r"report.html: not written by this program"):
        check_folder(tmp_path, "run", ["report.html", "*.csv"])
    (tmp_path / "report.html").unlink()
    assert check_folder(tmp_path, "run", ["report.html", "*.csv"]) == tmp_path


@pytest.mark.parametrize(
    "content",
    ["", "[]", "{}", '{"program": "other"}', "\xff", "[" * 100_000]
    + [
        json.dumps({"program": "rollerrig", "command": "run", "cases": {}, "interrupted": False, "files": {name: None}})
        for name in ("../mine.txt", "/etc/passwd", "a/../../b", "C:\\x", "..\\x", "", "a\0b")
    ],
)
def test_a_manifest_that_is_none_is_refused(tmp_path: Path, content: str) -> None:
    """Also one that a stranger made so that files elsewhere are taken for ours and removed."""
    (tmp_path / "mine.txt").write_text("mine")
    out = tmp_path / "out"
    out.mkdir()
    (out / NAME).write_bytes(content.encode("latin-1"))
    with pytest.raises(OutputError, match=r"rollerrig.json: no manifest of this program"):
        write(out, a_csv="1")
    assert names(tmp_path) == {"mine.txt", f"out/{NAME}"}


def test_no_file_behind_a_link_is_removed(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "a.csv").write_text("1")
    (tmp_path / "b.csv").write_text("1")
    out = tmp_path / "out"
    write(out, a_csv="1", b_csv="1")
    manifest = json.loads((out / NAME).read_text())
    manifest["files"]["data/a.csv"] = manifest["files"]["a.csv"]
    (out / NAME).write_text(json.dumps(manifest))
    (out / "data").symlink_to(tmp_path / "elsewhere")
    (out / "b.csv").unlink()
    (out / "b.csv").symlink_to(tmp_path / "b.csv")
    write(out, a_csv="2")
    assert (tmp_path / "elsewhere" / "a.csv").exists()
    assert (tmp_path / "b.csv").exists()
    assert (out / "b.csv").is_symlink()


def test_a_full_disk_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, a_csv="1", b_csv="1")
    before = {name: (tmp_path / name).read_bytes() for name in names(tmp_path)}
    calls = 0

    def full(_: int) -> None:
        nonlocal calls
        calls += 1
        if calls > 1:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(files.os, "fsync", full)
    with pytest.raises(OutputError, match=r"b.csv: cannot be written: the disk is full"):
        write(tmp_path, a_csv="2", b_csv="2")
    assert {name: (tmp_path / name).read_bytes() for name in names(tmp_path)} == before
    assert not list(tmp_path.glob(".*"))


def dies_while_it_writes(path: Path, moment: int) -> int:
    """Exit code of a process of its own that writes a folder and is killed at one of its steps; moment 0: their number."""
    child = os.fork()
    if child == 0:
        seen = 0

        def dying(function: Callable[..., Any]) -> Callable[..., Any]:
            def wrapped(*arguments: Any, **options: Any) -> Any:
                nonlocal seen
                seen += 1
                if seen == moment:
                    os.kill(os.getpid(), signal.SIGKILL)
                return function(*arguments, **options)

            return wrapped

        for name in ("replace", "unlink", "rmdir"):
            setattr(Path, name, dying(getattr(Path, name)))
        os.fsync = dying(os.fsync)
        try:
            with ResultFolder(path, "run", NO_CASES) as results:
                for name, content in (("a.csv", "2"), ("b.csv", "2"), ("data/c.csv", "2")):
                    results.add(name, content.encode())
                results.commit()
        finally:
            os._exit(seen)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs processes that can be killed")
def test_a_program_killed_while_it_writes_leaves_whole_files_that_the_next_one_replaces(tmp_path: Path) -> None:
    """At every step that changes the folder; the next run needs no --force and leaves the same folder."""

    def old(path: Path) -> None:
        with ResultFolder(path, "run", NO_CASES) as results:
            for name in ("a.csv", "data/c.csv", "stale/d.csv"):
                results.add(name, b"1")
            results.commit()

    old(tmp_path / "0")
    steps = dies_while_it_writes(tmp_path / "0", 0)
    assert steps >= 10
    expected = {name: (tmp_path / "0" / name).read_bytes() for name in names(tmp_path / "0")}
    assert set(expected) == {NAME, "a.csv", "b.csv", "data/c.csv"}
    for moment in range(1, steps + 1):
        path = tmp_path / str(moment)
        old(path)
        assert dies_while_it_writes(path, moment) == -signal.SIGKILL
        for name in names(path):
            if name.endswith(".csv") and not name.startswith("."):
                assert (path / name).read_text() in ("1", "2"), "whole, old or new"
        assert check_folder(path, "run", ["*.csv", "data/*.csv"]) == path
        with ResultFolder(path, "run", NO_CASES) as results:
            for name in ("a.csv", "b.csv", "data/c.csv"):
                results.add(name, b"2")
            results.commit()
        assert {name: (path / name).read_bytes() for name in names(path)} == expected, moment


# ---------------------------------------------------------------------------------------------------------- commands

CASE = """
name = "short"
vehicle = { use = "manchester_vehicle_1", cut = "leading_wheelset" }
support = { use = "full_scale_rig" }
contact = { material = "steel" }
motion = { speed = "40 km/h" }
time = { duration = "0.05 s" }
"""


@pytest.mark.slow
def test_a_run_into_the_folder_of_another_command_is_refused_before_it_begins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case, out = tmp_path / "case.toml", tmp_path / "out"
    case.write_text(CASE)
    code, text = call("conicity", "s1002", "uic60_benchmark_1_40", "--amplitudes-mm=3", "--step-mm=1", "--out", out)
    assert code == 0, text
    before = {name: (out / name).read_bytes() for name in names(out)}
    assert {"conicity.csv", NAME} <= before.keys()
    with monkeypatch.context() as patch:
        patch.setattr("rollerrig.study.run.simulate", lambda *_, **__: pytest.fail("the run has begun"))
        code, text = call("run", case, "--out", out)
    assert code == 2
    assert f"{out}: holds results of `rollerrig conicity`" in text
    assert {name: (out / name).read_bytes() for name in names(out)} == before

    assert call("run", case, "--out", out, "--force")[0] == 0
    manifest = read_manifest(out)
    assert manifest is not None
    assert manifest.command == "run"
    assert names(out) == {NAME, *manifest.files}
    assert set(manifest.cases) == {"short"}

    shutil.copytree(out, tmp_path / "first")
    assert call("run", case, "--out", out)[0] == 0, "the same command again"
    for name in names(out) - {"timing.json"}:
        assert (out / name).read_bytes() == (tmp_path / "first" / name).read_bytes(), name


def test_the_second_of_two_commands_in_a_folder_is_refused_before_it_begins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fcntl = pytest.importorskip("fcntl")
    monkeypatch.setattr("rollerrig.study.run.simulate", lambda *_, **__: pytest.fail("the run has begun"))
    handle = os.open(tmp_path, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)  # as the first command holds it
        code, text = call("run", "wheelset_rollers", "--out", tmp_path)
        with pytest.raises(OutputError, match="another command is writing there"):
            write(tmp_path, a_csv="1")
    finally:
        os.close(handle)
    assert code == 2
    assert f"{tmp_path}: another command is writing there; wait" in text
    assert names(tmp_path) == set()
    (tmp_path / ".rollerrig-left").mkdir()  # by a killed program, whose lock ended with it
    with locked(tmp_path):
        write(tmp_path, a_csv="1")
    assert {path.name for path in tmp_path.iterdir()} == {NAME, "a.csv"}


@pytest.mark.slow
def test_a_run_beside_the_users_own_files_keeps_them(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text(CASE)
    (tmp_path / "jobs").mkdir()
    (tmp_path / "jobs" / "mine.txt").write_text("mine")
    (tmp_path / "profile.csv").write_text("mine")
    assert call("run", case, "--out", tmp_path)[0] == 0
    assert case.read_text() == CASE
    assert (tmp_path / "jobs" / "mine.txt").read_text() == "mine"
    (tmp_path / "running_safety.csv").write_text("mine")
    code, text = call("run", case, "--out", tmp_path)
    assert code == 2
    assert "running_safety.csv: not written by this program, or changed since" in text
    assert (tmp_path / "running_safety.csv").read_text() == "mine"


def test_scale_does_not_replace_a_model_that_was_edited(tmp_path: Path) -> None:
    arguments = ("scale", "adhesion_brake", "--strategy", "dlr", "--out", tmp_path)
    assert call(*arguments)[0] == 0
    assert call(*arguments)[0] == 0
    model = tmp_path / "case.toml"
    model.write_text(model.read_text() + "# my changes\n")
    code, text = call(*arguments)
    assert code == 2
    assert "case.toml: not written by this program, or changed since" in text
    assert model.read_text().endswith("# my changes\n")


def test_every_command_that_writes_has_the_option() -> None:
    import typer

    for name, command in typer.main.get_command(build_app()).commands.items():  # type: ignore[attr-defined]
        options = {option for parameter in command.params for option in parameter.opts}
        assert ("--force" in options) == bool(options & {"--out", "--csv"}), name
