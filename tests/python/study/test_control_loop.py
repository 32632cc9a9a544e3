"""The linear loop of the roller drives: against closed forms, against continuous time, and against runs of the core."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.signal import butter, sosfiltfilt

from rollerrig import load_case, simulate
from rollerrig.analysis.control_loop import Loop, Wheel, creep_slope, loop_of, margins, users_loop, wheel_of
from rollerrig.analysis.loop_stability import (
    ABOVE,
    Plant,
    gain_limit,
    growth,
    rolling_plant,
    sampled_matrix,
    vehicle_plant,
)
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.config import Case
from rollerrig.simulation.mechatronics import feedback_gains
from rollerrig.study.runs.control import SLOW_GROWTH, loop_case, loop_numbers, users_motion

WHEEL = Wheel(wheelset_inertia=112.0, roller_inertia=705.0, wheel_radius=0.46, roller_radius=0.725)
ROLLING = 1e9  # creep so stiff that wheel and roller are one [N s/m]
HZ = 2.0 * math.pi
INERTIA = WHEEL.wheelset_inertia + WHEEL.roller_inertia * WHEEL.ratio**2


def gains(bandwidth: float, damping: float) -> tuple[float, float]:
    """(D6), an independent copy: for wheel and roller as one inertia and a bandwidth [rad/s]."""
    return 2.0 * damping * bandwidth * INERTIA / WHEEL.ratio, bandwidth**2 * INERTIA / WHEEL.ratio


EXCITED = {
    "slide_protection": None,
    "time.duration": 4.0,
    "time.output_step": 1e-3,
    "brake.demand": [[0.0, 0.0], [0.2, 0.0], [0.21, "0.2 bar"]],
}
"""A light brake application excites the loop."""
WINDOW = 0.1  # of the RMS values from which a growth rate is measured [s]
LEAST_WINDOWS = 4  # that it takes
LINEAR_RANGE = (1e-10, 2e-2)  # tracking errors between rounding and saturation of torque and adhesion [rad/s]


def measured_growth(error: xr.DataArray, begin: float) -> tuple[float, float, bool]:
    """Rate [1/s] and frequency [Hz] at which the tracking error of a run grows above ABOVE, NaN: it does not; unstable or not.

    Of virtual less real speeds [rad/s] over evenly spaced `time` [s], then axle, from `begin` [s] on.
    """
    step = float(error["time"][1] - error["time"][0])
    sos = butter(8, ABOVE, "highpass", fs=1.0 / step, output="sos")
    high = sosfiltfilt(sos, error.to_numpy(), axis=0)[round(begin / step) :]
    window = round(WINDOW / step)
    count = len(high) // window
    size = np.sqrt(np.mean(high[: count * window].reshape(count, window, -1) ** 2, axis=(1, 2)))
    linear = (size < LINEAR_RANGE[1]) & (size > 3.0 * max(float(size[:-2].min()), LINEAR_RANGE[0]))
    linear[-2:] = False  # the filter's end
    parts = np.split(np.flatnonzero(linear), np.flatnonzero(np.diff(np.flatnonzero(linear)) > 1) + 1)
    late = next((part for part in reversed(parts) if len(part) >= LEAST_WINDOWS), parts[-1])[-12:]
    saturated = float(size[-3]) > 0.1 * LINEAR_RANGE[1]  # from the start
    if len(late) < LEAST_WINDOWS:
        return math.nan, math.nan, saturated
    rate = float(np.polyfit((late + 0.5) * window * step, np.log(size[late]), 1)[0])
    piece = high[late[0] * window : (late[-1] + 1) * window]
    steady = piece[:, int(np.argmax(np.abs(piece).max(axis=0)))] * np.exp(-rate * step * np.arange(len(piece)))
    power = np.abs(np.fft.rfft(steady * np.hanning(len(steady)), 8 * len(steady)))
    frequency = float(np.argmax(power) / (8 * len(steady) * step))
    grows = rate > 0.0 and frequency > ABOVE
    return (rate, frequency, True) if grows else (math.nan, math.nan, saturated)


def excited(case: Case, loop: Loop) -> tuple[float, float, bool]:
    """Growth of a run of a case with the gains of a loop."""
    gains = {f"rig_control.feedback.{name}": getattr(loop, name) for name in ("proportional", "integral")}
    run = simulate(case.with_changes({**EXCITED, **gains}))
    return measured_growth(run["virtual_speed"] - run["axle_speed"], 0.3)


def loop(creep: float = ROLLING, **changes: object) -> Loop:
    """A PI loop of 0.7 Hz whose estimator filters force and acceleration alike, so that feed-forward sees no drive."""
    plain = {"estimator.kind": "filtered_derivative", "axle_torque.kind": "estimated", "drive_command.kind": "direct"}
    given = {key.replace("__", "."): value for key, value in changes.items()}
    case = load_case("adhesion_brake").with_changes({"time.sampling_step": given.get("sample_time", 1e-3)})
    case = case.with_changes({f"rig_control.{key}": value for key, value in {**plain, **given}.items()})
    made = loop_of(case, creep, sliding=True)
    assert made is not None
    return made


def test_margins_are_those_of_the_closed_form() -> None:
    found, made = margins(loop()), loop()
    lag = 1.0 / made.drive_bandwidth + 0.5 * made.sample
    w, zeta = 0.7 * HZ, 0.7
    crossover = w * math.sqrt(2.0 * zeta**2 + math.sqrt(4.0 * zeta**4 + 1.0))  # (Q2)
    phase = math.atan(2.0 * zeta * crossover / w) - crossover * lag
    # A lag of first order is a delay but for (w/w_d)^3/3, here 3e-6; the table of frequencies is 0.4 % fine.
    assert 2.0 * math.pi * found.phase_frequency == pytest.approx(crossover, rel=1e-3)
    assert found.phase == pytest.approx(phase, abs=1e-3)


def test_slow_drives_are_unstable_where_routh_says() -> None:
    """s^2 (1 + s/w_d) + 2 zeta w s + w^2 is stable where w_d > w / (2 zeta): 0.5 Hz here."""
    limit = 0.7 / (2.0 * 0.7) * HZ
    # Sampling adds half a sample of delay: 0.03 % of the margin.
    for factor, unstable in ((0.95, True), (1.05, False)):
        slow = loop(1e7, motor__bandwidth=factor * limit / HZ, sample_time=1e-4)
        assert (growth(slow, rolling_plant(slow))[0] > 0.0) == unstable, factor


@pytest.mark.parametrize("delay", [0.0, 4e-3])
def test_the_sampled_loop_is_unstable_from_the_gain_margin_on(delay: float) -> None:
    """Sampling as a delay of half a sample holds while the oscillation, 60 to 130 Hz, is slow against 1 kHz: within 3 %."""
    creep = 657600.0
    made = loop(creep, delay=delay)
    assert gain_limit(made, rolling_plant(made)) == pytest.approx(margins(made).gain, rel=0.03)


def test_poles_of_the_sampled_loop_are_those_that_the_gains_were_made_for() -> None:
    fast = loop(1e7, motor__bandwidth=2000.0, sample_time=1e-4)
    values = np.log(np.linalg.eigvals(sampled_matrix(fast, rolling_plant(fast))).astype(complex) + 1e-300) / 1e-4
    wanted = 0.7 * HZ * complex(-0.7, math.sqrt(1.0 - 0.49))
    nearest = values[np.argmin(abs(values - wanted))]
    assert abs(nearest - wanted) < 2e-3 * abs(wanted)  # lag of 0.13 ms at 4.4 rad/s


def test_an_inertia_assumed_too_large_is_unstable_by_feed_forward() -> None:
    """Feed-forward over assumed less real inertia is a loop of its own, of gain (J^/J - 1) J_r rho^2 / J_w: 1 at 39 %."""
    limit = WHEEL.wheelset_inertia / (WHEEL.roller_inertia * WHEEL.ratio**2) * INERTIA
    for factor, unstable in ((0.8, False), (1.2, True)):
        # Given to the wheelset alone, so that force and roller torque stay right.
        heavy = WHEEL.wheelset_inertia + factor * limit
        made = loop(1e7, assumed__wheelset_inertia=heavy, feedback__kind="none")
        assert (growth(made, rolling_plant(made))[0] > 1e-3) == unstable, factor


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["observer", "filtered_derivative", "kalman"])
def test_computed_growth_is_that_of_excited_runs(kind: str) -> None:
    """The bogie's longitudinal spring-mass mode near 27 Hz grows from 13 times the gains on; wheel and roller alone do not."""
    case = loop_case(load_case("adhesion_brake").with_changes({"rig_control.estimator.kind": kind}))
    made, vehicle = loop_of(case, creep_slope(case), sliding=False), vehicle_plant(case)
    assert made is not None
    for factor in (32.0, 50.8):
        scaled = made.scaled(factor)
        rate, frequency, _ = excited(case, scaled)
        # The two axles' loads, and so their creep, differ once the brake pitches the frame; speed falls by 0.1 %.
        assert growth(scaled, vehicle, ABOVE) == (pytest.approx(rate, abs=0.5), pytest.approx(frequency, rel=0.01)), (
            factor
        )
        assert not growth(scaled, rolling_plant(scaled), ABOVE)[0] > 0.0
    stable = made.scaled(8.0)
    assert growth(stable, vehicle, ABOVE)[0] < 0.0
    assert not excited(case, stable)[2]


