"""`rollerrig adhesion`: what its outcome, numbers and sentences are made of."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reported import unexplained
from rollerrig import ConfigError, load_case, simulate
from rollerrig.analysis.slide_statistics import SLIP_EDGES, TestRecord, adhesion_at_readhesion
from rollerrig.analysis.slide_statistics import test_record as record_of
from rollerrig.config import Case, case_from_toml
from rollerrig.study.adhesion import QUANTITIES, AdhesionStudy, Runs
from rollerrig.study.assessment import Outcome
from rollerrig.study.ensemble import Estimate, difference, drawn, estimate, finer, relative, starts
from rollerrig.study.frame import Outcome as Found
from rollerrig.study.runs.adhesion import (
    CAUSES,
    LARGEST_ERROR,
    STEPS,
    TOGETHER,
    Row,
    assessment_rows,
    cause_shares,
    outcome_of,
    to_refine,
    track_case,
    variant,
    variants_of,
)

FIRST: list[Found[Runs]] = []


@pytest.fixture(scope="module")
def outcome() -> Found[Runs]:
    """A brake test until the wheels have slid once, with two starts; what is asked of it is none of the contact's."""
    case = load_case("adhesion_brake").with_changes({"time.duration": "5 s", "contact.normal": "hertz"})

    def first(page: Found[Runs]) -> None:
        FIRST.append(page)
        if len(page.results.records.get("rig", ())) == 2:  # no page after that
            patch.setattr("rollerrig.study.frame.PAGE_EVERY", math.inf)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rollerrig.study.frame.PAGE_EVERY", 0.0)
        patch.setattr("rollerrig.study.frame.PAGE_SHARE", math.inf)
        found = AdhesionStudy(case, quick=True).run(first_results=first)
    assert found is not None
    return found


