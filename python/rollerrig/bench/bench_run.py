"""A vehicle on the test bench: machines and controllers act while the plant is integrated.

AssembledModel of a case with [brake], [traction], [adhesion] or [rig_control] -> [bench] -> rows, Outcome

The core keeps the time grid (core/include/rollerrig/simulate/sampled_run.hpp); here it is run in slices, for progress, Ctrl-C
and the user's own controllers.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig import _core
from rollerrig.assembly import AssembledModel
from rollerrig.bench.controllers import (
    COMMANDS,
    ControllerError,
    UserController,
    ask,
    check_controller,
    load_controller,
)
from rollerrig.bench.settings import fit
from rollerrig.config import Case, ConfigError, ConfigProblem
from rollerrig.results import Outcome, run_dataset
from rollerrig.starting_state import starting_state

Vector = NDArray[np.float64]
Progress = Callable[[float, str], None]

_SLICE_SECONDS = 0.2
_ROLES = {
    "slide_protection": _core.Role.slide_protection,
    "wheel_slip_control": _core.Role.wheel_slip_control,
    "rig_control": _core.Role.rig,
}
_STATUS_NAMES: dict[int, str] = {code: name for name, code in _core.status_codes.items()}
CONTROLLER_FAILED = "controller_failed"
ROLLERS_PROTECTED = "rollers_protected"


class BenchRun:
    """One test on the bench."""

    def __init__(self, model: AssembledModel, controllers: Mapping[str, Any] | None = None) -> None:
        """A run of a model; the model may be shared.

        Args:
            model: assembled with its actuators.
            controllers: objects in place of the case's controllers: 'slide_protection', 'wheel_slip_control', 'rig_control'.

        Raises:
            ConfigError: a controller cannot be used.
            StartError: no equilibrium was found.
        """
        self.model = model
        self.case: Case = model.case
        self.controllers = users_controllers(self.case, controllers or {})
        self.travels = self._fit()
        self._filled = 0
        self._message = ""

    def _fit(self) -> bool:
        fitted = fit(self.model, self.controllers)
        simulation = _core.Simulation(self.model.start_core)
        self._start = np.asarray(starting_state(simulation, self.model))
        self._core = _core.Bench(self.model.core, fitted.settings)
        return fitted.travels

    @property
    def width(self) -> int:
        """Numbers per output time."""
        return int(self._core.plant_width + self._core.bench_width)

    def run(self, count: int, progress: Progress | None = None) -> xr.Dataset:
        """Run to the end of the test.

        Args:
            count: output times at most.
            progress: called several times a second with the fraction done and a short text.

        Returns:
            The Dataset of a run with the bench's variables over `axle` beside it, without the energy audit.
        """
        times = np.full(count, np.nan)
        plant, bench = np.empty((count, self._core.plant_width)), np.empty((count, self._core.bench_width))
        try:
            status = self._advance(times, plant, bench, progress)
        except KeyboardInterrupt:
            status = "interrupted"
        except ControllerError as error:
            status, self._message = CONTROLLER_FAILED, str(error)
        filled = int(np.count_nonzero(np.isfinite(times)))
        run = run_dataset(self.model, times[:filled], plant[:filled], self._outcome(status))
        return _with_bench(run, self.model, bench[:filled])

    def _advance(self, times: Vector, plant: Vector, bench: Vector, progress: Progress | None) -> str:
        core, case = self._core, self.case
        every = round(case.time.output_step / case.bench.step)
        code = core.start(self._start)
        duration, until, length = case.time.duration, 0.0, case.time.output_step
        while code == 0 and not core.ended and until < duration:
            until = min(until + length, duration)
            begun = time.perf_counter()
            while True:
                code, self._filled = core.advance(until, every, times, plant, bench, self._filled)
                if code != 0 or not self._answer():
                    break
            spent = time.perf_counter() - begun
            if progress is not None and self._filled:
                speed = 3.6 * bench[self._filled - 1, -len(_core.bench_train_columns)]
                progress(until / duration, f"t = {core.time:.2f} s of {duration:g} s, {speed:.0f} km/h")
            if spent < 0.5 * _SLICE_SECONDS:
                length *= 2.0
            elif spent > 2.0 * _SLICE_SECONDS:
                length = max(0.5 * length, case.time.output_step)
        if code == 0 and core.protected_rollers:
            return ROLLERS_PROTECTED
        return _STATUS_NAMES.get(code, "unknown")

    def _answer(self) -> bool:
        """Ask the user's controllers that are due; whether there was one."""
        due = [role for role in self.controllers if self._core.due(_ROLES[role])]
        for role in due:
            rows = np.array(self._core.measurement(_ROLES[role])).reshape(-1, len(_core.measurement_fields))
            measurements: dict[str, Any] = {"time": self._core.time}
            measurements.update({name: rows[:, i] for i, name in enumerate(_core.measurement_fields)})
            self._core.set_command(_ROLES[role], ask(self.controllers[role], role, measurements).tolist())
        return bool(due)

    def _outcome(self, status: str) -> Outcome:
        core, at = self._core, self._core.time
        blamed = core.failed_contact if status in ("contact_lost", "off_profile", "derailed") else -1
        wheel = next((w.name for w in self.model.wheels if w.contact == blamed), "")
        if status == CONTROLLER_FAILED:
            message = self._message
        elif status == ROLLERS_PROTECTED:
            control = self.case.rig_control
            limit = control.protection.slip if control else 0.0
            message = (
                f"t = {at:.4g} s: the protection of the rollers ended the test: a wheel slid on its roller by more than "
                f"{limit:g} m/s; less torque or more friction between wheel and roller, or raise rig_control.protection.slip"
            )
        elif status == "ok":
            stands = " The train has stopped." if core.ended else ""
            message = f"{_core.status_sentence(0)}{stands}"
        else:
            message = (
                f"t = {at:.4g} s{', ' + wheel if wheel else ''}: {_core.status_sentence(_core.status_codes[status])}"
            )
        counts = {"steps": core.steps, "derivative_calls": core.derivative_calls}
        return Outcome(status, message, at, wheel, counts, {})


