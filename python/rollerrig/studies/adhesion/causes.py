"""Why the rig differs from the track: the same test with one imperfection of the rig after the other taken away.

Case -> [variants of the rig, the same test begun a little later] -> shares of the causes, and how much chance there is

The first variants build on each other, so that their differences add up to the whole: wheels roll on the rollers without
sliding, then the drives have no lag and no limit, then force and torque are known. What remains between the last and the track
is what the virtual train leaves out. Slide protection and wheel-slip control switch on small differences: tests begun some
milliseconds later show how much of a difference is chance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.tracking import distances
from rollerrig.config import Case

STEPS = ("rolling", "drives", "estimator")
STATIC_LOADS = "static_loads"
LATER = (0.01, 0.02, 0.03, 0.04)
"""How much later the repeated tests begin [s]."""

VARIANT_WORDS = {
    "rig": "the rig as it is",
    "rolling": "its wheels roll on the rollers without sliding",
    "drives": "and its roller drives have neither lag nor limit",
    "estimator": "and force and torque of the axles are known exactly",
    STATIC_LOADS: "the rig as it is, but its virtual train knows no load transfer",
}
CAUSE_WORDS = {
    "rolling": "sliding of the wheels on the rollers",
    "drives": "lag and limit of the roller drives",
    "estimator": "lag of the estimated torque",
    "model": "what the virtual train leaves out, and sampling",
}
_QUICK_MOTOR_HZ, _NO_LIMIT = 400.0, 1e7
"""More is not to be had with samples of 1 ms; [N m]."""


def variants_of(case: Case) -> tuple[str, ...]:
    """Names of the variants that say something about this case."""
    assert case.rig_control is not None
    return (*STEPS, STATIC_LOADS) if case.rig_control.load_transfer != "none" else STEPS


def variant(case: Case, name: str) -> Case:
    """The rig without some of its imperfections; see VARIANT_WORDS."""
    control = case.rig_control
    assert control is not None
    if name == STATIC_LOADS:
        return case.model_copy(update={"rig_control": control.model_copy(update={"load_transfer": "none"})})
    taken = STEPS[: STEPS.index(name) + 1]
    changes: dict[str, Any] = {}
    if "drives" in taken:
        changes["motor"] = control.motor.model_copy(
            update={"bandwidth": _QUICK_MOTOR_HZ, "damping_ratio": 0.0, "envelope": None}
        )
        changes["feedback"] = control.feedback.model_copy(update={"largest": _NO_LIMIT})
    if "estimator" in taken:
        changes["estimator"] = control.estimator.model_copy(update={"kind": "exact"})
    bench = case.bench.model_copy(update={"pure_rolling": True})
    return case.model_copy(update={"rig_control": control.model_copy(update=changes), "bench": bench})


def begun_later(case: Case, seconds: float) -> Case:
    """The same test with all demands that much later."""
    changes = {}
    for key in ("brake", "traction"):
        table = getattr(case, key)
        if table is not None:
            rows = tuple((time + seconds if time > 0.0 else time, value) for time, value in table.demand)
            changes[key] = table.model_copy(update={"demand": rows})
    return case.model_copy(update=changes)


def shares(track: xr.Dataset, rig: xr.Dataset, variants: Mapping[str, xr.Dataset]) -> dict[str, float] | None:
    """Parts of (distance of the rig / distance of the track - 1) by cause, CAUSE_WORDS; they add up to it. None if unknown."""
    if any(name not in variants for name in STEPS):
        return None
    way_track, *ways = distances([track, rig, *(variants[name] for name in STEPS)])
    causes = (*STEPS, "model")
    return {
        cause: (before - after) / way_track
        for cause, before, after in zip(causes, ways, [*ways[1:], way_track], strict=True)
    }


def spread(runs: Sequence[xr.Dataset]) -> float | None:
    """Range of the distances of the same test begun at different instants, over their mean; None for a single run."""
    if len(runs) < 2:
        return None
    ways = distances(runs)
    return (max(ways) - min(ways)) / float(np.mean(ways))
