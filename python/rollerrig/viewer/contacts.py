"""Contact patches of a run, and of a simulation that goes on: asked of the core's contact geometry, never computed here.

    run at its frames -> [contact_places] -> per wheel and patch: point on roller or rail, peak pressure, length, width
    AssembledModel, values of a frame -> [LiveContacts] -> values of the columns of patches

A run records abscissas, forces and axes of its patches. The point in space follows from the pose of the wheelset against its
rollers or rails by the geometry of the core, which is asked once per frame; it also knows peak pressure, loaded length and width.
"""

import math
from collections.abc import Mapping
from functools import partial

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel
from rollerrig.common.arrays import Array
from rollerrig.config import Track
from rollerrig.config.schema.support import NOWHERE, rail_layout

PLACE = ("x", "y", "z", "peak_pressure", "length", "width")
"""What is found of a patch: point from the crown or top of rail below the wheelset's design position [m], [Pa], [m]."""

_FARTHEST = 3e-3
"""Between the abscissas of a recorded patch and the one that the geometry finds: more is another patch [m]."""


def contact_places(model: AssembledModel, run: xr.Dataset, patches: int) -> Array:
    """Places of so many of the recorded patches of each wheel.

    Returns:
        (frames, wheels, patches, len(PLACE)); NaN where there is no patch, or the geometry finds none there.
    """
    found = np.full((run.sizes["time"], len(model.wheels), patches, len(PLACE)), np.nan)
    s = run["patch_wheel_abscissa"].to_numpy()
    poses = {name: relative_pose(model, run, name) for name in model.wheelsets}
    static = {name: static_contact(model, name) for name in model.wheelsets}
    for number, wheel in enumerate(model.wheels):
        contact, right = static[wheel.wheelset], wheel.side == "right"
        for frame, pose in enumerate(poses[wheel.wheelset][right]):
            recorded = s[frame, number, :patches]
            if not np.isfinite(recorded).any() or not np.isfinite(pose).all():
                continue
            x, y, z, roll, yaw = pose
            for patch in contact.patches(x, y, z, yaw, roll, right):
                k = int(np.nanargmin(np.abs(recorded - patch.wheel_s)))
                if abs(recorded[k] - patch.wheel_s) < _FARTHEST:
                    found[frame, number, k] = (*patch.point, patch.peak_pressure, patch.length, patch.width)
    return found


def relative_pose(model: AssembledModel, run: xr.Dataset, wheelset: str) -> dict[bool, Array]:
    """Pose of a wheelset against what it stands on, x, y, z, roll, yaw (frames, 5); True: on the right."""
    own = _motion(run, wheelset)
    poses: dict[bool, Array] = {}
    support = model.case.support.data
    layout = rail_layout(support) if isinstance(support, Track) else None
    for right, side in ((False, "left"), (True, "right")):
        under = support_under(model, wheelset, side)
        moved = _motion(run, under) if under else np.zeros_like(own)
        wheel = run.sel(wheel=f"{wheelset}_{side}")
        moved[:, 1] += wheel["rail_lateral"].to_numpy()
        moved[:, 2] += wheel["rail_vertical"].to_numpy()
        poses[right] = own - moved
        poses[right][:, 1:3] = seen_from_rail(
            model, under, wheelset, poses[right][:, 1], poses[right][:, 2], moved[:, 3]
        )
        roll = layout[f"{side}_roll"] if layout else NOWHERE
        if len(roll.rows):
            x, _, height = model.positions[wheelset]
            lean = roll.evaluate(run["distance"].to_numpy() + x)
            head = -model.right_rail_origin_y if right else model.rail_origin_y
            _, y, z, _, _ = poses[right].T
            poses[right][:, 1:3] = _in_turned_axes(y, z, lean, (head, -height))
            poses[right][:, 3] -= lean
    return poses


def support_under(model: AssembledModel, wheelset: str, side: str) -> str:
    """The roller or piece of rail under a wheel; "" for a rigid rail."""
    number = wheelset.removeprefix("wheelset_")
    names = (f"roller_{number}", f"roller_{number}_{side}", f"rail_{number}_{side}")
    return next((name for name in names if name in model.bodies), "")


