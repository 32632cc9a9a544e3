"""The installed core: the programs of examples/cpp are built on it as a user does, and say what the package computes."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import rollerrig as rr

ROOT = Path(__file__).parents[3]
BUILDS = sorted((ROOT / "build").glob("cp3*/librollerrig_core.a"), key=lambda path: path.stat().st_mtime)


def done(*command: object) -> str:
    """What a command prints."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    run = subprocess.run(
        list(map(str, command)),
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PATH": path, "CMAKE_GENERATOR": "Ninja"},
    )
    assert run.returncode == 0, run.stdout + run.stderr
    return run.stdout


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the programs, built on the core that was compiled for the extension."""
    if not BUILDS:
        pytest.skip("the package was not built in this checkout: there is no library of the core to install")
    folder = tmp_path_factory.mktemp("cpp")
    done("cmake", "--install", BUILDS[-1].parent, "--component", "development", "--prefix", folder / "installed")
    done("cmake", "-S", ROOT / "examples/cpp", "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={folder / 'installed'}")
    done("cmake", "--build", folder / "build")
    return folder / "build"


@pytest.mark.slow
def test_a_run_for_each_stiffness_is_that_of_the_package(programs: Path, tmp_path: Path) -> None:
    case = rr.load_case("bogie_rollers_constant").with_changes({"motion.speed": "210 km/h", "time.duration": "6 s"})
    rr.assemble_file(case, tmp_path / "bogie.model")
    printed = done(programs / "primary_stiffness", tmp_path / "bogie.model")
    found = {float(factor): float(mm) for factor, mm in re.findall(r"x (\S+): (\S+) mm, ok", printed)}
    assert list(found) == [0.5, 0.8, 1.0, 1.25, 2.0]
    key = "vehicle.element.primary_*.y.stiffness"
    stiffness = next(e.y.stiffness for e in case.vehicle.data.element if e.name == "primary_1_left")
    for factor in (0.8, 2.0):
        run = rr.simulate(case.with_changes({key: factor * stiffness}))
        end = run["lateral"].sel(body="wheelset_1").where(run["time"] > 5.0, drop=True)
        assert found[factor] == pytest.approx(1e3 * float(np.abs(end).max()), rel=0.02)


@pytest.mark.slow
def test_a_slide_protection_in_cpp_stops_the_train(programs: Path, tmp_path: Path) -> None:
    rr.assemble_file("adhesion_brake", tmp_path / "brake.model", external=["slide_protection"])
    printed = done(programs / "slide_protection", tmp_path / "brake.model")
    time, distance, speed, vented = map(
        float, re.findall(r"after (\S+) s and (\S+) m at (\S+) km/h; .* in (\d+)", printed)[0]
    )
    built_in = rr.simulate("adhesion_brake")
    assert speed == pytest.approx(3.6, abs=0.05)
    assert float(built_in["train_distance"][-1]) < distance < 1.15 * float(built_in["train_distance"][-1])
    assert time > float(built_in["time"][-1])
    assert vented > 10000


@pytest.mark.slow
def test_a_model_without_the_variables_is_refused_by_name(programs: Path, tmp_path: Path) -> None:
    rr.assemble_file("bogie_rollers_constant", tmp_path / "bogie.model")
    run = subprocess.run(
        [programs / "slide_protection", tmp_path / "bogie.model"], capture_output=True, text=True, check=False
    )
    assert (run.returncode, run.stderr) == (2, "the model has no variable train.speed\n")
