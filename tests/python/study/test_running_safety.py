"""Running safety as a user reads it off `run`: sections, limits, filtered forces beside raw ones, contact that was lost."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig.analysis.assessment import Row
from rollerrig.analysis.wheel_rail_forces import WHOLE_RUN, filtered, test_zone, track_sections, wheel_forces
from rollerrig.plot.wheel_rail_forces import track_shifting
from rollerrig.study.frame import Outcome
from rollerrig.study.report import Table
from rollerrig.study.run import Results, RunStudy

test_zone.__test__ = False  # type: ignore[attr-defined]  # a function of that name is no test

CURVE = "3 curve R 600 m left, test zone 3"


def outcome_of(case: rr.Case) -> Outcome[Results]:
    found = RunStudy(case).run()
    assert found is not None
    return found


HERTZ = {"contact.normal": "hertz", "contact.creep": "kalker_saturated"}
RIGID = {"support.foundation": None}
"""Ellipses that come and go shake the wheels: what is to be filtered, and what the values here were checked with."""


@pytest.fixture(scope="module")
def curve() -> Outcome[Results]:
    return outcome_of(rr.load_case("vehicle_curve").with_changes({**HERTZ, **RIGID}))


def row(outcome: Outcome[Results], quantity: str, place: str, section: str = WHOLE_RUN) -> Row:
    wanted = (quantity, place, section)
    return next(r for r in outcome.results.rows if (r.quantity, r.place, r.section) == wanted)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("point", "lowest", "highest"),
    [("car_body over rear_frame", -0.070, 0.042), ("car_body over front_frame", -0.125, 0.074)],
)
def test_a_car_body_feels_no_kinks_of_the_cant_over_its_bogies(
    curve: Outcome[Results], point: str, lowest: float, highest: float
) -> None:
    """Reference: the same run, by an observer who differentiated the path of the points in the ground, three decimals."""
    found = row(curve, "lateral_acceleration", point).statistics
    assert found["percentile_0_15"] == pytest.approx(lowest, abs=6e-4)
    assert found["percentile_99_85"] == pytest.approx(highest, abs=6e-4)


@pytest.mark.slow
def test_sections_of_a_curve_have_names_and_only_the_constant_ones_quasi_static_values(curve: Outcome[Results]) -> None:
    rows = [r for r in curve.results.rows if (r.quantity, r.place) == ("guiding_force", "wheelset_1_right")]
    found = {r.section: r.statistics["quasi_static"] for r in rows}
    assert list(found) == [WHOLE_RUN, "1 straight", "2 transition", CURVE, "4 transition", "5 straight"]
    assert {name for name, value in found.items() if np.isnan(value)} == {WHOLE_RUN, "2 transition", "4 transition"}
    # The vehicle is 19 + 2.56 m from its first to its last wheelset; the curve lies from 130 to 330 m.
    forces = wheel_forces(curve.results.run)
    inside = (forces["distance"] > 130 + 10.78) & (forces["distance"] < 330 - 10.78)
    median = float(forces["guiding_force"].sel(wheel="wheelset_1_right")[inside].median())
    assert median == pytest.approx(13.34e3, rel=1e-3)
    assert found[CURVE] == pytest.approx(median, rel=1e-4)  # filtered or not: a median of what hardly changes
    assert found["1 straight"] == pytest.approx(560, rel=0.01)
    named = forces["section"].to_numpy()
    assert list(dict.fromkeys(named.tolist())) == list(found)[1:]
    assert (named == CURVE).tolist() == inside.to_numpy().tolist()


@pytest.mark.slow
def test_sections_stand_in_table_file_and_summary(curve: Outcome[Results]) -> None:
    own = curve.numbers["running_safety"]["guiding_force"]["wheelset_1_right"]["sections"]
    assert own[CURVE]["quasi_static"] == pytest.approx(13.34e3, rel=1e-3)
    assert own["2 transition"]["quasi_static"] is None
    assert own["2 transition"]["percentile_99_85"] > 13e3
    assert curve.study.files(curve.results, curve.numbers)["running_safety.csv"][0][:3] == [
        "quantity",
        "place",
        "section",
    ]
    captions = [table.caption for table in tables_of_safety(curve)]
    assert captions == [WHOLE_RUN, "1 straight", "2 transition", CURVE, "4 transition", "5 straight"]


def tables_of_safety(outcome: Outcome[Results]) -> list[Table]:
    sections = outcome.study.sections(outcome.results, outcome.numbers)
    safety = next(s for s in sections if s.title == "Wheel-rail forces and running safety")
    return [block for block in safety.blocks if isinstance(block, Table)]


@pytest.mark.slow
def test_the_limit_of_the_sum_of_guiding_forces_is_one_in_table_and_figure(curve: Outcome[Results]) -> None:
    limit = row(curve, "guiding_force_sum", "wheelset_1").limit
    assert limit == pytest.approx(10e3 + 2.0 / 3.0 * 54.546e3, rel=1e-3)
    figure = track_shifting(curve.results.assessment.assessed)
    words = [text.get_text() for axes in figure.axes for text in (axes.title, axes._left_title, axes._right_title)]  # type: ignore[attr-defined]
    assert any("46.4 kN" in text for text in words)
    shown = next(line for line in tables_of_safety(curve)[0].rows if "ΣY" in str(line[0]))
    assert "46.4" in [str(cell) for cell in shown]
    assert f"{100 * row(curve, 'guiding_force_sum', 'wheelset_1').part_of_limit:.1f}" == "11.6"


@pytest.mark.parametrize(("radius", "zone"), [(5000, 2), (601, 2), (600, 3), (400, 3), (399, 4), (250, 4), (249, None)])
def test_zones_by_radius(radius: float, zone: int | None) -> None:
    assert test_zone(radius) == zone


def test_a_run_that_brakes_has_no_quasi_static_values_and_one_on_straight_track_one_section() -> None:
    case = rr.load_case("bogie_track").with_changes({"time.duration": "0.2 s", "disturbance": []})
    slowing = case.with_changes({"motion.speed_table": [[0.0, "200 km/h"], [0.2, "150 km/h"]]})
    for chosen, constant in ((case, True), (slowing, False)):
        (section,) = track_sections(rr.simulate(chosen))
        assert (section.name, section.constant, section.within.all()) == ("straight", constant, True)
    (rollers,) = track_sections(rr.simulate(rr.load_case("wheelset_rollers").with_changes({"time.duration": "10 ms"})))
    assert rollers.name == "rollers"


# ------------------------------------------------------------------------------------------------ filtered and raw


IRREGULAR = {"time.duration": "4 s", **HERTZ}


@pytest.fixture(scope="module")
def irregular() -> Outcome[Results]:
    """At the default output step, 10 ms, with which 20 Hz cannot be filtered from the output times."""
    case = rr.load_case("vehicle_track_irregular").with_changes({**IRREGULAR, "time.output_step": "10 ms"})
    return outcome_of(case)


@pytest.fixture(scope="module")
def dense() -> xr.Dataset:
    """The same run, kept every 0.4 ms."""
    return rr.simulate(
        rr.load_case("vehicle_track_irregular").with_changes({**IRREGULAR, "time.output_step": "0.4 ms"})
    )


@pytest.mark.slow
def test_forces_are_filtered_at_the_default_output_step_and_right(
    irregular: Outcome[Results], dense: xr.Dataset
) -> None:
    """Wheelsets vibrate on their contacts at 240 Hz: forces kept every 5 or 10 ms would fold that below 20 Hz."""
    found, exact = irregular.results.assessment.assessed, filtered(wheel_forces(dense))
    assert found["wheel_load"].attrs["filter"] == "20 Hz"
    assert "not filtered" not in " ".join(irregular.numbers["running_safety_notes"])
    at_outputs = exact.sel(time=found["time"], method="nearest")
    for name in ("wheel_load", "guiding_force", "guiding_force_sum", "derailment_quotient"):
        spread = float(at_outputs[name].std("time").max())
        deviation = (found[name] - at_outputs[name].to_numpy()).std("time")
        assert float(deviation.max()) < 0.06 * spread, name  # what a reading every 1 ms still folds down
    by_outputs = dense.isel(time=slice(0, None, 12))  # every 4.8 ms, without readings: what was done before
    folded = filtered(wheel_forces(by_outputs))["wheel_load"].std("time")
    assert float((folded / exact["wheel_load"].std("time")).max()) > 2.0


@pytest.mark.slow
def test_readings_are_the_forces_of_the_run_between_its_outputs(irregular: Outcome[Results], dense: xr.Dataset) -> None:
    run = irregular.results.run
    assert run.sizes["time"] == 401
    assert run["reading_time"].to_numpy() == pytest.approx(np.arange(4001) * 1e-3, abs=1e-12)
    assert run["reading_vertical_force"][::10].to_numpy() == pytest.approx(run["vertical_force"].to_numpy(), rel=1e-15)
    both = dense["vertical_force"][::5].to_numpy()  # every 2 ms
    assert run["reading_vertical_force"][::2].to_numpy() == pytest.approx(both, rel=1e-9, abs=1e-3)
    part = wheel_forces(run.sel(time=slice(1.0, 2.0)))
    assert (float(part["reading_time"][0]), float(part["reading_time"][-1])) == pytest.approx((1.0, 2.0))


@pytest.mark.slow
def test_extremes_are_filtered_and_what_is_raw_is_called_raw(irregular: Outcome[Results]) -> None:
    wheels = irregular.numbers["wheels"]
    assert min(wheel["vertical_force_least_raw_n"] for wheel in wheels.values()) == 0.0
    assert all(wheel["wheel_load_least_n"] > 44e3 for wheel in wheels.values())
    assert all(wheel["derailment_quotient_largest"] < 0.2 for wheel in wheels.values())
    first, *_, last = irregular.study.sections(irregular.results, irregular.numbers)
    shown, folded = (
        next(set(block.header) for block in section.blocks if isinstance(block, Table) and block.header[0] == "wheel")
        for section in (first, last)
    )
    assert {"least Q [N]", "largest Y/Q [-]"} <= shown
    assert not any("raw" in heading for heading in shown)
    assert {"least Q, raw [N]", "largest Y/Q, raw [-]"} <= folded
    assert last.folded


@pytest.mark.slow
def test_the_report_explains_wheels_that_are_unloaded_for_moments(irregular: Outcome[Results]) -> None:
    sections = irregular.study.sections(irregular.results, irregular.numbers)
    texts = [str(block) for section in sections for block in section.blocks]
    assert any("vibrate" in text and "unloaded for moments" in text for text in texts)


def test_smooth_contact_leaves_no_wheel_unloaded_on_the_same_rails() -> None:
    """What unloads them is the jump of the force between Hertz patches, not the rails."""
    case = rr.load_case("vehicle_track_irregular").with_changes({"time.duration": "2 s"})
    study = outcome_of(case)
    assert min(wheel["vertical_force_least_raw_n"] for wheel in study.numbers["wheels"].values()) > 44e3
    assert study.results.run.attrs["warnings"] == ""


def test_a_case_that_keeps_little_has_no_readings() -> None:
    case = rr.load_case("bogie_track").with_changes({"time.duration": "0.2 s", "time.output_step": "50 ms"})
    assert "reading_time" not in rr.simulate(case).variables
    alone = rr.load_case("adhesion_brake").model_copy(
        update={"rig_control": None, "adhesion": None, "slide_protection": None}
    )
    run = rr.simulate(alone.with_changes({"time.duration": "0.1 s", "time.sampling_step": "2 ms"}))
    # Outputs every 10 ms: every 2 ms is the closest that the samples allow.
    assert run["reading_time"].to_numpy() == pytest.approx(np.arange(51) * 2e-3)


# ------------------------------------------------------------------------------------------------ lost contact


def test_wheels_that_lose_contact_are_named_with_time_and_place() -> None:
    drop = [{"body": "wheelset_1", "vertical": "3 mm"}]
    case = rr.load_case("bogie_track").with_changes({"time.duration": "1 s", "disturbance": drop})
    study = outcome_of(case)
    run = study.results.run
    assert run.attrs["status"] == "ok"
    losses = json.loads(run.attrs["contact_losses"])
    assert {loss["wheel"] for loss in losses} == {"wheelset_1_left", "wheelset_1_right"}
    first = losses[0]
    off = run["patch_count"].sel(wheel=first["wheel"]).to_numpy() == 0
    step = float(run["time"][1])
    assert first["total_s"] == pytest.approx(step * np.count_nonzero(off), abs=2 * step * first["spells"])
    assert first["longest_from_m"] == pytest.approx(first["longest_from_s"] * float(run["speed"][0]))
    warning, coarse = run.attrs["warnings"].splitlines()
    assert "steps have an error above the tolerance" in coarse  # a 32nd of 1 ms does not resolve the bounce
    assert warning.startswith("wheels lost contact: wheelset_1_left without contact")
    assert f"{1e3 * first['longest_s']:.3g} ms at t = {first['longest_from_s']:.4g} s" in warning
    assert any(
        line.startswith("Warning: wheels lost contact") for line in study.study.summary(study.results, study.numbers)
    )
    assert study.numbers["wheels"]["wheelset_1_left"]["without_contact_longest_s"] == first["longest_s"]


def test_round_off_is_no_result() -> None:
    """A wheelset in the middle does not move: 1e-17 m is not shown as a displacement, nor 1e-12 N as a force."""
    case = rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.2 s", "disturbance": []})
    study = outcome_of(case)
    body = study.numbers["bodies"]["wheelset_1"]
    assert (body["lateral_largest_mm"], body["lateral_end_mm"], body["yaw_largest_mrad"]) == (0.0, 0.0, 0.0)
    sums = study.numbers["running_safety"]["guiding_force_sum"]["wheelset_1"]["sections"]["rollers"]
    assert all(value == 0.0 for name, value in sums.items() if np.isfinite(value))
