"""Of the modes at the speed of a case: the one that comes nearest to growing, and the hunting mode."""

from __future__ import annotations

import numpy as np

from rollerrig.config import Case
from rollerrig.config.schema.plan import StabilityMeasure
from rollerrig.study.jobs import Progress, whole_modes

QUANTITIES = {
    "growth_rate": ("1/s", "largest growth rate of an oscillatory mode; negative: all decay"),
    "damping": ("1", "damping of that mode over critical damping"),
    "frequency": ("Hz", "its frequency"),
    "hunting_frequency": ("Hz", "of the least damped hunting mode"),
    "hunting_damping": ("1", "its damping over critical damping"),
}


def measure(case: Case, options: StabilityMeasure, progress: Progress | None = None) -> dict[str, float]:
    """Modes at the case's speed; the numbers of QUANTITIES.

    Raises:
        StartError: no rolling equilibrium.
    """
    modes = whole_modes(case, [3.6 * case.motion.speed], progress).isel(speed=0)
    first = modes.isel(mode=int(np.nanargmax(modes["growth_rate"].to_numpy())))
    found = {name: float(first[name]) for name in ("growth_rate", "damping", "frequency")}
    return {**found, **{name: float(modes[name]) for name in ("hunting_frequency", "hunting_damping")}}
