"""Tables of a case: what runs on what, how it moves, what is computed."""

from typing import Annotated, Any, Literal, NamedTuple, get_args

from pydantic import ConfigDict, StrictBool, model_validator

from rollerrig.config.schema.actuators import AnySlideProtection, Brake, BrakeUnit, Traction, WheelSlipControl
from rollerrig.config.schema.adhesion import Adhesion
from rollerrig.config.schema.base import Mistakes, Name, Named, SpeedTable, Table, TorqueTable, needed, optional
from rollerrig.config.schema.brakes import AnyTrackBrake, Sanding, Train
from rollerrig.config.schema.contact import (
    AnyCreep,
    AnyFriction,
    AnyNormal,
    ConstantFriction,
    ExactTable,
    Friction,
    Material,
    Strips,
)
from rollerrig.config.schema.ensemble import Ensemble
from rollerrig.config.schema.faults import AnyFault
from rollerrig.config.schema.rig_control import RigControl, Sensors
from rollerrig.config.schema.support import AnySupport
from rollerrig.config.schema.units import Damping, Quantity, RunningSpeed, Torque
from rollerrig.config.schema.vehicle import Body, Cut, Vehicle

StrategyName = Literal["mmu", "dlr", "inrets"]
Kept = Literal["gravity", "material", "clock", "drives"]
KEPT: tuple[Kept, ...] = get_args(Kept)

Factor = Annotated[float, Quantity("1", 1e-4, 1e4)]


class ScaledFrom(Table):
    """What a scaled case is a model of. Its other tables are at the model's own scale: this one changes nothing in a run."""

    case: Name = needed("name of the full-scale case")
    strategy: StrategyName = needed("choice of the factors of time and density for a length")
    length: Factor = needed("a length at full scale over that of the model")
    time: Factor = needed("a time at full scale over that of the model")
    density: Factor = needed("a density at full scale over that of the model")
    keep: tuple[Kept, ...] = optional(
        (),
        "properties that a real model cannot scale, or does not: gravity; material of wheels and rollers; clock, sample times "
        "and delays of the controllers; drives, bandwidth of the motors",
    )


GRAVITY = 9.81
"""Standard acceleration of gravity, that of a case which gives none [m/s^2]."""


class VehicleChoice(Table):
    """Which vehicle, and which part of it."""

    use: str | None = optional(
        None, "a vehicle of the catalogue, or a file relative to this one; keys beside it take the place of its own"
    )
    data: Vehicle = needed("the vehicle itself, in place of `use`; after loading it is always here", instead_of="use")
    cut: str = optional("vehicle", "the part that is run: a [cut.NAME] of the vehicle, or 'vehicle' for all")

    @property
    def part(self) -> Cut:
        """The chosen cut of the vehicle."""
        return self.data.cut_named(self.cut)

    @property
    def bodies(self) -> tuple[Body, ...]:
        """Free bodies of the chosen cut, in the order of the vehicle."""
        return self.data.bodies_in(self.part)

    @property
    def wheelsets(self) -> tuple[Body, ...]:
        """Wheelsets among them."""
        return tuple(body for body in self.bodies if body.kind == "wheelset")


class SupportChoice(Table):
    """Which rig or track."""

    use: str | None = optional(
        None, "a support of the catalogue, or a file relative to this one; keys beside it take the place of its own"
    )
    data: AnySupport = needed("the support itself, in place of `use`; always here after loading", instead_of="use")


class RollerEffects(Table):
    """What makes a roller differ from a rail, each to be switched off to see what it costs; track knows none of them."""

    curvature: StrictBool = optional(True, "the roller's curvature along x makes the patch shorter (Hertz and Kalker)")
    conicity: StrictBool = optional(True, "the roller's surface speed follows its local radius; off: crown speed")
    spin: StrictBool = optional(True, "the roller's turning counts in the spin creepage")
    yaw: StrictBool = optional(True, "a yawed or shifted wheel leaves the crown, its normal tilts; off: as on a rail")


