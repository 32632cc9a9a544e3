"""Lateral motion of a bogie whose wheels slide along the track: amplitudes, and the lateral creep that remains.

run -> [slide_begins, amplitude, amplitudes_over_time] -> hunting before and in the slide
run -> [guidance] -> lateral creep force of sliding axles against -F v_y / v_s, (Q6) of docs/theory/rig_control.md

A wheel that slides along the track has its friction used up: what remains of lateral creep is viscous.
"""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig.analysis.signals import half_waves
from rollerrig.analysis.slide_statistics import slip, under_test, virtual_slip
from rollerrig.assembly.laws import linear_coefficients
from rollerrig.common.arrays import Array
from rollerrig.config import Case

SLIDES = 0.02  # slip from which on an axle counts as sliding: friction is used up long before, at some 0.5 %
FULL_SLIDING = 1.0  # sliding of a wheel [m/s] above which creep is far into saturation, so that its closed form applies
LEAST_WAVE = 1e-2  # smaller half-waves are rounding [mm]


def on_rig(run: xr.Dataset) -> bool:
    """Whether a run stands on rollers."""
    return any("roller" in str(body) for body in run["body"].to_numpy())


def train_slip(run: xr.Dataset) -> xr.DataArray:
    """Slip of the wheels against the train, on a rig of the virtual wheels: flange strikes are no part of it."""
    return virtual_slip(run) if on_rig(run) else slip(run)


def slide_begins(run: xr.Dataset) -> float:
    """When an axle first slips by more than SLIDES against the train [s]; NaN: never."""
    sliding = np.flatnonzero((abs(train_slip(run)).to_numpy() > SLIDES).any(axis=1))
    return float(run["time"][sliding[0]]) if sliding.size else math.nan


def leading_lateral(run: xr.Dataset) -> Array:
    """Lateral displacement of the leading wheelset [mm], shape (time,)."""
    return np.asarray(1e3 * run["lateral"].sel(body=str(run["axle"].to_numpy()[0])))


def amplitude(time: Array, values: Array, begin: float, end: float) -> float:
    """Half of peak to peak within a time [unit of the values]; NaN where there is none of it."""
    within = values[(time >= begin) & (time <= end)]
    return 0.5 * float(np.ptp(within)) if within.size else math.nan


def amplitudes_over_time(time: Array, values: Array, window: float = 0.4) -> tuple[Array, Array]:
    """Middle [s] and half of peak to peak of windows that begin each `window` / 2 [s]."""
    begins = np.arange(time[0], time[-1] - window, 0.5 * window)
    return begins + 0.5 * window, np.array([amplitude(time, values, t, t + window) for t in begins])


def hunting_frequency(time: Array, values: Array, begin: float, end: float) -> float:
    """Frequency of the half-waves larger than LEAST_WAVE of a displacement in mm within a time [Hz]; NaN: none."""
    within = (time >= begin) & (time <= end)
    duration = half_waves(time[within], values[within], LEAST_WAVE).duration
    return 0.5 / float(np.median(duration)) if duration.size else math.nan


def creep_force(run: xr.Dataset, direction: str) -> Array:
    """Creep force on each wheel along ("x") or across ("y") the track [N], shape (time, wheel)."""
    return np.asarray(run[f"patch_creep_force_{direction}"].sum("patch").to_numpy())


def lateral_creep_coefficient(case: Case, run: xr.Dataset) -> float:
    """f22 of linear theory, the mean over the wheels in steady running [N]: from the patches at the start of a run."""
    first = run.isel(time=0)
    axes = zip(*(first[name].to_numpy().ravel() for name in ("patch_a", "patch_b")), strict=True)
    return sum(linear_coefficients(case.contact, a, b)[1] for a, b in axes if min(a, b) > 0.0) / first.sizes["wheel"]


@dataclass(frozen=True)
class Guidance:
    """Lateral creep of fully sliding axles and the closed form; the parts of spin on left and right cancel in an axle."""

    force: Array  # lateral creep force of an axle [N]
    expected: Array  # sum of -F v_y / v_s over its wheels [N], F the length of a wheel's creep force
    slope: float  # of force over expected; 1: Coulomb's law
    correlation: float  # of the two
    # rolling, sliding: damping of one wheel -dF_y/dv_y [N s/m]: f22 / V of Kalker's theory, and the median of F / v_s
    rolling: float
    sliding: float


def guidance(run: xr.Dataset, f22: float) -> Guidance | None:
    """Lateral creep of the axles while they slide fully along the track, as on track; f22 of a wheel [N].

    None where no axle slid, or none moved sideways.
    """
    run = under_test(run)
    axles = (run.sizes["time"], run.sizes["axle"], 2)  # wheels stand left and right of each axle, in order
    along, across = (run[f"{name}_sliding"].to_numpy().reshape(axles) for name in ("longitudinal", "lateral"))
    x, y = (creep_force(run, direction).reshape(axles) for direction in "xy")
    fully = (np.abs(along) > FULL_SLIDING).all(axis=-1)
    if fully.sum() < 10 or float(np.abs(across[fully]).max()) < 1e-4:
        return None
    total, speed = np.hypot(x, y)[fully], np.hypot(along, across)[fully]
    expected, force = -(total * across[fully] / speed).sum(axis=-1), y[fully].sum(axis=-1)
    slope = float(np.dot(expected, force) / np.dot(expected, expected))
    rolling = f22 / float(np.median(run["rolling_speed"].to_numpy().reshape(axles)[fully]))
    correlation = float(np.corrcoef(expected, force)[0, 1])
    return Guidance(force, expected, slope, correlation, rolling, float(np.median(total / speed)))
