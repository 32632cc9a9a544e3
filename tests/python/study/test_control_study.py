"""`rollerrig control`: variants, values that fail, the files, and what is refused."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from reported import unexplained
from rollerrig import ConfigError, load_case, simulate
from rollerrig.analysis.slide_statistics import unwanted_ripple
from rollerrig.config import Case
from rollerrig.config.schema.contact import kinds
from rollerrig.config.schema.rig_control import ESTIMATORS, AnyFeedback
from rollerrig.study import control
from rollerrig.study.control import ControlStudy, Found, ranking, run_variant, study_case
from rollerrig.study.frame import Outcome
from rollerrig.study.report import Table
from rollerrig.study.runs.control import FAMILIES, TRACKING_LIMIT, USER, Family, Result
from rollerrig.study.runs.control import FEEDBACKS as FEEDBACK_VARIANTS

MINE = """
class FeedForward:
    sample_time = 1e-3

    def step(self, measurements):
        return {"roller_torque": measurements["feed_forward"]}
"""


def brake(duration: float = 3.0) -> Case:
    """The contact is not what is compared: ellipses, which are fast."""
    return study_case(load_case("adhesion_brake").with_changes({"contact.normal": "hertz"}), duration)


def family(name: str, values: tuple[float, ...], *curves: str) -> Family:
    found = next(f for f in FAMILIES if f.name == name)
    return replace(found, values=values, curves={key: found.curves[key] for key in curves or found.curves})


def compared(families: list[Family], duration: float, **options: Any) -> Outcome[Found] | None:
    """A study of these families in place of the shipped ones."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(control, "FAMILIES", families)
        progress = options.pop("progress", None)
        return ControlStudy(brake(duration), loop=False, **options).run(progress=progress)


@pytest.fixture(scope="module")
def outcome(tmp_path_factory: pytest.TempPathFactory) -> Outcome[Found]:
    file = tmp_path_factory.mktemp("mine") / "mine.py"
    file.write_text(MINE)
    families = [
        family("drive_bandwidth", (0.2, 5.0, 50.0), "PI", "no feedback"),
        family("assumed_parameters", (-5.0, 0.0, 5.0), "wheel radius", "roller inertia"),
    ]
    found = compared(families, 5.0, user=f"{file}:FeedForward")
    assert found is not None
    return found


def curve(outcome: Outcome[Found], family: str, label: str) -> list[Result]:
    return [r for r in outcome.results.results if (r.family, r.curve) == (family, label)]


def test_families_change_what_they_say() -> None:
    """Every variant of every family is a case that a file could hold, and each value makes another one."""
    case = brake()
    for each in FAMILIES:
        for label, curve in each.curves.items():
            changed = [case.with_changes(each.changes(case, curve, value)) for value in each.values]
            assert len({one.to_toml() for one in changed}) == len(each.values), (each.name, label)
        assert list(each.values) == sorted(each.values)
        if (base := each.base(case)) is not None:
            assert each.values[0] <= base <= each.values[-1], each.name


def test_every_estimator_and_feedback_of_the_case_file_is_compared() -> None:
    case = brake()
    for name, part, known in (
        ("sample_time", "estimator", ESTIMATORS),
        ("drive_bandwidth", "feedback", kinds(AnyFeedback)),
    ):
        found = next(f for f in FAMILIES if f.name == name)
        variants = [case.with_changes(found.changes(case, curve, found.values[0])) for curve in found.curves.values()]
        assert {getattr(variant.rig_control, part).kind for variant in variants} == set(known), name


def test_kinds_of_a_scaled_case_have_numbers_at_its_scale() -> None:
    """1:5, DLR: torque over 312.5, angular speed times sqrt(5)."""
    case = load_case("scaled_brake")
    feedback = case.with_changes(FEEDBACK_VARIANTS["sliding mode"](case, 1.0)).rig_control.feedback
    assert (feedback.switching, feedback.largest) == pytest.approx((3.2, 64.0))
    assert feedback.boundary_layer == pytest.approx(0.5 * math.sqrt(5.0))


@pytest.mark.slow
def test_a_users_controller_is_compared_at_every_bandwidth(outcome: Outcome[Found]) -> None:
    built_in, mine = curve(outcome, "drive_bandwidth", "no feedback"), curve(outcome, "drive_bandwidth", USER)
    assert [one.value for one in mine] == [one.value for one in built_in]
    assert any(r.curve == USER for r in outcome.results.references)