@pytest.mark.slow
def test_the_first_page_is_that_of_two_starts_on_track_and_rig(outcome: Found[Runs], tmp_path: Path) -> None:
    """Nothing is said yet of what was not run."""
    first = next(one for one in FIRST if len(one.results.records.get("rig", ())) == 2)
    assert len(first.results.records["track"]) == 2
    assert set(first.results.records) <= {"track", "rig", "rolling"}
    assert first.numbers["track"] == outcome.numbers["track"]
    assert first.numbers["interrupted"]
    first.write(tmp_path)
    assert "First results" in (tmp_path / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def numbers(outcome: Found[Runs]) -> dict[str, Any]:
    return outcome.numbers


# ---------------------------------------------------------------------------------------------- ensembles and shares


def test_mean_standard_error_and_interval_of_known_values() -> None:
    found = estimate((1.0, 2.0, 3.0, 4.0))
    assert found.mean == 2.5
    assert found.standard_error == pytest.approx((5.0 / 3.0) ** 0.5 / 2.0)
    assert found.interval.high == pytest.approx(2.5 + 3.1824463 * found.standard_error)  # Student's table, 3 degrees
    assert not estimate((1.0,)).interval.known  # of one test nothing is known


def test_intervals_hold_the_mean_of_very_many_tests_as_often_as_they_say() -> None:
    """95 % of 2000 ensembles of 8, to three standard deviations of such a count; of a difference and a ratio as well."""
    generator = np.random.default_rng(1)
    held = np.zeros(3)
    for _ in range(2000):
        shared = generator.normal(0.0, 5.0, 8)  # what both draw alike is no error of their difference and ratio
        b = 100.0 + shared + generator.normal(0.0, 1.0, 8)
        a = 0.95 * (100.0 + shared) + generator.normal(0.0, 2.0, 8)
        for k, (one, true) in enumerate(((estimate(a), 95.0), (difference(a, 0.95 * b), 0.0), (relative(a, b), -0.05))):
            held[k] += one.interval.low < true < one.interval.high
    assert relative(a, b).standard_error < 0.03 < 0.05 < estimate(a).standard_error
    assert held / 2000 == pytest.approx(0.95, abs=3.0 * math.sqrt(0.05 * 0.95 / 2000))


def test_zero_against_not_zero_is_infinite_and_not_met() -> None:
    """Ventings on the rig and none on track: no ratio, and no agreement; none on both says nothing."""
    none, some = (0.0, 0.0, 0.0, 0.0), (5.0, 6.0, 5.0, 6.0)
    assert relative(some, none).mean == math.inf
    assert math.isnan(relative(none, none).mean)
    row = Row("fidelity", "x", "x", relative(some, none), -0.05, 0.05, "")
    assert (row.outcome, row.value_text) == ("not met", "not zero, against zero")
    once = relative((0.0, 0.0, 0.0, 1.0), none)  # whose interval reaches to zero
    assert replace(row, value=once).outcome == "not decided"
    assert replace(row, value=relative(none, none)).outcome == "not decided"


def test_a_number_that_is_infinite_is_none() -> None:
    found = relative((1.0, math.inf, 1.0), (1.0, 1.0, 1.0))  # warnings are errors
    assert math.isnan(found.mean)
    assert Row("fidelity", "x", "x", found, -0.05, 0.05, "").outcome == "not decided"


NUMBERS = {"zero": [0.0] * 8, "a number": [0.3 + 1e-4 * k for k in range(8)], "none": [math.nan] * 8}
NUMBERS |= {"none in one test": [*NUMBERS["a number"][:7], math.nan]}


@pytest.mark.slow
@pytest.mark.parametrize("key", ["dump_cycles", "air_litres", "adhesion_at_readhesion", "mean_deceleration_mps2"])
@pytest.mark.parametrize("on_track", NUMBERS)
@pytest.mark.parametrize("on_rig", NUMBERS)
def test_no_row_vanishes_that_one_of_both_has_a_number_for(key: str, on_track: str, on_rig: str) -> None:
    """Zero against not zero is not met, what is no number is not decided; only two zeros or two nothings say nothing."""

    def tests(numbers: str) -> list[TestRecord]:
        return [
            replace(one, measures=one.measures | {key: x}) for one, x in zip(records(), NUMBERS[numbers], strict=True)
        ]

    _, fidelity, rows = outcomes(tests(on_track), tests(on_rig))
    if on_track == on_rig and on_track in ("zero", "none"):
        assert key not in rows
        assert fidelity == "met"
        return
    same = on_track == on_rig == "a number"
    both = {on_track, on_rig} == {"zero", "a number"}
    assert rows[key].outcome == ("met" if same else "not met" if both else "not decided")
    assert fidelity == rows[key].outcome


def test_where_no_axle_passes_the_creep_peak_nothing_is_met() -> None:
    for slid, seven in ((0.0, 0.0), (20.0, 0.0), (math.nan, math.nan)):
        tests = records(beyond_peak_s=slid)
        tests[7] = replace(tests[7], measures=tests[7].measures | {"beyond_peak_s": seven})
        tracking, fidelity, rows = outcomes(tests, tests)
        assert (tracking, fidelity) == ("not decided", "not decided")
        assert {row.outcome for row in rows.values() if not row.shown} == {"not decided"}
    assert outcomes(records(), records(beyond_peak_s=0.0))[:2] == ("not decided", "not decided")


@pytest.mark.slow  # two runs of 2 s
def test_on_a_dry_rail_nothing_is_assessed() -> None:
    case = load_case("adhesion_brake").with_changes(
        {"time.duration": "2 s", "contact.normal": "hertz", "adhesion.rail": "dry"}
    )
    track, rig = ([record_of(simulate(one), one)] * 2 for one in (track_case(case), case))
    assert track[0].measures["largest_slip"] < 0.01
    assert {outcome_of(assessment_rows(case, (track, rig)), group) for group in ("tracking", "fidelity")} == {
        "not decided"
    }


def test_an_interval_has_what_finer_steps_change_on_the_same_draws() -> None:
    case = load_case("adhesion_brake")
    plain = {row.key: row.value for row in assessment_rows(case, (records(), records()))}
    fine = records(dump_cycles=1.03 * GOOD["dump_cycles"])[:3]
    rows = {row.key: row for row in assessment_rows(case, (records(), records()), (records()[:3], fine))}
    assert rows["dump_cycles"].value.systematic == pytest.approx(0.03, rel=1e-3)
    reach = [0.5 * (one.interval.high - one.interval.low) for one in (rows["dump_cycles"].value, plain["dump_cycles"])]
    assert reach[0] - reach[1] == pytest.approx(0.03, rel=1e-3)
    assert rows["air_litres"].value.systematic == 0.0
    assert rows["rig_ended"].value == plain["rig_ended"]


def test_finer_tests_have_a_quarter_of_steps_and_samples_on_both_supports() -> None:
    case = load_case("adhesion_brake")
    rig, track = finer(case), finer(track_case(case))
    assert rig.rig_control is not None
    assert track.time.sampling_step == rig.time.sampling_step == rig.rig_control.sample_time == 0.25e-3
    assert track.integration.step == 0.25e-3


@pytest.mark.slow
@pytest.mark.parametrize("distribution", ["uniform", "normal"])
def test_starts_are_the_case_itself_and_others_drawn_by_its_ensemble_and_always_the_same(distribution: str) -> None:
    case = load_case("adhesion_brake").with_changes({"ensemble.distribution": distribution})
    eight, longer = starts(case, 8), starts(case, 400)
    assert eight[0] is case
    assert eight == longer[:8]
    spread = case.ensemble
    assert case.adhesion is not None
    assert case.brake is not None

    def drawn_of(one: Case) -> list[float]:
        assert one.adhesion is not None
        assert one.brake is not None
        mass = one.vehicle.data.body[0].mass / case.vehicle.data.body[0].mass
        friction = one.adhesion.rail.friction.mu_0 / 0.08, one.brake.friction[0][1] / 0.38
        return [*friction, mass, one.motion.speed / case.motion.speed, one.brake.demand[-2][0] - 0.5]

    factors = np.array([drawn_of(one) for one in longer])
    reach = np.array([spread.adhesion, spread.pad_friction, spread.load, spread.speed, 0.5 * spread.demand_time])
    shares = (factors[1:] - [1.0, 1.0, 1.0, 1.0, 0.5 * spread.demand_time]) / reach
    assert np.abs(shares).max() <= 1.0 + 1e-9
    deviation = {"uniform": 3.0**-0.5, "normal": 0.44}[distribution]  # of a normal one cut off at 2 sigma: 0.88 sigma
    assert shares.std(axis=0) == pytest.approx(deviation, rel=0.1)  # sqrt(1/2n) of 400: 4 %
    assert [drawn_of(one) for one in starts(track_case(case), 8)] == factors[:8].tolist()


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"adhesion.rail.friction.mu_0": 1.2, "ensemble.adhesion": 0.5}, "ensemble.adhesion: 0.5, which draws adhesion.rail"),
        ({"ensemble.load": 1.0}, "ensemble.load: 1, which draws vehicle.body.car_body.mass"),
        ({"ensemble.speed": 0.98}, "ensemble.speed: 0.98, which draws motion.speed = 2.4 km/h; allowed: more than motion.stop"),
        ({"motion.speed": "3 km/h", "ensemble.speed": 0.0}, "motion.speed: 3 km/h; allowed: more than motion.stop_speed, "),
        ({"ensemble.adhesion": 1.0}, "ensemble.adhesion: 1, which draws rails without friction; allowed: less than 1"),
        ({"ensemble.demand_time": 100.0}, "ensemble.demand_time: 100 s, which draws a row of brake.demand at 100.6 s"),
    ],
)  # fmt: skip
def test_a_distribution_that_leaves_the_range_of_a_law_is_refused_in_a_line(changes: dict[str, Any], line: str) -> None:
    with pytest.raises(ConfigError) as refused:
        AdhesionStudy(load_case("adhesion_brake").with_changes(changes))
    assert [line in str(problem) and "allowed:" in str(problem) for problem in refused.value.problems] == [True]


