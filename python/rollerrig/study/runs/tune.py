"""Candidates of a tuned controller: places in the ranges of free keys, margins of their loops, which of them none surpasses.

keys and ranges -> [free_axes] -> axes -> [values_at] -> [margins_of] -> Point with its runs -> [not_dominated], [compromise]
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rollerrig.analysis.control_loop import creep_slope, loop_of, margins
from rollerrig.analysis.loop_stability import gain_limit, vehicle_plant
from rollerrig.common.arrays import Array
from rollerrig.config import Case, ConfigError, ConfigProblem, Plan, plan_of_case
from rollerrig.config.errors import show_value
from rollerrig.config.validate.messages import validate
from rollerrig.results.dataset import COMPLETED
from rollerrig.study.jobs import Progress
from rollerrig.study.runs.sweep import Axis, Points

TUNED = tuple(f"rig_control.{table}" for table in ("feedback", "estimator", "axle_torque", "drive_command"))
"""Tables that are the controller's own; others of [rig_control] are the rig."""
HIGHEST = 1e3
"""Factor on the gains up to which a margin is looked for."""


@dataclass(frozen=True)
class Point:
    """A candidate, or the case as shipped.

    Attributes:
        values: at the free keys, in their units; None where the case leaves one to what follows from others.
        place: in the unit cube of the ranges; empty of the case as shipped.
        gain_margin: factor on the gains from which vehicle and sampled loop are unstable; 0: as it is, inf: not up to HIGHEST.
        phase_margin_deg: of the feedback of one axle alone; inf: it does not cross over.
        runs: numbers of its runs, one of each draw.
    """

    values: Sequence[float | None]
    place: Sequence[float]
    gain_margin: float
    phase_margin_deg: float
    runs: Sequence[Mapping[str, Any]] = ()

    def of(self, name: str) -> list[float]:
        """An error in each draw; NaN where the test ended early."""
        return [float(run[name]) if run["status"] in COMPLETED else math.nan for run in self.runs]


def not_dominated(errors: Array) -> list[int]:
    """Rows that no other row surpasses: at most as large in all columns, smaller in one; shape (point, objective)."""
    return [
        k for k, one in enumerate(errors) if not np.any(np.all(errors <= one, axis=1) & np.any(errors < one, axis=1))
    ]


def compromise(errors: Array) -> int:
    """Row nearest to the least of each column, in logarithms over their span; shape (point of the front, objective).

    M. Zeleny, Multiple Criteria Decision Making (1982).
    """
    logs = np.log(errors) - np.log(errors.min(axis=0))
    return int(np.argmin(np.linalg.norm(logs / np.maximum(logs.max(axis=0), 1e-12), axis=1)))


def free_axes(case: Case, free: Mapping[str, Any]) -> list[Axis]:
    """The free keys with their ranges, dotted key -> least and most, as a sweep takes them.

    Raises:
        ConfigError: a key is none of the controller's, or a range does not fit.
    """
    keys, varied, problems = list(free), [], []
    for key, ends in free.items():
        if not key.startswith(tuple(f"{table}." for table in TUNED)):
            problems.append(ConfigProblem(case.name, "free", show_value(key), f"allowed: keys of {', '.join(TUNED)}"))
        elif not isinstance(ends, list | tuple) or len(ends) != 2:
            problems.append(ConfigProblem(case.name, f"free.{key}", show_value(ends), "needed: [least, most]"))
        else:
            name = "_".join(key.split(".")[1:])
            varied.append({"key": key, "name": name, "least": ends[0], "most": ends[1]})
    if problems:
        raise ConfigError(problems)
    if not keys:
        raise ConfigError.of(case.name, "free", "{}", "needed: a key and its range")
    sampled = {"kind": "latin_hypercube", "samples": 2}
    raw = {"name": "tune", "case": case.name, "vary": varied, "measure": [], "design": sampled}
    try:
        plan, problems = validate(Plan, raw, case.name)
        if plan is None:
            raise ConfigError(problems)
        return Points(plan_of_case(plan, case, case.name)).axes
    except ConfigError as error:
        named = [re.sub(r"vary\[(\d+)\]", lambda at: f"free.{keys[int(at[1])]}", one.key) for one in error.problems]
        raise ConfigError([replace(one, key=key) for one, key in zip(error.problems, named, strict=True)]) from None


def values_at(axes: Sequence[Axis], place: Sequence[float]) -> list[float]:
    """Values at a place of the unit cube, of four digits; a positive range is divided by its logarithm."""
    found = []
    for axis, part in zip(axes, place, strict=True):
        assert axis.quantile is not None
        least, most = axis.quantile(np.array([0.0, 1.0])).tolist()
        value = least * (most / least) ** part if least > 0.0 else least + part * (most - least)
        found.append(min(max(float(f"{value:.4g}"), least), most))
    return found


def margins_of(case: Case, candidates: Mapping[str, Any], progress: Progress | None = None) -> dict[str, Any]:
    """Candidates, each with the gain margin of vehicle and sampled loop, rolling or sliding, and phase margin of one axle.

    Raises:
        StartError: no rolling equilibrium was found.
    """
    creep, vehicle = creep_slope(case), vehicle_plant(case)
    found: dict[str, Any] = {}
    for name, one in candidates.items():
        changed = case.with_changes(one["changes"])
        loops = [loop for slides in (False, True) if (loop := loop_of(changed, creep, sliding=slides)) is not None]
        phase = math.degrees(margins(loops[0]).phase)
        limits = np.nan_to_num([gain_limit(loop, vehicle, HIGHEST) for loop in loops], nan=math.inf)
        phase_margin = math.inf if math.isnan(phase) else phase
        found[name] = {**one, "gain_margin": float(limits.min()), "phase_margin_deg": phase_margin}
        if progress is not None:
            progress(len(found) / len(candidates), name)
    return found
