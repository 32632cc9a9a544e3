"""Tables of what acts on the axles, and of the controllers that drive it: brakes, traction, slide protection.

Wheel slide protection: dump valves by slip and acceleration, after published principles; not certified.
"""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, PlainValidator, StrictBool, WithJsonSchema

from rollerrig.config.schema.base import Mistakes, OrShort, Rows, Table, TorqueTable, by_kind, needed, optional
from rollerrig.config.schema.brakes import (
    AnyAir,
    AnyElectrodynamicBrake,
    PositivePressure,
    Pressure,
    Rate,
    UnlimitedAir,
    Volume,
)
from rollerrig.config.schema.units import Delay, Frequency, Phase, Quantity, SampleTime, Time

_LARGEST = 1e18
"""Largest value of a parameter: any unit has room below it."""


def _parameter(value: Any) -> Any:
    """A number, true or false, or a text; its type and limits are those of the FMU, and checked with it."""
    fits = isinstance(value, bool | str) or (isinstance(value, int | float) and -_LARGEST <= value <= _LARGEST)
    if not fits:
        raise ValueError("allowed: a number, true, false or a text")
    return value


Parameter = Annotated[
    Any, PlainValidator(_parameter), WithJsonSchema({"type": ["number", "boolean", "string"]}, mode="validation")
]


class ControllerFmu(Table):
    """An FMU for co-simulation, version 2.0 or 3.0, in place of our own controller."""

    file: Annotated[str, Field(min_length=1)] = needed("FMU file, relative to the file that names it")
    names: dict[str, str | tuple[str, ...]] = optional(
        {},
        "measured quantity or command -> variable of the FMU: a name in which `{axle}` stands for the axle's name "
        "and `{number}` for 1, 2, ..., or a list with a name for each axle; absent: `{axle}.axle_speed`, and so on, as "
        "`rollerrig export-fmu --part` writes them",
    )
    parameters: dict[str, Parameter] = optional({}, "parameter of the FMU -> value, in the FMU's unit")


def _from_file(value: Any) -> Any:
    """A file alone is a table with that file."""
    return {"file": value} if isinstance(value, str) else dict(value) if isinstance(value, Mapping) else value


AnyControllerFmu = Annotated[ControllerFmu, BeforeValidator(_from_file), OrShort({"type": "string"}, words="a text")]


TorqueOverSpeed = Rows[Annotated[float, Quantity("rad/s", 0.0, 1e5)], Annotated[float, Quantity("N m", 0.0, 1e9)]]
FrictionOverSpeed = Rows[Annotated[float, Quantity("m/s", 0.0, 1e3)], Annotated[float, Quantity("1", 0.0, 1.0)]]
PressureRate = Annotated[float, Quantity("Pa/s", 1.0, 1e10)]
Ratio = Annotated[float, Quantity("1", 1e-6, 1.0)]
Deceleration = Annotated[float, Quantity("m/s^2", 1e-4, 1e4)]
PositiveSpeed = Annotated[float, Quantity("m/s", 1e-6, 1e3)]
Pause = Annotated[float, Quantity("s", 0.0, 1e4)]
DriveTorque = Annotated[float, Quantity("N m", 1e-3, 1e9)]
DrivePower = Annotated[float, Quantity("W", 1e-3, 1e10)]
DriveSpeed = Annotated[float, Quantity("rad/s", 1e-3, 1e5)]


class Motor(Table):
    """A drive from torque command to torque."""

    envelope: TorqueOverSpeed | None = optional(
        None, "rows [speed of the driven axle, largest torque], a torque-speed table: each speed once; absent: no limit"
    )
    bandwidth: Frequency = optional(50.0, "bandwidth of the torque loop")
    damping_ratio: Annotated[float, Quantity("1", 0.0, 5.0)] = optional(
        0.0, "damping ratio of a torque loop of second order; 0: first order"
    )
    largest_torque: DriveTorque | None = optional(
        None, "largest torque on the driven axle, either way; absent: no limit"
    )
    largest_power: DrivePower | None = optional(None, "torque times speed of the axle, either way; absent: no limit")
    largest_speed: DriveSpeed | None = optional(
        None, "largest speed of the driven axle: beyond it there is no torque; absent: no limit"
    )
    rotor_inertia: Annotated[float, Quantity("kg m^2", 0.0, 1e8)] = optional(
        0.0, "inertia of the rotor about its shaft; on the driven axle it counts times gear_ratio squared"
    )
    gear_ratio: Annotated[float, Quantity("1", -20.0, 20.0)] = optional(
        -1.0,
        "speed of the rotor over that of the driven axle, for rotor_inertia alone: torques and speeds of this "
        "table are the driven axle's; negative: the rotor turns against the axle, as with one pair of gears",
    )


