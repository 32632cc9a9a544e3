"""The names of `rollerrig`: each is what it should be, whatever was imported before, and none is a module too."""

from __future__ import annotations

import inspect
import random
import subprocess
import sys
from pathlib import Path

import pytest
from matplotlib.figure import Figure

import rollerrig as rr
from rollerrig.cli.app import COMMANDS

PACKAGE = Path(rr.__file__).parent
MODULES = sorted(
    ".".join(("rollerrig", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__")
    for path in PACKAGE.rglob("*.py")
    if path.name != "__main__.py"
)
OBJECTS = [name for name in rr.__all__ if name not in ("__version__", "plot")]

CHECK = """
import sys, types
from importlib import import_module
for module in sys.argv[1:]:
    import_module(module)
import rollerrig
for name in rollerrig.__all__:
    value = getattr(rollerrig, name)
    is_module = isinstance(value, types.ModuleType)
    assert is_module == (name == "plot"), f"{name} is a {type(value).__name__}"
    assert name in ("plot", "__version__") or callable(value), name
"""


def test_no_public_object_has_the_name_of_a_module() -> None:
    assert not {name for name in OBJECTS if (PACKAGE / name).is_dir() or (PACKAGE / f"{name}.py").is_file()}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_names_are_the_same_whatever_is_imported_first(seed: int) -> None:
    order = random.Random(seed).sample(MODULES, len(MODULES))
    done = subprocess.run([sys.executable, "-c", CHECK, *order], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


COSTLY = ("numpy", "pydantic", "pint", "pandas", "xarray", "matplotlib", "h5py", "jinja2")
COSTLY += ("scipy.interpolate", "scipy.optimize", "scipy.integrate", "scipy.signal", "scipy.stats", "scipy.linalg")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("work", "allowed"),
    [
        ("import rollerrig", set()),
        ("import rollerrig.analysis", set()),
        ("from rollerrig.cli import main; sys.argv = ['rollerrig', '--help']; main()", set()),
        (
            "from rollerrig.cli import main; sys.argv = ['rollerrig', 'adhesion', '--help']; main()",
            {"pydantic"},
        ),  # typer's own
        ("import rollerrig; rollerrig.load_case('bogie_track')", {"numpy", "pydantic"}),
        ("import rollerrig; rollerrig.simulate", {"numpy", "pydantic", "pandas", "xarray"}),
        (
            "import rollerrig.study.adhesion, rollerrig.study.run",
            {"numpy", "pydantic", "pandas", "xarray", "matplotlib", "h5py", "jinja2", "scipy.linalg"},
        ),  # what each process of a study loads
    ],
    ids=["import", "analysis", "help", "help of a command", "load_case", "simulate", "study"],
)
def test_what_is_not_needed_is_not_imported(work: str, allowed: set[str]) -> None:
    check = f"""
import atexit, sys
atexit.register(lambda: print("|", *(name for name in {COSTLY!r} if name in sys.modules)))
{work}
"""
    done = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, check=True)
    assert set(done.stdout.rpartition("|")[2].split()) <= allowed


def test_every_command_is_a_function() -> None:
    elsewhere = {"assemble": "assemble_file", "check": "load_case", "catalog": "catalog_entries"}
    elsewhere |= {"new": "starting_case", "schema": "json_schema", "show": "plot"}
    assert {elsewhere.get(command, command) for command in COMMANDS} <= set(rr.__all__)


def test_every_public_name_is_documented() -> None:
    assert [name for name in OBJECTS if not inspect.getdoc(getattr(rr, name))] == []


def test_an_unknown_name_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        rr.nonsense  # noqa: B018


# -------------------------------------------------------------------------------------- results drawn with defaults


def drawn(figure: Figure) -> int:
    return sum(len(axes.lines) + len(axes.collections) + len(axes.patches) for axes in figure.axes)


@pytest.fixture(scope="module")
def run():
    case = rr.load_case("wheelset_rollers")
    return rr.simulate(case.with_changes({"time.duration": "0.3 s", "time.output_step": "5 ms"}))


def test_a_run_and_its_wheel_forces_are_drawn(run) -> None:
    forces = rr.wheel_forces(run)
    for draw in (rr.plot.motion_over_time, rr.plot.sliding_over_time, rr.plot.energy_over_time):
        assert drawn(draw(run)) > 0
    for draw in (rr.plot.wheel_forces_over_time, rr.plot.quotient, rr.plot.track_shifting, rr.plot.wear):
        assert drawn(draw(forces)) > 0


def test_modes_are_drawn() -> None:
    modes = rr.stability("wheelset_rollers", [100.0, 150.0])
    figures = (rr.plot.damping_over_speed, rr.plot.frequency_over_speed, rr.plot.root_locus)
    for draw in (*figures, rr.plot.damping_map):
        assert drawn(draw(modes)) > 0


def test_contact_is_drawn() -> None:
    assert drawn(rr.plot.contact_figure(rr.contact("contact_benchmark_track"))) > 0


def test_creep_is_drawn() -> None:
    assert drawn(rr.plot.creep_figure(rr.creep(laws=["fastsim"], demands=(0.5, 2.0)))) > 0


def test_the_limit_cycle_diagram_is_drawn() -> None:
    cycles = rr.limit_cycle("wheelset_rollers", [100.0], processes=1, longest=1.6)
    assert cycles.attrs["bifurcation"] == "none"
    assert drawn(rr.plot.limit_cycle_diagram(cycles)) > 0
