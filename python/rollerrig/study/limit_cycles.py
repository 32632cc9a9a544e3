"""The limit-cycle diagram of a case: two chains of runs, each kept as soon as it has settled; how reports show it.

Case, speeds -> [cycle_chains] -> jobs, results by name -> [cycle_diagram] -> Diagram -> numbers, rows, sentences, figures
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal

import numpy as np
import xarray as xr

from rollerrig.analysis import SPEEDS_KMH
from rollerrig.analysis.critical_speed import LinearCriticalSpeed, scan_linear
from rollerrig.analysis.hunting import HuntingSettings
from rollerrig.analysis.limit_cycle import KIND_SENTENCES, Branch, CyclePoint, Diagram, NotMadeError, diagram, trace
from rollerrig.analysis.limit_cycle_runs import LastState, LimitCycleSettings, limit_cycle_table, settling_run
from rollerrig.cases import as_case
from rollerrig.common.arrays import Array
from rollerrig.config import Case
from rollerrig.plot import limit_cycle_diagram
from rollerrig.results.dataset import variable
from rollerrig.simulation.starting_state import StartError
from rollerrig.study.critical_speeds import brackets, disturbance_chains, ended_early, narrowings
from rollerrig.study.jobs import Chain, Chains, Done, Progress, Round, job, run_rounds
from rollerrig.study.quantities import Quantities
from rollerrig.study.report import Block, Picture, Text

Method = Literal["linear", "disturbance", "continuation"]
Sweep = Literal["up", "down"]


def limit_cycles(
    case: Case,
    speeds_kmh: Sequence[float],
    linear_critical_kmh: float,
    settings: LimitCycleSettings,
    *,
    processes: int = 1,
    progress: Progress | None = None,
) -> Diagram:
    """The diagram of `rollerrig.limit_cycle`, whose arguments these are; after Ctrl-C what was done until then."""
    chains = cycle_chains(case, speeds_kmh, settings)
    done, _ = run_rounds(lambda _done: iter([chains]), None, (0.75,), processes, progress)
    return cycle_diagram(speeds_kmh, linear_critical_kmh, settings, done)


def cycle_chains(case: Case, speeds_kmh: Sequence[float], settings: LimitCycleSettings) -> Chains:
    """The runs of both sweeps at these speeds [km/h], each sweep a chain."""

    def chain(sweep: Sweep) -> Chain:
        offset = settings.perturbation if sweep == "up" else settings.disturbance

        def following(done: Done) -> Round:
            _, missing = _branch(sweep, speeds_kmh, settings, done)
            return {missing[0]: job(settling_run, case, settings, offset, *missing[1:])} if missing else {}

        return following

    expected = 2 * len(speeds_kmh) + narrowings(speeds_kmh, settings.tolerance_kmh, 2)
    return Chains((chain("down"), chain("up")), expected)


def cycle_diagram(
    speeds_kmh: Sequence[float], linear_critical_kmh: float, settings: LimitCycleSettings, done: Done
) -> Diagram:
    """The diagram of the runs of `cycle_chains` that were made; the linear critical speed [km/h] is NaN where there is none."""
    down, up = (_branch(sweep, speeds_kmh, settings, done)[0] for sweep in ("down", "up"))
    return diagram(up, down, linear_critical_kmh / 3.6, settings.tolerance_kmh / 3.6)


def _branch(
    sweep: Sweep, speeds_kmh: Sequence[float], settings: LimitCycleSettings, done: Done
) -> tuple[Branch, tuple[str, float, LastState | None] | None]:
    """One sweep as far as its runs were made, and the first that was not: its name, speed and what it starts from."""
    count, missing = 0, None

    def settle(speed: float, state: LastState | None) -> tuple[CyclePoint, LastState | None]:
        nonlocal count, missing
        count += 1
        name = f"{sweep}ward sweep, run {count}, {3.6 * speed:.6g} km/h"
        if name not in done:
            missing = name, speed, state
            raise NotMadeError
        found: tuple[CyclePoint, LastState | None] = done[name]
        return found

    tolerance = settings.tolerance_kmh / 3.6 if sweep == "down" else None
    return trace(settle, sweep, tuple(float(v) / 3.6 for v in speeds_kmh), tolerance=tolerance), missing


POINT = {  # number of a point -> attribute of CyclePoint, and factor
    "speed_kmh": ("speed", 3.6),
    "amplitude_mm": ("amplitude", 1e3),
    "peak_mm": ("peak", 1e3),
    "frequency_hz": ("frequency", 1.0),
    "guiding_force_n": ("guiding_force", 1.0),
    "growth_rate_at_end_per_s": ("rate", 1.0),
    "duration_s": ("duration", 1.0),
}


def cycle_numbers(found: Diagram, settings: LimitCycleSettings) -> dict[str, Any]:
    """The diagram and what follows from it."""
    return {
        "bifurcation": found.kind,
        "critical_speed_by_continuation_kmh": 3.6 * found.lowest_cycle,
        "decays_kmh": 3.6 * found.decays,
        "jump_up_kmh": 3.6 * found.jumps,
        "hysteresis_kmh": None if found.hysteresis is None else [3.6 * v for v in found.hysteresis],
        "tolerance_kmh": settings.tolerance_kmh,
        "disturbance_mm": 1e3 * settings.disturbance,
        "perturbation_mm": 1e3 * settings.perturbation,
        "ended_early": len(found.ended_early),
        "points": [
            {
                "sweep": sweep,
                **{key: factor * getattr(point, name) for key, (name, factor) in POINT.items()},
                "status": point.status,
            }
            for sweep, points in (("up", found.up), ("down", found.down))
            for point in points
        ],
    }


def continuation_sentences(found: Diagram) -> list[str]:
    """The critical speed by continuation, the kind of bifurcation, and which runs did not come to their end."""
    if not (count := len(found.up) + len(found.down)):
        return ["Limit cycles: no run was finished."]
    early = ended_early([(p.speed, p.message) for p in found.ended_early], count)
    return [_continuation(found), *([early] if early else [])]


def _continuation(found: Diagram) -> str:
    name = "Critical speed by continuation"
    if not math.isfinite(found.lowest_cycle):
        decaying = [p.speed for p in (*found.up, *found.down) if p.decays]
        if not decaying:
            return f"{name}: not found, no run was decided."
        if found.ended_early:
            return f"No limit cycle was found; the disturbance decays in the {len(decaying)} runs that were decided."
        return f"No limit cycle up to {3.6 * max(decaying):.1f} km/h: every disturbance decays."
    rest = f", at {3.6 * found.decays:.1f} km/h every motion comes to rest"
    rest = rest if math.isfinite(found.decays) else ", the lowest run that was decided"
    text = f"{name}: {3.6 * found.lowest_cycle:.1f} km/h, the lowest with a limit cycle{rest}. {KIND_SENTENCES[found.kind]}"
    if found.hysteresis is None:
        return text
    low, high = (3.6 * v for v in found.hysteresis)
    return f"{text} From {low:.1f} to {high:.1f} km/h the upward and the downward sweep end differently."


def cycle_blocks(
    found: Diagram, modes: xr.Dataset, settings: LimitCycleSettings, points: Sequence[Mapping[str, Any]]
) -> list[Block]:
    """The section of a report: of a diagram, the modes of `stability`, settings and the points of `cycle_numbers`."""
    blocks: list[Block] = []
    if points:
        caption = (
            "What each run ends in, with the speed stepped up and stepped down. Amplitude: half the range of the lateral "
            "displacement of the wheelset that moves most. |Y|: unfiltered; where flanges strike rigid rails it is short and "
            "very high. A run that did not come to its end or to a decision has no point; how it ended is written in its place."
        )
        blocks.append(Picture("limit_cycles", limit_cycle_diagram(limit_cycle_table(found), modes), caption))
    method = (
        f"Way up: from a lateral offset of the leading wheelset of {1e3 * settings.perturbation:g} mm until a limit "
        f"cycle is reached. Way down: from {1e3 * settings.disturbance:g} mm at the highest speed, then from the "
        "limit cycle of the speed above; where that has decayed, from the same offset again. Each run lasts until it is "
        f"decided whether its motion persists, or {settings.longest:g} s. The perturbation need not grow or decay as the linear "
        "model predicts: the contact leaves the smooth piece of the profiles around its position."
    )
    table = Quantities("stability").table(points, "limit_cycles.points.*", "All runs.")
    return [*blocks, Text(method), table]


_LINEAR = "linear critical speed"


def critical_speed(
    case: Case | str,
    *,
    methods: Sequence[Method] = ("linear",),
    speeds_kmh: Sequence[float] = SPEEDS_KMH,
    bracket_kmh: float = 3.0,
    processes: int = 1,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Critical speed of a case by one or several definitions.

    Args:
        case: the case, or its name in the catalogue.
        methods: of 'linear', 'disturbance', 'continuation'.
        speeds_kmh: range of speeds [km/h], rising; runs are made at each of them.
        bracket_kmh: to which those by disturbance and by continuation are found [km/h].
        processes: runs at a time.
        progress: called with the fraction done and a short text.

    Returns:
        `linear_critical_speed`, `critical_speed_by_disturbance`, `critical_speed_by_continuation` [km/h], those asked for. The
        latter two are known between two speeds and have the dimension `end`: 'decays', the highest one below at which the motion
        comes to rest, and 'persists', the lowest at which it does not; NaN where there is none. The linear one is looked for up
        to HIGHEST_KMH where the range has none; the attribute `linear_searched_to_kmh` says how far.

    Raises:
        ConfigError: runs are asked for, and nothing holds the vehicle along the track on its rollers.
        ValueError: an unknown method, or speeds not positive and rising.
        StartError: no rolling equilibrium at one of the speeds.
        KeyboardInterrupt: Ctrl-C.

    Example:
        >>> import rollerrig as rr
        >>> found = rr.critical_speed("bogie_rollers_constant", speeds_kmh=[200, 300])
        >>> round(float(found["linear_critical_speed"]))
        224
    """
    unknown = set(methods) - {"linear", "disturbance", "continuation"}
    if unknown:
        raise ValueError(f"methods: {', '.join(sorted(unknown))}; allowed: linear, disturbance, continuation")
    chosen, asked = as_case(case), tuple(dict.fromkeys(methods))
    speeds = [float(v) for v in speeds_kmh]
    runs, cycles = HuntingSettings(), LimitCycleSettings(tolerance_kmh=bracket_kmh)

    def rounds(done: Done) -> Iterator[Round | Chains]:
        if "linear" in asked:
            yield {_LINEAR: job(scan_linear, chosen, speeds, True)}
            if problem := done[_LINEAR].problem:
                raise StartError(problem)
        if "disturbance" in asked:
            yield disturbance_chains({"": chosen}, {"": speeds}, bracket_kmh, runs)
        if "continuation" in asked:
            yield cycle_chains(chosen, speeds, cycles)

    done, interrupted = run_rounds(rounds, None, (0.75,), processes, progress)
    if interrupted:
        raise KeyboardInterrupt
    found: dict[str, float | Array] = {}
    linear: LinearCriticalSpeed = done.get(_LINEAR, LinearCriticalSpeed())
    if "linear" in asked:
        found["linear_critical_speed"] = linear.speed_kmh / 3.6
    if by := brackets([""], runs, done):
        found["critical_speed_by_disturbance"] = np.array([by[""].decays, by[""].persists])
    if "continuation" in asked:
        diagram = cycle_diagram(speeds, math.nan, cycles, done)
        found["critical_speed_by_continuation"] = np.array([diagram.decays, diagram.lowest_cycle])
    variables = {
        name: variable(("end",)[: np.ndim(v)], 3.6 * v, "km/h", name.replace("_", " ")) for name, v in found.items()
    }
    ends = {"end": ["decays", "persists"]} if any(np.ndim(v) for v in found.values()) else {}
    attributes = {"case": chosen.name, "title": f"Critical speed of {chosen.name}"}
    return xr.Dataset(variables, ends, attributes | {"linear_searched_to_kmh": linear.searched_to_kmh})


def limit_cycle(
    case: Case | str,
    speeds_kmh: Sequence[float] = SPEEDS_KMH,
    *,
    linear_critical_kmh: float = math.nan,
    processes: int = 1,
    progress: Progress | None = None,
    **settings: float,
) -> xr.Dataset:
    """The limit-cycle diagram: what the vehicle ends in at each speed, stepped up and down.

    Args:
        case: the case; its rollers or rails are speed-controlled.
        speeds_kmh: speeds of the runs [km/h].
        linear_critical_kmh: linear critical speed, which decides how the bifurcation is called [km/h]; NaN: unknown.
        processes: with 2, the two sweeps run at a time; that asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.
        **settings: of `LimitCycleSettings`, such as disturbance [m] and tolerance_kmh.

    Returns:
        Dataset over `cycle_point`, see `limit_cycle_table`; attributes `critical_speed_by_continuation_kmh`, `bifurcation`.

    Raises:
        StartError: no state was found from which a run can start.
    """
    chosen = LimitCycleSettings(**settings)
    found = limit_cycles(as_case(case), speeds_kmh, linear_critical_kmh, chosen, processes=processes, progress=progress)
    return limit_cycle_table(found)
