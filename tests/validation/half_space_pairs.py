"""Exact normal contact at given heights in random poses of five pairs of wheel and rail, new and worn, on rail and rollers.

    data/half_space_pairs.csv -> [read] -> pose, what the half-space says; pose -> [errors] -> how far ours is from it

Left wheel; mm, N, N/mm2, rad.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, fields
from functools import cache

import numpy as np
from numpy.typing import NDArray

from catalogued import profile_table
from rollerrig import _core
from rollerrig.profiles import ProfileTable, tabulate
from validation.free_patches import curved, patches
from validation.half_space import Pose, Surfaces
from validation.reference import mm, rail_origin, rows, static_contact_of

Array = NDArray[np.float64]

FILE = "half_space_pairs.csv"
CELLS = 96
CATEGORIES = ("tread", "flange root", "flange", "two contacts", "transition")
#: From this spread a half-space in a plane and one on the rail's curved surface are further apart than 1 % in force and 3 % in
#: pressure; an error counts from the nearer of the two.
CONFORMAL = 0.1


def hollow_wheel() -> ProfileTable:
    """S1002 whose tread is worn hollow: 3 mm from its lowest point to the false flange 41 mm outside the tape circle."""
    new = profile_table("s1002", "wheel")
    return tabulate(
        lambda s: new.evaluate(s) - 4.4 * mm * np.exp(-(((s - 2 * mm) / (30 * mm)) ** 4)),
        *new.domain,
        name="hollow S1002",
        kind="wheel",
        source="S1002 less 4.4 mm exp(-((s - 2 mm) / 30 mm)^4)",
    )


def worn_rail() -> ProfileTable:
    """60E1 1:40 worn by 1 mm on the crown and by 1.5 mm, measured vertically, in the gauge corner."""
    new = profile_table("en_60e1_1_40", "rail")

    def height(y: Array) -> Array:
        crown = 1.0 * mm * np.exp(-((y / (22 * mm)) ** 4))
        corner = 1.5 * mm * np.exp(-(((y + 28 * mm) / (8 * mm)) ** 2))
        return new.evaluate(y) - crown - corner

    top = height(np.linspace(*new.domain, 20001)).max()
    source = "60E1 1:40 less 1 mm exp(-(y / 22 mm)^4) and 1.5 mm exp(-((y + 28 mm) / 8 mm)^2)"
    return tabulate(lambda y: height(y) - top, *new.domain, name="worn 60E1", kind="rail", source=source)


#: Wheel on rail. A worn rail stands where the new one stood.
PAIRS = (
    "S1002 on UIC60 1:40",
    "S1002 on 60E1 1:20",
    "S1002 on 60E1 1:40",
    "hollow S1002 on 60E1 1:40",
    "S1002 on worn 60E1 1:40",
)


@cache
def surfaces_of(pair: str) -> Surfaces:
    wheel, rail = pair.split(" on ")
    table = profile_table("s1002", "wheel") if wheel == "S1002" else hollow_wheel()
    names = {
        "UIC60 1:40": "uic60_benchmark_1_40",
        "60E1 1:20": "en_60e1_1_20",
        "60E1 1:40": "en_60e1_1_40",
        "worn 60E1 1:40": "en_60e1_1_40",
    }
    new = profile_table(names[rail], "rail")
    return Surfaces(table, worn_rail() if "worn" in rail else new, rail_origin(new))


@dataclass(frozen=True)
class PairPose:
    """`height` of the wheelset's centre over that of a wheel of 460 mm on the crown."""

    pair: str
    category: str
    roller_radius: float  # 0: rail
    x: float
    y: float
    height: float
    yaw: float
    roll: float

    @property
    def pose(self) -> Pose:
        return Pose(self.y, self.height, self.yaw, self.roll, self.roller_radius or None, self.x)


@dataclass(frozen=True)
class ExactWheel:
    """All patches of the wheel: sum of their forces, largest pressure and interpenetration, whole area; `spread`: how far the
    surfaces turn within a patch; `curved`: the same on the rail's curved surface. Then each patch's force and its centre on the
    rail."""

    force: float
    pressure: float
    area: float
    approach: float
    spread: float
    curved_force: float
    curved_pressure: float
    forces: tuple[float, ...]
    centres_x: tuple[float, ...]
    centres_y: tuple[float, ...]
    centres_z: tuple[float, ...]
    normals_x: tuple[float, ...]
    normals_y: tuple[float, ...]
    normals_z: tuple[float, ...]

    @property
    def centres(self) -> Array:
        return np.array([self.centres_x, self.centres_y, self.centres_z]).T

    @property
    def normals(self) -> Array:
        return np.array([self.normals_x, self.normals_y, self.normals_z]).T