def test_a_wheelset_alone_has_no_load_to_draw() -> None:
    case = load_case("contact_benchmark_rollers")
    assert drawn(case, {"load": 1.0}) == case


@pytest.mark.parametrize("begin", [0.0, 0.5])
def test_a_demand_comes_later_as_it_is(begin: float) -> None:
    """Also one that begins with the run: a delay makes no ramp slower."""
    case = load_case("adhesion_brake").with_changes({"brake.demand": [[begin, 0.0], [begin + 0.1, 3e5], [9.0, 2e5]]})
    found = drawn(case.with_changes({"ensemble.demand_time": 2.0}), {"demand_time": 0.75}).brake
    assert found is not None
    at = np.linspace(0.0, 12.0, 241)
    demand, later = (np.interp(at, *np.transpose(table)) for table in (case.brake.demand, found.demand))  # type: ignore[union-attr]
    np.testing.assert_allclose(later[30:], demand[:-30], rtol=1e-12)
    assert not later[:30].any()


def test_a_spread_beyond_everything_is_refused_with_its_key() -> None:
    with pytest.raises(ConfigError, match=r"ensemble\.adhesion: 1\.5; allowed: .*from 0 to 1"):
        load_case("adhesion_brake").with_changes({"ensemble.adhesion": 1.5})


