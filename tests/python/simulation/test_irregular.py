"""Irregular rails and what stands for them: rollers, elastic rails, measured files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rollerrig as rr
from rollerrig.assembly.model import assemble
from rollerrig.irregularity import generate

RAILS = {"kind": "ore_b176", "level": "low", "seed": 2, "fade_in": "5 m", "scale": 0.3}
SHORT = {"disturbance": [], "motion.speed": "30 m/s", "time.duration": "1 s"}


def test_large_rollers_that_are_steered_are_rails() -> None:
    """Roller radius 100 km against track, same seed: what is left goes with 1 / R."""
    track = rr.simulate(rr.load_case("bogie_track").with_changes({**SHORT, "support.irregularity": RAILS}))
    rig = rr.load_case("bogie_rollers_constant").with_changes(
        {**SHORT, "support.irregularity": RAILS, "support.roller_radius": "100 km"}
    )
    for steered, alike in ((True, True), (False, False)):
        rollers = rr.simulate(rig.with_changes({"support.steered": steered}))
        for name in ("rail_lateral", "rail_vertical"):
            np.testing.assert_allclose(rollers[name], track[name], atol=1e-12)
        error = np.abs(rollers["lateral"].sel(body="wheelset_1") - track["lateral"].sel(body="wheelset_1")).max()
        assert (float(error) < 1e-2 * float(np.abs(track["lateral"]).max())) is alike


def test_a_measured_file_gives_the_rails_it_was_written_from(tmp_path: Path) -> None:
    """A generated track written to a file every 0.25 m and read again; waves of 10 m and more: (k h)^4 / 100 = 6e-6."""
    rails = generate("low", 3, shortest=10.0, longest=50.0, period=200.0, fade_in=5.0)
    s = np.arange(0.0, 60.01, 0.25)
    columns = [s, *(1e3 * rails.components(s)[name] for name in ("alignment", "vertical", "cross_level", "gauge"))]
    rows = "\n".join(",".join(f"{value:.9f}" for value in row) for row in np.column_stack(columns))
    path = tmp_path / "track.csv"
    path.write_text(f"distance [m],alignment [mm],vertical [mm],cross_level [mm],gauge [mm]\n{rows}\n")
    base = rr.load_case("bogie_track").with_changes(SHORT)
    written = base.with_changes(
        {"support.irregularity": {"kind": "file", "path": str(path), "start": 5.0, "fade_in": "5 m"}}
    )
    run = rr.simulate(written)
    late = run.isel(time=run["distance"].to_numpy() > 10.0)
    foremost = rails.components(late["distance"].to_numpy() + 5.0 + 1.28)
    expected = foremost["vertical"] - foremost["cross_level"] / 2
    np.testing.assert_allclose(late["rail_vertical"].sel(wheel="wheelset_1_left"), expected, atol=1e-7)


def test_elastic_rails_carry_the_load_and_are_no_part_of_the_vehicle() -> None:
    foundation = {
        "rail_mass": 60.0,
        "lateral": {"stiffness": 4e7, "damping": 5e4},
        "vertical": {"stiffness": 1e8, "damping": 1e5},
    }
    case = rr.load_case("bogie_track").with_changes(
        {**SHORT, "support.foundation": foundation, "time.duration": "0.2 s"}
    )
    model = assemble(case)
    assert model.rails == ("rail_1_left", "rail_1_right", "rail_2_left", "rail_2_right")
    assert not set(model.rails) & set(model.lateral_bodies)
    run = rr.simulate(case)
    assert run.attrs["energy_relative_residual"] < 1e-6
    load = run["element_force_z"].sel(element="mounting_rail_1_left")
    rail = 60.0 * 9.81
    assert float(load[0]) == pytest.approx(
        float(run["vertical_force"].sel(wheel="wheelset_1_left")[0]) + rail, rel=1e-9
    )
    np.testing.assert_allclose(run["vertical"].sel(body="rail_1_left"), 0.0, atol=1e-5)  # the preload holds it up
