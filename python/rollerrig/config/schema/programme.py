"""A test programme for wheel slide protection: the stops, and the limits that they are assessed by."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, ValidationInfo, field_validator

from rollerrig.config.schema.adhesion import ALLOWED, Adhesion, AnyCondition, Piece
from rollerrig.config.schema.base import Mistakes, Named, Sourced, Table, needed, optional
from rollerrig.config.schema.brakes import Pressure
from rollerrig.config.schema.units import Quantity, RunningSpeed

Length = Annotated[float, Quantity("m", 1e-3, 1e5)]
Count = Annotated[int, Field(ge=4, le=100)]


class BrakedRun(Named):
    """What every stop of a programme has."""

    speed: RunningSpeed = needed("speed at the demand for braking")
    pressure: Pressure | None = optional(
        None, "demanded cylinder pressure over the ambient; absent: the largest that the case demands"
    )
    duration: Annotated[float, Quantity("s", 1.0, 1e4)] = optional(
        120.0, "longest; where the train has not stopped by then nothing is decided"
    )
    rail: AnyCondition = needed(f"condition of the rail at the start: {ALLOWED}")

    stops: ClassVar[bool] = True
    """Whether the train is to come to a stop."""

    @property
    def falls(self) -> float:
        """Gradient of the line, positive uphill [-]."""
        return getattr(self, "gradient", 0.0)

    def pieces(self) -> tuple[Piece, ...]:
        """Where the rail changes."""
        return ()


class UniformStop(BrakedRun):
    """The same rail all the way."""

    kind: Literal["uniform"] = needed("the same rail all the way")


class SteppedStop(BrakedRun):
    """A rail whose condition changes along the way, under all axles."""

    kind: Literal["steps"] = needed("the rail changes along the way")
    piece: tuple[Piece, ...] = needed("changes of the rail, as in [adhesion]", min_length=1, max_length=1000)
    blend: Annotated[float, Quantity("m", 0.0, 1e3)] = optional(0.0, "length over which conditions pass into the next")

    def pieces(self) -> tuple[Piece, ...]:
        """Where the rail changes."""
        return self.piece

    def _mistakes(self) -> Mistakes:
        if any(piece.distance is None for piece in self.piece):
            yield "piece", "allowed: each piece with `distance`"
        Adhesion(rail=self.rail, piece=self.piece, blend=self.blend)


class PatchStop(BrakedRun):
    """Short patches of another rail, each shorter than the axles' spacing: one axle at a time is on one."""

    kind: Literal["patches"] = needed("short patches, under one axle at a time")
    patch: AnyCondition = needed("condition of the patches")
    length: Length = needed("length of a patch; less than the least spacing of the axles")
    spacing: Length = needed("distance from the beginning of a patch to that of the next one")
    first: Length = optional(20.0, "distance of the first one")
    count: Annotated[int, Field(ge=1, le=400)] = optional(10, "number of patches")

    def pieces(self) -> tuple[Piece, ...]:
        """Where the rail changes: in and out of each patch."""
        begins = [self.first + k * self.spacing for k in range(self.count)]
        return tuple(
            piece
            for begin in begins
            for piece in (Piece(distance=begin, rail=self.patch), Piece(distance=begin + self.length, rail=self.rail))
        )

    def _mistakes(self) -> Mistakes:
        if not self.spacing > self.length:
            yield "spacing", f"allowed: more than the length of a patch, {self.length:g} m"


class DragBraking(BrakedRun):
    """Braking for a time on a falling line, which keeps the train running."""

    stops: ClassVar[bool] = False
    kind: Literal["drag"] = needed("braking for a time on a falling line; the train need not stop")
    gradient: Annotated[float, Quantity("1", -0.1, 0.0)] = needed("gradient of the line, negative: it falls")


AnyStop = Annotated[UniformStop | SteppedStop | PatchStop | DragBraking, Discriminator("kind")]


@dataclass(frozen=True)
class Criterion:
    """What a limit may be set for."""

    measure: str  # of a test, of whose number it is a limit
    quantity: Quantity  # unit and range of the limit
    factor: float = 1.0  # from the measure to this unit
    least: bool = False  # whether it is the least that is allowed, else the most
    every: bool = False  # whether each test must keep it, else the mean of all
    of_a_stop: bool = False  # whether it is defined only for a train that comes to a stop


