"""The half-space that finds its patches itself: against Hertz, on one grid for two patches, and with the tables."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from rollerrig.profiles import ProfileTable, tabulate
from validation.free_patches import lowered, patches, press, regions
from validation.half_space import Grid, Pose, Surfaces, solve
from validation.reference import mm, static_contact_of

Array = NDArray[np.float64]

PLACE = 0.76


def barrel(radius: float) -> ProfileTable:
    """A wheel hollowed to a radius [m]."""
    return tabulate(lambda s: s**2 / (2 * radius), -0.05, 0.05, name="barrel", kind="wheel", source="parabola")


def head(radius: float, waves: float = 0.0) -> ProfileTable:
    """A rail of a radius, with waves of an amplitude and 12 mm length [m]."""

    def height(y: Array) -> Array:
        return np.sqrt(radius**2 - y**2) - radius + waves * (np.cos(2 * np.pi * y / (12 * mm)) - 1)

    return tabulate(height, -0.03, 0.03, name="head", kind="rail", source="arc")


@pytest.mark.parametrize(("yaw", "roller_radius"), [(0.0, None), (0.05, None), (0.05, 300.0), (-0.03, 725.0)])
def test_hertz(yaw: float, roller_radius: float | None) -> None:
    """The program's Hertz contact, itself tested against closed forms, on surfaces of one curvature each."""
    surfaces = Surfaces(barrel(0.9), head(0.3), PLACE)
    pose = lowered(surfaces, Pose(3.0, 0.0, yaw, 1e-3, roller_radius), 2e4)
    (patch,) = patches(surfaces, pose, 80)
    exact = patch.solution()
    contact = static_contact_of(surfaces.wheel, surfaces.rail, roller_radius and roller_radius * mm, PLACE)
    (ours,) = contact.minima(0.0, pose.y * mm, pose.height * mm, yaw, 1e-3, False, 0.0)
    assert exact.force == pytest.approx(ours.normal, rel=2e-3)
    assert exact.pressure == pytest.approx(ours.peak_pressure / 1e6, rel=2e-3)
    assert exact.area == pytest.approx(ours.area / mm**2, rel=0.01)
    assert exact.approach == pytest.approx(ours.approach / mm, rel=5e-4)
    assert surfaces.on_rail(pose, patch.centre, patch.grid.normal) == pytest.approx(np.array(ours.point) / mm, abs=0.01)


def test_patches_in_planes_of_their_own_are_what_one_grid_holds() -> None:
    """On the three crests of a wavy rail, where each is pushed back by the loads of the others."""
    surfaces = Surfaces(barrel(3.0), head(1.5, 0.1 * mm), PLACE)
    pose = lowered(surfaces, Pose(10.0, 0.0, 0.0), 1e5)
    whole = solve(surfaces, pose, Grid(np.array([0.0, 760.0, 0.0]), np.array([0.0, 0.0, 1.0]), (9.0, 20.0), (120, 500)))
    pressed = patches(surfaces, pose)
    alone = [
        press(surfaces, pose, region, patch.grid, [], 1e-5)
        for region, patch in zip(regions(surfaces, pose), pressed, strict=True)
    ]
    assert len(pressed) == 3
    assert sum(patch.force for patch in pressed) == pytest.approx(whole.force, rel=5e-3)
    assert max(patch.pressures.max() for patch in pressed) == pytest.approx(whole.pressure, rel=5e-3)
    assert sum(patch.force for patch in alone) > 1.1 * whole.force
