"""A case, or one of our controllers alone, packed as an FMU: model file, description and the libraries of the package.

rollerrig/shells/<platform>/rollerrig.* -> [shells] -> Shell per platform
case -> assembled model -> [export_fmu] -> FILE.fmu
case -> its slide protection, wheel-slip control or rig's controller -> [export_part] -> FILE.fmu
"""

import ctypes
import io
import platform
import zipfile
from collections.abc import Collection
from dataclasses import dataclass
from html import escape
from pathlib import Path

from rollerrig import _core
from rollerrig.cases import as_case
from rollerrig.config import Case, ConfigError
from rollerrig.interfaces.fmu.description import TOOL, Unit, model_description_2, model_description_3
from rollerrig.interfaces.plant import assembled_model, controller_part, part_refused
from rollerrig.results.files import output_file, write_bytes
from rollerrig.results.marks import PAGE

WINDOWS = "x86_64-windows"
FOLDERS = {"2": {"x86_64-linux": "linux64", WINDOWS: "win64"}, "3": {}}
"""Platform -> folder in binaries/, where the standard calls it otherwise: FMI 2.0.4, section 2.3."""


@dataclass(frozen=True)
class Shell:
    """A library for one platform."""

    platform: str  # processor and system, as FMI 3.0 writes them: x86_64-linux
    file: Path  # the library
    needs: str  # instructions beyond the oldest processor of its kind, with commas; empty: none

    def place(self, fmi: str, identifier: str) -> str:
        """Where an FMU keeps it."""
        return f"binaries/{FOLDERS[fmi].get(self.platform, self.platform)}/{identifier}{self.file.suffix}"


def shells() -> list[Shell]:
    """Those that came with the package; none on a system for which none is built."""
    folder = Path(str(_core.__file__)).parent / "shells"
    files = sorted(folder.glob("*/rollerrig.*"))
    return [Shell(file.parent.name, file, _needs(file)) for file in files if file.suffix in {".so", ".dll"}]


def _needs(file: Path) -> str:
    """Requirements of a library that this machine can load; the others are built for every processor of their kind."""
    if file.parent.name != f"{platform.machine()}-{platform.system().lower()}":
        return ""
    ask = ctypes.CDLL(str(file)).rollerrig_needs
    ask.restype = ctypes.c_char_p
    return str(ask().decode("ascii"))


STEP = 1e-3
"""At which to exchange values where nothing is sampled [s]."""
STAMP = (1980, 1, 1, 0, 0, 0)
"""Time stamp of every file in an FMU: the same case gives the same bytes."""
KINDS = ("cs", "me", "both")
DESCRIPTIONS = {"2": model_description_2, "3": model_description_3}


class ExportError(ValueError):
    """There is nothing to export with."""


def export_fmu(
    case: Case | str,
    path: str | Path,
    *,
    fmi: str = "2",
    kind: str = "cs",
    external: Collection[str] = (),
    force: bool = False,
) -> Path:
    """Write a case as an FMU: a Functional Mock-up Unit, which Simulink, Dymola, FMPy and others run.

    Args:
        case: a checked case, or what `load_case` takes.
        path: the file; one that this program wrote is replaced.
        fmi: version of the standard, '2' or '3'.
        kind: 'cs': co-simulation; 'me': model exchange; 'both'.
        external: tables of the case's controllers whose commands become inputs, `rollerrig.assemble_file`.
        force: replace a file that this program did not write.

    Returns:
        The file.

    Raises:
        ConfigError: the case cannot be run from outside; the version or kind is not offered.
        ExportError: this package was built without a library for FMUs.
        OutputError: the file cannot be written, or is somebody else's.
    """
    case, target, carried = _begun(case, path, fmi, kind, force=force)
    assembled = assembled_model(case, external=external)
    plant = _core.Plant(assembled)
    states, rates, indicators = ((), (), ()) if kind == "cs" else _core.continuous_variables(assembled)
    model = _core.write_model(assembled)
    unit = Unit(
        name=case.name,
        token=_core.model_token(model),
        final_time=assembled.options.final_time,
        step=plant.sampling_step or STEP,
        sampled=plant.sampling_step > 0.0,
        variables=plant.variables,
        kind=kind,
        states=states,
        rates=rates,
        indicators=indicators,
    )
    return _written(target, unit, fmi, {"resources/rig.model": model}, carried, force=force)


def _begun(case: Case | str, path: str | Path, fmi: str, kind: str, *, force: bool) -> tuple[Case, Path, list[Shell]]:
    """The case, the file of its FMU and the libraries of the package, refused where one of them cannot be used."""
    case = as_case(case)
    for key, value, offered in (("fmi", fmi, tuple(DESCRIPTIONS)), ("kind", kind, KINDS)):
        if value not in offered:
            raise ConfigError.of(case.name, key, repr(value), f"allowed: {', '.join(offered)}")
    target = output_file(path, force=force)
    if not (carried := shells()):
        raise ExportError("fmu: this package has no library for FMUs; they are built on Linux, with the package")
    return case, target, carried


def _written(
    target: Path, unit: Unit, fmi: str, resource: dict[str, bytes], carried: list[Shell], *, force: bool
) -> Path:
    """The FMU as a zip file. A page stands first, as it is: by it the program knows its own files."""
    head = f'<meta charset="utf-8">{PAGE.decode()}<title>{escape(unit.name)}</title>'
    page = f'<!DOCTYPE html><html lang="en"><head>{head}</head><body>Written by {TOOL}.</body></html>\n'
    files = {"documentation/index.html": page.encode(), "modelDescription.xml": DESCRIPTIONS[fmi](unit), **resource}
    files |= {shell.place(fmi, unit.identifier): shell.file.read_bytes() for shell in carried}
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for path, content in files.items():
            entry = zipfile.ZipInfo(path, STAMP)
            entry.compress_type = zipfile.ZIP_DEFLATED if archive.filelist else zipfile.ZIP_STORED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content)
    return write_bytes(target, stream.getvalue(), force=force)


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
    case, target, carried = _begun(case, path, fmi, "cs", force=force)
    alone = controller_part(case, part)
    try:
        content = _core.write_part(alone)
    except ValueError as error:
        raise part_refused(case, part, str(error)) from None
    plant = _core.ControllerPlant(alone)
    unit = Unit(
        name=f"{case.name}.{part}",
        token=_core.model_token(content),
        final_time=float(case.time.duration),
        step=plant.period,
        sampled=True,
        variables=plant.variables,
    )
    return _written(target, unit, fmi, {"resources/controller.part": content}, carried, force=force)
