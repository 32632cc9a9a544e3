"""Lateral motion during a slide: does it disturb the control of the rig, and does the rig show what a sliding train does?

Case on elastic rollers with a disturbance -> [lateral_cases] -> runs aside and centred, elastic and rigid, rig and track
-> [numbers] tracking, real sliding, hunting before and in the slide; [guidance] lateral creep against its closed form

A wheel that slides along the track has its friction used up: what is left of lateral creep is viscous, -F v_y / w
(docs/theory/rig_control.md, Q6).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig import _core
from rollerrig.analysis.parallel import run_jobs
from rollerrig.analysis.signals import half_waves
from rollerrig.analysis.tracking import slip, tracking
from rollerrig.config import Case, ConfigError, ConfigProblem, Rig
from rollerrig.studies.control.ring import whole_run
from rollerrig.study.adhesion import track_case

Progress = Callable[[float, str], None]
Array = NDArray[np.float64]

SLIDES = 0.02
"""Slip from which on an axle counts as sliding: friction is used up long before, at some 0.5 %."""

FULL_SLIDING = 1.0
"""Sliding of a wheel [m/s] above which creep is far into saturation and its closed form is looked at."""

WORDS = {
    "rig": "rig as it is, aside",
    "rig_centred": "rig as it is, centred",
    "rig_rigid": "rollers rigid, aside",
    "rig_rigid_centred": "rollers rigid, centred",
    "rig_dry": "rig as it is, aside, virtual rail dry",
    "track": "track, aside",
    "track_dry": "track, aside, rail dry",
    "track_exact": "track, aside, exact creep theory",
}
"""Key of a run -> its name; aside: from the case's disturbance."""


@dataclass(frozen=True)
class LateralStudy:
    """Runs by key of WORDS; those that Ctrl-C cut off are missing."""

    case: Case
    runs: dict[str, xr.Dataset]
    interrupted: bool = False


def lateral_cases(case: Case) -> dict[str, Case]:
    """The runs of the study, by key of WORDS.

    Raises:
        ConfigError: the case has no rig controller, no elastic rollers, or no disturbance.
    """
    track = track_case(case)
    rig = case.support.data
    problems = []
    if not isinstance(rig, Rig) or rig.mounting is None:
        needed = "needed: the elastic support of the roller axles, which this study also makes rigid"
        problems.append(ConfigProblem(case.name, "support.mounting", "missing", needed))
    if not any(d.lateral or d.yaw for d in case.disturbance):
        needed = "needed: an offset in lateral or yaw, e.g. body = 'wheelset_1', lateral = '4 mm'"
        problems.append(ConfigProblem(case.name, "disturbance", "missing", needed))
    if case.adhesion is None:
        needed = "needed: the degraded rail on which the wheels slide"
        problems.append(ConfigProblem(case.name, "adhesion", "missing", needed))
    if problems:
        raise ConfigError(problems)
    rigid: dict[str, object] = {"support.mounting": None, "support.changes": None}
    centred: dict[str, object] = {"disturbance": []}
    dry: dict[str, object] = {"adhesion.rail": "dry", "adhesion.piece": []}
    return {
        "rig": case,
        "rig_centred": case.with_changes(centred),
        "rig_rigid": case.with_changes(rigid),
        "rig_rigid_centred": case.with_changes({**rigid, **centred}),
        "rig_dry": case.with_changes(dry),
        "track": track,
        "track_dry": track.with_changes(dry),
        "track_exact": track.with_changes({"contact.creep": "table", "contact.polach": None}),
    }


def compare_lateral(case: Case, *, processes: int = 2, progress: Progress | None = None) -> LateralStudy | None:
    """Run the cases of `lateral_cases`.

    Args:
        case: on elastic rollers, with a disturbance.
        processes: runs at a time.
        progress: called with the fraction done and a text.

    Returns:
        The runs; None where Ctrl-C came before the case itself was done.

    Raises:
        ConfigError, StartError: as `simulate`, and `lateral_cases`.
    """
    cases = lateral_cases(case)
    done = run_jobs(_run, list(cases.values()), processes=processes, progress=progress, names=list(WORDS.values()))
    runs = {key: run for key, run in zip(cases, done.results, strict=True) if run is not None}
    return LateralStudy(case, runs, done.interrupted) if "rig" in runs else None


