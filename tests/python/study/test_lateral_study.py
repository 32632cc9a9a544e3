"""`rollerrig lateral`: sliding wheels against the closed form, hunting on rig and track, what is refused."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from reported import unexplained
from rollerrig import ConfigError, load_case, load_run, simulate
from rollerrig.assembly.laws import linear_coefficients
from rollerrig.common.arrays import Array
from rollerrig.config import Case
from rollerrig.study.frame import Outcome
from rollerrig.study.lateral import LABELS, Found, LateralStudy, amplitude, run_numbers, slide_begins

Study = Outcome[Found]

MEMBERS = 3
"""Of the ensembles here, in place of the study's own number."""


@pytest.fixture(scope="module")
def outcome() -> Study:
    case = load_case("adhesion_lateral").with_changes({"time.duration": "6 s"})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rollerrig.study.lateral.MEMBERS", MEMBERS)
        found = LateralStudy(case).run()
    assert found is not None
    assert set(found.results.runs) == set(LABELS)
    return found


def guidance(run: xr.Dataset) -> tuple[Array, Array, float]:
    """Lateral creep force of axles while they slide at more than 1 m/s, and the sum of -F v_y / v_s over their wheels, [N].

    Last the damping of one of these wheels, the median of F / v_s [N s/m].
    """
    axles = (run.sizes["time"], run.sizes["axle"], 2)  # wheels stand left and right of each axle, in order
    along, across = (run[f"{name}_sliding"].to_numpy().reshape(axles) for name in ("longitudinal", "lateral"))
    x, y = (run[f"patch_creep_force_{way}"].sum("patch").to_numpy().reshape(axles) for way in "xy")
    fully = (np.abs(along) > 1.0).all(axis=-1)
    total, speed = np.hypot(x, y)[fully], np.hypot(along, across)[fully]
    return y[fully].sum(axis=-1), -(total * across[fully] / speed).sum(axis=-1), float(np.median(total / speed))


def rolling_damping(case: Case, run: xr.Dataset) -> float:
    """f22 / V of linear theory, of the mean wheel at the start [N s/m]."""
    first = run.isel(time=0)
    axes = zip(*(first[name].to_numpy().ravel() for name in ("patch_a", "patch_b")), strict=True)
    f22 = sum(linear_coefficients(case.contact, a, b)[1] for a, b in axes if min(a, b) > 0.0) / first.sizes["wheel"]
    return f22 / float(run["rolling_speed"][0, 0])


@pytest.mark.slow
def test_a_sliding_wheel_is_guided_by_viscous_friction_alone(outcome: Study) -> None:
    """Friction opposes sliding: F_y = -F v_y / w. The exact theory gets there; Kalker's saturated by length keeps f22 / f11."""
    assert isinstance(outcome.study, LateralStudy)
    case, track = outcome.study.cases()["track"], outcome.results.runs["track"]
    force, expected, sliding = guidance(track)
    # The table is within 2 % of the friction limit; at w > 1 m/s creepage is 20 times that of saturation.
    assert np.dot(expected, force) / np.dot(expected, expected) == pytest.approx(1.0, abs=0.02)
    assert np.corrcoef(expected, force)[0, 1] > 0.999
    assert sliding < 0.02 * rolling_damping(case, track)  # weak guidance
    force, expected, _ = guidance(simulate(case.with_changes({"contact.creep": "kalker_saturated"})))
    # f22 / f11 is 0.80 for the whole wheel, and differs from patch to patch
    assert 0.78 < np.dot(expected, force) / np.dot(expected, expected) < 0.95


@pytest.mark.slow
def test_hunting_decays_on_the_degraded_track_and_persists_on_the_rig(outcome: Study) -> None:
    begin = slide_begins(outcome.results.runs["track"])
    assert 3.0 < begin < 4.5  # low adhesion begins at 3 s
    found = outcome.numbers["runs"]
    assert outcome.numbers["slide_begins_s"] == begin
    assert found["track"]["amplitude_before_mm"] > 1.0
    assert found["track"]["amplitude_in_slide_mm"] < 0.2
    assert found["track_dry"]["amplitude_in_slide_mm"] > 1.0
    for key in ("rig", "rig_rigid"):
        assert found[key]["amplitude_in_slide_mm"] > 2.0
    assert found["rig"]["roller_lateral_mm"] > 0.5
    assert found["rig_rigid"]["roller_lateral_mm"] == 0.0


