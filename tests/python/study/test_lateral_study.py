"""`rollerrig lateral`: sliding wheels against the closed form, hunting on rig and track, what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from rollerrig import ConfigError, load_case
from rollerrig.studies.control.lateral import (
    KEYS,
    WORDS,
    LateralStudy,
    amplitude,
    compare_lateral,
    envelope,
    guidance,
    lateral_cases,
    lateral_stiffness,
    numbers,
    slide_begins,
)
from rollerrig.studies.control.lateral_page import lead, write_lateral


@pytest.fixture(scope="module")
def study() -> LateralStudy:
    case = load_case("adhesion_lateral").with_changes({"time.duration": "6 s"})
    found = compare_lateral(case, processes=1)
    assert found is not None
    assert set(found.runs) == set(WORDS)
    return found


def test_a_sliding_wheel_is_guided_by_viscous_friction_alone(study: LateralStudy) -> None:
    """Friction opposes sliding: F_y = -F v_y / w. The exact theory gets there; Kalker's saturated by length keeps f22 / f11."""
    exact = study.runs["track_exact"]
    left = guidance(exact, lateral_stiffness(study.case, exact))
    assert left is not None
    # The table is within 2 % of the friction limit; at w > 1 m/s creepage is 20 times that of saturation.
    assert left.slope == pytest.approx(1.0, abs=0.02)
    assert left.correlation > 0.999
    assert left.sliding < 0.02 * left.rolling  # that is what it means to be guided no more

    paper = guidance(study.runs["track"], lateral_stiffness(study.case, study.runs["track"]))
    assert paper is not None
    assert 0.78 < paper.slope < 0.95  # f22 / f11 is 0.80 for the whole wheel, and differs from patch to patch
    assert guidance(study.runs["track_dry"], 1e7) is None


def test_hunting_dies_on_the_degraded_track_and_goes_on_on_the_rig(study: LateralStudy) -> None:
    begin = slide_begins(study.runs["track"])
    assert 3.0 < begin < 4.5  # low adhesion begins at 3 s
    found = {key: numbers(run, begin) for key, run in study.runs.items()}
    assert found["track"]["amplitude_before_mm"] > 1.0
    assert found["track"]["amplitude_in_slide_mm"] < 0.2
    assert found["track_dry"]["amplitude_in_slide_mm"] > 1.0
    for key in ("rig", "rig_rigid", "rig_dry"):
        assert found[key]["amplitude_in_slide_mm"] > 2.0
    assert found["rig"]["roller_lateral_mm"] > 0.5
    assert found["rig_rigid"]["roller_lateral_mm"] == 0.0


def test_hunting_disturbs_the_control(study: LateralStudy) -> None:
    errors = {key: numbers(study.runs[key], 4.0)["tracking_rms"] for key in ("rig", "rig_rigid", "rig_centred")}
    assert errors["rig"] > 2.0 * errors["rig_rigid"] > 4.0 * errors["rig_centred"] > 0.0
    assert errors["rig"] < 0.01  # and yet stays within the project's aim


def test_a_bogie_in_the_middle_stays_there(study: LateralStudy) -> None:
    """Left and right are alike: rounding alone moves it, whatever the wheels do along the track."""
    for key in ("rig_centred", "rig_rigid_centred"):
        assert numbers(study.runs[key], 4.0)["largest_lateral_mm"] < 1e-6


def test_amplitudes() -> None:
    time = np.arange(0.0, 4.0, 1e-3)
    values = np.exp(-time) * np.sin(2.0 * np.pi * 5.0 * time)
    assert amplitude(time, 3.0 + np.sin(2.0 * np.pi * 5.0 * time), 1.0, 2.0) == pytest.approx(1.0, abs=1e-4)
    middle, size = envelope(time, values)
    # A window of 0.4 s holds two waves: its largest extrema stand 0.15 to 0.2 s before its middle.
    assert np.allclose(size * np.exp(middle), 1.0, atol=0.22)
    assert np.isnan(amplitude(time, values, 10.0, 11.0))


def test_files(study: LateralStudy, tmp_path: Path) -> None:
    files = write_lateral(study, tmp_path)
    assert files[-1].name == "report.html"
    found = json.loads((tmp_path / "summary.json").read_text())
    assert set(found["runs"]["rig"]) == set(KEYS)
    assert set(found["runs"]) == set(WORDS)
    assert "hunt no more" in lead(study)
    assert "http://" not in files[-1].read_text()


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
        lateral_cases(load_case("adhesion_lateral").with_changes(changes))
