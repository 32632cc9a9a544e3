"""The library for Windows: what it offers and asks for, and its run under wine beside that of this machine.

`scripts/build_windows_shell` builds it, in minutes; without it, or without mingw-w64 and wine, there is nothing to test.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from rollerrig import export_fmu
from rollerrig.interfaces.fmu import export
from rollerrig.interfaces.fmu.export import WINDOWS, Shell, shells

ROOT = Path(__file__).parents[3]
LIBRARY = ROOT / "build" / "windows" / "fmu" / "rollerrig.dll"
MINGW = shutil.which("x86_64-w64-mingw32-gcc-posix") or shutil.which("x86_64-w64-mingw32-gcc")
WINE = shutil.which("wine64") or shutil.which("wine") or shutil.which("/usr/lib/wine/wine64")

long = pytest.mark.long
built = pytest.mark.skipif(not LIBRARY.is_file() or not MINGW, reason="scripts/build_windows_shell was not run here")


def with_windows(monkeypatch: pytest.MonkeyPatch, library: Path) -> None:
    """As if the package had been built with it."""
    windows = Shell(WINDOWS, library, "")
    monkeypatch.setattr(export, "shells", lambda: [*shells(), windows])


@pytest.mark.skipif(sys.platform != "linux", reason="the library inside FMUs is built on Linux")
def test_an_fmu_carries_the_windows_library_where_the_package_has_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (library := tmp_path / "rollerrig.dll").write_bytes(b"MZ")
    with_windows(monkeypatch, library)
    for fmi, folder in (("2", "win64"), ("3", "x86_64-windows")):
        export_fmu("bogie_track", out := tmp_path / f"{fmi}.fmu", fmi=fmi)
        with zipfile.ZipFile(out) as file:
            assert file.read(f"binaries/{folder}/bogie_track.dll") == b"MZ"


@long
@built
def test_exports_are_the_standard_s_and_imports_are_on_every_windows() -> None:
    """The script says so, and fails otherwise."""
    command = [sys.executable, str(ROOT / "scripts" / "windows_library.py")]
    found = subprocess.run([*command, str(LIBRARY)], capture_output=True, text=True, check=False)
    assert (found.returncode, found.stderr) == (0, "")
    assert "fmi2DoStep" in found.stdout
    assert "imports kernel32.dll, msvcrt.dll" in found.stdout


@long
@built
@pytest.mark.skipif(not WINE, reason="there is no wine")
def test_a_run_under_wine_is_that_of_this_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A brake test with sliding wheels. The C libraries and instructions differ: round-off, which grows with the slide."""
    fmpy = pytest.importorskip("fmpy", reason="FMPy is an optional dependency")
    with_windows(monkeypatch, LIBRARY)
    export_fmu("adhesion_brake", out := tmp_path / "braked.fmu")
    with zipfile.ZipFile(out) as file:
        file.extractall(folder := tmp_path / "an fmu")
    names = ["wheelset_1_left.vertical_force"]
    names += [f"wheelset_1.{name}" for name in ("real_sliding", "valve", "dump_cycles", "cylinder_pressure")]
    names += ["wheelset_2_right.lateral_force", "train.speed"]
    description = fmpy.read_model_description(str(out))
    references = {variable.name: str(variable.valueReference) for variable in description.modelVariables}
    driver = tmp_path / "drive.exe"
    headers = ROOT / "third_party" / "fmi" / "2.0"
    source = str(Path(__file__).with_name("drive.c"))
    subprocess.run([MINGW, "-std=c2x", "-O1", f"-I{headers}", source, "-o", str(driver)], check=True)
    uri = "file:///Z:" + str(folder / "resources").replace(" ", "%20")
    words = [description.guid, uri, "0.01", "400", *(references[name] for name in names)]
    library = folder / "binaries" / "win64" / "adhesion_brake.dll"
    environment = {**os.environ, "WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all"}
    found = subprocess.run(
        [WINE, str(driver), str(library), *words], env=environment, capture_output=True, text=True, check=False
    )
    assert found.returncode == 0, found.stderr
    here = fmpy.simulate_fmu(str(out), stop_time=4.0, output_interval=0.01, output=names)
    there = np.array([float(line) for line in found.stdout.split()])
    np.testing.assert_allclose(there, [here[name][-1] for name in names], rtol=1e-6, atol=1e-9)
