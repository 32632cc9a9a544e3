"""What is no regular file of a sensible size is refused before it is read: a device never ends, a pipe never begins."""

from __future__ import annotations

import ast
import io
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig.common.input_files import LARGEST_TABLE, LARGEST_TEXT, InputError, read_input
from rollerrig.config import ConfigError, load_any, load_material, load_profile, load_support, load_vehicle
from rollerrig.irregularity import IrregularityError, read_measured_track
from rollerrig.results import ResultsError, files, save_run
from rollerrig.study.checkpoint import NAME, Checkpoint

PACKAGE = Path(rr.__file__).parent


def load_changed(key: str, case: str) -> Callable[[str], object]:
    return lambda path: rr.load_case(case).with_changes({key: {"kind": "file", "path": path}})


def simulate_with_controller(path: str) -> object:
    return rr.simulate(rr.load_case("adhesion_brake").with_changes({"rig_control.user": f"{path}:Mine"}))


def go_on_with_jobs(path: str) -> object:
    (Path(path).parent / NAME).symlink_to(path)
    return Checkpoint(Path(path).parent, "test", {})


READERS: dict[str, tuple[str, Callable[[str], object], type[Exception]]] = {
    "case": (".toml", rr.load_case, ConfigError),
    "any": (".toml", load_any, ConfigError),
    "vehicle": (".toml", load_vehicle, ConfigError),
    "support": (".toml", load_support, ConfigError),
    "material": (".toml", load_material, ConfigError),
    "profile by its table": (".toml", load_profile, ConfigError),
    "profile": (".csv", lambda path: load_profile(path, "wheel"), ConfigError),
    "profile of a vehicle": (".dat", load_changed("vehicle.wheel.profile", "wheelset_rollers"), ConfigError),
    "measured track": (".csv", load_changed("support.irregularity", "vehicle_track_irregular"), ConfigError),
    "measured track by itself": (".csv", lambda path: read_measured_track(Path(path)), IrregularityError),
    "controller": (".py", simulate_with_controller, ConfigError),
    "results": (".nc", rr.load_run, ResultsError),
}


@pytest.mark.parametrize(("ending", "read", "error"), READERS.values(), ids=READERS)
def test_a_pipe_is_not_waited_for(
    tmp_path: Path, ending: str, read: Callable[[str], object], error: type[Exception]
) -> None:
    path = tmp_path / f"pipe{ending}"
    os.mkfifo(path)
    with pytest.raises(error, match=r"pipe.*a pipe, not a regular file"):
        read(str(path))


@pytest.mark.parametrize(("ending", "read", "error"), READERS.values(), ids=READERS)
def test_a_device_is_not_read(
    tmp_path: Path, ending: str, read: Callable[[str], object], error: type[Exception]
) -> None:
    path = tmp_path / f"zero{ending}"
    path.symlink_to("/dev/zero")
    with pytest.raises(error, match=r"zero.*a device, not a regular file"):
        read(str(path))


@pytest.mark.parametrize(("ending", "read", "error"), READERS.values(), ids=READERS)
def test_a_null_byte_in_a_name_is_an_error_of_the_user(
    ending: str, read: Callable[[str], object], error: type[Exception]
) -> None:
    with pytest.raises(error, match="null byte in its name"):
        read(f"a\0b{ending}")


@pytest.mark.parametrize(
    ("ending", "read", "error"),
    [row for name, row in READERS.items() if name != "results"],
    ids=[name for name in READERS if name != "results"],
)
def test_what_is_far_too_large_is_not_read(
    tmp_path: Path, ending: str, read: Callable[[str], object], error: type[Exception]
) -> None:
    path = tmp_path / f"large{ending}"
    with path.open("wb") as file:
        file.truncate(10**12)  # takes no room
    with pytest.raises(error, match=r"large.*too large: 1e\+03 GB, at most (4|64) MB are read"):
        read(str(path))


def test_jobs_in_a_pipe_are_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(rr.OutputError, match="a pipe, not a regular file"):
        go_on_with_jobs(str(tmp_path / "pipe"))


def test_a_file_that_does_not_tell_its_size_is_read_up_to_the_limit() -> None:
    assert read_input("/proc/self/status", LARGEST_TEXT).startswith(b"Name:")
    with pytest.raises(InputError, match="too large"):
        read_input("/proc/self/status", 10)


def test_limits_leave_room_for_real_files() -> None:
    whole = max(len(rr.load_case(name).to_toml()) for kind, name, _ in rr.catalog_entries() if kind == "case")
    assert 100 * whole < LARGEST_TEXT
    assert 200_000 / 0.25 * len("123456.75;-12.345;-12.345;-12.345;-12.345\n") < LARGEST_TABLE


