"""What a run was: its case, model and support as its Dataset keeps them, and what to cite of it.

    run, case or nothing, catalog/sources.bib -> [cite] -> BibTeX, an entry per source
    Case -> [sources_of] -> what -> publication in words, for runs and reports
    AssembledModel -> [describe] -> RunInfo -> attribute `run_info` of the Dataset, JSON -> RunInfo.of(run)

Numbers carry their unit in the field's metadata, so that results of a scaled model can be mapped back to full scale.
"""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal
from unicodedata import normalize

import xarray as xr
from pydantic import TypeAdapter, ValidationError

from rollerrig import __version__
from rollerrig.assembly.model import AssembledModel
from rollerrig.cases import as_case
from rollerrig.config import Case, Rig, ScaledFrom, case_from_toml
from rollerrig.config.read import CATALOG_FOLDER
from rollerrig.config.schema.case import ACTUATORS
from rollerrig.config.schema.contact import FallingFriction
from rollerrig.profiles import flange_angle
from rollerrig.track import Segment

ALWAYS = ("rollerrig", "malvezzi2010")
"""Cited whatever was computed."""


def cite(what: xr.Dataset | Case | str | Path | None = None) -> str:
    """BibTeX of the program and the paper, and of the models and data in a run or a case.

    Args:
        what: results of `simulate`, a case, or its name or file; None: only the program and the paper.

    Raises:
        ConfigError: there is no such case.
        ValueError: the Dataset is no run.

    Example:
        >>> print(cite()[:20])
        @software{rollerrig,
    """
    case = _case_of(what)
    keys = dict.fromkeys((*ALWAYS, *(sources(case) if case else ())))
    return "\n\n".join(entries()[key] for key in keys) + "\n"


def _case_of(what: xr.Dataset | Case | str | Path | None) -> Case | None:
    if what is None:
        return None
    if not isinstance(what, xr.Dataset):
        return as_case(what)
    if "config_toml" not in what.attrs:
        raise ValueError("these results do not say which case they are of; needed: a run, as of simulate and load_run")
    return case_from_toml(what.attrs["config_toml"], allow_code=True)


def sources(case: Case) -> Iterator[str]:
    """Keys of the entries behind a case."""
    for keys in _keys(case).values():
        yield from keys
    if "Iwnicki" in case.vehicle.data.source:
        yield "iwnicki1999"


def _keys(case: Case) -> dict[str, tuple[str, ...]]:
    """Model of the contact in a case -> keys of its entries."""
    contact = case.contact
    laws = {"normal contact": contact.normal, "creep law": contact.creep}
    found: dict[str, tuple[str, ...]] = {
        f"{what}, {law.kind.replace('_', ' ')}": law.sources for what, law in laws.items()
    }
    falling = case.adhesion or contact.friction.kind == "falling"
    return found | ({"friction falling with sliding": FallingFriction.sources} if falling else {})


def sources_of(case: Case) -> dict[str, str]:
    """What -> publication: of the model, the laws of its contact, the vehicle and the support."""
    laws = {what: "; ".join(map(in_words, keys)) for what, keys in _keys(case).items()}
    data = {"vehicle": case.vehicle.data.source, "support": case.support.data.source}
    return {"model": in_words(ALWAYS[1]), **laws, **data}


def in_words(key: str) -> str:
    """An entry as a report shows it: 'O. Polach (2005), Creep forces in ...'."""
    fields = dict(re.findall(r"^  (\w+) = \{(.*)\},$", entries()[key], re.MULTILINE))
    people = [one.partition(", ") for one in (fields.get("author") or fields["editor"]).split(" and ")]
    names = (" ".join([*(f"{name[0]}." for name in first.split()), last]) for last, _, first in people)
    text = f"{', '.join(names)} ({fields['year']}), {fields['title']}".replace("\\&", "&")
    text = re.sub(r'\{\\"(\w)\}', lambda found: normalize("NFC", f"{found[1]}\u0308"), text)
    return text.replace("{", "").replace("}", "")


