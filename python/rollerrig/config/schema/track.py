"""A track: rails, the line they follow, what they deviate from it, and what they lie on."""

from collections.abc import Sequence
from typing import Annotated, Literal, TypeVar

from pydantic import Discriminator, Field, model_validator

from rollerrig.config.schema.base import Table, refused
from rollerrig.config.schema.irregularity import AnyIrregularity
from rollerrig.config.schema.mounting import Foundation
from rollerrig.config.schema.profile import AnyProfile, Inclination
from rollerrig.config.schema.units import Quantity
from rollerrig.config.schema.vehicle import Name
from rollerrig.track import Line, Segment, build_line

Gauge = Annotated[float, Quantity("m", 0.01, 5.0)]
GaugeDepth = Annotated[float, Quantity("m", 1e-5, 0.05)]
SegmentLength = Annotated[float, Quantity("m", 1e-3, 1e6)]
Cant = Annotated[float, Quantity("m", -0.3, 0.3)]


V = TypeVar("V")

_GAUGE = "gauge of its rails; absent: that of the track; transitions widen or narrow between their neighbours"
_INCLINATION = "inclination of its rails in place of that of their profiles, a number or a ratio like '1:40'"
_PROFILE = "head of its rails; absent: as the track has them; transitions blend between their neighbours"
_RIGHT_PROFILE = "head of its right rail, as a left one would have it; absent: that of its left one"

STEEPEST_CANT = 0.25
"""Largest cant over the distance it is measured on: 14 degrees, beyond all tracks."""


class Straight(Table):
    """A straight, without cant."""

    kind: Literal["straight"] = Field(description="no curvature, no cant")
    length: SegmentLength = Field(description="length")
    gauge: Gauge | None = Field(default=None, description=_GAUGE)
    inclination: Inclination | None = Field(default=None, description=_INCLINATION)
    profile: AnyProfile | None = Field(default=None, description=_PROFILE)
    right_profile: AnyProfile | None = Field(default=None, description=_RIGHT_PROFILE)


class Transition(Table):
    """A transition between the straights or curves before and after it, of which it takes over curvature and cant."""

    kind: Literal["transition"] = Field(description="joins what stands before and after it")
    length: SegmentLength = Field(description="length")
    shape: Literal["clothoid", "bloss"] = Field(
        default="clothoid", description="curvature and cant in proportion to the distance, or along the cubic of Bloss"
    )


class Curve(Table):
    """A circular curve."""

    kind: Literal["curve"] = Field(description="constant curvature and cant")
    length: SegmentLength = Field(description="length")
    radius: Annotated[float, Quantity("m", 20.0, 1e7)] = Field(description="radius of the track's middle")
    direction: Literal["left", "right"] = Field(default="left", description="where it leads")
    cant: Cant = Field(default=0.0, description="height of the outer rail over the inner one")
    gauge: Gauge | None = Field(default=None, description=_GAUGE)
    inclination: Inclination | None = Field(default=None, description=_INCLINATION)
    profile: AnyProfile | None = Field(default=None, description=_PROFILE)
    right_profile: AnyProfile | None = Field(default=None, description=_RIGHT_PROFILE)


AnySegment = Annotated[Straight | Transition | Curve, Discriminator("kind")]


class Track(Table):
    """A track: the rig's limit of an infinite roller radius; straight, smooth and rigid unless it says otherwise."""

    kind: Literal["track"] = Field(description="rails")
    name: Name = Field(description="name of the track")
    description: str = Field(default="", description="one line about the track")
    source: str = Field(default="", description="where the data come from")
    profile: AnyProfile = Field(description="head of the left rail")
    right_profile: AnyProfile | None = Field(
        default=None, description="head of the right rail, as a left one would have it; absent: the same"
    )
    gauge: Gauge = Field(default=1.435, description="distance between the gauge sides of the two rails")
    gauge_depth: GaugeDepth = Field(
        default=0.014, description="depth below the top of rail at which the gauge is taken"
    )
    segment: tuple[AnySegment, ...] = Field(
        default=(),
        max_length=1000,
        description="straights, transitions and curves in the order of the run, which starts where the first begins; the "
        "first continues behind the start, the last beyond its end; absent: straight",
    )
    smoothing: Annotated[float, Quantity("m", 1e-3, 50.0)] = Field(
        default=4.0, description="length over which a corner of curvature and cant is rounded by a parabola"
    )
    cant_base: Annotated[float, Quantity("m", 0.01, 5.0)] = Field(
        default=1.5, description="distance over which cant is measured"
    )
    irregularity: AnyIrregularity | None = Field(
        default=None, description="what the rails deviate from their design position; absent: nothing"
    )
    foundation: Foundation | None = Field(default=None, description="what the rails lie on; absent: rigid")

    @model_validator(mode="after")
    def _cant_within_its_base(self) -> "Track":
        largest = max((abs(segment.cant) for segment in self.segment if isinstance(segment, Curve)), default=0.0)
        if largest > STEEPEST_CANT * self.cant_base:
            least = largest / STEEPEST_CANT
            raise refused("cant_base", f"allowed: at least four times the largest cant, {least:g} m")
        return self

    @property
    def line(self) -> Line | None:
        """Curvature and cant of segments that join; None for a straight track without segments."""
        if not self.segment:
            return None
        return build_line(layout(self), self.smoothing, self.cant_base)


def layout(track: Track) -> list[Segment]:
    """The segments with distances, curvatures and cants; a transition takes both from its neighbours."""
    ends = at_ends([_constant(segment) for segment in track.segment], (0.0, 0.0))
    found: list[Segment] = []
    start = 0.0
    for segment, ((k0, d0), (k1, d1)) in zip(track.segment, ends, strict=True):
        shape = segment.shape if isinstance(segment, Transition) else "clothoid"
        found.append(Segment(segment.kind, start, segment.length, (k0, k1), (d0, d1), shape))
        start += segment.length
    return found


def at_ends(constants: Sequence[V | None], otherwise: V) -> list[tuple[V, V]]:
    """What holds at the start and at the end of each segment; a transition, None, takes it from its neighbours."""
    last, found = len(constants) - 1, []
    for i, own in enumerate(constants):
        ends = (constants[max(i - 1, 0)], constants[min(i + 1, last)]) if own is None else (own, own)
        before, after = (otherwise if end is None else end for end in ends)
        found.append((before, after))
    return found


def _constant(segment: Straight | Transition | Curve) -> tuple[float, float] | None:
    """Curvature and cant of a segment where they are constant; to the left is positive, right rail up is positive."""
    match segment:
        case Straight():
            return 0.0, 0.0
        case Curve():
            sign = 1.0 if segment.direction == "left" else -1.0
            return sign / segment.radius, sign * segment.cant
        case _:
            return None
