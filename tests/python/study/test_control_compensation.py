"""Ways to compensate the lags, compared with the track: the dead time that is left, and the words about it."""

from __future__ import annotations

import pytest

from rollerrig import load_case
from rollerrig.study import lag_compensation as module
from rollerrig.study.control import study_case
from rollerrig.study.ensemble import Estimate, measured_dead_time
from rollerrig.study.lag_compensation import VARIANTS, compensation_cases


def test_every_variant_is_a_case_and_a_case_without_slide_protection_has_none() -> None:
    case = study_case(load_case("adhesion_brake"), 5.0)
    cases = compensation_cases(case)
    assert len({one.to_toml() for one in cases.values()}) == len(cases)
    assert set(VARIANTS) < set(cases)
    assert compensation_cases(case.with_changes({"slide_protection": None})) == {}
    exact = compensation_cases(case.with_changes({"rig_control.estimator": "exact"}))
    assert "estimator with 100 Hz" not in exact


@pytest.mark.slow
def test_pressure_and_lead_take_the_lag_away(monkeypatch: pytest.MonkeyPatch) -> None:
    """In the first 10 s, with ellipses; the whole stop with the default contact is a long test of test_lag_compensation.py."""
    monkeypatch.setattr(module, "STARTS", 2)
    monkeypatch.setattr(module, "DEAD_TIMES", (10e-3, 20e-3))
    kept = ("no compensation", "pressure, and lead")
    monkeypatch.setattr(module, "VARIANTS", {label: VARIANTS[label] for label in kept})
    case = load_case("adhesion_brake").with_changes({"time.duration": "10 s", "contact.normal": "hertz"})
    jobs = module.compensation_jobs(case)
    assert len(jobs) == 2 * 5
    done = {name: work.function(*work.arguments) for name, work in jobs.items()}
    numbers = module.compensation_numbers(case, done)
    assert numbers is not None
    none, best = (numbers[label] for label in kept)
    assert numbers["track"]["measured_ms"] == 0.0
    assert none["predicted_ms"] == pytest.approx(11.7, abs=0.1)
    assert none["measured_ms"] == pytest.approx(
        none["predicted_ms"], abs=4.0
    )  # of two starts, between two dead times of the track
    assert best["predicted_ms"] == pytest.approx(-0.5, abs=1e-9)
    assert abs(best["measured_ms"]) < 3.0
    # Ventings on the track's line, as the adhesion study reads distances on it.
    tracks = {d: numbers["track" if not d else f"track, {1e3 * d:g} ms more dead time"] for d in (0.0, 10e-3, 20e-3)}
    curve = {d: Estimate(one["dump_cycles"], one["dump_cycles_standard_error"], 1.0) for d, one in tracks.items()}
    own = Estimate(none["dump_cycles"], none["dump_cycles_standard_error"], 1.0)
    assert none["measured_ms"] == pytest.approx(1e3 * measured_dead_time(own, curve).mean)
    assert "acts like a track" in module.compensation_text(numbers)
    assert module.compensation_numbers(case, {}) is None
