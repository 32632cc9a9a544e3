"""Traction motors that brake: their characteristic, and how the friction brake fills what they do not give."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Discriminator, Field, model_validator

from rollerrig.config.schema.base import Table, by_kind, in_order, refused
from rollerrig.config.schema.units import Quantity

BrakeForce = Annotated[float, Quantity("N", 0.0, 1e8)]
Share = Annotated[float, Quantity("1", 0.0, 1.0)]
FactorRate = Annotated[float, Quantity("1/s", 0.0, 1e4)]
BrakeSpeed = Annotated[float, Quantity("m/s", 0.0, 1e3)]
ForceOverSpeed = Annotated[tuple[tuple[BrakeSpeed, BrakeForce], ...], AfterValidator(in_order), Field(min_length=2)]


class ElectrodynamicBrake(Table):
    """What every electrodynamic brake has: its axles, its lag, and its place beside friction brake and slide protection."""

    axles: tuple[str, ...] | None = Field(
        default=None, min_length=1, description="wheelsets with a motor that brakes, by name; absent: all"
    )
    share: Share = Field(
        default=1.0, description="share of the torque asked of the axle, at most; friction gives the rest"
    )
    time_constant: Annotated[float, Quantity("s", 1e-4, 100.0)] = Field(
        default=0.1, description="time constant of the torque"
    )
    blending_delay: Annotated[float, Quantity("s", 0.0, 10.0)] = Field(
        default=0.2,
        description="blending delay from the motor's torque to the pneumatic demand that allows for it, a multiple of "
        "time.sampling_step; the control valve's rates follow",
    )
    on_slide: Literal["keep", "reduce", "switch_off"] = Field(
        default="reduce",
        description="while slide protection vents the axle's cylinder: keep the torque; take it off and give it back, and the "
        "friction brake does not fill the gap; or switch off until the brake is released, and the friction brake takes over",
    )
    reduction_rate: FactorRate = Field(
        default=5.0, description="reduction rate of the factor on the torque while the cylinder is vented"
    )
    restoring_rate: FactorRate = Field(
        default=1.0, description="restoring rate of the factor on the torque while it is filled"
    )


class ConstantPowerBrake(ElectrodynamicBrake):
    """Constant force, constant power, fading at low speed; the defaults are ours, of the size of a multiple unit's axle."""

    kind: Literal["constant_power"] = Field(
        default="constant_power", description="constant force, constant power, fading at low speed"
    )
    largest_force: BrakeForce = Field(
        default=15e3, description="largest force of one axle at the wheels' circumference"
    )
    largest_power: Annotated[float, Quantity("W", 0.0, 1e9)] = Field(
        default=300e3, description="largest power of one axle"
    )
    fade_from: BrakeSpeed = Field(default=10.0 / 3.6, description="below this speed the force fades ...")
    fade_to: BrakeSpeed = Field(default=3.0 / 3.6, description="... along a straight line, to nothing here")

    @model_validator(mode="after")
    def _does_not_cross(self) -> "ConstantPowerBrake":
        if not self.fade_to < self.fade_from:
            raise refused("fade_to", f"allowed: below fade_from, {self.fade_from:g} m/s")
        corner = self.largest_power / self.largest_force if self.largest_force > 0.0 else self.fade_from
        if corner < self.fade_from:
            allowed = f"allowed: at least largest_force times fade_from, {self.largest_force * self.fade_from:g} W: at less the "
            raise refused("largest_power", f"{allowed}curve of constant power crosses the fading at {corner:.3g} m/s")
        return self


class ForceTableBrake(ElectrodynamicBrake):
    """Points of the diagram of force over speed."""

    kind: Literal["table"] = Field(description="points of the diagram of force over speed")
    forces: ForceOverSpeed = Field(
        description="rows [speed of the wheels' circumference, largest force of one axle]; linear between, constant beyond"
    )


AnyElectrodynamicBrake = Annotated[
    ConstantPowerBrake | ForceTableBrake, Discriminator("kind"), by_kind("constant_power")
]
