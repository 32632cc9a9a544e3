"""A controller that is an FMU: its file, whether it fits the case, and one communication step for each sample of a run.

    [slide_protection] fmu = ... -> [open_fmu] -> FmuFile: its bytes, which variable is which signal, its parameters
    measurements -> inputs of the FMU -> doStep over one sample time -> outputs -> [FmuController] -> commands

The outputs at the end of the step that a sample begins are the commands of that sample; what the FMU takes to compute is the
table's `delay`.
"""

from __future__ import annotations

import hashlib
import io
import math
import shutil
import struct
import subprocess
import sys
import tempfile
import weakref
import zipfile
import zlib
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from signal import Signals
from typing import Any

import numpy as np

from rollerrig import _core
from rollerrig.common.input_files import MEGABYTE, InputError, read_input
from rollerrig.config import ConfigError, ConfigProblem
from rollerrig.config.errors import nearest
from rollerrig.config.schema.actuators import ControllerFmu

LARGEST_FMU = 512 * MEGABYTE
"""Some carry tables and a library for each platform [bytes]."""
LARGEST_UNPACKED = 2 * LARGEST_FMU
"""Of all its members [bytes]."""
LARGEST_DESCRIPTION = 32 * MEGABYTE
"""Of modelDescription.xml [bytes]; 100 000 variables have some 20 MB."""
OF_THE_TRAIN = ("track_brake_force", "force_of_others")
"""Measured quantities that are the same for each axle: a variable may take one number."""
MEASURED = tuple(name for name, _, _ in _core.measurement_fields)
FLOATS = ("Real", "Float64", "Float32")
WHOLE_NUMBERS = tuple(f"{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64))
NUMBERS = (*FLOATS, "Integer", "Enumeration", "Boolean", *WHOLE_NUMBERS)
_SHOWN = 12


@dataclass(frozen=True)
class Link:
    """A signal and the variables of the FMU that carry it.

    Attributes:
        signal: measured quantity, command or parameter.
        kind: type of the variables, as the FMU calls it.
        references: one for each axle, or that of an array, or that of a number for all axles.
        width: numbers that the variables have together.
    """

    signal: str
    kind: str
    references: tuple[int, ...]
    width: int


@dataclass(frozen=True)
class FmuFile:
    """An FMU that fits.

    Attributes:
        path: of the file.
        content: its bytes.
        description: as FMPy reads it.
        inputs: measured quantities that it takes.
        command: what it commands.
        parameters: with their values.
    """

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
        return [
            v.name for v in self.description.modelVariables if v.causality == "input" and v.valueReference not in driven
        ]


def open_fmu(table: ControllerFmu, key: str, file: str, axles: Sequence[str], command: str) -> FmuFile:
    """Read an FMU and connect it.

    Args:
        table: of the case.
        key: of the table, for messages.
        file: the case, for messages.
        axles: names of those that it controls.
        command: quantity that it commands.

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
    """The bytes of an FMU for co-simulation on this machine, and its description.

    Raises:
        ConfigError: it is none.
    """

    def refused(allowed: str) -> ConfigError:
        return ConfigError([ConfigProblem(file, f"{key}.file", repr(path), allowed)])

    try:
        import fmpy
    except ModuleNotFoundError:
        raise refused('needs FMPy, which is not installed: pip install "rollerrig[fmu]"') from None
    try:
        content = read_input(path, LARGEST_FMU)
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            sizes = {member.filename: member.file_size for member in archive.infolist()}
            if sum(sizes.values()) > LARGEST_UNPACKED:
                raise refused(f"it unpacks to {_size(sum(sizes.values()))}; allowed: up to {_size(LARGEST_UNPACKED)}")
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
        raise refused(f"its modelDescription.xml cannot be read: {_first_line(error)}") from None
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
            missing = cut_off(archive.read(library))
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError) as error:
        raise refused(f"{library} in it cannot be unpacked: {_first_line(error)}") from None
    if missing:
        raise refused(
            f"{library} in it is cut: {_size(missing)} are missing at its end, the loader of the system would crash"
        )
    return content, description


def cut_off(library: bytes) -> int:
    """Bytes that miss at the end of a shared library of Linux; 0 of a whole one, and of what is none of Linux.

    The loader maps what the program headers say and dies of SIGBUS where the file ends before; nothing is executed here.
    """
    if library[:6] != b"\x7fELF\x02\x01" or len(library) < 64:  # 64 bits, little endian
        return max(0, 64 - len(library)) if library[:4] == b"\x7fELF" else 0
    first, size, count = struct.unpack_from("<Q", library, 32)[0], *struct.unpack_from("<HH", library, 54)
    end = first + size * count
    for at in range(first, end, max(size, 1)) if end <= len(library) and size >= 56 else ():
        kind, offset, length = (
            struct.unpack_from(form, library, at + place)[0] for form, place in (("<I", 0), ("<Q", 8), ("<Q", 32))
        )
        end = max(end, offset + length) if kind == 1 else end  # PT_LOAD
    return max(0, end - len(library))


def _size(count: int) -> str:
    return f"{count / MEGABYTE:.3g} MB"


def _first_line(error: Exception) -> str:
    text = str(error).strip() or type(error).__name__
    return text.splitlines()[0]


class _Matcher:
    """Finds the variables that the case's table names; what it does not find it keeps as problems."""

    def __init__(self, table: ControllerFmu, key: str, file: str, axles: tuple[str, ...], variables: list[Any]) -> None:
        self._table, self._key, self._file, self._axles = table, key, file, axles
        self._variables = {v.name: v for v in variables}
        self.problems: list[ConfigProblem] = []

    def inputs(self, command: str) -> tuple[Link, ...]:
        """Measured quantities that the FMU takes."""
        for signal in self._table.names:
            if signal not in (*MEASURED, command):
                known = (*MEASURED, command)
                self._refuse("names", signal, f"allowed: {', '.join(known)}", nearest(signal, known))
        found = []
        for signal in MEASURED:
            written = self._table.names.get(signal)
            link = self._usual(signal) if written is None else self._link(signal, written, "input", FLOATS)
            if link is not None:
                found.append(link)
        if not found and not self.problems:
            takes = self._offers(lambda v: v.causality == "input")
            self._refuse(
                "names", "missing", f"none of its inputs is driven: {takes}; measured are {', '.join(MEASURED)}"
            )
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
            allowed = _values(v)
            if not allowed(value):
                limits = "".join(
                    f", {word} {limit}"
                    for word, limit in (("at least", v.min), ("at most", v.max))
                    if limit is not None
                )
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
        return [
            written.replace("{axle}", axle).replace("{number}", str(number))
            for number, axle in enumerate(self._axles, start=1)
        ]

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


def _values(variable: Any) -> Callable[[Any], bool]:
    """Whether a value may stand for a parameter, by its type and limits."""

    def within(value: Any) -> bool:
        low, high = variable.min, variable.max
        return (low is None or value >= float(low)) and (high is None or value <= float(high))

    def allowed(value: Any) -> bool:
        if variable.type == "String":
            return isinstance(value, str)
        if variable.type == "Boolean":
            return isinstance(value, bool)
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            return False
        return (variable.type in FLOATS or value == int(value)) and variable.type in NUMBERS and within(value)

    return allowed


_ERROR, _FATAL = 3, 4
"""Statuses of both versions of the standard."""
_LINES = 3
"""Largest number of lines of the FMU's log in a message."""


class FmuError(Exception):
    """An FMU gave an error status, or ended the run; the message says in which call."""


class FmuController:
    """An FMU that is asked like a controller of the user.

    Attributes:
        sample_time: of the case's table [s].
        name: of its file.
        file: what was found in it.
    """

    def __init__(
        self, table: ControllerFmu, key: str, case: str, axles: Sequence[str], command: str, sample_time: float
    ) -> None:
        """Check that it fits; none of its code is run.

        Args:
            table: of the case.
            key: of the table.
            case: name, for messages.
            axles: names of those that it controls.
            command: quantity that it commands.
            sample_time: [s].

        Raises:
            ConfigError: see `open_fmu`.
        """
        self.sample_time = sample_time
        self.file: FmuFile = open_fmu(table, key, case, axles, command)
        self.name = Path(table.file).name
        self._fmu: Any = None
        self._remove: Any = None
        self._log: list[str] = []
        self._dead = False

    @property
    def provenance(self) -> str:
        """What results say of it: file, name of the model, version of the standard, checksum."""
        description = self.file.description
        return f"{self.name}: {description.modelName}, FMI {description.fmiVersion}, SHA-256 {self.file.checksum}"

    def step(self, measurements: dict[str, Any]) -> dict[str, Any]:
        """Commands of one sample.

        Raises:
            FmuError: the FMU failed.
        """
        time = float(measurements["time"])
        try:
            if self._fmu is None:
                self._begin(time, measurements)
            self._set_inputs(measurements)
            ended = self._fmu.doStep(time, self.sample_time)
            if isinstance(ended, tuple) and (ended[1] or ended[2]):  # FMI 3.0: event, terminate, early return, time
                raise FmuError(f"doStep ended the run at {ended[3]:.6g} s{self._last_lines()}")
            command = self.file.command
            return {command.signal: np.array(self._get(command), dtype=np.float64)}
        except FmuError:
            raise
        except Exception as error:
            self._dead = getattr(error, "status", _ERROR) == _FATAL
            raise FmuError(f"{_sentence(error)}{self._last_lines()}") from error

    def close(self) -> None:
        """End the instance and remove what was unpacked; another run may begin."""
        if self._fmu is not None and not self._dead:
            with suppress(Exception):
                self._fmu.terminate()
            with suppress(Exception):
                self._fmu.freeInstance()
        self._fmu, self._dead, self._log = None, False, []
        if self._remove is not None:
            self._remove()
            self._remove = None

    def _begin(self, time: float, measurements: dict[str, Any]) -> None:
        import fmpy

        folder = tempfile.mkdtemp(prefix="rollerrig-fmu-")
        self._remove = weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        with zipfile.ZipFile(io.BytesIO(self.file.content)) as archive:
            archive.extractall(folder)
        _try_to_load(folder, self.file)
        description = self.file.description
        old = description.fmiVersion == "2.0"
        self._fmu = fmpy.instantiate_fmu(
            folder,
            description,
            fmi_type="CoSimulation",
            logger=self._hear_2 if old else self._hear_3,
        )
        for link, value in self.file.parameters:
            self._set(link, [value])
        if old:
            self._fmu.setupExperiment(startTime=time)
            self._fmu.enterInitializationMode()
        else:
            self._fmu.enterInitializationMode(startTime=time)
        self._set_inputs(measurements)
        self._fmu.exitInitializationMode()

    def _set_inputs(self, measurements: dict[str, Any]) -> None:
        for link in self.file.inputs:
            self._set(link, [float(value) for value in measurements[link.signal][: link.width]])

    def _set(self, link: Link, values: list[Any]) -> None:
        getattr(self._fmu, f"set{_kind(link)}")(list(link.references), values if _kind(link) == "String" else
                                                [v if link.kind in FLOATS else int(v) for v in values])  # fmt: skip

    def _get(self, link: Link) -> list[Any]:
        read = getattr(self._fmu, f"get{_kind(link)}")
        values: list[Any] = (
            read(list(link.references))
            if link.width == len(link.references)
            else read(list(link.references), nValues=link.width)
        )
        return values

    def _hear_2(self, _environment: Any, _name: Any, _status: int, _category: Any, message: Any) -> None:
        self._hear(message)

    def _hear_3(self, _environment: Any, _status: int, _category: Any, message: Any) -> None:
        self._hear(message)

    def _hear(self, message: Any) -> None:
        text = message.decode("utf-8", "replace") if isinstance(message, bytes) else str(message)
        self._log = [*self._log[1 - _LINES :], " ".join(text.split())]

    def _last_lines(self) -> str:
        return f"; it says: {'; '.join(self._log)}" if self._log else ""


_LOADED: set[str] = set()
"""Checksums of FMUs whose library could be loaded."""


def _try_to_load(folder: str, file: FmuFile) -> None:
    """Load the library in a process of its own, once: what is damaged inside can end the process that loads it.

    Raises:
        FmuError: it could not be loaded.
    """
    import fmpy

    if file.checksum in _LOADED or not sys.executable:
        return
    own = fmpy.platform if file.description.fmiVersion == "2.0" else fmpy.platform_tuple
    name = f"{file.description.coSimulation.modelIdentifier}{fmpy.sharedLibraryExtension}"
    code = "import ctypes, os, sys; os.chdir(os.path.dirname(sys.argv[1])); ctypes.CDLL(sys.argv[1])"
    path = str(Path(folder) / "binaries" / own / name)
    ended = subprocess.run([sys.executable, "-I", "-c", code, path], capture_output=True, text=True, check=False)
    if ended.returncode < 0:
        raise FmuError(f"its library cannot be loaded: the loader was ended by {Signals(-ended.returncode).name}")
    if ended.returncode:
        raise FmuError(f"its library cannot be loaded: {(ended.stderr.strip().splitlines() or ['?'])[-1]}")
    _LOADED.add(file.checksum)


def _kind(link: Link) -> str:
    """In the names of the standard's functions."""
    return "Integer" if link.kind == "Enumeration" else link.kind


def _sentence(error: Exception) -> str:
    """In one line."""
    return " ".join(str(error).split()) or type(error).__name__
