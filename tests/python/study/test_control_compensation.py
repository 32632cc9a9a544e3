"""Ways to compensate the lags, compared with the track: the dead time that is left, and the words about it."""

from __future__ import annotations

import math

import pytest

from rollerrig import load_case
from rollerrig.study import control_compensation as module
from rollerrig.study.control import study_case
from rollerrig.study.control_compensation import VARIANTS, compensation_cases, dead_time


def ensemble(cycles: float, error: float = 0.0) -> dict[str, float]:
    return {"dump_cycles": cycles, "dump_cycles_standard_error": error}


TRACKS = [ensemble(300.0), ensemble(260.0), ensemble(200.0)]
ADDED = (0.0, 4.0, 10.0)


@pytest.mark.parametrize(
    ("cycles", "milliseconds"), [(300.0, 0.0), (280.0, 2.0), (260.0, 4.0), (230.0, 7.0), (310.0, -1.0), (200.0, 10.0)]
)
def test_dead_time_is_read_on_the_track_s_line(cycles: float, milliseconds: float) -> None:
    assert dead_time(ensemble(cycles), TRACKS, ADDED)[0] == pytest.approx(milliseconds)


def test_its_error_is_that_of_the_rig_and_of_the_tracks_beside_it() -> None:
    """10 dump cycles a millisecond: an error of 5 of the rig is half a millisecond."""
    assert dead_time(ensemble(280.0, 5.0), TRACKS, ADDED)[1] == pytest.approx(0.5)
    uncertain = [ensemble(300.0, 6.0), ensemble(260.0, 8.0), ensemble(200.0)]
    assert dead_time(ensemble(280.0), uncertain, ADDED)[1] == pytest.approx(math.hypot(3.0, 4.0) / 10.0)
    assert all(map(math.isnan, dead_time(ensemble(150.0), TRACKS, ADDED)))  # beyond what was run


def test_every_variant_is_a_case_and_a_case_without_slide_protection_has_none() -> None:
    case = study_case(load_case("adhesion_brake"), 5.0)
    cases = compensation_cases(case)
    assert len({repr(one) for one in cases.values()}) == len(cases)
    assert set(VARIANTS) < set(cases)
    assert compensation_cases(case.with_changes({"slide_protection": None})) == {}
    exact = compensation_cases(case.with_changes({"rig_control.estimator": "exact"}))
    assert "estimator with 100 Hz" not in exact


def test_pressure_and_lead_take_the_lag_away(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "STARTS", 3)
    monkeypatch.setattr(module, "DEAD_TIMES", (10e-3, 30e-3))
    kept = ("no compensation", "pressure, and lead")
    monkeypatch.setattr(module, "VARIANTS", {label: VARIANTS[label] for label in kept})
    case = load_case("adhesion_brake")
    jobs = module.compensation_jobs(case)
    assert len(jobs) == 3 * 5
    done = {name: work.function(*work.arguments) for name, work in jobs.items()}
    numbers = module.compensation_numbers(case, done)
    assert numbers is not None
    none, best = (numbers[label] for label in kept)
    assert numbers["track"]["measured_ms"] == 0.0
    assert none["predicted_ms"] == pytest.approx(11.7, abs=0.1)
    assert none["measured_ms"] == pytest.approx(
        none["predicted_ms"], abs=4.0
    )  # of three starts, between two dead times of the track
    assert best["predicted_ms"] == pytest.approx(0.0, abs=1e-9)
    assert abs(best["measured_ms"]) < 3.0
    assert "acts like a track" in module.compensation_text(numbers)
    assert module.compensation_numbers(case, {}) is None
