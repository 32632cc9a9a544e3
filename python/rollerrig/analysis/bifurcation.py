"""The branch of limit cycles that begins at the linear critical speed, stable and unstable ones, with its folds.

    Case -> [linear critical speed and its mode] -> a small limit cycle -> [shooting] -> the next amplitude ... -> Dataset

A limit cycle is a state x to which the vehicle comes back after a period T: phi_T(x; V) = x. It is looked for at a turning point
of the leading wheelset's lateral motion, y' = 0, y = y_0 + A, with the amplitude A given and the speed V to be found: then stable
and unstable cycles are found alike, and the branch passes its folds without turning back. One step of Newton's method is

    (M - 1) dx + f(phi_T) dT + (d phi_T / dV) dV = x - phi_T(x; V),    dy = dy' = 0,    M = d phi_T / dx

with M, the monodromy matrix, and d phi_T/dV from exact Jacobians along the run (core/include/rollerrig/simulate/tangent_run.hpp).
The eigenvalues of M on the section y' = 0 are the Floquet multipliers: what becomes of a small deviation in a period; the cycle
is stable where all lie within the unit circle. The same system gives dV/dA: it changes its sign at a fold, where a stable and an
unstable cycle meet. The lowest speed of a stable cycle, as a rule that of a fold, is the nonlinear critical speed: from it on a
disturbance that is large enough ends in a limit cycle of this branch.
Source: Seydel, Practical Bifurcation and Stability Analysis, 3rd ed. (2010), chapter 7; for railway vehicles Kaas-Petersen,
Chaos in a railway bogie, Acta Mechanica 61 (1986).
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.analysis import SPEEDS_KMH
from rollerrig.analysis.mode_table import first_onset, modes_over_speed, zero_crossings
from rollerrig.analysis.modes import Lineariser, eigensystem
from rollerrig.cases import as_case
from rollerrig.common.arrays import Array, Complex
from rollerrig.common.linear_algebra import one_blas_thread
from rollerrig.config import Case
from rollerrig.results import variable
from rollerrig.simulation.run import Progress, integrator_settings

FIRST_AMPLITUDE, LARGEST_AMPLITUDE = 1e-4, 6e-3
"""Amplitudes between which the branch is followed unless another end is asked for [m]."""

LONGEST_STEP, SHORTEST_STEP = 5e-4, 1e-5  # steps from one amplitude to the next [m]
STEP, TOLERANCE = 1e-3, 1e-6  # longest step of a run at full scale [s], and its relative tolerance
CLOSED = 3e-5  # part of its amplitude by which a limit cycle may miss itself after a period [-]
FOLD_WIDTH = 0.002  # to which the speed of a fold is found [m/s]

_MOST_ITERATIONS, _FEW_ITERATIONS = 8, 4
_RATE = 100.0  # turns an error of a velocity into that of a displacement [1/s]

_LATERAL, _PITCH, _OK = 1, 4, _core.status_codes["ok"]


@dataclass(frozen=True)
class Cycle:
    """A limit cycle."""

    # of the leading wheelset's lateral motion, from its equilibrium to the turning point on the left [m]
    amplitude: float
    speed: float  # [m/s]
    period: float  # [s]
    state: Array  # at that turning point, without the rates of driven rollers, shape (n,)
    multipliers: Complex  # Floquet multipliers, largest first, shape (n - 1,)
    tangent: Array  # how state, period and speed change with the amplitude, shape (n + 2,)
    missed: float  # by how much it missed itself after a period, in displacements [m]

    @property
    def stable(self) -> bool:
        """Whether every small deviation decays."""
        return bool(abs(self.multipliers[0]) < 1.0)

    @property
    def slope(self) -> float:
        """dV/dA [1/s]."""
        return float(self.tangent[-1])


def bifurcation(
    case: Case | str,
    speeds_kmh: Sequence[float] = SPEEDS_KMH,
    largest: float = LARGEST_AMPLITUDE,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Follow the limit cycles that begin at the linear critical speed, over their amplitude.

    Args:
        case: what runs, or its name in the catalogue; without actuators, speed-controlled, on smooth rollers or rails.
        speeds_kmh: where the linear critical speed is looked for [km/h], rising; the branch ends where it leaves them.
        largest: amplitude at which the branch ends [m].
        progress: called with the part of the amplitudes that is done and a short text.

    Returns:
        Over `cycle`, by amplitude: `amplitude` [m], `speed` [km/h], `frequency` [Hz], `multiplier`, the largest magnitude of a
        Floquet multiplier, `stable`, `speed_slope` [km/h per mm], `missed` [m]. Attributes: `linear_critical_speed_kmh`;
        `nonlinear_critical_speed_kmh`, the lowest of a stable limit cycle of the branch, NaN where none is stable; `folds`, a
        list as JSON of speed_kmh and amplitude_mm; `ended`, why the branch ends where it does.

    Raises:
        ValueError: no oscillation begins to grow at these speeds.
        StartError: no rolling equilibrium at one of the speeds.

    Example:
        >>> import rollerrig as rr
        >>> branch = rr.bifurcation("cooperrider_bogie", range(220, 281, 10), largest=1e-3)
        >>> bool(branch["stable"].all())
        False
    """
    case = as_case(case)
    modes = modes_over_speed(case, [v / 3.6 for v in speeds_kmh])
    onset = first_onset(zero_crossings(modes))
    if onset is None:
        raise ValueError(f"speeds_kmh: {case.name} has no linear critical speed between them; give higher ones")
    shooting = _Shooting(modes.lineariser, onset.speed, onset.frequency)
    limits = (speeds_kmh[0] / 3.6, speeds_kmh[-1] / 3.6)
    with one_blas_thread():
        cycles, ended = _follow(shooting, limits, largest, progress or (lambda _fraction, _text: None))
        cycles = _with_folds(shooting, cycles)
    return _dataset(case, cycles, onset.speed, ended)