class Brake(Table):
    """Friction brake of each axle, filled by a control valve; the defaults are those of a coach with two discs an axle."""

    demand: Rows[Time, Pressure] = needed("rows [time, cylinder pressure over the ambient]; linear between")
    application_rate: PressureRate = optional(1.2e5, "rise of the control valve's pressure")
    release_rate: PressureRate = optional(1.2e5, "fall of the control valve's pressure")
    follow_rate: Rate = optional(20.0, "rate at which the control valve approaches the demand")
    air: AnyAir = optional(UnlimitedAir(), "air supply of the cylinders: its kind, or a table")
    ambient_pressure: PositivePressure = optional(
        101325.0, "pressure of the air around: valves choke by ratios of absolute pressures"
    )
    volume: Volume = optional(5e-3, "volume of one axle's cylinders, and of its pipes where brake.air has none")
    piston_area: Annotated[float, Quantity("m^2", 1e-8, 10.0)] = optional(
        0.085, "piston area of one axle times ratio and efficiency of the rigging"
    )
    spring_force: Annotated[float, Quantity("N", 0.0, 1e7)] = optional(500.0, "spring force of the retracting spring")
    friction: FrictionOverSpeed = optional(
        ((0.0, 0.38), (50.0, 0.30)), "rows [sliding speed at the friction radius, friction of the pads]"
    )
    friction_radius: Annotated[float, Quantity("m", 1e-4, 2.0)] = optional(
        0.247, "effective radius of the disc; of a tread brake the wheel radius"
    )
    faces: Annotated[float, Quantity("1", 0.01, 100.0)] = optional(2.0, "friction faces that the force presses on")
    friction_regularisation_speed: PositiveSpeed = optional(0.05, "sliding speed below which friction is viscous")
    by_traction_motors: StrictBool = optional(False, "the traction motors exert the brake's torque, as far as they can")
    electrodynamic: AnyElectrodynamicBrake | None = optional(
        None, "traction motors brake first, the friction brake gives the rest: their kind, or a table; absent: none do"
    )


class Traction(Table):
    """Traction drive of each axle."""

    demand: TorqueTable = optional(((0.0, 0.0), (1.0, 0.0)), "rows [time, torque per axle], positive forward; linear")
    motor: Motor = optional(Motor(), "the motor and its gear, seen from the axle")
    suspension: Literal["frame", "ground", "axle"] = optional(
        "frame",
        "reaction to the motor's moment: the bogie frame; nothing of the vehicle; or, axle-hung "
        "(nose-suspended), its bearings on the axle and a link on the frame, which exert two opposite vertical forces",
    )
    link: Annotated[float, Quantity("m", 1e-3, 20.0)] | None = optional(
        None, "distance of the link from the axle for suspension = 'axle', towards the frame's middle"
    )

    def _mistakes(self) -> Mistakes:
        needed = self.suspension == "axle"
        if needed != (self.link is not None):
            word = "needed, about 1 m, for" if needed else "allowed only with"
            yield "link", f"{word} suspension = 'axle'"