class Contact(Table):
    """Laws and parameters of the contact between wheel and rail or roller."""

    material: Material = needed("material of both: a catalogue name, a file or a table")
    friction: AnyFriction = optional(
        ConstantFriction(kind="constant", mu_0=0.3), "a coefficient, or a law over slip velocity"
    )
    gauge_face_friction: Friction | None = optional(
        None,
        "coefficient on the gauge face of rail or roller, from a contact angle of 40 degrees on; up to 20 degrees "
        "that of the top, `friction` or [adhesion]; a smooth transition between; absent: the same everywhere",
    )
    creep: AnyCreep = optional(ExactTable(kind="table"), "law of the tangential force: its kind, or a table")
    kalker_factor: Annotated[float, Quantity("1", 0.01, 10.0)] = optional(
        1.0, "factor on Kalker's coefficients, below 1 for rough or contaminated surfaces; not with `coefficients`"
    )
    normal: AnyNormal = optional(Strips(kind="strips"), "law of the normal force: its kind, or a table")
    normal_damping: Damping = optional(1e5, "damping of the normal force while the surfaces approach")
    damping_onset: Annotated[float, Quantity("m/s", 1e-9, 1.0)] = optional(
        1e-4, "speed of approach from which on the damping acts in full; rounds its corner at rest"
    )
    creepage_regularisation_speed: Annotated[float, Quantity("m/s", 1e-6, 10.0)] = optional(
        0.1, "V_s in the rolling speed sqrt(V^2 + V_s^2) that creepages are divided by"
    )
    pure_rolling: StrictBool = optional(
        False,
        "pure rolling, with actuators on rollers: no axle slides along the track on its rollers, r w = R W, as "
        "the rig's control law assumes; one force per axle, without a limit, takes the place of the longitudinal creep forces' "
        "mean; normal forces, lateral and yaw creep stay. For studies of what real sliding does to the control",
    )
    roller_effects: RollerEffects = optional(RollerEffects(), "differences of a roller from a rail that count")

    @property
    def creep_shear_modulus(self) -> float:
        """Shear modulus of the surfaces in Kalker's coefficients [Pa]."""
        return self.kalker_factor * self.material.shear_modulus

    @property
    def flange_friction(self) -> float:
        """Coefficient of friction where flanges touch, at no slip [-]."""
        return self.friction.mu_0 if self.gauge_face_friction is None else self.gauge_face_friction

    def _mistakes(self) -> Mistakes:
        if self.creep.kind == "strip_theory" and self.normal.kind != "strips":
            yield "creep", "allowed: strip_theory with normal = 'strips', whose strips it follows; else take 'table'"
        if self.creep.kind == "coefficients" and self.kalker_factor != 1.0:
            yield "kalker_factor", "allowed with contact.creep = 'coefficients': 1; its coefficients are final"


class Motion(Table):
    """How the vehicle and the rollers are driven, and when a brake test ends."""

    speed: RunningSpeed = needed(
        "running speed at the start; on rollers the simulated one; taken from speed_table if absent",
        instead_of="speed_table",
    )
    drive: Literal["speed_controlled", "free", "torque"] = optional(
        "speed_controlled", "rollers (or track): speed constant or by speed_table, free to turn, or given a torque"
    )
    speed_table: SpeedTable | None = optional(
        None, "rows [time, speed] for drive = 'speed_controlled'; linear between, constant beyond"
    )
    torque_table: TorqueTable | None = optional(
        None, "rows [time, torque per roller axle] for drive = 'torque'; positive drives forward running"
    )
    stop_speed: Annotated[float, Quantity("m/s", 1e-4, 50.0)] = optional(
        1.0, "lowest speed with [brake]: a train slower than this counts as stationary, and the run ends"
    )

    @model_validator(mode="before")
    @classmethod
    def _speed_from_table(cls, data: Any) -> Any:
        if not isinstance(data, dict) or "speed" in data:
            return data
        try:
            return {**data, "speed": data["speed_table"][0][1]}
        except (KeyError, IndexError, TypeError):
            return data

    def _mistakes(self) -> Mistakes:
        needed = self.drive == "torque"
        if needed != (self.torque_table is not None):
            yield "torque_table", "needed for drive = 'torque'" if needed else "allowed only with drive = 'torque'"
        if self.speed_table is None:
            return
        if self.drive != "speed_controlled":
            yield "speed_table", "allowed only with drive = 'speed_controlled'"
        start, speed = self.speed_table[0]
        if start != 0 or abs(speed - self.speed) > 1e-9 * max(1.0, self.speed):
            yield "speed_table", f"allowed: a first row at time 0 with motion.speed; [{start:g}, {speed:g}] is not that"