@dataclass(frozen=True)
class _Period:
    """What a run of one period says: end state, M, d(phi - x)/dV of a wheelset that goes on rolling, f at the end."""

    end: Array
    monodromy: Array
    by_speed: Array
    slope: Array


class _Shooting:
    """Newton's method for one limit cycle."""

    def __init__(self, lineariser: Lineariser, speed: float, frequency: float) -> None:
        self._lineariser, self._speed = lineariser, speed
        here = lineariser.at(speed)
        self._rest, self._model = here.equilibrium, lineariser.model
        simulation, kept = lineariser.simulation_at(speed), lineariser.kept
        coordinates = min(i for rates in simulation.rate_index for i in rates if i >= 0)
        rate = simulation.rate_index[self._model.body_index(self._model.wheelsets[0])][_LATERAL]
        lateral = int(np.flatnonzero(simulation.jacobian(0.0, self._rest)[0][:coordinates, rate])[0])
        self._kept, self._driven = kept, np.setdiff1d(np.arange(simulation.state_count), kept)
        self._y, self._rate = (int(np.searchsorted(kept, i)) for i in (lateral, rate))
        self._free = np.setdiff1d(np.arange(len(kept)), (self._y, self._rate))
        self._weight = np.where(kept < coordinates, 1.0, 1.0 / _RATE)
        spins = [simulation.rate_index[self._model.body_index(name)][_PITCH] for name in self._model.wheelsets]
        self._rolls = np.where(np.isin(kept, spins), self._rest[kept] / speed, 0.0)
        system = eigensystem(here.matrix)
        mode = system.vectors[:, int(np.argmin(np.abs(system.values - 2j * math.pi * frequency)))]
        tangent = np.concatenate([(mode / mode[self._y]).real, [0.0, 0.0]])
        self.rest = Cycle(0.0, speed, 1.0 / frequency, self._rest[kept], np.ones(1, dtype=complex), tangent, 0.0)

    def cycle(self, amplitude: float, near: Cycle) -> tuple[Cycle | None, int]:
        """The limit cycle of an amplitude [m] from one nearby, None where there is none; and the iterations."""
        change = (amplitude - near.amplitude) * near.tangent
        state, period, speed = near.state + change[:-2], near.period + change[-2], near.speed + change[-1]
        state[self._y], state[self._rate] = self._rest[self._kept[self._y]] + amplitude, 0.0
        before = math.inf
        for iteration in range(1, _MOST_ITERATIONS + 1):
            run = self._period(state, period, speed)
            if run is None:
                break
            residual = state - run.end
            missed = float(np.abs(self._weight * residual).max())
            returns = run.monodromy - np.eye(len(state))
            system = np.column_stack([returns[:, self._free], run.slope, run.by_speed])
            if missed < CLOSED * amplitude:
                tangent = self._solved(system, -returns[:, self._y], 1.0)
                return Cycle(amplitude, speed, period, state, self._multipliers(run), tangent, missed), iteration
            change = self._solved(system, residual, 0.0)
            state, period, speed = state + change[:-2], period + change[-2], speed + change[-1]
            near_it = 0.3 * near.period < period < 3.0 * near.period and 0.3 * near.speed < speed < 3.0 * near.speed
            if not (missed < 2.0 * before and near_it):
                break
            before = missed
        return None, _MOST_ITERATIONS

    def _solved(self, system: Array, right: Array, lateral: float) -> Array:
        """State, period and speed from the unknowns of a system, with what is prescribed; wheelsets roll with the speed."""
        solution = np.linalg.solve(system, right)
        out = np.zeros(len(self._kept) + 2)
        out[self._free], out[self._y], out[-2:] = solution[:-2], lateral, solution[-2:]
        out[:-2] += self._rolls * out[-1]
        return out

    def _multipliers(self, run: _Period) -> Complex:
        """Eigenvalues of M on the section y' = 0, along the flow."""
        returned = run.monodromy - np.outer(run.slope, run.monodromy[self._rate]) / run.slope[self._rate]
        values = np.linalg.eigvals(np.delete(np.delete(returned, self._rate, 0), self._rate, 1))
        return np.asarray(values[np.argsort(-np.abs(values))], dtype=np.complex128)

    def _period(self, state: Array, period: float, speed: float) -> _Period | None:
        """A run of one period; None where it ends early."""
        width = 1e-5 * speed
        changes = (0.0, width, -width)
        run, above, below = (self._start(state + one * self._rolls, period, speed + one) for one in changes)
        directions = np.eye(len(self._rest))[:, self._kept]
        tangents = _core.TangentRun(run, [(above, below, width, True)], np.ascontiguousarray(directions), [], [])
        if tangents.advance(period) != _OK:
            return None
        found, end = tangents.tangents[self._kept], run.state
        slope = run.derivative(period, end)[0]
        return _Period(end[self._kept], found[:, 1:], found[:, 0] - self._rolls, slope[self._kept])

    def _start(self, state: Array, period: float, speed: float) -> _core.Simulation:
        simulation, case = self._lineariser.simulation_at(speed), self._lineariser.case
        settings = integrator_settings(simulation, self._model) | {
            "method": "exponential_adams",
            "step": STEP / (case.similitude.time if case.similitude else 1.0),
            "relative_tolerance": TOLERANCE,
            "final_time": period,
        }
        whole = self._rest.copy()
        whole[self._kept] = state
        whole[self._driven] *= speed / self._speed
        simulation.start(_core.Options(**settings, output_step=period), t0=0.0, x0=whole)
        return simulation


