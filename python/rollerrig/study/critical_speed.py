"""Critical speed of one case by one or several definitions; each finished run can be kept.

Case, speeds -> [modes over speed | runs from a disturbance | limit-cycle diagram] -> critical_speed -> Dataset
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig.analysis import HuntingSettings, LimitCycleSettings
from rollerrig.analysis.critical_speed import onset_from
from rollerrig.analysis.speed_map import SPEEDS_KMH
from rollerrig.cases import as_case
from rollerrig.config import Case
from rollerrig.results import variable
from rollerrig.study.critical_speeds import brackets, disturbance_rounds
from rollerrig.study.jobs import Chains, Done, Progress, Round, job
from rollerrig.study.kept import kept_rounds
from rollerrig.study.limit_cycles import cycle_chains, cycle_diagram

Method = Literal["linear", "disturbance", "continuation"]
_LINEAR = "linear critical speed"


def critical_speed(
    case: Case | str,
    *,
    methods: Sequence[Method] = ("linear",),
    speeds_kmh: Sequence[float] = SPEEDS_KMH,
    bracket_kmh: float = 3.0,
    processes: int = 1,
    folder: str | Path | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Critical speed of a case by one or several definitions.

    Args:
        case: the case, or its name in the catalogue.
        methods: of 'linear', 'disturbance', 'continuation'.
        speeds_kmh: range of speeds [km/h], rising; runs are made at each of them.
        bracket_kmh: to which those by disturbance and by continuation are found [km/h].
        processes: runs at a time.
        folder: where each finished run is kept: after Ctrl-C or a killed program the same call goes on; None: nowhere.
        progress: called with the fraction done and a short text.

    Returns:
        `linear_critical_speed`, `critical_speed_by_disturbance`, `critical_speed_by_continuation` [km/h], those asked for. The
        latter two are known between two speeds and have the dimension `end`: 'decays', the highest one below at which the motion
        comes to rest, and 'persists', the lowest at which it does not; NaN where there is none. The linear one is looked for up
        to HIGHEST_KMH where the range has none; the attribute `linear_searched_to_kmh` says how far.

    Raises:
        ConfigError: the folder has runs of another case or range; or runs are asked for, and nothing holds the
            vehicle along the track on its rollers.
        ValueError: an unknown method, or speeds not positive and rising.
        OutputError: the folder takes no files, or holds those of another study.
        StartError: no rolling equilibrium at one of the speeds.
        KeyboardInterrupt: Ctrl-C; finished runs are in `folder`.

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
            yield {_LINEAR: job(onset_from, chosen, speeds)}
        if "disturbance" in asked:
            yield from disturbance_rounds({"": chosen}, {"": speeds}, bracket_kmh, runs, done)
        if "continuation" in asked:
            yield cycle_chains(chosen, speeds, cycles)

    plan = {"speeds_kmh": speeds, "bracket_kmh": bracket_kmh, "case": tomllib.loads(chosen.to_toml())}
    done, interrupted = kept_rounds(rounds, folder, "critical_speed", plan, processes, progress)
    if interrupted:
        raise KeyboardInterrupt
    found: dict[str, float | NDArray[np.float64]] = {}
    searched_to = math.nan
    if _LINEAR in done:
        onset, searched_to = done[_LINEAR]
        found["linear_critical_speed"] = math.nan if onset is None else onset.speed
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
    return xr.Dataset(variables, ends, attributes | {"linear_searched_to_kmh": searched_to})