CRITERIA: Mapping[str, Criterion] = {
    "k_wet": Criterion("k_wet", Quantity("1", 0.0, 1.0), least=True, of_a_stop=True),
    "increase_over_dry": Criterion("increase_over_dry", Quantity("1", 0.0, 100.0), of_a_stop=True),
    "distance": Criterion("distance_m", Quantity("m", 0.0, 1e5), of_a_stop=True),
    "mean_deceleration": Criterion("mean_deceleration_mps2", Quantity("m/s^2", 0.0, 10.0), least=True, of_a_stop=True),
    "adhesion_utilisation": Criterion("adhesion_utilisation", Quantity("1", 0.0, 10.0), least=True),
    "longest_lock": Criterion("longest_lock_s", Quantity("s", 0.0, 1e4), every=True),
    "flat_length": Criterion("flat_length_m", Quantity("m", 0.0, 1.0), every=True),
    "large_slip_share": Criterion("large_slip_share", Quantity("1", 0.0, 1.0)),
    "air": Criterion("air_litres", Quantity("m^3", 0.0, 1e3), factor=1e-3),
    "dump_cycles": Criterion("dump_cycles", Quantity("1", 0.0, 1e6)),
}


def _bound(value: Any, info: ValidationInfo) -> Any:
    """In the unit of the criterion."""
    name = info.data.get("criterion")
    if value is None or name is None:  # the criterion itself is refused
        return None
    return CRITERIA[name].quantity.parse(value)


NUMBER = {"anyOf": [{"type": "number"}, {"type": "string"}]}
"""In a JSON Schema, with a unit or without."""


class Limit(Table):
    """A limit, who set it, and the clause of a standard that it stands for."""

    criterion: Literal[*CRITERIA] = needed("criterion that is limited")  # type: ignore[valid-type]
    at_least: float | None = optional(None, "least that is allowed, in the criterion's unit", json_schema_extra=NUMBER)
    at_most: float | None = optional(None, "most that is allowed, in the criterion's unit", json_schema_extra=NUMBER)
    stops: tuple[str, ...] = optional(
        (), "names of the stops that it holds for; none: all that have such a number", max_length=100
    )
    origin: str = needed("origin of the limit: who set it, and why", min_length=1)
    clause: str = optional("", "clause of the standard or specification that it is taken from, as you have it")

    _parse = field_validator("at_least", "at_most", mode="before")(_bound)

    @property
    def value(self) -> float:
        """The limit itself, in the SI unit of the criterion."""
        value = self.at_least if self.at_least is not None else self.at_most
        assert value is not None
        return value

    def _mistakes(self) -> Mistakes:
        right, wrong = ("at_least", "at_most") if CRITERIA[self.criterion].least else ("at_most", "at_least")
        if getattr(self, wrong) is not None:
            yield wrong, f"allowed for {self.criterion}: {right}"
        if getattr(self, right) is None:
            yield right, CRITERIA[self.criterion].quantity.allowed.replace("allowed", "needed", 1)

    def holds_for(self, stop: BrakedRun) -> bool:
        """Whether a stop is assessed by it."""
        named = stop.name in self.stops if self.stops else True
        return named and (stop.stops or not CRITERIA[self.criterion].of_a_stop)


class FlatWear(Table):
    """Numbers of the estimate of a wheel flat's length."""

    wear: Annotated[float, Quantity("m^3/J", 1e-16, 1e-6)] = optional(7e-13, "worn volume per energy of a locked wheel")
    width: Annotated[float, Quantity("m", 1e-4, 0.2)] = optional(0.012, "width of the flat, across the tread")


class Programme(Sourced):
    """Stops and limits."""

    starts: Count = optional(8, "tests of each stop on each support, without which nothing is decided")
    flat: FlatWear = optional(FlatWear(), "estimate of wheel flats")
    stop: tuple[AnyStop, ...] = needed("the stops, in their order", min_length=1, max_length=100)
    limit: tuple[Limit, ...] = optional((), "limits by which they are assessed; none: nothing is", max_length=1000)