@pytest.mark.parametrize("bandwidth", ["5 Hz", "50 Hz"])
def test_a_users_feed_forward_is_the_built_in_one_without_feedback(bandwidth: str, tmp_path: Path) -> None:
    """The user is given the feed-forward torque: posting it is `no feedback`, as long as no limit of torque is met.

    In steps of one length: which predictions `exponential_adams` keeps is decided by round-off, and with them the run within
    its tolerance.
    """
    (tmp_path / "mine.py").write_text(MINE)
    steps = {"time.method": "exponential_rk4", "time.step": "1 ms", "rig_control.motor.bandwidth": bandwidth}
    case = brake(2.5).with_changes(steps)
    built_in = simulate(case.with_changes({"rig_control.feedback.kind": "none"}))
    mine = simulate(case.with_changes({"rig_control.user": f"{tmp_path / 'mine.py'}:FeedForward"}))
    assert float(abs(built_in["roller_torque"]).max()) < 2e4
    assert float(abs(built_in["axle_speed"] - built_in["virtual_speed"]).max()) > 1e-3
    for name in ("axle_speed", "roller_torque", "creep_force"):
        scale = float(abs(built_in[name]).max())
        np.testing.assert_allclose(mine[name], built_in[name], rtol=0.0, atol=1e-9 * scale)


@pytest.mark.slow
def test_feedback_and_fast_drives_help(outcome: Outcome[Found]) -> None:
    curves = {name: curve(outcome, "drive_bandwidth", name) for name in ("PI", "no feedback")}
    errors = {name: [r.numbers["tracking_rms"] for r in points] for name, points in curves.items()}
    assert errors["PI"] == sorted(errors["PI"], reverse=True)
    assert all(a <= b for a, b in zip(errors["PI"][1:], errors["no feedback"][1:], strict=True))
    assert errors["PI"][0] > TRACKING_LIMIT > errors["PI"][1]


@pytest.mark.slow
def test_the_ranking_begins_with_what_ended_early(outcome: Outcome[Found]) -> None:
    ranks = outcome.numbers["ranking"]
    assert (ranks[0]["family"], ranks[0]["curve"]) == ("assumed_parameters", "wheel radius")
    assert ranks[0]["failures"] == {"rollers_protected": [-5.0, 5.0]}
    assert "roller inertia" in {r["curve"] for r in ranks if not r["failures"]}
    slow = next(r for r in ranks if (r["family"], r["curve"]) == ("drive_bandwidth", "PI"))
    assert slow["failures"] == {"tracking": [0.2]}


@pytest.mark.parametrize(("percent", "ends"), [(2.9, False), (-2.9, False), (-3.1, True)])
def test_a_wrong_radius_trips_the_protection_where_it_should(percent: float, ends: bool) -> None:
    """It sees (r^ - r) w, at 120 km/h and a limit of 1 m/s from 3 % on, though nothing slides."""
    case = brake(1.0).with_changes({"rig_control.assumed.wheel_radius": 0.46 * (1 + 0.01 * percent)})
    assert case.rig_control is not None
    assert (abs(0.01 * percent) * case.motion.speed > case.rig_control.protection.slip) == ends
    numbers = run_variant(case)
    assert (numbers["status"] == "rollers_protected") == ends
    assert numbers["real_sliding_largest_mps"] < 0.05


def result(value: float, rms: float, ripple: float = 1.0, status: str = "ok") -> Result:
    return Result("f", "c", value, {"status": status, "tracking_rms": rms, "ripple_nm": ripple, "ended_s": 1.0})


def test_all_values_that_fail_are_named_and_none_that_passes() -> None:
    """Torque ripple over the gains rises above its limit and falls below it again; one test ends early beyond."""
    gains = family("feedback_gain", (1.0, 16.0, 32.0, 64.0, 256.0), "PI")
    ripples = {1.0: 5.0, 16.0: 250.0, 32.0: 1000.0, 64.0: 250.0, 128.0: 700.0}
    points = [result(value, 0.001, ripple) for value, ripple in ripples.items()]
    points.append(result(256.0, 0.001, status="contact_lost"))
    points = [replace(point, family=gains.name, curve="PI") for point in points]
    (rank,) = ranking([gains], points)
    assert rank.failures == {"ripple": [32.0, 128.0], "contact_lost": [256.0]}
    assert rank.failures_text == (
        "torque ripple above 500 N m RMS for 5 % of the time at 32×, 128× and contact lost, test ends early, at 256×"
    )
    assert rank.worst.value == 256.0
    (rank,) = ranking([gains], points[:-1])
    assert rank.worst.value == 32.0
    (rank,) = ranking([gains], points[:2])
    assert (rank.failures, rank.failures_text) == ({}, "")
    (rank,) = ranking([gains], [replace(points[0], numbers={**points[0].numbers, "tracking_rms": 0.02})])
    assert rank.failures_text == "tracking error above 1 % RMS at 1×"


