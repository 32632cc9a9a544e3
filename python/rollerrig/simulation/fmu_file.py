"""A controller's FMU as it lies in its file: what it offers, and whether it fits the case. None of its code is run.

[slide_protection] fmu = ... -> [open_fmu] -> FmuFile: its bytes, which variable is which signal, its parameters
"""

from __future__ import annotations

import hashlib
import io
import math
import zipfile
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rollerrig import _core
from rollerrig.common.input_files import MEGABYTE, InputError, read_input
from rollerrig.config import ConfigError, ConfigProblem
from rollerrig.config.errors import nearest
from rollerrig.config.schema.actuators import ControllerFmu

LARGEST_FMU = 512 * MEGABYTE
"""Some carry tables and a library for each platform [bytes]."""
LARGEST_UNPACKED = 2 * LARGEST_FMU
"""Largest size of all its members together [bytes]."""
LARGEST_DESCRIPTION = 16 * MEGABYTE
"""Largest size of its modelDescription.xml [bytes]; 80 000 variables have some 16 MB."""
OF_THE_TRAIN = ("track_brake_force", "force_of_others")
"""Measured quantities that are the same for each axle: a variable may take one number."""
MEASUREMENTS = tuple(name for name, _, _ in _core.measurement_fields)
"""What a controller is given beside `time`, an array over the axles each; on track only `axle_speed` means anything."""
FLOATS = ("Real", "Float64", "Float32")
WHOLE_NUMBERS = tuple(f"{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64))
NUMBERS = (*FLOATS, "Integer", "Enumeration", "Boolean", *WHOLE_NUMBERS)
_SHOWN = 12


@dataclass(frozen=True)
class Link:
    """A signal and the variables of the FMU that carry it."""

    signal: str  # measured quantity, command or parameter
    kind: str  # type of the variables, as the FMU calls it
    references: tuple[int, ...]  # one for each axle, or that of an array, or that of a number for all axles
    width: int  # numbers that the variables have together


@dataclass(frozen=True)
class FmuFile:
    """An FMU that fits: its bytes, FMPy's description, measured quantities that it takes, what it commands, parameters."""

    path: str
    content: bytes
    description: Any
    inputs: tuple[Link, ...]
    command: Link
    parameters: tuple[tuple[Link, Any], ...]

    @property
    def checksum(self) -> str:
        """SHA-256 of the file."""
        return hashlib.sha256(self.content).hexdigest()

    @property
    def unused(self) -> list[str]:
        """Inputs of the FMU that nothing drives: they keep their start values."""
        driven = {reference for link in self.inputs for reference in link.references}
        driven |= {reference for link, _ in self.parameters for reference in link.references}
        variables = self.description.modelVariables
        return [v.name for v in variables if v.causality == "input" and v.valueReference not in driven]


def open_fmu(table: ControllerFmu, key: str, file: str, axles: Sequence[str], command: str) -> FmuFile:
    """Read the FMU of a table of a case and connect it to the axles that it controls, whose quantity `command` it commands.

    Raises:
        ConfigError: FMPy is not installed; the file is no FMU that can be run here; a name or a parameter is not that of one
            of its variables.
    """
    content, description = _read(table.file, key, file)
    matcher = _Matcher(table, key, file, tuple(axles), list(description.modelVariables))
    inputs, found = matcher.inputs(command), matcher.command(command)
    parameters = matcher.parameters({reference for link in inputs for reference in link.references})
    if matcher.problems or found is None:
        raise ConfigError(matcher.problems)
    return FmuFile(table.file, content, description, inputs, found, parameters)


def _read(path: str, key: str, file: str) -> tuple[bytes, Any]:
    """The bytes of an FMU for co-simulation on this machine, and its description; else a ConfigError."""

    def refused(allowed: str) -> ConfigError:
        return ConfigError.of(file, f"{key}.file", repr(path), allowed)

    try:
        import fmpy
    except ModuleNotFoundError:
        raise refused('needs FMPy, which is not installed: pip install "rollerrig[fmu]"') from None
    try:
        content = read_input(path, LARGEST_FMU)
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            sizes = {member.filename: member.file_size for member in archive.infolist()}
            unpacked = sum(member.file_size for member in archive.infolist())  # two of one name are both unpacked
            if unpacked > LARGEST_UNPACKED:
                raise refused(f"it unpacks to {_size(unpacked)}; allowed: up to {_size(LARGEST_UNPACKED)}")
            described = sizes.get("modelDescription.xml", 0)
            if described > LARGEST_DESCRIPTION:
                allowed = f"allowed: up to {_size(LARGEST_DESCRIPTION)}"
                raise refused(f"its modelDescription.xml has {_size(described)}; {allowed}")
    except InputError as error:
        raise refused(f"{error.strerror}; allowed: an FMU file") from None
    except OSError as error:
        raise refused(f"{error.strerror}; allowed: an FMU file, its path starts at the file that names it") from None
    except zipfile.BadZipFile:
        raise refused("this file is no FMU: it is no zip archive") from None
    if "modelDescription.xml" not in sizes:
        raise refused("this file is no FMU: it has no modelDescription.xml")
    try:
        description = fmpy.read_model_description(io.BytesIO(content), validate=False)
    except Exception as error:  # whatever the reader of XML meets
        raise refused(f"its modelDescription.xml cannot be read: {in_one_line(error)}") from None
    if description.fmiVersion not in ("2.0", "3.0"):
        raise refused(f"it is of FMI {description.fmiVersion}; allowed: 2.0, 3.0")
    if description.coSimulation is None:
        raise refused("it is for model exchange alone; allowed: an FMU for co-simulation")
    own = fmpy.platform if description.fmiVersion == "2.0" else fmpy.platform_tuple
    library = f"binaries/{own}/{description.coSimulation.modelIdentifier}{fmpy.sharedLibraryExtension}"
    if library not in sizes:
        there = sorted({name.split("/")[1] for name in sizes if name.startswith("binaries/") and name.count("/") > 1})
        raise refused(f"it has no {library}; it runs on {', '.join(there) or 'no platform'}, this is {own}")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            archive.read(library)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError) as error:
        raise refused(f"{library} in it cannot be unpacked: {in_one_line(error)}") from None
    return content, description


