"""What a railway engineer calls a mode, read off its shape.

    energies and shapes over speed, who carries whom -> [mode names] -> 'car body lower sway', 'bogie pitch, in phase', 'hunting'

The words: bounce, pitch, roll, yaw of car body and bogies; the **lower sway** swings about an axis below the car body's centre
of mass, the **upper sway** about one above it; **hunting** is a wave-like motion of the wheelsets. Of the car body, of bogies
and of wheelsets, that part names a mode which has the most of its kinetic energy.
"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rollerrig.common.arrays import Array, Complex, Mask
from rollerrig.config import Case

HUNTING_SHARE = 0.2
"""Least share of the kinetic energy that a hunting mode has in the lateral motion of wheelsets, on average over speed."""

HUNTING_SPEEDS = 0.9  # a mode that hunts at this part of the speeds is called so, whoever has the kinetic energy
ONE_BOGIE_SHARE = 0.8  # a bogie with more than this part of all bogies' energy names the mode alone: 'front bogie'
WORDS = {"vertical": "bounce", "longitudinal": "longitudinal"}  # direction -> word, where the two differ


@dataclass(frozen=True)
class Roles:
    """Which body is what, by who carries whom; front to rear."""

    car_bodies: tuple[str, ...]  # bodies that no wheelset's suspension touches, and frames with nothing above them
    frames: tuple[str, ...]  # bodies that wheelsets carry and that carry something themselves
    wheelsets: tuple[str, ...]  # all wheelsets
    wheelsets_of: dict[str, tuple[str, ...]]

    def kind(self, body: str) -> str:
        """'car body', 'bogie', 'wheelsets', or the body's own name with spaces."""
        if body in self.wheelsets:
            return "wheelsets"
        if body in self.frames:
            return "bogie"
        if body in self.car_bodies and len(self.car_bodies) == 1:
            return "car body"
        return body.replace("_", " ")


def roles(case: Case) -> Roles:
    """Roles of the moving bodies of a case."""
    vehicle = case.vehicle.data
    kinds = {body.name: body.kind for body in vehicle.body}
    neighbours: dict[str, set[str]] = {name: set() for name in kinds}
    for a, b in (element.between for element in vehicle.element):
        neighbours[a].add(b)
        neighbours[b].add(a)
    moving = sorted(case.vehicle.bodies, key=lambda body: -body.position[0])
    wheelsets = tuple(body.name for body in moving if body.kind == "wheelset")

    def is_frame(name: str) -> bool:
        others = [kinds.get(n) for n in neighbours[name]]
        return "wheelset" in others and any(kind != "wheelset" for kind in others)

    frames = tuple(body.name for body in moving if body.kind != "wheelset" and is_frame(body.name))
    car_bodies = tuple(body.name for body in moving if body.kind != "wheelset" and body.name not in frames)
    wheelsets_below = {frame: tuple(w for w in wheelsets if w in neighbours[frame]) for frame in frames}
    return Roles(car_bodies, frames, wheelsets, wheelsets_below)


@dataclass(frozen=True)
class Shapes:
    """Modes over speed, as names need them."""

    keys: Sequence[tuple[str, str]]  # (body, direction) of each coordinate
    rates: Array  # growth rates [1/s], shape (speeds, modes)
    shares: Array  # of the kinetic energy, shape (speeds, coordinates, modes)
    parts: Complex  # displacements, shape (speeds, coordinates, modes)
    hunting: Mask  # where a mode hunts, shape (speeds, modes); a mode that does so nowhere is not called hunting


def mode_names(shapes: Shapes, who: Roles) -> list[str]:
    """A name for each mode, all different, from its shape on average over speed."""
    mean = shapes.shares.mean(axis=0)
    names = [_name(shapes, mean, who, m) for m in range(mean.shape[1])]
    for mode, name in _hunting(shapes, mean, who).items():
        names[mode] = name
    return unique_names(names)


def shape_name(keys: Sequence[tuple[str, str]], share: Array, parts: Complex, who: Roles) -> str:
    """Name of one mode at one speed.

    Args:
        keys: (body, direction) of each coordinate.
        share: of the kinetic energy, shape (coordinates,).
        parts: displacements, shape (coordinates,).
        who: roles of the bodies.
    """
    nowhere = np.zeros((1, 1), dtype=np.bool_)
    one = Shapes(keys, np.zeros((1, 1)), share[None, :, None], parts[None, :, None], nowhere)
    return mode_names(one, who)[0]


def wheelset_lateral_share(keys: Sequence[tuple[str, str]], shares: Array) -> Array:
    """How much of the modes' kinetic energy, shape (..., coordinates, modes), is lateral motion of wheelsets.

    Large only where they run in waves.
    """
    rows = [i for i, (body, way) in enumerate(keys) if body.startswith("wheelset") and way == "lateral"]
    return np.asarray(shares[..., rows, :].sum(axis=-2))


def unique_names(names: list[str]) -> list[str]:
    """Names made different: 'frame yaw', 'frame yaw 2'."""
    counts = [names[: k + 1].count(name) for k, name in enumerate(names)]
    return [name if count == 1 else f"{name} {count}" for name, count in zip(names, counts, strict=True)]


