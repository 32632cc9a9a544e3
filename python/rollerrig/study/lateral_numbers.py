"""Lateral motion during a slide as numbers: the runs by name, what is reported of each, and how tables show it.

run -> [run_numbers], Guidance -> [guidance_numbers] -> values by key of QUANTITIES
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.lateral_guidance import (
    Guidance,
    amplitude,
    creep_force,
    hunting_frequency,
    leading_lateral,
    on_rig,
    train_slip,
)
from rollerrig.analysis.tracking import largest, rms, tracking
from rollerrig.config import Case
from rollerrig.study.ensemble import estimate
from rollerrig.study.jobs import Progress, whole_run
from rollerrig.study.quantities import Quantities, Quantity

LABELS = {
    "rig": "rig as it is, displaced",
    "rig_centred": "rig as it is, centred",
    "rig_rigid": "rigid rollers, displaced",
    "rig_rigid_centred": "rigid rollers, centred",
    "rig_dry": "rig as it is, displaced, dry virtual rail",
    "track": "track, displaced",
    "track_dry": "track, displaced, dry rail",
    "track_paper": "track, displaced, the paper's creep law",
    "track_unbraked": "track, displaced, unbraked",
    "track_stiff": "track, displaced, k_A = k_S = 1",
    "track_stiff_unbraked": "track, displaced, k_A = k_S = 1, unbraked",
    "track_polach_stiff_unbraked": "track, displaced, k_A = k_S = 1, unbraked, Polach's creep law",
}
"""Key of a run -> its label; displaced: by the case's disturbance."""

GUIDED = ("track", "track_paper")
"""Runs whose lateral creep is compared with the closed form."""

REPEATED = ("rig", "rig_rigid")
"""Runs in which flanges strike: repeated with a disturbance that differs by 1e-9, since no single figure of theirs is certain."""

PERCENT = ("%", 100.0)
ROUND_OFF = 1e-6
"""A centred bogie stays in the middle to 1e-10 mm; what is smaller than this is no motion [mm]."""


def _motion(key: str, meaning: str, label: str) -> Quantity:
    return Quantity(f"runs.*.{key}_mm", meaning, "mm", label, 3, least=ROUND_OFF)


RUN = (
    Quantity("runs.*.status", "how the run ended"),
    Quantity("runs.*.tracking_rms", "wheel less virtual wheel over train speed, RMS; on track null", "1", "tracking error, RMS",
             3, PERCENT),
    Quantity("runs.*.tracking_largest", "largest of the same", "1", "tracking error, largest", 3, PERCENT),
    Quantity("runs.*.real_sliding_rms_mps", "wheel against roller along the track; on track wheel against rail", "m/s",
             "real sliding, RMS", 3),
    Quantity("runs.*.real_sliding_largest_mps", "largest of the same", "m/s", "real sliding, largest", 3),
    Quantity("runs.*.largest_slip", "of the wheels against the train, over its speed", "1", "slip against the train, largest", 3,
             PERCENT),
    _motion("amplitude_before", "leading wheelset, half peak to peak in the second before the slide",
            "amplitude before the slide"),
    _motion("amplitude_in_slide", "largest of the same over seconds, from 1 s into the slide on", "amplitude in the slide"),
    _motion("amplitude_end", "of the last second", "amplitude at the end"),
    Quantity("runs.*.frequency_hz", "of the half-waves in the second before the slide; null: none", "Hz",
             "hunting frequency before the slide", 3),
    _motion("largest_lateral", "displacement of the leading wheelset", "lateral displacement, largest"),
    _motion("roller_lateral", "largest displacement of a roller axle", "lateral displacement of a roller, largest"),
    Quantity("runs.*.lateral_creep_largest_kn", "of one wheel", "kN", "lateral creep force of a wheel, largest", 3, least=1e-6),
)  # fmt: skip
GUIDANCE = (
    Quantity("guidance.*.slope", "lateral creep force of fully sliding axles over -F v_y / v_s; 1: Coulomb", "1",
             "slope against −F v_y/v_s", 3),
    Quantity("guidance.*.correlation", "of the two", "1", "correlation", 3),
    Quantity("guidance.*.rolling_ns_per_m", "damping of a rolling wheel, f22 / V", "N s/m", "rolling: f₂₂/V", 3),
    Quantity("guidance.*.sliding_ns_per_m", "of a sliding one, median of F / v_s", "N s/m", "sliding: F/v_s", 3),
)  # fmt: skip
CHAOTIC = ("tracking_rms", "real_sliding_largest_mps", "amplitude_before_mm", "amplitude_in_slide_mm")
"""Quantities of a run that the smallest change moves."""

