"""The train of which the axles under test brake or pull their part."""

from itertools import pairwise
from typing import Annotated

from pydantic import Field, StrictInt, model_validator

from rollerrig.config.schema.base import Table, refused
from rollerrig.config.schema.units import Mass, Quantity

MOST_AXLES = 8
"""That have sensors, actuators and controllers; the core's `most_axles`."""


class TrainAxles(Table):
    """All axles of the train. Those that are not under test are simulated: same wheels, creep law, brake, slide protection."""

    positions: tuple[Annotated[float, Quantity("m", 0.0, 1e4)], ...] = Field(
        description="distance of each axle behind the first one, in order"
    )
    under_test: tuple[Annotated[StrictInt, Field(ge=1, le=MOST_AXLES)], ...] = Field(
        description="which of them are those of [vehicle]: on rollers, or on track in the 3-D model; the first axle is 1"
    )
    loads: tuple[Annotated[float, Quantity("N", 1.0, 1e7)], ...] | None = Field(
        default=None, description="loads of each simulated axle, in order; absent: the mean of the axles under test"
    )
    load_transfer: tuple[Annotated[float, Quantity("kg", -1e6, 1e6)], ...] | None = Field(
        default=None,
        description="change of each simulated axle's load per acceleration of the train, forward; absent: none",
    )

    @model_validator(mode="after")
    def _in_order(self) -> "TrainAxles":
        n, m = len(self.positions), len(self.under_test)
        if not 1 <= n <= MOST_AXLES:
            raise refused("positions", f"allowed: 1 to {MOST_AXLES} axles; given are {n}")
        if self.positions[0] != 0.0 or any(not a < b for a, b in pairwise(self.positions)):
            raise refused("positions", "allowed: distances behind the first axle, which begin at 0 and increase")
        if not 1 <= m <= n:
            raise refused("under_test", f"allowed: 1 to {n} axles, no more than the train has; given are {m}")
        if any(not 1 <= k <= n for k in self.under_test) or any(not a < b for a, b in pairwise(self.under_test)):
            raise refused("under_test", f"allowed: numbers from 1 to {n} that increase, each axle once")
        for key in ("loads", "load_transfer"):
            given = getattr(self, key)
            if given is not None and len(given) != n - m:
                raise refused(key, f"allowed: one number for each simulated axle, {n - m}; given are {len(given)}")
        return self

    @property
    def simulated(self) -> tuple[int, ...]:
        """Numbers of the axles that are not under test."""
        return tuple(k for k in range(1, len(self.positions) + 1) if k not in self.under_test)


class Train(Table):
    """The train of which the axles under test brake or pull their part: it runs on a track, on a rig it is reproduced."""

    mass: Mass | None = Field(default=None, description="that these axles brake or pull; absent: what they carry")
    resistance_constant: Annotated[float, Quantity("N", 0.0, 1e8)] = Field(
        default=0.0,
        description="A in the part of the running resistance that these axles overcome, R = A + B v + C v^2",
    )
    resistance_linear: Annotated[float, Quantity("N s/m", 0.0, 1e6)] = Field(default=0.0, description="B")
    resistance_quadratic: Annotated[float, Quantity("N s^2/m^2", 0.0, 1e6)] = Field(default=0.0, description="C")
    gradient: Annotated[float, Quantity("1", -0.1, 0.1)] = Field(default=0.0, description="positive uphill")
    axles: TrainAxles | None = Field(
        default=None, description="the train's axles, of which some are under test; absent: all of them are"
    )
    brake_signal_speed: Annotated[float, Quantity("m/s", 10.0, 1e4)] | None = Field(
        default=None,
        description="at which the brake demand runs along the main pipe, from the train's first axle; absent: everywhere at once",
    )
