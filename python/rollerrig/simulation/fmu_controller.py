"""A controller that is an FMU, in a run: one communication step for each sample.

    measurements -> inputs of the FMU -> doStep over one sample time -> outputs -> [FmuController] -> commands

The outputs at the end of the step that a sample begins are the commands of that sample; what the FMU takes to compute is the
table's `delay`.
"""

from __future__ import annotations

import ctypes
import io
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
import weakref
import zipfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from signal import Signals
from typing import Any

import numpy as np

from rollerrig.config.schema.actuators import ControllerFmu
from rollerrig.simulation.fmu_file import FLOATS, FmuFile, Link, in_one_line, open_fmu

_ERROR, _FATAL = 3, 4
"""Statuses of both versions of the standard."""
_LINES = 3
"""Largest number of lines of the FMU's log in a message."""


class FmuError(Exception):
    """An FMU gave an error status, or ended the run; the message says in which call."""


class FmuController:
    """An FMU that is asked like a controller of the user, every `sample_time` [s]."""

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
            raise FmuError(f"{in_one_line(error)}{self._last_lines()}") from error

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

    def try_out(self) -> str:
        """Unpack it and take its first step in a process of its own, once: what is damaged inside can end that or never return.

        Returns:
            The folder where it is unpacked until `close`.

        Raises:
            FmuError: the process did not come to the end of that step. An error status is none: the run reports it.
        """
        folder = tempfile.mkdtemp(prefix="rollerrig-fmu-")
        self._remove = weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        with zipfile.ZipFile(io.BytesIO(self.file.content)) as archive:
            archive.extractall(folder)
        if self.file.checksum not in _SOUND and sys.executable:
            _in_process_of_its_own(folder, self.file, self.sample_time)
            _SOUND.add(self.file.checksum)
        return folder

    def _begin(self, time: float, measurements: dict[str, Any]) -> None:
        self._fmu = _instance(self.try_out(), self.file, self._hear)
        _enter(self._fmu, self.file, time)
        self._set_inputs(measurements)
        self._fmu.exitInitializationMode()

    def _set_inputs(self, measurements: dict[str, Any]) -> None:
        for link in self.file.inputs:
            _set(self._fmu, link, [float(value) for value in measurements[link.signal][: link.width]])

    def _get(self, link: Link) -> list[Any]:
        read = getattr(self._fmu, f"get{_kind(link)}")
        of_array = {} if link.width == len(link.references) else {"nValues": link.width}
        values: list[Any] = read(list(link.references), **of_array)
        return values

    def _hear(self, *told: Any) -> None:
        """Keep a message of the FMU: the last of what either version of the standard gives."""
        message = told[-1]
        text = message.decode("utf-8", "replace") if isinstance(message, bytes) else str(message)
        self._log = [*self._log[1 - _LINES :], " ".join(text.split())]

    def _last_lines(self) -> str:
        return f"; it says: {'; '.join(self._log)}" if self._log else ""


def _instance(folder: str, file: FmuFile, hear: Callable[..., None] | None = None) -> Any:
    """FMPy's instance of an unpacked FMU; its messages go to `hear`."""
    import fmpy

    return fmpy.instantiate_fmu(folder, file.description, fmi_type="CoSimulation", logger=hear)


def _enter(fmu: Any, file: FmuFile, time: float) -> None:
    """Set the parameters of the case and enter the initialisation at a time [s]."""
    for link, value in file.parameters:
        _set(fmu, link, [value])
    if file.description.fmiVersion == "2.0":
        fmu.setupExperiment(startTime=time)
        fmu.enterInitializationMode()
    else:
        fmu.enterInitializationMode(startTime=time)


_SOUND: set[str] = set()
"""Checksums of FMUs whose first step came to its end."""
_PATIENCE = 30.0
"""How long that may take [s]."""


def _in_process_of_its_own(folder: str, file: FmuFile, sample_time: float) -> None:
    import fmpy

    own = fmpy.platform if file.description.fmiVersion == "2.0" else fmpy.platform_tuple
    name = f"{file.description.coSimulation.modelIdentifier}{fmpy.sharedLibraryExtension}"
    library = str(Path(folder) / "binaries" / own / name)
    code = f"import sys; sys.path[:] = {sys.path}; from {__name__} import first_step; first_step()"
    given = pickle.dumps((library, folder, replace(file, content=b""), sample_time))
    try:
        command = [sys.executable, "-I", "-c", code]
        ended = subprocess.run(command, input=given, capture_output=True, check=False, timeout=_PATIENCE)
    except subprocess.TimeoutExpired:
        raise FmuError(f"tried in a process of its own, its first step had not ended after {_PATIENCE:g} s") from None
    if ended.stdout.endswith(_THROUGH):
        return
    last = (ended.stderr.decode("utf-8", "replace").strip().splitlines() or [""])[-1]
    if last.startswith("OSError: "):
        raise FmuError(f"its library cannot be loaded: {last}")
    code_or_error = last if ended.returncode > 0 and last else f"exit code {ended.returncode}"
    how = Signals(-ended.returncode).name if ended.returncode < 0 else code_or_error
    raise FmuError(f"tried in a process of its own, it ended that with {how} before the end of its first step")


_THROUGH = b"through the first step"


def first_step() -> None:
    """Load the library that standard input names, and take the FMU's first step with the start values of its inputs."""
    library, folder, file, sample_time = pickle.load(sys.stdin.buffer)  # of our own process
    os.chdir(Path(library).parent)
    ctypes.CDLL(library)
    with suppress(Exception):  # an error status, of which the run will tell
        fmu = _instance(folder, file)
        _enter(fmu, file, 0.0)
        fmu.exitInitializationMode()
        fmu.doStep(0.0, sample_time)
    os.write(1, _THROUGH)
    os._exit(0)  # whatever the library wants to do at the end of a process


def _set(fmu: Any, link: Link, values: list[Any]) -> None:
    given = values if _kind(link) == "String" else [v if link.kind in FLOATS else int(v) for v in values]
    getattr(fmu, f"set{_kind(link)}")(list(link.references), given)


def _kind(link: Link) -> str:
    """In the names of the standard's functions."""
    return "Integer" if link.kind == "Enumeration" else link.kind
