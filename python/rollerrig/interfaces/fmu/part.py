"""One of our controllers packed alone as an FMU: what it measures are inputs, its commands outputs.

case -> its slide protection, wheel-slip control or rig's controller -> [export_part] -> FILE.fmu
"""

from __future__ import annotations

import re
from html import escape
from pathlib import Path

from rollerrig import __version__, _core
from rollerrig.cases import as_case
from rollerrig.config import Case
from rollerrig.interfaces.controller_part import controller_part, part_refused
from rollerrig.interfaces.fmu.description import Unit
from rollerrig.interfaces.fmu.export import DESCRIPTIONS, carried_shells, check_format, libraries, machines, packed
from rollerrig.results.files import output_file, write_bytes
from rollerrig.results.marks import PAGE


def export_part(case: Case | str, part: str, path: str | Path, *, fmi: str = "2", force: bool = False) -> Path:
    """Write one of our controllers alone as an FMU for co-simulation, with the parameters that the case gives it.

    Args:
        case: a checked case, or what `load_case` takes.
        part: its table: 'slide_protection', 'wheel_slip_control', 'rig_control', or 'brake_unit' of [brake].
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
        raise part_refused(case, part, str(error)) from None
    plant = _core.ControllerPlant(alone)
    unit = Unit(
        name=f"{case.name}.{part}",
        identifier=re.sub(r"\W", "_", f"{case.name}_{part}", flags=re.ASCII),
        token=_core.part_token(content),
        tool=f"rollerrig {__version__}",
        final_time=float(case.time.duration),
        step=plant.period,
        sampled=True,
        variables=plant.variables,
    )
    files = {
        "documentation/index.html": _page(unit, machines(carried)),
        "modelDescription.xml": DESCRIPTIONS[fmi](unit),
        "resources/controller.part": content,
    }
    files |= libraries(carried, fmi, unit.identifier)
    return write_bytes(target, packed(files), force=force)


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
