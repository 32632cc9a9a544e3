"""Normal contacts and creep laws side by side, on the leading wheelset under its axle load.

    Case, positions -> contact with each `contact.normal` -> per wheel: patches, centre, width, approach, pressure, cost
                    -> [core: one recorded row per law] -> force of each wheel in mu N, beside the exact solver

Creepages and forces are the core's, as in a run. The wheelset rolls as one body along the track at the case's speed: its speed
of rotation is such that the longitudinal creepages of its two wheels cancel.

What each model is: `docs/theory/contact_forces.md`, `non_elliptic_contact.md`, `creep_laws.md`.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.assembly.laws import core_law
from rollerrig.assembly.model import assemble
from rollerrig.common.arrays import Array
from rollerrig.common.formatting import number
from rollerrig.config import Case
from rollerrig.config.schema.contact import CREEP_LAWS, NORMAL_LAWS
from rollerrig.config.schema.vehicle import DIRECTIONS as COORDINATES
from rollerrig.contact_analysis.creep_laws import ASPECTS, REFERENCE, creepage_units, seconds_per_call
from rollerrig.contact_analysis.static_contact import contact, contact_rows, leading_wheelset
from rollerrig.results import variable
from rollerrig.simulation.starting_state import equilibrium

QUANTITIES = {
    "patches": ("1", "patches", 1.0, "patches under load, each counted with its weight"),
    "normal": ("N", "normal_n", 1.0, "sum of the normal forces"),
    "centre": ("m", "centre_s_mm", 1e3, "EN abscissa S of the centre of the pressures, negative towards the flange"),
    "width": ("m", "width_mm", 1e3, "loaded width across the rolling direction"),
    "area": ("m^2", "area_mm2", 1e6, "loaded area"),
    "approach": ("m", "approach_mm", 1e3, "largest elastic approach"),
    "peak_pressure": ("Pa", "peak_pressure_mpa", 1e-6, "largest pressure"),
}
"""Quantity of a wheel -> unit, its column of the CSV file, factor from SI, meaning."""

_FORCES = {
    "force_x": ("mu N", "force_x_percent", 100.0, "longitudinal force on the wheel"),
    "force_y": ("mu N", "force_y_percent", 100.0, "lateral force on the wheel"),
    "error": ("mu N", "error_percent", 100.0, "length of the difference to the exact force"),
}
_PLACE = {"lateral_mm": ("lateral", 1e3), "yaw_mrad": ("yaw", 1e3), "side": ("side", None)}
NORMALS_COLUMNS = {"normal_contact": ("model", None), **_PLACE, **{c: (n, f) for n, (_, c, f, _) in QUANTITIES.items()}}
"""Columns of the table of normal contacts: what they show, factor from SI."""
CREEP_COLUMNS = {
    "normal_contact": ("model", None),
    "law": ("law", None),
    **_PLACE,
    **{c: (n, f) for n, (_, c, f, _) in _FORCES.items()},
}
"""The same of the table of creep laws."""

REPEATS = 2000  # of one evaluation, to time it
EXACT_EVERY = 4  # positions; the exact solver takes some 10 ms a patch
LEAST_SOLUTIONS = 8  # exact solutions, of loaded wheels, that a mean or a worst case is given from
LEAST_SPEED = 1.0  # [m/s]; slower, the viscous friction of standstill mixes in
SIDES = ("left", "right")
_FIELDS = tuple(name for name, _, _ in _core.patch_fields)


def compare_contacts(
    case: Case, positions: Sequence[tuple[float, float]], *, roll: float | None = None, timed: bool = True
) -> xr.Dataset:
    """Each wheel of the leading wheelset at each position, by every normal contact and creep law.

    Args:
        case: vehicle, support and contact; `contact.normal` and `contact.creep` are what varies. `polach` takes the case's
            parameters, or 1 and 1; `coefficients` is compared where it is the case's own.
        positions: lateral position [m] and yaw [rad] of the wheelset.
        roll: roll angle to hold [rad]; None: free to roll.
        timed: measure the costs too; figures of this machine and this moment.

    Returns:
        Over `model`, the normal contact, `position` and `side`: the quantities of QUANTITIES, NaN where there is no contact
        or no balance. Over `law` as well: `force_x`, `force_y` on the wheel [mu N of the wheel], the sum over its patches,
        NaN for `strip_theory` without strips; the first law, REFERENCE, is the exact solver on the same ellipses, at every
        EXACT_EVERY-th position and where a/b is in its range, else NaN; `error` [mu N], the length of the difference to it.
        `contact_cost` [s] over `model`: search and normal contact of one wheel, mean over the positions; `creep_cost` [s] per
        call over `law`. `lateral` [m], `yaw` [rad] over `position`. The attribute `failed_positions` as of `contact`,
        named by model.

    Raises:
        ValueError: the case stands still.
        StartError: no rolling equilibrium was found to start from.
    """
    if not case.motion.speed >= LEAST_SPEED:
        raise ValueError(
            f"{case.name}: motion.speed: {case.motion.speed:g} m/s; creep forces of steady rolling are compared from "
            f"{LEAST_SPEED:g} m/s"
        )
    # Laws that know a patch by its size and material; coefficients as given belong to their case.
    laws = [REFERENCE, *(law for law in CREEP_LAWS if law != "coefficients" or case.contact.creep.kind == law)]
    shape = (len(NORMAL_LAWS), len(positions), len(SIDES))
    found = {name: np.full(shape, np.nan) for name in QUANTITIES}
    force = np.full((len(laws), *shape, 2), np.nan)
    contact_cost, creep_cost = np.full(len(NORMAL_LAWS), np.nan), np.full(len(laws), np.nan)
    failed: list[str] = []
    attributes: dict[str, Any] = {}
    for m, model in enumerate(NORMAL_LAWS):
        pressed = case.with_changes({"contact.normal": model})
        table = contact(pressed, positions, roll=roll)
        attributes = {key: table.attrs[key] for key in ("title", "case", "wheelset", "load_n")}
        failed += [f"{model}: {line}" for line in table.attrs["failed_positions"].splitlines()]
        places = (((table["lateral"] == lateral) & (table["yaw"] == yaw)).to_numpy() for lateral, yaw in positions)
        rows = {j: table.isel(row=here) for j, here in enumerate(places) if here.any()}
        wheels = {
            (j, k): one
            for j, both in rows.items()
            for k, side in enumerate(SIDES)
            if (one := both.isel(row=(both["side"] == side).to_numpy())).sizes["row"]
        }
        for place, one in wheels.items():
            for name, value in _of_wheel(one).items():
                found[name][m, *place] = value
        if timed and wheels:
            contact_cost[m] = _seconds_per_contact(pressed, wheels)
        for i, law in enumerate(laws[1:], start=1):
            if law == "strip_theory" and model != "strips":
                continue
            chosen = _with_law(pressed, law)
            if timed and np.isnan(creep_cost[i]):
                nu = chosen.contact.material.poisson_ratio
                creep_cost[i] = seconds_per_call(1.0, nu, core_law(chosen.contact.creep), creepage_units(1.0, nu))
            rolling = _Rolling(chosen)
            for j, both in rows.items():
                pose = (float(both[name][0]) for name in ("lateral", "yaw", "roll", "height"))
                for k, patches in enumerate(rolling.patches(*pose)):
                    normal = patches[:, _FIELDS.index("normal")].sum()
                    if not normal > 0.0:
                        continue
                    forces = patches[:, [_FIELDS.index(f"creep_force_{d}") for d in "xy"]].sum(axis=0)
                    force[i, m, j, k] = forces / (chosen.contact.friction.mu_0 * normal)
                    if i == 1 and not j % EXACT_EVERY:
                        force[0, m, j, k] = _exact_force(chosen, patches, wheels[j, k])
    over = ("model", "position", "side")
    forces = [*np.moveaxis(force, -1, 0), np.linalg.norm(force - force[:1], axis=-1)]
    return xr.Dataset(
        {
            **{n: variable(over, found[n], unit, text) for n, (unit, _, _, text) in QUANTITIES.items()},
            **{
                n: variable(("law", *over), data, unit, text)
                for data, (n, (unit, _, _, text)) in zip(forces, _FORCES.items(), strict=True)
            },
            "contact_cost": variable("model", contact_cost, "s", "search and normal contact of one wheel"),
            "creep_cost": variable("law", creep_cost, "s", "processor time per call"),
        },
        {
            "model": list(NORMAL_LAWS),
            "law": laws,
            "side": list(SIDES),
            "lateral": ("position", [lateral for lateral, _ in positions], {"units": "m"}),
            "yaw": ("position", [yaw for _, yaw in positions], {"units": "rad"}),
        },
        {**attributes, "friction": case.contact.friction.mu_0, "failed_positions": "\n".join(failed)},
    )


def comparison_rows(comparison: xr.Dataset) -> tuple[list[list[object]], list[list[object]]]:
    """Tables of normal contacts and of creep laws, header first: a row per model (and law), position and loaded wheel."""
    over = ("model", "position", "side")
    normals = comparison[list(QUANTITIES)].stack(row=over).dropna("row", subset=["normal"])
    creep = comparison[list(_FORCES)].stack(row=("model", "law", *over[1:])).dropna("row", subset=["force_x"])
    return contact_rows(normals, NORMALS_COLUMNS), contact_rows(creep, CREEP_COLUMNS)


def comparison_text(comparison: xr.Dataset) -> str:
    """Per normal contact its cost and the range of what it finds; per law its error against the exact solver, and its cost.

    Says how many exact solutions the statistics of a normal contact rest on; from fewer than LEAST_SOLUTIONS none is given.
    """
    models = [str(name) for name in comparison["model"].to_numpy()]
    lines = []
    for model in models:
        here = comparison.sel(model=model)
        spans = [
            f"{column} {number(factor * float(here[name].min()), 3)} to {number(factor * float(here[name].max()), 3)}"
            for name, (_, column, factor, _) in QUANTITIES.items()
        ]
        step = float(np.abs(here["centre"].diff("position")).max()) if comparison.sizes["position"] > 1 else 0.0
        spans.append(f"the centre moves by up to {number(1e3 * step, 3)} mm from one position to the next")
        if not np.isnan(here["contact_cost"]):
            spans.append(f"{number(1e6 * float(here['contact_cost']), 2)} µs per wheel and evaluation")
        lines.append(f"{model}: {', '.join(spans)}")
    errors = 100 * comparison["error"]
    solved = {name: int(errors.sel(law=REFERENCE, model=name).notnull().sum()) for name in models}
    counts = ", ".join(f"{name} {count}" for name, count in solved.items())
    few = f"; '-': fewer than {LEAST_SOLUTIONS}" if min(solved.values()) < LEAST_SOLUTIONS else ""
    lines.append(f"creep force, off the exact solver [% of mu N]; exact solutions: {counts}{few}")
    head = "".join(f"{f'{name}: mean':>16}{'worst':>8}" for name in models)
    lines.append(f"{'law':<18}{head}{'ns per call':>13}")
    for law in comparison["law"].to_numpy()[1:]:
        cells = ""
        for name in models:
            one = errors.sel(law=law, model=name)
            enough = solved[name] >= LEAST_SOLUTIONS
            cells += f"{float(one.mean()):>16.1f}{float(one.max()):>8.1f}" if enough else f"{'-':>16}{'-':>8}"
        seconds = float(comparison["creep_cost"].sel(law=law))
        lines.append(f"{law!s:<18}{cells}{'-' if np.isnan(seconds) else f'{1e9 * seconds:.0f}':>13}")
    return "\n".join(lines)


def _of_wheel(rows: xr.Dataset) -> dict[str, float]:
    """All patches of one wheel as one: sums with their weights, the centre weighted with force, the largest pressure."""
    normal, weight = rows["normal"].to_numpy(), rows["weight"].to_numpy()
    return {
        "patches": float(weight.sum()),
        "normal": float(normal.sum()),
        "centre": float(rows["wheel_abscissa"].to_numpy() @ normal / normal.sum()),
        "width": float(rows["width"].to_numpy() @ weight),
        "area": float(rows["area"].to_numpy() @ weight),
        "approach": float(rows["approach"].max()),
        "peak_pressure": float(rows["peak_pressure"].max()),
    }


def _seconds_per_contact(case: Case, wheels: Mapping[tuple[int, int], xr.Dataset]) -> float:
    """Seconds for search and normal contact of one wheel, mean over the loaded ones."""
    _, _, contact, unloaded = leading_wheelset(assemble(case))
    times = []
    for (_, k), rows in wheels.items():
        lateral, yaw, roll, height = (float(rows[name][0]) for name in ("lateral", "yaw", "roll", "height"))
        times.append(contact.seconds_per_contact(0.0, lateral, height + unloaded, yaw, roll, bool(k), 1, REPEATS))
    return float(np.mean(times))


class _Rolling:
    """A wheelset fixed in a pose while it rolls, as the core computes it."""

    def __init__(self, case: Case) -> None:
        model = assemble(case)
        wheelset, contacts, _, self.unloaded = leading_wheelset(model)
        self.simulation = _core.Simulation(model.core)
        body = model.body_index(wheelset)
        self.places: dict[str, int] = dict(zip(COORDINATES, self.simulation.coordinate_index[body], strict=True))
        self.rotation = self.simulation.rate_index[body][COORDINATES.index("pitch")]
        # Speeds of wheelset and rollers; the other bodies carry nothing here.
        self.state: Array = equilibrium(self.simulation, model)
        self.nothing = np.zeros(self.simulation.quadrature_count)
        start = len(model.bodies) * len(_core.body_fields) + len(model.wheels) * len(_core.wheel_fields)
        self.patches_in_row = slice(start, start + len(model.wheels) * _core.patches_recorded * len(_FIELDS))
        number_of = {wheel.contact: number for number, wheel in enumerate(model.wheels)}
        self.wheels = [number_of[contact] for contact in contacts]

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
        row = np.asarray(self.simulation.record(0.0, state, self.nothing))[self.patches_in_row]
        wheels = row.reshape(-1, _core.patches_recorded, len(_FIELDS))[self.wheels]
        return [patches[~np.isnan(patches[:, 0])] for patches in wheels]


def _mean_creepage(wheels: Sequence[Array]) -> float:
    """Longitudinal, of the wheels that carry load; the patches of a wheel weighted with their loads."""
    normal, creepage = _FIELDS.index("normal"), _FIELDS.index("creepage_x")
    means = [w[:, normal] @ w[:, creepage] / w[:, normal].sum() for w in wheels if w[:, normal].sum() > 0.0]
    return float(np.mean(means)) if means else 0.0


def _with_law(case: Case, law: str) -> Case:
    if case.contact.creep.kind == law:
        return case
    return case.with_changes({"contact.creep": {"kind": law, **({"k_A": 1.0, "k_S": 1.0} if law == "polach" else {})}})


def _exact_force(case: Case, patches: Array, contacts: xr.Dataset) -> Array:
    """Force of a wheel by the exact solver, over mu N. A patch that fades is solved at its full load, then scaled."""
    total, normals = np.zeros(2), patches[:, _FIELDS.index("normal")]
    for patch, normal in zip(patches, normals, strict=True):
        value = dict(zip(_FIELDS, patch, strict=True))
        nearest = int(np.argmin(np.abs(contacts["wheel_abscissa"].to_numpy() - value["wheel_abscissa"])))
        limit = case.contact.friction.mu_0 * normal / float(contacts["weight"][nearest])
        if not ASPECTS[0] <= value["a"] / value["b"] <= ASPECTS[1]:
            return np.full(2, np.nan)
        c = np.sqrt(value["a"] * value["b"])
        creepage = np.array([[value["creepage_x"], value["creepage_y"], c * value["creepage_spin"]]])
        solver = _core.RollingReference(value["a"] / value["b"], case.contact.material.poisson_ratio, 1.0)
        answer = solver.solve(creepage * case.contact.creep_shear_modulus * c**2 / limit)[0]
        if not answer[5]:
            return np.full(2, np.nan)
        total += normal * answer[:2]
    return np.asarray(total / normals.sum())
