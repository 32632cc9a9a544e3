"""The linear bench against differences, against the modes' linearisation, and as other tools take it."""

from __future__ import annotations

import io
import math

import control
import numpy as np
import pytest
import scipy.io
import xarray as xr

import rollerrig as rr
from rollerrig import _core
from rollerrig.analysis import linear_bench
from rollerrig.analysis.linear_bench import LinearBench
from rollerrig.analysis.linear_system import margins_of
from rollerrig.analysis.modes import Lineariser
from rollerrig.assembly.model import assemble
from rollerrig.cases import on_track
from rollerrig.config import ConfigError
from rollerrig.simulation.starting_state import starting_state

COMMAND, SPEED = "wheelset_1.roller_torque_command", "wheelset_1.axle_speed"


@pytest.fixture(scope="module")
def bench() -> LinearBench:
    return LinearBench(rr.load_case("adhesion_brake"))


@pytest.mark.parametrize("name", ["bogie_rollers_traction", "adhesion_start", "bogie_track"])
def test_outputs_follow_states_as_differences_say(name: str) -> None:
    """Central differences of the recorded row; their own error is about 1e-6 of the largest entry of a row."""
    bench = LinearBench(rr.load_case(name))
    simulation = _core.Simulation(bench.model.core)
    state = starting_state(bench.model)
    c = simulation.linear_model(0.0, state, [], [])[2]
    quadratures = np.zeros(simulation.quadrature_count)
    scale = np.abs(c).max(axis=1) + 1e-6
    for i in range(len(state)):
        errors = []
        for shorter in (1.0, 16.0):  # a profile's knot within a step is a kink; the shorter one stays clear of it
            step = np.zeros(len(state))
            step[i] = (1e-7 if i < len(state) // 2 else 1e-6) / shorter
            above, below = (simulation.record(0.0, state + s * step, quadratures)[: len(c)] for s in (1.0, -1.0))
            errors.append(np.abs((above - below) / (2.0 * step[i]) - c[:, i]))
        error = np.fmin(*errors)
        there = np.isfinite(error)
        assert np.all(error[there] <= 2e-5 * scale[there])


def test_torques_act_as_in_the_equations_of_motion() -> None:
    """Forces are linear in a torque: the difference of two derivatives is its column, to rounding."""
    case = rr.load_case("bogie_rollers_traction").with_changes(
        {"axle_torque.1.constant": 0.0, "axle_torque.1.table": None}
    )
    bench = LinearBench(case)
    system = bench.system(
        ["wheelset_2.axle_torque"], ["wheelset_2.pitch_acceleration", "front_frame.pitch_acceleration"]
    )
    model = assemble(bench.case)
    state = starting_state(model)
    pushed = assemble(bench.case.with_changes({"axle_torque.1.constant": 1000.0}))
    rest, moved = (_core.Simulation(m.core).derivative(0.0, state)[0] for m in (model, pushed))
    rows = [_core.Simulation(model.core).rate_index[model.body_index(b)][4] for b in ("wheelset_2", "front_frame")]
    np.testing.assert_allclose(system.d[:, 0], (moved - rest)[rows] / 1000.0, rtol=1e-9)
    names = [system.states.index(f"{body}.pitch_rate") for body in ("wheelset_2", "front_frame")]
    np.testing.assert_allclose(system.b[names, 0], system.d[:, 0], rtol=1e-12)


def test_motions_are_those_of_the_modes() -> None:
    """The same equilibrium and the same Jacobian as the stability tables."""
    case = rr.load_case("bogie_rollers_constant")
    system = LinearBench(case, 60.0).system(["wheelset_1.axle_torque"], ["wheelset_1.lateral"])
    expected = Lineariser(case).at(60.0).matrix
    np.testing.assert_allclose(system.a, expected, atol=1e-6 * np.abs(expected).max())


def test_samples_are_those_of_the_continuous_system_held_and_late(bench: LinearBench) -> None:
    """Far below the sampling frequency a hold is half a step late; the rest is its sinc, 1e-3 here at most."""
    frequencies = np.geomspace(0.5, 15.0, 12)
    late = bench.case.rig_control.delay + 0.5 * bench.case.time.sampling_step
    continuous = bench.system([COMMAND], [SPEED]).response(frequencies)[:, 0, 0]
    sampled = bench.system([COMMAND], [SPEED], discrete=True).response(frequencies)[:, 0, 0]
    np.testing.assert_allclose(sampled, continuous * np.exp(-2j * math.pi * frequencies * late), rtol=1e-3)


def test_a_torque_command_turns_axle_and_roller_together_in_the_end(bench: LinearBench) -> None:
    """Slowly, both turn as one: torque over R accelerates the inertias of one axle, its twin, and what they drag along."""
    frequency = 0.02
    response = bench.system([COMMAND], [SPEED, "wheelset_1.roller_speed"]).response([frequency])[0, :, 0]
    ratio = bench.case.support.data.roller_radius / bench.case.vehicle.data.wheel.radius
    assert abs(response[0] / response[1]) == pytest.approx(ratio, rel=0.01)


def test_python_control_gets_names_and_the_same_response(bench: LinearBench) -> None:
    system = rr.linearize(
        bench.case, inputs=[COMMAND], outputs=[SPEED, "wheelset_1_left.vertical_force"], discrete=True
    )
    assert isinstance(system, control.StateSpace)
    assert system.input_labels == [COMMAND.replace(".", "/")]
    assert system.output_labels == [SPEED.replace(".", "/"), "wheelset_1_left/vertical_force"]
    assert system.dt == bench.case.time.sampling_step
    own = bench.system([COMMAND], [SPEED, "wheelset_1_left.vertical_force"], discrete=True)
    at = system(np.exp(2j * math.pi * 5.0 * system.dt))
    np.testing.assert_allclose(at, own.response([5.0])[0], rtol=1e-9)


def test_without_python_control_it_is_a_dataset(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(linear_bench, "find_spec", lambda _: None)
    system = rr.linearize("bogie_rollers_constant", 50.0, ["wheelset_1.axle_torque"], ["wheelset_1.lateral"])
    assert isinstance(system, xr.Dataset)
    assert system["B"].sel(state="wheelset_1.pitch_rate", input="wheelset_1.axle_torque") > 0.0
    assert str(system["output_unit"].sel(output="wheelset_1.lateral").values) == "m"


def test_matlab_file(bench: LinearBench) -> None:
    system = bench.system([COMMAND], [SPEED], discrete=True)
    content = system.mat_bytes()
    assert content == system.mat_bytes()
    read = scipy.io.loadmat(io.BytesIO(content))
    np.testing.assert_array_equal(read["A"], system.a)
    assert read["InputName"][0, 0].item() == COMMAND
    assert float(read["Ts"].item()) == bench.case.time.sampling_step


@pytest.mark.parametrize(
    ("inputs", "outputs", "message"),
    [
        (
            ["wheelset_1.roler_torque_command"],
            [SPEED],
            r"inputs: 'wheelset_1.roler_torque_command'; allowed: .*did you mean",
        ),
        ([COMMAND], ["wheelset_1.axle_sped"], r"outputs: .*did you mean 'wheelset_1.axle_speed'"),
        ([], [SPEED], r"inputs: none; allowed: wheelset_1.roller_torque_command, "),
        ([COMMAND, COMMAND], [SPEED], "each name once"),
    ],
)
def test_wrong_names_are_refused_with_a_guess(
    bench: LinearBench, inputs: list[str], outputs: list[str], message: str
) -> None:
    with pytest.raises(ConfigError, match=message) as raised:
        bench.system(inputs, outputs)
    assert "\n" not in str(raised.value)


def test_a_case_without_motors_has_axle_torques() -> None:
    """Brakes alone, on track and on the rig: the torque of an axle turns it by its inertia, as that of a motor does."""
    brakes = rr.load_case("adhesion_brake")
    for case in (on_track(brakes), brakes):
        bench = LinearBench(case, 20.0)
        system = bench.system(["wheelset_1.axle_torque"], ["wheelset_1.pitch_acceleration"])
        inertia = case.vehicle.data.body_named("wheelset_1").inertia[1]
        assert system.d[0, 0] == pytest.approx(1.0 / inertia, rel=1e-6)


def test_wrong_speed_and_missing_samples_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"motion.speed"):
        LinearBench(rr.load_case("bogie_rollers_constant"), 1e4)
    with pytest.raises(ConfigError, match="discrete"):
        rr.linearize("bogie_track", None, ["wheelset_1.axle_torque"], ["wheelset_1.lateral"], discrete=True)


def test_zeros_and_poles_of_a_known_system(bench: LinearBench) -> None:
    """(s + 2) / ((s + 1)(s + 5)), also from its samples."""
    a, b = np.array([[-1.0, 0.0], [0.0, -5.0]]), np.array([[0.25], [0.75]])
    c, d = np.array([[1.0, 1.0]]), np.zeros((1, 1))
    known = bench.system([COMMAND], [SPEED])
    known = type(known)("known", 0.0, 0.0, a, b, c, d, ("p", "q"), ("u",), ("y",), ("1",), ("1",))
    np.testing.assert_allclose(known.poles(), [-5.0, -1.0])
    np.testing.assert_allclose(known.zeros(), [-2.0])
    np.testing.assert_allclose(known.sampled(0.01).poles(), [-5.0, -1.0])
    late = known.sampled(0.01).delayed([3]).response([1.0])[0, 0, 0]
    held = known.sampled(0.01).response([1.0])[0, 0, 0]
    assert late == pytest.approx(held * np.exp(-2j * math.pi * 0.03))


def test_margins_of_a_known_loop() -> None:
    """L = 4 / (s + 1)^3: phase -pi at sqrt 3 rad/s where |L| is 1/2; |L| = 1 at w^2 = 4^(2/3) - 1."""
    frequencies = np.geomspace(1e-3, 10.0, 4000)
    found = margins_of(frequencies, 4.0 / (2j * math.pi * frequencies + 1.0) ** 3)
    assert found.gain == pytest.approx(2.0, rel=1e-4)
    assert found.gain_frequency == pytest.approx(math.sqrt(3.0) / (2 * math.pi), rel=1e-4)
    crossover = math.sqrt(4.0 ** (2.0 / 3.0) - 1.0)
    assert found.phase_frequency == pytest.approx(crossover / (2 * math.pi), rel=1e-4)
    assert found.phase == pytest.approx(math.pi - 3.0 * math.atan(crossover), rel=1e-3)
