"""Steady curving over radius and cant deficiency: wheel forces and wear, and which limits are exceeded where.

Case -> [CurvingStudy] -> curving.nc, a table of the largest values in each curve, figure over the radius
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.curving import DEFICIENCIES, RADII, curving, curving_case
from rollerrig.analysis.wheel_rail_forces import QUOTIENT_LIMIT
from rollerrig.config import Case
from rollerrig.plot.curving import curving_over_radius
from rollerrig.study.frame import Study
from rollerrig.study.jobs import Done, Round, job
from rollerrig.study.quantities import Numbers, Quantities, Quantity
from rollerrig.study.report import Picture, Section, Text
from rollerrig.wording import number

IN = {
    "guiding_force": ("n", 1.0),
    "wheel_load": ("n", 1.0),
    "derailment_quotient": ("", 1.0),
    "guiding_force_sum": ("n", 1.0),
    "wear_number": ("n", 1.0),
    "angle_of_attack": ("mrad", 1e3),
}
"""Quantity of which the largest magnitude is reported -> unit in its key, and factor."""

KILO = ("kN", 1e-3)
QUANTITIES = Quantities(
    Quantity("cant_mm", "of all curves", "mm"),
    Quantity("direction", "of the curves"),
    Quantity("derailment_quotient_limit", "lower one of Nadal's limit of Y/Q and 0.8", "1"),
    Quantity("guiding_force_sum_limit_n", "lowest one of Prud'homme's limits of ΣY, 10 kN + 2 Q0 / 3", "N", shown=KILO),
    Quantity("curves.*.radius_m", "radius", "m"),
    Quantity("curves.*.cant_deficiency_mm", "negative: cant excess", "mm"),
    Quantity("curves.*.speed_kmh", "that has this cant deficiency", "km/h"),
    Quantity("curves.*.guiding_force_n", "largest Y of a wheel; null: no steady state", "N", "Y", shown=KILO),
    Quantity("curves.*.wheel_load_n", "largest Q", "N", "Q", shown=KILO),
    Quantity("curves.*.least_wheel_load_n", "least Q", "N", "least Q", shown=KILO),
    Quantity("curves.*.derailment_quotient", "largest Y/Q", "1", "Y/Q", 3),
    Quantity("curves.*.guiding_force_sum_n", "largest |ΣY| of a wheelset", "N", "ΣY", shown=KILO),
    Quantity("curves.*.wear_number_n", "largest Tγ of a wheel", "N", "Tγ"),
    Quantity("curves.*.angle_of_attack_mrad", "largest angle of attack", "mrad", "angle of attack", 3),
    Quantity("curves.*.unbalanced_force_n", "largest that is left on a body", "N", "unbalanced", 2),
    Quantity("curves.*.growth_rate_per_s", "of the fastest growing small motion; positive: the vehicle hunts", "1/s", digits=2),
    Quantity("curves.*.exceeded", "which limits are exceeded"),
    Quantity("curves.*.failure", "why no steady state was found; empty: it was"),
)  # fmt: skip
LIMITED = {"derailment_quotient": "Y/Q", "guiding_force_sum": "ΣY"}


@dataclass(frozen=True)
class CurvingStudy(Study[xr.Dataset]):
    """One vehicle in many curves.

    Attributes:
        case: see `curving`. Likewise:
        radii: [m].
        deficiencies: [m].
        cant: [m].
    """

    case: Case
    radii: tuple[float, ...] = RADII
    deficiencies: tuple[float, ...] = DEFICIENCIES
    cant: float | None = None

    command = "curving"
    quantities = QUANTITIES
    writes = ("curving.nc", "curving.csv")
    formats = ("svg", "png")
    resumable = False

    @property
    def title(self) -> str:
        return f"Steady curving of {self.case.name}"

    def cases(self) -> Mapping[str, Case]:
        return {self.case.name: curving_case(self.case)}

    def rounds(self, done: Done) -> Iterator[Round]:
        yield {"curving": job(steady_curves, self)}

    def collect(self, done: Done) -> xr.Dataset | None:
        return done.get("curving")

    def statuses(self, results: xr.Dataset) -> Sequence[str]:
        return ["no steady state" if why else "ok" for why in results["failure"].to_numpy().ravel()]

    def numbers(self, results: xr.Dataset) -> dict[str, Any]:
        limits, curves = limits_of(results), {}
        for i, j in np.ndindex(results["failure"].shape):
            one = results.isel(radius=i, cant_deficiency=j)
            largest = {name: float(abs(one[name]).max()) for name in IN}
            radius, deficiency = float(one["radius"]), 1e3 * float(one["cant_deficiency"])
            curves[f"{radius:g} m, {deficiency:g} mm"] = {
                "radius_m": radius,
                "cant_deficiency_mm": round(deficiency, 9),
                "speed_kmh": 3.6 * float(one["speed"]),
                **{f"{name}_{unit}".rstrip("_"): factor * largest[name] for name, (unit, factor) in IN.items()},
                "least_wheel_load_n": float(one["wheel_load"].min()),
                "unbalanced_force_n": float(one["unbalanced_force"]),
                "growth_rate_per_s": float(one["growth_rate"]),
                "exceeded": [word for name, word in LIMITED.items() if largest[name] > limits[name]],
                "failure": str(one["failure"].item()),
            }
        return {
            "cant_mm": 1e3 * results.attrs["cant_m"],
            "direction": results.attrs["direction"],
            "derailment_quotient_limit": limits["derailment_quotient"],
            "guiding_force_sum_limit_n": limits["guiding_force_sum"],
            "curves": curves,
        }

    def summary(self, results: xr.Dataset, numbers: Numbers) -> list[str]:
        curves = numbers["curves"]
        limits = {"Y/Q": f"{number(numbers['derailment_quotient_limit'], 3)}",
                  "ΣY": f"{number(1e-3 * numbers['guiding_force_sum_limit_n'], 3)} kN"}  # fmt: skip
        found = []
        for word, limit in limits.items():
            where = [label for label, curve in curves.items() if word in curve["exceeded"]]
            found.append(f"{word} exceeds its limit of {limit} {f'at {listed(where)}' if where else 'nowhere'}.")
        unstable = [label for label, curve in curves.items() if (curve["growth_rate_per_s"] or 0.0) > 0.0]
        if unstable:
            found.append(f"The steady state is unstable at {listed(unstable)}: a run leaves it.")
        return found + [f"{label}: {curve['failure']}." for label, curve in curves.items() if curve["failure"]]

    def files(self, results: xr.Dataset, numbers: Numbers) -> Mapping[str, Any]:
        names = [quantity.key for quantity in QUANTITIES if quantity.key.startswith("curves.")]
        rows = [{**curve, "exceeded": " ".join(curve["exceeded"])} for curve in numbers["curves"].values()]
        return {"curving.nc": results, "curving.csv": QUANTITIES.csv(rows, names)}

    def sections(self, results: xr.Dataset, numbers: Numbers) -> list[Section]:
        caption = "Largest magnitudes of all wheels or wheelsets over the radius; dashed: limits."
        columns = ("speed_kmh", *(f"{name}_{unit}".rstrip("_") for name, (unit, _) in IN.items()), "least_wheel_load_n")
        columns += ("growth_rate_per_s",)
        table = QUANTITIES.table(numbers["curves"], columns, "Largest magnitudes in each curve", "curve")
        return [
            Section("Over the radius", [Picture("curving", curving_over_radius(results, limits_of(results)), caption)]),
            Section("Curves", [table, Text(METHOD)]),
        ]


METHOD = (
    "Each curve is without end: all forces are in balance, creep forces included; the heaviest body is hauled at constant speed. "
    "The largest force left unbalanced is in curving.csv. ΣY and Y/Q are quasi-static: a run over irregularities exceeds them."
)


def steady_curves(study: CurvingStudy, progress: Any = None) -> xr.Dataset:
    """All curves of a study.

    Raises:
        ConfigError: the case cannot be used.
        StartError: there is no steady state at all.
    """
    return curving(study.case, study.radii, study.deficiencies, cant=study.cant, progress=progress)


def limits_of(results: xr.Dataset) -> dict[str, float]:
    """Limit of the magnitude of a variable: the lowest one of all wheels or wheelsets."""
    return {
        "derailment_quotient": float(np.fmin(results["nadal_limit"], QUOTIENT_LIMIT)),
        "guiding_force_sum": float(results["guiding_force_sum_limit"].min()),
    }


def listed(labels: Sequence[str], most: int = 6) -> str:
    """The first labels, and how many there are more."""
    return "; ".join(labels[:most]) + (f" and {len(labels) - most} more" if len(labels) > most else "")
