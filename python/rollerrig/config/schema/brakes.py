"""Tables of the train and its brakes: air, electrodynamic brakes, brakes on the rail, sand."""

import math
from itertools import pairwise
from typing import Annotated, ClassVar, Literal

from pydantic import Field, StrictInt

from rollerrig.config.schema.adhesion import ALLOWED, AnyCondition, Condition
from rollerrig.config.schema.base import Mistakes, Rows, Table, by_kind, needed, optional
from rollerrig.config.schema.contact import AnyFriction, FallingFriction
from rollerrig.config.schema.units import Mass, Quantity, Time

MOST_AXLES = 32
"""That have sensors, actuators and controllers; the core's `most_axles`."""


class TrainAxles(Table):
    """All axles of the train. Those that are not under test are simulated: same wheels, creep law, brake, slide protection."""

    positions: tuple[Annotated[float, Quantity("m", 0.0, 1e4)], ...] = needed("distances behind the first axle, rising")
    under_test: tuple[Annotated[StrictInt, Field(ge=1, le=MOST_AXLES)], ...] = needed(
        "those of them that [vehicle] has: on rollers, or on track in the 3-D model; the first axle is 1"
    )
    loads: tuple[Annotated[float, Quantity("N", 1.0, 1e7)], ...] | None = optional(
        None, "loads of each simulated axle, in order; absent: the mean of the axles under test"
    )
    load_transfer: tuple[Annotated[float, Quantity("kg", -1e6, 1e6)], ...] | None = optional(
        None, "change of each simulated axle's load per acceleration of the train, forward; absent: none"
    )

    def _mistakes(self) -> Mistakes:
        n, m = len(self.positions), len(self.under_test)
        if not 1 <= n <= MOST_AXLES:
            yield "positions", f"allowed: 1 to {MOST_AXLES} axles; given are {n}"
        if self.positions[0] != 0.0 or any(not a < b for a, b in pairwise(self.positions)):
            yield "positions", "allowed: distances behind the first axle, which begin at 0 and increase"
        if not 1 <= m <= n:
            yield "under_test", f"allowed: 1 to {n} axles, no more than the train has; given are {m}"
        if any(not 1 <= k <= n for k in self.under_test) or any(not a < b for a, b in pairwise(self.under_test)):
            yield "under_test", f"allowed: numbers from 1 to {n} that increase, each axle once"
        for key in ("loads", "load_transfer"):
            given = getattr(self, key)
            if given is not None and len(given) != n - m:
                yield key, f"allowed: one number for each simulated axle, {n - m}; given are {len(given)}"

    @property
    def simulated(self) -> tuple[int, ...]:
        """Numbers of the axles that are not under test."""
        return tuple(k for k in range(1, len(self.positions) + 1) if k not in self.under_test)


class Train(Table):
    """The train of which the axles under test brake or pull their part: it runs on a track, on a rig it is reproduced."""

    mass: Mass | None = optional(None, "mass that these axles brake or pull; absent: what they carry")
    resistance_constant: Annotated[float, Quantity("N", 0.0, 1e8)] = optional(
        0.0, "A in the part of the running resistance that these axles overcome, R = A + B v + C v^2"
    )
    resistance_linear: Annotated[float, Quantity("N s/m", 0.0, 1e6)] = optional(0.0, "B")
    resistance_quadratic: Annotated[float, Quantity("N s^2/m^2", 0.0, 1e6)] = optional(0.0, "C")
    gradient: Annotated[float, Quantity("1", -0.1, 0.1)] = optional(0.0, "positive uphill")
    axles: TrainAxles | None = optional(None, "the train's axles, of which some are under test; absent: all are")
    brake_signal_speed: Annotated[float, Quantity("m/s", 10.0, 1e4)] | None = optional(
        None,
        "speed at which the brake demand runs along the main pipe, from the train's first axle; absent: everywhere at once",
    )


Pressure = Annotated[float, Quantity("Pa", 0.0, 1e8)]
PositivePressure = Annotated[float, Quantity("Pa", 1.0, 1e8)]
Rate = Annotated[float, Quantity("1/s", 1e-4, 1e5)]
Conductance = Annotated[float, Quantity("m^3/(s Pa)", 1e-13, 1e-2)]
Volume = Annotated[float, Quantity("m^3", 1e-10, 10.0)]
DeadTime = Annotated[float, Quantity("s", 0.0, 1.0)]


