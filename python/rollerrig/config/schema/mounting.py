"""How roller axles and rails are mounted where they are not rigid."""

from pydantic import Field, model_validator

from rollerrig.config.schema.base import Table, refused
from rollerrig.config.schema.units import (
    Angle,
    AngularDamping,
    Damping,
    Mass,
    Position,
    PositiveAngularStiffness,
    PositiveStiffness,
)
from rollerrig.config.schema.vehicle import Name


class LinearSupport(Table):
    """Elastic support along one axis."""

    stiffness: PositiveStiffness = Field(description="stiffness")
    damping: Damping = Field(default=0.0, description="damping")


class AngularSupport(Table):
    """Elastic support about one axis."""

    stiffness: PositiveAngularStiffness = Field(description="stiffness")
    damping: AngularDamping = Field(default=0.0, description="damping")


class Mounting(Table):
    """How a roller axle is mounted; what is absent is rigid."""

    lateral: LinearSupport | None = Field(default=None, description="elastic support along y")
    vertical: LinearSupport | None = Field(default=None, description="elastic support along z")
    yaw: AngularSupport | None = Field(default=None, description="elastic support about z")
    misalignment: tuple[Angle, ...] = Field(
        default=(),
        max_length=64,
        description="angle about z at which the roller axles of the first, second, ... wheelset are mounted, positive to the "
        "left; those not named stand square; needs `yaw`",
    )

    @model_validator(mode="after")
    def _can_turn(self) -> "Mounting":
        if any(self.misalignment) and self.yaw is None:
            raise refused("yaw", "needed: the support about z of a roller axle that is mounted askew")
        return self

    @property
    def laws(self) -> dict[str, LinearSupport | AngularSupport]:
        """The supports that are given, by direction."""
        given = {"y": self.lateral, "z": self.vertical, "yaw": self.yaw}
        return {direction: support for direction, support in given.items() if support is not None}


class Restraint(Table):
    """A coupler rod from a vehicle to the ground: spring and damper along the track, which hold it on top of the rollers."""

    height: Position = Field(description="of the rod above the crowns")
    stiffness: PositiveStiffness = Field(description="of the rod with its anchorage, along the track")
    damping: Damping = Field(default=0.0, description="of the same")
    body: Name | None = Field(default=None, description="that it holds; absent: the heaviest that is no wheelset")


class Foundation(Table):
    """Rails on an elastic foundation: under each wheel a piece of rail that moves along with it; what is absent is rigid."""

    rail_mass: Mass = Field(description="mass of the piece of rail under one wheel, with what moves with it")
    lateral: LinearSupport | None = Field(default=None, description="elastic support of one rail along y")
    vertical: LinearSupport | None = Field(default=None, description="elastic support of one rail along z")

    @model_validator(mode="after")
    def _moves(self) -> "Foundation":
        if self.lateral is None and self.vertical is None:
            raise refused(
                "lateral", "needed: a support along y or z; without both leave out the foundation, the rails are rigid"
            )
        return self

    @property
    def laws(self) -> dict[str, LinearSupport]:
        """The supports that are given, by direction."""
        given = {"y": self.lateral, "z": self.vertical}
        return {direction: support for direction, support in given.items() if support is not None}
