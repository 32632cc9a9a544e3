"""Creep laws compared: with the exact theory on one ellipse, and side by side on a wheelset in steady rolling.

    a/b, laws -> [compare_laws] -> forces and moments of each law and of the exact solver, in mu N and mu N c
    Case, positions -> contact_table -> [core: one recorded row per law] -> force of each wheel in mu N, beside the exact solver

Reduced units (docs/theory/creep_laws.md): the result depends on a/b, Poisson's ratio and reduced creepages alone.

Creepages and forces of a wheelset are the core's, as in a run. It rolls as one body along the track: its speed of
rotation is such that the longitudinal creepages of its two wheels cancel.
"""

import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.assembly.laws import CoreLaw, core_law
from rollerrig.assembly.model import assemble
from rollerrig.common.arrays import Array
from rollerrig.config import Case
from rollerrig.config.schema.contact import CREEP_LAWS, NORMAL_LAWS
from rollerrig.config.schema.vehicle import DIRECTIONS as COORDINATES
from rollerrig.contact_analysis.static_contact import contact_table, leading_wheelset
from rollerrig.results import variable
from rollerrig.simulation.starting_state import equilibrium

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
COMPARED = tuple(law for law in CREEP_LAWS if law != "coefficients")
"""Laws that know a patch by its size and material; coefficients as given belong to their case."""
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


EXACT_EVERY = 4  # positions; the exact solver takes some 10 ms a patch
LEAST_SOLUTIONS = 8  # exact solutions, of loaded wheels, that a mean or a worst case is given from
LEAST_SPEED = 1.0  # [m/s]; slower, the viscous friction of standstill mixes in
SIDES = ("left", "right")
_FIELDS = tuple(name for name, _, _ in _core.patch_fields)


def compare_creep(
    case: Case, positions: Sequence[tuple[float, float]], *, roll: float | None = None, timed: bool = True
) -> xr.Dataset:
    """Tangential forces of every creep law on the leading wheelset under its axle load, rolling at the case's speed.

    Args:
        case: vehicle, support and contact; `contact.normal` and `contact.creep` are what varies. `polach` takes the case's
            parameters, or 1 and 1; `coefficients` is compared where it is the case's own.
        positions: lateral position [m] and yaw [rad] of the wheelset.
        roll: roll angle to hold [rad]; None: free to roll.
        timed: measure `cost` too; a figure of this machine and this moment.

    Returns:
        Dataset: `force_x`, `force_y` on the wheel [mu N of the wheel], the sum over its patches, over `law`, `normal`,
        `position`, `side`, NaN for `strip_theory` without strips; `exact_x`, `exact_y`, the exact solver on the same ellipses
        at every EXACT_EVERY-th position, NaN
        elsewhere and where a/b leaves its range; `cost` [s] per call over `law`; `lateral` [m], `yaw` [rad] over `position`.

    Raises:
        ValueError: the case stands still.
        StartError: no rolling equilibrium was found to start from.
    """
    if not case.motion.speed >= LEAST_SPEED:
        raise ValueError(
            f"{case.name}: motion.speed: {case.motion.speed:g} m/s; creep forces of steady rolling are compared from "
            f"{LEAST_SPEED:g} m/s"
        )
    shape = (len(NORMAL_LAWS), len(positions), 2, 2)
    laws = [law for law in CREEP_LAWS if law in (case.contact.creep.kind, *COMPARED)]
    force, exact = np.full((len(laws), *shape), np.nan), np.full(shape, np.nan)
    cost = np.full(len(laws), np.nan)
    load = 0.0
    for n, normal in enumerate(NORMAL_LAWS):
        table = contact_table(case.with_changes({"contact.normal": normal}), positions, roll=roll)
        load = table.attrs["load_n"]
        for i, law in enumerate(laws):
            if law == "strip_theory" and normal != "strips":
                continue
            chosen = _with_law(case, normal, law)
            if timed and np.isnan(cost[i]):
                nu = chosen.contact.material.poisson_ratio
                cost[i] = seconds_per_call(1.0, nu, core_law(chosen.contact.creep), creepage_units(1.0, nu))
            for j, k, patches, rows in _loaded_wheels(chosen, table, positions):
                limit = chosen.contact.friction.mu_0 * patches[:, _FIELDS.index("normal")].sum()
                force[i, n, j, k] = [patches[:, _FIELDS.index(f"creep_force_{d}")].sum() / limit for d in "xy"]
                if not i and not j % EXACT_EVERY:
                    exact[n, j, k] = _exact_percent(chosen, patches, rows)
    over = ("normal", "position", "side")
    units = {"units": "mu N"}
    return xr.Dataset(
        {
            **{f"force_{d}": (("law", *over), force[..., c], units) for c, d in enumerate("xy")},
            **{f"exact_{d}": (over, exact[..., c], units) for c, d in enumerate("xy")},
            "cost": variable("law", cost, "s", "processor time per call"),
        },
        {
            "law": laws,
            "normal": list(NORMAL_LAWS),
            "side": list(SIDES),
            "lateral": ("position", [lateral for lateral, _ in positions], {"units": "m"}),
            "yaw": ("position", [yaw for _, yaw in positions], {"units": "rad"}),
        },
        {"case": case.name, "load_n": load, "speed": case.motion.speed, "friction": case.contact.friction.mu_0},
    )


