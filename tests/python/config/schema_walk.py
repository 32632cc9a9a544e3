"""Cases in which every table of the schema stands, and every place in them where a number may be written.

raw case -> [places] -> (dotted key, holder, key in the holder, range)
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

import numpy as np
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from rollerrig.config import Case, load_case
from rollerrig.config.load.case import build_case
from rollerrig.config.read import Document
from rollerrig.config.schema.units import Quantity
from rollerrig.config.write.toml import plain
from rollerrig.profiles.analytic import s1002_height

Raw = dict[str, Any]


@dataclass(frozen=True)
class WholeNumber:
    """Range of a key that takes whole numbers."""

    least: float
    most: float


@dataclass(frozen=True)
class Place:
    """Where a number may stand.

    Attributes:
        key: dotted, list items by index.
        path: keys and indices from the top of the raw case.
        field: the table's class and the name of the field.
        range: what may stand there; None: the schema sets no range.
    """

    key: str
    path: tuple[str | int, ...]
    field: tuple[type[BaseModel], str]
    range: Quantity | WholeNumber | None


def build(raw: Raw, file: str = "case.toml") -> Case:
    return build_case(Document(raw, file, Path()))


def with_value(raw: Raw, place: Place, value: object) -> Raw:
    changed = copy.deepcopy(raw)
    put(changed, place, value)
    return changed


def put(raw: Raw, place: Place, value: object) -> None:
    holder: Any = raw
    for part in place.path[:-1]:
        holder = holder[part]
    holder[place.path[-1]] = value


def numbers_in(annotation: Any, metadata: Any = ()) -> Iterator[Quantity | WholeNumber | None]:
    """Ranges of the numbers that stand directly at a field; None for a number without a range."""
    quantity = next((item for item in metadata if isinstance(item, Quantity)), None)
    if quantity is not None:
        yield quantity
        return
    if annotation is float:
        yield None
    elif annotation is int:
        ends = [next((getattr(i, e) for i in metadata if getattr(i, e, None) is not None), None) for e in ("ge", "le")]
        yield WholeNumber(*ends) if None not in ends else None  # type: ignore[arg-type]
    elif get_origin(annotation) is Annotated:
        inner, *more = get_args(annotation)
        flat = [item for m in more for item in (m.metadata if isinstance(m, FieldInfo) else (m,))]
        yield from numbers_in(inner, [*metadata, *flat])
    elif get_origin(annotation) in (Union, UnionType):
        for part in get_args(annotation):
            yield from numbers_in(part)


def inner(annotation: Any) -> tuple[Any, ...]:
    """Annotations of the items of a list or table."""
    if get_origin(annotation) is Annotated:
        return inner(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        return next((found for part in get_args(annotation) if (found := inner(part))), ())
    return get_args(annotation) if get_origin(annotation) in (tuple, dict) else ()


def places(table: BaseModel, path: tuple[str | int, ...] = ()) -> Iterator[Place]:
    """Every place for a number in a table and the tables below it."""
    for name, field in type(table).model_fields.items():
        annotation = Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation
        yield from _places(getattr(table, name), annotation, (*path, name), (type(table), name))


def _places(
    value: Any, annotation: Any, path: tuple[str | int, ...], field: tuple[type[BaseModel], str]
) -> Iterator[Place]:
    if isinstance(value, BaseModel):
        yield from places(value, path)
        return
    if not isinstance(value, str) or field[1] == "smoothing":
        for found in numbers_in(annotation):
            yield Place(".".join(map(str, path)), path, field, found)
    if isinstance(value, tuple):
        kinds = inner(annotation)
        kinds = kinds[:1] * len(value) if len(kinds) == 2 and kinds[1] is Ellipsis else kinds
        for i, (item, kind) in enumerate(zip(value, kinds, strict=True)):
            yield from _places(item, kind, (*path, i), field)
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from _places(item, (inner(annotation) or (None,))[-1], (*path, key), field)


def tables(root: type[BaseModel]) -> Iterator[type[BaseModel]]:
    """The models below one."""
    seen: dict[type[BaseModel], None] = {}

    def visit(annotation: Any) -> None:
        if isinstance(annotation, type) and issubclass(annotation, BaseModel) and annotation not in seen:
            seen[annotation] = None
            for field in annotation.model_fields.values():
                visit(field.annotation)
        for part in get_args(annotation):
            visit(part)

    visit(root)
    yield from seen


@cache
def whole_cases() -> dict[str, Raw]:
    """Valid cases by name; together they have every table."""
    brake = plain(load_case("adhesion_brake"))
    brake["traction"] = {"motor": {"envelope": [[0, 1e4], [100, 1e3]]}}
    brake["wheel_slip_control"] = {}
    brake["brake"]["air"] = {"kind": "reservoir", "reservoir_pressure": "8 bar", "pipe": {"length": "4 m"}}
    brake["brake"]["electrodynamic"] = {}
    brake["track_brake"] = {"demand": [[0.0, 0.0], [1.0, 1.0]], "friction": 0.1}
    brake["sanding"] = {}
    brake["sensors"] = {
        "roller_torque": {"noise": 1.0}, "vehicle": {"kind": "pulse_period"}, "rollers": {"kind": "pulse_frequency"}
    }  # fmt: skip
    brake["rig_control"]["assumed"] = {"wheel_radius": 0.46}
    brake["rig_control"]["load_transfer"] = [100.0, -100.0]
    brake["train"] = {
        "gradient": 0.01,
        "axles": {
            "positions": [0.0, 2.56, 19.0, 21.56],
            "under_test": [1, 2],
            "loads": [1e5, 1e5],
            "load_transfer": [0.0, 0.0],
        },
    }
    brake["adhesion"]["piece"] = [{"distance": 10.0, "rail": "low"}]
    brake["support"]["data"]["mounting"] = {
        "lateral": {"stiffness": 1e8},
        "yaw": {"stiffness": 1e8},
        "misalignment": [1e-3],
    }
    brake["support"]["data"]["losses"] = {"constant": 10.0}
    brake["support"]["data"]["restraint"] = {"height": 1.0, "stiffness": 1e7}
    brake["rig_control"]["drive_command"] = {"kind": "lead", "ahead": 1e-3}
    kalman = plain(load_case("adhesion_brake"))
    kalman["rig_control"] |= {
        "estimator": {"kind": "kalman", "force_change": 1e3, "torque_change": 1e3}, "feedback": {"kind": "sliding_mode"},
        "axle_torque": {"kind": "extrapolated"}, "drive_command": {"kind": "torque_loop"},
    }  # fmt: skip
    kalman["slide_protection"] = {"kind": "threshold_table"}
    kalman["rig_control"]["motor"] = {
        "envelope": [[0, 1e4], [100, 1e3]],
        "largest_torque": 2e4,
        "largest_power": 1e6,
        "largest_speed": 200.0,
    }
    kalman["brake"]["electrodynamic"] = {"kind": "table", "forces": [[1.0, 0.0], [3.0, 1e4]]}
    kalman["track_brake"] = {"kind": "eddy_current", "demand": [[0.0, 0.0], [1.0, 1.0]]}
    kalman["sanding"] = {"start": {"kind": "from_distance", "begin": 10.0}}
    derivative = plain(load_case("adhesion_brake"))
    derivative["rig_control"] |= {"estimator": {"kind": "filtered_derivative"}, "feedback": {"kind": "none"}}
    derivative["brake_unit"] = {}
    faults = ("none", "isolated", "dragging", "never_vents", "pads", "silent_sensor", "wheel_radius")
    axles = {"dragging": "wheelset_2"}  # an isolated brake does not drag
    derivative["fault"] = [{"axle": axles.get(kind, "wheelset_1"), "kind": kind} for kind in faults]
    derivative["sanding"] = {"start": {"kind": "from_time", "begin": 1.0}}
    track = plain(load_case("vehicle_track_irregular"))
    track["support"]["data"]["foundation"] = {
        "rail_mass": 60.0,
        "lateral": {"stiffness": 1e8},
        "roll": {"stiffness": 4e5},
        "sleeper": {"vertical": {"stiffness": 7e7}},
    }
    damped = {"damper": {"damping": 1e4, "series_stiffness": 1e6}}
    element = track["vehicle"]["data"]["element"][0]
    element["x"] = {"damping_table": [[-1.0, -1e4], [1.0, 1e4]], **damped}
    element["yaw"] = {"table": [[-0.1, -1e3], [0.1, 1e3]], "damping_table": [[-1.0, -10.0], [1.0, 10.0]], **damped}
    small = plain(load_case("contact_benchmark_rollers"))
    small["contact"]["friction"] = {"kind": "falling", "mu_0": 0.3, "A": 0.4, "B": 0.6}
    small["contact"]["creep"] = {"kind": "modified_fastsim"}
    small["contact"]["normal"] = {"kind": "hertz"}
    small["similitude"] = {"case": "x", "strategy": "mmu", "length": 5, "time": 1, "density": 1}
    small["vehicle"]["data"]["wheel"]["profile"] = {"kind": "cone", "conicity": 0.025}
    ramp = plain(load_case("bogie_rollers_ramp"))
    ramp["contact"]["creep"] = {"kind": "polach", "k_A": 1.0, "k_S": 0.4}
    ramp["support"]["data"]["spot"] = {"length": 0.1, "ramp": 0.05, "depth": 1e-4}
    ramp["disturbance"] = [{"body": "front_frame", "lateral": 1e-3}]
    torque = plain(load_case("bogie_rollers_traction"))
    torque["axle_torque"][0] = {"wheelset": "wheelset_1", "constant": 1e3}
    torque["motion"] = {"speed": "20 m/s", "drive": "torque", "torque_table": [[0.0, 0.0], [1.0, 100.0]]}
    arcs = plain(load_case("contact_benchmark_track"))
    arcs["vehicle"]["data"]["wheel"]["profile"] = {"kind": "arc", "radius": 2.0, "half_width": 20e-3}
    arcs["support"]["data"] |= {"profile": {"kind": "arc", "radius": 0.3, "half_width": 20e-3}, "gauge_depth": 0.2e-3}
    arcs["support"]["data"]["gauge"] = 1.492
    arcs["contact"]["normal"] = {"kind": "hertz"}
    arcs["contact"]["creep"] = {"kind": "coefficients", "f11": 7e6, "f22": 6e6}
    flat = copy.deepcopy(arcs)
    flat["vehicle"]["data"]["wheel"]["profile"] = {"kind": "cylinder"}
    curve = plain(load_case("vehicle_curve"))
    cases = {
        "brake": brake, "kalman": kalman, "derivative": derivative, "track": track, "curve": curve, "small": small,
        "ramp": ramp, "torque": torque, "arcs": arcs,
        "flat": flat, "files": _with_files(),
    }  # fmt: skip
    return {name: plain(build(raw)) for name, raw in cases.items()}  # every key with its value


def _with_files() -> Raw:
    """A case with a measured wheel and a measured track."""
    folder = Path(mkdtemp())
    s = [0.25 * i for i in range(-248, 241)]
    (folder / "wheel.txt").write_text("\n".join(f"{x} {z}" for x, z in zip(s, s1002_height(np.array(s)), strict=True)))
    rows = "\n".join(f"{0.5 * i}, {math.sin(0.1 * i):.6f}" for i in range(-200, 1800))
    (folder / "rails.csv").write_text(f"distance [m], vertical [mm]\n{rows}\n")
    raw = plain(load_case("vehicle_track_irregular"))
    raw["vehicle"]["data"]["wheel"]["profile"] = {"kind": "file", "path": str(folder / "wheel.txt"), "smoothing": 0.005}
    raw["support"]["data"]["irregularity"] = {"kind": "file", "path": str(folder / "rails.csv"), "start": 0.0}
    return raw