@pytest.mark.slow
def test_the_control_runs_tell_the_slide_from_the_rail(outcome: Study) -> None:
    """Unbraked no wheel slides. On the contaminated rail hunting ends all the same; with k_A = k_S = 1 only the slide ends it."""
    found = outcome.numbers["runs"]
    for key in ("track_unbraked", "track_stiff_unbraked"):
        assert found[key]["largest_slip"] < 0.01
        assert found[key]["amplitude_before_mm"] > 1.0
    assert found["track_stiff"]["largest_slip"] > 0.05
    assert found["track_unbraked"]["amplitude_in_slide_mm"] < 0.3
    assert found["track_stiff_unbraked"]["amplitude_in_slide_mm"] > 1.0
    assert found["track_stiff"]["amplitude_in_slide_mm"] < 0.1
    told = str(outcome.summary)
    for key, end in (("track_unbraked", "dies"), ("track_stiff_unbraked", "goes on"), ("track_stiff", "dies")):
        assert re.search(rf"Hunting, {LABELS[key]}: [^:]*: it {end}", told)
    runs = {
        **outcome.results.runs,
        "track_stiff": outcome.results.runs["track_stiff"].assign_attrs(status="off_profile"),
    }
    told = str(outcome.study.summary(replace(outcome.results, runs=runs), outcome.numbers))
    assert f"Hunting, {LABELS['track_stiff_unbraked']}:" in told
    assert f"Hunting, {LABELS['track_stiff']}:" not in told  # a run that ended early says neither


@pytest.mark.slow
def test_figures_of_runs_that_strike_are_means_with_errors(outcome: Study) -> None:
    again = outcome.numbers["ensemble"]
    assert set(again) == {"rig", "rig_rigid"}
    for key, one in again.items():
        members = [outcome.numbers["runs"][key], *outcome.results.repeated[key]]
        assert len(members) == MEMBERS
        sliding = [member["real_sliding_largest_mps"] for member in members]
        assert one["real_sliding_largest_mps"] == pytest.approx(np.mean(sliding))
        assert one["real_sliding_largest_mps_standard_error"] == pytest.approx(np.std(sliding, ddof=1) / MEMBERS**0.5)
    # 1e-9 of the disturbance moves the run on elastic rollers, whose flanges strike
    assert again["rig"]["real_sliding_largest_mps_standard_error"] > 1e-6


@pytest.mark.slow
def test_hunting_disturbs_the_control(outcome: Study) -> None:
    errors = {key: outcome.numbers["runs"][key]["tracking_rms"] for key in ("rig", "rig_rigid", "rig_centred")}
    assert errors["rig"] > 2.0 * errors["rig_rigid"] > 4.0 * errors["rig_centred"] > 0.0
    assert errors["rig"] < 0.01  # and yet stays within the project's aim


@pytest.mark.slow
def test_slip_on_the_rig_is_that_of_the_virtual_wheels(outcome: Study) -> None:
    """Real wheels that strike with their flanges slide on the rollers: that is no slip of the train."""
    run = outcome.results.runs["rig"]
    for name in ("virtual_speed", "axle_speed"):
        slip = abs(0.46 * run[name] / run["train_speed"] - 1.0).where(run["train_speed"] > 2.0)
        same = float(slip.max()) == pytest.approx(outcome.numbers["runs"]["rig"]["largest_slip"], rel=1e-6)
        assert same == (name == "virtual_speed")


@pytest.mark.slow
def test_a_bogie_in_the_middle_stays_there(outcome: Study) -> None:
    """Left and right are alike: rounding alone moves it, whatever the wheels do along the track."""
    assert run_numbers(outcome.results.runs["rig_centred"], 4.0)["largest_lateral_mm"] < 1e-6


def test_amplitudes() -> None:
    time = np.arange(0.0, 4.0, 1e-3)
    values = 3.0 + np.sin(2.0 * np.pi * 5.0 * time)
    assert amplitude(time, values, 1.0, 2.0) == pytest.approx(1.0, abs=1e-4)
    assert np.isnan(amplitude(time, values, 10.0, 11.0))


@pytest.mark.slow
def test_files_hold_every_run_and_every_number_is_explained(outcome: Study, tmp_path: Path) -> None:
    files = {path.name for path in outcome.write(tmp_path)}
    assert {f"{key}.nc" for key in LABELS} | {
        "summary.json",
        "timing.json",
        "report.html",
        "motion.png",
    } <= files
    numbers = json.loads((tmp_path / "summary.json").read_text())
    assert unexplained(outcome.study.quantities, numbers) == []
    assert run_numbers(load_run(tmp_path / "rig.nc"), numbers["slide_begins_s"]) == numbers["runs"]["rig"]


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"support.mounting": None, "support.changes": None}, "support.mounting"),
        ({"disturbance": []}, "disturbance"),
        ({"adhesion": None}, "adhesion"),
        ({"rig_control": None, "adhesion": None}, "rig_control"),
    ],
)
def test_cases_that_say_nothing_about_it_are_refused(changes: dict[str, object], key: str) -> None:
    with pytest.raises(ConfigError, match=key):
        LateralStudy(load_case("adhesion_lateral").with_changes(changes))
