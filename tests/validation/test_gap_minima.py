"""Every minimum of the gap is found: all shipped pairs, a hollow wheel and a worn rail, on rail and rollers, tread to flange.

Oracle: the reduced equation (G3) written out in NumPy, its sign changes on a grid of 0.02 mm along the wheel, bisected.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from catalogued import profile_table
from rollerrig.profiles import ProfileTable
from validation.half_space_pairs import PAIRS, hollow_wheel, surfaces_of
from validation.reference import mm, rail_origin, static_contact_of

Array = NDArray[np.float64]

WHEEL_RADIUS, TAPE_CIRCLE = 0.46, 0.75
STEP = 0.02 * mm
#: The gap changes less in 0.2 mm of the abscissa, at slopes of F up to 2.
FAR = 0.5 * mm
ROLLERS = (None, 0.725, 0.3)


@dataclass(frozen=True)
class Pose:
    """Of a left wheel [m, rad], height of the wheelset's centre over that of a wheel of 460 mm on the crown."""

    x: float
    y: float
    z: float
    yaw: float
    roll: float


@dataclass(frozen=True)
class Surfaces:
    wheel: ProfileTable
    rail: ProfileTable
    origin: float
    roller_radius: float | None

    def equation(self, pose: Pose, s: Array) -> tuple[Array, Array]:
        """F of (G3) and the gap [m] at abscissae of the wheel; NaN where the wheel's normal misses the generatrix."""
        kappa = 1 / self.roller_radius if self.roller_radius else 0.0
        sin, cos = np.sin, np.cos
        ex = np.array([cos(pose.yaw), sin(pose.yaw), 0.0])
        ey = np.array([-sin(pose.yaw) * cos(pose.roll), cos(pose.yaw) * cos(pose.roll), sin(pose.roll)])
        ez = np.cross(ex, ey)
        centre = np.array([pose.x, pose.y, pose.z + WHEEL_RADIUS])
        r = WHEEL_RADIUS + self.wheel.evaluate(s)
        slope = self.wheel.evaluate(s, 1)
        apex = centre[:, None] + (TAPE_CIRCLE + s + r * slope) * ey[:, None]
        u = np.array([kappa * apex[0], 0 * s, kappa * apex[2] + 1])
        u /= np.linalg.norm(u, axis=0)
        w = np.array([u[2], 0 * s, -u[0]])
        wx, wy, wz = ex @ w, ey @ w, ez @ w
        square = wx**2 + wz**2
        root = np.sqrt(square - (slope * wy) ** 2)
        sine, cosine = (slope * wy * wx + wz * root) / square, (wx * root - slope * wy * wz) / square
        outwards = sine * ex[:, None] - cosine * ez[:, None]
        n = (outwards - slope * ey[:, None]) / np.sqrt(1 + slope**2)
        p = centre[:, None] + (TAPE_CIRCLE + s) * ey[:, None] + r * outwards
        length = np.hypot(kappa * p[0], 1 + kappa * p[2])
        height = (kappa * (p[0] ** 2 + p[2] ** 2) + 2 * p[2]) / (length + 1)
        n_radial = (n[0] * kappa * p[0] + n[2] * (1 + kappa * p[2])) / length
        first, last = self.rail.domain
        abscissa = p[1] - self.origin
        y = abscissa
        for _ in range(12):
            inside = np.clip(y, first, last)
            h, h_slope = self.rail.evaluate(inside), self.rail.evaluate(inside, 1)
            h = h + h_slope * (y - inside)
            y = y - ((y - abscissa) * n_radial - (h - height) * n[1]) / (n_radial - h_slope * n[1])
        with np.errstate(invalid="ignore"):
            missed = ~((y > first) & (y < last)) | (n_radial - h_slope * n[1] > -0.1)
        y = np.where(missed, first, y)
        residual = self.rail.evaluate(y, 1) + n[1] / n_radial
        gap = -((abscissa - y) * n[1] + (height - self.rail.evaluate(y)) * n_radial)
        return np.where(missed, np.nan, residual), np.where(missed, np.nan, gap)

    def minima(self, pose: Pose, reach: float) -> Array:
        """Abscissae and gaps of all minima closer than `reach` [m], shape (n, 2)."""
        s = np.arange(self.wheel.domain[0], self.wheel.domain[1], STEP)
        # Where every tenth point is far away, or misses the generatrix with its neighbours, there is no minimum.
        coarse = self.equation(pose, s[::10])[1]
        near = np.nan_to_num(coarse, nan=np.inf) < reach + FAR
        near = np.convolve(near, np.ones(3), "same") > 0
        s = s[np.repeat(near, 10)[: len(s)]]
        residual, _ = self.equation(pose, s)
        residual[:-1][np.diff(s) > 1.5 * STEP] = np.nan
        with np.errstate(invalid="ignore"):
            falls = np.flatnonzero((residual[:-1] > 0) & (residual[1:] <= 0))
        low, high = s[falls], s[falls + 1]
        for _ in range(25):
            middle = 0.5 * (low + high)
            positive = self.equation(pose, middle)[0] > 0
            low, high = np.where(positive, middle, low), np.where(positive, high, middle)
        found = np.column_stack([low, self.equation(pose, low)[1]])
        return found[found[:, 1] < reach]