def test_the_limit_lies_between_stable_and_unstable_runs() -> None:
    case = loop_case(load_case("adhesion_brake"))
    made, numbers = loop_of(case, creep_slope(case), sliding=False), loop_numbers(case, None)
    assert made is not None
    assert numbers is not None
    limit = numbers["unstable_from_factor"]
    for factor in (12.7, 16.0, 20.2):
        assert excited(case, made.scaled(factor))[2] == (factor > limit), factor


def test_the_core_is_given_the_gains_of_the_closed_form() -> None:
    """(D6) for the shipped case, from its own numbers: 0.7 Hz, damping 0.7."""
    found = feedback_gains(assemble_with_actuators(load_case("adhesion_brake")))
    assert wheel_of(load_case("adhesion_brake")) == WHEEL
    assert found == pytest.approx(gains(0.7 * HZ, 0.7), rel=1e-12)


@pytest.mark.parametrize("layer", [0.5, 1e-6])
def test_a_sliding_mode_is_proportional_within_its_boundary_layer(layer: float) -> None:
    proportional = loop(feedback={"proportional": 4e3, "integral": 0.0})
    thin = loop(feedback={"kind": "sliding_mode", "switching": 4e3 * layer, "boundary_layer": layer})
    limits = [gain_limit(made, rolling_plant(made)) for made in (thin, proportional)]
    assert limits[0] == pytest.approx(limits[1], rel=1e-9)


