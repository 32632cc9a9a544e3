"""The axles of the train: those under test, in the order of the model, then those that are only simulated.

Case, AssembledModel -> [train_axles] -> names, loads, places, brake demand and air; _core.SimulatedAxles
"""

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel
from rollerrig.config import Case
from rollerrig.config.schema.brakes import ReservoirAir


def simulated_count(case: Case) -> int:
    """Number of axles that are only simulated."""
    return len(case.train.axles.simulated) if case.train.axles else 0


def axle_loads(model: AssembledModel) -> list[float]:
    """Static load of each axle of the train, as `model.axle_names` [N]."""
    tested = [model.axle_loads[name] for name in model.wheelsets]
    table = model.case.train.axles
    if table is None:
        return tested
    others = table.loads or [sum(tested) / len(tested)] * len(table.simulated)
    return [*tested, *others]


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
    first = max(axle.x for axle in model.axles)
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


def reservoirs(model: AssembledModel) -> list[int]:
    """Number of the auxiliary reservoir that feeds each axle, as `model.axle_names`; empty: one feeds all."""
    brake = model.case.brake
    if brake is None or not isinstance(brake.air, ReservoirAir) or brake.air.axles_per_reservoir is None:
        return []
    return _in_rows(model, brake.air.axles_per_reservoir)


def relay_valves(model: AssembledModel) -> list[int]:
    """Number of each axle's relay valve, as `model.axle_names`; empty: the air has no pipes."""
    brake = model.case.brake
    if brake is None or not isinstance(brake.air, ReservoirAir) or brake.air.pipe is None:
        return []
    return _in_rows(model, brake.air.pipe.axles_per_relay_valve)


def _in_rows(model: AssembledModel, count: int) -> list[int]:
    """Number of the row of so many axles that each axle belongs to, counted from the front of the train."""
    along = places(model)
    return [sorted(along).index(place) // count for place in along]


def places(model: AssembledModel) -> list[float]:
    """Distance of each axle behind the train's first one, as `model.axle_names` [m]."""
    table = model.case.train.axles
    if table is None:
        first = max(axle.x for axle in model.axles)
        return [first - axle.x for axle in model.axles]
    return [table.positions[k - 1] for k in (*table.under_test, *table.simulated)]
