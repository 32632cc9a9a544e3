"""Numbers of the independent model: the bogie of Manchester Benchmark vehicle 1 on a full-scale roller rig.

    profiles, masses, springs, material  ->  Parameters  ->  bogie.rhs, benchmarks/numba_model.py

Frames  rig frame: x forward, y left, z up; x = 0 mid-way between the wheelsets, z = 0 at the crown of the rollers.
        Profile abscissae point outward (away from the track centre) on both sides.
Units   SI throughout.
Source  vehicle: S. Iwnicki (ed.), The Manchester Benchmarks for Rail Vehicle Simulators (1999); S1002: EN 13715;
        UIC60: EN 13674-1, and as the Manchester contact benchmark has it.
"""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import ellipe, ellipk, elliprd

from .kalker_table import AXIS_RATIO, coefficients_at_poisson

GRAVITY = 9.81  # [m/s^2]


# ---------------------------------------------------------------------------------------------- profiles
@dataclass(frozen=True)
class Table:
    """Cubic spline on uniform knots: value = c0 + c1 t + c2 t^2 + c3 t^3, t = y - (start + i step).

    Attributes:
        start: first knot [m].
        step: knot spacing [m].
        coefficients: shape (n, 4), row i from knot i on [m, -, 1/m, 1/m^2] for a profile.
    """

    start: float
    step: float
    coefficients: np.ndarray

    def __call__(self, y):
        """Value, first and second derivative at y (arrays allowed; the end polynomials extrapolate)."""
        i = np.clip(((y - self.start) / self.step).astype(int), 0, len(self.coefficients) - 1)
        t = y - (self.start + i * self.step)
        c0, c1, c2, c3 = np.moveaxis(self.coefficients[i], -1, 0)
        return c0 + t * (c1 + t * (c2 + t * c3)), c1 + t * (2 * c2 + 3 * t * c3), 2 * c2 + 6 * t * c3

    @property
    def end(self) -> float:
        """Last knot [m]."""
        return self.start + self.step * len(self.coefficients)


def spline_table(function, start: float, end: float, step: float) -> Table:
    """Interpolate `function` by a C2 cubic spline (not-a-knot ends) on uniform knots."""
    n = round((end - start) / step)
    y = start + step * np.arange(n + 1)
    spline = CubicSpline(y, function(y))
    return Table(start, step, np.ascontiguousarray(spline.c[::-1].T))


def s1002(s_mm: np.ndarray) -> np.ndarray:
    """Radius increase of the S1002 wheel over the EN abscissa, both in mm (negative abscissa: flange)."""
    s = np.asarray(s_mm, dtype=float)
    tread = np.polyval(
        [
            2.646656573e-13,
            -5.957839843e-12,
            5.309217349e-15,
            -1.562379023e-8,
            5.844240864e-8,
            -2.810427944e-5,
            1.565681624e-3,
            -3.358537058e-2,
            0.0,
        ],
        s,
    )
    root = np.polyval(
        [
            -2.252755540e-7,
            -4.687195829e-5,
            -4.169739389e-3,
            -2.054332446e-1,
            -6.051367875,
            -1.065501873e2,
            -1.038384026e3,
            -4.320221063e3,
        ],
        s,
    )
    with np.errstate(invalid="ignore"):
        pieces = [
            (s >= 32.15796, 1.364323640 - 0.066666667 * s),
            (s >= -26.0, tread),
            (s >= -35.0, root),
            (s >= -38.426669071, 16.446 - np.sqrt(13.0**2 - (s + 26.210665) ** 2)),
            (s >= -39.764473993, -93.576667419 - 2.747477419 * s),
            (s >= -49.662510381, 8.834924130 + np.sqrt(20.0**2 - (s + 58.558326413) ** 2)),
            (s >= -62.764705882, 16.0 + np.sqrt(12.0**2 - (s + 55.0) ** 2)),
            (s >= -70.0, 9.519259302 + np.sqrt(20.5**2 - (s + 49.5) ** 2)),
        ]
    return np.select([where for where, _ in pieces], [value for _, value in pieces])


#: Junctions of the arcs R300/R80 and R80/R13 on the upright head [mm]: Manchester contact benchmark, and EN 13674-1.
UIC60_BENCHMARK, EN_60E1 = (10.5, 25.98803), (10.228, 26.0265)


