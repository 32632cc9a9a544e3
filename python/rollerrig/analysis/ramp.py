"""The rollers are slowly sped up (and slowed down again), and the bogie is nudged now and then.

    Case, speeds, rate -> [ramp in segments] -> lateral motion over time and speed

A model has no irregularities: below the critical speed a disturbance decays to exact rest, and a bogie at exact rest stays
there far above the critical speed. So the bogie gets a sideways nudge at regular steps of speed: a jump of the lateral
velocity of all its moving bodies. What is left of it before the next one shows whether disturbances grow or decay.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.analysis.hunting import HuntingSettings, hunting_case
from rollerrig.config import Case
from rollerrig.model import AssembledModel, assemble
from rollerrig.results import Outcome, add_energy_audit, run_dataset
from rollerrig.run import begin
from rollerrig.start import starting_state

SLICES_PER_SEGMENT = 8
LATERAL = 1


@dataclass(frozen=True)
class RampSettings:
    """How fast the rollers are sped up and how the bogie is nudged.

    Attributes:
        low: speed at the start [m/s].
        high: highest speed [m/s].
        acceleration: of the rollers' surface [m/s^2].
        down: whether the rollers are slowed down to `low` again afterwards.
        nudge: jump of lateral velocity [m/s]; 0 for none.
        nudge_every: change of speed between nudges [m/s].
        disturbance: lateral offset of the leading wheelset at the start [m].
    """

    low: float = 60 / 3.6
    high: float = 300 / 3.6
    acceleration: float = 2 / 3.6
    down: bool = True
    nudge: float = 0.05
    nudge_every: float = 10 / 3.6
    disturbance: float = 3e-3


def ramp_run(job: tuple[Case, RampSettings, HuntingSettings], progress: Callable[[float, str], None]) -> xr.Dataset:
    """One ramp, up and down.

    Args:
        job: case, ramp, and settings of the integration (its duration is not used).
        progress: called with the fraction done and a short text.

    Returns:
        `lateral` [m] over time and body, `speed` [m/s] over time, and the times of the nudges in the attributes. A run that
        left the model's validity ends there; its attribute `status` says why.

    Raises:
        KeyboardInterrupt: Ctrl-C came before the end.
    """
    case, ramp, settings = job
    one_way = (ramp.high - ramp.low) / ramp.acceleration
    turning = [one_way, 2 * one_way] if ramp.down else [one_way]
    table = [[0.0, ramp.low], [one_way, ramp.high], [2 * one_way, ramp.low]][: len(turning) + 1]
    chosen = hunting_case(case, ramp.low, _with_duration(settings, ramp.disturbance, turning[-1]))
    model = assemble(chosen.with_changes({"motion.speed_table": table}))
    simulation = _core.Simulation(model.core)
    state = starting_state(simulation, model)
    parts: list[xr.Dataset] = []
    starts = _segment_starts(ramp, one_way, turning[-1])
    for number, (start, stop) in enumerate(zip(starts, [*starts[1:], turning[-1]], strict=True)):
        if number > 0 and ramp.nudge and start < one_way:
            state = _nudged(state, simulation, model, ramp.nudge)
        part = _segment(simulation, model, state, start, stop, lambda t: progress(t / turning[-1], "ramp"))
        parts.append(part)
        if part.attrs["status"] != "ok":
            break
        state = simulation.state
    return _joined(parts, [s for s in starts[1:] if ramp.nudge and s < one_way])


def _with_duration(settings: HuntingSettings, disturbance: float, duration: float) -> HuntingSettings:
    return HuntingSettings(
        disturbance, duration, settings.output_step, settings.relative_tolerance, settings.absolute_tolerance
    )


def _segment_starts(ramp: RampSettings, one_way: float, end: float) -> list[float]:
    """Start of each segment, on the way up and down [s]."""
    count = max(1, round((ramp.high - ramp.low) / ramp.nudge_every))
    ways = round(end / one_way)
    return [one_way * (way + k / count) for way in range(ways) for k in range(count)]


def _nudged(state: np.ndarray, simulation: _core.Simulation, model: AssembledModel, velocity: float) -> np.ndarray:
    pushed = np.array(state)
    for body in model.lateral_bodies:
        index = simulation.rate_index[model.body_index(body)][LATERAL]
        if index >= 0:
            pushed[index] += velocity
    return pushed


def _segment(
    simulation: _core.Simulation,
    model: AssembledModel,
    state: np.ndarray,
    start: float,
    stop: float,
    progress: Callable[[float], None],
) -> xr.Dataset:
    begin(simulation, model, np.ascontiguousarray(state), start_time=start)
    room = int((stop - start) / model.case.time.output_step) + 3
    times, rows = np.empty(room), np.empty((room, simulation.width))
    filled = 0
    code = _core.status_codes["ok"]
    for until in np.linspace(start, stop, SLICES_PER_SEGMENT + 1)[1:]:
        code, filled = simulation.advance(float(until), times, rows, filled)
        if code != _core.status_codes["ok"]:
            break
        progress(float(until))
    status = next(name for name, number in _core.status_codes.items() if number == code)
    outcome = Outcome(
        status, _core.status_sentence(code), simulation.time, "", simulation.statistics(), simulation.counters()
    )
    audited = add_energy_audit(run_dataset(model, times[:filled], rows[:filled], outcome))
    moving = json.loads(audited.attrs["vehicle_bodies"])
    kept: xr.Dataset = audited[["lateral", "yaw", "speed"]].sel(body=moving).copy(deep=True)
    return kept.assign_attrs(largest_residual_j=float(np.abs(audited["energy_residual"]).max()))


def _joined(parts: Sequence[xr.Dataset], nudges: Sequence[float]) -> xr.Dataset:
    inner = [part.isel(time=slice(0, -1)) for part in parts[:-1]] + [parts[-1]]
    joined = xr.concat(
        inner, "time", data_vars="minimal", coords="minimal", compat="override", combine_attrs="override"
    )
    turned_over = sum(part.attrs["energy_turned_over_j"] for part in parts)
    residual = sum(part.attrs["largest_residual_j"] for part in parts)
    return joined.assign_attrs(
        parts[-1].attrs
        | {
            "nudge_times_s": json.dumps([float(t) for t in nudges]),
            "solver_statistics": json.dumps(_summed(part.attrs["solver_statistics"] for part in parts), sort_keys=True),
            "contact_counters": json.dumps(_summed(part.attrs["contact_counters"] for part in parts), sort_keys=True),
            "energy_turned_over_j": turned_over,
            "energy_relative_residual": residual / turned_over if turned_over else 0.0,
        }
    )


def _summed(texts: Iterable[str]) -> dict[str, float]:
    """Counts of all segments together; of the steps' lengths the smallest and largest."""
    total: dict[str, float] = {}
    for text in texts:
        for key, value in json.loads(text).items():
            if value is None:
                continue
            pick = {"smallest_step": min, "largest_step": max}.get(key)
            old = total.get(key)
            total[key] = value if old is None else pick(old, value) if pick else old + value
    return total