def record(distance: float, status: str = "stopped", **measures: float) -> TestRecord:
    """Of a test that was not run."""
    shares = np.zeros(len(SLIP_EDGES) - 1)
    shares[4] = 1.0
    return TestRecord(
        status, status, {"distance_m": distance, **measures}, shares, np.array([0.0, 50.0]), np.array([0.0, distance])
    )


def test_each_share_is_what_its_variant_takes_away_with_both_errors() -> None:
    generator = np.random.default_rng(2)
    means = dict(zip(("rig", *STEPS, "track"), (940.0, 943.0, 944.0, 947.0, 952.0), strict=True))
    values = {name: generator.normal(mean, 2.0, 8) for name, mean in means.items()}
    shares = cause_shares({name: [record(one) for one in own] for name, own in values.items()})
    assert shares is not None
    way = [float(values[name].mean()) for name in means]
    own = list(values.values())
    for k, name in enumerate(CAUSES):
        error = float((own[k] - own[k + 1]).std(ddof=1)) / 8**0.5
        assert shares[name].mean == pytest.approx((way[k] - way[k + 1]) / way[-1])
        assert shares[name].standard_error == pytest.approx(error / way[-1])
    assert sum(shares[name].mean for name in CAUSES) == pytest.approx(shares[TOGETHER].mean)
    assert len(to_refine(shares)) == len(shares)  # 0.1 % of the distance each
    known = {name: replace(one, standard_error=0.9 * LARGEST_ERROR) for name, one in shares.items()}
    assert to_refine(known) == []
    assert to_refine({**known, "drives": shares["drives"]}) == [("rolling", "drives")]


def refined(
    scatter: Mapping[str, float], rig: Mapping[str, float] = {}, cycles: float = 0.0
) -> tuple[dict[str, int], str]:
    """Starts that the study makes of each ensemble, and its summary.

    Distances are in turn by `scatter` [m] above and below 950 m, measures those of GOOD and of `rig`, its dump cycles in turn by
    `cycles` above and below; the same with finer steps.
    """
    study, done = AdhesionStudy(load_case("adhesion_brake")), dict[str, Any]()

    def invented(job: str) -> TestRecord:
        ensemble, sign = job.split(",")[0], -1.0 if job[-1] in "02468" else 1.0
        measures = GOOD if ensemble == "track" else {**GOOD, **rig}
        counted = measures["dump_cycles"] + (sign * cycles if ensemble == "rig" else 0.0)
        start = int(job.split()[-1]) if job[-1].isdigit() else 1
        way = 950.0 + sign * scatter.get(ensemble, 0.0) + 1e-6 * start  # no two tests are the same
        return record(way, **{**measures, "dump_cycles": counted})

    with pytest.MonkeyPatch.context() as patch:  # what is not asked for here
        patch.setattr("rollerrig.analysis.slide_statistics.test_record", lambda run, _: run)
        patch.setattr("rollerrig.study.adhesion.predicted_dead_time", lambda _: None)
        patch.setattr("rollerrig.study.ensemble.drawn", lambda case, _: case)
        for jobs in study.rounds(done):
            done |= {name: invented(name) for name in jobs if name not in done}
        results = study.collect(done)
    assert results is not None
    count = {name: len(results.records[name]) for name in ("track", "rig", *STEPS)}
    return count, "\n".join(row.told for row in study.rows(results) if "would decide" in row.told)


EIGHT = dict.fromkeys(("track", "rig", *STEPS), 8)