USERS = """
import math
import numpy as np

class Ours:
    sample_time = 1e-3
    sum = 0.0

    def feedback(self, error):
        self.sum = self.sum + self.sample_time * error
        return {proportional} * error + {integral} * self.sum

    def step(self, measurements):
        error = measurements["virtual_speed"] - measurements["axle_speed"]
        return {{"roller_torque": measurements["feed_forward"] + self.feedback(error)}}

class Delayed(Ours):
    def __init__(self):
        self.waiting = [0.0] * 10

    def feedback(self, error):
        self.waiting.append(super().feedback(error))
        return self.waiting.pop(0)

class Switching(Ours):
    def feedback(self, error):
        return 500.0 * np.sign(error)

class Alternating(Ours):
    count = 0

    def feedback(self, error):
        self.count += 1
        return self.count % 2 * 2e4 * error

class Later(Ours):
    count = 0

    def feedback(self, error):
        self.count += 1
        return super().feedback(error) * (self.count < 300)

class DeadBand(Ours):
    def feedback(self, error):
        return super().feedback(np.sign(error) * np.maximum(np.abs(error) - 2e-3, 0.0))

class Rounding(Ours):
    def step(self, measurements):
        return {{"roller_torque": super().feedback(np.round(measurements["axle_speed"], 1))}}

class Growing(Ours):
    own = 0.0

    def feedback(self, error):
        self.own = -1.2 * self.own + error
        return {proportional} * error + self.own

class Failing(Ours):
    def feedback(self, error):
        return math.nan * error

class SlowlyUnstable(Ours):
    def feedback(self, error):
        self.sum = 1.01 * self.sum + self.sample_time * error
        return {proportional} * error + {integral} * self.sum
"""


def users(folder: Path, name: str, ours: Loop) -> Case:
    """A case with a class above, with the gains of ours."""
    file = folder / "users.py"
    file.write_text(USERS.format(proportional=ours.proportional, integral=ours.integral))
    return loop_case(load_case("adhesion_brake")).with_changes({"rig_control.user": f"{file}:{name}"})


