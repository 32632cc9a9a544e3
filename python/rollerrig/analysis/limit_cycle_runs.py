"""Runs of a case until they have settled, each from the last state of the one before.

Case, speed, last state -> [settling_run: windows of time until settled] -> CyclePoint, last state; Diagram -> Dataset
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.analysis.hunting import LATERAL, NOT_DECIDED, HuntingSettings, hunting_case, not_decided
from rollerrig.analysis.limit_cycle import CyclePoint, Diagram, decide
from rollerrig.analysis.signals import half_waves
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.common.arrays import Array
from rollerrig.config import Case
from rollerrig.results import run_dataset, variable
from rollerrig.simulation.run import Progress, begin, march, outcome
from rollerrig.simulation.starting_state import starting_state

LastState = tuple[float, Array]  # speed [m/s] and state in which a run ended

PITCH = 4
SAMPLES_BY = 8  # rows of results beyond one per output step


@dataclass(frozen=True)
class LimitCycleSettings:
    """How the runs are done."""

    disturbance: float = 3e-3  # lateral offset of the leading wheelset at the start of the downward sweep [m]
    perturbation: float = 1e-4  # the same on the upward sweep [m]
    window: float = 0.8  # pieces of a run between which amplitudes are compared [s]; four waves if that is longer
    longest: float = 16.0  # time after which a run ends, decided or not [s]
    output_step: float = 5e-3  # interval of the samples [s]
    relative_tolerance: float = 1e-4  # of the integrator
    absolute_tolerance: float = 1e-7  # of the integrator, for displacements [m]
    tolerance_kmh: float = 1.0  # to which the critical speed by continuation is found [km/h]


def settling_run(
    case: Case,
    settings: LimitCycleSettings,
    offset: float,
    speed: float,
    state: LastState | None,
    progress: Progress | None = None,
) -> tuple[CyclePoint, LastState | None]:
    """Run a case, speed-controlled at a speed [m/s], until it has settled.

    Args:
        case: what runs.
        settings: how the run is done.
        offset: lateral, of the leading wheelset, where it starts from the steady state [m].
        speed: running speed [m/s].
        state: limit cycle from which it starts; None: from the steady state, disturbed.
        progress: called with the fraction of the longest time and a short text.

    Returns:
        What it ends in, and the state there; None at rest or where the run did not come to its end.

    Raises:
        StartError: no state was found from which the run can start.
    """
    tolerances = settings.relative_tolerance, settings.absolute_tolerance
    hunting = HuntingSettings(offset, settings.longest, settings.output_step, *tolerances)
    model = assemble(hunting_case(case, speed, hunting))
    simulation = _core.Simulation(model.core)
    start = starting_state(model) if state is None else at_other_speed(simulation, model, state, speed)
    begin(simulation, model, start)
    point = _settled(simulation, model, settings, speed, progress)
    return point, (speed, simulation.state) if point.amplitude > 0.0 and point.status == "ok" else None


def _settled(
    simulation: _core.Simulation,
    model: AssembledModel,
    settings: LimitCycleSettings,
    speed: float,
    progress: Progress | None,
) -> CyclePoint:
    """What a run that has begun ends in, in windows of time until it is decided, over, or left the model's validity."""
    longest, step, window = settings.longest, settings.output_step, settings.window
    times, rows = (np.empty((math.ceil(longest / step) + SAMPLES_BY, *more)) for more in ((), (simulation.width,)))
    wheelsets = [model.body_index(name) * len(_core.body_fields) + LATERAL for name in model.wheelsets]
    code, at, ends, amplitudes, decision = _core.status_codes["ok"], 0.0, [0], list[float](), "open"
    while code == _core.status_codes["ok"] and at < longest * (1 - 1e-9) and decision == "open":
        if progress is not None:
            progress(at / longest, f"{3.6 * speed:.0f} km/h")  # Ctrl-C arrives here
        until, filled = min(at + window, longest), ends[-1]
        code, more = march(simulation, until, times[filled:], rows[filled:], slice_length=window, begin_at=at)
        at, ends = until, [*ends[-3:], filled + more]
        lateral = rows[filled : ends[-1], wheelsets]
        amplitudes.append(0.5 * float(np.ptp(lateral, axis=0).max()) if more else 0.0)
        frequency = _frequency(times[ends[0] : ends[-1]], rows[ends[0] : ends[-1], wheelsets])
        if 0.0 < frequency * window < 3.0 and len(amplitudes) == 1:
            window = 4.0 / frequency  # slow running: fewer than three waves say little about the amplitude
            amplitudes.clear()
        decision = decide(amplitudes, window, ended=at >= longest * (1 - 1e-9))
    ended, rate = outcome(simulation, model, code), _rate(amplitudes, window)
    status, message = ended.status, ended.message
    if status == "ok" and decision == "decays":
        return CyclePoint(speed, 0.0, rate=rate, duration=at)
    amplitude = amplitudes[-1] if amplitudes else 0.0
    if status == "ok" and decision == "open":
        status, message = NOT_DECIDED, not_decided(at, amplitude, rate)
    run = run_dataset(model, times[ends[-2] : ends[-1]], rows[ends[-2] : ends[-1]], ended)
    last = run[["lateral", "lateral_force"]].sel(body=list(model.wheelsets))
    largest = {name: float(abs(one).max()) if one.size else math.nan for name, one in last.items()}
    return CyclePoint(
        speed=speed,
        amplitude=amplitude if status == "ok" else math.nan,
        peak=largest["lateral"],
        frequency=frequency or math.nan,
        guiding_force=largest["lateral_force"],
        rate=rate,
        duration=at,
        status=status,
        message="" if status == "ok" else message,
    )


