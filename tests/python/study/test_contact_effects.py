"""What the contact model changes: a job for every normal contact and creep law, on rig and track."""

from __future__ import annotations

import math

import pytest

from rollerrig.analysis.critical_speed import scan_linear
from rollerrig.analysis.limit_cycle_runs import LimitCycleSettings
from rollerrig.config import load_case
from rollerrig.study import stability
from rollerrig.study.stability import COUNTERPART, contact_effect_jobs


def test_jobs_are_those_of_the_cases_with_each_contact(monkeypatch: pytest.MonkeyPatch) -> None:
    # not settled by then: the critical speeds are checked here, not the limit cycle
    monkeypatch.setattr(stability, "CONTACT_SETTINGS", LimitCycleSettings(longest=2.0))
    case, speeds = load_case("bogie_track"), [200.0, 300.0]
    jobs = contact_effect_jobs(case, speeds, 200.0, creeps=["kalker_saturated"])
    assert list(jobs) == [
        f"contact model {support}, {normal}, kalker_saturated"
        for support in ("track", "rig")
        for normal in ("hertz", "strips")
    ]
    hertz, strips = (job.function(*job.arguments) for job in list(jobs.values())[:2])
    same = case.with_changes({"contact.normal": "strips", "contact.creep": "kalker_saturated"})
    assert strips["linear_critical_speed_kmh"] == pytest.approx(scan_linear(same, speeds).speed_kmh, abs=1e-6)
    assert strips["linear_critical_speed_kmh"] == pytest.approx(251.2, abs=0.2)
    # Hertz' two ellipses of the middle hold the bogie longer than the one patch there is: 310 km/h, outside the range.
    assert math.isnan(hertz["linear_critical_speed_kmh"])
    names = ("support", "normal", "creep", "run_speed_kmh")
    assert tuple(strips[name] for name in names) == ("track", "strips", "kalker_saturated", 200.0)


def test_each_kind_of_support_has_a_counterpart() -> None:
    for kind, (other, support) in COUNTERPART.items():
        case = load_case("bogie_track").with_changes({"support.use": support})
        assert case.support.data.kind == other != kind