def _loaded_wheels(
    case: Case, table: xr.Dataset, positions: Sequence[tuple[float, float]]
) -> Iterator[tuple[int, int, Array, xr.Dataset]]:
    """Number of position and side, recorded patches and rows of the contact table of every wheel under load."""
    rolling = _Rolling(case)
    for j, (lateral, yaw) in enumerate(positions):
        rows = table.isel(row=((table["lateral"] == lateral) & (table["yaw"] == yaw)).to_numpy())
        if not rows.sizes["row"]:
            continue
        wheels = rolling.patches(lateral, yaw, float(rows["roll"][0]), float(rows["height"][0]))
        for k, patches in enumerate(wheels):
            if patches[:, _FIELDS.index("normal")].sum() > 0.0:
                yield j, k, patches, rows.isel(row=(rows["side"] == SIDES[k]).to_numpy())


def creep_errors(comparison: xr.Dataset) -> xr.DataArray:
    """Length of the difference to the exact force [mu N], over (law, normal, position, side); NaN where it was not solved."""
    away_x, away_y = (comparison[f"force_{d}"] - comparison[f"exact_{d}"] for d in "xy")
    error: xr.DataArray = (away_x**2 + away_y**2) ** 0.5
    return error


def creep_text(comparison: xr.Dataset) -> str:
    """A table for the terminal: per law its error against the exact solver with each normal contact, and its cost.

    Says how many exact solutions the statistics of a normal contact rest on; from fewer than LEAST_SOLUTIONS none is given.
    """
    errors = 100 * creep_errors(comparison)
    normals = [str(name) for name in comparison["normal"].to_numpy()]
    solved = {name: int(comparison["exact_x"].sel(normal=name).notnull().sum()) for name in normals}
    head = "".join(f"{f'{name}: mean':>16}{'worst':>8}" for name in normals)
    lines = ["creep force, off the exact solver [% of mu N]", f"{'law':<18}{head}{'ns per call':>13}"]
    for law in comparison["law"].to_numpy():
        cells = ""
        for name in normals:
            one = errors.sel(law=law, normal=name)
            enough = solved[name] >= LEAST_SOLUTIONS
            cells += f"{float(one.mean()):>16.1f}{float(one.max()):>8.1f}" if enough else f"{'-':>16}{'-':>8}"
        seconds = float(comparison["cost"].sel(law=law))
        lines.append(f"{law!s:<18}{cells}{'-' if np.isnan(seconds) else f'{1e9 * seconds:.0f}':>13}")
    counts = ", ".join(f"{name} {count}" for name, count in solved.items())
    few = f"; '-': fewer than {LEAST_SOLUTIONS}" if min(solved.values()) < LEAST_SOLUTIONS else ""
    lines[0] += f"; exact solutions: {counts}{few}"
    return "\n".join(lines)


SIDE_BY_SIDE_HEAD = "normal_contact,law,lateral_mm,yaw_mrad,side,force_x_percent,force_y_percent,error_percent"
"""First line of a table of creep laws."""


def creep_csv(comparison: xr.Dataset) -> str:
    """One row per normal contact, law, position and wheel, in mm, mrad and % of mu N; the exact solver is the law `exact`."""
    lines = [SIDE_BY_SIDE_HEAD]
    errors = creep_errors(comparison)
    for n, normal in enumerate(comparison["normal"].to_numpy()):
        for i, law in enumerate([*comparison["law"].to_numpy(), "exact"]):
            known = law != "exact"
            forces = [
                (comparison[f"force_{d}"][i, n] if known else comparison[f"exact_{d}"][n]).to_numpy() for d in "xy"
            ]
            error = errors[i, n].to_numpy() if known else np.zeros_like(forces[0])
            for j, k in np.ndindex(forces[0].shape):
                if np.isnan(forces[0][j, k]):
                    continue
                place = [1e3 * float(comparison[name][j]) for name in ("lateral", "yaw")]
                values = [100 * values[j, k] for values in (*forces, error)]
                texts = ["" if np.isnan(v) else f"{v + 0.0:.6g}" for v in values]
                lines.append(",".join([str(normal), str(law), *(f"{v + 0.0:.9g}" for v in place), SIDES[k], *texts]))
    return "\n".join(lines) + "\n"