def test_an_ensemble_ends_as_soon_as_its_shares_are_known() -> None:
    """Standard error x / sqrt(n - 1) of values x above and below their mean: 0.05 % of the distance after 9.7 and 18.7 starts."""
    assert refined({})[0] == EIGHT
    assert refined({"estimator": 1.4})[0] == {**EIGHT, "track": 10, "drives": 10, "estimator": 10}
    assert refined({"estimator": 2.0})[0] == {**EIGHT, "track": 16, "drives": 16, "estimator": 16}
    assert refined({"rolling": 1.4})[0] == {**EIGHT, "rig": 10, "rolling": 10, "drives": 10}


def test_starts_are_added_while_they_decide_a_row() -> None:
    """Dump cycles 4 % fewer on the rig, of 5 %: interval of t(n - 1) x / sqrt(n - 1), x = 3, 4, 6 of 300 cycles."""
    fewer = {"dump_cycles": 0.96 * GOOD["dump_cycles"]}
    assert refined({}, fewer, 3.0) == (EIGHT, "")
    assert refined({}, fewer, 4.0) == ({**EIGHT, "track": 11, "rig": 11}, "")
    count, said = refined({}, fewer, 6.0)
    assert count == EIGHT
    assert "dump cycles, all axles under test" in said
    assert said.endswith(" (about 21 starts would decide, if mean and scatter stay)")
    row = Row("fidelity", "x", "x", estimate([0.0, 0.09]), -0.05, 0.05, "")  # of two starts alone
    assert row.starts_needed < math.inf
    assert row.told.endswith("target within 5 %")
    bad_run = {**fewer, "force_error_rms": 0.06}  # no number of starts makes the row met
    assert refined({}, bad_run, 4.0) == (EIGHT, "")


def test_a_row_looked_at_twice_is_wrong_hardly_more_often() -> None:
    """At its limit every decision is wrong: 5 % of a single look at an interval of 95 %."""
    generator, row, wrong = np.random.default_rng(5), Row("fidelity", "x", "x", estimate([0.0]), -0.05, 0.05, ""), 0
    for values in generator.normal(0.05, 0.01, (2000, 16)).tolist():
        one = replace(row, value=estimate(values[:8]))
        if 8 < one.starts_needed <= 16:
            one = replace(row, value=estimate(values[: int(one.starts_needed)]))
        wrong += one.outcome != "not decided"
    assert wrong / 2000 == pytest.approx(0.07, abs=0.01)


def test_the_starts_that_a_row_needs_end_its_interval_at_the_nearest_limit() -> None:
    row = Row("fidelity", "x", "x", estimate([0.01, 0.05, 0.02, 0.00, 0.04, 0.03, 0.02, 0.03]), -0.05, 0.05, "")
    for value in (row.value, replace(row.value, mean=0.08), replace(row.value, systematic=0.01)):
        one = replace(row, value=value)
        count = one.starts_needed
        spread = value.standard_error * 8**0.5
        ends = [
            replace(one, value=replace(value, standard_error=spread / n**0.5, freedom=n - 1.0)).outcome
            for n in (count - 1.0, count)
        ]
        assert ends == ["not decided", "met" if value.mean < 0.05 else "not met"]
    many = replace(row.value, mean=0.0499)
    assert replace(row, value=many).starts_needed == math.inf
    assert (
        replace(row, value=replace(row.value, systematic=0.03)).starts_needed == math.inf
    )  # the steps decide, not the starts
    assert replace(row, bad_run=True).starts_needed == replace(row, undecided=True).starts_needed == math.inf
    assert replace(row, value=Estimate(math.nan, math.nan, 0.0)).starts_needed == math.inf


# -------------------------------------------------------------------------------------------------------- the outcome

GOOD = {
    "tracking_rms": 0.0015, "tracking_largest": 0.016, "force_error_rms": 0.04, "drive_oscillation_nm": 50.0,
    "drive_limited_share": 0.005, "crown_gravity_largest": 0.005, "mean_deceleration_mps2": 0.6, "dump_cycles": 300.0,
    "air_litres": 1100.0, "adhesion_at_readhesion": 0.083, "longest_lock_s": 0.0, "beyond_peak_s": 20.0,
    "drive_oscillation_spell_s": 0.25, "energy_relative_residual": 1e-6, "contact_lost_s": 0.0,
    "contact_lost_total_s": 0.0, "duration_s": 50.0,
}  # fmt: skip