def _name(shapes: Shapes, mean: Array, who: Roles, mode: int) -> str:
    kinds, ways = defaultdict[str, float](float), defaultdict[str, float](float)
    for (body, _), share in zip(shapes.keys, mean[:, mode], strict=True):
        kinds[who.kind(body)] += share
    kind = max(kinds, key=lambda name: kinds[name])
    if kind == "wheelsets" and _as_one(shapes, mean, who, mode):
        kind = "bogie"
    for (body, way), share in zip(shapes.keys, mean[:, mode], strict=True):
        if who.kind(body) == kind:
            ways[way] += share
    way = max(ways, key=lambda name: ways[name])
    if kind == "car body" and way in ("lateral", "roll"):
        return f"car body {_sway(shapes, who.car_bodies[0], mode)}"
    word = WORDS.get(way, way)
    if kind == "bogie":
        return _of_bogies(shapes, mean, who, mode, way, word)
    if kind == "wheelsets" and len(who.wheelsets) == 1:
        kind = "wheelset"
    return f"{kind} {word}"


def _as_one(shapes: Shapes, mean: Array, who: Roles, mode: int) -> bool:
    """Whether the frames go with their wheelsets along the track: the bogie moves as a whole, though wheelsets are heavier."""
    rows = [i for i, (body, way) in enumerate(shapes.keys) if way == "longitudinal" and who.kind(body) != "car body"]
    frames = [i for i in rows if shapes.keys[i][0] in who.frames]
    if mean[rows, mode].sum() < 0.5 or not frames:
        return False
    for pair in ((frame, wheelset) for frame in who.frames for wheelset in who.wheelsets_of[frame]):
        f, w = (_row(shapes, body, "longitudinal") for body in pair)
        if f is None or w is None or _phase(shapes.parts[:, f, mode], shapes.parts[:, w, mode]) != "in phase":
            return False
    return True


def _sway(shapes: Shapes, body: str, mode: int) -> str:
    """Lower or upper: whether the axis about which the body swings is below or above its centre of mass."""
    y, roll = (_row(shapes, body, way) for way in ("lateral", "roll"))
    if y is None or roll is None:
        return "sway" if y is not None else "roll"
    # a point at height h above the centre moves y - h roll: it stands still where h = y / roll
    height = np.sum((shapes.parts[:, y, mode] * shapes.parts[:, roll, mode].conj()).real)
    return "lower sway" if height < 0 else "upper sway"


def _row(shapes: Shapes, body: str, way: str) -> int | None:
    return next((i for i, key in enumerate(shapes.keys) if key == (body, way)), None)


def _of_bogies(shapes: Shapes, mean: Array, who: Roles, mode: int, way: str, word: str) -> str:
    if len(who.frames) < 2:
        return f"bogie {word}"
    rows = [_row(shapes, frame, way) for frame in who.frames]
    if alone := _alone([0.0 if row is None else float(mean[row, mode]) for row in rows]):
        return f"{alone} bogie {word}"
    if len(rows) > 2 or rows[0] is None or rows[1] is None:
        return f"bogies {word}"
    return f"bogie {word}, {_phase(shapes.parts[:, rows[0], mode], shapes.parts[:, rows[1], mode])}"


def _alone(shares: Sequence[float]) -> str:
    """'front' or 'rear' where one of several bogies has nearly all the energy, else ''."""
    ends = {"front": shares[0], "rear": shares[-1]}
    return next((name for name, share in ends.items() if share > ONE_BOGIE_SHARE * sum(shares)), "")


def _phase(front: Complex, rear: Complex) -> str:
    return "in phase" if np.sum((front * rear.conj()).real) >= 0 else "out of phase"


def _hunting(shapes: Shapes, mean: Array, who: Roles) -> dict[int, str]:
    """Mode -> name for the least damped modes in which wheelsets weave, one for each bogie (or one at all)."""
    lateral = wheelset_lateral_share(shapes.keys, mean) >= HUNTING_SHARE
    # in slow hunting a heavy car body that sways along has most of the energy: there the motion itself decides
    weave = np.flatnonzero((lateral & shapes.hunting.any(axis=0)) | (shapes.hunting.mean(axis=0) >= HUNTING_SPEEDS))
    order = sorted(weave, key=lambda m: -float(shapes.rates[:, m].mean()))
    if len(who.frames) != 2:
        return {int(m): "hunting" for m in order[:1]}
    return {int(m): f"hunting, {_which_bogie(shapes, mean, who, int(m))}" for m in order[:2]}


def _which_bogie(shapes: Shapes, mean: Array, who: Roles, mode: int) -> str:
    lateral = {i: body for i, (body, way) in enumerate(shapes.keys) if way == "lateral"}
    rows = [[i for i, b in lateral.items() if b in (frame, *who.wheelsets_of[frame])] for frame in who.frames]
    if alone := _alone([float(mean[r, mode].sum()) for r in rows]):
        return f"{alone} bogie"
    front, rear = (shapes.parts[:, r, mode].sum(axis=1) for r in rows)
    return f"bogies {_phase(front, rear)}"