def users_controllers(case: Case, given: Mapping[str, Any]) -> dict[str, UserController]:
    """Controllers of the case and of the caller, whose sample times fit the bench.

    Raises:
        ConfigError: one cannot be used.
    """
    found: dict[str, UserController] = {}
    for role in given:
        if role not in COMMANDS or getattr(case, role) is None:
            there = [name for name in COMMANDS if getattr(case, name) is not None]
            allowed = f"allowed: a table of the case: {', '.join(there) or 'it has none'}"
            raise ConfigError([ConfigProblem(case.name, "controllers", repr(role), allowed)])
        found[role] = check_controller(given[role], role, case.name)
    for role in COMMANDS:
        table = getattr(case, role)
        if role not in found and table is not None and table.user is not None:
            found[role] = load_controller(table.user, f"{role}.user", case.name)
    for role, controller in found.items():
        steps = controller.sample_time / case.bench.step
        if round(steps) < 1 or abs(steps - round(steps)) > 1e-6 * steps:
            name = f"{role}, {type(controller).__name__}.sample_time"
            near = max(1, round(steps)) * case.bench.step
            allowed = f"allowed: a multiple of bench.step, {case.bench.step:g} s; the nearest is {near:g} s"
            raise ConfigError([ConfigProblem(case.name, name, f"{controller.sample_time:g}", allowed)])
    return found


def _with_bench(run: xr.Dataset, model: AssembledModel, rows: Vector) -> xr.Dataset:
    """The run with the bench's variables over time and axle, and those of the train over time."""
    axles, columns = len(model.wheelsets), _core.bench_axle_columns
    per_axle = rows[:, : axles * len(columns)].reshape(len(rows), axles, len(columns))
    train = rows[:, axles * len(columns) :]
    variables: dict[str, Any] = {}
    for i, (name, unit, meaning) in enumerate(columns):
        variables[name] = (("time", "axle"), per_axle[..., i], {"units": unit, "long_name": meaning})
    for i, (name, unit, meaning) in enumerate(_core.bench_train_columns):
        variables[name] = ("time", train[:, i], {"units": unit, "long_name": meaning})
    return run.assign(variables).assign_coords(axle=("axle", list(model.wheelsets), {"long_name": "wheelset"}))
