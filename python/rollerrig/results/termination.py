"""Where a run ended: how far along the track, on which segment, and with which quotient Y/Q.

results, their model -> [termination] -> the same with attributes `stopped_...`, and a sentence with all of them
"""

import math

import numpy as np
import xarray as xr

from rollerrig.assembly.model import AssembledModel
from rollerrig.common.arrays import Array
from rollerrig.config import Track
from rollerrig.profiles.table import ProfileTable
from rollerrig.results.dataset import Draft
from rollerrig.track import Segment

LAST_SECONDS = 0.5
"""Before the end: a flange climbs within this time, and in the end it carries nothing [s]."""

PATCH = ("wheel_abscissa", "rail_abscissa", "contact_angle", "normal")
FORCES = ("lateral_force", "vertical_force")

NO_FURTHER = 0.2e-3
"""A profile whose points reach no further than this beyond its table ends there; else it only becomes too steep [m]."""

BESIDE = 1e-3
"""A contact further from the end of its profiles did not come to it [m]: core/src/system/contact_monitor.cpp has 0.5 mm."""

LESS = "Less force on the flange (speed, cant deficiency, friction) or a smaller step may keep it on its rail."
FLEXIBLE = "The rails are rigid: support.foundation, as flexible_track has it, lets them give way."
"""What to try where a wheel comes to the end of a profile, and where it chatters or leaves its rail."""


def add_termination(draft: Draft, model: AssembledModel) -> None:
    """Add to a draft the place where a run ended and the quotient of the wheelset that ended it.

    The attributes `stopped_at_m`, `stopped_segment`, `stopped_quotient`, `stopped_quotient_wheel`; they are in `status_message`
    too where a wheel ended the run.
    """
    distances = draft.values("distance")
    distance = float(distances[-1]) if len(distances) else 0.0
    segment = segment_in_words(model, distance)
    quotient, wheel = _largest_quotient(draft, model)
    if draft.attributes["status"] == "contact_lost" and draft.attributes["stopped_wheel"]:
        draft.attributes["status_message"] += _last_touch_in_words(draft, model)
    if wheel:
        place = f"{distance:.5g} m" + (f" ({segment})" if segment else "")
        message = draft.attributes["status_message"]
        when, _, rest = message.partition(", ")
        if isinstance(model.case.support.data, Track):
            message = f"{when}, {place}, {rest}"
        largest = (
            f"Largest unfiltered |Y|/Q of its wheelset in the {LAST_SECONDS:g} s before: {quotient:.2f} at {wheel}."
        )
        draft.attributes["status_message"] = f"{message} {largest}"
    draft.attributes.update({"stopped_at_m": distance, "stopped_segment": segment})
    draft.attributes.update({"stopped_quotient": quotient, "stopped_quotient_wheel": wheel})


def contact_in_words(model: AssembledModel, wheel: str, status: str, last: xr.Dataset) -> str:
    """Where the wheel that ended a run touches in the last state, what it carries, and what to try; with a blank before it."""
    s, y, angle, load = (last[f"patch_{name}"].sel(wheel=wheel).to_numpy().ravel() for name in PATCH)
    forces = [float(last[name].sel(wheel=wheel).squeeze()) for name in FORCES]
    parts, ends = [], False
    if np.any(load > 0):
        left = np.array([_left(model.wheel_profile, s), _left(_rail(model, wheel), y)])
        side, k = np.unravel_index(int(np.argmin(np.where(load > 0, left, np.inf))), left.shape)
        parts.append(f"It touches {_touch_in_words(model, wheel, s[k], y[k], angle[k], *forces)}")
        if status == "off_profile":
            profile, place = ((model.wheel_profile, s), (_rail(model, wheel), y))[side]
            ends = left[side, k] < BESIDE and _points_end(profile, place[k])
            parts.append(f"That is {1e3 * left[side, k]:.1f} mm from the end of the {profile.kind}'s profile.")
            parts.append("Its points end there: give a profile that reaches further." if ends else LESS)
    if isinstance(model.case.support.data, Track) and not model.rails and not ends:
        parts.append(FLEXIBLE)
    return "".join(f" {part}" for part in parts)


def _last_touch_in_words(draft: Draft, model: AssembledModel) -> str:
    """Where a wheel that lost contact touched in the last record in which it carried; a blank before it; "" if in none."""
    number = [wheel.name for wheel in model.wheels].index(wheel := draft.attributes["stopped_wheel"])
    s, y, angle, load = (draft.values(f"patch_{name}")[:, number] for name in PATCH)
    carried = np.flatnonzero(np.any(load > 0, axis=1))
    if not len(carried):
        return ""
    row = carried[-1]
    k = int(np.nanargmax(load[row]))
    forces = [draft.values(name)[row, number] for name in FORCES]
    when = draft.values("time")[row]
    touch = _touch_in_words(model, wheel, s[row, k], y[row, k], angle[row, k], *forces)
    return f" It last touched at t = {when:.4g} s: {touch}"


def _touch_in_words(model: AssembledModel, wheel: str, s: float, y: float, angle: float, side: float, up: float) -> str:
    """Abscissae of one patch on both profiles, its angle, and the forces of the wheel."""
    return (
        f"its profile ({model.wheel_profile.name}) at S = {1e3 * s:.1f} mm, the rail ({_rail(model, wheel).name}) at "
        f"y = {1e3 * y:.1f} mm, {'flange' if s < 0 else 'field'} side, contact angle {math.degrees(abs(angle)):.0f} degrees, "
        f"Y {1e-3 * side:.1f} kN, Q {1e-3 * up:.1f} kN, |Y|/Q {abs(side) / max(up, 1.0):.2f}."
    )


def _rail(model: AssembledModel, wheel: str) -> ProfileTable:
    return model.right_rail_profile if wheel.endswith("_right") else model.rail_profile


def _left(profile: ProfileTable, places: Array) -> Array:
    """How far the end of a profile is from places on it, along it as core/src/system/contact_monitor.cpp measures it [m]."""
    low, high = profile.domain
    near = np.where(2.0 * places < low + high, low, high)
    inside = np.nan_to_num(np.clip(places, low, high))
    return np.hypot(near - inside, profile.evaluate(near) - profile.evaluate(inside))


def _points_end(profile: ProfileTable, place: float) -> bool:
    """Whether the points of a profile end where its table does, at the end nearer to a place: then a longer one helps."""
    (low, high), along = profile.domain, profile.outline[:, 0]
    beyond = low - along.min() if 2.0 * place < low + high else along.max() - high
    return bool(beyond < NO_FURTHER)


def segment_in_words(model: AssembledModel, distance: float) -> str:
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
