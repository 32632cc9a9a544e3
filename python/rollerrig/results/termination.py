"""Where a run ended: how far along the track, on which segment, and with which quotient Y/Q.

results, their model -> [termination] -> the same with attributes `stopped_...`, and a sentence with all of them
"""

from __future__ import annotations

import math

import numpy as np

from rollerrig.assembly import AssembledModel
from rollerrig.config import Track
from rollerrig.results.dataset import Draft
from rollerrig.track import Segment

LAST_SECONDS = 0.5
"""Before the end: a flange climbs within this time, and in the end it carries nothing [s]."""


def add_termination(draft: Draft, model: AssembledModel) -> None:
    """Add the place where a run ended and the quotient of the wheelset that ended it.

    The attributes `stopped_at_m`, `stopped_segment`, `stopped_quotient`, `stopped_quotient_wheel`; they stand in `status_message`
    too where a wheel ended the run.

    Args:
        draft: results with the attributes of `Outcome`; it is changed.
        model: the model that was run.
    """
    distances = draft.values("distance")
    distance = float(distances[-1]) if len(distances) else 0.0
    segment = _segment(model, distance)
    quotient, wheel = _largest_quotient(draft, model)
    if wheel:
        place = f"{distance:.5g} m" + (f" ({segment})" if segment else "")
        message = draft.attributes["status_message"]
        when, _, rest = message.partition(", ")
        if isinstance(model.case.support.data, Track):
            message = f"{when}, {place}, {rest}"
        draft.attributes["status_message"] = (
            f"{message} Largest unfiltered |Y|/Q of its wheelset in the {LAST_SECONDS:g} s before: {quotient:.2f} at {wheel}."
        )
    draft.attributes.update(
        stopped_at_m=distance, stopped_segment=segment, stopped_quotient=quotient, stopped_quotient_wheel=wheel
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


def _largest_quotient(draft: Draft, model: AssembledModel) -> tuple[float, str]:
    """Largest |Y|/Q of the wheels on the axle that ended the run, and where; NaN and "" if none did, or none is known."""
    blamed = next((wheel for wheel in model.wheels if wheel.name == draft.attributes["stopped_wheel"]), None)
    if blamed is None:
        return math.nan, ""
    columns = [number for number, wheel in enumerate(model.wheels) if wheel.wheelset == blamed.wheelset]
    late = draft.values("time") >= draft.attributes["stopped_at_s"] - LAST_SECONDS
    y, q = np.abs(draft.values("lateral_force")[late][:, columns]), draft.values("vertical_force")[late][:, columns]
    if not np.any(q > 0):
        return math.nan, ""
    quotients = np.where(q > 0, y / np.where(q > 0, q, 1.0), 0.0)
    _, place = np.unravel_index(int(np.argmax(quotients)), quotients.shape)
    return float(quotients.max()), model.wheels[columns[place]].name
