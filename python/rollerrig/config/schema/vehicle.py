"""A vehicle: wheels, bodies, the force elements between them, and the parts of it that can be run alone.

Positions are design positions in the frame of the whole vehicle: x forward from its middle, y left, z up from the top
of rail.
"""

from typing import Annotated, Any, Literal

from pydantic import StrictBool

from rollerrig.config.schema.base import Mistakes, Name, Rows, Sourced, Table, Vector, needed, optional
from rollerrig.config.schema.profile import AnyProfile
from rollerrig.config.schema.units import (
    Angle,
    AngularDamping,
    Damping,
    Force,
    Inertia,
    Mass,
    Position,
    PositiveAngularStiffness,
    PositiveStiffness,
    Quantity,
    Torque,
    WheelRadius,
)

ForceOverDeflection = Rows[Annotated[float, Quantity("m", -10.0, 10.0)], Force]
ForceOverSpeed = Rows[Annotated[float, Quantity("m/s", -1e3, 1e3)], Force]
MomentOverAngle = Rows[Angle, Torque]
MomentOverRate = Rows[Annotated[float, Quantity("rad/s", -1e5, 1e5)], Torque]
Direction = Literal["x", "y", "z", "roll", "pitch", "yaw"]
DIRECTIONS: tuple[Direction, ...] = ("x", "y", "z", "roll", "pitch", "yaw")


class Wheel(Table):
    """The wheels of every wheelset of the vehicle."""

    profile: AnyProfile = needed("profile of the left wheel: a catalogue name, a file or a table")
    radius: WheelRadius = needed("radius at the tape circle")
    back_to_back: Annotated[float, Quantity("m", 0.01, 5.0)] = needed("distance between the flange backs")
    tape_circle: Annotated[float, Quantity("m", 1e-4, 0.5)] = optional(0.070, "distance from the flange back, EN 13715")


class Body(Table):
    """A rigid body."""

    name: Name = needed("name, unique in the vehicle")
    at: dict[Name, dict[str, Any]] | None = optional(
        None,
        "places at which it stands, by the end of the name: at.1 = { position = [...] } of `wheelset` is "
        "`wheelset_1`; loading makes a body of each",
    )
    kind: Literal["rigid", "wheelset"] = optional("rigid", "a wheelset carries two wheels and spins")
    mass: Mass = needed("mass")
    inertia: tuple[Inertia, Inertia, Inertia] = needed(
        "principal moments of inertia about x, y, z through the centre of mass"
    )
    position: Vector = needed("design position of the centre of mass", instead_of="at")
    locked: tuple[Direction, ...] = optional((), "directions in which the body cannot move")

    def _mistakes(self) -> Mistakes:
        x, _, z = self.inertia
        largest, total = max(self.inertia), sum(self.inertia)
        if largest > (total - largest) * (1 + 1e-6):
            yield "inertia", "allowed: no moment of inertia may exceed the sum of the other two"
        if self.kind == "wheelset" and abs(x - z) > 1e-9 * x:
            yield "inertia", f"allowed for a wheelset, a body of revolution: {x:g} about x and z, or {z:g} about both"


SHORTEST_RELAXATION = 1e-12
"""Damping over series stiffness, at least [s]; the core asks for the same."""


class SeriesDamper(Table):
    """A damper in series with a spring (Maxwell)."""

    damping: Annotated[float, Quantity("N s/m", 1e-6, 1e11)] = needed("damping")
    series_stiffness: PositiveStiffness = needed("stiffness of the spring in series")

    def _mistakes(self) -> Mistakes:
        least = SHORTEST_RELAXATION * self.series_stiffness
        if self.damping < least:
            allowed = f"allowed: at least {least:g} beside that stiffness; what gives way so fast carries nothing"
            yield "damping", allowed


class AngularSeriesDamper(SeriesDamper):
    """A rotational damper in series with a rotational spring (Maxwell)."""

    damping: Annotated[float, Quantity("N m s/rad", 1e-6, 1e11)] = needed("damping")
    series_stiffness: PositiveAngularStiffness = needed("stiffness of the spring in series")