class AxleTorque(Table):
    """A torque on a wheelset."""

    wheelset: str = needed("the wheelset")
    constant: Torque | None = optional(None, "torque; positive drives the vehicle forward")
    table: TorqueTable | None = optional(None, "rows [time, torque] in place of a constant; linear, constant beyond")
    reacts_on: str = optional("none", "the body that feels the opposite moment (the motor's frame), or 'none'")

    def _mistakes(self) -> Mistakes:
        if (self.constant is None) == (self.table is None):
            yield "table", "allowed: one of `constant = torque` and `table = [[time, torque], ...]`"


Offset = Annotated[float, Quantity("m", -1.0, 1.0)]
SidewaysOffset = Annotated[float, Quantity("m", -0.1, 0.1)]
Rotation = Annotated[float, Quantity("rad", -0.5, 0.5, bare=0.2)]


class Disturbance(Table):
    """Offset of a body from its equilibrium, from which the run starts."""

    body: str = needed("the body")
    longitudinal: Offset = optional(0.0, "offset along x")
    lateral: SidewaysOffset = optional(0.0, "offset along y, positive to the left")
    vertical: Offset = optional(0.0, "offset along z")
    roll: Rotation = optional(0.0, "offset about x")
    pitch: Rotation = optional(0.0, "offset about y")
    yaw: Rotation = optional(0.0, "offset about z")


FIXED_STEP = ("rk4", "exponential_rk4", "exponential_adams")
"""Methods that need a step; exponential_adams may halve it."""


class Integration(NamedTuple):
    """Method and step that a case is integrated with."""

    method: str
    step: float | None
    """Step of a method with a fixed step; of an adaptive one the first step tried; None: it finds its own [s]."""

    @property
    def fixed(self) -> bool:
        """Whether the method keeps to the step."""
        return self.method in FIXED_STEP


Step = Annotated[float, Quantity("s", 1e-8, 1.0)]
Interval = Annotated[float, Quantity("s", 1e-7, 1e5)]


class TimeSettings(Table):
    """How time is integrated, when sensors and controllers are sampled, and what is kept."""

    duration: Annotated[float, Quantity("s", 1e-6, 1e5)] = needed("length of the run")
    method: Literal["rodas4", "rk4", "exponential_rk4", "exponential_adams", "dormand_prince"] | None = optional(
        None,
        "rodas4: stiff, adaptive, exact Jacobian; dormand_prince: explicit, adaptive; rk4: fixed step; "
        "exponential_rk4: fixed step that dampers with series stiffness do not limit; exponential_adams: two evaluations a step "
        "that contact stiffness does not limit either, halved by its error, the fastest with smooth contacts (strips); "
        "absent: rodas4, and with actuators or controllers exponential_adams with the sampling step",
    )
    step: Step | None = optional(
        None,
        "step of rk4 and exponential_rk4, longest step of exponential_adams, which need it; for the others the "
        "first step tried",
    )
    relative_tolerance: Annotated[float, Quantity("1", 1e-13, 0.1)] = optional(
        1e-6, "local error per step, relative to each state"
    )
    absolute_tolerance: Annotated[float, Quantity("1", 1e-16, 1.0)] = optional(
        1e-9, "local error per step of a displacement or angle [m, rad]; of its rate 100 1/s times that"
    )
    maximum_step: Interval | None = optional(None, "longest step of an adaptive method; absent: no limit")
    sampling_step: Annotated[float, Quantity("s", 1e-6, 1.0)] = optional(
        1e-3,
        "period of actuators and controllers: samples, delays and changes of commands are at its multiples; the "
        "method integrates from one to the next",
    )
    output_step: Interval = optional(0.01, "interval between kept samples")

    def _mistakes(self) -> Mistakes:
        if self.method in FIXED_STEP and self.step is None:
            yield "step", f"needed: the step of the fixed-step method {self.method}, e.g. step = '0.1 ms'"
        for key, value in (("output_step", self.output_step), ("step", self.step), ("maximum_step", self.maximum_step)):
            if value is not None and value > self.duration:
                yield key, f"allowed: at most the duration, {self.duration:g} s"


