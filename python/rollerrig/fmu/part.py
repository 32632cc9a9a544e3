"""One of our controllers packed alone as an FMU: what it measures are inputs, its commands outputs.

case -> its slide protection, wheel-slip control or rig's controller -> [export_part] -> FILE.fmu
"""

from __future__ import annotations

import re
from html import escape
from pathlib import Path

from rollerrig import __version__, _core
from rollerrig.cases import as_case
from rollerrig.config import Case, ConfigError, ConfigProblem
from rollerrig.config.errors import nearest
from rollerrig.fmu.description import Unit
from rollerrig.fmu.export import DESCRIPTIONS, carried_shells, check_format, libraries, machines, packed
from rollerrig.mechatronics import COMMANDS
from rollerrig.plant import assembled_model
from rollerrig.results.files import output_file, write_bytes
from rollerrig.results.marks import PAGE


def export_part(case: Case | str, part: str, path: str | Path, *, fmi: str = "2", force: bool = False) -> Path:
    """Write one of our controllers alone as an FMU for co-simulation, with the parameters that the case gives it.

    Args:
        case: a checked case, or what `load_case` takes.
        part: its table: 'slide_protection', 'wheel_slip_control' or 'rig_control'.
        path: the file; one that this program wrote is replaced.
        fmi: version of the standard, '2' or '3'.
        force: replace a file that this program did not write.

    Returns:
        The file.

    Raises:
        ConfigError: the case has no such controller, or not ours.
        ExportError: this package was built without a library for FMUs.
        OutputError: the file cannot be written, or is somebody else's.
        StartError: no equilibrium was found to start from.

    Example:
        >>> import rollerrig as rr
        >>> rr.export_part("adhesion_brake", "slide_protection", "build/wsp.fmu").name
        'wsp.fmu'
    """
    case = as_case(case)
    check_format(case.name, fmi, "cs")
    target = output_file(path, force=force)
    carried = carried_shells()
    alone = controller_part(case, part)
    try:
        content = _core.write_part(alone)
    except ValueError as error:
        raise _refused(case, part, str(error)) from None
    unit = Unit(
        name=f"{case.name}.{part}",
        identifier=re.sub(r"\W", "_", f"{case.name}_{part}", flags=re.ASCII),
        token=_core.part_token(content),
        tool=f"rollerrig {__version__}",
        final_time=float(case.time.duration),
        step=float(getattr(case, part).sample_time),
        sampled=True,
        variables=_core.part_variables(alone),
    )
    files = {
        "documentation/index.html": _page(unit, machines(carried)),
        "modelDescription.xml": DESCRIPTIONS[fmi](unit),
        "resources/controller.part": content,
    }
    files |= libraries(carried, fmi, unit.identifier)
    return write_bytes(target, packed(files), force=force)


def controller_part(case: Case, part: str) -> _core.ControllerPart:
    """A controller of the case with what it starts from.

    Raises:
        ConfigError: the case has no such controller, or not ours.
        StartError: no equilibrium was found to start from.
    """
    there = [role for role in COMMANDS if getattr(case, role) is not None]
    if part not in there:
        raise _refused(case, part, f"allowed: a controller of the case: {', '.join(there) or 'it has none'}", there)
    if not getattr(case, part).is_ours:
        raise _refused(case, part, "the case has a controller of your own there; allowed: one of ours")
    axles = case.train.axles
    shared = case.sanding is not None or (case.adhesion is not None and case.adhesion.recovery_constant > 0.0)
    if part == "rig_control" and axles is not None and axles.simulated and shared:
        raise _refused(
            case, part, "the simulated axles of [train.axles] run on its virtual rail, and clean it or take its sand"
        )
    assembled = assembled_model(case, external=[role for role in there if not getattr(case, role).is_ours])
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


def _refused(case: Case, part: str, allowed: str, choices: list[str] | None = None) -> ConfigError:
    return ConfigError([ConfigProblem(case.name, "part", repr(part), allowed, nearest(part, choices or []))])


def _page(unit: Unit, runs_on: str) -> bytes:
    """What a user of the FMU should know, as the page that tools show."""
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">{PAGE.decode()}<title>{escape(unit.name)}</title></head><body>
<h1>{escape(unit.name)}</h1>
<p>A controller alone, written by {unit.tool}. It takes a sample every {unit.step:g} s: at the beginning of a
step, with the inputs as they are then; its commands are outputs from the end of that step on. What lies between a sample and the
command's acting is not part of it. SI.</p>
<p>Runs on</p>
<ul>
{runs_on}</ul>
</body></html>
""".encode()
