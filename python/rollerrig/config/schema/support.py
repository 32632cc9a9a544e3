"""What the wheels stand on: the rollers of a rig, or a track."""

import math
from typing import Annotated, Literal

from pydantic import Discriminator, Field, RootModel, StrictBool, model_validator

from rollerrig.config.schema.base import Table, refused
from rollerrig.config.schema.irregularity import AnyIrregularity
from rollerrig.config.schema.mounting import Mounting, Restraint
from rollerrig.config.schema.profile import AnyProfile
from rollerrig.config.schema.track import Curve, Gauge, GaugeDepth, Straight, Track
from rollerrig.config.schema.units import Inertia, Mass, Quantity, RollerRadius
from rollerrig.config.schema.vehicle import Name


class Spot(Table):
    """A worn or out-of-round spot of the rollers, at the same place of all of them; ramps join it to the rest of the crown."""

    start: Annotated[float, Quantity("m", 0.0, 100.0)] = Field(
        default=0.5, description="way that the crown runs until the spot first comes under the wheel"
    )
    length: Annotated[float, Quantity("m", 0.0, 100.0)] = Field(description="along the crown, between the ramps")
    ramp: Annotated[float, Quantity("m", 1e-3, 100.0)] = Field(description="length of each ramp")
    depth: Annotated[float, Quantity("m", -0.01, 0.01)] = Field(
        default=0.0, description="depth by which its radius is less"
    )
    profile: AnyProfile | None = Field(default=None, description="its generatrix; absent: that of the roller")
    sides: Literal["both", "left", "right"] = Field(default="both", description="which rollers have it")


class Rig(Table):
    """A roller rig: under each wheelset a pair of rollers on one axis, parallel to y, under the wheelset's axle."""

    kind: Literal["rig"] = Field(description="rollers")
    name: Name = Field(description="name of the rig")
    description: str = Field(default="", description="one line about the rig")
    source: str = Field(default="", description="where the data come from")
    profile: AnyProfile = Field(description="generatrix of the left roller: a rail head")
    right_profile: AnyProfile | None = Field(
        default=None, description="generatrix of the right roller, as a left one would have it; absent: the same"
    )
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
        description="steering of the rollers: with an irregularity they also turn about z into the direction of "
        "the rail they represent, as real rails do; false: they are only moved sideways and up",
    )

    spot: Spot | None = Field(default=None, description="worn or out-of-round spot; absent: rollers are round")

    @model_validator(mode="after")
    def _spot_on_the_roller(self) -> "Rig":
        round_it = 2.0 * math.pi * self.roller_radius
        if self.spot is not None and self.spot.start + self.spot.length + 2.0 * self.spot.ramp > round_it:
            raise refused("spot", f"allowed: start, both ramps and length within one turn, {round_it:.4g} m")
        return self

    @model_validator(mode="after")
    def _possible_inertia(self) -> "Rig":
        x, spin, z = self.roller_inertia
        if abs(x - z) > 1e-9 * x or spin > (x + z) * (1 + 1e-6):
            raise refused("roller_inertia", "allowed: a body of revolution, [I, I_spin, I] with I_spin at most 2 I")
        return self


Side = Literal["left", "right"]


def heads(support: Track | Rig, segment: Straight | Curve | None = None) -> dict[Side, AnyProfile]:
    """Profiles of the rails or rollers of both sides, each as a left one has it; of a track also on one of its segments."""
    left, right = support.profile, support.right_profile or support.profile
    if segment is None:
        return {"left": left, "right": right}
    return {"left": segment.profile or left, "right": segment.right_profile or segment.profile or right}


AnySupport = Annotated[Rig | Track, Discriminator("kind")]


class SupportRoot(RootModel[AnySupport]):
    """A support of either kind, as a file of its own."""
