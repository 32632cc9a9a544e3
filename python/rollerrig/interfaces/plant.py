"""A case, or one of its controllers alone, as other tools drive it: with named inputs and outputs; and its model file.

Case -> [assembled_model] -> _core.AssembledModel -> _core.Plant
        [assemble_file]   -> model file -> [read_model] -> _core.AssembledModel
case, name of its table -> [controller_part] -> _core.ControllerPart
"""

from collections.abc import Collection
from pathlib import Path
from types import SimpleNamespace
from typing import cast

from rollerrig import _core
from rollerrig.assembly.actuators import assemble_as_run
from rollerrig.cases import as_case
from rollerrig.common.input_files import MEGABYTE, read_input
from rollerrig.config import Case, ConfigError
from rollerrig.config.errors import nearest
from rollerrig.results.files import output_file, write_bytes
from rollerrig.simulation.controllers import UserController, roles_of, with_brake_unit
from rollerrig.simulation.faults import refuse_faults
from rollerrig.simulation.mechatronics import mechatronic_setup
from rollerrig.simulation.run import check_fixed_step, integrator_settings
from rollerrig.simulation.starting_state import disturbances, starting_state

LARGEST_MODEL = 256 * MEGABYTE
"""Largest size of a model file: 200 km of measured track have some 100 MB [bytes]."""


class ModelFileError(ValueError):
    """A file holds no model that this version can read; the message says why."""


def assemble_file(
    case: Case | str,
    path: str | Path,
    *,
    external: Collection[str] = (),
    allow_unrestrained: bool = False,
    force: bool = False,
) -> Path:
    """Write everything that a run of a case needs into one file, which the core reads without Python (docs/model_file.md).

    Args:
        case: what to assemble, or its name in the catalogue.
        path: the file; replaced if this program wrote it. The same case gives the same bytes.
        external: tables of the case's controllers whose commands come from outside, as inputs.
        allow_unrestrained: also where nothing holds the vehicle along the track on its rollers.
        force: whether a file of another program may be replaced.

    Raises:
        ConfigError: see `rollerrig.interfaces.plant.assembled_model`.
        StartError: no equilibrium was found to start from.
        OutputError: the file could not be written.

    Example:
        >>> import rollerrig as rr
        >>> path = rr.assemble_file("wheelset_rollers", "build/wheelset.model")
        >>> rr.read_model(path).name
        'wheelset_rollers'
    """
    target = output_file(path, force=force)
    content = _core.write_model(
        assembled_model(as_case(case), external=external, allow_unrestrained=allow_unrestrained)
    )
    return write_bytes(target, content, force=force)


def read_model(path: str | Path) -> _core.AssembledModel:
    """The assembled model in a file.

    Raises:
        ModelFileError: it is none, or cut, changed, or of another version.
        OSError: there is no such file, or it cannot be read.
    """
    try:
        return _core.read_model(read_input(path, LARGEST_MODEL))
    except ValueError as error:
        raise ModelFileError(f"{path}: {error}") from None


def contents(assembled: _core.AssembledModel) -> str:
    """Lines for a user: how large a model is, and its inputs."""
    variables = _core.Plant(assembled).variables
    inputs = [f"{v.name} [{v.unit}]" for v in variables if v.causality == "input"]
    counted = (
        f"{len(assembled.names.bodies)} bodies, {len(assembled.x0)} states, {len(variables) - len(inputs)} outputs"
    )
    return f"{assembled.name}: {counted}\ninputs: {', '.join(inputs) or 'none'}"


