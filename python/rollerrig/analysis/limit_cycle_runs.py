"""Runs of a case until they have settled, each from the last state of the one before.

Case, speed, last state -> [settling_run: windows of time until settled] -> CyclePoint, last state; Diagram -> Dataset
"""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.analysis.hunting import NOT_DECIDED, HuntingSettings, hunting_case, not_decided
from rollerrig.analysis.limit_cycle import CyclePoint, Decision, Diagram, decide
from rollerrig.analysis.signals import half_waves
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.common.arrays import Array
from rollerrig.config import Case
from rollerrig.results import run_dataset, variable
from rollerrig.simulation.run import Progress, begin, march, outcome
from rollerrig.simulation.starting_state import starting_state

LastState = tuple[float, Array]  # speed [m/s] and state in which a run ended

PITCH = 4
SAMPLES_BY = 8  # rows of results beyond those a window needs


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
    run = _Windows(simulation, model, settings)
    while not run.finished:
        if progress is not None:
            progress(run.time / settings.longest, f"{3.6 * speed:.0f} km/h")  # Ctrl-C arrives here
        run.advance()
    point = run.point(speed)
    return point, (speed, simulation.state) if point.amplitude > 0.0 and point.status == "ok" else None


def at_other_speed(simulation: _core.Simulation, model: AssembledModel, state: LastState, speed: float) -> Array:
    """A state at another speed [m/s]: wheelsets and rollers turn in proportion, all else stays as it is."""
    before, values = state
    changed = np.array(values)
    spins = [simulation.rate_index[model.body_index(body)][PITCH] for body in (*model.wheelsets, *model.rollers)]
    changed[[spin for spin in spins if spin >= 0]] *= speed / before
    return changed


class _Windows:
    """A run in windows of time, and the amplitude in each; `time` is how far it is [s]."""

    def __init__(self, simulation: _core.Simulation, model: AssembledModel, settings: LimitCycleSettings) -> None:
        self._simulation, self._model, self._settings = simulation, model, settings
        self._amplitudes: list[float] = []
        self._parts: list[xr.Dataset] = []
        self.time, self._window = 0.0, settings.window
        self._code: int = _core.status_codes["ok"]

    @property
    def finished(self) -> bool:
        """Whether it is decided, has lasted long enough, or left the model's validity."""
        return self._code != _core.status_codes["ok"] or self._is_over or self._decision != "open"

    @property
    def _is_over(self) -> bool:
        return self.time >= self._settings.longest * (1 - 1e-9)

    @property
    def _decision(self) -> Decision:
        return decide(self._amplitudes, self._window, ended=self._is_over)

    def advance(self) -> None:
        """One window more."""
        step = self._settings.output_step
        until = min(self.time + self._window, self._settings.longest)
        room = math.ceil((until - self.time) / step) + SAMPLES_BY
        times, rows = np.empty(room), np.empty((room, self._simulation.width))
        self._code, filled = march(self._simulation, until, times, rows, slice_length=self._window, begin_at=self.time)
        data = run_dataset(
            self._model, times[:filled], rows[:filled], outcome(self._simulation, self._model, self._code)
        )
        part = data[["lateral", "lateral_force"]].sel(body=list(self._model.wheelsets)).load()
        self._parts = [*self._parts[-2:], part]
        self.time = until
        lateral = part["lateral"].to_numpy()
        self._amplitudes.append(0.5 * float(np.ptp(lateral, axis=0).max()) if len(lateral) else 0.0)
        frequency = self._frequency()
        if frequency * self._window < 3.0 and len(self._amplitudes) == 1 and frequency > 0.0:
            self._window = 4.0 / frequency  # slow running: fewer than three waves say little about the amplitude
            self._amplitudes.clear()

    def _frequency(self) -> float:
        lateral = xr.concat([part["lateral"] for part in self._parts], "time")
        most = int(np.argmax(np.ptp(lateral.to_numpy(), axis=0)))
        signal = lateral.to_numpy()[:, most]
        waves = half_waves(lateral["time"].to_numpy(), signal, 0.25 * 0.5 * float(np.ptp(signal)) + 1e-9)
        return 0.5 / float(waves.duration.mean()) if len(waves.duration) > 1 else 0.0

    def _rate(self) -> float:
        last = self._amplitudes[-4:]
        if len(last) < 2 or min(last) <= 0.0:
            return math.nan
        return float(np.polyfit(self._window * np.arange(len(last)), np.log(last), 1)[0])

    def point(self, speed: float) -> CyclePoint:
        """What the run ended in."""
        ended = outcome(self._simulation, self._model, self._code)
        status, message = ended.status, ended.message
        rate, amplitude = self._rate(), self._amplitudes[-1] if self._amplitudes else 0.0
        if status == "ok" and self._decision == "decays":
            return CyclePoint(speed, 0.0, rate=rate, duration=self.time)
        if status == "ok" and self._decision == "open":
            status, message = NOT_DECIDED, not_decided(self.time, amplitude, rate)
        last = self._parts[-1]
        largest = {name: float(abs(one).max()) if one.size else math.nan for name, one in last.items()}
        return CyclePoint(
            speed=speed,
            amplitude=amplitude if status == "ok" else math.nan,
            peak=largest["lateral"],
            frequency=self._frequency() or math.nan,
            guiding_force=largest["lateral_force"],
            rate=rate,
            duration=self.time,
            status=status,
            message="" if status == "ok" else message,
        )


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
