"""What the wheels stand on: the rollers of a rig, or a straight track."""

from typing import Annotated, Literal

from pydantic import Discriminator, Field, model_validator
from pydantic_core import PydanticCustomError

from rollerrig.config.base import Table
from rollerrig.config.profile import AnyProfile
from rollerrig.config.units import (
    AngularDamping,
    Damping,
    Inertia,
    Mass,
    PositiveAngularStiffness,
    PositiveStiffness,
    Quantity,
)
from rollerrig.config.vehicle import Name

Gauge = Annotated[float, Quantity("m", gt=0.1, le=5.0)]
GaugeDepth = Annotated[float, Quantity("m", gt=0, le=0.05)]


class LinearSupport(Table):
    """Elastic support of a roller axle along one axis."""

    stiffness: PositiveStiffness = Field(description="stiffness")
    damping: Damping = Field(default=0.0, description="damping")


class AngularSupport(Table):
    """Elastic support of a roller axle about one axis."""

    stiffness: PositiveAngularStiffness = Field(description="stiffness")
    damping: AngularDamping = Field(default=0.0, description="damping")


class Mounting(Table):
    """How a roller axle is carried; what is absent is rigid."""

    lateral: LinearSupport | None = Field(default=None, description="elastic support along y")
    vertical: LinearSupport | None = Field(default=None, description="elastic support along z")
    yaw: AngularSupport | None = Field(default=None, description="elastic support about z")


class Rig(Table):
    """A roller rig: under each wheelset a pair of rollers on one axis, parallel to y, under the wheelset's axle."""

    kind: Literal["rig"] = Field(description="rollers")
    name: Name = Field(description="name of the rig")
    description: str = Field(default="", description="one line about the rig")
    source: str = Field(default="", description="where the data come from")
    profile: AnyProfile = Field(description="generatrix of the left roller: a rail head")
    gauge: Gauge = Field(default=1.435, description="distance between the gauge sides of the two rollers")
    gauge_depth: GaugeDepth = Field(default=0.014, description="depth below the crown at which the gauge is taken")
    roller_radius: Annotated[float, Quantity("m", ge=0.05, le=1e6)] = Field(description="radius at the crown")
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

    @model_validator(mode="after")
    def _possible_inertia(self) -> "Rig":
        x, spin, z = self.roller_inertia
        if abs(x - z) > 1e-9 * x or spin > (x + z) * (1 + 1e-6):
            allowed = "allowed: a body of revolution, [I, I_spin, I] with I_spin at most 2 I"
            raise PydanticCustomError("at_key", "{allowed}", {"allowed": allowed, "key": "roller_inertia"})
        return self


class Track(Table):
    """A straight, rigid track: the rig's limit of an infinite roller radius."""

    kind: Literal["track"] = Field(description="straight rails")
    name: Name = Field(description="name of the track")
    description: str = Field(default="", description="one line about the track")
    source: str = Field(default="", description="where the data come from")
    profile: AnyProfile = Field(description="head of the left rail")
    gauge: Gauge = Field(default=1.435, description="distance between the gauge sides of the two rails")
    gauge_depth: GaugeDepth = Field(
        default=0.014, description="depth below the top of rail at which the gauge is taken"
    )


AnySupport = Annotated[Rig | Track, Discriminator("kind")]
