"""From a checked case to the compiled model: the only caller of the core's constructors.

    Case -> [assemble] -> AssembledModel -> run, analysis

No physics here: positions are added up, names become indices, profiles become spline tables.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from rollerrig import _core
from rollerrig.config import AngularSupport, Case, Foundation, LinearSupport, Mounting, Rig, Track, Vehicle
from rollerrig.config.schema.irregularity import rails_of_run
from rollerrig.config.schema.vehicle import DIRECTIONS, AngularLaw, Body, Element, LinearLaw
from rollerrig.config.validate.check_track import distance_run, foremost_wheelset
from rollerrig.creep import creep_law_of, friction_of
from rollerrig.irregularity import RAILS, RailIrregularity
from rollerrig.profiles import ProfileTable, gauge_point, profile_from_spec
from rollerrig.track import Line

GROUND = -1
Row = tuple[float, float]


@dataclass(frozen=True)
class WheelInfo:
    """One wheel of the assembled model."""

    name: str
    wheelset: str
    side: str
    contact: int


@dataclass(frozen=True)
class AssembledModel:
    """A compiled model and the names of its parts, in the order of the core's indices."""

    case: Case
    core: _core.Model
    bodies: tuple[str, ...]
    elements: tuple[str, ...]
    wheels: tuple[WheelInfo, ...]
    wheelsets: tuple[str, ...]
    rollers: tuple[str, ...]
    rails: tuple[str, ...]
    """Pieces of rail on an elastic foundation; none where the rails are rigid."""
    fixed: tuple[str, ...]
    masses: dict[str, float]
    inertias: dict[str, tuple[float, float, float]]
    """Principal moments of inertia of each body [kg m^2]."""
    positions: dict[str, tuple[float, float, float]]
    axle_loads: dict[str, float]
    """Static load of each axle: its own weight and what its springs carry in the design position [N]."""
    preloads: dict[str, float]
    """Vertical preload of each element that carries load, force on its second body [N]."""
    wheel_profile: ProfileTable
    rail_profile: ProfileTable
    rail_origin_y: float
    """Lateral position of the highest point of the left rail or roller [m]."""
    line: Line | None
    """Curvature and cant of the track; None where it is straight, and on a rig."""
    irregularity: RailIrregularity | None
    """Displacements of the rails, or of the rollers that stand for them; None where there are none."""
    breakpoints: tuple[float, ...] = field(default=())
    """Times at which an input has a corner [s]."""

    def body_index(self, name: str) -> int:
        """Index of a body in the core.

        Raises:
            KeyError: no such body.
        """
        try:
            return self.bodies.index(name)
        except ValueError:
            raise KeyError(f"no body named {name!r}; there are {', '.join(self.bodies)}") from None

    @property
    def lateral_bodies(self) -> tuple[str, ...]:
        """Vehicle bodies that can move sideways: frames, wheelsets, car body where free."""
        return tuple(b for b in self.vehicle_bodies if b not in self.fixed)

    @property
    def vehicle_bodies(self) -> tuple[str, ...]:
        """Bodies of the vehicle, held ones included; no rollers, no rails."""
        return tuple(b for b in self.bodies if b not in self.rollers and b not in self.rails)


def assemble(case: Case) -> AssembledModel:
    """Build the compiled model of a case.

    Args:
        case: a checked case.

    Returns:
        The model; constant, it may be shared by any number of simulations.
    """
    return _Assembly(case).build()