ACTUATORS = (
    "adhesion", "brake", "track_brake", "sanding", "traction", "slide_protection", "wheel_slip_control", "brake_unit",
    "rig_control",
)  # fmt: skip
"""Tables of a case beside vehicle, support and contact: what acts on the vehicle, and degraded adhesion."""


class CaseTables(Named):
    """Everything one simulation needs; read by `load_case`, in SI, never changed: `with_changes` makes another."""

    model_config = ConfigDict(title="Case")

    base: str | None = optional(
        None,
        "a case of the catalogue, or a file relative to this one, from which this one says only what is "
        "different; loading writes that into it",
    )
    without: tuple[str, ...] | None = optional(None, "dotted keys that `base` has and this one has not")
    gravity: Annotated[float, Quantity("m/s^2", 0.05, 1e4)] = optional(
        GRAVITY, "acceleration of gravity; another one only in ideal similitude"
    )
    vehicle: VehicleChoice = needed("the vehicle")
    support: SupportChoice = needed("the rig or the track")
    contact: Contact = needed("the contact")
    motion: Motion = needed("the drive")
    axle_torque: tuple[AxleTorque, ...] = optional((), "torques on wheelsets")
    disturbance: tuple[Disturbance, ...] = optional((), "offsets at the start")
    time: TimeSettings = needed("the integration")
    train: Train = optional(Train(), "train of which the axles under test brake or pull their part")
    adhesion: Adhesion | None = optional(None, "adhesion of the rail, real or virtual; absent: friction")
    brake: Brake | None = optional(None, "friction brake of each axle")
    track_brake: AnyTrackBrake | None = optional(
        None, "magnets of each bogie that brake on the rail: kind, or a table; on a rig they brake the virtual train"
    )
    sanding: Sanding | None = optional(None, "sand on the rail of [adhesion]")
    traction: Traction | None = optional(None, "traction drive of each axle")
    slide_protection: AnySlideProtection | None = optional(None, "wheel slide protection: its kind, or a table")
    wheel_slip_control: WheelSlipControl | None = optional(None, "protection of the traction drives against wheel slip")
    brake_unit: BrakeUnit | None = optional(
        None, "brake unit of your own: demand and valves -> cylinder pressures; absent: that of [brake]"
    )
    sensors: Sensors = optional(Sensors(), "sensors of the controllers")
    rig_control: RigControl | None = optional(None, "controller of the roller drives")
    fault: tuple[AnyFault, ...] = optional((), "faults of axles' brakes and sensors", max_length=16)

    ensemble: Ensemble = optional(Ensemble(), "scatter between the tests of an ensemble, as adhesion and wsp make them")
    similitude: ScaledFrom | None = optional(None, "the full-scale case that this one models; absent: at full scale")

    @property
    def sampled(self) -> bool:
        """Whether actuators or controllers act on the vehicle, sampled in time."""
        return any((self.adhesion, self.brake, self.track_brake, self.traction, self.rig_control))

    @property
    def axle_names(self) -> tuple[str, ...]:
        """Axles of the train: wheelsets under test, then `axle_N` for each simulated one, N its number along the train."""
        simulated = self.train.axles.simulated if self.train.axles else ()
        return (*(body.name for body in self.vehicle.wheelsets), *(f"axle_{k}" for k in simulated))

    @property
    def integration(self) -> Integration:
        """Method and step of [time], where they are absent those that belong to such a case."""
        step = self.time.step
        if self.time.method is not None:
            return Integration(self.time.method, step)
        if self.sampled:
            return Integration("exponential_adams", self.time.sampling_step if step is None else step)
        return Integration("rodas4", step)
