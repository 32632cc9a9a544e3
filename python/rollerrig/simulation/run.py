"""One simulation: from a case to its results.

    Case -> model -> starting state -> [integration in slices] -> results.Dataset

The steps of the integrator do not depend on the slices (core/include/rollerrig/integrate/integrator.hpp): progress and
Ctrl-C cost no reproducibility.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.assembly.actuators import assemble_as_run
from rollerrig.assembly.model import AssembledModel
from rollerrig.cases import as_case
from rollerrig.common.arrays import Array, Complex
from rollerrig.common.linear_algebra import eigenvalues
from rollerrig.config import Case, ConfigError, Rig
from rollerrig.results import COMPLETED, Draft, Outcome, add_energy_audit, add_termination, run_draft
from rollerrig.results.dataset import Recording, add_readings, drive_warning, readings_per_sample
from rollerrig.results.files import available_memory
from rollerrig.results.plausibility import plausibility_warnings
from rollerrig.results.summary import add_contact_losses, contact_loss_warning
from rollerrig.results.termination import FLEXIBLE, contact_in_words
from rollerrig.simulation.controllers import (
    MEASUREMENTS,
    ControllerError,
    UserController,
    ask,
    close_controllers,
    provenance_of,
    users_controllers,
    with_brake_unit,
)
from rollerrig.simulation.faults import add_signals_of_ours, faulty_roles, refuse_faults, with_faults
from rollerrig.simulation.mechatronics import mechatronic_setup
from rollerrig.simulation.starting_state import left_the_rollers, recorded_state, starting_state

Progress = Callable[[float, str], None]
"""Called with the fraction done and a short text."""

CHARACTERISTIC_RATE = 100.0
"""Rate that turns the tolerance of a displacement into that of its rate [1/s]."""

SURELY_THERE = 64e6
"""Memory that need not be asked for [bytes]."""

_VALID = "the results up to this time are valid"
"""What the core says of some runs that end early, before their energy is audited."""

ENERGY_WARNING = 1e-3
"""Relative energy residual above which a run carries a warning [-]."""

_STATUS_NAMES = {code: name for name, code in _core.status_codes.items()}
_BLAMELESS = ("ok", "interrupted", "stopped", "rollers_protected", "controller_failed")
"""Statuses that no wheel has brought about."""
_LARGEST = 1e5
"""Displacement [m, rad] or rate [m/s, rad/s] beyond which nothing is said of the contact."""
_SLICE_SECONDS = 0.2
"""A slice should take this long: often enough for a progress bar and Ctrl-C."""


def simulate(
    case: Case | str,
    *,
    progress: Progress | None = None,
    controllers: Mapping[str, Any] | None = None,
    allow_unrestrained: bool = False,
) -> xr.Dataset:
    """Run a case.

    Args:
        case: what to run, or its name in the catalogue; method, tolerances and output interval are those of `case.time`.
        progress: called several times a second with the fraction done and a short text.
        controllers: your own objects in place of the case's controllers, by table: 'slide_protection', 'wheel_slip_control',
            'rig_control', or 'brake_unit' of [brake] (docs/how_to/controller.md).
        allow_unrestrained: run also a vehicle on rollers that nothing holds along the track, until it has rolled off them.

    Returns:
        The results, see docs: dimensions time, body, wheel, patch, element. A run that left the model's validity or was
        interrupted by Ctrl-C returns what was computed until then; the attributes `status` and `status_message` say so.

    Raises:
        ConfigError: the results would not fit in memory, the fixed step is unstable, a disturbance moves what is locked, or
            nothing holds the vehicle along the track on its rollers.
        StartError: no equilibrium was found to start from.

    Example:
        >>> from rollerrig import load_case, simulate
        >>> case = load_case("wheelset_rollers").with_changes({"motion.speed": "36 km/h", "time.duration": "0.1 s"})
        >>> simulate(case)["lateral"].sel(body="wheelset_1").sizes["time"]
        51
    """
    case = as_case(case)
    case = with_brake_unit(case, {*(controllers or {}), *faulty_roles(case)})
    users = users_controllers(case, controllers or {})
    model = assemble_as_run(case)
    asked = with_faults(model, users)
    step = case.time.output_step / readings_per_sample(case)
    simulation = prepare(model, asked, allow_unrestrained=allow_unrestrained, output_step=step)
    recording = _room(case, simulation.width, simulation.reading_width)
    if recording.every > 1:
        simulation.keep_readings(recording.every, recording.reading_times, recording.readings)
    failure = ""
    try:
        code, _ = march(
            simulation,
            case.time.duration,
            recording.times,
            recording.rows,
            slice_length=case.time.output_step,
            users=asked,
            report=progress and _reporter(case, recording.rows, progress),
        )
    except KeyboardInterrupt:
        code = _core.status_codes["interrupted"]
    except ControllerError as error:
        code, failure = _core.status_codes["controller_failed"], str(error)
    finally:
        close_controllers(users)
    ended = outcome(simulation, model, code, failure)
    return _results(model, recording, simulation, ended, users, asked)


def _results(
    model: AssembledModel,
    recording: Recording,
    simulation: _core.Simulation,
    ended: Outcome,
    users: Mapping[str, UserController],
    asked: Mapping[str, UserController],
) -> xr.Dataset:
    """The Dataset of a run with all its attributes; `asked` are its users' controllers, and those that have faults."""
    filled, read = recording.filled, simulation.reading_count
    if ended.status not in COMPLETED:  # what became infinite, or whose square would, is no result
        beyond = np.flatnonzero((np.abs(recording.rows[:filled]) > 1e150).any(axis=1))
        if len(beyond):
            filled = int(beyond[0])
            read = int(np.searchsorted(recording.reading_times[:read], recording.times[filled]))
    draft = run_draft(model, recording.times[:filled], recording.rows[:filled], ended)
    add_readings(draft, model, recording.reading_times[:read], recording.readings[:read])
    if ("wheel_slip_control" if model.case.slide_protection is None else "slide_protection") in users:
        for name in ("reference_speed", "reference_speed_error"):  # inside of a user's, which nobody knows
            dims, values, attributes = draft.variables[name]
            draft.variables[name] = (dims, np.full_like(values, np.nan), attributes)
    add_signals_of_ours(draft, asked)
    add_termination(draft, model)
    spells = simulation.contact_losses()
    names = [wheel.name for wheel in model.wheels]
    losses = add_contact_losses(draft, names, [spells[wheel.contact] for wheel in model.wheels])
    add_energy_audit(draft)
    times, support = draft.values("time"), model.case.support.data
    duration = float(np.ptp(times)) if len(times) else 0.0
    on_rollers = isinstance(support, Rig)
    advice = "" if on_rollers or model.rails else FLEXIBLE
    lost = contact_loss_warning(losses, duration, on_rollers=on_rollers, advice=advice)
    draft.attributes.update(provenance_of(users))
    energy = _energy_warning(draft, advice)
    if energy:
        message = draft.attributes["status_message"]
        draft.attributes["status_message"] = message.replace(_VALID, "its energy balance is open, see the warning")
    own = (energy, lost, drive_warning(draft), *plausibility_warnings(draft, model))
    draft.attributes["warnings"] = "\n".join(filter(None, own))
    return draft.dataset()


