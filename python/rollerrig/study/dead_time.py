"""Equivalent dead time, measured: with how much more dead time of its slide protection the track does as the rig does.

Case of a rig -> [later_protection] -> cases on track -> ensembles of a number -> [measured_dead_time] -> Estimate [s]
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from rollerrig.analysis.equivalent_dead_time import DeadTime, at_track_of
from rollerrig.config import Case
from rollerrig.study.ensemble import Estimate

SHARES = (0.5, 1.0, 1.5)
"""Of the predicted dead time, at which the track is run."""

LEAST_STEP = 2e-3
"""Between them at least [s]: less is not seen beside the scatter of the distance."""


def protection_of(case: Case) -> str | None:
    """Table of what protects the axles of this test, whose `delay` is the dead time; None: nothing of ours does."""
    name = "slide_protection" if case.brake is not None else "wheel_slip_control"
    table = getattr(case, name)
    return name if table is not None and table.is_ours else None


def later_protection(case: Case, dead_time: float) -> Case:
    """The same test with so much more dead time of the protection [s], a multiple of the sampling step."""
    name = protection_of(case)
    assert name is not None
    table = getattr(case, name)
    return case.model_copy(update={name: table.model_copy(update={"delay": table.delay + dead_time})})


def dead_times(case: Case, predicted: DeadTime | None) -> tuple[float, ...]:
    """Additional dead times at which to run the track [s], ascending, multiples of the sampling step."""
    if predicted is None or protection_of(case) is None:
        return ()
    step, reach = case.time.sampling_step, max(predicted.total, LEAST_STEP / SHARES[0])
    return tuple(sorted({max(1, round(share * reach / step)) * step for share in SHARES}))


def measured_dead_time(rig: Estimate, track: Mapping[float, Estimate]) -> Estimate:
    """Additional dead time [s] with which the track has the rig's mean number: its distance, or its ventings.

    Args:
        rig: that number of the rig.
        track: additional dead time [s] -> the same on track, 0 among them.

    Returns:
        By linear interpolation between two ensembles; NaN where the rig's number is outside all of the track's.
    """
    found, slope = at_track_of(rig.mean, {delay: one.mean for delay, one in track.items()})
    if not math.isfinite(found):
        return Estimate(math.nan, math.nan, 0.0)
    delays = sorted(track)
    k = next((k for k, delay in enumerate(delays[1:]) if found <= delay), 0)
    low, high = delays[k], delays[k + 1]
    part = (found - low) / (high - low)
    errors = (rig.standard_error, (1.0 - part) * track[low].standard_error, part * track[high].standard_error)
    return Estimate(found, math.hypot(*errors) / abs(slope), min(rig.freedom, track[low].freedom, track[high].freedom))
