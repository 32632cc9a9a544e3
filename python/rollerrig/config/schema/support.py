"""What the wheels stand on: the rollers of a rig, or a track."""

from typing import Annotated, Literal

from pydantic import Discriminator, Field, RootModel, StrictBool, model_validator

from rollerrig.config.schema.base import Table, refused
from rollerrig.config.schema.irregularity import AnyIrregularity
from rollerrig.config.schema.mounting import Mounting, Restraint
from rollerrig.config.schema.profile import AnyProfile
from rollerrig.config.schema.track import Gauge, GaugeDepth, Track
from rollerrig.config.schema.units import Inertia, Mass, RollerRadius
from rollerrig.config.schema.vehicle import Name


class Rig(Table):
    """A roller rig: under each wheelset a pair of rollers on one axis, parallel to y, under the wheelset's axle."""

    kind: Literal["rig"] = Field(description="rollers")
    name: Name = Field(description="name of the rig")
    description: str = Field(default="", description="one line about the rig")
    source: str = Field(default="", description="where the data come from")
    profile: AnyProfile = Field(description="generatrix of the left roller: a rail head")
    gauge: Gauge = Field(default=1.435, description="distance between the gauge sides of the two rollers")
    gauge_depth: GaugeDepth = Field(default=0.014, description="depth below the crown at which the gauge is taken")
    roller_radius: RollerRadius = Field(description="radius at the crown")
    roller_mass: Mass = Field(description="mass of a pair of rollers with their axle")
    roller_inertia: tuple[Inertia, Inertia, Inertia] = Field(
        description="moments of inertia of a pair about x, y (spin) and z through its centre"
    )
    coupling: Literal["axle", "independent"] = Field(
        default="axle", description="axle: left and right turn as one; independent: each with half of the spin inertia"
    )
    mounting: Mounting | None = Field(
        default=None, description="elastic support of the roller axles; absent: they only spin"
    )
    restraint: Restraint | None = Field(
        default=None,
        description="a coupler rod that holds a vehicle along the track which nothing else holds; absent: there is none",
    )
    irregularity: AnyIrregularity | None = Field(
        default=None,
        description="irregularities of a track that actuators feed to the wheels by moving the rollers; absent: none",
    )
    steered: StrictBool = Field(
        default=True,
        description="with an irregularity the rollers also turn about z into the direction of the rail they stand for, as "
        "real rails do; false: they are only moved sideways and up",
    )

    @model_validator(mode="after")
    def _possible_inertia(self) -> "Rig":
        x, spin, z = self.roller_inertia
        if abs(x - z) > 1e-9 * x or spin > (x + z) * (1 + 1e-6):
            raise refused("roller_inertia", "allowed: a body of revolution, [I, I_spin, I] with I_spin at most 2 I")
        return self


AnySupport = Annotated[Rig | Track, Discriminator("kind")]


class SupportRoot(RootModel[AnySupport]):
    """A support of either kind, as a file of its own."""