def _energy_warning(draft: Draft, advice: str) -> str:
    """A line where the energy balance is not closed."""
    residual = draft.attributes["energy_relative_residual"]
    if residual <= ENERGY_WARNING:
        return ""
    if not math.isfinite(residual):
        return "energy balance open: energies of the run are not finite; reduce the step or the tolerance"
    return (
        f"energy balance open by {100 * residual:.2g} % of the energy turned over: the "
        "integration missed something (an impact, a stiff contact); use a smaller step, tolerance or maximum_step"
        f"{'. ' if advice else ''}{advice}"
    )


def prepare(
    model: AssembledModel,
    users: Mapping[str, UserController] | None = None,
    *,
    allow_unrestrained: bool = False,
    output_step: float | None = None,
) -> _core.Simulation:
    """A simulation of a model with everything that acts on it, at its start.

    Args:
        model: assembled with its actuators.
        users: the user's controllers, by table of the case.
        allow_unrestrained: also where nothing holds the vehicle along the track on its rollers.
        output_step: interval of what it records [s]; None: that of the case.

    Raises:
        ConfigError: the fixed step is unstable, a disturbance moves what is locked, or nothing holds the vehicle on its rollers.
        StartError: no equilibrium was found to start from.
    """
    if not users:
        refuse_faults(model.case)
    start = starting_state(model, allow_unrestrained=allow_unrestrained)
    simulation = _core.Simulation(model.core, mechatronic_setup(model, users))
    begin(simulation, model, start, output_step=output_step)
    return simulation


