"""Creep laws compared with the exact theory on one ellipse.

    a/b, laws -> [compare_laws] -> forces and moments of each law and of the exact solver, in mu N and mu N c

Reduced units (docs/theory/creep_laws.md): the result depends on a/b, Poisson's ratio and reduced creepages alone.
"""

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.assembly.laws import CoreLaw
from rollerrig.common.arrays import Array
from rollerrig.results import variable

DIRECTIONS: dict[str, tuple[float, float, float]] = {
    "longitudinal": (1, 0, 0),
    "lateral": (0, 1, 0),
    "spin": (0, 0, 1),
    "longitudinal and lateral": (1, 1, 0),
    "longitudinal and spin": (1, 0, 1),
    "lateral with spin": (0, 1, 1),
    "lateral against spin": (0, 1, -1),
}
"""Name -> share of each demand; scaled to length one."""

DEMANDS = (0.05, 0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0)
ASPECTS = (0.1, 10.0)
"""Range of a/b in which Kalker's coefficients and the table hold."""
COARSE = 0.7
"""Fineness of the second solution, which tells the grid's error."""
CALLS = 20_000
REFERENCE = "exact"
COMPONENTS = ("force_x", "force_y", "spin_moment")


def creepage_units(a_over_b: float, poisson_ratio: float) -> Array:
    """Reduced creepages (xi, eta, chi) that each demand about mu N of the linear theory.

    Args:
        a_over_b: ratio of the semi-axes, a along the rolling direction.
        poisson_ratio: [-].
    """
    return np.array(_core.creepage_units(a_over_b, poisson_ratio))


def compare_laws(
    a_over_b: float,
    laws: Mapping[str, CoreLaw],
    *,
    poisson_ratio: float = 0.28,
    demands: Sequence[float] = DEMANDS,
    fineness: float = 1.0,
) -> xr.Dataset:
    """Forces and moment of laws and of the exact theory.

    Args:
        a_over_b: ratio of the semi-axes, 0.1 to 10.
        laws: label -> law.
        poisson_ratio: 0 to 0.5.
        demands: sizes of the creepage, in units in which each component alone demands about mu N.
        fineness: of the exact solver's grid; 1: errors below 1 % of mu N.

    Returns:
        `force_x`, `force_y` [mu N] and `spin_moment` [mu N c] over (law, direction, demand), the exact theory under the name
        of REFERENCE; `adhesion`, the share of the patch that sticks; `creepage`, reduced; `grid_error` of the exact theory,
        its difference to a coarser grid; `seconds` per call of each law, as measured now.

    Raises:
        ValueError: a number outside its range, or no law.
        RuntimeError: the exact solver found no solution.
    """
    sizes = np.asarray(demands, dtype=float)
    _check(a_over_b, poisson_ratio, sizes, laws)
    units = creepage_units(a_over_b, poisson_ratio)
    directions = np.array(list(DIRECTIONS.values()), dtype=float)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    creepage = sizes[None, :, None] * directions[:, None, :] * units
    exact, adhesion = _exact(a_over_b, poisson_ratio, fineness, creepage)
    coarse, _ = _exact(a_over_b, poisson_ratio, COARSE * fineness, creepage)
    flat = creepage.reshape(-1, 3)
    values = np.array(
        [exact, *(_law(a_over_b, poisson_ratio, law, flat).reshape(exact.shape) for law in laws.values())]
    )
    seconds = [np.nan, *(seconds_per_call(a_over_b, poisson_ratio, law, units) for law in laws.values())]
    over = ("law", "direction", "demand")
    variables: dict[str, tuple[str | tuple[str, ...], Any, str, str]] = {
        "force_x": (over, values[..., 0], "mu N", "longitudinal force"),
        "force_y": (over, values[..., 1], "mu N", "lateral force"),
        "spin_moment": (over, values[..., 2], "mu N c", "spin moment"),
        "adhesion": (over[1:], adhesion, "1", "share of the patch that sticks"),
        "creepage": ((*over[1:], "component"), creepage, "1", "reduced creepage"),
        "grid_error": ((*over[1:], "component"), np.abs(exact - coarse), "mu N", "exact theory less that on a coarser grid"),
        "seconds": ("law", seconds, "s", "processor time per call"),
    }  # fmt: skip
    return xr.Dataset(
        {n: variable(dims, data, unit, text) for n, (dims, data, unit, text) in variables.items()},
        coords={
            "law": [REFERENCE, *laws],
            "direction": list(DIRECTIONS),
            "demand": variable("demand", sizes, "1", "creepage over that which demands mu N"),
            "component": ["longitudinal", "lateral", "spin"],
        },
        attrs={"a_over_b": a_over_b, "poisson_ratio": poisson_ratio, "fineness": fineness},
    )