class Controller(Table):
    """When a controller is asked, and who it is."""

    sample_time: SampleTime = optional(5e-3, "a multiple of time.sampling_step")
    delay: Delay = optional(1e-3, "delay from the sample to the command's acting, a multiple of time.sampling_step")
    user: str | None = optional(
        None,
        "your own class in its place: 'module:Class' or 'file.py:Class', the file relative to the one that names "
        "it; its sample_time counts, this delay too",
    )
    fmu: AnyControllerFmu | None = optional(
        None, "an FMU in its place: its file, or a table; it is asked every sample_time, and this delay counts, too"
    )

    @property
    def is_ours(self) -> bool:
        """Whether our own controller runs, none of the user's."""
        return self.user is None and self.fmu is None

    def _mistakes(self) -> Mistakes:
        if self.user is not None and self.fmu is not None:
            yield "fmu", "allowed: one of user and fmu"


class BrakeUnit(Controller):
    """The brake unit, asked in time as a controller is: for one of your own in its place.

    It finds the cylinder pressures at the end of its sample time from demand and dump valves at its beginning, after all
    controllers have commanded.
    """

    sample_time: SampleTime = optional(1e-3, "a multiple of time.sampling_step")
    delay: Delay = optional(0.0, "delay from the sample to the pressure's acting, a multiple of time.sampling_step")


class SlipSearch(Table):
    """Search for the slip at which an axle transmits most: perturb and observe. All numbers are ours."""

    interval: Pause = optional(
        0.0, "interval between two changes of the slip above which an axle loses torque, about 2 s; 0: no search"
    )
    ratio: Annotated[float, Quantity("1", 1.001, 10.0)] = optional(1.15, "ratio of a change, up or down")
    least: Annotated[float, Quantity("1", 1e-3, 1.0)] = optional(0.1, "least slip tried, over slip and slip_speed")
    largest: Annotated[float, Quantity("1", 1.0, 1e3)] = optional(8.0, "largest slip tried, over slip and slip_speed")


class WheelSlipControl(Controller):
    """Takes torque off an axle that slips under its motor, driving or braking, and gives it back."""

    reference_acceleration: Deceleration = optional(1.5, "largest rise of the reference speed")
    slip: Ratio = optional(0.04, "relative slip above which torque is taken off")
    slip_speed: PositiveSpeed = optional(0.15, "lower limit of that slip as a speed")
    acceleration: Deceleration = optional(3.0, "acceleration above which an axle loses torque as well")
    filter_time: Phase = optional(0.04, "filter time of the axles' acceleration")
    reduction_rate: Rate = optional(4.0, "reduction rate of the factor on the torque")
    restoring_rate: Rate = optional(0.35, "restoring rate of the factor on the torque")
    least_factor: Ratio = optional(0.05, "least part of the torque that is left")
    release_interval: Pause = optional(
        3.0, "while axles slip one is released this often for the reference speed; 0: never"
    )
    shortest_release: Pause = optional(0.4, "shortest duration of such a release: the torque needs some time to go")
    longest_release: Phase = optional(1.2, "longest duration of such a release")
    release_deceleration: Deceleration = optional(
        0.5, "deceleration below which a released axle has run down to the train's speed"
    )
    least_acceleration: Deceleration = optional(0.05, "least acceleration of the reference speed between releases")
    regained_after: Phase = optional(3.0, "time without slip after which the axles count as gripping")
    search: SlipSearch = optional(SlipSearch(), "search for the slip at which each axle transmits most")


Entry = Literal["fill", "hold", "vent", "vent_in_steps"]


class ReferencedProtection(Controller):
    """What every law of slide protection has: reference speed, stepwise filling, watchdog."""

    reference_deceleration: Deceleration = optional(1.6, "largest fall of the reference speed: no train brakes harder")
    release_interval: Pause = optional(
        3.0, "while all axles slide one is released this often for the reference speed; 0: never"
    )
    shortest_release: Pause = optional(0.3, "shortest duration of such a release: valve and cylinder need some time")
    longest_release: Phase = optional(1.2, "longest duration of such a release")
    least_deceleration: Deceleration = optional(0.2, "least deceleration of the reference speed between releases")
    regained_after: Phase = optional(2.0, "time without slip after which an axle counts as gripping")
    filter_time: Phase = optional(0.04, "filter time of the axles' deceleration")
    recovery_acceleration: Deceleration = optional(0.5, "acceleration above which an axle is left alone")
    pulse_time: Phase = optional(0.06, "length of each step of filling after a slide ...")
    pulse_pause: Phase = optional(0.14, "... closed for so long")
    longest_vent: Phase = optional(5.0, "time of venting after which the watchdog fills")
    least_speed: PositiveSpeed = optional(5.0 / 3.6, "speed below which the protection is off: all valves fill")
    return_speed: PositiveSpeed | None = optional(
        None, "reference speed above which a protection that is off is on again; absent: least_speed"
    )

    def _mistakes(self) -> Mistakes:
        yield from super()._mistakes()
        if self.return_speed is not None and self.return_speed < self.least_speed:
            yield "return_speed", f"allowed: at least least_speed, {self.least_speed:g} m/s"


