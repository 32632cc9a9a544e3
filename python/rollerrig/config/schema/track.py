"""Tables of a line: its layout, irregularities, and what carries rails and rollers."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Discriminator, Field, SerializerFunctionWrapHandler, StrictInt, model_serializer

from rollerrig.config.schema.base import Mistakes, Name, Sourced, Table, needed, optional
from rollerrig.config.schema.profile import AnyProfile, Inclination
from rollerrig.config.schema.units import (
    Angle,
    AngularDamping,
    Damping,
    Mass,
    Position,
    PositiveAngularStiffness,
    PositiveStiffness,
    Quantity,
)
from rollerrig.irregularity import RailIrregularity, generate, measured_irregularity, read_measured_track
from rollerrig.track import Line, Segment, build_line


class Deviation(Table):
    """What every irregularity may say about itself."""

    length_scale: Annotated[float, Quantity("1", 1e-3, 10.0)] = optional(
        1.0,
        "factor on all lengths, along the track and of the displacements: 0.2 are the rails of a 1:5 model; every "
        "other key is that of the full-scale track",
    )

    fade_in: Annotated[float, Quantity("m", 0.0, 1e4)] = optional(
        20.0, "length from where the foremost wheelset starts, over which it grows from nothing to its full size"
    )
    scale: Annotated[float, Quantity("1", 0.0, 10.0)] = optional(
        1.0, "factor on all displacements; 1.414 reads a published spectrum as a two-sided one"
    )


class SpectrumIrregularity(Deviation):
    """Rails with a published spectrum, random phases: alignment, vertical, cross level and gauge."""

    kind: Literal["ore_b176"] = needed("the spectra of ORE B 176, generated; repeats after `period`")
    level: Literal["low", "high"] = needed("level of the spectra")
    seed: Annotated[StrictInt, Field(ge=0, le=2**32 - 1)] = optional(1, "another number, other rails of the spectrum")
    shortest_wavelength: Annotated[float, Quantity("m", 0.5, 1e3)] = optional(3.0, "shortest wave")
    longest_wavelength: Annotated[float, Quantity("m", 0.5, 1e4)] = optional(100.0, "longest wave")
    period: Annotated[float, Quantity("m", 1.0, 1e5)] = optional(
        2000.0, "distance after which the rails repeat; not tied to the run, so that a seed always means the same rails"
    )

    def _mistakes(self) -> Mistakes:
        if self.longest_wavelength < self.shortest_wavelength:
            yield "longest_wavelength", f"allowed: at least shortest_wavelength, {self.shortest_wavelength:g} m"
        if self.period < self.longest_wavelength:
            yield "period", f"allowed: at least longest_wavelength, {self.longest_wavelength:g} m"


class MeasuredIrregularity(Deviation):
    """Rails from a measured file."""

    kind: Literal["file"] = needed("a CSV file of measured rails, columns with units")
    path: str = needed("the file, relative to the file that names it", min_length=1)
    start: Annotated[float, Quantity("m", -1e6, 1e6)] | None = optional(
        None,
        "distance in the file at which the middle of the vehicle (or of its cut) starts; absent: the foremost "
        "wheelset starts at the first row",
    )


AnyIrregularity = Annotated[SpectrumIrregularity | MeasuredIrregularity, Discriminator("kind")]


def rails_of_run(
    irregularity: SpectrumIrregularity | MeasuredIrregularity, foremost: float, distance: float
) -> RailIrregularity:
    """The rails of a run.

    Args:
        irregularity: what the configuration says.
        foremost: how far ahead of the middle of the vehicle its foremost wheelset stands [m].
        distance: length of the run [m].

    Raises:
        IrregularityError: a measured file cannot be used, or is shorter than the run.
    """
    own, scale = irregularity, irregularity.length_scale
    size = {"fade_in": own.fade_in, "scale": own.scale}
    if isinstance(own, SpectrumIrregularity):
        waves = {"shortest": own.shortest_wavelength, "longest": own.longest_wavelength, "period": own.period}
        rails = generate(own.level, own.seed, **waves, **size)
    else:
        track, ahead, run = read_measured_track(Path(own.path)), foremost / scale, distance / scale
        start = float(track.distance[0]) - ahead if own.start is None else own.start
        rails = measured_irregularity(track, start=start, needed=(ahead, ahead + run), **size)
    return rails if scale == 1.0 else rails.scaled(scale)


class LinearSupport(Table):
    """Elastic support along one axis."""

    stiffness: PositiveStiffness = needed("stiffness")
    damping: Damping = optional(0.0, "damping")


class AngularSupport(Table):
    """Elastic support about one axis."""

    stiffness: PositiveAngularStiffness = needed("stiffness")
    damping: AngularDamping = optional(0.0, "damping")


class WithSupports(Table):
    """What stands on elastic supports, each along or about one axis."""

    @property
    def laws(self) -> dict[str, LinearSupport | AngularSupport]:
        """The supports that are given, by direction."""
        keys = {"y": "lateral", "z": "vertical", "roll": "roll", "yaw": "yaw"}
        return {direction: law for direction, key in keys.items() if (law := getattr(self, key, None)) is not None}


_LARGEST_MOMENT = 1e8
"""At rest, in the support of a roller axle with a yaw misalignment [N m]: the range of preloads in the core."""


class Mounting(WithSupports):
    """How a roller axle is mounted; what is absent is rigid."""

    lateral: LinearSupport | None = optional(None, "elastic support along y")
    vertical: LinearSupport | None = optional(None, "elastic support along z")
    yaw: AngularSupport | None = optional(None, "elastic support about z")
    misalignment: tuple[Angle, ...] = optional(
        (),
        "angle about z at which the roller axles of the first, second, ... wheelset are mounted, positive to the "
        "left; those not named stand square; needs `yaw`",
        max_length=64,
    )

    def _mistakes(self) -> Mistakes:
        if any(self.misalignment) and self.yaw is None:
            yield "yaw", "needed: the support about z of a roller axle with a yaw misalignment"
        largest = _LARGEST_MOMENT / self.yaw.stiffness if self.yaw else math.inf
        if max(map(abs, self.misalignment), default=0.0) > largest:
            yield "misalignment", f"allowed: at most {largest:.3g} rad, a moment of {_LARGEST_MOMENT:g} N m at rest"


class Restraint(Table):
    """A coupler rod from a vehicle to the ground: spring and damper along the track, which hold it on top of the rollers."""

    height: Position = needed("height of the rod above the crowns")
    stiffness: PositiveStiffness = needed("stiffness of the rod with its anchorage, along the track")
    damping: Damping = optional(0.0, "damping of the same")
    body: Name | None = optional(None, "body that it holds; absent: the heaviest that is no wheelset")


class Sleeper(WithSupports):
    """Half a sleeper under each piece of rail, on ballast; the supports of the foundation are then those of the rail pad."""

    mass: Mass = optional(150.0, "mass of the moving share of the sleepers under one wheel")
    lateral: LinearSupport | None = optional(None, "ballast along y; absent: rigid")
    vertical: LinearSupport | None = optional(None, "ballast along z; absent: rigid")

    def _mistakes(self) -> Mistakes:
        if not self.laws:
            yield "vertical", "needed: ballast along y or z; without both leave out the sleeper"


class Foundation(WithSupports):
    """Rails on an elastic foundation: under each wheel a piece of rail that moves along with it; what is absent is rigid.

    docs/how_to/flexible_rails.md says when to use it, and where the values of the catalogue's `flexible_track` come from.
    """

    rail_mass: Mass = optional(150.0, "mass of the piece of rail under one wheel, with what moves with it")
    lateral: LinearSupport | None = optional(None, "elastic support of one rail's foot along y")
    vertical: LinearSupport | None = optional(None, "elastic support of one rail's foot along z")
    roll: AngularSupport | None = optional(None, "elastic support of one rail about its foot")
    rail_height: Annotated[float, Quantity("m", 0.01, 1.0)] = optional(
        0.172, "top of rail over foot: lever arm of the lateral force"
    )
    sleeper: Sleeper | None = optional(None, "a second layer between the supports and the ground; absent: none")

    def _mistakes(self) -> Mistakes:
        if not self.laws:
            yield "lateral", "needed: a support along y, z or about the foot, as in flexible_track; else leave it out"

    @property
    def centre_height(self) -> float:
        """Height of the rail's centre of mass over its foot [m]: 81 of 172 mm in a 60E1."""
        return 0.47 * self.rail_height

    @property
    def roll_inertia(self) -> float:
        """Inertia of the rail about its centre of mass [kg m^2]: radius of gyration 68 of 172 mm in a 60E1."""
        return self.rail_mass * (0.395 * self.rail_height) ** 2