def records(status: str = "stopped", scatter: float = 1e-4, **changes: Any) -> list[TestRecord]:
    """Eight tests that scatter by a part of each number."""
    factors = 1.0 + scatter * np.random.default_rng(4).normal(size=8)
    return [record(950.0 * x, status, **{k: v * x for k, v in {**GOOD, **changes}.items()}) for x in factors.tolist()]


def outcomes(track: Sequence[TestRecord], rig: Sequence[TestRecord]) -> tuple[Outcome, Outcome, dict[str, Row]]:
    rows = assessment_rows(load_case("adhesion_brake"), (track, rig))
    return outcome_of(rows, "tracking"), outcome_of(rows, "fidelity"), {row.key: row for row in rows}


def test_a_rig_that_does_as_the_track_meets_everything() -> None:
    tracking, fidelity, rows = outcomes(records(), records())
    assert (tracking, fidelity) == ("met", "met")
    assert len(rows) == 24


BAD_RUNS: dict[str, dict[str, Any]] = {
    "ended early": {"status": "test_terminated"},
    "rolled off the crowns": {"status": "contact_lost"},
    "oscillating drives": {"drive_oscillation_nm": 9e3},
    "contact force away from the virtual one": {"force_error_rms": 1.5},
    "drives at their limit": {"drive_limited_share": 0.2},
    "drives that oscillate for a while": {"drive_oscillation_spell_s": 3.0},
    "outputs too rare to see oscillations": {"drive_oscillation_nm": math.nan},
    "energy from nowhere": {"energy_relative_residual": 0.5},
    "wheels that left the rollers for a while": {"contact_lost_s": 0.3},
    "wheels that hardly touch the rollers": {"contact_lost_s": 5e-3, "contact_lost_total_s": 0.6},
    "a sample beyond the peak of the creep curve": {"beyond_peak_s": 0.01},
    "the same test eight times": {"scatter": 0.0},
}


@pytest.mark.parametrize("bad", BAD_RUNS)
def test_nothing_is_met_by_a_bad_run(bad: str) -> None:
    """All other numbers agree exactly with the track's."""
    tracking, fidelity, rows = outcomes(records(), records(**BAD_RUNS[bad]))
    assert tracking != "met"
    assert fidelity != "met"
    agreeing = [row for row in rows.values() if row.group == "fidelity" and not row.gate]
    assert {row.outcome for row in agreeing} == {"not decided"}


def test_a_row_says_how_sure_it_is_also_where_it_is_met() -> None:
    fewer = records(dump_cycles=0.99 * GOOD["dump_cycles"])
    fewer[0] = replace(fewer[0], measures=fewer[0].measures | {"dump_cycles": 290.0})
    rows = outcomes(records(), fewer)[2]
    assert rows["distance"].told == "✔ met: stopping distance 0 %, target within 2 %"
    told = r"✔ met: dump cycles, all axles under test -1\.\d \(-2 … -0\.\d+\) %, target within 5 %"
    assert re.fullmatch(told, rows["dump_cycles"].told), rows["dump_cycles"].told


def test_finer_tests_that_say_nothing_leave_intervals_without_bounds() -> None:
    case, both = load_case("adhesion_brake"), (records(), records())
    some, nothing = (records(air_litres=value)[:3] for value in (GOOD["air_litres"], math.nan))
    for fine in ((nothing, nothing), (nothing, some)):
        found = {row.key: row for row in assessment_rows(case, both, fine)}
        assert found["air_litres"].outcome == "not decided"
        assert not found["air_litres"].value.interval.known
        assert found["dump_cycles"].outcome == "met"


def test_what_is_zero_on_track_alone_is_not_met_with_finer_tests_too() -> None:
    none = records(dump_cycles=0.0)
    rows = assessment_rows(load_case("adhesion_brake"), (none, records()), (none[:3], records()[:3]))
    assert {row.key: row.outcome for row in rows}["dump_cycles"] == "not met"