class Law(Table):
    """What laws along and about an axis have in common: one spring, one damper, and that it dissipates."""

    def _mistakes(self) -> Mistakes:
        for one, table in (("stiffness", "table"), ("damping", "damping_table")):
            if getattr(self, one) is not None and getattr(self, table) is not None:
                yield table, f"allowed: `{one}` or `{table}`; for both at once write two elements"
        for speed, force in getattr(self, "damping_table", None) or ():
            if speed * force < 0 or (speed == 0 and force != 0):
                allowed = f"allowed: a force of the speed's sign, 0 at rest; [{speed:g}, {force:g}] would feed energy"
                yield "damping_table", allowed


class LinearLaw(Law):
    """Force of an element along one axis; all parts given act in parallel.

    The force on body b is minus the sum of the parts; between the rows of a table it is linear, beyond them it continues
    with the slope of the last two.
    """

    stiffness: Annotated[float, Quantity("N/m", 0.0, 1e13)] | None = optional(None, "force per deflection")
    table: ForceOverDeflection | None = optional(
        None, "rows [deflection, force] in place of a stiffness: a nonlinear spring or a bumpstop"
    )
    damping: Damping | None = optional(None, "force per speed, in parallel with the spring")
    damping_table: ForceOverSpeed | None = optional(
        None, "rows [speed, force] in place of a damping: a nonlinear damper"
    )
    damper: SeriesDamper | None = optional(None, "a damper in series with its own spring, in parallel")
    preload: Force = optional(0.0, "force at the design position, positive as a positive deflection makes it")


class AngularLaw(Law):
    """Moment of an element about one axis; all parts given act in parallel."""

    stiffness: Annotated[float, Quantity("N m/rad", 0.0, 1e13)] | None = optional(None, "moment per angle")
    table: MomentOverAngle | None = optional(None, "rows [angle, moment] in place of a stiffness")
    damping: AngularDamping | None = optional(None, "moment per angular speed, in parallel with the spring")
    damping_table: MomentOverRate | None = optional(None, "rows [angular speed, moment] in place of a damping")
    damper: AngularSeriesDamper | None = optional(None, "a damper in series with its own spring, in parallel")
    preload: Annotated[float, Quantity("N m", -1e8, 1e8)] = optional(0.0, "moment at the design position")


class Element(Table):
    """A massless force element between two bodies; its axes are those of body a, if it is `clamped` those of both."""

    name: Name = needed("name, unique in the vehicle")
    at: dict[Name, dict[str, Any]] | None = optional(
        None,
        "places at which it stands, by the end of the name: at.1 = { between = [...], point = [...] } of "
        "`primary` is `primary_1`; loading makes an element of each",
    )
    both_sides: StrictBool | None = optional(
        None, "true: on the left as written, `NAME_left`, and mirrored on the right, `NAME_right`; loading makes both"
    )
    between: tuple[str, str] = needed("the bodies a and b", instead_of="at")
    point: Vector | None = optional(None, "design position of both ends")
    points: tuple[Vector, Vector] | None = optional(
        None, "design positions of the end on a and the end on b, where they differ; the force acts at b's"
    )
    carries_load: StrictBool = optional(False, "whether its vertical preload is solved from the static equilibrium")
    clamped: StrictBool = optional(
        False,
        "a loaded spring clamped at both ends, its `point` at mid-height: half of the force acts in the axes of "
        "either body, and both ends take the same moment",
    )
    x: LinearLaw | None = optional(None, "law along x")
    y: LinearLaw | None = optional(None, "law along y")
    z: LinearLaw | None = optional(None, "law along z")
    roll: AngularLaw | None = optional(None, "law about x")
    pitch: AngularLaw | None = optional(None, "law about y")
    yaw: AngularLaw | None = optional(None, "law about z")

    def _mistakes(self) -> Mistakes:
        if (self.point is None) == (self.points is None):
            yield "point", "allowed: one of `point = [x, y, z]` and `points = [[x, y, z], [x, y, z]]`"
        if not self.laws:
            yield "x", "needed: a law in at least one of the directions x, y, z, roll, pitch, yaw"
        if self.between[0] == self.between[1]:
            yield "between", "allowed: two different bodies"
        if self.clamped and self.points is not None:
            yield "clamped", "allowed: true only with `point`, the middle of the spring, not with `points`"
        if self.carries_load and (self.z is None or (not self.z.stiffness and self.z.table is None)):
            yield "carries_load", "allowed: true only where the element has a vertical spring (z.stiffness or z.table)"
        if self.carries_load and self.z and self.z.preload:
            yield "z.preload", "allowed: no z.preload beside carries_load = true, which solves it"

    @property
    def end_a(self) -> tuple[float, float, float]:
        """Design position of the end on body a [m]."""
        return self.points[0] if self.points else (self.point or (0.0, 0.0, 0.0))

    @property
    def end_b(self) -> tuple[float, float, float]:
        """Design position of the end on body b [m]."""
        return self.points[1] if self.points else (self.point or (0.0, 0.0, 0.0))

    @property
    def laws(self) -> dict[Direction, LinearLaw | AngularLaw]:
        """The laws that are given, by direction."""
        return {direction: law for direction in DIRECTIONS if (law := getattr(self, direction)) is not None}