def _size(count: int) -> str:
    return f"{count / MEGABYTE:.3g} MB"


def in_one_line(error: Exception) -> str:
    """What an exception says."""
    return " ".join(str(error).split()) or type(error).__name__


class _Matcher:
    """Finds the variables that the case's table names; what it does not find it keeps as problems."""

    def __init__(self, table: ControllerFmu, key: str, file: str, axles: tuple[str, ...], variables: list[Any]) -> None:
        self._table, self._key, self._file, self._axles = table, key, file, axles
        self._variables = {v.name: v for v in variables}
        self.problems: list[ConfigProblem] = []

    def inputs(self, command: str) -> tuple[Link, ...]:
        """Measured quantities that the FMU takes."""
        for signal in self._table.names:
            if signal not in (*MEASUREMENTS, command):
                known = (*MEASUREMENTS, command)
                self._refuse("names", signal, f"allowed: {', '.join(known)}", nearest(signal, known))
        found = []
        for signal in MEASUREMENTS:
            written = self._table.names.get(signal)
            link = self._usual(signal) if written is None else self._link(signal, written, "input", FLOATS)
            if link is not None:
                found.append(link)
        if not found and not self.problems:
            takes = self._offers(lambda v: v.causality == "input")
            self._refuse("names", "missing", f"no input is driven: {takes}; measured are {', '.join(MEASUREMENTS)}")
        return tuple(found)

    def command(self, command: str) -> Link | None:
        """What it commands."""
        written = self._table.names.get(command, f"{{axle}}.{command}_command")
        return self._link(command, written, "output", NUMBERS)

    def parameters(self, driven: set[int]) -> tuple[tuple[Link, Any], ...]:
        """Its parameters that the case sets; an input that nothing drives may be set, too."""

        def settable(v: Any) -> bool:
            return v.causality == "parameter" or (v.causality == "input" and v.valueReference not in driven)

        found = []
        for name, value in self._table.parameters.items():
            v = self._variables.get(name)
            if v is None or not settable(v):
                self._unknown("parameters", name, "parameter", settable)
                continue
            if not _fits(v, value):
                ends = ("at least", v.min), ("at most", v.max)
                limits = "".join(f", {word} {limit}" for word, limit in ends if limit is not None)
                self._refuse(f"parameters.{name}", repr(value), f"allowed: a value of type {v.type}{limits}")
                continue
            found.append((Link(name, v.type, (v.valueReference,), 1), value))
        return tuple(found)

    def _usual(self, signal: str) -> Link | None:
        """Link to the variable with the name that our own FMUs use; an absent one is not driven."""
        for pattern in (f"{{axle}}.{signal}", f"train.{signal}"):
            if all(self._is_input(name) for name in self._expanded(pattern)):
                return self._link(signal, pattern, "input", FLOATS)
        return None

    def _is_input(self, name: str) -> bool:
        return name in self._variables and self._variables[name].causality == "input"

    def _expanded(self, written: str) -> list[str]:
        """A name for each axle; one alone where the text has no place for them."""
        if "{axle}" not in written and "{number}" not in written:
            return [written]
        numbered = enumerate(self._axles, start=1)
        return [written.replace("{axle}", axle).replace("{number}", str(number)) for number, axle in numbered]

    def _link(self, signal: str, written: str | tuple[str, ...], causality: str, kinds: tuple[str, ...]) -> Link | None:
        names = list(written) if isinstance(written, tuple) else self._expanded(written)
        place = f"names.{signal}"
        for name in names:
            if name not in self._variables or self._variables[name].causality != causality:
                self._unknown(place, name, causality, lambda v: v.causality == causality)
                return None
            if self._variables[name].type not in kinds:
                self._refuse(place, repr(name), f"it is a {self._variables[name].type}; allowed: {', '.join(kinds)}")
                return None
        variables = [self._variables[name] for name in names]
        width = sum(math.prod(v.shape or (1,)) for v in variables)
        whole = signal in OF_THE_TRAIN and len(names) == 1 and width == 1
        if (width != len(self._axles) and not whole) or len({v.type for v in variables}) > 1:
            count = len(self._axles)
            self._refuse(
                place,
                repr(written),
                f"it has {width} numbers for {count} axles ({', '.join(self._axles)}); allowed: a name with {{axle}} or "
                f"{{number}}, a list of {count} names, or an array of {count}, all of one type",
            )
            return None
        return Link(signal, variables[0].type, tuple(v.valueReference for v in variables), width)

    def _unknown(self, place: str, name: str, kind: str, offered: Callable[[Any], bool]) -> None:
        choices = [v.name for v in self._variables.values() if offered(v)]
        allowed = f"no {kind} of {Path(self._table.file).name}; it offers {self._offers(offered)}"
        self._refuse(place, repr(name), allowed, nearest(name, choices))

    def _offers(self, wanted: Callable[[Any], bool]) -> str:
        names = [v.name for v in self._variables.values() if wanted(v)]
        more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
        return (", ".join(names[:_SHOWN]) or "none") + more

    def _refuse(self, place: str, value: str, allowed: str, hint: str = "") -> None:
        self.problems.append(ConfigProblem(self._file, f"{self._key}.{place}", value, allowed, hint))


def _fits(variable: Any, value: Any) -> bool:
    """Whether a value may stand for a parameter, by its type and limits."""
    if variable.type in ("String", "Boolean"):
        return isinstance(value, str if variable.type == "String" else bool)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return False
    low, high = (None if limit is None else float(limit) for limit in (variable.min, variable.max))
    within = (low is None or value >= low) and (high is None or value <= high)
    return (variable.type in FLOATS or value == int(value)) and variable.type in NUMBERS and within
