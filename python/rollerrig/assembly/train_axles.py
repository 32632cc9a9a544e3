"""The axles of the train: those under test, in the order of the model, then those that are only simulated.

Case, AssembledModel -> [train_axles] -> names, loads, places, brake demand and air; _core.SimulatedAxles
"""

from typing import Any

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel
from rollerrig.config.schema.brakes import ReservoirAir


def axle_loads(model: AssembledModel) -> list[float]:
    """Static load of each axle of the train, as `model.axle_names` [N]."""
    tested = [*model.axle_loads.values()]
    table = model.case.train.axles
    if table is None:
        return tested
    others = table.loads or [sum(tested) / len(tested)] * len(table.simulated)
    return [*tested, *others]


def axle_places(model: AssembledModel) -> list[float]:
    """Design position of each axle of the model along the vehicle [m]."""
    return [model.positions[name][0] for name in model.wheelsets]


def train_mass(model: AssembledModel) -> float:
    """What all axles of the train brake or pull [kg]."""
    return model.case.train.mass or sum(axle_loads(model)) / model.case.gravity


def simulated_axles(model: AssembledModel, wheelset_inertia: float) -> _core.SimulatedAxles:
    """The axles that are not in the model.

    Args:
        model: assembled with its actuators.
        wheelset_inertia: about the axle, with the rotor of its motor [kg m^2].
    """
    case = model.case
    table = case.train.axles
    first = max(axle_places(model))
    return _core.SimulatedAxles(
        wheelset_inertia=wheelset_inertia,
        wheel_radius=case.vehicle.data.wheel.radius,
        gradient_force=case.gravity * case.train.gradient,
        static_load=axle_loads(model)[len(model.wheelsets) :],
        load_transfer=list(table.load_transfer or [0.0] * len(table.simulated)) if table else [],
        # A train's places run backwards from its first axle, those of the model forwards from its own origin.
        position=[first + table.positions[table.under_test[0] - 1] - table.positions[k - 1] for k in table.simulated]
        if table
        else [],
    )


def brake_delay(model: AssembledModel) -> list[float]:
    """After which the brake demand reaches each axle, as `model.axle_names` [s]; empty: no delay."""
    speed = model.case.train.brake_signal_speed
    return [] if speed is None else [place / speed for place in places(model)]


def air_groups(model: AssembledModel) -> dict[str, Any]:
    """Number of each axle's `reservoir` and `relay_valve`, as `model.axle_names`; empty: all have one, or the air has none."""
    air = model.case.brake.air if model.case.brake is not None else None
    counts = {"reservoir": getattr(air, "axles_per_reservoir", None), "relay_valve": None}
    if isinstance(air, ReservoirAir) and air.pipe is not None:
        counts["relay_valve"] = air.pipe.axles_per_relay_valve
    along = places(model)
    return {key: [sorted(along).index(at) // count for at in along] if count else [] for key, count in counts.items()}


def places(model: AssembledModel) -> list[float]:
    """Distance of each axle behind the train's first one, as `model.axle_names` [m]."""
    table = model.case.train.axles
    if table is None:
        first = max(axle_places(model))
        return [first - x for x in axle_places(model)]
    return [table.positions[k - 1] for k in (*table.under_test, *table.simulated)]