def _run(case: Case, progress: Progress) -> xr.Dataset:
    return whole_run(case, progress)


# ------------------------------------------------------------------------------------------------------------- numbers

KEYS = {
    "status": "how the run ended",
    "tracking_rms": "wheel less virtual wheel over train speed, RMS [-]; on track null",
    "tracking_largest": "largest of the same [-]",
    "real_sliding_rms_mps": "wheel against roller along the track [m/s]; on track wheel against rail",
    "real_sliding_largest_mps": "largest of the same [m/s]",
    "largest_slip": "of the wheels against the train, over its speed [-]",
    "amplitude_before_mm": "of the leading wheelset's lateral motion, half peak to peak in the second before the slide [mm]",
    "amplitude_in_slide_mm": "largest of the same over seconds, from one second into the slide on [mm]",
    "amplitude_end_mm": "of the last second [mm]",
    "frequency_hz": "of the half-waves in the second before the slide [Hz]; null: none",
    "largest_lateral_mm": "displacement of the leading wheelset [mm]",
    "roller_lateral_mm": "largest displacement of a roller axle [mm]",
    "lateral_creep_largest_kn": "of one wheel [kN]",
}
"""Key of a run in summary.json -> meaning."""


def slide_begins(run: xr.Dataset) -> float:
    """When an axle first slips by more than SLIDES against the train [s]; NaN: never."""
    sliding = np.flatnonzero((abs(train_slip(run)).to_numpy() > SLIDES).any(axis=1))
    return float(run["time"][sliding[0]]) if sliding.size else math.nan


def numbers(run: xr.Dataset, slide: float) -> dict[str, Any]:
    """The numbers of one run under the keys of KEYS.

    Args:
        run: of the study.
        slide: when the wheels begin to slide, the same for all runs [s]; NaN: they do not.
    """
    error, largest = tracking(run) if on_rig(run) else (math.nan, math.nan)
    time = run["time"].to_numpy()
    lead = 1e3 * run["lateral"].sel(body=str(run["axle"].to_numpy()[0])).to_numpy()
    slips = abs(train_slip(run)).to_numpy()
    begin = slide if math.isfinite(slide) else float(time[-1])
    later = [amplitude(time, lead, t, t + 1.0) for t in np.arange(begin + 1.0, time[-1] - 0.999)]
    rollers = [body for body in map(str, run["body"].to_numpy()) if "roller" in body]
    real = run["real_sliding"].to_numpy()
    waves = _waves(time, lead, begin - 1.0, begin)
    found = {
        "status": run.attrs["status"],
        "tracking_rms": error,
        "tracking_largest": largest,
        "real_sliding_rms_mps": float(np.sqrt(np.mean(real**2))),
        "real_sliding_largest_mps": float(np.abs(real).max()),
        "largest_slip": float(np.nanmax(slips)) if np.isfinite(slips).any() else math.nan,
        "amplitude_before_mm": amplitude(time, lead, begin - 1.0, begin),
        "amplitude_in_slide_mm": max(later, default=math.nan),
        "amplitude_end_mm": amplitude(time, lead, time[-1] - 1.0, time[-1]),
        "frequency_hz": 0.5 / float(np.median(waves)) if waves.size else math.nan,
        "largest_lateral_mm": float(np.abs(lead).max()),
        "roller_lateral_mm": 1e3 * float(np.abs(run["lateral"].sel(body=rollers)).max()) if rollers else math.nan,
        "lateral_creep_largest_kn": 1e-3 * float(np.abs(lateral_creep(run)).max()),
    }
    return {key: None if isinstance(v, float) and not math.isfinite(v) else v for key, v in found.items()}


def train_slip(run: xr.Dataset) -> xr.DataArray:
    """Slip of the wheels against the train, on a rig of the virtual wheels: flange strikes are none of it."""
    return slip(run.assign(axle_speed=run["virtual_speed"])) if on_rig(run) else slip(run)