def shipped() -> dict[str, tuple[ProfileTable, ProfileTable, float]]:
    """Wheel, rail and the lateral place of the rail's highest point."""
    pairs = {pair: (surfaces_of(pair).wheel, surfaces_of(pair).rail, surfaces_of(pair).origin * mm) for pair in PAIRS}
    for wheel in ("s1002", "cone_1_20", "cone_1_40"):
        for rail in ("en_60e1_1_20", "en_60e1_1_40", "uic60_benchmark_1_20", "uic60_benchmark_1_40"):
            table = profile_table(rail, "rail")
            pairs[f"{wheel} on {rail}"] = (profile_table(wheel, "wheel"), table, rail_origin(table))
    table = profile_table("uic60_benchmark_1_20", "rail")
    pairs["hollow wheel on uic60_benchmark_1_20"] = (hollow_wheel(), table, rail_origin(table))
    return pairs


def poses_of(pair: str, poses: int) -> int:
    """Compares random poses of a pair on rail and rollers; returns how many minima were seen."""
    wheel, rail, origin = shipped()[pair]
    seen = 0
    for number, radius in enumerate(ROLLERS):
        surfaces = Surfaces(wheel, rail, origin, radius)
        contact = static_contact_of(wheel, rail, radius, origin)
        rng = np.random.default_rng(number)
        for trial in range(poses):
            yaw = (50e-3 if trial % 3 == 0 else 5e-3) * rng.uniform(-1, 1)
            x, y, roll = 5 * mm * rng.uniform(-1, 1), 8 * mm * rng.uniform(-1, 1), 5e-3 * rng.uniform(-1, 1)
            # Pressed in by up to 0.35 mm, or lifted; second contacts that are open by up to 0.1 mm must be seen, too.
            z = contact.touch_height(x, y, yaw, roll, False) + 0.1 * mm * rng.uniform(-3.5, 0.5)
            reach = 0.0 if trial % 2 else 0.1 * mm
            pose = Pose(x, y, z, yaw, roll)
            expected = surfaces.minima(pose, reach)
            found = np.array([(p.wheel_s, -p.approach) for p in contact.minima(x, y, z, yaw, roll, False, reach)])
            for s, gap in expected:
                if gap > reach - 1e-12:
                    continue
                assert len(found), (pair, radius, pose, s, gap)
                k = np.abs(found[:, 0] - s).argmin()
                # Round-off of F, 1e-14, over its slope near a fold.
                assert abs(found[k, 0] - s) < 1e-9, (pair, radius, pose, s, gap)
                assert abs(found[k, 1] - gap) < 1e-13, (pair, radius, pose, s, gap)
            seen += len(expected)
    return seen


@pytest.mark.parametrize("pair", sorted(shipped()))
def test_every_minimum_of_random_poses_is_found(pair: str) -> None:
    assert poses_of(pair, 2) > 3


@pytest.mark.long
@pytest.mark.parametrize("pair", sorted(shipped()))
def test_every_minimum_of_many_random_poses_is_found(pair: str) -> None:
    assert poses_of(pair, 60) > 100