class UnlimitedAir(Table):
    """A supply that never runs out, behind dump valves that switch at once."""

    kind: Literal["unlimited"] = optional("unlimited", "an endless supply, behind dump valves that switch at once")
    fill_rate: Rate = optional(6.0, "choked filling of the cylinder, p'/p_supply, absolute")
    vent_rate: Rate = optional(5.0, "choked venting of the cylinder, -p'/p, absolute")


class CylinderPipe(Table):
    """A relay valve for some axles, and the pipes from it to their dump valves. The numbers are ours, of usual size."""

    length: Annotated[float, Quantity("m", 0.01, 1e3)] = needed("length from relay valve to dump valve of an axle")
    diameter: Annotated[float, Quantity("m", 5e-4, 0.1)] = optional(0.02, "inner diameter")
    axles_per_relay_valve: Annotated[StrictInt, Field(ge=1, le=MOST_AXLES)] = optional(
        2, "axles in a row behind one relay valve, counted from the front: 2 of a bogie; each has such a pipe"
    )
    relay_conductance: Conductance = optional(5e-7, "sonic conductance C of a relay valve that is wide open")

    @property
    def volume(self) -> float:
        """Volume of the pipe of one axle [m^3]."""
        return 0.25 * math.pi * self.diameter**2 * self.length


class ReservoirAir(Table):
    """An auxiliary reservoir, fed by the main pipe, behind dump valves with dead times and orifices after ISO 6358.

    The defaults are ours: of the size of a dump valve of 12 mm nominal width that switches in 20 ms, and of half a coach.
    """

    kind: Literal["reservoir"] = needed("a reservoir fed by the main pipe, behind dump valves as ISO 6358 has them")
    fill_conductance: Conductance = optional(2.5e-7, "sonic conductance C, reservoir or pipe to one axle's cylinders")
    vent_conductance: Conductance = optional(2.5e-7, "sonic conductance C from one axle's cylinders to the ambient")
    critical_ratio: Annotated[float, Quantity("1", 0.0, 0.9)] = optional(0.3, "critical pressure ratio b of orifices")
    relay_band: Annotated[float, Quantity("Pa", 1.0, 1e7)] = optional(
        1e4, "missing cylinder pressure from which the relay valve is wide open"
    )
    opening_time: DeadTime = optional(
        0.02, "dead time of a dump valve's magnet valves, a multiple of time.sampling_step"
    )
    closing_time: DeadTime = optional(0.02, "dead time for closing, likewise")
    least_pulse: DeadTime = optional(0.02, "least length of a magnet valve's command: a shorter one is prolonged")
    reservoir_volume: Volume = optional(0.1, "volume of each auxiliary reservoir")
    axles_per_reservoir: Annotated[StrictInt, Field(ge=1, le=MOST_AXLES)] | None = optional(
        None, "axles in a row that share a reservoir, counted from the front: 4 of a coach, 2 of a bogie; absent: all"
    )
    reservoir_pressure: Pressure | None = optional(
        None, "pressure of the reservoir over the ambient, at the start; absent: as the main pipe"
    )
    main_pipe_pressure: Pressure = optional(8.5e5, "pressure of the main pipe over the ambient")
    charging_conductance: Annotated[float, Quantity("m^3/(s Pa)", 0.0, 1e-2)] = optional(
        2e-8, "conductance of the choke between main pipe and reservoir; 0: the reservoir is not fed"
    )
    reference_pressure: PositivePressure = optional(
        1e5, "pressure at which conductances hold, with 20 degrees C (ISO 8778)"
    )
    temperature: Annotated[float, Quantity("K", 200.0, 400.0)] = optional(293.15, "constant temperature of all air")
    pipe: CylinderPipe | None = optional(
        None, "pipes from a relay valve to the dump valves of its axles; absent: a relay valve at each cylinder"
    )


AnyAir = Annotated[UnlimitedAir | ReservoirAir, by_kind("unlimited")]