class _Assembly:
    def __init__(self, case: Case) -> None:
        self.case = case
        self.vehicle: Vehicle = case.vehicle.data
        self.cut = case.vehicle.part
        self.support = case.support.data
        self.core = _core.Model()
        self.core.gravity = case.gravity
        self.bodies: list[str] = []
        self.elements: list[str] = []
        self.rollers: list[str] = []
        self.rails: list[str] = []
        self.wheels: list[WheelInfo] = []
        self.positions: dict[str, tuple[float, float, float]] = {}
        self.masses: dict[str, float] = {}
        self.inertias: dict[str, tuple[float, float, float]] = {}
        self.roller_of: dict[tuple[str, str], int] = {}

    def build(self) -> AssembledModel:
        preloads, axle_loads = static_loads(self.vehicle, self.case.gravity)
        kept = {*self.cut.bodies, *self.cut.fixed}
        for body in self.vehicle.body:
            if body.name in kept:
                self._add_vehicle_body(body)
        wheelsets = [b for b in self.vehicle.bodies_in(self.cut) if b.kind == "wheelset"]
        for element in self.vehicle.elements_in(self.cut):
            self._add_element(element, preloads.get(element.name, 0.0))
        if isinstance(self.support, Rig):
            for body in wheelsets:
                self._add_rollers(body, self.support, axle_loads[body.name])
        elif self.support.foundation is not None:
            for body in wheelsets:
                self._add_rails(body, self.support.foundation, axle_loads[body.name])
        line, irregularity = self._add_way()
        wheel, rail, rail_origin = self._add_contacts(wheelsets)
        breakpoints = self._add_motion()
        return AssembledModel(
            case=self.case,
            core=self.core,
            bodies=tuple(self.bodies),
            elements=tuple(self.elements),
            wheels=tuple(self.wheels),
            wheelsets=tuple(b.name for b in wheelsets),
            rollers=tuple(self.rollers),
            rails=tuple(self.rails),
            fixed=tuple(self.cut.fixed),
            masses=self.masses,
            inertias=self.inertias,
            positions=self.positions,
            axle_loads={b.name: axle_loads[b.name] for b in wheelsets},
            preloads={name: preloads[name] for name in self.elements if name in preloads},
            wheel_profile=wheel,
            rail_profile=rail,
            rail_origin_y=rail_origin,
            line=line,
            irregularity=irregularity,
            breakpoints=breakpoints,
        )

    def _add_vehicle_body(self, body: Body) -> None:
        x, y, z = body.position
        position = (x - self.cut.origin_x, y, z)
        held = body.name in self.cut.fixed
        locked = [held or direction in body.locked for direction in DIRECTIONS]
        locked[0] = locked[0] or body.name == self._hauled()
        self._add_body(body.name, body.mass, body.inertia, position, body.kind == "wheelset", locked, 0.0)

    def _hauled(self) -> str | None:
        """The body that a line with curves takes along at the running speed: the heaviest, where no body is held.

        Curving slows a free vehicle down; it would fall behind its own track frame, whose x axis is straight.
        """
        if not isinstance(self.support, Track) or not self.support.segment or self.cut.fixed:
            return None
        return max(self.vehicle.bodies_in(self.cut), key=lambda body: body.mass).name

    def _add_body(
        self,
        name: str,
        mass: float,
        inertia: tuple[float, float, float],
        position: tuple[float, float, float],
        axisymmetric: bool,
        locked: list[bool],
        driven_inverse_radius: float,
        carried: bool = True,
    ) -> int:
        self.bodies.append(name)
        self.positions[name] = position
        self.masses[name] = mass
        self.inertias[name] = inertia
        return self.core.add_body(mass, inertia, position, axisymmetric, locked, driven_inverse_radius, carried)

    def _add_element(self, element: Element, preload: float) -> None:
        a, b = (self.bodies.index(name) for name in element.between)
        x, y, z = element.end_b
        bx, by, bz = self.positions[element.between[1]]
        index = self.core.add_element(
            a, b, (x - self.cut.origin_x - bx, y - by, z - bz), element.carries_load, element.clamped
        )
        self.elements.append(element.name)
        for direction, law in element.laws.items():
            extra = preload if element.carries_load and direction == "z" else 0.0
            set_law(self.core, index, DIRECTIONS.index(direction), law, extra)

    def _add_rollers(self, wheelset: Body, rig: Rig, axle_load: float) -> None:
        x = wheelset.position[0] - self.cut.origin_x
        mounting = rig.mounting
        free = {
            "pitch": True,
            "y": mounting is not None and mounting.lateral is not None,
            "z": mounting is not None and mounting.vertical is not None,
            "yaw": mounting is not None and mounting.yaw is not None,
        }
        locked = [not free.get(direction, False) for direction in DIRECTIONS]
        driven = 1.0 / rig.roller_radius if self.case.motion.drive == "speed_controlled" else 0.0
        number = wheelset.name.removeprefix("wheelset_")
        sides = ("",) if rig.coupling == "axle" else ("_left", "_right")
        share = 1.0 / len(sides)
        for side in sides:
            y = {"": 0.0, "_left": 1.0, "_right": -1.0}[side] * self._rail_origin()
            name = f"roller_{number}{side}"
            ixx, iyy, izz = rig.roller_inertia
            inertia = (share * ixx, share * iyy, share * izz)
            position = (x, y, -rig.roller_radius)
            index = self._add_body(name, share * rig.roller_mass, inertia, position, True, locked, driven)
            self.rollers.append(name)
            for wheel_side in ("left", "right") if side == "" else (side[1:],):
                self.roller_of[(wheelset.name, wheel_side)] = index
            if mounting is not None:
                self._mount(name, index, mounting, share * (axle_load + rig.roller_mass * self.core.gravity))

    def _add_rails(self, wheelset: Body, foundation: Foundation, axle_load: float) -> None:
        x, mass = wheelset.position[0] - self.cut.origin_x, foundation.rail_mass
        free = {"y": foundation.lateral is not None, "z": foundation.vertical is not None}
        locked = [not free.get(direction, False) for direction in DIRECTIONS]
        number = wheelset.name.removeprefix("wheelset_")
        for side, sign in (("left", 1.0), ("right", -1.0)):
            name = f"rail_{number}_{side}"
            position = (x, sign * self._rail_origin(), 0.0)
            index = self._add_body(name, mass, (mass, mass, mass), position, False, locked, 0.0, carried=False)
            self.rails.append(name)
            self.roller_of[(wheelset.name, side)] = index
            self._mount(name, index, foundation, 0.5 * axle_load + mass * self.core.gravity)

    def _mount(self, name: str, body: int, mounting: Mounting | Foundation, load: float) -> None:
        element = self.core.add_element(GROUND, body, (0.0, 0.0, 0.0), False, False)
        self.elements.append(f"mounting_{name}")
        for attribute, direction in (("lateral", "y"), ("vertical", "z"), ("yaw", "yaw")):
            spring: LinearSupport | AngularSupport | None = getattr(mounting, attribute, None)
            if spring is not None:
                preload = load if direction == "z" else 0.0
                self.core.set_law(
                    element, DIRECTIONS.index(direction), preload, spring.stiffness, [], spring.damping, [], 0.0, 0.0
                )

    def _rail_origin(self) -> float:
        """Lateral position of the left rail's highest point: the gauge is taken `gauge_depth` below it [m]."""
        table = profile_from_spec(self.support.profile.arguments(), "rail")
        return self.support.gauge / 2 + abs(gauge_point(table, self.support.gauge_depth))

    def _add_contacts(self, wheelsets: list[Body]) -> tuple[ProfileTable, ProfileTable, float]:
        wheel = profile_from_spec(self.vehicle.wheel.profile.arguments(), "wheel")
        rail = profile_from_spec(self.support.profile.arguments(), "rail")
        wheel_index = self.core.add_profile(wheel.start, wheel.step, wheel.coefficients)
        rail_index = self.core.add_profile(rail.start, rail.step, rail.coefficients)
        rail_origin = self._rail_origin()
        radius = self.support.roller_radius if isinstance(self.support, Rig) else None
        contact = self.case.contact
        effects = contact.roller_effects
        for body in wheelsets:
            for side in ("left", "right"):
                roller = self.roller_of.get((body.name, side), GROUND)
                roller_y = self.positions[self.bodies[roller]][1] if roller != GROUND else 0.0
                index = self.core.add_contact(
                    wheelset=self.bodies.index(body.name),
                    roller=roller,
                    rail=isinstance(self.support, Track),
                    along=self.positions[body.name][0],
                    right=side == "right",
                    wheel_profile=wheel_index,
                    rail_profile=rail_index,
                    wheel_radius=self.vehicle.wheel.radius,
                    tape_circle_y=self.vehicle.wheel.back_to_back / 2 + self.vehicle.wheel.tape_circle,
                    rail_origin_y=rail_origin,
                    inverse_radius=1.0 / radius if radius else 0.0,
                    wheelset_from_crown=(0.0, body.position[1], body.position[2]),
                    crown_in_roller=(0.0, -roller_y, radius or 0.0),
                    shear_modulus=contact.material.shear_modulus,
                    poisson_ratio=contact.material.poisson_ratio,
                    friction=friction_of(contact),
                    normal=contact.normal,
                    creep=creep_law_of(contact),
                    normal_damping=contact.normal_damping,
                    creepage_regularisation_speed=contact.creepage_regularisation_speed,
                    merging_criterion=contact.merging_criterion,
                    roller_effects=(effects.curvature, effects.conicity, effects.spin, effects.yaw),
                    damping_onset=contact.damping_onset,
                    size=self.vehicle.wheel.profile.length_scale,
                )
                self.wheels.append(WheelInfo(f"{body.name}_{side}", body.name, side, index))
        return wheel, rail, rail_origin

    def _add_way(self) -> tuple[Line | None, RailIrregularity | None]:
        """Where the track leads, and where its rails lie."""
        line = self.support.line if isinstance(self.support, Track) else None
        if line is not None:
            self.core.set_line(line.curvature.rows, line.cant.rows, line.cant_base)
        chosen = self.support.irregularity
        if chosen is None:
            return line, None
        distance = distance_run(self.case.motion, self.case.time.duration)
        rails = rails_of_run(chosen, foremost_wheelset(self.case), distance)
        left_y, left_z, right_y, right_z = (rails.coefficients[rail] for rail in RAILS)
        steered = not isinstance(self.support, Rig) or self.support.steered
        self.core.set_irregularity(rails.period, rails.step, left_y, left_z, right_y, right_z, rails.fade_in, steered)
        return line, rails

    def _add_motion(self) -> tuple[float, ...]:
        motion = self.case.motion
        speed: list[Row] = [(0.0, motion.speed)] if motion.speed_table is None else list(motion.speed_table)
        self.core.set_speed(speed)
        corners = [time for time, _ in speed]
        if motion.torque_table is not None:
            corners += [time for time, _ in motion.torque_table]
            axle_share = 0.5 if isinstance(self.support, Rig) and self.support.coupling == "independent" else 1.0
            rows = [(time, axle_share * torque) for time, torque in motion.torque_table]
            for name in self.rollers:
                self.core.add_roller_torque(self.bodies.index(name), rows)
        for torque in self.case.axle_torque:
            rows = [(0.0, torque.constant)] if torque.constant is not None else list(torque.table or ())
            corners += [time for time, _ in rows]
            reaction = GROUND if torque.reacts_on == "none" else self.bodies.index(torque.reacts_on)
            self.core.add_axle_torque(self.bodies.index(torque.wheelset), reaction, rows)
        duration = self.case.time.duration
        return tuple(sorted({time for time in corners if 0.0 < time < duration}))


