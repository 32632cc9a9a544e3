"""What controllers see: speeds of axles and rollers, torques and loads."""

from typing import Annotated, Literal

from pydantic import Discriminator, Field

from rollerrig.config.schema.actuators import Frequency
from rollerrig.config.schema.base import Table, by_kind
from rollerrig.config.schema.units import Quantity


class Encoder(Table):
    """Incremental encoder: speed from counts."""

    kind: Literal["encoder"] = Field(default="encoder", description="incremental encoder: speed from counts")
    counts: Annotated[float, Quantity("1", 0.0, 1e7)] = Field(default=0.0, description="per turn; 0: exact speeds")
    jitter: Annotated[float, Quantity("1", 0.0, 100.0)] = Field(
        default=0.0, description="deviation of edges, in counts"
    )
    window: Annotated[int, Field(strict=True, ge=1, le=16)] = Field(
        default=1, description="samples over which counts are differenced, 1 to 16"
    )


class PhonicWheel(Table):
    """Toothed wheel with one pick-up; a magnitude, it does not tell the direction."""

    teeth: Annotated[float, Quantity("1", 1.0, 1e5)] = Field(default=100.0, description="around the phonic wheel")
    pitch_error: Annotated[float, Quantity("1", 0.0, 0.1)] = Field(
        default=0.0, description="standard deviation of a tooth's place, in pitches; the same in each turn"
    )


class PulsePeriod(PhonicWheel):
    """Speed from the time between edges of a phonic wheel."""

    kind: Literal["pulse_period"] = Field(description="phonic wheel: speed from the time between edges")
    averaging_time: Annotated[float, Quantity("s", 0.0, 1.0)] = Field(
        default=5e-3, description="edges are timed over at least so long; 0: from sample to sample"
    )
    timeout: Annotated[float, Quantity("s", 1e-3, 100.0)] = Field(
        default=0.3, description="without an edge for so long the axle counts as standing"
    )
    clock: Annotated[float, Quantity("Hz", 0.0, 1e12)] = Field(
        default=1e6, description="that times the edges; 0: exactly"
    )


class PulseFrequency(PhonicWheel):
    """Speed from the number of edges of a phonic wheel in a gate time."""

    kind: Literal["pulse_frequency"] = Field(description="phonic wheel: speed from the number of edges in a gate time")
    gate_time: Annotated[float, Quantity("s", 1e-4, 10.0)] = Field(
        default=0.1,
        description="edges are counted over at least so long; speed comes in steps of one edge per gate time",
    )


AnySpeedSensor = Annotated[Encoder | PulsePeriod | PulseFrequency, Discriminator("kind"), by_kind("encoder")]


class ForceSensor(Table):
    """Transducer of a force [N] or a torque [N m]: lag, then noise, resolution and range of each reading."""

    bandwidth: Frequency | None = Field(default=None, description="bandwidth of first order; absent: no lag")
    noise: Annotated[float, Quantity("1", 0.0, 1e9)] = Field(
        default=0.0, description="standard deviation of a reading, in N or N m"
    )
    resolution: Annotated[float, Quantity("1", 0.0, 1e9)] = Field(
        default=0.0, description="resolution of a reading, in N or N m; 0: none"
    )
    range: Annotated[float, Quantity("1", 1e-6, 1e9)] | None = Field(
        default=None, description="largest reading, in N or N m; absent: no limit"
    )


class Sensors(Table):
    """What controllers see of speeds, torques and loads."""

    axles: AnySpeedSensor = Field(
        default=Encoder(), description="the rig's own on each axle of the vehicle: its kind, or a table"
    )
    rollers: AnySpeedSensor = Field(default=Encoder(), description="on each roller axle: its kind, or a table")
    vehicle: AnySpeedSensor | None = Field(
        default=None,
        description="the vehicle's own on each axle, for its slide protection and wheel-slip control: its kind, or a table; "
        "absent: they see what `axles` does",
    )
    roller_torque: ForceSensor | None = Field(
        default=None, description="torque flange in the drive shaft of each roller axle; absent: its torque is known"
    )
    axle_load: ForceSensor = Field(
        default=ForceSensor(), description="vertical force on the rollers (or rails) under each axle"
    )
    seed: Annotated[int, Field(strict=True, ge=0, le=2**31)] = Field(default=1, description="seed of all noise")
