"""Parts of an assembled model by the core's indices: its wheels, and what acts on an axle."""

from __future__ import annotations

from dataclasses import dataclass

ABSENT = -1


@dataclass(frozen=True)
class WheelInfo:
    """One wheel of the assembled model."""

    name: str
    wheelset: str
    side: str
    contact: int


@dataclass(frozen=True)
class AxleActuators:
    """Indices in the core's model of what acts on one axle; ABSENT where there is none."""

    wheelset: int
    contacts: tuple[int, ...]
    x: float
    """Design position along the vehicle [m]."""
    brake: int = ABSENT
    axle_torque: int = ABSENT
    roller: int = ABSENT
    roller_torque: int = ABSENT
    electrodynamic: bool = False
    sands: bool = False
