"""The linear bench under its brakes: against a closed form, differences of steady states, and a sine on the nonlinear bench."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rollerrig as rr
from called import called
from rollerrig import ConfigError, _core
from rollerrig.analysis.linear_bench import LinearBench
from rollerrig.analysis.measured_response import measured_response
from rollerrig.assembly.actuators import friction_brake
from rollerrig.simulation.starting_state import StartError, starting_state
from rollerrig.study.runs.adhesion import track_case

PRESSURE, SPEED = 2e5, 25.0  # [Pa], [m/s]
DEMAND, AXLE = "wheelset_1.brake_demand", "wheelset_1.axle_speed"


@pytest.fixture(scope="module")
def bench() -> LinearBench:
    return LinearBench(rr.load_case("adhesion_brake"), SPEED, PRESSURE)


def test_the_rollers_drives_hold_the_speed_against_the_pads(bench: LinearBench) -> None:
    """Torque of a drive = that of the pads, over the radii; creep and loads that shift take less than 1 %."""
    radius, roller = bench.case.vehicle.data.wheel.radius, bench.case.support.data.roller_radius
    pads = -float(friction_brake(bench.case.brake).torque(PRESSURE, SPEED / radius))
    assert list(bench.holding) == [f"wheelset_{i}.roller_torque_command" for i in (1, 2)]
    assert pads > 1e3
    for torque in bench.holding.values():
        assert torque == pytest.approx(pads * roller / radius, rel=0.01)


def test_pressure_slows_axle_and_roller_together(bench: LinearBench) -> None:
    """Below the modes of the bogie: torque by pressure over i w (I + (r/R)^2 I_r), the wheel rolls on its roller."""
    radius, roller = bench.case.vehicle.data.wheel.radius, bench.case.support.data.roller_radius
    torque = [
        float(friction_brake(bench.case.brake).torque(PRESSURE + change, SPEED / radius)) for change in (-10.0, 10.0)
    ]
    by_pressure = (torque[1] - torque[0]) / 20.0
    inertia = bench.model.inertias["wheelset_1"][1] + (radius / roller) ** 2 * bench.model.inertias["roller_1"][1]
    system = bench.system(["wheelset_1.cylinder_pressure"], [AXLE])
    assert system.input_units == ("Pa",)
    for frequency in (0.1, 0.3):
        expected = by_pressure / (2j * np.pi * frequency * inertia)
        found = system.response(np.array([frequency]))[0, 0, 0]
        assert abs(found / expected - 1.0) < 0.015


def test_steady_states_under_other_pressures_lie_where_the_linear_bench_says(bench: LinearBench) -> None:
    """Central differences of what is found at 1 kPa more and less: A dx + B du = 0."""
    simulation = _core.Simulation(bench.model.core)
    start = starting_state(bench.model)
    states, torques = [], []
    for change in (-1e3, 0.0, 1e3):
        x, torque, found = simulation.hold_speed(0.0, start, [PRESSURE + change, PRESSURE])
        assert found
        states.append(x)
        torques.append(np.array(torque))
    a, b, _, _ = simulation.linear_model(0.0, states[1], [PRESSURE] * 2, list(torques[1]))
    moved = (states[2] - states[0]) / 2e3
    pushed = (torques[2] - torques[0]) / 2e3
    count = len(bench.torques)  # of axles, then of rollers; behind them the cylinders
    rollers, cylinder = b[:, count - 2 : count], b[:, count]
    terms = np.abs(a * moved).max(axis=1) + np.abs(rollers * pushed).max(axis=1) + np.abs(cylinder)
    left = np.abs(a @ moved + rollers @ pushed + cylinder)
    assert np.abs(moved).max() > 0.0
    assert np.all(left <= 1e-4 * terms + 1e-12)


@pytest.mark.slow
def test_a_sine_on_the_demand_gives_what_the_linear_bench_says(bench: LinearBench) -> None:
    """1 dB is asked for up to half the bandwidth of the control valve, 20 1/s: 1.6 Hz."""
    frequencies = [0.5, 1.0, 1.6]
    found = measured_response(bench, DEMAND, [AXLE], frequencies, 1000.0)
    assert found is not None
    assert not found.ended
    linear = bench.system([DEMAND], [AXLE], discrete=True).response(found.frequencies)[:, :, 0]
    decibels = 20.0 * np.log10(np.abs(found.values / linear))
    assert np.abs(decibels).max() < 0.1
    assert np.abs(np.angle(found.values / linear)).max() < 0.05


def test_another_torque_of_a_drive_is_measured_about_the_one_that_holds(bench: LinearBench) -> None:
    source = "wheelset_1.roller_torque_command"
    found = measured_response(bench, source, [AXLE], [10.0], 100.0)
    assert found is not None
    linear = bench.system([source], [AXLE], discrete=True).response(found.frequencies)[:, :, 0]
    np.testing.assert_allclose(np.abs(found.values), np.abs(linear), rtol=0.05)


def test_on_track_the_frame_is_held() -> None:
    """The axle is braked as on rollers, whose torque has no counterpart there."""
    bench = LinearBench(track_case(rr.load_case("adhesion_brake")), SPEED, PRESSURE)
    assert bench.holding == {}
    system = bench.system([DEMAND], [AXLE, "wheelset_1_left.longitudinal_force"])
    assert system.input_units == ("Pa",)
    assert np.all(np.isfinite(system.response(np.array([1.0]))))
    assert measured_response(bench, DEMAND, [AXLE], [1.0], 1000.0) is None


@pytest.mark.parametrize(
    ("case", "pressure", "names", "message"),
    [
        ("adhesion_brake", 0.0, [DEMAND], r"inputs: 'wheelset_1.brake_demand'; allowed with brake_pressure"),
        ("adhesion_brake", PRESSURE, ["wheelset_1.valve_command"], r"a dump valve fills, holds or vents"),
        ("bogie_rollers_constant", PRESSURE, ["wheelset_1.axle_torque"], r"brake_pressure: '?200000 Pa'?; allowed: 0"),
        ("adhesion_brake", -1.0, [DEMAND], r"brake_pressure: .*from 0 to 1e7"),
        ("adhesion_brake", float("nan"), [DEMAND], r"brake_pressure: .*from 0 to 1e7"),
    ],
)
def test_what_has_no_small_motion_is_refused(case: str, pressure: float, names: list[str], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        rr.linearize(case, SPEED, names, [AXLE], brake_pressure=pressure)


def test_wheels_that_would_slide_are_said_so() -> None:
    case = rr.load_case("adhesion_brake").with_changes({"contact.friction": 0.02})
    with pytest.raises(StartError, match=r"no steady rolling at 90 km/h and 4 bar"):
        LinearBench(case, SPEED, 4e5)


def test_the_command_says_the_pressure(tmp_path: Path) -> None:
    words = [
        "response",
        "adhesion_brake",
        "--input",
        DEMAND,
        "--output",
        AXLE,
        "--brake-pressure",
        "2",
        "--measured",
        "0",
    ]
    done = called(*words, "--points", "20", "--to-hz", "20", "--out", tmp_path / "out")
    assert done.exit_code == 0, done.stderr
    assert '"brake_pressure_bar": 2.0' in (tmp_path / "out" / "summary.json").read_text()
