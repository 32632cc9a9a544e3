"""A model in a file runs as the case does, bit for bit; what is no such file is refused by name."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import rollerrig as rr
from called import called
from rollerrig import _core, load_case
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.assembly.model import assemble
from rollerrig.config import Case, ConfigError
from rollerrig.interfaces.plant import ModelFileError, assembled_model
from rollerrig.simulation.run import prepare

RUNS = {
    "adhesion_brake": "50 ms",
    "adhesion_sanding": "50 ms",
    "adhesion_valves": "50 ms",
    "bogie_rollers_traction": "50 ms",
    "scaled_brake": "20 ms",
    "vehicle_curve": "30 ms",
    "vehicle_track_irregular": "30 ms",
    "wheelset_rollers": "50 ms",
}


def course(simulation: _core.Simulation, until: float) -> np.ndarray:
    """Everything recorded until then, every time beside it."""
    times, rows = np.full(400, np.nan), np.zeros((400, simulation.width))
    code, filled = simulation.advance(until, times, rows, 0)
    assert code == _core.status_codes["ok"]
    return np.column_stack([times[:filled], rows[:filled]])


@pytest.mark.parametrize("name", RUNS)
def test_a_run_of_the_file_is_the_run_of_the_case_bit_for_bit(name: str, tmp_path: Path) -> None:
    the_file_runs_as_the_case(load_case(name).with_changes({"time.duration": RUNS[name]}), tmp_path)


def test_rails_and_heads_that_change_are_in_the_file(tmp_path: Path) -> None:
    other = {"gauge": 1.44, "inclination": 0.05, "profile": "en_60e1_1_40"}
    ends = ({"kind": "straight", "length": 1.0}, {"kind": "straight", "length": 50.0, **other})
    track = {"support.segment": [ends[0], {"kind": "transition", "length": 10.0}, ends[1]]}
    spot = {"support.spot": {"start": 0.2, "ramp": 0.5, "length": 0.1, "depth": 1e-4}}
    for name, change in (("bogie_track", track), ("bogie_rollers_constant", spot)):
        the_file_runs_as_the_case(load_case(name).with_changes({**change, "time.duration": "50 ms"}), tmp_path)


def the_file_runs_as_the_case(case: Case, tmp_path: Path) -> None:
    path = rr.assemble_file(case, tmp_path / "rig.model")
    assert rr.assemble_file(case, tmp_path / "again.model").read_bytes() == path.read_bytes()
    read = rr.read_model(path)
    from_file = _core.Simulation(read.model, read.setup)
    step = case.time.output_step
    settings = {name: getattr(read.options, name) for name in _core.Options.fields} | {"output_step": step}
    from_file.start(_core.Options(**settings), t0=read.t0, x0=np.array(read.x0))
    of_case = prepare(assemble_with_actuators(case) if case.sampled else assemble(case), output_step=step)
    expected = course(of_case, case.time.duration)
    assert len(expected) >= 3
    np.testing.assert_array_equal(course(from_file, case.time.duration), expected)


def test_a_plant_of_the_file_has_the_variables_of_the_case(tmp_path: Path) -> None:
    case = load_case("adhesion_brake")
    path = rr.assemble_file(case, tmp_path / "rig.model", external=["slide_protection"])
    plants = [_core.Plant(m) for m in (rr.read_model(path), assembled_model(case, external=["slide_protection"]))]
    first, second = ([(v.name, v.unit, v.causality) for v in plant.variables] for plant in plants)
    assert first == second
    assert ("wheelset_2.valve_command", "1", "input") in first


def test_what_is_no_model_file_is_refused_by_name(tmp_path: Path) -> None:
    path = rr.assemble_file("wheelset_rollers", tmp_path / "rig.model")
    whole = path.read_bytes()
    spoiled = {
        "cut": whole[:-1],
        "changed": whole[:-1] + bytes([whole[-1] ^ 1]),
        "it is none": b"PK\x03\x04",
        "cut: ": b"",
    }
    for what, content in spoiled.items():
        path.write_bytes(content)
        with pytest.raises(ModelFileError, match=f"rig.model: model file: .*{what}"):
            rr.read_model(path)


def test_the_command_writes_the_file_and_says_its_inputs(tmp_path: Path) -> None:
    path = tmp_path / "rig.model"
    arguments = ["assemble", "adhesion_brake", "--out", str(path), "--external", "slide_protection"]
    done = called(*arguments)
    assert done.exit_code == 0
    assert "wheelset_1.valve_command [1]" in done.stderr
    assert rr.read_model(path).name == "adhesion_brake"
    before = path.read_bytes()
    assert called(*arguments).exit_code == 0  # our own file may be replaced
    assert path.read_bytes() == before
    refused = called(*arguments[:-1], "anti_slip")
    assert refused.exit_code == 2
    assert "anti_slip" in refused.stderr
    assert path.read_bytes() == before


def test_a_file_of_another_program_stays(tmp_path: Path) -> None:
    path = tmp_path / "rig.model"
    path.write_text("mine")
    with pytest.raises(rr.OutputError):
        rr.assemble_file("wheelset_rollers", path)
    assert path.read_text() == "mine"
    assert list(tmp_path.iterdir()) == [path]


def test_a_controller_in_python_has_no_place_in_a_file(tmp_path: Path) -> None:
    case = load_case("adhesion_brake").with_changes({"slide_protection.user": "module:Class"})
    with pytest.raises(ConfigError, match=r"slide_protection\.user"):
        rr.assemble_file(case, tmp_path / "rig.model")
    assert not list(tmp_path.iterdir())


def test_the_page_names_every_kind_of_value_that_the_layout_has() -> None:
    lines = [line for line in _core.model_layout.splitlines() if not line.strip().startswith("= ")]
    assert "    mass f64, kg" in lines
    fields = [line.split(",")[0].split() for line in lines]
    words = {word for _, *kind in fields for word in re.findall(r"[a-z]+[0-9]*|@", " ".join(kind))}
    page = (Path(__file__).parents[3] / "docs" / "model_file.md").read_text()
    assert {"f64", "bool", "text", "law", "x"} <= words
    assert [word for word in words if f"`{word}`" not in page and f" {word} " not in page] == []
