"""Sand on the rail: from where or when, how much, and what it makes of the rail's adhesion."""

from typing import Annotated, Literal

from pydantic import Discriminator, Field, model_validator

from rollerrig.config.schema.adhesion import AnyCondition, Condition
from rollerrig.config.schema.base import Table, by_kind, refused
from rollerrig.config.schema.contact_law import FallingFriction
from rollerrig.config.schema.units import Quantity

Duration = Annotated[float, Quantity("s", 0.0, 1e6)]
Place = Annotated[float, Quantity("m", 0.0, 1e6)]


class SandOnSlide(Table):
    """While slide protection vents an axle, or wheel-slip control takes torque off one."""

    kind: Literal["on_slide"] = Field(
        default="on_slide",
        description="while slide protection vents an axle or wheel-slip control takes torque off one",
    )


class SandFromDistance(Table):
    """Sand from a place on."""

    kind: Literal["from_distance"] = Field(description="sand from a place on")
    begin: Place = Field(description="distance of the train since the start")
    end: Place = Field(default=1e6, description="end of sanding")

    @model_validator(mode="after")
    def _in_order(self) -> "SandFromDistance":
        if not self.begin < self.end:
            raise refused("end", f"allowed: beyond begin, {self.begin:g} m")
        return self


class SandFromTime(Table):
    """Sand from a time on, as a driver switches it."""

    kind: Literal["from_time"] = Field(description="sand from a time on, as a driver switches it")
    begin: Duration = Field(description="time of the run")
    end: Duration = Field(default=1e6, description="end of sanding")

    @model_validator(mode="after")
    def _in_order(self) -> "SandFromTime":
        if not self.begin < self.end:
            raise refused("end", f"allowed: after begin, {self.begin:g} s")
        return self


AnySandingStart = Annotated[SandOnSlide | SandFromDistance | SandFromTime, Discriminator("kind"), by_kind("on_slide")]


class Sanding(Table):
    """Sand in front of some axles: they and all axles behind them find it on the rail. All numbers are ours."""

    start: AnySandingStart = Field(default=SandOnSlide(), description="when sand is wanted: its kind, or a table")
    axles: tuple[str, ...] | None = Field(
        default=None,
        min_length=1,
        description="wheelsets in front of which sand falls, by name; absent: the leading one",
    )
    delay: Annotated[float, Quantity("s", 0.0, 10.0)] = Field(
        default=0.5,
        description="delay from the wish to the sand on the rail, and back, a multiple of time.sampling_step",
    )
    run_on: Duration = Field(default=1.0, description="sand is wanted for so long after its reason has gone")
    flow: Annotated[float, Quantity("kg/s", 1e-9, 100.0)] = Field(
        default=0.01, description="on each rail in front of one axle"
    )
    least_speed: Annotated[float, Quantity("m/s", 0.0, 1e3)] = Field(
        default=2.0, description="a slower train gets none"
    )
    saturation: Annotated[float, Quantity("kg/m", 1e-9, 100.0)] = Field(
        default=5e-4, description="mass per length of rail that brings 63 % of the effect, q_0 in 1 - exp(-q/q_0)"
    )
    kept: Annotated[float, Quantity("1", 0.0, 1.0)] = Field(
        default=0.7, description="share of the sand under it that a wheel leaves on the rail"
    )
    rail: AnyCondition = Field(
        default=Condition(friction=FallingFriction(kind="falling", mu_0=0.25, A=0.6, B=0.2), k_A=0.3, k_S=0.1),
        description="condition of a rail with much sand: dry, wet, low, very_low, or a table",
    )