Gauge = Annotated[float, Quantity("m", 0.01, 5.0)]
GaugeDepth = Annotated[float, Quantity("m", 1e-5, 0.05)]
SegmentLength = Annotated[float, Quantity("m", 1e-3, 1e6)]
Cant = Annotated[float, Quantity("m", -0.3, 0.3)]


V = TypeVar("V")


class WithGauge(Sourced):
    """What rails and rollers have in common: their gauge is given, or the distance of the contacts."""

    profile: AnyProfile = needed("head of the left rail, or generatrix of the left roller")
    right_profile: AnyProfile | None = optional(
        None, "head or generatrix on the right, as a left one would have it; absent: the same"
    )
    gauge: Gauge = optional(1.435, "distance between the gauge sides of the two rails or rollers")
    gauge_depth: GaugeDepth = optional(0.014, "depth below the top of rail or the crown at which the gauge is taken")
    contact_distance: Gauge | None = optional(
        None, "distance between contacts of the centred wheelset in place of gauge; needs the same head left and right"
    )
    irregularity: AnyIrregularity | None = optional(
        None,
        "irregularities of the rails; on a rig those of a track that actuators feed to the wheels by moving the "
        "rollers; absent: none",
    )

    def _mistakes(self) -> Mistakes:
        if self.contact_distance is not None and "gauge" in self.model_fields_set:
            yield "contact_distance", "allowed without gauge, which follows from it"
        if self.contact_distance is not None and self.right_profile not in (None, self.profile):
            yield "contact_distance", "allowed with the same head left and right; right_profile is another one"

    @model_serializer(mode="wrap")
    def _without_a_gauge_that_follows(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        tables: dict[str, Any] = handler(self)
        if self.contact_distance is not None:
            tables.pop("gauge", None)
        return tables


STEEPEST_CANT = 0.25
"""Largest cant over the distance it is measured on: 14 degrees, beyond all tracks."""


class LaidSegment(Table):
    """What a straight or a curve says of its rails; transitions pass from one of their neighbours to the other."""

    length: SegmentLength = needed("length")
    gauge: Gauge | None = optional(
        None, "gauge of its rails; absent: that of the track; transitions widen or narrow between their neighbours"
    )
    inclination: Inclination | None = optional(None, "inclination in place of the profiles', also a ratio like '1:40'")
    profile: AnyProfile | None = optional(
        None, "head of its rails; absent: as the track has them; transitions blend between their neighbours"
    )
    right_profile: AnyProfile | None = optional(None, "right rail's head, as a left one has it; absent: the left's")


class Straight(LaidSegment):
    """A straight, without cant."""

    kind: Literal["straight"] = needed("no curvature, no cant")


class Transition(Table):
    """A transition between the straights or curves before and after it, of which it takes over curvature and cant."""

    kind: Literal["transition"] = needed("joins what stands before and after it")
    length: SegmentLength = needed("length")
    shape: Literal["clothoid", "bloss"] = optional("clothoid", "curvature and cant: linear, or the cubic of Bloss")


class Curve(LaidSegment):
    """A circular curve."""

    kind: Literal["curve"] = needed("constant curvature and cant")
    radius: Annotated[float, Quantity("m", 20.0, 1e7)] = needed("radius of the track's middle")
    direction: Literal["left", "right"] = optional("left", "direction in which it leads")
    cant: Cant = optional(0.0, "height of the outer rail over the inner one")


AnySegment = Annotated[Straight | Transition | Curve, Discriminator("kind")]


class Track(WithGauge):
    """A track: the rig's limit of an infinite roller radius; straight, smooth and rigid unless it says otherwise."""

    kind: Literal["track"] = needed("rails")
    segment: tuple[AnySegment, ...] = optional(
        (),
        "straights, transitions and curves in the order of the run, which starts where the first begins; the "
        "first continues behind the start, the last beyond its end; absent: straight",
        max_length=1000,
    )
    smoothing: Annotated[float, Quantity("m", 1e-3, 50.0)] = optional(
        4.0, "length over which a corner of curvature and cant is rounded by a parabola"
    )
    cant_base: Annotated[float, Quantity("m", 0.01, 5.0)] = optional(1.5, "distance over which cant is measured")
    foundation: Foundation | None = optional(None, "foundation of the rails; absent: rigid")

    def _mistakes(self) -> Mistakes:
        yield from super()._mistakes()
        largest = max((abs(segment.cant) for segment in self.segment if isinstance(segment, Curve)), default=0.0)
        if largest > STEEPEST_CANT * self.cant_base:
            yield "cant_base", f"allowed: at least four times the largest cant, {largest / STEEPEST_CANT:g} m"

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
