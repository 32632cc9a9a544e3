"""What the rig's controller must know of the vehicle on track, which it reproduces: load transfer, and the wheels' contact.

AssembledModel of a vehicle on a rig -> [equilibria of the same vehicle on track] -> change of load per acceleration, ellipse

A train that gains speed on the level stands, in its own frame, as one that runs steadily uphill: gravity has a part a against
the running direction. There the core finds its equilibrium, with everything that carries load. What is missing in it, the
wheelsets' gain of spin, is a moment on what carries their brakes.
"""

from __future__ import annotations

import numpy as np

from rollerrig import _core
from rollerrig.assembly.model import GROUND, AssembledModel, assemble, axle_torque
from rollerrig.assembly.model_parts import add_part
from rollerrig.assembly.train_axles import train_mass
from rollerrig.cases import on_track, without_actuators
from rollerrig.common.arrays import Array
from rollerrig.config import Case, RigControl
from rollerrig.simulation.starting_state import equilibrium_dataset

_GRADIENT = 0.01
"""Small enough for the linear part, large against the solver's tolerance [-]."""


def load_transfer(model: AssembledModel) -> list[float]:
    """Change of each axle's load per acceleration of the train, forward [kg], as the case's key `load_transfer` says.

    Raises:
        StartError: the vehicle has no equilibrium on track.
    """
    chosen = (model.case.rig_control or RigControl(load_transfer="none")).load_transfer
    if chosen == "none":
        return [0.0] * len(model.wheelsets)
    if chosen != "quasi_static":
        return list(chosen)
    small = _GRADIENT * model.case.gravity
    faster, slower = (_axle_loads(model.case, sign * small) for sign in (1.0, -1.0))
    change: list[float] = ((faster - slower) / (2.0 * small)).tolist()
    return change


def rail_patch(model: AssembledModel) -> _core.EquivalentPatch:
    """One ellipse that stands for all patches of a wheel in steady running on track, and the width that they sweep.

    Returns:
        `load` [N] of the wheel to which it belongs; semi-axes `a`, `b` [m]; `width` [m].
    """
    rails = assemble(_bare_on_track(model.case))
    rest = equilibrium_dataset(rails).isel(time=0, wheel=0)
    a, b = (np.nan_to_num(rest[name].to_numpy()).tolist() for name in ("patch_a", "patch_b"))
    return _core.equivalent_patch(load=rails.axle_loads[rails.wheelsets[0]] / 2.0, a=a, b=b)


def _axle_loads(case: Case, acceleration: float) -> Array:
    """Load of each axle on straight track, all axles sharing the force [N]."""
    model = AssembledModel(_bare_on_track(case))
    free = sum(model.masses[name] for name in model.lateral_bodies)
    force = (train_mass(model) if model.fixed else free) * acceleration / len(model.axle_names)
    radius = case.vehicle.data.wheel.radius
    on_ground = case.brake is None and case.traction is not None and case.traction.suspension == "ground"
    for name in model.wheelsets:
        wheelset, frame = model.body_index(name), GROUND if on_ground else model.frame_of(name)
        add_part(model.parts, "axle_torques", axle_torque(wheelset, frame, [(0.0, force * radius)]))
        if frame != GROUND:
            spin = model.inertias[name][1] * acceleration / radius
            add_part(model.parts, "axle_torques", axle_torque(frame, GROUND, [(0.0, -spin)]))
    slope = acceleration / case.gravity
    model.parts["resistance"] = _core.RunningResistance(
        body=GROUND, constant=0.0, linear=0.0, quadratic=0.0, gradient=slope
    )
    forces = equilibrium_dataset(model.finish())["vertical_force"].isel(time=0).to_numpy()
    return np.array([sum(forces[i] for i, w in enumerate(model.wheels) if w.wheelset == n) for n in model.wheelsets])


def _bare_on_track(case: Case) -> Case:
    return on_track(without_actuators(case)).with_changes({"disturbance": []})
