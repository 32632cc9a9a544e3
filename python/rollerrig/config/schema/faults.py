"""Faults of single axles: what brake or sensor of one axle does otherwise than those of the others."""

from typing import Annotated, Literal

from rollerrig.config.schema.base import Table, by_kind, needed, optional
from rollerrig.config.schema.units import Quantity


class Fault(Table):
    """What every fault has."""

    axle: str = needed("the axle: a wheelset by name, or 'axle_3' of [train.axles]")
    begin: Annotated[float, Quantity("s", 0.0, 1e5)] = optional(0.0, "time from which on it is there")


class NoFault(Fault):
    """A sound axle: what a plan compares the others with."""

    kind: Literal["none"] = needed("a sound axle, for a plan that compares others with it")


class IsolatedBrake(Fault):
    """A brake that is cut off."""

    kind: Literal["isolated"] = needed("the brake is cut off, as by a dump valve that stays open to vent")


class DraggingBrake(Fault):
    """A brake that does not release."""

    kind: Literal["dragging"] = needed("the brake does not release in full, whatever its dump valve does")
    pressure: Annotated[float, Quantity("Pa", 0.0, 1e7)] = optional(1e5, "cylinder pressure that always acts")


class StuckFilling(Fault):
    """A dump valve that never moves."""

    kind: Literal["never_vents"] = needed("the dump valve stays open to fill: the slide protection has no effect")


class OtherPads(Fault):
    """Pads of other friction."""

    kind: Literal["pads"] = needed("pads of other friction: the axle brakes by another torque")
    factor: Annotated[float, Quantity("1", 0.0, 3.0)] = optional(0.8, "friction of its pads over that of the others")


class SilentSensor(Fault):
    """A speed sensor without a signal."""

    kind: Literal["silent_sensor"] = needed("the vehicle's speed sensor reads 0")


class OtherWheels(Fault):
    """Wheels of another radius, as the slide protection sees them."""

    kind: Literal["wheel_radius"] = needed(
        "the axle turns as wheels of another radius do: slide protection takes it for faster or slower; forces stay"
    )
    factor: Annotated[float, Quantity("1", 0.8, 1.25)] = optional(0.97, "radius of its wheels over that of the others")


OF_SENSORS = ("silent_sensor", "wheel_radius")
"""Kinds that need a slide protection."""

AnyFault = Annotated[
    NoFault | IsolatedBrake | DraggingBrake | StuckFilling | OtherPads | SilentSensor | OtherWheels,
    by_kind(),
]


def fault_text(fault: AnyFault) -> str:
    """The fault in words: 'wheelset_2, pads × 0.8, from 0 s on'."""
    size = f" × {fault.factor:g}" if hasattr(fault, "factor") else ""
    size = f" at {1e-5 * fault.pressure:g} bar" if hasattr(fault, "pressure") else size
    return f"{fault.axle}, {fault.kind.replace('_', ' ')}{size}, from {fault.begin:g} s on"
