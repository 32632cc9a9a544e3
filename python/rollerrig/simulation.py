"""One simulation: from a case to its results.

    Case -> model -> starting state -> [integration in slices] -> results.Dataset

The steps of the integrator do not depend on the slices (core/include/rollerrig/integrate/integrator.hpp): progress and
Ctrl-C cost no reproducibility.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig import _core
from rollerrig.actuators import assemble_with_actuators
from rollerrig.assembly import AssembledModel, assemble
from rollerrig.bench import BenchRun, users_controllers
from rollerrig.cases import as_case
from rollerrig.config import Case, ConfigError, ConfigProblem
from rollerrig.results import Outcome, add_energy_audit, add_termination, run_dataset
from rollerrig.starting_state import StartError, starting_state

__all__ = ["Progress", "StartError", "absolute_tolerances", "available_memory", "begin", "sample_count", "simulate"]

Vector = NDArray[np.float64]
Progress = Callable[[float, str], None]
"""Called with the fraction done and a short text."""

CHARACTERISTIC_RATE = 100.0
"""Rate that turns the tolerance of a displacement into that of its rate [1/s]."""

ENERGY_WARNING = 1e-3
"""Relative energy residual above which a run carries a warning [-]."""

_STATUS_NAMES = {code: name for name, code in _core.status_codes.items()}
_SLICE_SECONDS = 0.2
"""A slice should take this long: often enough for a progress bar and Ctrl-C."""


def simulate(
    case: Case | str, *, progress: Progress | None = None, controllers: Mapping[str, Any] | None = None
) -> xr.Dataset:
    """Run a case.

    Args:
        case: what to run, or its name in the catalogue; method, tolerances and output interval are those of `case.time`.
        progress: called several times a second with the fraction done and a short text.
        controllers: your own objects in place of the case's controllers, by table: 'slide_protection', 'wheel_slip_control',
            'rig_control' (docs/how_to/controller.md).

    Returns:
        The results, see docs: dimensions time, body, wheel, patch, element. A run that left the model's validity or was
        interrupted by Ctrl-C returns what was computed until then; the attributes `status` and `status_message` say so.

    Raises:
        ConfigError: the results would not fit in memory, the fixed step is unstable, or a disturbance moves what is
            locked.
        StartError: no equilibrium was found to start from.

    Example:
        >>> from rollerrig import load_case, simulate
        >>> case = load_case("wheelset_rollers").with_changes({"motion.speed": "36 km/h", "time.duration": "0.1 s"})
        >>> simulate(case)["lateral"].sel(body="wheelset_1").sizes["time"]
        51
    """
    case = as_case(case)
    if case.on_bench:
        return _simulate_on_bench(BenchRun(assemble_with_actuators(case), controllers), progress)
    model = assemble(case)
    users_controllers(case, controllers or {})
    simulation = _core.Simulation(model.core)
    times, rows = _allocate(case, simulation.width)
    begin(simulation, model, starting_state(simulation, model))
    try:
        code = _integrate(simulation, case, times, rows, progress)
    except KeyboardInterrupt:
        code = _core.status_codes["interrupted"]
    filled = int(np.count_nonzero(np.isfinite(times)))  # also what the last slice wrote before it was cut off
    run = run_dataset(model, times[:filled], rows[:filled], _outcome(simulation, model, code))
    return _with_warnings(add_energy_audit(add_termination(run, model)))


def _simulate_on_bench(bench: BenchRun, progress: Progress | None) -> xr.Dataset:
    _allocate(bench.case, bench.width)  # refuses what does not fit
    run = bench.run(sample_count(bench.case), progress)
    return _with_warnings(add_energy_audit(add_termination(run, bench.model)))


def begin(simulation: _core.Simulation, model: AssembledModel, state: Vector, *, start_time: float = 0.0) -> None:
    """Prepare a simulation with the settings of the model's case.

    Args:
        simulation: the simulation.
        model: its model.
        state: state at the start.
        start_time: time at the start [s].

    Raises:
        ConfigError: the fixed step is beyond the stability limit of the method at the start.
    """
    settings = model.case.time
    fixed = settings.has_fixed_step
    if fixed:
        _check_fixed_step(simulation, model.case, state)
    simulation.start(
        method=settings.method,
        step=(settings.step or 0.0) if fixed else 0.0,
        relative_tolerance=settings.relative_tolerance,
        absolute_tolerance=absolute_tolerances(simulation, settings.absolute_tolerance),
        initial_step=0.0 if fixed else settings.step or 0.0,
        maximum_step=settings.maximum_step or math.inf,
        final_time=settings.duration,
        output_step=settings.output_step,
        breakpoints=list(model.breakpoints),
        t0=start_time,
        x0=state,
    )


def _check_fixed_step(simulation: _core.Simulation, case: Case, state: Vector) -> None:
    """Refuse a step at which the method lets a decaying motion of the starting state grow.

    The motions that last or grow by themselves each own the eigenvalue of the step's amplification matrix nearest to
    exp(lambda step); no other one may lie outside the unit circle (docs/theory/time_integration.md, (T5)). Slow running
    and stiff springs and dampers make lambda large.
    """
    method, step = case.time.method, case.time.step or 0.0
    rates = np.linalg.eigvals(simulation.jacobian(0.0, state)[0])
    lasting = rates[rates.real >= -1.0]

    def stable(step: float) -> bool:
        factors = np.linalg.eigvals(simulation.step_amplification(method, step, 0.0, state))
        for factor in np.exp(step * lasting):
            factors = np.delete(factors, np.argmin(np.abs(factors - factor)))
        return bool(np.all(np.abs(factors) <= 1.0 + 1e-9))

    if stable(step):
        return
    allowed_step = step
    while not stable(allowed_step):
        allowed_step *= 0.97
    allowed = (
        f"allowed: at most {1e3 * allowed_step:.2g} ms, where {method} is stable at {3.6 * case.motion.speed:g} km/h in "
        "this case; or method = 'rodas4', which has no such limit"
    )
    raise ConfigError([ConfigProblem(case.name, "time.step", f"{1e3 * step:g} ms", allowed)])


def absolute_tolerances(simulation: _core.Simulation, displacement: float) -> list[float]:
    """Absolute tolerance of each state: of displacements as given [m, rad], of rates 100 1/s times that."""
    tolerances = [displacement] * simulation.state_count
    for row in simulation.rate_index:
        for index in row:
            if index >= 0:
                tolerances[index] = CHARACTERISTIC_RATE * displacement
    return tolerances


def _with_warnings(run: xr.Dataset) -> xr.Dataset:
    """The run with the attribute `warnings`: what limits its validity, one line each, or empty."""
    warnings = []
    if run.attrs["energy_relative_residual"] > ENERGY_WARNING:
        warnings.append(
            f"energy balance open by {100 * run.attrs['energy_relative_residual']:.2g} % of the energy turned over: the "
            "integration missed something (an impact, a stiff contact); use a smaller step, tolerance or maximum_step"
        )
    return run.assign_attrs(warnings="\n".join(warnings))


# ---------------------------------------------------------------------------------------------------- integration


def sample_count(case: Case) -> int:
    """Number of output times of a whole run, start and end included."""
    return math.floor(case.time.duration / case.time.output_step * (1 + 1e-12) + 1e-9) + 1


def available_memory() -> float:
    """Memory that a process can still get [bytes]; infinite where the system does not say."""
    try:
        with open("/proc/meminfo", encoding="ascii") as file:  # noqa: PTH123
            fields = dict(line.split(":", 1) for line in file)
        return 1024.0 * float(fields["MemAvailable"].split()[0])
    except (OSError, KeyError, ValueError, IndexError):
        return math.inf


def _allocate(case: Case, width: int) -> tuple[Vector, Vector]:
    """Room for all output times, taken once: a run needs no more memory at its end than at its start.

    Raises:
        ConfigError: the results, and the copy made when they are written, would not fit.
    """
    count = sample_count(case)
    needed, available = 2.0 * 8.0 * count * (width + 1), available_memory()
    if needed > 0.9 * available:
        least = case.time.duration / (count * 0.9 * available / needed)
        allowed = (
            f"allowed: at least {least:.2g} s for a run of {case.time.duration:g} s; {count} samples need "
            f"{needed / 1e9:.1f} GB of memory, {available / 1e9:.1f} GB are available"
        )
        raise ConfigError([ConfigProblem(case.name, "time.output_step", f"{case.time.output_step:g}", allowed)])
    return np.full(count, np.nan), np.empty((count, width))


def _integrate(simulation: _core.Simulation, case: Case, times: Vector, rows: Vector, progress: Progress | None) -> int:
    """Advance to the end, or to the first status that is not ok; returns its code."""
    ok: int = _core.status_codes["ok"]
    duration, filled, until = case.time.duration, 0, 0.0
    length = case.time.output_step
    shortest = 0.1 * length  # however slow the model is
    while until < duration:
        until = min(until + length, duration)
        begun = time.perf_counter()
        code, filled = simulation.advance(until, times, rows, filled)
        spent = time.perf_counter() - begun
        if code != ok:
            return code
        if progress is not None:
            speed = 3.6 * rows[filled - 1, -1]
            progress(until / duration, f"t = {until:.2f} s of {duration:g} s, {speed:.0f} km/h")
        if spent < 0.5 * _SLICE_SECONDS:
            length *= 2.0
        elif spent > 2.0 * _SLICE_SECONDS:
            length = max(0.5 * length, shortest)
    return ok


def _outcome(simulation: _core.Simulation, model: AssembledModel, code: int) -> Outcome:
    status = _STATUS_NAMES.get(code, "unknown")
    at = simulation.time
    blamed = simulation.failed_contact if status not in ("ok", "interrupted") else -1
    wheel = next((w.name for w in model.wheels if w.contact == blamed), "")
    message = _core.status_sentence(code)
    if status != "ok":
        place = f"t = {at:.4g} s" + (f", {wheel}" if wheel else "")
        message = f"{place}: {message}"
    return Outcome(status, message, at, wheel, simulation.statistics(), simulation.counters())