@cache
def entries() -> dict[str, str]:
    """BibTeX of every source by its key."""
    text = (CATALOG_FOLDER / "sources.bib").read_text(encoding="utf-8").replace("{VERSION}", f"{{{__version__}}}")
    return {entry.partition("{")[2].partition(",")[0]: entry.strip() for entry in text.split("\n\n")}


ATTRIBUTE = "run_info"


class ResultsError(ValueError):
    """Results that this version cannot read, or that are damaged."""


def _in(unit: str) -> Any:
    return field(metadata={"unit": unit})


@dataclass(frozen=True)
class LowerBody:
    """A body that carries another one, and the height at which its springs act on that [m]."""

    body: str
    height: float = _in("m")


@dataclass(frozen=True)
class TrackSegment:
    """A piece of the line, as it was laid."""

    kind: Literal["straight", "transition", "curve"]  # what it is
    start: float = _in("m")  # distance at which it begins [m]
    end: float = _in("m")  # and at which it ends [m]
    curvature: float = _in("1/m")  # of a straight or a curve, positive to the left; 0 for a transition [1/m]


@dataclass(frozen=True)
class BodyInfo:
    """A body of the run."""

    name: str  # as in the coordinate `body`
    role: Literal["wheelset", "vehicle body", "roller", "rail"]  # what it is
    fixed: bool  # whether it is kept at its design position
    # design position of its centre of mass from the origin of the run [m]
    position: tuple[float, float, float] = _in("m")
    lower_bodies: tuple[LowerBody, ...] = ()  # lower bodies joined to it by elements that carry load, foremost first
    # of a wheelset, static load of each of its wheels [N]
    wheel_load: float | None = field(default=None, metadata={"unit": "N"})


@dataclass(frozen=True)
class RunInfo:
    """Metadata of a run.

    Attributes:
        case: name of the case.
        part: of the vehicle that was run.
        support: kind of the support.
        bodies, wheels: in the order of the coordinates.
        actuators: tables of the case that act on the vehicle.
        motors_reproduce_brakes: whether the traction motors give the torque of the brakes.
        scaled_from: of a scaled model, the full-scale case and the factors; None at full scale.
        speed: at the start [m/s].
        gravity: [m/s^2].
        wheel_radius: nominal [m].
        roller_radius: at the crown [m]; None on track.
        friction: coefficient of friction where flanges touch [-].
        flange_angle: steepest slope of the wheel profile towards the flange [rad].
        segments: of the line, in the order of the run; empty on a straight track without segments and on a rig.

    Example:
        >>> import rollerrig as rr
        >>> case = rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.02 s"})
        >>> rr.RunInfo.of(rr.simulate(case)).wheel_radius
        0.46
    """

    case: str
    part: str
    support: Literal["rig", "track"]
    bodies: tuple[BodyInfo, ...]
    wheels: tuple[str, ...]
    actuators: tuple[str, ...]
    motors_reproduce_brakes: bool
    scaled_from: ScaledFrom | None
    speed: float = _in("m/s")
    gravity: float = _in("m/s^2")
    wheel_radius: float = _in("m")
    roller_radius: float | None = _in("m")
    friction: float = _in("1")
    flange_angle: float = _in("rad")
    segments: tuple[TrackSegment, ...] = ()

    @classmethod
    def of(cls, results: xr.Dataset) -> "RunInfo":
        """The metadata of a run, or of what was computed from it.

        Raises:
            ResultsError: there is none, or that of another version.
        """
        text = results.attrs.get(ATTRIBUTE)
        if text is None:
            raise ResultsError("these results do not say which case they came from: no attribute run_info")
        try:
            return _adapter().validate_json(text)
        except ValidationError:
            raise ResultsError("results of another version of rollerrig: run the case again") from None

    def to_json(self) -> str:
        """As the attribute holds it."""
        return _adapter().dump_json(self).decode()

    def mapped(self, factor: Callable[[str], float]) -> "RunInfo":
        """This record with every number times the factor of its unit."""
        return _mapped(self, factor)  # type: ignore[no-any-return]

    def body(self, name: str) -> BodyInfo:
        """The body of that name.

        Raises:
            KeyError: no such body.
        """
        return {body.name: body for body in self.bodies}[name]

    def on_wheelsets(self, body: BodyInfo) -> bool:
        """Whether wheelsets carry a body, as they do a bogie's frame."""
        return any(self.body(below.body).role == "wheelset" for below in body.lower_bodies)

    @property
    def wheelsets(self) -> tuple[BodyInfo, ...]:
        """In the order of the vehicle."""
        return tuple(body for body in self.bodies if body.role == "wheelset")

    @property
    def sprung(self) -> tuple[BodyInfo, ...]:
        """Free bodies above the wheelsets."""
        return tuple(body for body in self.bodies if body.role == "vehicle body" and not body.fixed)

    @property
    def moving(self) -> list[str]:
        """Names of the vehicle's bodies that can move."""
        return [body.name for body in self.bodies if body.role in ("wheelset", "vehicle body") and not body.fixed]