def test_an_oscillation_for_a_part_of_the_test_fails() -> None:
    """A third of the time: the median of windows would not see it. What the virtual rail itself demands is none."""
    time = np.arange(0.0, 15.0, 2e-3)
    fast = 1000.0 * np.sin(2 * np.pi * 27.0 * time) * ((time > 5.0) & (time < 10.0))
    demanded = 2000.0 * np.sin(2 * np.pi * 12.0 * time)
    forces = {"virtual_force": demanded, "creep_force": demanded + fast}
    run = xr.Dataset({name: (("time", "axle"), value[:, None]) for name, value in forces.items()}, {"time": time})
    ripple = unwanted_ripple(run, roller_radius=0.7)
    assert ripple.rms == pytest.approx(700.0 / math.sqrt(2.0), rel=0.03)
    assert ripple.spell == pytest.approx(5.0, abs=0.51)
    assert ripple.frequency == pytest.approx(27.0, abs=1.0)
    assert unwanted_ripple(run.assign(creep_force=run["virtual_force"]), 0.7).rms == 0.0


def test_half_a_run_is_no_result() -> None:
    def pressed(_fraction: float, _text: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_variant(brake(), pressed)


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_there() -> None:
    calls = []

    def pressed(fraction: float, _text: str) -> None:
        calls.append(fraction)
        if fraction > 0.5:
            raise KeyboardInterrupt

    families = [family("drive_bandwidth", (5.0, 20.0, 50.0, 100.0, 200.0), "PI")]
    found = compared(families, 1.0, progress=pressed)
    assert calls
    assert found is not None
    assert found.interrupted
    assert found.results.references[0].curve == "as shipped"
    assert len(found.results.results) < 5
    assert found.statuses == ["interrupted"]
    references = replace(found.results, results=[])  # interrupted, or shown for the first time, before any variant
    assert found.study.sections(references, found.study.numbers(references))


@pytest.mark.slow
def test_files_hold_every_run_and_every_number_is_explained(outcome: Outcome[Found], tmp_path: Path) -> None:
    files = {path.name for path in outcome.write(tmp_path)}
    assert {"variants.csv", "summary.json", "report.html", "drive_bandwidth.png"} <= files
    with (tmp_path / "variants.csv").open() as lines:
        rows = list(csv.DictReader(lines))
    runs = [*outcome.results.references, *outcome.results.results]
    assert [(r["family"], r["curve"]) for r in rows] == [(r.family, r.curve) for r in runs]
    assert [float(r["tracking_rms"]) for r in rows] == pytest.approx(
        [r.numbers["tracking_rms"] for r in runs], rel=1e-8
    )
    assert unexplained(outcome.study.quantities, json.loads((tmp_path / "summary.json").read_text())) == []


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
        ControlStudy(brake(), ("drive_bandwith",))
    with pytest.raises(ConfigError, match="nowhere"):
        ControlStudy(brake(), user="nowhere.py:Mine")


def test_the_duration_only_shortens() -> None:
    assert study_case(load_case("adhesion_brake"), 100.0).time.duration == load_case("adhesion_brake").time.duration
    assert study_case(load_case("adhesion_brake"), 5.0).time.duration == 5.0


@pytest.mark.slow
def test_tables_show_errors_in_the_unit_of_their_heading(outcome: Outcome[Found]) -> None:
    tables = [block for section in outcome.study.sections(outcome.results, outcome.numbers) for block in section.blocks
              if isinstance(block, Table) and "tracking RMS [%]" in block.header]  # fmt: skip
    worst, references = tables
    assert worst.caption == "every curve, the worst first"
    assert [row[0] for row in references.rows] == ["as shipped", USER]
    shipped = outcome.results.references[0].numbers["tracking_rms"]
    assert float(str(references.rows[0][references.header.index("tracking RMS [%]")])) == pytest.approx(
        100 * shipped, rel=0.01
    )
    ranked = {(rank["family"], rank["curve"]): rank for rank in outcome.numbers["ranking"]}
    assert len(ranked) == len(worst.rows)
    for row, rank in zip(worst.rows, outcome.numbers["ranking"], strict=True):
        error = row[worst.header.index("tracking RMS [%]")]
        assert error == "ended early" or float(str(error)) == pytest.approx(100 * rank["worst_tracking_rms"], rel=0.01)
