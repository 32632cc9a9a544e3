"""The rollers are slowly sped up (and slowed down again), and the bogie is perturbed now and then.

    Case, speeds, rate -> [ramp in segments] -> lateral motion over time and speed

A model has no irregularities: below the critical speed a disturbance decays to exact rest, and a bogie at exact rest stays
there far above the critical speed. So the bogie gets a sideways perturbation at regular steps of speed: a jump of the lateral
velocity of all its moving bodies. What is left of it before the next one shows whether disturbances grow or decay.
"""

import itertools
import json
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.analysis.hunting import HuntingSettings, audited, hunting_case, longest_step
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.common.arrays import Array
from rollerrig.config import Case
from rollerrig.simulation.run import Progress, begin, march
from rollerrig.simulation.starting_state import starting_state

LATERAL = 1


@dataclass(frozen=True)
class RampSettings:
    """How fast the rollers are sped up and how the bogie is perturbed."""

    low: float = 60 / 3.6  # speed at the start [m/s]
    high: float = 300 / 3.6  # highest speed [m/s]
    acceleration: float = 2 / 3.6  # of the rollers' surface [m/s^2]
    down: bool = True  # whether the rollers are slowed down to `low` again afterwards
    perturbation: float = 0.05  # jump of lateral velocity [m/s]; 0 for none
    perturbation_every: float = 10 / 3.6  # change of speed between perturbations [m/s]
    disturbance: float = 3e-3  # lateral offset of the leading wheelset at the start [m]


def ramp_run(job: tuple[Case, RampSettings, HuntingSettings], progress: Progress) -> xr.Dataset:
    """One ramp, up and down.

    Args:
        job: case, ramp, and settings of the integration (its duration is not used).
        progress: called with the fraction done and a short text.

    Returns:
        `lateral` [m] over time and body, `speed` [m/s] over time, and the times of the perturbations in the attributes. A run
        that left the model's validity ends there; its attribute `status` says why.
    """
    case, ramp, settings = job
    one_way = (ramp.high - ramp.low) / ramp.acceleration
    ways = [(ramp.low, ramp.high), (ramp.high, ramp.low)][: 2 if ramp.down else 1]
    count = max(1, round((ramp.high - ramp.low) / ramp.perturbation_every))
    marks = [one_way * k / count for k in range(count)] + [one_way]
    parts: list[xr.Dataset] = []
    perturbations: list[float] = []
    state: Array | None = None
    for way, (first, last) in enumerate(ways):  # each way is a run of its own: no corner of the speed within it
        model = assemble(_one_way_case(case, ramp, settings, first, last, one_way))
        simulation = _core.Simulation(model.core)
        state = starting_state(model) if state is None else state
        for start, stop in zip(marks[:-1], marks[1:], strict=True):
            if way == 0 and start > 0 and ramp.perturbation:
                state = _perturbed(state, simulation, model, ramp.perturbation)
                perturbations.append(start)
            report = partial(_report, progress, way, len(ways), one_way)
            part = _segment(simulation, model, state, (start, stop), report)
            parts.append(part.assign_coords(time=part["time"] + way * one_way))
            if part.attrs["status"] != "ok":
                return _joined(parts, perturbations)
            state = simulation.state
    return _joined(parts, perturbations)


def _one_way_case(
    case: Case, ramp: RampSettings, settings: HuntingSettings, first: float, last: float, duration: float
) -> Case:
    own = replace(settings, disturbance=ramp.disturbance, duration=duration)
    beyond = 1.001  # the table reaches a little beyond the end, so that no stage of the last step meets its corner
    table = [[0.0, f"{first} m/s"], [beyond * duration, f"{first + beyond * (last - first)} m/s"]]
    return hunting_case(case, first, own).with_changes({"motion.speed_table": table, **_method(case)})


def _method(case: Case) -> dict[str, object]:
    """Method of several steps with ellipses, too, unless they vanish at full force: amplitudes are shown, no run is decided."""
    normal = case.contact.normal
    if normal.kind == "hertz" and normal.merging_criterion == 0.0:
        return {}
    return {"time.method": "exponential_adams", "time.step": longest_step(case)}


def _perturbed(state: Array, simulation: _core.Simulation, model: AssembledModel, velocity: float) -> Array:
    rates = [simulation.rate_index[model.body_index(body)][LATERAL] for body in model.lateral_bodies]
    pushed = np.array(state)
    pushed[[rate for rate in rates if rate >= 0]] += velocity
    return pushed


def _report(progress: Progress, way: int, ways: int, length: float, at: float, _filled: int) -> None:
    progress((way + at / length) / ways, "ramp")


def _segment(
    simulation: _core.Simulation,
    model: AssembledModel,
    state: Array,
    span: tuple[float, float],
    report: Callable[[float, int], None],
) -> xr.Dataset:
    (start, stop), step = span, model.case.time.output_step
    begin(simulation, model, state, start_time=start, end_time=stop)  # the next segment starts from the state there
    room = math.ceil((stop - start) / step) + 3
    times, rows = np.empty(room), np.empty((room, simulation.width))
    code, filled = march(simulation, stop, times, rows, slice_length=step, begin_at=start, report=report)
    run, motion = audited(simulation, model, times[:filled], rows[:filled], code, ("lateral", "yaw", "speed"))
    return motion.assign_attrs(largest_residual_j=float(np.abs(run["energy_residual"]).max()))


def _joined(parts: Sequence[xr.Dataset], perturbations: Sequence[float]) -> xr.Dataset:
    inner = [part.isel(time=slice(0, -1)) for part in parts[:-1]] + [parts[-1]]
    joined = xr.concat(
        inner, "time", data_vars="minimal", coords="minimal", compat="override", combine_attrs="override"
    )
    turned_over = sum(part.attrs["energy_turned_over_j"] for part in parts)
    residual = sum(part.attrs["largest_residual_j"] for part in parts)
    return joined.assign_attrs(
        parts[-1].attrs
        | {
            "perturbation_times_s": json.dumps([float(t) for t in perturbations]),
            "solver_statistics": json.dumps(_summed(part.attrs["solver_statistics"] for part in parts), sort_keys=True),
            "contact_counters": json.dumps(_summed(part.attrs["contact_counters"] for part in parts), sort_keys=True),
            "energy_turned_over_j": turned_over,
            "energy_relative_residual": residual / turned_over if turned_over else 0.0,
        }
    )


def _summed(texts: Iterable[str]) -> dict[str, float]:
    """Counts of all segments together; of the steps' lengths the smallest and largest, of their errors the largest."""
    picks: dict[str, Any] = {"smallest_step": min, "largest_step": max, "largest_error": max}
    every: dict[str, list[float]] = {}
    for key, value in itertools.chain(*(json.loads(text).items() for text in texts)):
        every.setdefault(key, []).extend([] if value is None else [value])
    return {key: picks.get(key, sum)(values) for key, values in every.items() if values}


def end_of_hunting(ramp: xr.Dataset, body: str, least_amplitude: float = 1e-4) -> float:
    """Speed at which the hunting ends while the rollers slow down [m/s]; NaN if they do not, or if it never ends.

    Args:
        ramp: Dataset of `ramp_run`.
        body: whose lateral motion.
        least_amplitude: smaller displacements are no hunting [m].
    """
    speed, lateral = ramp["speed"].to_numpy(), np.abs(ramp["lateral"].sel(body=body).to_numpy())
    top = int(np.argmax(speed))
    moving = np.flatnonzero(lateral[top:] > least_amplitude)
    if moving.size == 0 or moving[-1] + 1 >= len(speed) - top:
        return float("nan")
    return float(speed[top + moving[-1]])
