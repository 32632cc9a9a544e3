"""The limit-cycle diagram of a case as two chains of runs, of which each is kept as soon as it has settled.

Case, speeds -> [cycle_chains] -> jobs, results by name -> [cycle_diagram] -> Diagram
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

from rollerrig.analysis import Diagram, LimitCycleSettings
from rollerrig.analysis.limit_cycle import Branch, CyclePoint, NotMadeError, diagram, trace
from rollerrig.analysis.limit_cycle_runs import LastState, settling_run
from rollerrig.config import Case
from rollerrig.study.jobs import Chain, Chains, Done, Job, Progress, job
from rollerrig.study.kept import kept_rounds

Sweep = Literal["up", "down"]
Missing = Callable[[str, float, LastState | None], None]


def limit_cycles(
    case: Case,
    speeds_kmh: Sequence[float],
    linear_critical_kmh: float,
    settings: LimitCycleSettings | None = None,
    *,
    processes: int = 1,
    folder: str | Path | None = None,
    progress: Progress | None = None,
) -> Diagram:
    """The limit-cycle diagram of a case.

    Args:
        case: the case; rollers or rails are speed-controlled.
        speeds_kmh: at least one speed, each positive [km/h].
        linear_critical_kmh: linear critical speed, from `stability` or `linear_critical_speed` [km/h]; NaN if there is none.
        settings: disturbances, tolerances, longest time.
        processes: 2 runs the two sweeps at a time.
        folder: where each finished run is kept: after Ctrl-C or a killed program the same call goes on; None: nowhere.
        progress: called with the fraction done and a short text.

    Returns:
        The diagram; after Ctrl-C what was done until then.

    Raises:
        ConfigError: the folder has the runs of another case, or with other settings.
        OutputError: the folder takes no files.
        StartError: no state was found from which a run can start.
    """
    chosen = settings or LimitCycleSettings()
    chains = cycle_chains(case, speeds_kmh, chosen)
    plan = {
        "speeds_kmh": [float(v) for v in speeds_kmh],
        "settings": asdict(chosen),
        "case": tomllib.loads(case.to_toml()),
    }
    done, _ = kept_rounds(lambda _done: iter([chains]), folder, "limit_cycle", plan, processes, progress)
    return cycle_diagram(speeds_kmh, linear_critical_kmh, chosen, done)


def cycle_chains(case: Case, speeds_kmh: Sequence[float], settings: LimitCycleSettings) -> Chains:
    """The runs of both sweeps, each sweep a chain.

    Args:
        case: the case.
        speeds_kmh: at which runs are made [km/h].
        settings: how they are done.
    """

    def chain(sweep: Sweep) -> Chain:
        def following(done: Done) -> tuple[str, Job] | None:
            missing: list[tuple[str, Job]] = []
            offset = settings.perturbation if sweep == "up" else settings.disturbance

            def note(name: str, speed: float, state: LastState | None) -> None:
                missing.append((name, job(settling_run, case, settings, offset, speed, state)))

            _branch(sweep, speeds_kmh, settings, done, note)
            return missing[0] if missing else None

        return following

    widest = max((b - a for a, b in zip(speeds_kmh, speeds_kmh[1:], strict=False)), default=0.0)
    halvings = math.ceil(math.log2(max(1.0, widest / settings.tolerance_kmh)))
    return Chains((chain("down"), chain("up")), 2 * len(speeds_kmh) + halvings)


def cycle_diagram(
    speeds_kmh: Sequence[float], linear_critical_kmh: float, settings: LimitCycleSettings, done: Done
) -> Diagram:
    """The diagram of the runs that were made.

    Args:
        speeds_kmh: those of `cycle_chains` [km/h].
        linear_critical_kmh: linear critical speed [km/h]; NaN: none.
        settings: those of `cycle_chains`.
        done: results by name.
    """
    down, up = (_branch(sweep, speeds_kmh, settings, done, lambda *_: None) for sweep in ("down", "up"))
    return diagram(up, down, linear_critical_kmh / 3.6, settings.tolerance_kmh / 3.6)


def _branch(
    sweep: Sweep, speeds_kmh: Sequence[float], settings: LimitCycleSettings, done: Done, missing: Missing
) -> Branch[Any]:
    """One sweep as far as its runs were made; the first that was not is told to `missing`."""
    count = 0

    def settle(speed: float, state: LastState | None) -> tuple[CyclePoint, LastState | None]:
        nonlocal count
        count += 1
        name = f"{sweep}ward sweep, run {count}, {3.6 * speed:.6g} km/h"
        if name not in done:
            missing(name, speed, state)
            raise NotMadeError
        found: tuple[CyclePoint, LastState | None] = done[name]
        return found

    tolerance = settings.tolerance_kmh / 3.6 if sweep == "down" else None
    return trace(settle, sweep, tuple(float(v) / 3.6 for v in speeds_kmh), tolerance=tolerance)