def assembled_model(
    case: Case, *, external: Collection[str] = (), allow_unrestrained: bool = False
) -> _core.AssembledModel:
    """Everything that a run of a case needs, as the core keeps it.

    Args:
        case: a checked case.
        external: tables of the case's controllers whose commands come from outside, as inputs: 'slide_protection',
            'wheel_slip_control', 'rig_control', or 'brake_unit' of [brake]. What they see are outputs.
        allow_unrestrained: also where nothing holds the vehicle along the track on its rollers.

    Raises:
        ConfigError: the case has no such controller, or one of the user's that is not external; nothing holds the
            vehicle on its rollers; the fixed step is unstable.
        StartError: no equilibrium was found to start from.
    """
    refuse_faults(case)
    case = with_brake_unit(case, external)
    controllers = _external_controllers(case, external)
    model = assemble_as_run(case)
    start = starting_state(model, allow_unrestrained=allow_unrestrained)
    setup = mechatronic_setup(model, controllers)
    simulation = _core.Simulation(model.core, setup)
    check_fixed_step(simulation, case, start)
    axles = model.axle_names if setup is not None else ()
    return _core.AssembledModel(
        name=case.name,
        model=model.core,
        setup=setup,
        names=_core.PartNames(bodies=list(model.bodies), elements=list(model.elements), axles=list(axles)),
        options=_core.Options(**integrator_settings(simulation, model), output_step=0.0),
        t0=0.0,
        x0=start.tolist(),
        disturbances=disturbances(model),
    )


def _external_controllers(case: Case, external: Collection[str]) -> dict[str, UserController]:
    there = roles_of(case)
    for role in external:
        if role not in there:
            allowed = f"allowed: a table of the case: {', '.join(there) or 'it has none'}"
            raise ConfigError.of(case.name, "external", repr(role), allowed)
    for role in there:
        table = getattr(case, role)
        if table is not None and not table.is_ours and role not in external:
            allowed = f"allowed: our own controller, or the commands as inputs: external = {role}"
            key, value = ("user", table.user) if table.user is not None else ("fmu", table.fmu.file)
            raise ConfigError.of(case.name, f"{role}.{key}", repr(value), allowed)
    # of a controller outside only when it is asked is known here
    times = {role: SimpleNamespace(sample_time=getattr(case, role).sample_time) for role in external}
    return cast("dict[str, UserController]", times)


def controller_part(case: Case, part: str) -> _core.ControllerPart:
    """A controller of the case with what it starts from.

    Raises:
        ConfigError: the case has no such controller, or not ours.
        StartError: no equilibrium was found to start from.
    """
    case, there = with_brake_unit(case, [part]), roles_of(case)
    if part not in there:
        raise part_refused(case, part, f"allowed: a controller of the case: {', '.join(there) or 'it has none'}", there)
    if not getattr(case, part).is_ours:
        raise part_refused(case, part, "the case has a controller of your own there; allowed: one of ours")
    axles = case.train.axles
    shared = case.sanding is not None or (case.adhesion is not None and case.adhesion.recovery_constant > 0.0)
    if part == "rig_control" and axles is not None and axles.simulated and shared:
        raise part_refused(
            case, part, "the simulated axles of [train.axles] run on its virtual rail, and clean it or take its sand"
        )
    others = [role for role in there if (table := getattr(case, role)) is not None and not table.is_ours]
    assembled = assembled_model(case, external=others)
    assert assembled.setup is not None
    sampled = next(one for one in assembled.setup.controllers if isinstance(one.controller, _core.controllers[part]))
    plant = _core.Plant(assembled)
    plant.start()
    names = list(assembled.names.axles)
    if isinstance(sampled.controller, _core.RigControl):  # of those on the rig alone
        names = names[: len(sampled.controller.train.static_load)]

    def at_start(quantity: str) -> list[float]:
        return [float(plant.get(plant.find(f"{axle}.{quantity}"))) for axle in names]

    return _core.ControllerPart(
        name=case.name,
        step=assembled.setup.step,
        controller=sampled,
        axles=names,
        train_speed=assembled.setup.speed,
        axle_speed=at_start("axle_speed"),
        roller_speed=at_start("roller_speed"),
    )


def part_refused(case: Case, part: str, allowed: str, choices: list[str] | None = None) -> ConfigError:
    """What is wrong with a part, with a guess."""
    return ConfigError.of(case.name, "part", repr(part), allowed, nearest(part, choices or []))