def uic60(
    y_mm: np.ndarray, inclination: float = 1 / 40, junctions: tuple[float, float] = UIC60_BENCHMARK
) -> np.ndarray:
    """Height of the canted UIC60 head below its highest point, both in mm.

    The abscissa is 0 at the highest point and negative towards the gauge side. Arcs R300, R80, R13 only: the sides are
    left out (they are steeper than any contact).
    """
    tilt = np.arctan(inclination)  # of the head towards the gauge side
    y1, y2 = junctions
    a1 = np.arcsin(y1 / 300)
    y80, z80 = 220 * np.sin(a1), -300 + 220 * np.cos(a1)
    a2 = np.arcsin((y2 - y80) / 80)
    y13, z13 = y80 + 67 * np.sin(a2), z80 + 67 * np.cos(a2)

    def turned(y, z):  # positions from the centre of the crown's arc, after canting
        return (y * np.cos(tilt) - (z + 300) * np.sin(tilt), y * np.sin(tilt) + (z + 300) * np.cos(tilt))

    left1, left2 = turned(-y1, -300 + 300 * np.cos(a1))[0], turned(-y2, z80 + 80 * np.cos(a2))[0]
    right1, right2 = turned(y1, -300 + 300 * np.cos(a1))[0], turned(y2, z80 + 80 * np.cos(a2))[0]
    edges = [-np.inf, left2, left1, right1, right2, np.inf]
    centres = [(-y13, z13, 13), (-y80, z80, 80), (0, -300, 300), (y80, z80, 80), (y13, z13, 13)]
    arcs = [
        (*turned(y, z), radius, *ends) for (y, z, radius), ends in zip(centres, itertools.pairwise(edges), strict=True)
    ]
    top_y, top_z = next((y0, z0 + radius) for y0, z0, radius, low, high in arcs if low <= y0 < high)
    y = np.asarray(y_mm, dtype=float) + top_y
    height = np.full_like(y, np.nan)
    for y0, z0, radius, low, high in arcs:
        here = (y >= low) & (y < high)
        height[here] = z0 + np.sqrt(radius**2 - (y[here] - y0) ** 2) - top_z
    return height


# ------------------------------------------------------------------------------------------ Hertz, Kalker
def hertz_table() -> Table:
    """Hertz' ellipse over lambda = ln(D1/D2), columns stacked: see `Parameters.hertz`.

    With gamma = a/b:  D1/D2 = R_D(0, b^2, a^2) / R_D(0, a^2, b^2)   (the relation (16) in Carlson's form)
    K and E of (19) with 1 - gamma^2 as parameter hold for gamma > 1 too, so no case distinction is needed.
    """
    log_gamma = np.linspace(np.log(1 / 200), np.log(200), 4001)
    gamma = np.exp(log_gamma)
    ratio = np.log(elliprd(0, 1 / gamma, gamma) / elliprd(0, gamma, 1 / gamma))  # ab = 1; falls with gamma
    log_gamma_of = CubicSpline(ratio[::-1], log_gamma[::-1])
    limit = np.log(200.0)

    def columns(lam):
        g = np.exp(log_gamma_of(lam))
        k, e = ellipk(1 - g * g), ellipe(1 - g * g)
        return np.stack([log_gamma_of(lam), np.sqrt(e) / (g * k**1.5), e / k], axis=-1)

    n = 1600
    step = 2 * limit / n
    lam = -limit + step * np.arange(n + 1)
    spline = CubicSpline(lam, columns(lam))  # c: (4, n, 3)
    return Table(-limit, step, np.ascontiguousarray(np.moveaxis(spline.c[::-1], 0, -1).reshape(n, 12)))


@functools.cache
def kalker_spline(poisson: float) -> tuple[np.ndarray, np.ndarray]:
    """Natural spline of Kalker's table: knots ln(a/b), shape (19,); coefficients, shape (18, 4 coefficients, 4 powers)."""
    spline = CubicSpline(np.log(AXIS_RATIO), coefficients_at_poisson(poisson), bc_type="natural")
    return spline.x, np.ascontiguousarray(np.transpose(spline.c[::-1], (1, 2, 0)))


