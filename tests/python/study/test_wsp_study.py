"""`rollerrig wsp`: its stops, its numbers, and that no bad run gets an outcome."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from reported import unexplained, unreported
from rollerrig import ConfigError, load_case
from rollerrig.analysis.slide_statistics import SLIP_EDGES, TestRecord, axle_load
from rollerrig.analysis.virtual_rail import patch_of, rail_peak
from rollerrig.assembly.model import assemble
from rollerrig.config import CRITERIA, Case, Programme, load_programme
from rollerrig.config.load.resolve import resolve_programme
from rollerrig.config.read import Document
from rollerrig.results.run_info import RunInfo
from rollerrig.study.assessment import overall
from rollerrig.study.frame import Outcome
from rollerrig.study.jobs import whole_run
from rollerrig.study.runs.adhesion import track_case
from rollerrig.study.runs.wsp import (
    Assessment,
    StopTests,
    Support,
    adhesion_utilisation,
    assessments,
    build_up,
    check_case,
    dry_case,
    stop_case,
)
from rollerrig.study.wsp import MEASURED, QUANTITIES, Results, WspStudy, label

SHORT = {
    "name": "short",
    "starts": 4,
    "stop": [
        {"name": "low_26", "kind": "uniform", "speed": "26 km/h", "rail": "low", "duration": "20 s"},
        {"name": "drag_30", "kind": "drag", "speed": "30 km/h", "rail": "low", "gradient": -0.04, "duration": "3 s"},
    ],
    "limit": [
        {"criterion": "k_wet", "at_least": 0.5, "origin": "test"},
        {"criterion": "longest_lock", "at_most": "0.4 s", "origin": "test", "clause": "none"},
    ],
}


def programme(**changes: Any) -> Programme:
    found, problems = resolve_programme(Document({**SHORT, **changes}, "mine.toml", Path()))
    assert found is not None, problems
    return found


@pytest.fixture(scope="module")
def case() -> Case:
    """That counts as stationary early, to be short."""
    return load_case("adhesion_brake").with_changes({"motion.stop_speed": "5 m/s"})


@pytest.fixture(scope="module")
def outcome(case: Case) -> Outcome[Results]:
    """Two stops of two starts, of which the programme needs four."""
    found = WspStudy(case, programme(), starts=2).run()
    assert found is not None
    return found


# ------------------------------------------------------------------------------------------------------- a programme run


@pytest.mark.slow
def test_every_number_is_explained_and_every_explained_number_is_there(outcome: Outcome[Results]) -> None:
    assert unexplained(QUANTITIES, outcome.numbers) == []
    assert unreported(QUANTITIES, outcome.numbers) == []


@pytest.mark.slow
def test_distances_are_those_since_the_demand_and_k_wet_is_that_of_the_trade(outcome: Outcome[Results]) -> None:
    """100 / (100 + increase in %), of the means to second order of their scatter."""
    for on in ("track", "rig"):
        own = outcome.numbers["stops"]["low_26"][on]
        increase = 100.0 * own["increase_over_dry"]["mean"]
        assert own["k_wet"]["mean"] == pytest.approx(100.0 / (100.0 + increase), rel=5e-4)
        way = 26.0 / 3.6 * own["dry_build_up_s"]
        assert own["distance_m"]["mean"] - way == pytest.approx(
            (own["dry_distance_m"] - way) * (1.0 + increase / 100.0), rel=1e-9
        )
        assert 0.6 < own["k_wet"]["mean"] < 0.95  # the axles slide
        assert 0.4 < own["adhesion_utilisation"]["mean"] < 1.0
        assert own["tests"] == own["stopped"] == 2
    drag = outcome.numbers["stops"]["drag_30"]["track"]
    assert drag["k_wet"]["mean"] is None
    assert drag["stopped"] == 0


@pytest.mark.slow
def test_with_fewer_starts_than_the_programme_needs_nothing_is_decided(outcome: Outcome[Results]) -> None:
    """Though every lock is zero and every K_wet far within its limit."""
    for stop in outcome.numbers["stops"].values():
        for criterion in stop["criteria"].values():
            for on in ("track", "rig"):
                assert criterion[on]["outcome"] == "not decided"
                assert criterion[on]["why"].startswith("2 of 4 tests were made")
    sums = outcome.numbers["sums"]["track"]["criteria"]
    assert sums == {"met": 0, "not_met": 0, "not_decided": 3}  # a lock for both stops, K_wet where the train stops
    assert "none not met, 3 not decided" in outcome.summary


@pytest.mark.slow
def test_the_page_says_that_no_standard_is_quoted_and_the_files_are_there(
    outcome: Outcome[Results], tmp_path: Path
) -> None:
    written = {path.relative_to(tmp_path).as_posix() for path in outcome.write(tmp_path)}
    assert {"tests_low_26.csv", "signals_drag_30.csv", "figures/k_wet.png", "figures/stop_low_26.png"} <= written
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "EN 15595 and UIC 541-05 are not quoted" in page
    assert page.index("Assessment</h2>") < page.index("Criteria</h2>") < page.index("Stops</h2>")
    header, *lines = (tmp_path / "tests_low_26.csv").read_text().splitlines()
    assert header.split(",") == ["support", "start", "status", *MEASURED]
    assert [line.split(",")[:2] for line in lines] == [["track", "1"], ["track", "2"], ["rig", "1"], ["rig", "2"]]


@pytest.mark.slow
def test_processor_time_is_told_stop_by_stop(outcome: Outcome[Results]) -> None:
    times = outcome.timing["processor time of the tests [s]"]
    assert times["all"] == pytest.approx(times["low_26"] + times["drag_30"])
    assert "processor" not in str(outcome.numbers)


def test_limits_and_starts_may_change_between_two_runs_of_a_programme_and_nothing_else(case: Case) -> None:
    plan = WspStudy(case, programme()).plan()
    stricter = programme(limit=[{"criterion": "k_wet", "at_least": 0.9, "origin": "test"}])
    assert WspStudy(case, stricter, starts=6).plan() == plan
    later = [{**SHORT["stop"][0], "speed": "27 km/h"}]  # type: ignore[index]
    assert WspStudy(case, programme(stop=later, limit=[])).plan() != plan


# ------------------------------------------------------------------------------------------------------------ the stops


def test_the_shipped_programme_runs_with_both_cases_and_its_stops_are_what_they_say() -> None:
    shipped = load_programme("slide_protection_stops")
    assert len(shipped.stop) == 12
    assert {stop.kind for stop in shipped.stop} == {"uniform", "steps", "patches", "drag"}
    assert all(limit.origin.startswith("ours") and not limit.clause for limit in shipped.limit)
    for name in ("adhesion_brake", "adhesion_valves"):
        own = load_case(name)
        check_case(own, shipped)
        for stop in shipped.stop:
            rig = stop_case(own, shipped, stop)
            assert track_case(rig).motion.speed == rig.motion.speed == stop.speed
            assert rig.brake is not None
            assert own.brake is not None
            assert rig.brake.air == own.brake.air
            dry = dry_case(own, shipped, stop).adhesion
            assert dry is not None
            assert dry.piece == ()


def test_one_axle_at_a_time_is_on_a_patch(case: Case) -> None:
    patches = {"name": "p", "kind": "patches", "speed": "30 km/h", "rail": "dry", "patch": "low", "spacing": "9 m"}
    made = programme(stop=[{**patches, "length": "2 m", "count": 3}], limit=[])
    adhesion = stop_case(case, made, made.stop[0]).adhesion
    assert adhesion is not None
    assert [piece.distance for piece in adhesion.piece] == [20.0, 22.0, 29.0, 31.0, 38.0, 40.0]
    with pytest.raises(
        ConfigError, match=r"stop\.p\.length: 3; allowed: less than the least spacing of the axles, 2\.56 m"
    ):
        check_case(case, programme(stop=[{**patches, "length": "3 m"}], limit=[]))


def test_a_stop_from_a_speed_that_counts_as_stationary_is_refused(case: Case) -> None:
    slow = programme(stop=[{**SHORT["stop"][0], "speed": "10 km/h"}], limit=[])  # type: ignore[index]
    with pytest.raises(
        ConfigError, match=r"short: stop\.low_26\.speed: 10 km/h; allowed: more than motion\.stop_speed"
    ):
        check_case(case, slow)


@pytest.mark.parametrize("missing", ["brake", "slide_protection", "rig_control"])
def test_a_case_without_something_to_test_is_refused(missing: str, case: Case) -> None:
    with pytest.raises(ConfigError, match=f"{missing}: missing; needed"):
        WspStudy(case.model_copy(update={missing: None}), programme())


def _limit(**changes: Any) -> dict[str, Any]:
    return {"limit": [{"criterion": "longest_lock", "origin": "test", **changes}]}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (_limit(at_most=-1.0), "mine.toml: limit[0].at_most: -1.0; allowed: a number in s or a text with a unit like '10 ms'"),
        (_limit(at_least=1.0), "mine.toml: limit[0].at_least: 1.0; allowed for longest_lock: at_most"),
        (_limit(), "mine.toml: limit[0].at_most: missing; needed: a number in s"),
        (_limit(criterion="longest_look", at_most=1), "'longest_look'; allowed: k_wet"),
        (_limit(criterion="longest_look", at_most=1), "did you mean 'longest_lock'?"),
        (_limit(at_most=1, stops=["low_2"]), "limit[0].stops: 'low_2'; allowed: low_26, drag_30; did you mean 'low_26'?"),
        (_limit(at_most=1, stop="low_26"), "unknown key (= 'low_26'); allowed: criterion"),
        (_limit(criterion="k_wet", at_least=0.5, stops=["low_26", "drag_30"]), "limit[0].stops: 'drag_30'; allowed for k_wet:"),
        (
            {"stop": SHORT["stop"][1:], **_limit(criterion="k_wet", at_least=0.5)},  # type: ignore[index]
            "limit[0].criterion: 'k_wet'; holds for no stop; allowed for k_wet:",
        ),
        (_limit(criterion="flat_length", at_most="3 s"), "limit[0].at_most: '3 s'; allowed: a number in m"),
        ({"limit": 2 * _limit(at_most=1)["limit"]}, "limit[1].criterion: 'longest_lock'; allowed: one limit of it for low_26"),
        ({"stop": [{"name": "a", "kind": "unifrom", "speed": 10.0, "rail": "low"}]}, "did you mean 'uniform'?"),
        ({"stop": [SHORT["stop"][0]] * 2}, "stop[1].name: 'low_26'; allowed: each name once"),  # type: ignore[index]
        ({"stop": []}, "stop: []; allowed: at least 1 entries"),
        ({"starts": 2}, "starts: 2; allowed"),
        ({"stop": [{"name": "a", "kind": "drag", "speed": 10.0, "rail": "low", "gradient": 0.02}]}, "from -0.1 to 0"),
    ],
)  # fmt: skip
def test_what_a_programme_may_not_say_is_refused_with_its_place(changes: dict[str, Any], message: str) -> None:
    found, problems = resolve_programme(Document({**SHORT, **changes}, "mine.toml", Path()))
    assert found is None
    assert message in "\n".join(map(str, problems))


def test_every_criterion_has_a_label_and_a_measure() -> None:
    assert all(label(name) for name in CRITERIA)
    assert {one.measure for one in CRITERIA.values()} <= set(MEASURED)


# ---------------------------------------------------------------------------------------------------------- the outcome

GOOD = {
    "distance_m": 900.0, "mean_deceleration_mps2": 0.6, "dump_cycles": 300.0, "air_litres": 1100.0, "longest_lock_s": 0.1,
    "largest_slip": 0.3, "flat_length_m": 0.01, "large_slip_share": 0.01, "adhesion_utilisation": 0.7,
    "contact_lost_s": 0.0, "contact_lost_total_s": 0.0,
    "energy_relative_residual": 1e-6, "force_error_rms": 0.02, "drive_oscillation_nm": 5.0,
    "drive_limited_share": 0.001, "tracking_rms": 0.001, "duration_s": 50.0, "beyond_peak_s": 20.0,
    "drive_oscillation_spell_s": 0.25, "build_up_s": 1.5,
}  # fmt: skip
DRY = {**GOOD, "distance_m": 600.0, "beyond_peak_s": 0.0, "dump_cycles": 0.0}
LIMITS: dict[str, float] = {
    "k_wet": 0.5, "increase_over_dry": 1.0, "distance": 1000.0, "mean_deceleration": 0.5, "adhesion_utilisation": 0.6,
    "longest_lock": 0.4, "flat_length": 0.02, "large_slip_share": 0.1, "air": 1.5, "dump_cycles": 500.0,
}  # fmt: skip
ALL = programme(
    starts=8,
    limit=[
        {"criterion": name, "at_least" if CRITERIA[name].least else "at_most": value, "origin": "test"}
        for name, value in LIMITS.items()
    ],
)


def record(measures: dict[str, float], status: str = "stopped") -> TestRecord:
    shares = np.zeros(len(SLIP_EDGES) - 1)
    shares[4] = 1.0
    distance = measures["distance_m"]
    return TestRecord(status, status, measures, shares, np.array([0.0, 50.0]), np.array([0.0, distance]))


def made(status: str = "stopped", scatter: float = 1e-3, count: int = 8, **changes: float) -> list[TestRecord]:
    """That scatter by a part of each number."""
    noise = np.random.default_rng(5).normal(size=count)
    return [record({k: v * (1.0 + scatter * x) for k, v in {**GOOD, **changes}.items()}, status) for x in noise]


def assessed(
    own: Sequence[TestRecord],
    on: Support = "track",
    dry: TestRecord | None = None,
    stop: int = 0,
    fine: Sequence[TestRecord] = (),
) -> dict[str, Assessment]:
    rig = load_case("adhesion_brake")
    reference = record(DRY) if dry is None else dry
    found = StopTests(ALL.stop[stop], on, rig, ALL.starts, own, reference, fine)
    beside = made()[: len(fine)]
    other = StopTests(ALL.stop[stop], "rig" if on == "track" else "track", rig, ALL.starts, made(), reference, beside)
    return {one.limit.criterion: one for one in assessments(ALL, found, other)}


def words(found: dict[str, Assessment]) -> set[str]:
    return {one.outcome for one in found.values()}


@pytest.mark.parametrize("on", ["track", "rig"])
def test_a_good_stop_meets_every_criterion(on: Support) -> None:
    found = assessed(made(), on)
    assert len(found) == len(CRITERIA)
    assert words(found) == {"met"}
    assert overall(one.outcome for one in found.values()) == "met"


@pytest.mark.parametrize("name", LIMITS)
def test_each_criterion_is_not_met_beyond_its_limit_and_undecided_across_it(name: str) -> None:
    measure, factor = CRITERIA[name].measure, CRITERIA[name].factor
    changed = "distance_m" if name in ("k_wet", "increase_over_dry") else measure
    limit = 1200.0 if changed == "distance_m" and name != "distance" else LIMITS[name] / factor
    beyond = 0.9 if CRITERIA[name].least and name != "k_wet" else 1.1
    bad = assessed(made(**{changed: beyond * limit}))
    assert bad[name].outcome == "not met"
    assert overall(one.outcome for one in bad.values()) == "not met"
    across = assessed(made(scatter=0.02, **{changed: limit}))
    assert across[name].outcome == ("not met" if CRITERIA[name].every else "not decided")


def test_one_lock_beyond_the_limit_is_enough_though_the_mean_is_within() -> None:
    one = made()
    one[3] = record({**GOOD, "distance_m": 901.0, "longest_lock_s": 2.0})
    found = assessed(one)["longest_lock"]
    assert (found.outcome, found.worst) == ("not met", 2.0)


SPOILED = {
    "7 of 8 tests were made": made()[:7],
    "0 of 1 tests came to their end, one ended early: contact_lost": [record({**GOOD}, "contact_lost")],
    "7 of 8 tests came to their end, one ended early: rollers_protected": [
        *made()[:7],
        record({**GOOD}, "rollers_protected"),
    ],
    "in 8 of 8 tests the train had not stopped after 20 s": made("ok"),
    "7 of 8 tests kept contact": [*made()[:7], record({**GOOD, "contact_lost_s": 0.02})],
    "6 of 8 tests kept contact": [*made()[:6], *made(contact_lost_total_s=0.6)[6:]],  # 0.6 s of 50 s
    "0 of 8 tests had axles beyond the peak of the creep curve for 1 s in all": made(beyond_peak_s=0.01),
    "0 of 8 tests closed their energy balance": made(energy_relative_residual=0.01),
    "0 of 8 tests differ": made(scatter=0.0),
}


@pytest.mark.parametrize("reason", SPOILED)
@pytest.mark.parametrize("on", ["track", "rig"])
def test_a_bad_run_gets_no_verdict_whatever_its_numbers_are(reason: str, on: Support) -> None:
    """Neither met nor not met, of any criterion: the worst run that would pass is a good one."""
    for own in (
        SPOILED[reason],
        [replace(one, measures={**one.measures, "longest_lock_s": 9.0}) for one in SPOILED[reason]],
    ):
        found = assessed(own, on)
        assert words(found) == {"not decided"}
        assert all(reason in one.why for one in found.values())


@pytest.mark.parametrize(
    "bad",
    [
        made("contact_lost"),
        made("ok"),
        made(energy_relative_residual=0.5),
        made(contact_lost_s=0.3),
        made(contact_lost_s=math.nan),
    ],
)
@pytest.mark.parametrize("on", ["track", "rig"])
def test_bad_tests_with_finer_steps_leave_nothing_decided(bad: list[TestRecord], on: Support) -> None:
    """Nobody knows then what steps change, of which every interval says that it has it."""
    assert words(assessed(made(), on, fine=made()[:2])) == {"met"}
    found = assessed(made(), on, fine=[made()[0], bad[1]])
    assert words(found) == {"not decided"}
    assert all(one.why.startswith("1 of 2 tests with finer steps ended early, did not") for one in found.values())


def test_on_the_rig_what_finer_steps_change_may_leave_it_no_track() -> None:
    fine = made(force_error_rms=0.06)[:2]
    assert words(assessed(made(), "track", fine=fine)) == {"met"}
    assert words(assessed(made(), "rig", fine=fine)) == {"not decided"}


def test_a_run_that_says_nothing_of_itself_gets_no_verdict() -> None:
    for name in ("contact_lost_s", "contact_lost_total_s", "duration_s", "beyond_peak_s", "energy_relative_residual"):
        assert words(assessed([replace(one, measures=one.measures | {name: math.nan}) for one in made()])) == {
            "not decided"
        }
    empty = assessed([replace(one, measures=one.measures | {"air_litres": math.nan}) for one in made()])
    assert empty["air"].outcome == "not decided"
    assert empty["k_wet"].outcome == "met"


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("force_error_rms", 0.2),
        ("drive_power_limited_s", 5.0),
        ("drive_limited_share", 0.1),
        ("drive_oscillation_nm", 5000.0),
    ],
)
def test_a_rig_that_is_no_track_gets_no_verdict_but_the_track_does(name: str, value: float) -> None:
    found = assessed(made(**{name: value}), "rig")
    assert words(found) == {"not decided"}
    assert all("the rig is no track here" in one.why for one in found.values())
    assert words(assessed(made(**{name: value}), "track")) == {"met"}


@pytest.mark.parametrize(
    ("dry", "reason"),
    [
        (record(DRY, "ok"), "the dry reference did not come to a stop"),
        (record({**DRY, "beyond_peak_s": 0.2}), "in the dry reference an axle passed the peak"),
        (record({**DRY, "dump_cycles": 3.0}), "in the dry reference the protection acted"),
        (record({**DRY, "distance_m": 950.0}), "a test stopped in less than the dry distance"),
    ],
)
def test_a_dry_stop_that_is_no_reference_decides_nothing_that_needs_it(dry: TestRecord, reason: str) -> None:
    found = assessed(made(), dry=dry)
    for name, one in found.items():
        needs_it = name in ("k_wet", "increase_over_dry")
        assert (one.outcome, reason in one.why) == (("not decided", True) if needs_it else ("met", False)), name


def test_k_wet_is_the_ratio_of_decelerations_where_the_brake_builds_up_and_then_holds() -> None:
    """s = v t + v^2 / 2 a: what is left of both distances without v t is in the ratio of the decelerations."""
    speed, waiting, dry, wet = ALL.stop[0].speed, 1.7, 0.9, 0.5
    own, reference = (
        record({**GOOD, "distance_m": speed * waiting + speed**2 / (2.0 * rate), "build_up_s": waiting})
        for rate in (wet, dry)
    )
    found = StopTests(ALL.stop[0], "track", load_case("adhesion_brake"), 1, [own], reference)
    assert found.values("k_wet") == pytest.approx([wet / dry], rel=1e-12)
    assert found.values("increase_over_dry") == pytest.approx([dry / wet - 1.0], rel=1e-12)


def test_the_build_up_of_a_pressure_that_rises_evenly_lasts_half_of_its_rise() -> None:
    time = np.linspace(0.0, 10.0, 1001)
    pressure = 3.8e5 * np.minimum(1.0, time / 3.0)
    run = xr.Dataset({"cylinder_pressure": (("time", "axle"), np.stack([pressure, pressure], 1))}, {"time": time})
    assert build_up(run) == pytest.approx(1.5, rel=1e-3)


def test_axles_that_stay_on_the_peak_of_the_creep_curve_use_all_of_the_adhesion() -> None:
    """Of each place and speed, also behind a change of the rail; the forces of a run replaced by those."""
    pieces = [{"distance": "15 m", "rail": "very_low"}]
    changes = {"time.duration": "4 s", "motion.speed": "36 km/h", "adhesion.piece": pieces, "contact.normal": "hertz"}
    case = track_case(load_case("adhesion_brake").with_changes(changes))
    run = whole_run(case)
    real = adhesion_utilisation(run, case)
    assert 0.4 < real < 1.0  # the brake builds up most of the time
    patch, load = patch_of(assemble(case)), axle_load(run)
    places = {body.name: body.position[0] for body in RunInfo.of(run).wheelsets}
    force = run["creep_force"].copy(deep=True)
    for axle, place in places.items():
        at = run["train_distance"].to_numpy() + place
        peaks = [
            rail_peak(case, patch, case.adhesion.rail if x < 15.0 else case.adhesion.piece[0].rail, float(v))[1]  # type: ignore[union-attr]
            for x, v in zip(at[::20], run["train_speed"].to_numpy()[::20], strict=True)
        ]
        force.loc[{"axle": axle}] = -load * np.interp(np.arange(at.size), np.arange(at.size)[::20], peaks)
    assert adhesion_utilisation(run.assign(creep_force=force), case) == pytest.approx(1.0, rel=0.01)


def test_a_drag_braking_need_not_stop_and_is_judged_by_what_it_has() -> None:
    found = assessed(made("ok"), stop=1, fine=made("ok")[:2])
    assert found.keys() == {
        "adhesion_utilisation",
        "longest_lock",
        "flat_length",
        "large_slip_share",
        "air",
        "dump_cycles",
    }
    assert words(found) == {"met"}


def test_without_limits_nothing_is_judged() -> None:
    assert overall([]) is None


@pytest.mark.slow
def test_the_summary_says_how_far_a_verdict_on_the_rig_is_one_on_track(outcome: Outcome[Results]) -> None:
    lines = outcome.summary.splitlines()
    assert lines[0].startswith("On track 0 of 3 criteria are met")
    assert any("an outcome on the rig is one of the test on the rig." in line for line in lines)
    assert "EN 15595 and UIC 541-05 are not quoted" in lines[-1]