BrakeForce = Annotated[float, Quantity("N", 0.0, 1e8)]
Share = Annotated[float, Quantity("1", 0.0, 1.0)]
FactorRate = Annotated[float, Quantity("1/s", 0.0, 1e4)]
BrakeSpeed = Annotated[float, Quantity("m/s", 0.0, 1e3)]
ForceOverSpeed = Annotated[Rows[BrakeSpeed, BrakeForce], Field(min_length=2)]


class ElectrodynamicBrake(Table):
    """What every electrodynamic brake has: its axles, its lag, and its place beside friction brake and slide protection."""

    axles: tuple[str, ...] | None = optional(
        None, "wheelsets with a motor that brakes, by name; absent: all", min_length=1
    )
    share: Share = optional(1.0, "share of the torque asked of the axle, at most; friction gives the rest")
    time_constant: Annotated[float, Quantity("s", 1e-4, 100.0)] = optional(0.1, "time constant of the torque")
    blending_delay: Annotated[float, Quantity("s", 0.0, 10.0)] = optional(
        0.2,
        "blending delay from the motor's torque to the pneumatic demand that allows for it, a multiple of "
        "time.sampling_step; the control valve's rates follow",
    )
    on_slide: Literal["keep", "reduce", "switch_off", "slip_control"] = optional(
        "reduce",
        "while slide protection vents the axle's cylinder: keep the torque; take it off and give it back, and the "
        "friction brake does not fill the gap; or switch off until the brake is released, and the friction brake takes over; "
        "slip_control: whatever the valve does, the torque is what [wheel_slip_control] admits, the gap is not filled",
    )
    reduction_rate: FactorRate = optional(5.0, "reduction rate of the factor on the torque while a cylinder is vented")
    restoring_rate: FactorRate = optional(1.0, "restoring rate of the factor on the torque while it is filled")


class ConstantPowerBrake(ElectrodynamicBrake):
    """Constant force, constant power, fading at low speed; the defaults are ours, of the size of a multiple unit's axle."""

    kind: Literal["constant_power"] = optional("constant_power", "constant force, constant power, fading at low speed")
    largest_force: BrakeForce = optional(15e3, "largest force of one axle at the wheels' circumference")
    largest_power: Annotated[float, Quantity("W", 0.0, 1e9)] = optional(300e3, "largest power of one axle")
    fade_from: BrakeSpeed = optional(10.0 / 3.6, "speed below which the force fades ...")
    fade_to: BrakeSpeed = optional(3.0 / 3.6, "... along a straight line, to nothing here")

    def _mistakes(self) -> Mistakes:
        if not self.fade_to < self.fade_from:
            yield "fade_to", f"allowed: below fade_from, {self.fade_from:g} m/s"
        corner = self.largest_power / self.largest_force if self.largest_force > 0.0 else self.fade_from
        if corner < self.fade_from:
            least = self.largest_force * self.fade_from
            yield "largest_power", f"allowed: at least {least:g} W; this curve crosses the fading at {corner:.3g} m/s"


class ForceTableBrake(ElectrodynamicBrake):
    """Points of the diagram of force over speed."""

    kind: Literal["table"] = needed("points of the diagram of force over speed")
    forces: ForceOverSpeed = needed(
        "rows [speed of the wheels' circumference, largest force of one axle]; linear between, constant beyond"
    )


AnyElectrodynamicBrake = Annotated[ConstantPowerBrake | ForceTableBrake, by_kind("constant_power")]


Excitation = Annotated[Rows[Time, Share], Field(min_length=1)]
MagnetForce = Annotated[float, Quantity("N", 0.0, 1e8)]


class TrackBrake(Table):
    """What every track brake has: when it is on."""

    demand: Excitation = needed("rows [time, excitation asked for, 0 to 1]; linear between")
    delay: Annotated[float, Quantity("s", 0.0, 1e3)] = optional(0.5, "delay of the first force: magnets are lowered")
    rise_time: Annotated[float, Quantity("s", 1e-4, 1e3)] = optional(0.5, "rise time of the excitation, none to full")
    release_speed: Annotated[float, Quantity("m/s", 0.0, 1e3)] = optional(
        0.0, "speed below which the magnets are lifted"
    )


