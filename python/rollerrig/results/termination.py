"""Where a run ended: how far along the track, on which segment, and with which quotient Y/Q.

run, its model -> [termination] -> the run with attributes `stopped_...`, and a sentence with all of them
"""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from rollerrig.assembly import AssembledModel
from rollerrig.config import Track
from rollerrig.track import Segment

LAST_SECONDS = 0.5
"""Before the end: a flange climbs within this time, and in the end it carries nothing [s]."""


def add_termination(run: xr.Dataset, model: AssembledModel) -> xr.Dataset:
    """The run with the place of its end and the quotient of the wheelset that ended it.

    Args:
        run: results with the attributes of `Outcome`.
        model: the model that was run.

    Returns:
        The same with `stopped_at_m`, `stopped_segment`, `stopped_quotient`, `stopped_quotient_wheel`; they stand in
        `status_message` too where a wheel ended the run.
    """
    distance = float(run["distance"][-1]) if run.sizes["time"] else 0.0
    segment = _segment(model, distance)
    quotient, wheel = _largest_quotient(run, model)
    message = run.attrs["status_message"]
    if wheel:
        place = f"{distance:.5g} m" + (f" ({segment})" if segment else "")
        when, _, rest = message.partition(", ")
        if isinstance(model.case.support.data, Track):
            message = f"{when}, {place}, {rest}"
        message += (
            f" Largest unfiltered |Y|/Q of its wheelset in the {LAST_SECONDS:g} s before: {quotient:.2f} at {wheel}."
        )
    return run.assign_attrs(
        status_message=message,
        stopped_at_m=distance,
        stopped_segment=segment,
        stopped_quotient=quotient,
        stopped_quotient_wheel=wheel,
    )


def _segment(model: AssembledModel, distance: float) -> str:
    """`segment[2], a curve of radius 300 m to the left`; empty on a track without segments and on a rig."""
    if model.line is None:
        return ""
    number = model.line.segment_at(distance)
    return f"segment[{number}], {in_words(model.line.segments[number])}"


def in_words(segment: Segment) -> str:
    """A straight, a transition, or a curve of a radius to one side."""
    if segment.kind != "curve":
        return f"a {segment.kind}"
    curvature = segment.curvature[0]
    return f"a curve of radius {1 / abs(curvature):g} m to the {'left' if curvature > 0 else 'right'}"


def _largest_quotient(run: xr.Dataset, model: AssembledModel) -> tuple[float, str]:
    """Largest |Y|/Q of the wheels on the axle that ended the run, and where; NaN and "" if none did, or none is known."""
    blamed = next((wheel for wheel in model.wheels if wheel.name == run.attrs["stopped_wheel"]), None)
    if blamed is None:
        return math.nan, ""
    wheels = [wheel.name for wheel in model.wheels if wheel.wheelset == blamed.wheelset]
    late = run.isel(time=run["time"].to_numpy() >= run.attrs["stopped_at_s"] - LAST_SECONDS).sel(wheel=wheels)
    y, q = np.abs(late["lateral_force"].to_numpy()), late["vertical_force"].to_numpy()
    if not np.any(q > 0):
        return math.nan, ""
    quotients = np.where(q > 0, y / np.where(q > 0, q, 1.0), 0.0)
    _, place = np.unravel_index(int(np.argmax(quotients)), quotients.shape)
    return float(quotients.max()), wheels[place]
