"""A checked case becomes the compiled model: the only caller of the core's model_of.

    Case -> [assemble] -> AssembledModel -> run, analysis
    Case -> [AssembledModel] -> its plant in parts -> rollerrig.assembly.actuators -> the same with actuators

No physics here: positions are added up, names become indices, profiles become spline tables.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from rollerrig import _core
from rollerrig.assembly.laws import Support, contact_laws, direction_law, friction
from rollerrig.assembly.model_parts import WheelInfo, add_part, no_parts, static_loads
from rollerrig.config import Case, ConfigError, Foundation, Restraint, Rig, Track, Vehicle
from rollerrig.config.schema.support import (
    NOWHERE,
    RAIL_CURVES,
    RollerLosses,
    Side,
    rail_heads,
    rail_layout,
)
from rollerrig.config.schema.track import rails_of_run
from rollerrig.config.schema.vehicle import DIRECTIONS, Body, Element
from rollerrig.config.validate.check_track import distance_run, foremost_wheelset
from rollerrig.irregularity import RAILS, RailIrregularity
from rollerrig.profiles import ProfileTable, gauge_point, profile_from_spec
from rollerrig.track import Line

GROUND = -1
_PLAIN_BODY: dict[str, Any] = {
    "axisymmetric": False,
    "speed_controlled_radius": 0.0,
    "in_moving_frame": True,
    **dict.fromkeys(("loss_constant", "loss_linear", "loss_quadratic"), 0.0),
}
Rows = Sequence[tuple[float, float]]
Point = tuple[float, float, float]


class AssembledModel:
    """A compiled model and the names of its parts, in the order of the core's indices; constant once it is finished.

    Made of a case it is the plant in `parts`, to which more may be added before `finish` compiles it.
    """

    core: _core.Model
    # the model whose equilibrium a run starts from: `core` itself but for a train, which starts on level track, coasting
    start_core: _core.Model
    bodies: tuple[str, ...] = ()
    elements: tuple[str, ...] = ()
    wheels: tuple[WheelInfo, ...] = ()
    rollers: tuple[str, ...] = ()
    rails: tuple[str, ...] = ()  # pieces of rail on an elastic foundation, and of sleepers; none of rigid rails
    axles: tuple[_core.AxleParts, ...] = ()  # actuators of each axle; empty where the model was assembled without
    # adhesion of the case's rails; None without [adhesion], and where the model was assembled without actuators
    adhesion: _core.AdhesionMap | None = None
    bogies: int = 0  # that carry the magnets of a track brake, where the case has one

    def __init__(self, case: Case, adhesion: _core.AdhesionMap | None = None) -> None:
        """The plant of a case; `adhesion` of the rails under its wheels takes the place of the case's friction."""
        self.case, self.support = case, case.support.data
        self.vehicle: Vehicle = case.vehicle.data
        self.cut = case.vehicle.part
        self.fixed = self.cut.fixed
        self.wheelsets, self.axle_names = tuple(body.name for body in case.vehicle.wheelsets), case.axle_names
        self.parts = no_parts(case.gravity, contact_laws(case.contact))
        self.masses: dict[str, float] = {}
        self.inertias: dict[str, Point] = {}  # principal moments of inertia of each body [kg m^2]
        self.positions: dict[str, Point] = {}
        self._profile_index: dict[ProfileTable, int] = {}
        self._roller_of: dict[tuple[str, str], int] = {}
        # vertical preload of each element that carries load, force on its second body [N], and static load of each axle: its
        # own weight and what its springs carry in the design position [N]
        preloads, loads = static_loads(self.vehicle, case.gravity)
        own = self.vehicle.elements_in(self.cut)
        self.preloads = {element.name: preloads[element.name] for element in own if element.name in preloads}
        self.axle_loads = {name: loads[name] for name in self.wheelsets}
        self.wheel_profile = profile_from_spec(self.vehicle.wheel.profile.arguments(), "wheel")
        left, right = self.support.profile, self.support.right_profile
        self.rail_profile = profile_from_spec(left.arguments(), "rail")
        self.right_rail_profile = self.rail_profile if right is None else profile_from_spec(right.arguments(), "rail")
        # distance of the highest point of the left and right rail or roller from the middle [m]
        self.rail_origin_y = self._rail_origin(self.rail_profile)
        self.right_rail_origin_y = self._rail_origin(self.right_rail_profile)
        self._add_plant(adhesion)

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
        others = {*self.fixed, *self.rollers, *self.rails}
        return tuple(b for b in self.bodies if b not in others)

    @property
    def main_body(self) -> str:
        """The body that is held in the train, or else the heaviest one."""
        return self.fixed[0] if self.fixed else max(self.case.vehicle.bodies, key=lambda body: body.mass).name

    def frame_of(self, wheelset: str) -> int:
        """The body that carries callipers and motor of a wheelset: what its springs stand under; or GROUND."""
        for element in self.vehicle.element:
            if element.carries_load and wheelset in element.between:
                other = element.between[0] if element.between[1] == wheelset else element.between[1]
                return self.body_index(other) if other in self.bodies else GROUND
        return GROUND

    def finish(self) -> "AssembledModel":
        """Compile what has been added so far."""
        self.core = _core.model_of(_core.ModelParts(**self.parts))
        self.start_core = _core.coasting_model(self.core)
        return self

    def _rail_origin(self, profile: ProfileTable) -> float:
        """The gauge is taken `gauge_depth` below a rail's highest point."""
        return self.support.gauge / 2 + abs(gauge_point(profile, self.support.gauge_depth))

    def _add_plant(self, adhesion: _core.AdhesionMap | None) -> None:
        kept = {*self.cut.bodies, *self.fixed}
        for body in self.vehicle.body:
            if body.name in kept:
                self._add_vehicle_body(body)
        for element in self.vehicle.elements_in(self.cut):
            self._add_element(element)
        wheelsets = self.case.vehicle.wheelsets
        if isinstance(self.support, Rig):
            for place, body in enumerate(wheelsets):
                self._add_rollers(body, self.support, place)
            if self.support.restraint is not None:
                self._restrain(self.support.restraint)
        elif self.support.foundation is not None:
            for body in wheelsets:
                self._add_rails(body, self.support.foundation)
        # curvature and cant of the track, None where it is straight and on a rig; displacements of the rails, or of the rollers
        # that stand for them; times at which an input has a corner [s]
        self.line, self.irregularity = self._add_track_geometry()
        self._add_contacts(wheelsets, adhesion)
        self.breakpoints = self._add_motion()

    def _add_vehicle_body(self, body: Body) -> None:
        x, y, z = body.position
        position = (x - self.cut.origin_x, y, z)
        held = body.name in self.fixed
        locked = [held or direction in body.locked for direction in DIRECTIONS]
        # A line with curves takes the main body along at the running speed. Curving slows a free vehicle down; it would fall
        # behind its own track frame, whose x axis is straight.
        curves = isinstance(self.support, Track) and bool(self.support.segment)
        locked[0] |= curves and not self.fixed and body.name == self.main_body
        self._add_body(body.name, body.mass, body.inertia, position, locked, axisymmetric=body.kind == "wheelset")

    def _add_body(
        self,
        name: str,
        mass: float,
        inertia: Point,
        position: Point,
        locked: list[bool],
        **more: Any,
    ) -> int:
        """A body of the core; what `more` does not say of it is as in _PLAIN_BODY."""
        self.bodies += (name,)
        self.positions[name] = position
        self.masses[name] = mass
        self.inertias[name] = inertia
        given = _PLAIN_BODY | more
        body = _core.Body(mass=mass, inertia=inertia, position=position, locked=locked, **given)
        return add_part(self.parts, "bodies", body)

    def _add_element(self, element: Element) -> None:
        a, b = element.between
        x, y, z = element.end_b
        bx, by, bz = self.positions[b]
        point, loads = (x - self.cut.origin_x - bx, y - by, z - bz), {"z": self.preloads.get(element.name, 0.0)}
        key = f"vehicle.element.{element.name}"
        self._join(
            element.name,
            self.body_index(a),
            self.body_index(b),
            point,
            element.laws,
            loads,
            key,
            clamped=element.clamped,
        )

    def _join(
        self,
        name: str,
        a: int,
        b: int,
        point: Point,
        laws: Mapping[Any, Any],
        loads: Mapping[str, float],
        key: str = "",
        *,
        clamped: bool = False,
    ) -> None:
        """An element at a point of body b, with its laws and loads at rest in each direction.

        Raises:
            ConfigError: what it carries is too heavy; it names the key.
        """
        try:
            law = [direction_law(laws.get(c), loads.get(c, 0.0)) for c in DIRECTIONS]
        except ValueError as error:
            allowed = "allowed: lighter bodies above it"
            raise ConfigError.of(self.case.name, key or name, str(error).partition(": ")[2], allowed) from None
        self.elements += (name,)
        element = _core.ForceElement(body_a=a, body_b=b, point_on_b=point, law=law, clamped=clamped)
        add_part(self.parts, "elements", element)

    def _add_rollers(self, wheelset: Body, rig: Rig, place: int) -> None:
        """The rollers under a wheelset, which is the `place`-th from the front."""
        x = wheelset.position[0] - self.cut.origin_x
        mounting = rig.mounting
        free = {"pitch", *(mounting.laws if mounting else ())}
        locked = [direction not in free for direction in DIRECTIONS]
        controlled = rig.roller_radius if self.case.motion.drive == "speed_controlled" else 0.0
        number = wheelset.name.removeprefix("wheelset_")
        sides = ("",) if rig.coupling == "axle" else ("_left", "_right")
        share = 1.0 / len(sides)
        load = share * (self.axle_loads[wheelset.name] + rig.roller_mass * self.case.gravity)
        for side in sides:
            y = {"": 0.0, "_left": self.rail_origin_y, "_right": -self.right_rail_origin_y}[side]
            name = f"roller_{number}{side}"
            ixx, iyy, izz = rig.roller_inertia
            mass, inertia = share * rig.roller_mass, (share * ixx, share * iyy, share * izz)
            torques = (rig.losses or RollerLosses()).model_dump()
            own = {f"loss_{name}": share * torque for name, torque in torques.items()}
            own |= {"axisymmetric": True, "speed_controlled_radius": controlled}
            index = self._add_body(name, mass, inertia, (x, y, -rig.roller_radius), locked, **own)
            self.rollers += (name,)
            for wheel_side in ("left", "right") if side == "" else (side[1:],):
                self._roller_of[(wheelset.name, wheel_side)] = index
            if mounting is not None:
                askew = dict(enumerate(mounting.misalignment)).get(place, 0.0)
                self._mount(index, mounting.laws, load, askew)

    def _add_rails(self, wheelset: Body, foundation: Foundation) -> None:
        """Under each wheel a piece of rail on its foot; under that, where asked for, half a sleeper at the same place."""
        x, mass, sleeper = wheelset.position[0] - self.cut.origin_x, foundation.rail_mass, foundation.sleeper
        number = wheelset.name.removeprefix("wheelset_")
        foot = (0.0, 0.0, -foundation.centre_height)
        for side, y in (("left", self.rail_origin_y), ("right", -self.right_rail_origin_y)):
            load, under = 0.5 * self.axle_loads[wheelset.name] + mass * self.case.gravity, GROUND
            place = (x, y, -foundation.rail_height)
            if sleeper is not None:
                under = self._add_piece(f"sleeper_{number}_{side}", sleeper.mass, sleeper.mass, place, sleeper.laws)
                self._mount(under, sleeper.laws, load + sleeper.mass * self.case.gravity)
            place = (*place[:2], foundation.centre_height - foundation.rail_height)
            index = self._add_piece(f"rail_{number}_{side}", mass, foundation.roll_inertia, place, foundation.laws)
            self._roller_of[(wheelset.name, side)] = index
            self._mount(index, foundation.laws, load, point=foot, under=under)

    def _add_piece(self, name: str, mass: float, inertia: float, place: Point, free: Mapping[str, Support]) -> int:
        """A piece of track that moves in the directions in which it has supports."""
        self.rails += (name,)
        locked = [direction not in free for direction in DIRECTIONS]
        return self._add_body(name, mass, (inertia, inertia, inertia), place, locked, in_moving_frame=False)

    def _mount(
        self,
        body: int,
        laws: Mapping[str, Support],
        load: float,
        askew: float = 0.0,
        point: Point = (0.0, 0.0, 0.0),
        under: int = GROUND,
    ) -> None:
        """Springs and dampers under a roller, whose rest is turned about z [rad], or a point of a piece of track."""
        loads = {"z": load} if "z" in laws else {}
        if askew and (yaw := laws.get("yaw")):
            loads["yaw"] = yaw.stiffness * askew
        self._join(f"mounting_{self.bodies[body]}", under, body, point, laws, loads)

    def _restrain(self, restraint: Restraint) -> None:
        """The coupler rod that holds the vehicle along the track."""
        heaviest = self.vehicle.heaviest_in(self.cut)
        name = restraint.body or (heaviest.name if heaviest else "")
        point = (0.0, 0.0, restraint.height - self.positions[name][2])
        self._join("restraint", GROUND, self.body_index(name), point, {"x": restraint}, {})

    def _add_contacts(self, wheelsets: Sequence[Body], adhesion: _core.AdhesionMap | None) -> None:
        """Two contacts of each wheelset, left and right, and the heads that change along the rails or round the rollers."""
        heads, own = rail_heads(self.support), friction(self.case.contact, adhesion)
        sides: tuple[tuple[Side, ProfileTable, float], ...] = (
            ("left", self.rail_profile, self.rail_origin_y),
            ("right", self.right_rail_profile, self.right_rail_origin_y),
        )
        for body in wheelsets:
            for side, rail, origin in sides:
                contact = _core.ContactDescription(
                    wheelset=self.body_index(body.name),
                    roller=self._roller_of.get((body.name, side), GROUND),
                    roller_radius=self.support.roller_radius if isinstance(self.support, Rig) else 0.0,
                    right=side == "right",
                    wheel_profile=self._profile(self.wheel_profile),
                    rail_profile=self._profile(heads[side].tables[0] if side in heads else rail),
                    wheel_radius=self.vehicle.wheel.radius,
                    tape_circle_y=self.vehicle.wheel.back_to_back / 2 + self.vehicle.wheel.tape_circle,
                    rail_origin_y=origin,
                    size=self.vehicle.wheel.profile.length_scale,
                    friction=own,
                )
                index = add_part(self.parts, "contacts", contact)
                self.wheels += (WheelInfo(f"{body.name}_{side}", body.name, side, index),)
        for side, changing in heads.items():
            self.parts[f"{side}_heads"] = _core.RailHeads(
                profiles=[self._profile(table) for table in changing.tables],
                place=changing.place.rows.tolist(),
                period=max(one.period for one in heads.values()),
            )

    def _profile(self, table: ProfileTable) -> int:
        """Index of a profile in the core, which gets it once."""
        if table not in self._profile_index:
            spline = _core.UniformSpline(table.start, table.step, table.coefficients)
            self._profile_index[table] = add_part(self.parts, "profiles", spline)
        return self._profile_index[table]

    def _add_track_geometry(self) -> tuple[Line | None, RailIrregularity | None]:
        """Where the track leads, and where its rails lie."""
        line = self.support.line if isinstance(self.support, Track) else None
        if isinstance(self.support, Track):
            laid = rail_layout(self.support) or dict.fromkeys(RAIL_CURVES, NOWHERE)
            left, right = (
                _core.RailLayout(**{name: laid[f"{side}_{name}"].rows.tolist() for name in ("y", "z", "roll")})
                for side in ("left", "right")
            )
            curvature, cant, base = (line.curvature, line.cant, line.cant_base) if line else (NOWHERE, NOWHERE, 1.5)
            self.parts["line"] = _core.Line(
                curvature=curvature.rows.tolist(), cant=cant.rows.tolist(), cant_base=base, left=left, right=right
            )
        chosen = self.support.irregularity
        if chosen is None:
            return line, None
        distance = distance_run(self.case.motion, self.case.time.duration)
        rails = rails_of_run(chosen, foremost_wheelset(self.case), distance)
        self.parts["irregularity"] = _core.Irregularity(
            **{name: _core.UniformSpline(0.0, rails.step, rails.coefficients[name]) for name in RAILS},
            period=rails.period,
            fade_in=rails.fade_in,
            steered=not isinstance(self.support, Rig) or self.support.steered,
        )
        return line, rails

    def _add_motion(self) -> tuple[float, ...]:
        motion = self.case.motion
        speed = [(0.0, motion.speed)] if motion.speed_table is None else list(motion.speed_table)
        self.parts["speed"] = speed
        corners = [time for time, _ in speed]
        if motion.torque_table is not None:
            corners += [time for time, _ in motion.torque_table]
            axle_share = 0.5 if isinstance(self.support, Rig) and self.support.coupling == "independent" else 1.0
            rows = [(time, axle_share * torque) for time, torque in motion.torque_table]
            for index in map(self.body_index, self.rollers):
                driven = _core.RollerTorque(roller=index, torque=rows, gear_ratio=1.0, rotor_inertia=0.0)
                add_part(self.parts, "roller_torques", driven)
        for torque in self.case.axle_torque:
            rows = [(0.0, torque.constant)] if torque.constant is not None else list(torque.table or ())
            corners += [time for time, _ in rows]
            reaction = GROUND if torque.reacts_on == "none" else self.body_index(torque.reacts_on)
            add_part(self.parts, "axle_torques", axle_torque(self.body_index(torque.wheelset), reaction, rows))
        duration = self.case.time.duration
        return tuple(sorted({time for time in corners if 0.0 < time < duration}))


def assemble(case: Case) -> AssembledModel:
    """Build the compiled model of a case, without its actuators (see `rollerrig.assembly.actuators`).

    Args:
        case: a checked case.

    Returns:
        The model; constant, it may be shared by any number of simulations.

    Example:
        >>> import rollerrig as rr
        >>> rr.assemble(rr.load_case("wheelset_rollers")).bodies[1]
        'wheelset_1'
    """
    return AssembledModel(case).finish()


def axle_torque(wheelset: int, reaction: int, table: Rows) -> _core.AxleTorque:
    """A torque about an axle over time [N m], of no motor; its opposite acts on the body `reaction`, or on nothing."""
    rotor = {"link": 0.0, "gear_ratio": 1.0, "rotor_inertia": 0.0}
    return _core.AxleTorque(wheelset=wheelset, reaction=reaction, torque=table, **rotor)
