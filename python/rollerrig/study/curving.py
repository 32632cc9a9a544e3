"""Steady curving over radius and cant deficiency: wheel forces and wear, and which limits are exceeded where.

Case -> [CurvingStudy] -> all wheels as curving.nc, table and figure of the largest values in each curve
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import numpy as np
import xarray as xr

from rollerrig.analysis.curving import curving as steady_curving
from rollerrig.analysis.curving import curving_case
from rollerrig.analysis.curving_sensitivity import curving_sensitivity, largest_change
from rollerrig.analysis.stability_sensitivity import parameter_rows
from rollerrig.analysis.wheel_rail_forces import QUOTIENT_LIMIT
from rollerrig.cases import as_case
from rollerrig.config import Case
from rollerrig.plot.hunting import tornado_diagram
from rollerrig.plot.run import curving_over_radius
from rollerrig.study.frame import Outcome, Study
from rollerrig.study.jobs import Done, Progress, Round, job
from rollerrig.study.options import Option, command
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Picture, Section, Text

MEASURED = {  # key -> variable of which it is the largest magnitude, and factor
    "guiding_force_n": ("guiding_force", 1.0),
    "wheel_load_n": ("wheel_load", 1.0),
    "derailment_quotient": ("derailment_quotient", 1.0),
    "guiding_force_sum_n": ("guiding_force_sum", 1.0),
    "wear_number_n": ("wear_number", 1.0),
    "angle_of_attack_mrad": ("angle_of_attack", 1e3),
    "unbalanced_force_n": ("unbalanced_force", 1.0),
}
METHOD = (
    "Each curve is without end: all forces are in balance, creep forces included; the heaviest body is hauled at constant speed. "
    "ΣY and Y/Q are quasi-static: a run over irregularities exceeds them."
)
MOVED = {  # key -> variable of whose largest magnitude it is the change by a number that is 1 % larger
    "derailment_quotient_change": "derailment_quotient",
    "guiding_force_sum_change_n": "guiding_force_sum",
    "wear_number_change_n": "wear_number",
}
LIMITED = {"derailment_quotient": "Y/Q", "guiding_force_sum_n": "ΣY"}  # key of what has a limit -> how texts call it


@dataclass(frozen=True)
class Results:
    """Steady states over radius and cant deficiency, and what moves the one in the tightest curve; None: not asked for."""

    curves: xr.Dataset
    sensitivity: xr.Dataset | None


@dataclass(frozen=True)
class CurvingStudy(Study[Results]):
    """One vehicle in many curves; attributes as the arguments of `curving`, lengths in [m]."""

    case: Case
    radii: tuple[float, ...]
    deficiencies: tuple[float, ...]
    cant: float | None
    sensitivity: bool

    command = "curving"
    heading = "Steady curving of {case.name}"
    writes = ("curving.nc", "sensitivity.csv")
    resumable = False

    def cases(self) -> Mapping[str, Case]:
        return {self.case.name: curving_case(self.case)}

    def rounds(self, done: Done) -> Iterator[Round]:
        yield {"curving": job(steady_curving, self.case, self.radii, self.deficiencies, self.cant)}
        if self.sensitivity:
            radius, deficiency = tightest(done["curving"])
            moves = partial(curving_sensitivity, radius=radius, deficiency=deficiency, cant=self.cant)
            yield {"sensitivity": job(moves, self.case)}

    def collect(self, done: Done) -> Results | None:
        return Results(done["curving"], done.get("sensitivity")) if "curving" in done else None

    def statuses(self, results: Results) -> Sequence[str]:
        return ["no steady state" if why else "ok" for why in results.curves["failure"].to_numpy().ravel()]

    def numbers(self, results: Results) -> dict[str, Any]:
        found, moved = self._curves(results.curves), results.sensitivity
        if moved is not None:
            changes = {key: largest_change(moved, name) for key, name in MOVED.items()}
            found["sensitivity"] = parameter_rows(moved, changes)
        return found

    def _curves(self, results: xr.Dataset) -> dict[str, Any]:
        limits, curves = limits_of(results), {}
        for i, j in np.ndindex(results["failure"].shape):
            one = results.isel(radius=i, cant_deficiency=j)
            largest = {key: factor * float(abs(one[name]).max()) for key, (name, factor) in MEASURED.items()}
            radius, deficiency = float(one["radius"]), round(1e3 * float(one["cant_deficiency"]), 9)
            curves[f"{radius:g} m, {deficiency:g} mm"] = {
                "radius_m": radius,
                "cant_deficiency_mm": deficiency,
                "speed_kmh": 3.6 * float(one["speed"]),
                **largest,
                "least_wheel_load_n": float(one["wheel_load"].min()),
                "growth_rate_per_s": float(one["growth_rate"]),
                "exceeded": [words for key, words in LIMITED.items() if largest[key] > limits[MEASURED[key][0]]],
                "failure": str(one["failure"].item()),
            }
        return {
            "cant_mm": 1e3 * results.attrs["cant_m"],
            "derailment_quotient_limit": limits["derailment_quotient"],
            "guiding_force_sum_limit_n": limits["guiding_force_sum"],
            "curves": curves,
        }

    def summary(self, results: Results, numbers: Numbers) -> list[str]:
        curves, found = numbers["curves"], []
        for words in LIMITED.values():
            where = [label for label, curve in curves.items() if words in curve["exceeded"]]
            found.append(f"{words} exceeds its limit in {'; '.join(where) or 'no curve'}.")
        unstable = [label for label, curve in curves.items() if (curve["growth_rate_per_s"] or 0.0) > 0.0]
        found += [f"The steady state is unstable, a run leaves it, in {'; '.join(unstable)}."] * bool(unstable)
        return found + [f"{label}: {curve['failure']}." for label, curve in curves.items() if curve["failure"]]

    def files(self, results: Results, numbers: Numbers) -> Mapping[str, Any]:
        rows = numbers.get("sensitivity")
        moved = {} if rows is None else {"sensitivity.csv": self.quantities.csv(rows, "sensitivity.*")}
        return {"curving.nc": results.curves, **moved}

    def sections(self, results: Results, numbers: Numbers) -> list[Section]:
        caption = "Largest magnitudes of all wheels or wheelsets; dashed: limits."
        picture = Picture("curving", curving_over_radius(results.curves, limits_of(results.curves)), caption)
        columns = ("speed_kmh", *MEASURED, "least_wheel_load_n", "growth_rate_per_s")
        table = self.quantities.table(numbers["curves"], columns, head="curve")
        sections = [Section("Curves", [picture, table, Text(METHOD)])]
        if (found := results.sensitivity) is not None:
            radius, deficiency = found.attrs["radius_m"], 1e3 * found.attrs["cant_deficiency_m"]
            said = f"Change by stiffnesses of the suspension and friction, 1 % larger, with {deficiency:g} mm of cant deficiency."
            drawn = [Picture(f"sensitivity_{name}", tornado_diagram(found, name), said) for name in MOVED.values()]
            every = self.quantities.table(numbers["sensitivity"], "sensitivity.*", "All of them; values in SI.")
            sections.append(Section(f"What moves it in the curve of {radius:g} m", [*drawn, every]))
        return sections


def tightest(curves: xr.Dataset) -> tuple[float, float]:
    """Radius and cant deficiency of the tightest curve with a steady state, there the largest deficiency [m]."""
    steady = curves["failure"].transpose("radius", "cant_deficiency").to_numpy() == ""
    radii, deficiencies = (curves[name].to_numpy() for name in ("radius", "cant_deficiency"))
    radius, below = min((radii[i], -deficiencies[j]) for i, j in np.argwhere(steady))
    return float(radius), -float(below)


def limits_of(results: xr.Dataset) -> dict[str, float]:
    """Limit of the magnitude of a variable: the lowest one of all wheels or wheelsets."""
    return {
        "derailment_quotient": float(np.fmin(results["nadal_limit"], QUOTIENT_LIMIT)),
        "guiding_force_sum": float(results["guiding_force_sum_limit"].min()),
    }


@command
def curving(
    case: Case | str,
    radii: Annotated[Sequence[float], Option("radii_m")] = (150.0, 200.0, 250.0, 300.0, 400.0, 500.0, 700.0, 1000.0),
    deficiencies: Annotated[Sequence[float], Option("deficiencies_mm", "mm")] = (-0.06, 0.0, 0.06, 0.1, 0.15),
    cant: Annotated[float | None, Option("cant_mm", "mm", 0.0, 300.0)] = None,
    *,
    sensitivity: bool = False,
    progress: Progress | None = None,
) -> Outcome[Results]:
    """Steady curving: Y, Q, Y/Q, sum of Y, angle of attack and wear number over radius and cant deficiency, with their limits.

    Args:
        case: case: a name of the catalogue or a TOML file.
        radii: radii of the curves [m].
        deficiencies: cant deficiencies, which decide the speed; negative: excess [m].
        cant: cant [m]; absent: that of the case's first curve, or 100 mm.
        sensitivity: also draw how stiffnesses of the suspension and friction move Y/Q, sum of Y and wear in the tightest curve.
        progress: called with the fraction done and a short text.
    """
    study = CurvingStudy(as_case(case), tuple(radii), tuple(deficiencies), cant, sensitivity)
    return study.outcome(progress=progress)