def on_rig(run: xr.Dataset) -> bool:
    """Whether a run stands on rollers."""
    return any("roller" in str(body) for body in run["body"].to_numpy())


def amplitude(time: Array, values: Array, begin: float, end: float) -> float:
    """Half of peak to peak within a time [unit of the values]; NaN where there is none of it."""
    within = values[(time >= begin) & (time <= end)]
    return 0.5 * float(np.ptp(within)) if within.size else math.nan


def _waves(time: Array, values: Array, begin: float, end: float) -> Array:
    """Lengths of half-waves of more than 10 um [s], of values in mm."""
    within = (time >= begin) & (time <= end)
    return half_waves(time[within], values[within], 1e-2).duration


def envelope(time: Array, values: Array, window: float = 0.4) -> tuple[Array, Array]:
    """Amplitude over time: half of peak to peak in windows that begin each `window` / 2 [s]."""
    begins = np.arange(time[0], time[-1] - window, 0.5 * window)
    return begins + 0.5 * window, np.array([amplitude(time, values, t, t + window) for t in begins])


# -------------------------------------------------------------------------------------------- lateral guidance that is left


def longitudinal_creep(run: xr.Dataset) -> Array:
    """Creep force along the track on each wheel [N], shape (time, wheel)."""
    return np.asarray(run["patch_creep_force_x"].sum("patch").to_numpy())


def lateral_creep(run: xr.Dataset) -> Array:
    """Creep force across the track on each wheel [N], shape (time, wheel)."""
    return np.asarray(run["patch_creep_force_y"].sum("patch").to_numpy())


def lateral_stiffness(case: Case, run: xr.Dataset) -> float:
    """f22 of Kalker's theory, the mean over the wheels in steady running [N]: from the patches at the start of a run."""
    first, material, total = run.isel(time=0), case.contact.material, 0.0
    for a, b in zip(first["patch_a"].to_numpy().ravel(), first["patch_b"].to_numpy().ravel(), strict=True):
        if a > 0.0 and b > 0.0:
            total += material.shear_modulus * a * b * _core.kalker_coefficients(a / b, material.poisson_ratio)[1]
    return float(total / first.sizes["wheel"])


@dataclass(frozen=True)
class Guidance:
    """Lateral creep of fully sliding axles and what the closed form says; spin's parts of left and right cancel in an axle.

    Attributes:
        force: lateral creep force of an axle [N].
        expected: sum of -F v_y / w over its wheels [N], F the length of a wheel's creep force.
        slope: of force over expected; 1: Coulomb's law.
        correlation: of the two.
        rolling, sliding: damping of one wheel -dF_y/dv_y [N s/m]: f22 / V of Kalker's theory, and the median of F / w.
    """

    force: Array
    expected: Array
    slope: float
    correlation: float
    rolling: float
    sliding: float


def guidance(run: xr.Dataset, stiffness: float) -> Guidance | None:
    """Lateral creep of the axles while they slide fully along the track.

    Args:
        run: with wheels that really slide, as on track.
        stiffness: f22 of a wheel [N].

    Returns:
        What was found; None where no axle slid, or none moved sideways.
    """
    axles = (run.sizes["time"], run.sizes["axle"], 2)  # wheels stand left and right of each axle, in order
    along, across = (run[f"{name}_sliding"].to_numpy().reshape(axles) for name in ("longitudinal", "lateral"))
    x, y = longitudinal_creep(run).reshape(axles), lateral_creep(run).reshape(axles)
    fully = (np.abs(along) > FULL_SLIDING).all(axis=-1)
    if fully.sum() < 10 or float(np.abs(across[fully]).max()) < 1e-4:
        return None
    total, speed = np.hypot(x, y)[fully], np.hypot(along, across)[fully]
    expected, force = -(total * across[fully] / speed).sum(axis=-1), y[fully].sum(axis=-1)
    slope = float(np.dot(expected, force) / np.dot(expected, expected))
    rolling = stiffness / float(np.median(run["rolling_speed"].to_numpy().reshape(axles)[fully]))
    correlation = float(np.corrcoef(expected, force)[0, 1])
    return Guidance(force, expected, slope, correlation, rolling, float(np.median(total / speed)))
