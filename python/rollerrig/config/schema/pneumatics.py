"""The air of a friction brake: what fills and vents its cylinders."""

from typing import Annotated, Literal

from pydantic import Discriminator, Field, StrictInt

from rollerrig.config.schema.base import Table, by_kind
from rollerrig.config.schema.train import MOST_AXLES
from rollerrig.config.schema.units import Quantity

Pressure = Annotated[float, Quantity("Pa", 0.0, 1e8)]
Rate = Annotated[float, Quantity("1/s", 1e-4, 1e5)]
Conductance = Annotated[float, Quantity("m^3/(s Pa)", 1e-13, 1e-2)]
Volume = Annotated[float, Quantity("m^3", 1e-10, 10.0)]
DeadTime = Annotated[float, Quantity("s", 0.0, 1.0)]


class UnlimitedAir(Table):
    """A supply that never runs out, behind dump valves that switch at once."""

    kind: Literal["unlimited"] = Field(
        default="unlimited", description="a supply that never runs out, behind dump valves that switch at once"
    )
    fill_rate: Rate = Field(default=6.0, description="choked filling of the cylinder, p'/p_supply, absolute")
    vent_rate: Rate = Field(default=5.0, description="choked venting of the cylinder, -p'/p, absolute")


class ReservoirAir(Table):
    """An auxiliary reservoir, fed by the main pipe, behind dump valves with dead times and orifices after ISO 6358.

    The defaults are ours: of the size of a dump valve of 12 mm nominal width that switches in 20 ms, and of half a coach.
    """

    kind: Literal["reservoir"] = Field(
        description="an auxiliary reservoir fed by the main pipe, behind dump valves with dead times, orifices after ISO 6358"
    )
    fill_conductance: Conductance = Field(
        default=2.5e-7, description="sonic conductance C from the reservoir to one axle's cylinders"
    )
    vent_conductance: Conductance = Field(
        default=2.5e-7, description="sonic conductance C from one axle's cylinders to the ambient"
    )
    critical_ratio: Annotated[float, Quantity("1", 0.0, 0.9)] = Field(
        default=0.3, description="critical pressure ratio b of all orifices"
    )
    relay_band: Annotated[float, Quantity("Pa", 1.0, 1e7)] = Field(
        default=1e4, description="missing cylinder pressure from which the relay valve is wide open"
    )
    opening_time: DeadTime = Field(
        default=0.02, description="dead time of a dump valve's magnet valves, a multiple of time.sampling_step"
    )
    closing_time: DeadTime = Field(default=0.02, description="the same for closing")
    least_pulse: DeadTime = Field(
        default=0.02, description="a magnet valve's command stays at least so long: a shorter one is prolonged"
    )
    reservoir_volume: Volume = Field(default=0.1, description="volume of each auxiliary reservoir")
    axles_per_reservoir: Annotated[StrictInt, Field(ge=1, le=MOST_AXLES)] | None = Field(
        default=None,
        description="axles in a row that share a reservoir, counted from the front: 4 of a coach, 2 of a bogie; absent: all",
    )
    reservoir_pressure: Pressure | None = Field(
        default=None, description="over the ambient, at the start; absent: that of the main pipe"
    )
    main_pipe_pressure: Pressure = Field(default=8.5e5, description="over the ambient")
    charging_conductance: Annotated[float, Quantity("m^3/(s Pa)", 0.0, 1e-2)] = Field(
        default=2e-8,
        description="conductance of the choke between main pipe and reservoir; 0: the reservoir is not fed",
    )
    reference_pressure: Annotated[float, Quantity("Pa", 1.0, 1e8)] = Field(
        default=1e5, description="at which conductances are stated, with 20 degrees C (ISO 8778)"
    )


AnyAir = Annotated[UnlimitedAir | ReservoirAir, Discriminator("kind"), by_kind("unlimited")]
