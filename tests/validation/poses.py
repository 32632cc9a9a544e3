"""The poses in which wheel and rail are compared with the exact half-space: those of CONTACT's tables, and others with yaw,
longitudinal offset, rollers and load. Left wheel, S1002 on UIC60 1:40; mm, N, N/mm2, rad.

    data/half_space_poses.csv -> [read] -> pose, what the half-space says; pose -> [pressed] -> what ours says
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cache
from itertools import cycle, product

from rollerrig import _core
from validation.comparison import FILES
from validation.half_space import Solution
from validation.pressed_wheel import PressedWheel, press
from validation.reference import benchmark_contact, mm, rows

FILE = "half_space_poses.csv"


@dataclass(frozen=True)
class LoadedPose:
    """A left wheel pressed down; `group` says what the pose is from."""

    group: str
    roller_radius: float  # 0: rail
    x: float
    y: float
    yaw: float
    roll: float
    force: float


@dataclass(frozen=True)
class ExactPose:
    """A row of the file."""

    pose: LoadedPose
    height: float
    solution: Solution


SOLUTION = ("pressure", "area", "approach", "length", "width")


def all_poses() -> list[LoadedPose]:
    """CONTACT's, then yaw on rail and rollers with a longitudinal offset on these, then wheel loads up to 100 kN."""
    list_of_poses = []
    for file in FILES:
        for row in rows(file):
            side = 1 if row["side"] == "right" else -1  # the right wheel in its mirror image
            place = [side * row["y_ws"], side * row["yaw"], -side * row["roll"] + 0.0]
            radius = 500.0 if "roller" in file else 0.0
            list_of_poses.append(LoadedPose(file.split(".")[0], radius, 0.0, *place, row["Fn"]))
    offsets = cycle((0.0, 10.0, 20.0))
    shifts = (-6.0, -3.0, -1.0, 0.0, 0.5, 1.0, 2.0, 4.0, 5.0, 5.5, 6.0, 7.0)
    for radius, yaw, y in product((0.0, 1000.0, 500.0), (0.01, 0.03, 0.05), shifts):
        x = next(offsets) if radius else 0.0
        list_of_poses.append(LoadedPose("yawed", radius, x, y, yaw, 0.0, 1e4))
    shifts = (-5.0, -2.0, -0.5, 0.0, 0.25, 0.5, 1.0, 1.5, 3.0, 5.0)
    for radius, force, y in product((0.0, 500.0), (5e4, 1e5), shifts):
        list_of_poses.append(LoadedPose("loaded", radius, 0.0, y, 0.003, 0.0, force))
    return list_of_poses


@cache
def contact_on(roller_radius: float, normal: str) -> _core.StaticWheelsetContact:
    return benchmark_contact(roller_radius * mm or None, normal)


def pressed(pose: LoadedPose, normal: str = "strips") -> PressedWheel:
    """The same by one of our laws of normal contact."""
    place = (pose.x * mm, pose.y * mm)
    return press(contact_on(pose.roller_radius, normal), place, pose.yaw, pose.roll, pose.force, normal=normal)


def columns() -> list[str]:
    return [*(field.name for field in fields(LoadedPose)), "height", *SOLUTION, "centre_x", "centre_y", "centre_z"]


def read() -> list[ExactPose]:
    """All poses of the file with the half-space's answers."""
    list_of_poses = []
    for row in rows(FILE):
        pose = LoadedPose(*(row[field.name] for field in fields(LoadedPose)))
        pressure, area, approach, length, width = (row[name] for name in SOLUTION)
        centre = (row["centre_x"], row["centre_y"], row["centre_z"])
        solution = Solution(pose.force, pressure, area, approach, length, width, centre)
        list_of_poses.append(ExactPose(pose, row["height"], solution))
    return list_of_poses