def built_in(**changes: object) -> tuple[Loop, Plant]:
    case = loop_case(load_case("adhesion_brake"))
    made = loop_of(
        case.with_changes({f"rig_control.{key}": value for key, value in changes.items()}), 1e6, sliding=False
    )
    assert made is not None
    return made.scaled(20.0), vehicle_plant(case)


def test_a_users_controller_has_the_motions_of_ours_with_the_same_law(tmp_path: Path) -> None:
    ours, vehicle = built_in()
    found = users_motion(users(tmp_path, "Ours", ours), 1e6)
    assert (found["vehicle_rate"], found["vehicle_hz"]) == pytest.approx(growth(ours, vehicle, ABOVE), rel=1e-4)


@pytest.mark.slow
def test_a_users_controller_may_delay_its_feedback(tmp_path: Path) -> None:
    """All of the command by 10 samples, but for the feed-forward, which only decides how slow motions follow."""
    ours, vehicle = built_in()
    found = users_loop(users(tmp_path, "Delayed", ours), 1e6)
    n, inputs = len(ours.controller) - ours.axles, ours.controller.shape[1] - len(ours.controller) + ours.axles
    states = n + 10 * ours.axles  # those of ours, then the commands of the feedback that wait, the oldest first
    matrix = np.zeros((states + ours.axles, states + inputs))
    old = np.r_[0:n, states : states + inputs]
    matrix[:n, old] = ours.controller[:n]
    matrix[states - ours.axles : states, old] = ours.feedback[n:]
    matrix[n : states - ours.axles, n + ours.axles : states] = np.eye(states - n - ours.axles)
    matrix[states:, old] = ours.controller[n:] - ours.feedback[n:]
    matrix[states:, n : n + ours.axles] += np.eye(ours.axles)
    delayed = replace(ours, controller=matrix)
    assert growth(found, vehicle, ABOVE) == pytest.approx(growth(delayed, vehicle, ABOVE), rel=1e-3)


@pytest.mark.slow
def test_a_users_controller_that_grows_slowly_is_not_called_stable(tmp_path: Path) -> None:
    found = users_motion(users(tmp_path, "SlowlyUnstable", built_in()[0].scaled(0.05)), 1e6)
    assert found["vehicle_rate"] > SLOW_GROWTH
    assert found["vehicle_hz"] < ABOVE


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("Switching", "from linear answers"),
        ("Alternating", "from linear answers"),
        ("Later", "from linear answers"),
        ("DeadBand", "from linear answers"),
        ("Rounding", "answers no small change"),
        ("Growing", "grows by itself"),
        ("Failing", r"t = 0 s, rig_control, controller Failing: roller_torque = \[nan, nan\]"),
    ],
)
def test_what_is_not_linear_has_no_motions(name: str, why: str, tmp_path: Path) -> None:
    found = users_motion(users(tmp_path, name, built_in()[0]), 1e6)
    assert re.search(why, found["no_loop"])
    assert math.isnan(found["vehicle_rate"])


def test_a_users_controller_is_not_ours() -> None:
    case = load_case("adhesion_brake").with_changes({"rig_control.user": "mine:Mine"})
    assert loop_of(case, 1e6, sliding=True) is None


@pytest.mark.parametrize("rate", [3.0, 8.0])
def test_rate_and_frequency_of_a_growing_oscillation(rate: float) -> None:
    time = np.arange(0.0, 4.0, 1e-3)
    growing = 1e-9 * np.exp(rate * time) * np.sin(HZ * 27.0 * time)
    slow = 1e-4 * np.exp(-time) * np.sin(HZ * 1.0 * time)
    error = xr.DataArray((growing + slow)[:, None] * [1.0, 0.5], {"time": time}, ("time", "axle"))
    found = measured_growth(error, 0.3)
    assert found[0] == pytest.approx(rate, abs=0.1)  # tenths of a second hold no whole number of periods
    assert found[1] == pytest.approx(27.0, abs=0.1)


def test_a_rotor_counts_in_the_gains_but_the_plant_has_none() -> None:
    case = load_case("adhesion_brake")
    geared = case.with_changes({"rig_control.motor.rotor_inertia": 2.0, "rig_control.motor.gear_ratio": 3.0})
    assert wheel_of(geared).roller_inertia == pytest.approx(wheel_of(case).roller_inertia + 18.0)
    assert loop_of(geared, 1e6, sliding=True) is None