class MagneticTrackBrake(TrackBrake):
    """Magnets that rub on the rail; the numbers are ours, of the size of two magnets of 1 m on each bogie."""

    kind: Literal["magnetic"] = optional("magnetic", "magnets that are lowered and rub on the rail")
    attraction: MagnetForce = optional(160e3, "attraction of all magnets of a bogie together, which loads no wheel")
    friction: AnyFriction = optional(
        FallingFriction(kind="falling", mu_0=0.20, A=0.35, B=0.1),
        "friction coefficient of pole shoes over speed: a number, or a law; the state of the rail is not part of it",
    )
    regularisation_speed: Annotated[float, Quantity("m/s", 1e-6, 10.0)] = optional(
        0.05, "speed below which friction is viscous"
    )


class EddyCurrentTrackBrake(TrackBrake):
    """Magnets over the rail that do not touch it; the curve over a critical speed is Wouterse's, the numbers are ours."""

    kind: Literal["eddy_current"] = needed("magnets over the rail that do not touch it: eddy currents brake")
    largest_force: MagnetForce = optional(15e3, "largest force of one bogie, at the critical speed")
    critical_speed: Annotated[float, Quantity("m/s", 1e-3, 1e3)] = optional(25.0, "speed at which the force is largest")


AnyTrackBrake = Annotated[MagneticTrackBrake | EddyCurrentTrackBrake, by_kind("magnetic")]


Duration = Annotated[float, Quantity("s", 0.0, 1e6)]
Place = Annotated[float, Quantity("m", 0.0, 1e6)]


class SandOnSlide(Table):
    """While slide protection vents an axle, or wheel-slip control takes torque off one."""

    kind: Literal["on_slide"] = optional(
        "on_slide", "while slide protection vents an axle or wheel-slip control takes torque off one"
    )


class SandBetween(Table):
    """Sand from a begin to an end."""

    unit: ClassVar[str] = "m"
    begin: Place = needed("begin of sanding")
    end: Place = needed("end of sanding")

    def _mistakes(self) -> Mistakes:
        if not self.begin < self.end:
            yield "end", f"allowed: beyond begin, {self.begin:g} {self.unit}"


class SandFromDistance(SandBetween):
    """Sand from a place on."""

    kind: Literal["from_distance"] = needed("sand from a place on")
    begin: Place = needed("distance of the train since the start")
    end: Place = optional(1e6, "end of sanding")


class SandFromTime(SandBetween):
    """Sand from a time on, as a driver switches it."""

    unit: ClassVar[str] = "s"
    kind: Literal["from_time"] = needed("sand from a time on, as a driver switches it")
    begin: Duration = needed("time of the run")
    end: Duration = optional(1e6, "end of sanding")


AnySandingStart = Annotated[SandOnSlide | SandFromDistance | SandFromTime, by_kind("on_slide")]


class Sanding(Table):
    """Sand in front of some axles: they and all axles behind them find it on the rail. All numbers are ours."""

    start: AnySandingStart = optional(SandOnSlide(), "criterion that demands sand: its kind, or a table")
    axles: tuple[str, ...] | None = optional(
        None, "wheelsets in front of which sand falls, by name; absent: the leading one", min_length=1
    )
    delay: Annotated[float, Quantity("s", 0.0, 10.0)] = optional(
        0.5, "delay from the wish to the sand on the rail, and back, a multiple of time.sampling_step"
    )
    run_on: Duration = optional(1.0, "sand is wanted for so long after its reason has gone")
    flow: Annotated[float, Quantity("kg/s", 1e-9, 100.0)] = optional(0.01, "sand on each rail in front of one axle")
    least_speed: Annotated[float, Quantity("m/s", 0.0, 1e3)] = optional(2.0, "speed below which there is no sand")
    saturation: Annotated[float, Quantity("kg/m", 1e-9, 100.0)] = optional(
        5e-4, "mass per length of rail that brings 63 % of the effect, q_0 in 1 - exp(-q/q_0)"
    )
    kept: Annotated[float, Quantity("1", 0.0, 1.0)] = optional(0.7, "share of the sand that a wheel leaves on the rail")
    rail: AnyCondition = optional(
        Condition(friction=FallingFriction(kind="falling", mu_0=0.25, A=0.6, B=0.2), k_A=0.3, k_S=0.1),
        f"condition of a rail with much sand: {ALLOWED}",
    )