def _follow(
    shooting: _Shooting, limits: tuple[float, float], largest: float, progress: Progress
) -> tuple[list[Cycle], str]:
    """Cycles of rising amplitude, and why they end."""
    cycles, last, step = list[Cycle](), shooting.rest, min(FIRST_AMPLITUDE, largest)
    while True:
        amplitude = min(last.amplitude + step, largest)
        progress(last.amplitude / largest, f"{3.6 * last.speed:.1f} km/h, {1e3 * last.amplitude:.2f} mm")
        found, iterations = shooting.cycle(amplitude, last)
        if found is None:
            step *= 0.5
            if step < SHORTEST_STEP:
                why = "none is found beyond it, the contacts are too rough there"
                return cycles, f"at {1e3 * last.amplitude:.2f} mm: {why}"
            continue
        if not limits[0] <= found.speed <= limits[1]:
            return cycles, f"at {1e3 * last.amplitude:.2f} mm, where it leaves the speeds asked for"
        cycles.append(found)
        last = found
        if found.amplitude >= largest:
            return cycles, f"at the largest amplitude asked for, {1e3 * largest:g} mm"
        step = min(LONGEST_STEP, 1.5 * step if iterations <= _FEW_ITERATIONS else step)


def _with_folds(shooting: _Shooting, cycles: list[Cycle]) -> list[Cycle]:
    """The same with cycles around each fold, narrowed down to FOLD_WIDTH."""
    found = list(cycles)
    for left, right in zip(cycles, cycles[1:], strict=False):
        for _ in range(_MOST_ITERATIONS):
            width = right.amplitude - left.amplitude
            if not (left.slope * right.slope < 0.0 and width * min(abs(left.slope), abs(right.slope)) > FOLD_WIDTH):
                break
            fold, _ = shooting.cycle(left.amplitude + width * _extreme(left, right), left)
            if fold is None:
                break
            found.append(fold)
            left, right = (fold, right) if left.slope * fold.slope > 0.0 else (left, fold)
    return sorted(found, key=lambda one: one.amplitude)


