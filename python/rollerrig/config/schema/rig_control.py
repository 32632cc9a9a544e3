"""Tables of the controller of the roller drives, and of the rig's sensors."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from rollerrig.config.schema.actuators import Controller, DrivePower, DriveSpeed, DriveTorque, Motor
from rollerrig.config.schema.base import Table, by_kind, needed, optional
from rollerrig.config.schema.contact import kinds
from rollerrig.config.schema.units import (
    Delay,
    Frequency,
    Inertia,
    Phase,
    Quantity,
    RollerRadius,
    SampleTime,
    WheelRadius,
)


class Encoder(Table):
    """Incremental encoder: speed from counts."""

    kind: Literal["encoder"] = optional("encoder", "incremental encoder: speed from counts")
    counts: Annotated[float, Quantity("1", 0.0, 1e7)] = optional(0.0, "per turn; 0: exact speeds")
    jitter: Annotated[float, Quantity("1", 0.0, 100.0)] = optional(0.0, "deviation of edges, in counts")
    window: Annotated[int, Field(strict=True, ge=1, le=16)] = optional(1, "samples over which counts are differenced")


class PhonicWheel(Table):
    """Toothed wheel with one pick-up; a magnitude, it does not tell the direction."""

    teeth: Annotated[float, Quantity("1", 1.0, 1e5)] = optional(100.0, "around the phonic wheel")
    pitch_error: Annotated[float, Quantity("1", 0.0, 0.1)] = optional(
        0.0, "standard deviation of a tooth's place, in pitches; the same in each turn"
    )


class PulsePeriod(PhonicWheel):
    """Speed from the time between edges of a phonic wheel."""

    kind: Literal["pulse_period"] = needed("phonic wheel: speed from the time between edges")
    averaging_time: Annotated[float, Quantity("s", 0.0, 1.0)] = optional(
        5e-3, "edges are timed over at least so long; 0: from sample to sample"
    )
    timeout: Annotated[float, Quantity("s", 1e-3, 100.0)] = optional(
        0.3, "time without an edge after which the axle counts as standing"
    )
    clock: Annotated[float, Quantity("Hz", 0.0, 1e12)] = optional(
        1e6, "frequency of the clock that times the edges; 0: exactly"
    )


class PulseFrequency(PhonicWheel):
    """Speed from the number of edges of a phonic wheel in a gate time."""

    kind: Literal["pulse_frequency"] = needed("phonic wheel: speed from the number of edges in a gate time")
    gate_time: Annotated[float, Quantity("s", 1e-4, 10.0)] = optional(
        0.1, "edges are counted over at least so long; speed comes in steps of one edge per gate time"
    )


AnySpeedSensor = Annotated[Encoder | PulsePeriod | PulseFrequency, by_kind("encoder")]


class ForceSensor(Table):
    """Transducer of a force [N] or a torque [N m]: lag, then noise, resolution and range of each reading."""

    bandwidth: Frequency | None = optional(None, "bandwidth of first order; absent: no lag")
    noise: Annotated[float, Quantity("1", 0.0, 1e9)] = optional(0.0, "standard deviation of a reading, in N or N m")
    resolution: Annotated[float, Quantity("1", 0.0, 1e9)] = optional(0.0, "resolution, in N or N m; 0: none")
    range: Annotated[float, Quantity("1", 1e-6, 1e9)] | None = optional(None, "largest reading, N or N m; absent: none")


class Sensors(Table):
    """What controllers see of speeds, torques and loads."""

    axles: AnySpeedSensor = optional(Encoder(), "sensor of the rig on each axle of the vehicle: its kind, or a table")
    rollers: AnySpeedSensor = optional(Encoder(), "sensor on each roller axle: its kind, or a table")
    vehicle: AnySpeedSensor | None = optional(
        None,
        "sensor of the vehicle on each axle, for its slide protection and wheel-slip control: its kind, or a table; "
        "absent: they see what `axles` does",
    )
    roller_torque: ForceSensor | None = optional(
        None, "torque flange in the drive shaft of each roller axle; absent: its torque is known"
    )
    axle_load: ForceSensor = optional(ForceSensor(), "vertical force on the rollers (or rails) under each axle")
    seed: Annotated[int, Field(strict=True, ge=0, le=2**31)] = optional(1, "seed of all noise")


_TRANSFER = Quantity("kg", -1e8, 1e8)


def _load_transfer(value: Any) -> Any:
    """'none', 'quasi_static' or a number for each axle."""
    if value in ("none", "quasi_static"):
        return value
    allowed = "allowed: 'quasi_static', 'none', or a list with a number in kg for each axle"
    if not isinstance(value, list | tuple):
        raise ValueError(allowed)
    try:
        return tuple(_TRANSFER.parse(number) for number in value)
    except ValueError:
        raise ValueError(allowed) from None


LoadTransfer = Annotated[
    Literal["none", "quasi_static"] | tuple[Annotated[float, _TRANSFER], ...], BeforeValidator(_load_transfer)
]


class Estimator(Table):
    """Contact force and axle torque from the rollers' side."""

    torque: Literal["measured", "commanded"] = optional(
        "measured", "torque of a roller's drive: as [sensors.roller_torque] says, exact if absent; or the commanded one"
    )


