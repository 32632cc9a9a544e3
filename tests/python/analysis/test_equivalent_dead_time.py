"""Equivalent dead time: its closed form, how it is read off the track's curve, and that the rig does act like that track."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rollerrig import load_case
from rollerrig.analysis.equivalent_dead_time import at_track_of, lags, predicted_dead_time
from rollerrig.analysis.slide_statistics import test_record as record_of
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.config import Case, Rig
from rollerrig.simulation.run import simulate
from rollerrig.study.ensemble import Estimate, dead_times, estimate, later_protection, measured_dead_time, starts
from rollerrig.study.runs.adhesion import track_case

TOLERANCE = 0.005
"""Of the distance: 4 ms of dead time, half of what the rig has."""


def brake(**changes: object) -> Case:
    """The brake test of a rig that does not compensate its lags; ellipses, since the lags are none of the contact's."""
    late = {"rig_control.axle_torque": "estimated", "rig_control.drive_command": "direct", "contact.normal": "hertz"}
    return load_case("adhesion_brake").with_changes({**late, **changes})


def test_its_parts_are_the_lags_and_its_share_the_inertias() -> None:
    found, case = predicted_dead_time(brake()), brake()
    assert found is not None
    assert found.total == pytest.approx(lags(assemble_with_actuators(case)).total)
    rig = case.support.data
    assert isinstance(rig, Rig)
    k = rig.roller_inertia[1] * (0.46 / rig.roller_radius) ** 2 / 112.0
    assert found.least == pytest.approx(k / (1.0 + k) * found.total)


def test_a_wheel_that_slides_is_late_by_the_least_of_it() -> None:
    """(Q7) integrated: under a step of C at constant T_v the speed is that of an undelayed wheel k/(1+k) tau before."""
    found = predicted_dead_time(brake())
    assert found is not None
    share, tau, h = found.late_share, found.total, 1e-6
    time = np.arange(0.0, 0.05, h)
    speed = np.cumsum((1.0 - share) + share * (time >= tau)) * h
    assert time[-1] - speed[-1] == pytest.approx(found.least, abs=3.0 * h)


def test_the_compensated_rig_is_half_a_sample_ahead() -> None:
    """(D22), so that the switching of valves is not late."""
    found = predicted_dead_time(load_case("adhesion_brake"))
    assert found is not None
    assert found.total == pytest.approx(-0.5e-3, abs=1e-9)
    assert dead_times(load_case("adhesion_brake"), found) == pytest.approx((2e-3, 4e-3, 6e-3))


def test_it_is_read_off_the_curve_of_the_track_with_its_error() -> None:
    track = {0.0: 950.0, 5e-3: 945.0, 10e-3: 940.0, 15e-3: 920.0}
    assert at_track_of(942.0, track) == pytest.approx((8e-3, -1000.0))
    assert at_track_of(951.0, track) == pytest.approx((-1e-3, -1000.0))  # a rig may be ahead
    assert all(map(math.isnan, at_track_of(956.0, track)))
    assert all(map(math.isnan, at_track_of(919.0, track)))
    found = measured_dead_time(Estimate(942.0, 1.0, 7.0), {d: Estimate(x, 0.5, 7.0) for d, x in track.items()})
    assert found.mean == pytest.approx(8e-3)
    assert found.standard_error == pytest.approx(math.hypot(1.0, 0.4 * 0.5, 0.6 * 0.5) / 1000.0)


def test_a_rig_that_is_late_by_a_known_time_is_measured_right() -> None:
    """A straight curve and normal scatter: 95 % of the intervals hold the truth, to three deviations of such a count."""
    generator, held = np.random.default_rng(5), 0
    for _ in range(400):
        track = {d: estimate(generator.normal(950.0 - 1200.0 * d, 1.0, 8).tolist()) for d in (0.0, 6e-3, 12e-3, 18e-3)}
        interval = measured_dead_time(estimate(generator.normal(950.0 - 12.0, 1.0, 8).tolist()), track).interval
        held += interval.low < 10e-3 < interval.high
    assert held / 400 > 0.95 - 3.0 * math.sqrt(0.05 * 0.95 / 400)


def test_the_track_is_run_around_the_predicted_dead_time() -> None:
    case = brake()
    found = predicted_dead_time(case)
    assert found is not None
    delays = dead_times(case, found)
    assert delays[0] < found.least < found.total < delays[-1]
    later = later_protection(track_case(case), delays[0]).slide_protection
    assert later is not None
    assert later.delay == pytest.approx(1e-3 + delays[0])
    assert dead_times(case, None) == ()


def mean_distance(case: Case, dead_time: float, count: int) -> float:
    cases = starts(case.with_changes({"slide_protection.delay": dead_time}), count)
    return float(np.mean([record_of(simulate(one), one).measures["distance_m"] for one in cases]))


def check(law: dict[str, object], dead_times_ms: tuple[int, ...], count: int, *, middle: bool = True) -> None:
    """The rig with dead time d stops where the track does with dead times from d + (Q8) to d + (Q7), their middle included."""
    case = brake(**{"contact.creep": law})
    found = predicted_dead_time(case)
    assert found is not None
    low, high = math.floor(1e3 * found.least), math.ceil(1e3 * found.total)
    lags_of_track = (low, (low + high) // 2, high) if middle else (low, high)
    for d in dead_times_ms:
        rig = mean_distance(case, 1e-3 * d, count)
        track = [mean_distance(track_case(case), 1e-3 * (d + lag), count) for lag in lags_of_track]
        assert (1.0 - TOLERANCE) * min(track) < rig < (1.0 + TOLERANCE) * max(track), d


PAPER: dict[str, object] = {"kind": "kalker_saturated"}
POLACH: dict[str, object] = {"kind": "polach", "k_A": 1.0, "k_S": 1.0}


@pytest.mark.slow  # three stops
def test_the_rig_acts_like_a_track_with_later_protection() -> None:
    check(PAPER, (21,), 1, middle=False)


@pytest.mark.long  # 150 stops a law
@pytest.mark.parametrize("law", [PAPER, POLACH], ids=["paper", "polach"])
def test_it_does_at_every_dead_time(law: dict[str, object]) -> None:
    """Up to 16 ms the limit cycles on track change their form, and the distance falls steeply: the range of both is needed."""
    check(law, (1, 5, 11, 21, 31, 51), 6)