def _check(a_over_b: float, poisson_ratio: float, demands: Array, laws: Mapping[str, CoreLaw]) -> None:
    if not ASPECTS[0] <= a_over_b <= ASPECTS[1]:
        raise ValueError(f"a/b = {a_over_b:g}; the exact coefficients are tabulated from 0.1 to 10")
    if not 0 <= poisson_ratio <= 0.5:
        raise ValueError(f"Poisson's ratio {poisson_ratio:g}; allowed are 0 to 0.5")
    if not demands.size or not np.all(np.isfinite(demands)) or not np.all(demands > 0):
        raise ValueError("demands must be positive numbers")
    if not laws:
        raise ValueError("no law to compare")


def error_table(comparison: xr.Dataset) -> list[tuple[str, str, float, float, float, float, float, float]]:
    """Errors of each law of `compare_laws` against the exact theory, without and with spin, in % of mu N and of mu N c.

    Returns:
        Rows of law, 'no spin' or 'spin', and median, 95th percentile and worst of force and of moment.
    """
    difference = comparison.sel(law=[str(n) for n in comparison["law"].to_numpy()[1:]]) - comparison.sel(law=REFERENCE)
    rows = []
    spin = np.array([DIRECTIONS[str(name)][2] != 0 for name in comparison["direction"].to_numpy()])
    for law in difference["law"].to_numpy():
        one = difference.sel(law=law)
        force = 100 * np.hypot(one["force_x"].to_numpy(), one["force_y"].to_numpy())
        moment = 100 * np.abs(one["spin_moment"].to_numpy())
        for label, chosen in (("no spin", ~spin), ("spin", spin)):
            rows.append(
                (str(law), label, *(float(q) for x in (force, moment) for q in np.quantile(x[chosen], (0.5, 0.95, 1))))
            )
    return rows  # type: ignore[return-value]


def seconds_per_call(a_over_b: float, poisson_ratio: float, law: CoreLaw, units: Array) -> float:
    """Processor time of one evaluation in plain numbers, best of three [s]; creepages from stick to full sliding."""
    random = np.random.default_rng(1)
    creepage = random.normal(size=(CALLS, 3)) * units * 1.5
    best = np.inf
    for _ in range(3):
        start = time.process_time()
        _law(a_over_b, poisson_ratio, law, creepage)
        best = min(best, time.process_time() - start)
    return best / CALLS


def _law(a_over_b: float, poisson_ratio: float, law: CoreLaw, creepage: Array) -> Array:
    """In reduced units: c, mu N and G are one."""
    a = float(np.sqrt(a_over_b))
    forces: Array = _core.creep_forces(creepage, a, 1 / a, 1.0, 1.0, 1.0, poisson_ratio, law)
    return forces[:, :3]


def _exact(a_over_b: float, poisson_ratio: float, fineness: float, creepage: Array) -> tuple[Array, Array]:
    """Forces and moment, and the share that sticks. From full sliding to stick: each case starts from its neighbour."""
    solver = _core.RollingReference(a_over_b, poisson_ratio, fineness)
    order = np.argsort(-np.linalg.norm(creepage, axis=2), axis=1)
    force, adhesion = np.zeros_like(creepage), np.zeros(creepage.shape[:2])
    for k, rows in enumerate(order):
        for answer, row in zip(solver.solve(np.ascontiguousarray(creepage[k, rows])), rows, strict=True):
            if not answer[5]:
                solver = _core.RollingReference(a_over_b, poisson_ratio, fineness)
                answer = solver.solve(creepage[k, row][None])[0]
            if not answer[5]:
                raise RuntimeError(f"no exact solution at a/b = {a_over_b:g}, reduced creepages {creepage[k, row]}")
            force[k, row], adhesion[k, row] = answer[:3], answer[3]
    return force, adhesion