class Cut(Table):
    """A part of the vehicle that is run alone."""

    bodies: tuple[str, ...] = needed("bodies kept and free to move", min_length=1)
    fixed: tuple[str, ...] = optional((), "bodies kept at their design position")
    origin_x: Position = optional(0.0, "x of the cut's own origin in the vehicle's frame")


class Vehicle(Sourced):
    """A whole vehicle; `cut` names the parts of it that are run alone."""

    wheel: Wheel = needed("the wheels")
    body: tuple[Body, ...] = needed("the bodies", min_length=1, max_length=200)
    element: tuple[Element, ...] = optional((), "the force elements", max_length=2000)
    cut: dict[Name, Cut] = optional({}, "parts of the vehicle that are run alone, by name")

    def __repr__(self) -> str:
        parts = ", ".join(self.cut_names())
        return f"Vehicle {self.name}: {len(self.body)} bodies, {len(self.element)} elements; parts {parts}"

    __str__ = __repr__

    def cut_named(self, name: str) -> Cut:
        """The cut; "vehicle" is all bodies unless the file says otherwise.

        Raises:
            KeyError: no such cut.
        """
        if name == "vehicle" and name not in self.cut:
            return Cut(bodies=tuple(body.name for body in self.body))
        return self.cut[name]

    def cut_names(self) -> tuple[str, ...]:
        """Names that `cut_named` knows."""
        return tuple(dict.fromkeys(("vehicle", *self.cut)))

    def body_named(self, name: str) -> Body:
        """The body of that name.

        Raises:
            KeyError: no such body.
        """
        return {body.name: body for body in self.body}[name]

    def bodies_in(self, cut: Cut) -> tuple[Body, ...]:
        """The free bodies of a cut, in the order of the vehicle."""
        return tuple(body for body in self.body if body.name in cut.bodies)

    def heaviest_in(self, cut: Cut) -> Body | None:
        """The heaviest free body of a cut that is no wheelset; None where there are wheelsets alone."""
        rigid = [body for body in self.bodies_in(cut) if body.kind != "wheelset"]
        return max(rigid, key=lambda body: body.mass, default=None)

    def elements_in(self, cut: Cut) -> tuple[Element, ...]:
        """The elements with both ends in the cut, at least one of them on a free body."""
        kept = {*cut.bodies, *cut.fixed}
        return tuple(e for e in self.element if kept.issuperset(e.between) and not set(cut.fixed).issuperset(e.between))