@pytest.mark.parametrize("command", ["check", "run"])
def test_commands_name_the_device(command: str, tmp_path: Path) -> None:
    """The whole program: also where it looks for the name of the case to say what was wrong with it."""
    more = ["--out", str(tmp_path / "out")] if command == "run" else []
    done = subprocess.run(
        [sys.executable, "-c", "from rollerrig.cli import main; main()", command, "/dev/zero", *more],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 2
    assert done.stderr == (
        "rollerrig: /dev/zero: a device, not a regular file; allowed: a TOML file that can be read\n"
    )


def test_results_that_do_not_fit_are_refused_by_their_size_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = save_run(xr.Dataset({"x": ("n", [0.0] * 100_000)}), tmp_path / "zeros.nc")
    assert path.stat().st_size < 20_000
    assert rr.load_run(path).sizes["n"] == 100_000
    monkeypatch.setattr(files, "available_memory", lambda: 500_000.0)
    with pytest.raises(ResultsError, match=r"zeros.nc: 0.0012 GB of results; 0.0005 GB of memory are available"):
        rr.load_run(path)


@pytest.mark.skipif(sys.platform != "linux", reason="limits of addresses are read from /proc")
def test_a_limit_on_addresses_is_a_limit_on_memory() -> None:
    code = (
        "import resource; from rollerrig.results.files import available_memory as left; "
        "used = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize(); "
        "resource.setrlimit(resource.RLIMIT_AS, (used + 50_000_000,) * 2); print(left())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert 30e6 < float(done.stdout) <= 50e6


def test_what_is_no_file_of_results_is_named(tmp_path: Path) -> None:
    (tmp_path / "text.nc").write_text("no results")
    with pytest.raises(ResultsError, match=r"text.nc: no NetCDF file of results such as run.nc, or a damaged one"):
        rr.load_run(tmp_path / "text.nc")
    with h5py.File(tmp_path / "other.nc", "w") as file:
        file["x"] = [1.0]
    with pytest.raises(ResultsError, match=r"other.nc: results of another version \(rollerrig another program"):
        rr.load_run(tmp_path / "other.nc")


@pytest.mark.parametrize("name", ["out\0", "o\0t/below"])
def test_a_null_byte_in_the_name_of_an_output(tmp_path: Path, name: str) -> None:
    for write in (files.output_folder, files.output_file, lambda path: files.write_text(path, "text")):
        with pytest.raises(rr.OutputError, match="a null byte in its name"):
            write(tmp_path / name)


OWN_FILES = {
    "catalog/__init__.py": "files that ship",
    "catalog/starting_case.py": "a case that ships",
    "__init__.py": "its own text",
    "cli/study_command.py": "the table of costs that ships",
    "study/__init__.py": "the texts of its own modules",
    "viewer/play.py": "a browser",
    "config/write/explain.py": "files that ship",
    "assembly/creep_table.py": "the table that ships",
    "interfaces/fmu/export.py": "the libraries that ship",
    "common/input_files.py": "the door itself",
    "results/files.py": "of the kernel",
    "results/folder.py": "the folder itself, to lock it",
    "results/run_info.py": "the sources that ship",
    "results/quantities.py": "the registry that ships",
    "study/paper.py": "the text of a report, which ships",
    "interfaces/realtime/links.py": "the memory of the server",
    "study/report.py": "the template that ships",
    "viewer/page.py": "the page that ships",
}
"""Where something is opened that is no file of the user."""


def opened(source: Path) -> list[str]:
    """Names of calls that open files for reading."""
    found = []
    for node in ast.walk(ast.parse(source.read_text())):
        if isinstance(node, ast.Call):
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            modes = [str(a.value) for a in node.args if isinstance(a, ast.Constant)]
            if name in {"read_text", "read_bytes", "loadtxt", "genfromtxt", "fromfile", "spec_from_file_location"} or (
                name == "open" and not any(mode[:1] in "wax" for mode in modes)
            ):
                found.append(name)
    return found


def test_files_of_the_user_come_in_by_one_door() -> None:
    sources = {source.relative_to(PACKAGE).as_posix(): source for source in sorted(PACKAGE.rglob("*.py"))}
    doors = {name: opened(source) for name, source in sources.items() if name not in OWN_FILES}
    assert {name: found for name, found in doors.items() if found} == {}


def test_a_file_that_has_nothing_to_give_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As /proc/kmsg does, which only the administrator may open: read without blocking, it answers None."""

    class Silent(io.BytesIO):
        def read(self, _size: int | None = -1) -> bytes:
            return None  # type: ignore[return-value]

    monkeypatch.setattr("rollerrig.common.input_files.open_input", lambda _path, _largest: Silent())
    with pytest.raises(InputError, match="nothing can be read from it"):
        read_input(tmp_path / "silent", 100)


@pytest.mark.parametrize("one", ["[", "{a=", "[{a="])
def test_a_file_nested_beyond_reason_is_refused_in_a_line(one: str, tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text("a = " + one * 20_000)
    command = [sys.executable, "-c", "from rollerrig.cli import main; main()", "check", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert f"{path}: not TOML that can be read" in done.stderr
    assert "Traceback" not in done.stderr


def test_of_thousands_of_mistakes_the_first_are_listed_and_the_rest_counted(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text('base = "bogie_track"\n' + "".join(f'[[vehicle.body]]\nname = "b{k}"\n' for k in range(2000)))
    with pytest.raises(ConfigError) as error:
        rr.load_case(path)
    assert len(error.value.problems) < 1200  # those of the elements beside them
    assert "more mistakes" in str(error.value.problems[-1])
    unknown = next(problem for problem in error.value.problems if problem.value == "'front_frame'")
    assert unknown.allowed.endswith("b998, b999, ... (1000 more)")
    assert unknown.hint == ""