@pytest.mark.parametrize(
    "bad", [{"status": "contact_lost"}, {"energy_relative_residual": 0.5}, {"contact_lost_s": 0.3}]
)
def test_bad_finer_tests_have_a_row_of_their_own_and_leave_nothing_met(bad: dict[str, Any]) -> None:
    case = load_case("adhesion_brake")
    rows = {row.key: row for row in assessment_rows(case, (records(), records()), (records()[:3], records(**bad)[:3]))}
    assert rows["rig_ended"].outcome == "met"
    assert (rows["fine_sound"].outcome, rows["fine_sound"].value_text) == ("not decided", "3 of 6")
    assert {row.outcome for row in rows.values() if row.group == "fidelity" and not row.gate} == {"not decided"}
    assert outcome_of(list(rows.values()), "tracking") == "not decided"


def test_one_bad_test_of_eight_is_a_bad_run() -> None:
    rig = records()
    rig[3] = replace(rig[3], status="contact_lost")
    tracking, fidelity, rows = outcomes(records(), rig)
    assert tracking == "not met"
    assert fidelity == "not decided"
    assert rows["rig_ended"].value_text == "7 of 8"


@pytest.mark.parametrize(
    ("key", "change"), [("dump_cycles", 0.57), ("air_litres", 0.76), ("mean_deceleration_mps2", 1.03)]
)
def test_what_differs_from_the_track_is_not_met(key: str, change: float) -> None:
    changed: dict[str, Any] = {key: change * GOOD[key]}
    tracking, fidelity, rows = outcomes(records(), records(**changed))
    assert (tracking, fidelity) == ("met", "not met")
    assert rows[key].outcome == "not met"
    assert rows[key].value.mean == pytest.approx(change - 1.0, abs=2e-4)


def test_a_wide_interval_decides_nothing() -> None:
    row = Row("fidelity", "x", "x", Estimate(0.01, 0.02, 7.0), -0.02, 0.02, "")
    assert row.outcome == "not decided"
    assert replace(row, value=Estimate(0.01, 1e-3, 7.0)).outcome == "met"
    assert replace(row, value=Estimate(0.10, 1e-3, 7.0)).outcome == "not met"
    assert replace(row, value=Estimate(0.01, math.nan, 0.0)).outcome == "not decided"  # a single test


def test_a_size_is_within_its_target_also_where_starts_differ_by_more_than_their_mean() -> None:
    """A drive at its limit in one start of eight: the interval reaches below zero, which says nothing against it."""
    row = Row("tracking", "x", "x", Estimate(7e-5, 5e-5, 7.0), 0.0, 0.01, "")
    assert row.value.interval.low < 0.0
    assert row.outcome == "met"
    assert row.value_text == "0.007 (0 … 0.019) %"
    assert replace(row, value=Estimate(7e-3, 5e-3, 7.0)).outcome == "not decided"
    assert replace(row, value=Estimate(-0.03, 1e-3, 7.0), low=-0.02, high=0.02).outcome == "not met"


def test_the_force_of_an_axle_counts_once_it_has_slid() -> None:
    slips = np.array([[0.0], [0.0], [0.3], [0.3], [0.0], [0.0]])
    used = np.array([[0.5], [0.1], [0.06], [0.06], [0.417], [0.1]])
    assert adhesion_at_readhesion(slips, used) == 0.417
    assert math.isnan(adhesion_at_readhesion(0.0 * slips, used))


@pytest.mark.slow  # two runs of 12 s
def test_the_regrip_force_from_low_to_dry_is_said_not_to_be_reproduced() -> None:
    """The wheel's own inertia brakes it on dry rail with three times the demand; the drives cannot follow that."""
    case = load_case("adhesion_step").with_changes({"time.duration": "12 s", "contact.normal": "hertz"})
    track, rig = ([record_of(simulate(one), one)] * 2 for one in (track_case(case), case))
    assert track[0].measures["adhesion_at_readhesion"] > 0.3
    rows = assessment_rows(case, (track, rig))
    found = {row.key: row for row in rows}["adhesion_at_readhesion"]
    assert found.outcome == "not met"
    assert found.told.startswith("✘ NOT met: largest force on an axle that has slid (readhesion)")


@pytest.mark.slow  # a stop and a half
def test_a_locked_wheel_is_counted_as_long_as_it_is_locked() -> None:
    case = load_case("adhesion_brake").model_copy(update={"slide_protection": None})
    found = record_of(
        simulate(track_case(case).with_changes({"time.duration": "15 s", "contact.normal": "hertz"})), case
    )
    assert 9.0 < found.measures["longest_lock_s"] < 13.0
    assert found.measures["adhesion_at_readhesion"] > 0.05