def set_law(core: _core.Model, element: int, direction: int, law: LinearLaw | AngularLaw, preload: float) -> None:
    """Hand one direction of an element to the core.

    Args:
        core: the model.
        element: index of the element.
        direction: 0..5 for x, y, z, roll, pitch, yaw.
        law: the law; its own `preload` acts on body a's side, so that body b feels the opposite.
        preload: further force on body b along the positive axis at the design position [N].
    """
    core.set_law(
        element,
        direction,
        preload - law.preload,
        law.stiffness or 0.0,
        list(law.table or ()),
        law.damping or 0.0,
        list(law.damping_table or ()),
        law.damper.damping if law.damper else 0.0,
        law.damper.series_stiffness if law.damper else 0.0,
    )


def static_loads(vehicle: Vehicle, gravity: float = 9.81) -> tuple[dict[str, float], dict[str, float]]:
    """Vertical preloads and axle loads of the whole vehicle in its design position, solved by the core.

    Args:
        vehicle: all bodies and elements.
        gravity: its acceleration [m/s^2].

    Returns:
        Preload per element that carries load (force on its second body [N]), and load per wheelset [N].
    """
    core = _core.Model()
    core.gravity = gravity
    names = [body.name for body in vehicle.body]
    for body in vehicle.body:
        core.add_body(body.mass, body.inertia, body.position, body.kind == "wheelset", [False] * 6, 0.0, True)
    for element in vehicle.element:
        a, b = (names.index(name) for name in element.between)
        point = tuple(p - q for p, q in zip(element.end_b, vehicle.body[b].position, strict=True))
        core.add_element(a, b, point, element.carries_load, element.clamped)
    forces, _ = core.static_preloads()
    preloads = {e.name: f for e, f in zip(vehicle.element, forces, strict=True) if e.carries_load}
    loads = {body.name: body.mass * core.gravity for body in vehicle.body if body.kind == "wheelset"}
    for element in vehicle.element:
        a_name, b_name = element.between
        force = preloads.get(element.name, 0.0)
        if b_name in loads:
            loads[b_name] -= force
        if a_name in loads:
            loads[a_name] += force
    return preloads, loads