class BandwidthEstimator(Estimator):
    """An estimator of limited bandwidth."""

    bandwidth: Frequency = optional(
        20.0,
        "pole of the filter, natural frequency of the observer; `rollerrig check` prints bandwidth and delay that "
        "are measured on the estimate",
    )


class Observer(BandwidthEstimator):
    """Observer of disturbance (Luenberger)."""

    kind: Literal["observer"] = optional("observer", "observer of disturbance (Luenberger)")
    damping_ratio: Annotated[float, Quantity("1", 0.01, 2.0)] = optional(0.8, "damping ratio of the observer's poles")


class FilteredDerivative(BandwidthEstimator):
    """A filtered derivative of the roller's speed."""

    kind: Literal["filtered_derivative"] = needed("a filtered derivative of the roller's speed")


class KalmanFilter(BandwidthEstimator):
    """A Kalman filter of both speeds, force and torque."""

    kind: Literal["kalman"] = needed("a Kalman filter of both speeds, force and torque")
    speed_noise: Annotated[float, Quantity("rad/s", 1e-12, 1e3)] = optional(
        1e-3, "standard deviation of a measured speed"
    )
    force_change: Annotated[float, Quantity("N", 1e-6, 1e12)] | None = optional(
        None, "standard deviation of the contact force's change over 1 s; absent: from `bandwidth`"
    )
    torque_change: Annotated[float, Quantity("N m", 1e-6, 1e12)] | None = optional(
        None, "standard deviation of the axle torque's change over 1 s; absent: from `bandwidth`"
    )


class ExactEstimator(Estimator):
    """Force and torque that really act, for studies of what estimating costs."""

    kind: Literal["exact"] = needed("force and torque that really act, as on no real rig")


AnyEstimator = Annotated[Observer | FilteredDerivative | KalmanFilter | ExactEstimator, by_kind("observer")]
ESTIMATORS = kinds(AnyEstimator)


class EstimatedTorque(Table):
    """The axle's torque as the estimator finds it, with its lag."""

    kind: Literal["estimated"] = needed("torque as the estimator finds it, with its lag")


class KnownTorque(Table):
    """The axle's torque from cylinder pressure and motor torque, both measured; the estimate corrects it slowly."""

    kind: Literal["known"] = optional("known", "torque from pressure, pad friction and motor; the estimate corrects it")
    correction: Frequency = optional(1.0, "bandwidth of the correction by the estimate")
    brake_friction: Annotated[float, Quantity("1", 0.0, 10.0)] = optional(
        1.0, "friction of the pads as the controller assumes it, over the real one"
    )


class ExtrapolatedTorque(Table):
    """The estimate, run ahead along its slope."""

    kind: Literal["extrapolated"] = needed("torque as the estimator finds it, run ahead along its slope")
    ahead: Delay = optional(8e-3, "time by which it runs ahead")
    bandwidth: Frequency = optional(40.0, "bandwidth of the low-pass on its slope")


AnyAxleTorque = Annotated[EstimatedTorque | KnownTorque | ExtrapolatedTorque, by_kind("known")]


class DirectCommand(Table):
    """The drive is asked for the wanted torque."""

    kind: Literal["direct"] = needed("the wanted torque itself; the drive follows with its lag")


class LeadCommand(Table):
    """The feed-forward runs ahead along its slope by the drive's lag."""

    kind: Literal["lead"] = optional("lead", "the feed-forward runs ahead along its slope")
    ahead: Delay | None = optional(None, "time of the lead; absent: the lag of drive and delay, and one sample")


class TorqueLoop(Table):
    """A loop around the drive, closed over its measured torque."""

    kind: Literal["torque_loop"] = needed("a loop around the drive, closed over its measured torque")
    gain: Annotated[float, Quantity("1", 0.0, 1e3)] = optional(
        2.0, "gain on wanted less measured torque; a drive of first order gets 1 + gain times its bandwidth"
    )


AnyDriveCommand = Annotated[DirectCommand | LeadCommand | TorqueLoop, by_kind("lead")]


class Feedback(Table):
    """What corrects the wheels' speeds, by virtual minus measured axle speed."""

    largest: DriveTorque = optional(2e4, "torque asked of a roller's drive")