def seen_from_rail(
    model: AssembledModel, under: str, wheelset: str, y: Array | float, z: Array | float, roll: Array | float
) -> Array:
    """Lateral and vertical displacement of a wheelset in the axes of a rail that rolls about its centre of mass (..., 2) [m].

    Args:
        model: of the run.
        under: the rail; a roller does not roll, "": nothing moves.
        wheelset: its name.
        y: lateral displacement of the wheelset less that of the rail [m].
        z: the same upwards.
        roll: of the rail [rad].
    """
    if not under:
        return np.stack([y, z], axis=-1)
    (_, y_rail, z_rail), height = model.positions[under], model.positions[wheelset][2]
    return _in_turned_axes(y, z, roll, (y_rail, z_rail - height))


def _in_turned_axes(y: Array | float, z: Array | float, roll: Array | float, middle: tuple[float, float]) -> Array:
    """A displacement in axes that are turned about a point, given from the wheelset's centre [m]."""
    sine, cosine = np.sin(roll), np.cos(roll)
    y, z = y - middle[0], z - middle[1]
    return np.stack([cosine * y + sine * z + middle[0], cosine * z - sine * y + middle[1]], axis=-1)


def _motion(run: xr.Dataset, body: str) -> Array:
    one = run.sel(body=body)
    return np.stack([one[name].to_numpy() for name in ("longitudinal", "lateral", "vertical", "roll", "yaw")], axis=1)


def static_contact(model: AssembledModel, wheelset: str) -> _core.StaticWheelsetContact:
    """The contact geometry of a wheelset on what it stands on."""
    of_side = {wheel.side: wheel.contact for wheel in model.wheels if wheel.wheelset == wheelset}
    return _core.StaticWheelsetContact(model.core, of_side["left"], of_side["right"])


PATCH = (*PLACE, "a", "b", "normal", "contact_angle", "creep_force_x", "creep_force_y", "sliding_x", "sliding_y")
_POSE = ("longitudinal", "lateral", "vertical", "yaw", "roll")


class LiveContacts:
    """The most loaded patch of every wheel."""

    def __init__(self, model: AssembledModel) -> None:
        self._wheels = [
            (
                model.bodies.index(wheel.wheelset),
                model.bodies.index(under) if (under := support_under(model, wheel.wheelset, wheel.side)) else -1,
                wheel.side == "right",
                static_contact(model, wheel.wheelset),
                partial(seen_from_rail, model, under, wheel.wheelset),
            )
            for wheel in model.wheels
        ]

    def values(self, frame: Mapping[str, float]) -> list[float]:
        """Values of the columns PATCH of all wheels, one after the other; NaN where a wheel does not touch."""
        found: list[float] = []
        for number, (body, under, right, contact, seen) in enumerate(self._wheels):
            pose = [frame.get(f"b{body}.{name}", 0.0) for name in _POSE]
            moved = [frame.get(f"b{under}.{name}", 0.0) for name in _POSE] if under >= 0 else [0.0] * len(_POSE)
            x, y, z, yaw, roll = (one - other for one, other in zip(pose, moved, strict=True))
            y -= frame.get(f"w{number}.rail_lateral", 0.0)
            z -= frame.get(f"w{number}.rail_vertical", 0.0)
            y, z = seen(y, z, moved[-1]).tolist()
            patches = contact.patches(x, y, z, yaw, roll, right) if math.isfinite(x + y + z + yaw + roll) else []
            loaded = max(patches, key=lambda patch: patch.normal, default=None)
            found += [math.nan] * len(PATCH) if loaded is None else _columns(loaded, frame, number)
        return found


def _columns(patch: _core.StaticPatch, frame: Mapping[str, float], number: int) -> list[float]:
    inwards = -patch.direction[1] if not patch.right else patch.direction[1]
    shape = (patch.peak_pressure, patch.length, patch.width, patch.a, patch.b, patch.normal)
    slip = (frame.get(f"w{number}.{name}_sliding", math.nan) for name in ("longitudinal", "lateral"))
    angle, creep = math.atan2(inwards, patch.direction[2]), frame.get(f"w{number}.creep", 0.0)
    return [*patch.point, *shape, angle, creep, 0.0, *slip]