@dataclass(frozen=True)
class Parameters:
    """All constants of the model; arrays are shared by reference, do not write to them."""

    # geometry [m]
    wheel_radius: float = 0.460
    roller_radius: float = 0.725
    tape_circle: float = 0.750  # lateral position of the wheel's tape circle
    rail_origin: float = 0.7175 + 0.0430385279  # roller profile's highest point: gauge 1435 mm, 14 mm below it
    semi_wheelbase: float = 1.280
    frame_height: float = 0.600
    wheel: Table = field(default_factory=lambda: spline_table(lambda y: s1002(1e3 * y) / 1e3, -0.060, 0.060, 1e-4))
    rail: Table = field(default_factory=lambda: spline_table(lambda y: uic60(1e3 * y) / 1e3, -0.0428, 0.0285, 1e-4))
    # bodies [kg], [kg m^2]
    frame_mass: float = 2615.0
    frame_inertia: tuple[float, float, float] = (1722.0, 1476.0, 3067.0)
    wheelset_mass: float = 1813.0
    wheelset_inertia: tuple[float, float] = (1120.0, 112.0)  # across the axle, spin
    roller_inertia: float = 705.0  # spin, of a pair
    # primary suspension, per axle box: x, y, z
    primary_y: float = 1.0
    primary_z: float = 0.460
    primary_stiffness: tuple[float, float, float] = (31.391e6, 3.884e6, 1.220e6)  # [N/m]
    primary_damping: tuple[float, float, float] = (15e3, 2e3, 4e3)  # [N s/m]
    primary_series: tuple[float, float, float] = (60e6, 7.5e6, 1.0e6)  # [N/m]
    primary_preload: float = (32000 / 2 + 2615) * GRAVITY / 4  # [N], vertical
    # secondary suspension, per side; ends on car body and frame
    secondary_y: float = 1.0
    secondary_top: float = 1.130
    secondary_bottom: float = 0.525
    secondary_stiffness: tuple[float, float, float] = (160e3, 160e3, 430e3)  # [N/m]
    secondary_bending: float = 10.5e3  # [N m/rad], about x and about y
    secondary_preload: float = 32000 * GRAVITY / 4  # [N]
    vertical_damper: tuple[float, float] = (20e3, 6e6)  # [N s/m], series [N/m]
    vertical_damper_y: float = 1.30
    vertical_damper_ends: tuple[float, float] = (0.925, 0.400)  # heights on car body, frame
    lateral_damper: tuple[float, float] = (32e3, 6e6)
    lateral_damper_y: float = 0.0
    lateral_damper_z: float = 0.70
    anti_roll: float = 940e3  # [N m/rad]
    rod: tuple[float, float] = (5e6, 25e3)  # [N/m], [N s/m], in parallel
    rod_z: float = 0.60
    bumpstop_z: float = 0.65
    bumpstop: np.ndarray = field(
        default_factory=lambda: np.array(
            [
                [0.0, 0.025, 0.030, 0.035, 0.040, 0.045, 0.050, 0.055, 0.060, 0.065],
                [0.0, 0.0, 600.0, 1760.0, 3730.0, 6870.0, 11580.0, 17170.0, 29200.0, 230000.0],
            ]
        )
    )
    # contact
    youngs_modulus: float = 210e9
    poisson: float = 0.28
    friction: float = 0.3
    normal_damping: float = 1e5  # [N s/m]
    damping_speed: float = 1e-4  # [m/s], smooths the corner of (12)
    creepage_regularisation_speed: float = 0.1  # [m/s], keeps creepages finite
    hertz: Table = field(default_factory=hertz_table)  # columns x 4 coefficients: ln(a/b), E^.5/(g K^1.5), E/K
    scan_start: float = -0.050  # wheel abscissa searched for contact [m]
    scan_end: float = 0.050
    scan_step: float = 5e-4
    # study: torque on each wheelset
    torque: float = 4e3  # [N m]
    torque_start: float = 1.0  # [s]
    torque_full: float = 5.0
    hold_rollers: bool = False  # True: roller spin rates do not change

    @property
    def shear_modulus(self) -> float:
        """G [Pa]."""
        return self.youngs_modulus / 2 / (1 + self.poisson)

    def torque_at(self, t: float) -> float:
        """Torque on each wheelset at time t [N m]."""
        return self.torque * min(max((t - self.torque_start) / (self.torque_full - self.torque_start), 0.0), 1.0)
