"""Steady curving over radius and cant deficiency: wheel forces and wear, and which limits are exceeded where.

Case -> [CurvingStudy] -> all wheels as curving.nc, table and figure of the largest values in each curve
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.curving import DEFICIENCIES, RADII, curving, curving_case
from rollerrig.analysis.wheel_rail_forces import QUOTIENT_LIMIT
from rollerrig.config import Case
from rollerrig.plot.run import curving_over_radius
from rollerrig.study.frame import Study
from rollerrig.study.jobs import Done, Round, job
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Picture, Section, Text

MEASURED = {
    "guiding_force_n": ("guiding_force", 1.0),
    "wheel_load_n": ("wheel_load", 1.0),
    "derailment_quotient": ("derailment_quotient", 1.0),
    "guiding_force_sum_n": ("guiding_force_sum", 1.0),
    "wear_number_n": ("wear_number", 1.0),
    "angle_of_attack_mrad": ("angle_of_attack", 1e3),
    "unbalanced_force_n": ("unbalanced_force", 1.0),
}
"""Key -> variable of which it is the largest magnitude, and factor."""
METHOD = (
    "Each curve is without end: all forces are in balance, creep forces included; the heaviest body is hauled at constant speed. "
    "ΣY and Y/Q are quasi-static: a run over irregularities exceeds them."
)
LIMITED = {"derailment_quotient": "Y/Q", "guiding_force_sum_n": "ΣY"}
"""Key of what has a limit -> how texts call it."""


@dataclass(frozen=True)
class CurvingStudy(Study[xr.Dataset]):
    """One vehicle in many curves; attributes as the arguments of `curving`, lengths in [m]."""

    case: Case
    radii: tuple[float, ...] = RADII
    deficiencies: tuple[float, ...] = DEFICIENCIES
    cant: float | None = None

    command = "curving"
    heading = "Steady curving of {case.name}"
    writes = ("curving.nc",)
    resumable = False

    def cases(self) -> Mapping[str, Case]:
        return {self.case.name: curving_case(self.case)}

    def rounds(self, done: Done) -> Iterator[Round]:
        yield {"curving": job(curving, self.case, self.radii, self.deficiencies, self.cant)}

    def statuses(self, results: xr.Dataset) -> Sequence[str]:
        return ["no steady state" if why else "ok" for why in results["failure"].to_numpy().ravel()]

    def numbers(self, results: xr.Dataset) -> dict[str, Any]:
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

    def summary(self, results: xr.Dataset, numbers: Numbers) -> list[str]:
        curves, found = numbers["curves"], []
        for words in LIMITED.values():
            where = [label for label, curve in curves.items() if words in curve["exceeded"]]
            found.append(f"{words} exceeds its limit in {'; '.join(where) or 'no curve'}.")
        unstable = [label for label, curve in curves.items() if (curve["growth_rate_per_s"] or 0.0) > 0.0]
        found += [f"The steady state is unstable, a run leaves it, in {'; '.join(unstable)}."] * bool(unstable)
        return found + [f"{label}: {curve['failure']}." for label, curve in curves.items() if curve["failure"]]

    def files(self, results: xr.Dataset, numbers: Numbers) -> Mapping[str, Any]:
        return {"curving.nc": results}

    def sections(self, results: xr.Dataset, numbers: Numbers) -> list[Section]:
        caption = "Largest magnitudes of all wheels or wheelsets; dashed: limits."
        picture = Picture("curving", curving_over_radius(results, limits_of(results)), caption)
        columns = ("speed_kmh", *MEASURED, "least_wheel_load_n", "growth_rate_per_s")
        return [
            Section("Curves", [picture, self.quantities.table(numbers["curves"], columns, head="curve"), Text(METHOD)])
        ]


def limits_of(results: xr.Dataset) -> dict[str, float]:
    """Limit of the magnitude of a variable: the lowest one of all wheels or wheelsets."""
    return {
        "derailment_quotient": float(np.fmin(results["nadal_limit"], QUOTIENT_LIMIT)),
        "guiding_force_sum": float(results["guiding_force_sum_limit"].min()),
    }
