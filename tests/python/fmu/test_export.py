"""An exported FMU: nothing to say for FMPy, and its run is that of `simulate`."""

from __future__ import annotations

import shutil
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from rollerrig import catalog_entries, export_fmu, load_case, simulate
from rollerrig.cli import main
from rollerrig.interfaces.fmu.description import base_units
from rollerrig.interfaces.fmu.export import shells

fmpy = pytest.importorskip("fmpy", reason="FMPy is an optional dependency")
validation = pytest.importorskip("fmpy.validation")
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the library inside FMUs is built on Linux")


@pytest.fixture(scope="module")
def braked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A brake test in which wheels slide within the first half second."""
    out = tmp_path_factory.mktemp("fmu") / "braked.fmu"
    export_fmu(load_case("adhesion_brake"), out)
    return out


@pytest.mark.parametrize("name", ["bogie_track", "adhesion_brake"])
def test_a_run_by_fmpy_is_that_of_simulate(name: str, tmp_path: Path) -> None:
    case = load_case(name).with_changes({"time.duration": "0.1 s"})
    export_fmu(case, out := tmp_path / "case.fmu")
    run = simulate(case)
    time = run["time"].values
    step = time[1] - time[0]
    outputs = [
        "wheelset_1.lateral",
        "wheelset_1.yaw",
        "wheelset_1_left.vertical_force",
        "wheelset_1_right.lateral_force",
    ]
    found = fmpy.simulate_fmu(str(out), stop_time=time[-1], output_interval=step, output=outputs)
    np.testing.assert_array_equal(found["time"], np.arange(len(time)) * step)
    # With steps of its own length the model sees the same instants; FMPy adds them up where a run multiplies.
    for output, column, where in [
        ("wheelset_1.lateral", "lateral", {"body": "wheelset_1"}),
        ("wheelset_1.yaw", "yaw", {"body": "wheelset_1"}),
        ("wheelset_1_left.vertical_force", "vertical_force", {"wheel": "wheelset_1_left"}),
        ("wheelset_1_right.lateral_force", "lateral_force", {"wheel": "wheelset_1_right"}),
    ]:
        expected = run[column].sel(where).values
        np.testing.assert_allclose(found[output], expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())
    assert np.ptp(found["wheelset_1_left.vertical_force"]) > 0.0


@pytest.mark.slow
def test_fmi_3_has_the_same_run(braked: Path, tmp_path: Path) -> None:
    export_fmu("adhesion_brake", third := tmp_path / "third.fmu", fmi="3")
    assert validation.validate_fmu(str(third)) == []
    output = ["wheelset_1_left.vertical_force", "train.speed", "wheelset_2.cylinder_pressure"]
    old, new = (
        fmpy.simulate_fmu(str(file), stop_time=0.2, output_interval=0.01, output=output) for file in (braked, third)
    )
    for name in output:
        np.testing.assert_array_equal(old[name], new[name])


@pytest.mark.slow
def test_fmpy_has_nothing_to_say(braked: Path) -> None:
    assert validation.validate_fmu(str(braked)) == []
    description = fmpy.read_model_description(str(braked))
    variables = {variable.name: variable for variable in description.modelVariables}
    demand = variables["wheelset_1.brake_demand"]
    assert (demand.causality, demand.unit, demand.start, demand.max) == ("input", "Pa", "0.0", "10000000.0")
    assert variables["wheelset_1_left.derailment_quotient"].causality == "output"
    assert description.coSimulation.modelIdentifier == "adhesion_brake"


@pytest.mark.long
@pytest.mark.parametrize("fmi", ["2", "3"])
@pytest.mark.parametrize("name", [name for kind, name, _ in catalog_entries() if kind == "case"])
def test_fmpy_has_nothing_to_say_of_any_case_that_ships(name: str, fmi: str, tmp_path: Path) -> None:
    export_fmu(name, out := tmp_path / "case.fmu", fmi=fmi)
    assert validation.validate_fmu(str(out)) == []


def test_the_same_case_gives_the_same_bytes(braked: Path, tmp_path: Path) -> None:
    export_fmu(load_case("adhesion_brake"), again := tmp_path / "again.fmu")
    assert again.read_bytes() == braked.read_bytes()


def test_an_input_of_fmpy_acts(braked: Path) -> None:
    signals = np.array([(0.0, 0.0), (0.1, 2e5)], dtype=[("time", float), ("wheelset_1.brake_demand", float)])
    output = ["wheelset_1.cylinder_pressure", "wheelset_2.cylinder_pressure"]

    def pressures(**inputs: object) -> np.ndarray:
        found = fmpy.simulate_fmu(str(braked), stop_time=0.2, output_interval=1e-2, output=output, **inputs)
        return np.array([found[name][-1] for name in output])

    alone, more = pressures(), pressures(input=signals)
    assert more[0] > alone[0]
    assert more[1] == alone[1]


def test_it_carries_every_library_of_the_package(braked: Path) -> None:
    with zipfile.ZipFile(braked) as file:
        names = file.namelist()
    for shell in shells():
        assert shell.place("2", "adhesion_brake") in names


def test_powers_of_base_units() -> None:
    assert base_units("kg/m^2") == {"kg": 1, "m": -2}
    assert base_units("N m") == {"kg": 1, "m": 2, "s": -2}
    assert base_units("1") == {}
    assert base_units("m^3/(s Pa)") == {"kg": -1, "m": 4, "s": 1}
    assert base_units("m/s/s") == base_units("m/s^2") == {"m": 1, "s": -2}
    with pytest.raises(ValueError, match="'km/h' is not a unit of SI"):
        base_units("km/h")
    for unit in ("%", "m^0.5", "m^9^9^9"):  # the last one would keep pint busy for ever
        with pytest.raises(ValueError, match="is not a unit"):
            base_units(unit)
    with pytest.raises(ValueError, match="powers that are no whole numbers"):
        base_units("m^(1/2)")


def refusal(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *words: object) -> str:
    monkeypatch.setattr(sys, "argv", ["rollerrig", "export-fmu", *map(str, words)])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    message = capsys.readouterr().err
    assert message.count("\n") == 1
    return message


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (["--fmi", "1"], "adhesion_brake: fmi: '1'; allowed: 2, 3"),
        (["--kind", "hybrid"], "adhesion_brake: kind: 'hybrid'; allowed: cs, me, both"),
        (["--external", "autopilot"], "adhesion_brake: external: 'autopilot'; allowed: a table of the case"),
    ],
)
def test_what_is_not_offered_is_one_line(
    options: list[str], line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    message = refusal(monkeypatch, capsys, "adhesion_brake", "--out", tmp_path / "x.fmu", *options)
    assert message.startswith(f"rollerrig: {line}")
    assert list(tmp_path.iterdir()) == []


def test_the_file_of_another_program_stays(
    braked: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (theirs := tmp_path / "x.fmu").write_bytes(b"PK\x03\x04 of somebody else")
    refusal(monkeypatch, capsys, "adhesion_brake", "--out", theirs)
    assert theirs.read_bytes() == b"PK\x03\x04 of somebody else"
    shutil.copy(braked, theirs)
    export_fmu(load_case("adhesion_brake"), theirs)


def test_the_speed_of_the_rollers_is_an_input(tmp_path: Path) -> None:
    case = load_case("bogie_rollers_constant").with_changes({"disturbance": []})
    export_fmu(case, out := tmp_path / "bogie.fmu")
    description = fmpy.read_model_description(str(out))
    command = next(v for v in description.modelVariables if v.name == "run.speed_command")
    assert (command.causality, command.unit, float(command.start)) == ("input", "m/s", case.motion.speed)
    faster = case.motion.speed * 1.01
    given = np.array([(0.0, faster), (1.0, faster)], dtype=[("time", float), ("run.speed_command", float)])
    found = fmpy.simulate_fmu(
        str(out), input=given, stop_time=0.2, output_interval=0.05, output=["roller_1.pitch_rate"]
    )["roller_1.pitch_rate"]
    assert found[-1] / found[0] == pytest.approx(1.01, rel=1e-9)
    export_fmu("adhesion_brake", out := tmp_path / "rig.fmu", external=["rig_control"])
    names = {v.name for v in fmpy.read_model_description(str(out)).modelVariables if v.causality == "input"}
    assert {f"wheelset_1.roller_{name}" for name in ("torque_command", "speed_command", "speed_control")} <= names


def test_in_model_exchange_the_end_of_a_change_of_speed_is_an_event(tmp_path: Path) -> None:
    case = load_case("bogie_rollers_constant").with_changes({"disturbance": []})
    export_fmu(case, out := tmp_path / "bogie.fmu", kind="me")
    start = case.motion.speed
    rows = [(0.0, start), (0.05, start), (0.05, 1.01 * start), (1.0, 1.01 * start)]
    found = fmpy.simulate_fmu(
        str(out),
        input=np.array(rows, dtype=[("time", float), ("run.speed_command", float)]),
        stop_time=0.25,
        output_interval=0.05,
        output=["roller_1.pitch_rate"],
        fmi_type="ModelExchange",
    )
    gained = np.interp([0.1, 0.15, 0.25], found["time"], found["roller_1.pitch_rate"] / found["roller_1.pitch_rate"][0])
    np.testing.assert_allclose(gained, [1.005, 1.01, 1.01], rtol=1e-6)  # the tolerance of CVODE
