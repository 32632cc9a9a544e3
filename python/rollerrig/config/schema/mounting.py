"""How roller axles and rails are mounted where they are not rigid."""

from typing import Annotated

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
    Quantity,
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
            raise refused("yaw", "needed: the support about z of a roller axle with a yaw misalignment")
        return self

    @property
    def laws(self) -> dict[str, LinearSupport | AngularSupport]:
        """The supports that are given, by direction."""
        given = {"y": self.lateral, "z": self.vertical, "yaw": self.yaw}
        return {direction: support for direction, support in given.items() if support is not None}


class Restraint(Table):
    """A coupler rod from a vehicle to the ground: spring and damper along the track, which hold it on top of the rollers."""

    height: Position = Field(description="height of the rod above the crowns")
    stiffness: PositiveStiffness = Field(description="stiffness of the rod with its anchorage, along the track")
    damping: Damping = Field(default=0.0, description="damping of the same")
    body: Name | None = Field(default=None, description="that it holds; absent: the heaviest that is no wheelset")


class Sleeper(Table):
    """Half a sleeper under each piece of rail, on ballast; the supports of the foundation are then those of the rail pad."""

    mass: Mass = Field(default=150.0, description="mass of the moving share of the sleepers under one wheel")
    lateral: LinearSupport | None = Field(default=None, description="ballast along y; absent: rigid")
    vertical: LinearSupport | None = Field(default=None, description="ballast along z; absent: rigid")

    @model_validator(mode="after")
    def _moves(self) -> "Sleeper":
        if not self.laws:
            raise refused("vertical", "needed: ballast along y or z; without both leave out the sleeper")
        return self

    @property
    def laws(self) -> dict[str, LinearSupport]:
        """The supports that are given, by direction."""
        given = {"y": self.lateral, "z": self.vertical}
        return {direction: support for direction, support in given.items() if support is not None}


class Foundation(Table):
    """Rails on an elastic foundation: under each wheel a piece of rail that moves along with it; what is absent is rigid.

    docs/how_to/flexible_rails.md says when to use it, and where the values of the catalogue's `flexible_track` come from.
    """

    rail_mass: Mass = Field(
        default=150.0, description="mass of the piece of rail under one wheel, with what moves with it"
    )
    lateral: LinearSupport | None = Field(default=None, description="elastic support of one rail's foot along y")
    vertical: LinearSupport | None = Field(default=None, description="elastic support of one rail's foot along z")
    roll: AngularSupport | None = Field(default=None, description="elastic support of one rail about its foot")
    rail_height: Annotated[float, Quantity("m", 0.01, 1.0)] = Field(
        default=0.172, description="top of rail over foot: lever arm of the lateral force"
    )
    sleeper: Sleeper | None = Field(
        default=None, description="a second layer between the supports and the ground; absent: none"
    )

    @model_validator(mode="after")
    def _moves(self) -> "Foundation":
        if not self.laws:
            raise refused(
                "lateral",
                "needed: a support along y, z or about the foot, as flexible_track has them; without any leave it out",
            )
        return self

    @property
    def laws(self) -> dict[str, LinearSupport | AngularSupport]:
        """The supports that are given, by direction."""
        given = {"y": self.lateral, "z": self.vertical, "roll": self.roll}
        return {direction: support for direction, support in given.items() if support is not None}

    @property
    def centre_height(self) -> float:
        """Height of the rail's centre of mass over its foot [m]: 81 of 172 mm in a 60E1."""
        return 0.47 * self.rail_height

    @property
    def roll_inertia(self) -> float:
        """Inertia of the rail about its centre of mass [kg m^2]: radius of gyration 68 of 172 mm in a 60E1."""
        return self.rail_mass * (0.395 * self.rail_height) ** 2
