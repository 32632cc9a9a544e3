"""Brakes that act on the rail: magnets of each bogie, rubbing on it or over it."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Discriminator, Field

from rollerrig.config.schema.base import Table, by_kind, in_order
from rollerrig.config.schema.contact_law import AnyFriction, FallingFriction
from rollerrig.config.schema.units import Quantity, Time

Excitation = Annotated[
    tuple[tuple[Time, Annotated[float, Quantity("1", 0.0, 1.0)]], ...], AfterValidator(in_order), Field(min_length=1)
]
MagnetForce = Annotated[float, Quantity("N", 0.0, 1e8)]


class TrackBrake(Table):
    """What every track brake has: when it is on."""

    demand: Excitation = Field(description="rows [time, excitation asked for, 0 to 1]; linear between")
    delay: Annotated[float, Quantity("s", 0.0, 1e3)] = Field(
        default=0.5, description="delay from the demand to the first force: the magnets are lowered"
    )
    rise_time: Annotated[float, Quantity("s", 1e-4, 1e3)] = Field(
        default=0.5, description="rise time of the excitation, from none to full"
    )
    release_speed: Annotated[float, Quantity("m/s", 0.0, 1e3)] = Field(
        default=0.0, description="a slower train has the magnets lifted"
    )


class MagneticTrackBrake(TrackBrake):
    """Magnets that rub on the rail; the numbers are ours, of the size of two magnets of 1 m on each bogie."""

    kind: Literal["magnetic"] = Field(default="magnetic", description="magnets that are lowered and rub on the rail")
    attraction: MagnetForce = Field(
        default=160e3,
        description="attraction of all magnets of one bogie together; between magnet and rail, it loads no wheel",
    )
    friction: AnyFriction = Field(
        default=FallingFriction(kind="falling", mu_0=0.20, A=0.35, B=0.1),
        description="friction coefficient of pole shoes over speed: a number, or a law; the state of the rail is not part of it",
    )
    regularisation_speed: Annotated[float, Quantity("m/s", 1e-6, 10.0)] = Field(
        default=0.05, description="below it friction turns into viscous drag"
    )


class EddyCurrentTrackBrake(TrackBrake):
    """Magnets over the rail that do not touch it; the curve over a critical speed is Wouterse's, the numbers are ours."""

    kind: Literal["eddy_current"] = Field(description="magnets over the rail that do not touch it: eddy currents brake")
    largest_force: MagnetForce = Field(default=15e3, description="largest force of one bogie, at the critical speed")
    critical_speed: Annotated[float, Quantity("m/s", 1e-3, 1e3)] = Field(
        default=25.0, description="at which the force is largest"
    )


AnyTrackBrake = Annotated[MagneticTrackBrake | EddyCurrentTrackBrake, Discriminator("kind"), by_kind("magnetic")]