# --------------------------------------------------------------------------------------------------------- the study


@pytest.mark.slow
def test_without_its_imperfections_the_rig_follows_better(numbers: dict[str, Any]) -> None:
    best = numbers["variants"]["estimator"]["tracking_rms"]["mean"]
    assert best < 0.8 * numbers["rig"]["tracking_rms"]["mean"]


@pytest.mark.slow
def test_real_sliding_is_gone_with_pure_rolling(outcome: Found[Runs]) -> None:
    """Real sliding does not count the bogie's swinging on its traction rod; that is there in both."""
    whole = outcome.results.whole
    assert float(abs(whole["rolling"]["longitudinal_velocity"].sel(body="wheelset_1")).max()) > 1e-3
    assert float(abs(whole["rolling"]["real_sliding"]).max()) < 1e-6
    assert float(abs(whole["rig"]["real_sliding"]).max()) > 5e-3


@pytest.mark.slow
def test_every_number_is_explained_and_written(outcome: Found[Runs], tmp_path: Path) -> None:
    written = {path.relative_to(tmp_path).as_posix() for path in outcome.write(tmp_path)}
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert unexplained(QUANTITIES, summary) == []
    pictures = {path for path in written if path.startswith("figures/")}
    others = {"track_quick.nc", "rig_quick.nc", "summary.json", "report.html", "timing.json", "view.html"}
    assert written - pictures == others
    assert "QUICK: degraded track" in (tmp_path / "view.html").read_text()
    assert {
        "figures/causes.png",
        "figures/slip_histogram.png",
        "figures/dead_time.png",
        "figures/sliding.png",
    } <= pictures
    assert "figures/traction.png" not in pictures  # a brake test
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page.index("<h2>Assessment</h2>") < page.index("<h2>Why rig and track differ</h2>")


@pytest.mark.slow
def test_the_summary_begins_with_the_verdict_and_says_how_limit_cycles_are_compared(outcome: Found[Runs]) -> None:
    lines = outcome.summary.splitlines()
    assert lines[1].startswith("Tracking, wheels of the rig against their virtual axles: ")
    assert lines[2].startswith("Fidelity, rig against track: ")
    rows = outcome.study.rows(outcome.results)
    told = lines[3 : 3 + len(rows)]
    assert sorted(told) == sorted(row.told for row in rows)
    outcomes = [line[0] for line in told]
    assert outcomes == sorted(outcomes, key="✘?✔".index)  # what is not met first
    assert set(outcomes) != {"✔"}
    assert any("not point by point" in line for line in lines)
    (dead_time,) = (line for line in lines if line.startswith("Equivalent dead time: "))
    assert dead_time.endswith("; measured: none, no track that was run has the rig's distance.")


@pytest.mark.slow
def test_one_and_two_processes_find_the_same_to_the_last_bit() -> None:
    case = load_case("adhesion_brake").with_changes({"time.duration": "0.6 s", "contact.normal": "hertz"})
    one, two = (AdhesionStudy(case, error_budget=False, quick=True).run(processes=count) for count in (1, 2))
    assert one is not None
    assert two is not None
    assert one.numbers == two.numbers
    assert all(run.identical(two.results.whole[name]) for name, run in one.results.whole.items())


def test_a_case_without_a_rig_controller_is_refused() -> None:
    with pytest.raises(ConfigError, match="rig_control: missing"):
        AdhesionStudy(load_case("bogie_rollers_constant"))


def test_variants_are_cases() -> None:
    """They survive the checks that a file goes through, and take away what they say."""
    case = load_case("adhesion_start")
    for name in variants_of(case):
        changed = variant(case, name)
        assert case_from_toml(changed.to_toml()) == changed
    best = variant(case, "estimator")
    assert best.rig_control is not None
    assert best.rig_control.estimator.kind == "exact"
    assert best.contact.pure_rolling
    assert not variant(case, "static_loads").contact.pure_rolling
    assert "static_loads" not in variants_of(case.with_changes({"rig_control.load_transfer": "none"}))