def begin(
    simulation: _core.Simulation,
    model: AssembledModel,
    state: Array,
    *,
    start_time: float = 0.0,
    end_time: float | None = None,
    output_step: float | None = None,
) -> None:
    """Prepare a simulation with the settings of the model's case.

    Args:
        simulation: the simulation.
        model: its model.
        state: state at the start.
        start_time: time at the start [s].
        end_time: which a step ends at exactly [s]; None: the duration of the case.
        output_step: interval of what it records [s]; None: that of the case.

    Raises:
        ConfigError: the fixed step is beyond the stability limit of the method at the start.
    """
    check_fixed_step(simulation, model.case, state)
    settings = integrator_settings(simulation, model)
    if end_time is not None:
        settings["final_time"] = end_time
    step = model.case.time.output_step if output_step is None else output_step
    simulation.start(_core.Options(**settings, output_step=step), t0=start_time, x0=state)


def integrator_settings(simulation: _core.Simulation, model: AssembledModel) -> dict[str, Any]:
    """Method, step, tolerances, end and breakpoints of the model's case, by the core's names."""
    settings, own = model.case.time, model.case.integration
    return {
        "method": own.method,
        "step": (own.step or 0.0) if own.fixed else 0.0,
        "relative_tolerance": settings.relative_tolerance,
        "absolute_tolerance": absolute_tolerances(simulation, settings.absolute_tolerance, model.case),
        "initial_step": 0.0 if own.fixed else own.step or 0.0,
        "maximum_step": settings.maximum_step or math.inf,
        "final_time": settings.duration,
        "breakpoints": list(model.breakpoints),
    }


def check_fixed_step(simulation: _core.Simulation, case: Case, state: Array) -> None:
    """Refuse a step that is beyond the stability limit of the case's method at the start: a decaying motion there would grow.

    The motions that last or grow by themselves each own the eigenvalue of the step's amplification matrix nearest to
    exp(lambda step); no other one may lie outside the unit circle (docs/theory/time_integration.md, (T5)). Slow running
    and stiff springs and dampers make lambda large.

    Raises:
        ConfigError: it is; the message says which would not be.
    """
    method, step = case.integration.method, case.integration.step or 0.0
    if method not in ("rk4", "exponential_rk4"):
        return

    @cache
    def lasting() -> Complex:
        rates = eigenvalues(simulation.jacobian(0.0, state)[0])
        return rates[rates.real >= -1.0]

    def stable(step: float) -> bool:
        factors = eigenvalues(simulation.step_amplification(method, step, 0.0, state))
        if np.all(np.abs(factors) <= 1.0 + 1e-9):
            return True
        for factor in np.exp(step * lasting()):
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
    raise ConfigError.of(case.name, "time.step", f"{1e3 * step:g} ms", allowed)


def absolute_tolerances(simulation: _core.Simulation, displacement: float, case: Case) -> list[float]:
    """Absolute tolerance of each state: of displacements as given [m, rad], of rates 100 1/s times that.

    Of a scaled model what these are at full scale: its steps are then those of the full-scale run.
    """
    length, seconds = (case.similitude.length, case.similitude.time) if case.similitude else (1.0, 1.0)
    tolerances = [displacement] * simulation.state_count
    for places, factor in ((simulation.coordinate_index, 1.0), (simulation.rate_index, CHARACTERISTIC_RATE * seconds)):
        for body in places:
            for k, index in enumerate(body):
                if index >= 0:
                    tolerances[index] = factor * displacement * (1.0 if k < 3 else length)
    return tolerances


# ---------------------------------------------------------------------------------------------------- integration


def sample_count(case: Case) -> int:
    """Number of output times of a whole run, start and end included."""
    return math.floor(case.time.duration / case.time.output_step * (1 + 1e-12) + 1e-9) + 1