class _Rolling:
    """A wheelset fixed in a pose while it rolls, as the core computes it."""

    def __init__(self, case: Case) -> None:
        self.model = assemble(case)
        wheelset, self.contacts, _, self.unloaded = leading_wheelset(self.model)
        self.simulation = _core.Simulation(self.model.core)
        body = self.model.body_index(wheelset)
        self.places: dict[str, int] = dict(zip(COORDINATES, self.simulation.coordinate_index[body], strict=True))
        self.rotation = self.simulation.rate_index[body][COORDINATES.index("pitch")]
        # Speeds of wheelset and rollers; the other bodies carry nothing here.
        self.state: Array = equilibrium(self.simulation, self.model)
        self.nothing = np.zeros(self.simulation.quadrature_count)

    def patches(self, lateral: float, yaw: float, roll: float, height: float) -> list[Array]:
        """Recorded patches of the left and the right wheel, shape (patches, fields)."""
        pose = {"y": lateral, "z": height + self.unloaded, "roll": roll, "yaw": yaw}
        state = self.state.copy()
        for name, value in pose.items():
            if self.places[name] >= 0:
                state[self.places[name]] = value
        found = self._record(state)
        for _ in range(2):  # the creepage is all but linear in the speed of rotation
            step = 1e-3 * state[self.rotation]
            before = _mean_creepage(found)
            state[self.rotation] += step
            slope = (_mean_creepage(self._record(state)) - before) / step
            state[self.rotation] -= step + (before / slope if slope else 0.0)
            found = self._record(state)
        return found

    def _record(self, state: Array) -> list[Array]:
        row = self.simulation.record(0.0, state, self.nothing)
        model, fields = self.model, len(_FIELDS)
        start = len(model.bodies) * len(_core.body_fields) + len(model.wheels) * len(_core.wheel_fields)
        size = _core.patches_recorded * fields
        wheels = row[start : start + len(model.wheels) * size].reshape(len(model.wheels), -1, fields)
        number_of = {wheel.contact: number for number, wheel in enumerate(model.wheels)}
        return [w[~np.isnan(w[:, 0])] for w in (wheels[number_of[contact]] for contact in self.contacts)]


def _mean_creepage(wheels: Sequence[Array]) -> float:
    """Longitudinal, of the wheels that carry load; the patches of a wheel weighted with their loads."""
    normal, creepage = _FIELDS.index("normal"), _FIELDS.index("creepage_x")
    means = [w[:, normal] @ w[:, creepage] / w[:, normal].sum() for w in wheels if w[:, normal].sum() > 0.0]
    return float(np.mean(means)) if means else 0.0


def _with_law(case: Case, normal: str, law: str) -> Case:
    clean: dict[str, Any] = {"kind": law, **({"k_A": 1.0, "k_S": 1.0} if law == "polach" else {})}
    own = case.contact.creep
    return case.with_changes({"contact.normal": normal, "contact.creep": own if own.kind == law else clean})


def _exact_percent(case: Case, patches: Array, contacts: xr.Dataset) -> tuple[float, float]:
    """Force of a wheel by the exact solver, over mu N. A patch that fades is solved at its full load, then scaled."""
    material, total = case.contact.material, np.zeros(2)
    normals = patches[:, _FIELDS.index("normal")]
    for patch, normal in zip(patches, normals, strict=True):
        value = dict(zip(_FIELDS, patch, strict=True))
        nearest = int(np.argmin(np.abs(contacts["wheel_abscissa"].to_numpy() - value["wheel_abscissa"])))
        limit = case.contact.friction.mu_0 * normal / float(contacts["weight"][nearest])
        if not ASPECTS[0] <= value["a"] / value["b"] <= ASPECTS[1]:
            return np.nan, np.nan
        c = np.sqrt(value["a"] * value["b"])
        creepage = np.array([[value["creepage_x"], value["creepage_y"], c * value["creepage_spin"]]])
        solver = _core.RollingReference(value["a"] / value["b"], material.poisson_ratio, 1.0)
        answer = solver.solve(creepage * case.contact.creep_shear_modulus * c**2 / limit)[0]
        if not answer[5]:
            return np.nan, np.nan
        total += normal * answer[:2]
    x, y = total / normals.sum()
    return float(x), float(y)