class SlideProtection(ReferencedProtection):
    """Our law: two slips, a deceleration, written after EN 15595's principles."""

    kind: Literal["slip_and_deceleration"] = optional(
        "slip_and_deceleration", "two slips and a deceleration; written after EN 15595's principles"
    )
    vent_slip: Ratio = optional(0.12, "relative slip above which a cylinder is vented")
    vent_slip_speed: PositiveSpeed = optional(1.0, "lower limit of that slip as a speed")
    vent_deceleration: Deceleration = optional(4.0, "deceleration above which a slipping axle is vented")
    fill_slip: Ratio = optional(0.06, "relative slip below which a cylinder is filled")
    fill_slip_speed: PositiveSpeed = optional(0.5, "lower limit of that slip as a speed")


class TableSlideProtection(ReferencedProtection):
    """Bands of slip and acceleration, an entry for each: the phases of an anti-lock cycle (Kiencke and Nielsen); numbers ours."""

    kind: Literal["threshold_table"] = needed("a table over bands of slip and acceleration: phases of anti-lock")
    least_slip_reference: PositiveSpeed = optional(
        30.0 / 3.6, "reference speed below which slip is over this speed, not over the reference"
    )
    slip_thresholds: tuple[Ratio, ...] = optional(
        (0.05, 0.1, 0.2), "relative slips between the rows of `entries`, ascending"
    )
    acceleration_thresholds: tuple[Annotated[float, Quantity("m/s^2", -1e3, 1e3)], ...] = optional(
        (-4.0, -1.5, 0.5), "limits of the axle's acceleration, between the columns of `entries`, ascending"
    )
    entries: tuple[tuple[Entry, ...], ...] = optional(
        (
            ("hold", "fill", "fill", "fill"),
            ("vent", "hold", "hold", "hold"),
            ("vent", "vent_in_steps", "vent_in_steps", "hold"),
            ("vent", "vent", "vent", "hold"),
        ),
        "states of an axle's valve: a row for each band of slip, least first, with an entry for each band of "
        "acceleration, strongest deceleration first; after a slide filling is stepwise",
    )

    @property
    def fill_slip(self) -> float:
        """Relative slip below which an axle counts as gripping."""
        return self.slip_thresholds[0] if self.slip_thresholds else 1.0

    @property
    def vent_slip(self) -> float:
        """Relative slip above which a cylinder is vented that does not regain speed."""
        return self.slip_thresholds[-1] if self.slip_thresholds else 1.0

    def _mistakes(self) -> Mistakes:
        yield from super()._mistakes()
        for key in ("slip_thresholds", "acceleration_thresholds"):
            values = getattr(self, key)
            if list(values) != sorted(set(values)):
                yield key, "allowed: ascending thresholds, each once"
        rows, columns = len(self.slip_thresholds) + 1, len(self.acceleration_thresholds) + 1
        if len(self.entries) != rows or any(len(row) != columns for row in self.entries):
            yield "entries", f"allowed: {rows} rows of {columns} entries, one for each band between the thresholds"


AnySlideProtection = Annotated[SlideProtection | TableSlideProtection, by_kind("slip_and_deceleration")]


def entry_numbers(table: TableSlideProtection) -> list[int]:
    """Entries row by row, as the core counts them."""
    order: tuple[Any, ...] = ("fill", "hold", "vent", "vent_in_steps")
    return [order.index(entry) for row in table.entries for entry in row]