_OF_RUN = {quantity.name: quantity for quantity in RUN}
ENSEMBLE = tuple(
    replace(_OF_RUN[name], key=f"ensemble.*.{name}{suffix}", meaning=f"{_OF_RUN[name].meaning}; {what}",
            label=f"{_OF_RUN[name].label}{mark}")
    for name in CHAOTIC
    for suffix, what, mark in (
        ("", "mean of runs whose disturbances differ by 1e-9", ""),
        ("_standard_error", "standard error of that mean", ", s.e."),
    )
)  # fmt: skip
QUANTITIES = Quantities(
    Quantity("case", "name of the case"),
    Quantity("slide_begins_s", "on track, the time that divides all runs; null: never", "s"),
    RUN,
    ENSEMBLE,
    GUIDANCE,
)


def run_measured(case: Case, slide: float, progress: Progress | None = None) -> dict[str, Any]:
    """The numbers of one more member of an ensemble."""
    return run_numbers(whole_run(case, progress), slide)


def ensemble_numbers(members: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Means and standard errors by name of ENSEMBLE."""
    found = {}
    for name in CHAOTIC:
        one = estimate([member[name] for member in members])
        found[name], found[f"{name}_standard_error"] = one.mean, one.standard_error
    return found


def run_numbers(run: xr.Dataset, slide: float) -> dict[str, Any]:
    """The numbers of one run by name of RUN; NaN where not defined.

    Args:
        run: of the study.
        slide: when the wheels begin to slide, the same for all runs [s]; NaN: they do not.
    """
    error, largest_error = tracking(run) if on_rig(run) else (math.nan, math.nan)
    time, lateral = run["time"].to_numpy(), leading_lateral(run)
    begin = slide if math.isfinite(slide) else float(time[-1])
    later = [amplitude(time, lateral, t, t + 1.0) for t in np.arange(begin + 1.0, time[-1] - 0.999)]
    rollers = [body for body in map(str, run["body"].to_numpy()) if "roller" in body]
    return {
        "status": run.attrs["status"],
        "tracking_rms": error,
        "tracking_largest": largest_error,
        "real_sliding_rms_mps": rms(run["real_sliding"]),
        "real_sliding_largest_mps": float(np.abs(run["real_sliding"]).max()),
        "largest_slip": largest(train_slip(run)),
        "amplitude_before_mm": amplitude(time, lateral, begin - 1.0, begin),
        "amplitude_in_slide_mm": max(later, default=math.nan),
        "amplitude_end_mm": amplitude(time, lateral, time[-1] - 1.0, time[-1]),
        "frequency_hz": hunting_frequency(time, lateral, begin - 1.0, begin),
        "largest_lateral_mm": float(np.abs(lateral).max()),
        "roller_lateral_mm": 1e3 * float(np.abs(run["lateral"].sel(body=rollers)).max()) if rollers else math.nan,
        "lateral_creep_largest_kn": 1e-3 * float(np.abs(creep_force(run, "y")).max()),
    }


def guidance_numbers(found: Guidance) -> dict[str, float]:
    """Lateral creep of sliding axles by name of GUIDANCE."""
    values = (found.slope, found.correlation, found.rolling, found.sliding)
    return dict(zip((q.name for q in GUIDANCE), values, strict=True))