class ProportionalIntegral(Feedback):
    """Proportional-integral feedback; gains that are absent follow from bandwidth, damping and inertias."""

    kind: Literal["proportional_integral"] = optional("proportional_integral", "proportional-integral feedback")
    bandwidth: Frequency = optional(0.7, "bandwidth of the loop: far below the estimator, whose errors it is to remove")
    damping_ratio: Annotated[float, Quantity("1", 0.01, 5.0)] = optional(0.7, "damping ratio of the loop")
    proportional: Annotated[float, Quantity("N m s/rad", 0.0, 1e10)] | None = optional(None, "gain")
    integral: Annotated[float, Quantity("N m/rad", 0.0, 1e10)] | None = optional(None, "gain")


class SlidingMode(Feedback):
    """Sliding-mode feedback with a boundary layer."""

    kind: Literal["sliding_mode"] = needed("a switched torque, proportional within a boundary layer")
    switching: Annotated[float, Quantity("N m", 0.0, 1e9)] = optional(1000.0, "torque of the sliding mode")
    boundary_layer: Annotated[float, Quantity("rad/s", 1e-9, 1e3)] = optional(
        0.5, "width of the boundary layer of the sliding mode: it acts in proportion within"
    )


class NoFeedback(Feedback):
    """Feed-forward alone."""

    kind: Literal["none"] = needed("feed-forward alone")


AnyFeedback = Annotated[ProportionalIntegral | SlidingMode | NoFeedback, by_kind("proportional_integral")]


class Protection(Table):
    """Ends a test before rollers and wheels are damaged."""

    slip: Annotated[float, Quantity("m/s", 1e-6, 200.0)] = optional(1.0, "real sliding of wheel on roller ...")
    time: Phase = optional(0.2, "... for longer than this")


class RollerDrive(Motor):
    """Drive of a roller axle: torque and power of the full-scale rig are ours, its speed is that of a published one.

    350 km/h, here at rollers of 725 mm radius, is the largest speed for a bogie on RTRI's Rolling Stock Test Plant of 1959, and
    500 km/h that of its successor of 1990 (Railway Technical Research Institute, news release of 10 August 2021). No published
    figures of torque and power were found that could be stood behind.
    """

    largest_torque: DriveTorque | None = optional(2e4, "largest torque on the roller axle, either way; ours")
    largest_power: DrivePower | None = optional(1e6, "torque times speed of the roller axle, either way; ours")
    largest_speed: DriveSpeed | None = optional(
        134.0, "largest speed of the roller axle, 350 km/h at a radius of 725 mm: beyond it there is no torque"
    )


class Assumed(Table):
    """Numbers in the controller that may differ from the rig's; absent: right."""

    roller_inertia: Inertia | None = optional(None, "inertia of a roller axle about its axis")
    wheelset_inertia: Inertia | None = optional(None, "about its axis")
    roller_radius: RollerRadius | None = optional(None, "radius of the rollers")
    wheel_radius: WheelRadius | None = optional(None, "radius of the wheels")


class RigControl(Controller):
    """Controller of the roller drives: the wheels turn as those of a train on the rail of [adhesion]."""

    sample_time: SampleTime = optional(1e-3, "a multiple of time.sampling_step")
    delay: Delay = optional(0.0, "delay of the command, a multiple of time.sampling_step")
    load_transfer: LoadTransfer = optional(
        "quasi_static",
        "change of the virtual train's axle loads with its acceleration: as geometry and masses of the vehicle "
        "say, not at all, or by [kg] for each axle, N per m/s^2 forward",
    )
    loads: Literal["computed", "measured"] = optional(
        "computed", "loads of the virtual train's axles: static loads and transfer, or what [sensors.axle_load] says"
    )
    locked_speed: Annotated[float, Quantity("m/s", 1e-9, 50.0)] = optional(
        0.1,
        "a wheel that turns slower than this while its train runs faster is locked: its virtual wheel is held with "
        "it, and its brake's torque, then the reaction to the roller's, is not used",
    )
    estimator: AnyEstimator = optional(Observer(), "estimator of the contact force: its kind, or a table")
    axle_torque: AnyAxleTorque = optional(
        KnownTorque(), "torque on an axle that the virtual train takes: its kind, or a table"
    )
    feedback: AnyFeedback = optional(ProportionalIntegral(), "feedback of the axles' speeds: its kind, or a table")
    drive_command: AnyDriveCommand = optional(
        LeadCommand(), "way in which torque is demanded of the drives: its kind, or a table"
    )
    motor: RollerDrive = optional(RollerDrive(), "drive of each roller axle, with its limits")
    protection: Protection = optional(Protection(), "limits that protect the rollers")
    assumed: Assumed = optional(Assumed(), "parameters that the controller assumes")
