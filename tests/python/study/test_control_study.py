"""`rollerrig control`: variants, where a curve breaks, the files, and what is refused."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

from rollerrig import ConfigError, load_case
from rollerrig.config import Case
from rollerrig.config.schema.rig_control import Estimator, Feedback
from rollerrig.studies.control import (
    FAMILIES,
    Study,
    chosen_families,
    compare_controllers,
    lead,
    study_case,
    write_control,
)
from rollerrig.studies.control.compute import (
    LOST,
    LOST_RIPPLE,
    RESULT_KEYS,
    Result,
    Variant,
    breaks,
    ranking,
    ripple_of,
    run_variant,
)
from rollerrig.studies.control.families import USER, Family

MINE = """
class FeedForward:
    sample_time = 1e-3

    def step(self, measurements):
        return {"roller_torque": measurements["feed_forward"]}
"""


def brake(duration: float = 3.0) -> Case:
    return study_case(load_case("adhesion_brake"), duration)


def family(name: str, values: tuple[float, ...], *curves: str) -> Family:
    found = next(f for f in FAMILIES if f.name == name)
    return replace(found, values=values, curves={key: found.curves[key] for key in curves or found.curves})


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    file = tmp_path_factory.mktemp("mine") / "mine.py"
    file.write_text(MINE)
    families = [
        family("drive_bandwidth", (0.2, 5.0, 50.0), "PI", "no feedback"),
        family("wrong_belief", (-5.0, 0.0, 5.0), "wheel radius", "roller inertia"),
    ]
    found = compare_controllers(brake(5.0), families=families, user=f"{file}:FeedForward", limits=False, processes=1)
    assert found is not None
    return found


def test_families_change_what_they_say() -> None:
    """Every variant of every family is a case that a file could hold, and each value makes another one."""
    case = brake()
    for each in FAMILIES:
        for label, curve in each.curves.items():
            changed = [case.with_changes(each.changes(case, curve, value)) for value in each.values]
            assert len(set(map(repr, changed))) == len(each.values), (each.name, label)
        assert list(each.values) == sorted(each.values)
        if each.base is not None:
            assert each.values[0] <= each.base(case) <= each.values[-1], each.name


def test_every_estimator_and_feedback_of_the_case_file_is_compared() -> None:
    for name, table in (("estimator_bandwidth", Estimator), ("drive_bandwidth", Feedback)):
        found = next(f for f in FAMILIES if f.name == name)
        keys = [dict(c) for c in found.curves.values() if not callable(c)]
        kinds = {value for changes in keys for key, value in changes.items() if key.endswith(".kind")}
        assert kinds == set(get_args(table.model_fields["kind"].annotation)), name


def test_a_users_feed_forward_is_ours_without_feedback(study: Study) -> None:
    """The user is given our feed-forward: posting it is `no feedback`, as long as no limit of torque is met."""
    ours, mine = study.curve("drive_bandwidth", "no feedback"), study.curve("drive_bandwidth", USER)
    assert len(mine) == len(ours) == 3
    for a, b in zip(ours[1:], mine[1:], strict=True):
        assert a.numbers["roller_torque_largest_nm"] < 2e4
        assert b.numbers["tracking_rms"] == pytest.approx(a.numbers["tracking_rms"], rel=1e-9)
    assert any(r.curve == USER for r in study.references)


def test_feedback_and_fast_drives_help(study: Study) -> None:
    curves = {name: study.curve("drive_bandwidth", name) for name in ("PI", "no feedback")}
    errors = {name: [r.numbers["tracking_rms"] for r in points] for name, points in curves.items()}
    assert errors["PI"] == sorted(errors["PI"], reverse=True)
    assert all(a <= b for a, b in zip(errors["PI"][1:], errors["no feedback"][1:], strict=True))
    assert errors["PI"][0] > LOST > errors["PI"][1]


def test_the_ranking_begins_with_what_ended_early(study: Study) -> None:
    ranks = ranking(study)
    assert (ranks[0].family.name, ranks[0].curve) == ("wrong_belief", "wheel radius")
    assert [b.cause for b in ranks[0].breaks] == ["rollers_protected"] * 2
    assert "roller inertia" in {r.curve for r in ranks if not r.breaks}
    slow = next(r for r in ranks if (r.family.name, r.curve) == ("drive_bandwidth", "PI"))
    assert 0.2 < slow.breaks[0].value < 5.0
    assert slow.breaks[0].cause == "tracking"


@pytest.mark.parametrize(("percent", "ends"), [(2.9, False), (-2.9, False), (-3.1, True)])
def test_a_wrong_radius_trips_the_protection_where_it_should(percent: float, ends: bool) -> None:
    """It sees (r^ - r) w, at 120 km/h and a limit of 1 m/s from 3 % on, though nothing slides."""
    case = brake(1.0).with_changes({"rig_control.assumed.wheel_radius": 0.46 * (1 + 0.01 * percent)})
    assert case.rig_control is not None
    assert (abs(0.01 * percent) * case.motion.speed > case.rig_control.protection.slip) == ends
    numbers = run_variant(Variant("", "", percent, case)).numbers
    assert (numbers["status"] == "rollers_protected") == ends
    assert numbers["real_sliding_largest_mps"] < 0.05


def result(value: float, rms: float, ripple: float = 1.0, status: str = "ok") -> Result:
    numbers: dict[str, Any] = dict.fromkeys(RESULT_KEYS, 0.0)
    numbers |= {"status": status, "tracking_rms": rms, "ripple_nm": ripple, "ended_s": 1.0}
    return Result("f", "c", value, numbers)


def test_breaks_are_interpolated_from_the_cases_own_value_outwards() -> None:
    log = family("drive_bandwidth", (1.0,))
    points = [result(1.0, 0.1), result(10.0, 0.001), result(100.0, 0.0005), result(1000.0, 0.0005, 1e6, "contact_lost")]
    low, high = breaks(log, points, 100.0)
    assert low.value == pytest.approx(math.sqrt(10.0))  # 0.01 is halfway between 0.1 and 0.001 in logarithms
    assert (low.good, low.cause) == (10.0, "tracking")
    assert (high.value, high.good, high.cause) == (1000.0, 100.0, "contact_lost")

    linear = family("wrong_belief", (0.0,))
    points = [result(0.0, 0.001), result(4.0, 0.001, LOST_RIPPLE**2)]  # ripple from 1 to its limit's square
    (only,) = breaks(linear, points, 0.0)
    assert only.value == pytest.approx(2.0)
    assert only.cause == "ripple"

    assert breaks(linear, [result(0.0, 0.001), result(1.0, 0.002)], 0.0) == []
    (nowhere,) = breaks(linear, [result(0.0, 0.1), result(1.0, 0.2)], None)
    assert math.isnan(nowhere.good)


def test_ripple_is_what_never_ceases() -> None:
    time = np.arange(0.0, 5.0, 2e-3)
    ring = 100.0 * np.sin(2 * np.pi * 27.0 * time)
    slow = 5000.0 * np.sin(2 * np.pi * 1.0 * time)
    ripple, frequency = ripple_of(time, np.stack([slow, slow + ring], axis=1))
    assert ripple == pytest.approx(100.0 / math.sqrt(2.0), rel=0.03)  # a quarter second holds 6.75 periods
    assert frequency == pytest.approx(27.0, abs=1.0)  # resolution of one second
    burst = np.where((time > 1.0) & (time < 2.0), ring, 0.0)
    assert ripple_of(time, burst[:, None])[0] < 1.0
    assert math.isnan(ripple_of(time[:100], ring[:100, None])[0])


def test_half_a_run_is_no_result() -> None:
    def pressed(_fraction: float, _text: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_variant(Variant("", "", 0.0, brake()), pressed)


def test_ctrl_c_keeps_what_is_there() -> None:
    calls = []

    def pressed(fraction: float, _text: str) -> None:
        calls.append(fraction)
        if fraction > 0.5:
            raise KeyboardInterrupt

    families = [family("drive_bandwidth", (5.0, 20.0, 50.0, 100.0, 200.0), "PI")]
    found = compare_controllers(brake(1.0), families=families, limits=False, processes=1, progress=pressed)
    assert calls
    assert found is not None
    assert found.interrupted
    assert found.references[0].curve == "as shipped"
    assert len(found.results) < 5
    assert "Interrupted" in lead(found)


def test_files(study: Study, tmp_path: Path) -> None:
    files = write_control(study, tmp_path)
    assert [f.name for f in files] == ["variants.csv", "summary.json", "report.html"]
    rows = (tmp_path / "variants.csv").read_text().splitlines()
    assert len(rows) == 1 + len(study.references) + len(study.results)
    numbers = json.loads((tmp_path / "summary.json").read_text())
    assert numbers["references"]["as shipped"]["tracking_rms"] < LOST
    assert len(numbers["results"]) == len(study.results)
    assert numbers["ranking"][0]["breaks"][0]["cause"] == "rollers_protected"
    page = (tmp_path / "report.html").read_text()
    assert "What breaks first" in page
    assert "http://" not in page
    said = lead(study)
    assert "Wrong numbers in the controller (shipped: 0 %)" in said
    assert "tracking lost below" in said


@pytest.mark.parametrize(
    ("name", "changes", "key"),
    [
        ("bogie_rollers_constant", {}, "rig_control"),
        ("adhesion_brake", {"brake": None, "slide_protection": None}, "brake"),
        ("adhesion_brake", {"rig_control.user": "mine:Mine"}, "rig_control.user"),
    ],
)
def test_cases_without_a_controller_to_compare_are_refused(name: str, changes: dict[str, object], key: str) -> None:
    with pytest.raises(ConfigError, match=key):
        study_case(load_case(name).with_changes(changes), None)


def test_unknown_families_and_controllers_are_refused() -> None:
    with pytest.raises(ConfigError, match="did you mean 'drive_bandwidth'"):
        chosen_families(["drive_bandwith"], "adhesion_brake")
    with pytest.raises(ConfigError, match="nowhere"):
        compare_controllers(brake(1.0), families=[], user="nowhere.py:Mine", limits=False)


def test_the_duration_only_shortens() -> None:
    assert study_case(load_case("adhesion_brake"), 100.0).time.duration == load_case("adhesion_brake").time.duration
    assert study_case(load_case("adhesion_brake"), 5.0).time.duration == 5.0