def exact(at: PairPose, cells: int = CELLS) -> ExactWheel:
    """By the half-space."""
    surfaces, pose = surfaces_of(at.pair), at.pose
    pressed = patches(surfaces, pose, cells)
    solutions = [patch.solution() for patch in pressed]
    centres = np.array([surfaces.on_rail(pose, patch.centre, patch.grid.normal) for patch in pressed])
    normals = np.array([patch.grid.normal for patch in pressed])
    return ExactWheel(
        sum(one.force for one in solutions),
        max(one.pressure for one in solutions),
        sum(one.area for one in solutions),
        max(one.approach for one in solutions),
        max(patch.spread for patch in pressed),
        *curved(surfaces, pose, pressed, cells),
        tuple(one.force for one in solutions),
        *(tuple(column) for column in centres.T),
        *(tuple(column) for column in normals.T),
    )


def columns() -> list[str]:
    return [field.name for kind in (PairPose, ExactWheel) for field in fields(kind)]


def row_of(at: PairPose, solution: ExactWheel) -> list[str]:
    def text(value: float | str | tuple[float, ...]) -> str:
        if isinstance(value, tuple):
            return ";".join(f"{number:.7g}" for number in value)
        return value if isinstance(value, str) else f"{value:.9g}"

    return [text(value) for value in (*astuple(at), *astuple(solution))]


def read() -> list[tuple[PairPose, ExactWheel]]:
    """All poses of the file with the half-space's answers."""
    lists = {field.name for field in fields(ExactWheel) if "tuple" in str(field.type)}

    def value(row: dict, name: str) -> object:
        return tuple(float(number) for number in str(row[name]).split(";")) if name in lists else row[name]

    return [
        (
            PairPose(*(row[field.name] for field in fields(PairPose))),
            ExactWheel(*(value(row, field.name) for field in fields(ExactWheel))),
        )
        for row in rows(FILE)
    ]


@cache
def contact_of(pair: str, roller_radius: float, normal: str) -> _core.StaticWheelsetContact:
    surfaces = surfaces_of(pair)
    return static_contact_of(surfaces.wheel, surfaces.rail, roller_radius * mm or None, surfaces.origin * mm, normal)


def our_patches(at: PairPose, normal: str) -> list[_core.StaticPatch]:
    """By one of the program's laws of normal contact."""
    contact = contact_of(at.pair, at.roller_radius, normal)
    place = (at.x * mm, at.y * mm, at.height * mm, at.yaw, at.roll, False)
    return contact.minima(*place, 0.0) if normal == "hertz" else contact.patches(*place)


def centre_error(ours: list[_core.StaticPatch], theirs: ExactWheel) -> float:
    """Largest distance, along the surface, of an exact patch's centre from that of our loads that are nearest to it in place
    (10 mm) and direction (0.1 rad); of patches with a twentieth of the load or more."""
    points = np.array([patch.point for patch in ours]) / mm
    loads = np.array([patch.normal for patch in ours])
    directions = np.array([patch.direction for patch in ours])
    apart = np.linalg.norm(points[:, None] - theirs.centres[None], axis=-1) / 10.0
    turned = np.linalg.norm(directions[:, None] - theirs.normals[None], axis=-1) / 0.1
    nearest = (apart + turned).argmin(axis=1)
    worst = 0.0
    for i, (force, centre, normal) in enumerate(zip(theirs.forces, theirs.centres, theirs.normals, strict=True)):
        if force < 0.05 * theirs.force:
            continue
        mine = nearest == i
        if not loads[mine].sum():
            return np.inf
        off = loads[mine] @ points[mine] / loads[mine].sum() - centre
        worst = max(worst, float(np.linalg.norm(np.cross(off, normal))))
    return worst


ERRORS = ("force", "pressure", "centre", "area", "approach")


def errors(at: PairPose, theirs: ExactWheel, normal: str) -> list[float]:
    """Of the program at the row's height; centre in mm, the others as ratios."""
    ours = our_patches(at, normal)
    if not ours:
        return [1.0, 1.0, np.inf, 1.0, 1.0]
    curved = theirs.spread > CONFORMAL
    force = theirs.force, theirs.curved_force if curved else theirs.force
    pressure = theirs.pressure, theirs.curved_pressure if curved else theirs.pressure
    return [
        outside(sum(patch.normal for patch in ours), force),
        outside(max(patch.peak_pressure for patch in ours) / 1e6, pressure),
        centre_error(ours, theirs),
        abs(sum(patch.weight * patch.area for patch in ours) / mm**2 / theirs.area - 1),
        abs(max(patch.approach for patch in ours) / mm / theirs.approach - 1),
    ]


def outside(ours: float, theirs: tuple[float, float]) -> float:
    """How far a value is outside the range of two others, as a ratio."""
    return max(ours / max(theirs) - 1, 1 - ours / min(theirs), 0.0)
