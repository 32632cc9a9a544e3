"""The vehicle that a run came from, as its own configuration says: names, places, loads.

    run -> [recorded] -> RecordedVehicle -> readings, accelerations

Only the vehicle is read: a file of measured rails that the case names need not be there any more.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass

import xarray as xr

from rollerrig.assembly import static_loads
from rollerrig.config import Cut, Vehicle, VehicleChoice


@dataclass(frozen=True)
class RecordedVehicle:
    """The vehicle of a run, or the part of it that was run.

    Attributes:
        vehicle: the whole vehicle.
        cut: the part that was run.
        friction: coefficient of friction of the contacts [-].
        gravity: its acceleration [m/s^2].
    """

    vehicle: Vehicle
    cut: Cut
    friction: float
    gravity: float

    @property
    def wheelsets(self) -> list[str]:
        """Names of the wheelsets that were run, in the order of the vehicle."""
        return [body.name for body in self.vehicle.bodies_in(self.cut) if body.kind == "wheelset"]

    @property
    def sprung(self) -> list[str]:
        """Names of the free bodies above the wheelsets."""
        return [body.name for body in self.vehicle.bodies_in(self.cut) if body.kind != "wheelset"]

    def place(self, body: str) -> tuple[float, float, float]:
        """Design position of a body from the origin of the run [m]."""
        x, y, z = self.vehicle.body_named(body).position
        return x - self.cut.origin_x, y, z

    def wheel_loads(self) -> dict[str, float]:
        """Wheelset -> static load of each of its wheels, half of the axle load [N]."""
        _, loads = static_loads(self.vehicle, self.gravity)
        return {name: 0.5 * loads[name] for name in self.wheelsets}

    def carriers(self, body: str) -> list[tuple[str, float]]:
        """Bodies that carry a body, foremost first, and the height at which their springs act [m].

        They are joined to it by elements that carry load, and lie lower.
        """
        found: dict[str, float] = {}
        for element in self.vehicle.elements_in(self.cut):
            if not element.carries_load or body not in element.between:
                continue
            other = element.between[1 - element.between.index(body)]
            if self.place(other)[2] < self.place(body)[2]:
                found[other] = element.end_b[2]
        return sorted(found.items(), key=lambda item: -self.place(item[0])[0])


def recorded_vehicle(run: xr.Dataset) -> RecordedVehicle:
    """The vehicle in the configuration of a run."""
    case = tomllib.loads(run.attrs["config_toml"])
    choice = VehicleChoice.model_validate(case["vehicle"])
    return RecordedVehicle(
        choice.data, choice.part, float(case["contact"]["friction"]), float(case.get("gravity", 9.81))
    )
