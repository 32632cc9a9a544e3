"""A case as other tools drive it: assembled, at its start, with named inputs and outputs.

Case -> [assembled_model] -> _core.AssembledModel -> _core.Plant
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import cast

from rollerrig import _core
from rollerrig.actuators import assemble_with_actuators
from rollerrig.assembly import assemble
from rollerrig.config import Case, ConfigError, ConfigProblem
from rollerrig.mechatronics import COMMANDS, UserController, mechatronic_setup
from rollerrig.simulation import check_fixed_step, integrator_settings
from rollerrig.starting_state import starting_state


@dataclass(frozen=True)
class _External:
    """A controller outside: only when it is asked is known here."""

    sample_time: float


def assembled_model(case: Case, *, external: Collection[str] = (), may_drift: bool = False) -> _core.AssembledModel:
    """Everything that a run of a case needs, as the core keeps it.

    Args:
        case: a checked case.
        external: tables of the case's controllers whose commands come from outside, as inputs: 'slide_protection',
            'wheel_slip_control', 'rig_control'. What they see are outputs.
        may_drift: also where nothing holds the vehicle along the track on its rollers.

    Raises:
        ConfigError: the case has no such controller, or one that is written in Python and not external; nothing holds the
            vehicle on its rollers; the fixed step is unstable.
        StartError: no equilibrium was found to start from.
    """
    controllers = _external_controllers(case, external)
    model = assemble_with_actuators(case) if case.sampled else assemble(case)
    start = starting_state(_core.Simulation(model.start_core), model, may_drift=may_drift)
    setup = mechatronic_setup(model, controllers)
    simulation = _core.Simulation(model.core, setup)
    check_fixed_step(simulation, case, start)
    axles = model.axle_names if setup is not None else ()
    return _core.AssembledModel(
        name=case.name,
        model=model.core,
        setup=setup,
        names=_core.PartNames(bodies=list(model.bodies), elements=list(model.elements), axles=list(axles)),
        **integrator_settings(simulation, model),
        t0=0.0,
        x0=start.tolist(),
    )


def _external_controllers(case: Case, external: Collection[str]) -> dict[str, UserController]:
    there = [role for role in COMMANDS if getattr(case, role) is not None]
    for role in external:
        if role not in there:
            allowed = f"allowed: a table of the case: {', '.join(there) or 'it has none'}"
            raise ConfigError([ConfigProblem(case.name, "external", repr(role), allowed)])
    for role in there:
        table = getattr(case, role)
        if table.user is not None and role not in external:
            allowed = f"allowed: our own controller, or the commands as inputs: external = {role}"
            raise ConfigError([ConfigProblem(case.name, f"{role}.user", repr(table.user), allowed)])
    return {role: cast("UserController", _External(getattr(case, role).sample_time)) for role in external}