def _frequency(time: Array, lateral: Array) -> float:
    """Frequency of the wheelset that moves most [Hz]; 0: within less than two half-waves."""
    if not time.size:
        return 0.0
    signal = lateral[:, int(np.argmax(np.ptp(lateral, axis=0)))]
    waves = half_waves(time, signal, 0.25 * 0.5 * float(np.ptp(signal)) + 1e-9)
    return 0.5 / float(waves.duration.mean()) if len(waves.duration) > 1 else 0.0


def _rate(amplitudes: Sequence[float], window: float) -> float:
    """Growth rate of the last amplitudes [1/s]; NaN: there are too few."""
    last = amplitudes[-4:]
    if len(last) < 2 or min(last) <= 0.0:
        return math.nan
    return float(np.polyfit(window * np.arange(len(last)), np.log(last), 1)[0])


def at_other_speed(simulation: _core.Simulation, model: AssembledModel, state: LastState, speed: float) -> Array:
    """A state at another speed [m/s]: wheelsets and rollers turn in proportion, all else stays as it is."""
    before, values = state
    changed = np.array(values)
    spins = [simulation.rate_index[model.body_index(body)][PITCH] for body in (*model.wheelsets, *model.rollers)]
    changed[[spin for spin in spins if spin >= 0]] *= speed / before
    return changed


CYCLE_COLUMNS = {  # attribute of a CyclePoint -> unit and meaning in the table
    "speed": ("km/h", "running speed"),
    "amplitude": ("m", "half the range of the lateral displacement of the wheelset that moves most; 0: rest"),
    "peak": ("m", "largest lateral displacement of a wheelset"),
    "frequency": ("Hz", "frequency; NaN at rest"),
    "guiding_force": ("N", "largest |Y| of a wheel, unfiltered"),
    "rate": ("1/s", "growth rate of the amplitude at the end"),
    "duration": ("s", "simulated time"),
}


def limit_cycle_table(found: Diagram) -> xr.Dataset:
    """The diagram as a Dataset over `cycle_point`, first the upward sweep, then the downward sweep, by speed."""
    points, variables = [*found.up, *found.down], dict[str, object]()
    for name, (unit, meaning) in CYCLE_COLUMNS.items():
        values = np.array([getattr(point, name) for point in points], dtype=np.float64)
        values = 3.6 * values if unit == "km/h" else values
        variables[f"cycle_{name}"] = variable("cycle_point", values, unit, meaning)
    sweeps, statuses = ["up"] * len(found.up) + ["down"] * len(found.down), [point.status for point in points]
    for name, texts in (("sweep", sweeps), ("status", statuses)):
        variables[f"cycle_{name}"] = ("cycle_point", np.array(texts, dtype=str), {"long_name": f"{name} of the run"})
    attributes = {
        "critical_speed_by_continuation_kmh": 3.6 * found.lowest_cycle,
        "decays_kmh": 3.6 * found.decays,
        "jump_up_kmh": 3.6 * found.jumps,
        "bifurcation": found.kind,
        "continuation_tolerance_kmh": 3.6 * found.tolerance,
        "limit_cycles_interrupted": int(found.interrupted),
    }
    return xr.Dataset(variables, attrs=attributes)