def _room(case: Case, width: int, columns: int) -> Recording:
    """Room for all output times and readings, taken once: a run needs no more memory at its end than at its start.

    Raises:
        ConfigError: the results, and the copy made when they are written, would not fit.
    """
    count, every = sample_count(case), readings_per_sample(case)
    needed = 2.0 * 8.0 * Recording.size(count, width, every, columns)
    if needed > SURELY_THERE and needed > 0.9 * (available := available_memory()):
        least = case.time.duration / (count * 0.9 * available / needed)
        allowed = (
            f"allowed: at least {least:.2g} s for a run of {case.time.duration:g} s; {count} samples need "
            f"{needed / 1e9:.1f} GB of memory, {available / 1e9:.1f} GB are available"
        )
        raise ConfigError.of(case.name, "time.output_step", f"{case.time.output_step:g}", allowed)
    return Recording(count, width, every, columns)


def march(
    simulation: _core.Simulation,
    until: float,
    times: Array,
    rows: Array,
    *,
    slice_length: float,
    begin_at: float = 0.0,
    users: Mapping[str, UserController] | None = None,
    report: Callable[[float, int], None] | None = None,
) -> tuple[int, int]:
    """Advance a simulation that has begun, in slices that last about 0.2 s of the clock.

    Args:
        simulation: the simulation.
        until: time of the end [s].
        times: room for the output times, shape (time,).
        rows: and for what is recorded, shape (time, width).
        slice_length: of the first slice [s].
        begin_at: time at which the simulation stands [s].
        users: the user's controllers, asked at their instants.
        report: called after each slice with the time [s] and the number of rows.

    Returns:
        Code of the first status that is not ok, or of ok; and the rows filled.

    Raises:
        ControllerError: a controller of the user gave no usable command.
    """
    ok: int = _core.status_codes["ok"]
    code, filled, at, length = ok, 0, begin_at, slice_length
    while code == ok and at < until:
        at = min(at + length, until)
        clock = time.perf_counter()
        code, filled = simulation.advance(at, times, rows, filled)
        while code == ok and _answer(simulation, users or {}):
            code, filled = simulation.advance(at, times, rows, filled)
        elapsed = time.perf_counter() - clock
        if code == ok and report is not None:
            report(at, filled)
        if elapsed < 0.5 * _SLICE_SECONDS:
            length *= 2.0
        elif elapsed > 2.0 * _SLICE_SECONDS:
            length = max(0.5 * length, 0.1 * slice_length)  # however slow the model is
    return code, filled


def _answer(simulation: _core.Simulation, users: Mapping[str, UserController]) -> bool:
    """Ask the user's controllers that are waited for; whether there was one."""
    due = [role for role in users if simulation.waits_for(role)]
    for role in due:
        rows = np.array(simulation.measurement(role)).reshape(-1, len(MEASUREMENTS))
        measurements = {"time": simulation.time, **dict(zip(MEASUREMENTS, rows.T, strict=True))}
        simulation.set_command(role, ask(users[role], role, measurements).tolist())
    return bool(due)


def _reporter(case: Case, rows: Array, progress: Progress) -> Callable[[float, int], None]:
    """Progress of a run as a whole, with the speed of the train or of the rollers."""
    duration, column = case.time.duration, -len(_core.train_fields) if case.sampled else -1

    def report(at: float, filled: int) -> None:
        speed = 3.6 * rows[max(0, filled - 1), column]
        progress(at / duration, f"t = {at:.2f} s of {duration:g} s, {speed:.0f} km/h")

    return report


def outcome(simulation: _core.Simulation, model: AssembledModel, code: int, failure: str = "") -> Outcome:
    """How a run of a model ended, from the code of its status; `failure`: what a controller of the user did wrong."""
    status = _STATUS_NAMES.get(code, "unknown")
    at = simulation.time
    blamed = simulation.failed_contact if status not in _BLAMELESS else -1
    wheel = next((w.name for w in model.wheels if w.contact == blamed), "")
    lost = status in ("contact_lost", "rollers_protected", "not_finite")
    message = failure or (lost and left_the_rollers(simulation, model)) or _core.status_sentence(code)
    if status != "ok" and not failure:
        place = f"t = {at:.4g} s" + (f", {wheel}" if wheel else "")
        message = f"{place}: {message}"
    if wheel and np.all(np.abs(simulation.state) < _LARGEST):
        message += contact_in_words(model, wheel, status, recorded_state(simulation, model, simulation.state, at))
    return Outcome(status, message, at, wheel, simulation.statistics(), simulation.counters())
