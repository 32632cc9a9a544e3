"""Contact patches of a run, and of a simulation that goes on: asked of the core's contact geometry, never computed here.

    run at its frames -> [contact_places] -> per wheel and patch: point on roller or rail, peak pressure, length, width
    wheels of an AssembledModel, values of a frame -> [live_places] -> values of the columns of patches

A run records abscissas, forces and axes of its patches. The point in space follows from the pose of the wheelset against its
rollers or rails by the geometry of the core, which is asked once per frame; it also knows peak pressure, loaded length and width.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel
from rollerrig.assembly.model_parts import WheelInfo
from rollerrig.common.arrays import Array
from rollerrig.config import Track
from rollerrig.config.schema.support import NOWHERE, rail_layout

PLACE = ("x", "y", "z", "peak_pressure", "length", "width")
"""What is found of a patch: point from the crown or top of rail below the wheelset's design position [m], [Pa], [m]."""

_FARTHEST = 3e-3
"""Between the abscissas of a recorded patch and the one that the geometry finds: more is another patch [m]."""


PATCH = (*PLACE, "a", "b", "normal", "contact_angle", "creep_force_x", "creep_force_y", "sliding_x", "sliding_y")
"""Columns of a patch of a simulation that goes on."""

Motion = Callable[[str], Sequence[Any]]
"""Name of a body -> its displacements MOTION, numbers or arrays over the frames."""
MOTION = ("longitudinal", "lateral", "vertical", "roll", "yaw")


class Standing:
    """A wheel on what it stands on: a roller, a piece of rail, or a rigid rail, which has no body."""

    def __init__(self, model: AssembledModel, wheel: WheelInfo) -> None:
        self.wheelset, self.right = wheel.wheelset, wheel.side == "right"
        number = wheel.wheelset.removeprefix("wheelset_")
        names = (f"roller_{number}", f"roller_{number}_{wheel.side}", f"rail_{number}_{wheel.side}")
        self._under = next((name for name in names if name in model.bodies), None)
        of_side = {one.side: one.contact for one in model.wheels if one.wheelset == wheel.wheelset}
        self._contact = _core.StaticWheelsetContact(model.core, of_side["left"], of_side["right"])
        self._along, _, height = model.positions[wheel.wheelset]
        _, y, z = model.positions[self._under] if self._under else (0.0, 0.0, height)
        self._middle = y, z - height
        support = model.case.support.data
        layout = rail_layout(support) if isinstance(support, Track) else None
        self._lean = layout[f"{wheel.side}_roll"] if layout else NOWHERE
        self._head = -model.right_rail_origin_y if self.right else model.rail_origin_y, -height

    def pose(self, motion: Motion, rail: Sequence[Any], distance: Any) -> list[Any]:
        """Pose of the wheelset against what the wheel stands on: x, y, z, roll, yaw, numbers or arrays over the frames.

        Args:
            motion: of the bodies.
            rail: lateral and vertical displacement of the rail by its irregularity [m].
            distance: run [m].
        """
        moved = list(motion(self._under) if self._under else [0.0] * len(MOTION))
        moved[1:3] = moved[1] + rail[0], moved[2] + rail[1]
        x, y, z, roll, yaw = (one - other for one, other in zip(motion(self.wheelset), moved, strict=True))
        if self._under:
            y, z = _in_turned_axes(y, z, moved[3], self._middle)
        if len(self._lean.rows):
            lean = self._lean.evaluate(distance + self._along)
            y, z = _in_turned_axes(y, z, lean, self._head)
            roll = roll - lean
        return [x, y, z, roll, yaw]

    def patches(self, pose: Sequence[float]) -> list[_core.StaticPatch]:
        """The patches of a pose; none where it is not finite."""
        x, y, z, roll, yaw = pose
        return list(self._contact.patches(x, y, z, yaw, roll, self.right)) if math.isfinite(sum(pose)) else []


def _in_turned_axes(y: Any, z: Any, roll: Any, middle: tuple[float, float]) -> tuple[Any, Any]:
    """A displacement in axes that are turned about a point, given from the wheelset's centre [m]."""
    sine, cosine = np.sin(roll), np.cos(roll)
    y, z = y - middle[0], z - middle[1]
    return cosine * y + sine * z + middle[0], cosine * z - sine * y + middle[1]


def contact_places(model: AssembledModel, run: xr.Dataset, patches: int) -> Array:
    """Places of so many of the recorded patches of each wheel.

    Returns:
        (frames, wheels, patches, len(PLACE)); NaN where there is no patch, or the geometry finds none there.
    """
    found = np.full((run.sizes["time"], len(model.wheels), patches, len(PLACE)), np.nan)
    s, distance = run["patch_wheel_abscissa"].to_numpy()[:, :, :patches], run["distance"].to_numpy()

    def motion(body: str) -> list[Array]:
        return [run[name].sel(body=body).to_numpy() for name in MOTION]

    for number, wheel in enumerate(model.wheels):
        standing = Standing(model, wheel)
        rail = [run[f"rail_{name}"].sel(wheel=wheel.name).to_numpy() for name in ("lateral", "vertical")]
        poses = np.transpose(standing.pose(motion, rail, distance))
        for frame in np.flatnonzero(np.isfinite(s[:, number]).any(axis=1)):
            recorded = s[frame, number]
            for patch in standing.patches(poses[frame].tolist()):
                k = int(np.nanargmin(np.abs(recorded - patch.wheel_s)))
                if abs(recorded[k] - patch.wheel_s) < _FARTHEST:
                    found[frame, number, k] = (*patch.point, patch.peak_pressure, patch.length, patch.width)
    return found


def live_places(standing: Sequence[Standing], bodies: Sequence[str], frame: Mapping[str, float]) -> list[float]:
    """Values of the columns PATCH of the most loaded patch of every wheel; NaN where a wheel does not touch."""
    found: list[float] = []

    def motion(body: str) -> list[float]:
        return [frame.get(f"b{bodies.index(body)}.{name}", 0.0) for name in MOTION]

    for number, wheel in enumerate(standing):
        rail = [frame.get(f"w{number}.rail_{name}", 0.0) for name in ("lateral", "vertical")]
        patches = wheel.patches(wheel.pose(motion, rail, frame.get("distance", 0.0)))
        loaded = max(patches, key=lambda patch: patch.normal, default=None)
        found += [math.nan] * len(PATCH) if loaded is None else _columns(loaded, frame, number)
    return found


def _columns(patch: _core.StaticPatch, frame: Mapping[str, float], number: int) -> list[float]:
    inwards = -patch.direction[1] if not patch.right else patch.direction[1]
    shape = (patch.peak_pressure, patch.length, patch.width, patch.a, patch.b, patch.normal)
    slip = (frame.get(f"w{number}.{name}_sliding", math.nan) for name in ("longitudinal", "lateral"))
    angle, creep = math.atan2(inwards, patch.direction[2]), frame.get(f"w{number}.creep", 0.0)
    return [*patch.point, *shape, angle, creep, 0.0, *slip]