def describe(model: AssembledModel) -> RunInfo:
    """Metadata of the runs of a model."""
    case, support = model.case, model.case.support.data
    return RunInfo(
        case=case.name,
        part=case.vehicle.cut,
        support=support.kind,
        bodies=tuple(_body(model, name) for name in model.bodies),
        wheels=tuple(wheel.name for wheel in model.wheels),
        actuators=tuple(key for key in ACTUATORS if getattr(case, key) is not None),
        motors_reproduce_brakes=case.brake is not None and case.brake.by_traction_motors,
        scaled_from=case.similitude,
        speed=case.motion.speed,
        gravity=case.gravity,
        wheel_radius=case.vehicle.data.wheel.radius,
        roller_radius=support.roller_radius if isinstance(support, Rig) else None,
        friction=case.contact.flange_friction,
        flange_angle=flange_angle(model.wheel_profile),
        segments=() if model.line is None else tuple(_segment(segment) for segment in model.line.segments),
    )


def _segment(segment: Segment) -> TrackSegment:
    curvature = 0.0 if segment.kind == "transition" else segment.curvature[0]
    return TrackSegment(segment.kind, segment.start, segment.end, curvature)


def _body(model: AssembledModel, name: str) -> BodyInfo:
    role: Literal["wheelset", "vehicle body", "roller", "rail"] = "vehicle body"
    if name in model.rollers:
        role = "roller"
    elif name in model.rails:
        role = "rail"
    elif name in model.wheelsets:
        role = "wheelset"
    load = model.axle_loads.get(name)
    return BodyInfo(
        name=name,
        role=role,
        fixed=name in model.fixed,
        position=model.positions[name],
        lower_bodies=_lower_bodies(model, name) if role == "vehicle body" else (),
        wheel_load=None if load is None else 0.5 * load,
    )


def _lower_bodies(model: AssembledModel, name: str) -> tuple[LowerBody, ...]:
    case: Case = model.case
    heights: dict[str, float] = {}
    for element in case.vehicle.data.elements_in(case.vehicle.part):
        if element.carries_load and name in element.between:
            other = element.between[1 - element.between.index(name)]
            if model.positions[other][2] < model.positions[name][2]:
                heights[other] = element.end_b[2]
    foremost_first = sorted(heights, key=lambda other: -model.positions[other][0])
    return tuple(LowerBody(other, heights[other]) for other in foremost_first)


@cache
def _adapter() -> TypeAdapter[RunInfo]:
    return TypeAdapter(RunInfo)


def _mapped(value: Any, factor: Callable[[str], float]) -> Any:
    if isinstance(value, tuple):
        return tuple(_mapped(item, factor) for item in value)
    if not is_dataclass(value) or isinstance(value, type):
        return value
    changes: dict[str, Any] = {}
    for one in fields(value):
        old, unit = getattr(value, one.name), one.metadata.get("unit")
        if unit is None or old is None:
            changes[one.name] = _mapped(old, factor)
        elif isinstance(old, tuple):
            changes[one.name] = tuple(factor(unit) * number for number in old)
        else:
            changes[one.name] = factor(unit) * old
    return replace(value, **changes)