def _extreme(left: Cycle, right: Cycle) -> float:
    """Where the cubic through speeds and slopes has its extreme, as part of the way; not at an end: slopes jump at flanges."""
    width = right.amplitude - left.amplitude
    a, b, rise = width * left.slope, width * right.slope, right.speed - left.speed
    places = np.roots([3.0 * (a + b - 2.0 * rise), 2.0 * (3.0 * rise - 2.0 * a - b), a]).real
    return float(np.clip(min(places, key=lambda t: abs(t - 0.5)), 0.15, 0.85))


def _folds(cycles: Sequence[Cycle]) -> list[int]:
    """Places of those of all cycles at which the speed is an extreme."""
    rises = np.diff([one.speed for one in cycles])
    return [int(i) + 1 for i in np.flatnonzero(rises[:-1] * rises[1:] < 0.0)]


def _nonlinear_critical_speed(cycles: Sequence[Cycle], onset: float) -> float:
    """Lowest speed of a stable cycle [m/s]; its limits count: a fold, and the linear critical speed. NaN: none is stable."""
    stable = [one.stable for one in cycles]
    folds = [cycles[i].speed for i in _folds(cycles) if stable[i - 1] or stable[i + 1]]
    begins = [onset] if any(stable[:1]) else []
    return min([one.speed for one in cycles if one.stable] + folds + begins, default=math.nan)


COLUMNS: dict[str, tuple[Callable[[Cycle], float], str, str]] = {  # variable -> its value for a cycle, unit and meaning
    "amplitude": (lambda one: one.amplitude, "m", "lateral amplitude of the leading wheelset"),
    "speed": (lambda one: 3.6 * one.speed, "km/h", "running speed"),
    "frequency": (lambda one: 1.0 / one.period, "Hz", "frequency of the limit cycle"),
    "multiplier": (lambda one: abs(one.multipliers[0]), "1", "largest magnitude of a Floquet multiplier"),
    "stable": (lambda one: one.stable, "1", "whether every small deviation decays"),
    "speed_slope": (lambda one: 3.6e-3 * one.slope, "km/h per mm", "speed over amplitude along the branch"),
    "missed": (lambda one: one.missed, "m", "by how much it misses itself after a period"),
}


def _dataset(case: Case, cycles: Sequence[Cycle], onset: float, ended: str) -> xr.Dataset:
    variables = {
        name: variable("cycle", np.array([value(one) for one in cycles]), unit, meaning)
        for name, (value, unit, meaning) in COLUMNS.items()
    }
    folds = [{"speed_kmh": 3.6 * cycles[i].speed, "amplitude_mm": 1e3 * cycles[i].amplitude} for i in _folds(cycles)]
    attributes = {
        "title": f"Limit cycles of {case.name} over their amplitude",
        "case": case.name,
        "linear_critical_speed_kmh": 3.6 * onset,
        "nonlinear_critical_speed_kmh": 3.6 * _nonlinear_critical_speed(cycles, onset),
        "folds": json.dumps(folds),
        "ended": ended,
    }
    return xr.Dataset(variables, attrs=attributes)
