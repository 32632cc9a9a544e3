"""Creep laws against the exact theory on one ellipse.

a/b, names of laws -> [creep study] -> report.html, creep.csv, creep.png, summary.json
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import xarray as xr

from rollerrig import __version__
from rollerrig.analysis.creep_laws import COMPONENTS, DEMANDS, REFERENCE, compare_laws, error_table
from rollerrig.config.contact_law import PolachReduction, StiffnessReduction
from rollerrig.creep import creep_law
from rollerrig.plot.creep import creep_figure
from rollerrig.plot.style import figure_bytes
from rollerrig.report import Figure, Page, Section, Table, Text, render
from rollerrig.results import output_folder, write_bytes, write_text
from rollerrig.studies.output import finite, write_rows

CREEP_KEYS = {
    "a_over_b": "ratio of the semi-axes of the contact ellipse, a along the rolling direction",
    "poisson_ratio": "of both bodies",
    "laws": "per law, the numbers below",
    "laws.*.*.force": "median, 95th percentile and worst error of the force against the exact theory [% of mu N]",
    "laws.*.*.moment": "the same of the spin moment [% of mu N sqrt(ab)]",
    "laws.*.nanoseconds": "processor time of a call as measured in this run [ns]",
    "grid_error": "largest difference of the exact theory to its solution on a coarser grid [% of mu N]",
    "rollerrig_version": "version of this program",
}
"""Key of summary.json -> meaning and unit."""


def creep_study(
    a_over_b: float,
    laws: Sequence[str],
    *,
    poisson_ratio: float = 0.28,
    demands: Sequence[float] = DEMANDS,
    polach: PolachReduction | None = None,
    stiffness: StiffnessReduction | None = None,
) -> xr.Dataset:
    """Laws by name beside the exact theory; see `compare_laws` for what comes back.

    Args:
        a_over_b: ratio of the semi-axes, 0.1 to 10.
        laws: names that `contact.creep` knows, each once.
        poisson_ratio: [-].
        demands: sizes of the creepage; 1 demands about mu N.
        polach: needed where `polach` is among the laws.
        stiffness: for `modified_fastsim`.

    Raises:
        ValueError: an unknown or repeated law, one that lacks a parameter, a number outside its range.
    """
    repeated = sorted({name for name in laws if list(laws).count(name) > 1})
    if repeated:
        raise ValueError(f"{', '.join(repeated)}: asked for more than once")
    chosen = {name: creep_law(name, saturate_spin_moment=False, polach=polach, stiffness=stiffness) for name in laws}
    return compare_laws(a_over_b, chosen, poisson_ratio=poisson_ratio, demands=demands)


def write_study(comparison: xr.Dataset, out: str | Path) -> list[Path]:
    """Write report.html, creep.csv, creep.png and summary.json.

    Raises:
        OutputError: a file could not be written.
    """
    folder = output_folder(out)
    figure = creep_figure(comparison)
    return [
        write_rows(folder / "creep.csv", rows(comparison)),
        write_bytes(folder / "creep.png", figure_bytes(figure, "png")),
        write_text(folder / "summary.json", json.dumps(summary(comparison), indent=2, ensure_ascii=False) + "\n"),
        write_text(folder / "report.html", render(report_page(comparison, figure_bytes(figure)))),
    ]


def rows(comparison: xr.Dataset) -> list[list[object]]:
    """Every force and moment, header first."""
    table: list[list[object]] = [
        [
            *("law", "direction", "demand", "xi", "eta", "chi"),
            *("force_x_over_mu_n", "force_y_over_mu_n", "spin_moment_over_mu_n_c", "adhesion"),
        ]
    ]
    for law in comparison["law"].to_numpy():
        for direction in comparison["direction"].to_numpy():
            one = comparison.sel(law=law, direction=direction)
            for k, demand in enumerate(one["demand"].to_numpy()):
                values = [float(one[name][k]) + 0.0 for name in COMPONENTS]
                adhesion = float(one["adhesion"][k]) if law == REFERENCE else float("nan")
                creepage = [float(x) + 0.0 for x in one["creepage"][k]]
                table.append([str(law), str(direction), float(demand), *creepage, *values, adhesion])
    return table


def summary(comparison: xr.Dataset) -> dict[str, Any]:
    """The numbers of the study under the keys of CREEP_KEYS, and the keys themselves."""
    laws: dict[str, Any] = {}
    for law, kind, *spread in error_table(comparison):
        entry = laws.setdefault(law, {"nanoseconds": finite(1e9 * float(comparison["seconds"].sel(law=law)))})
        entry[kind.replace(" ", "_")] = {"force": _triple(spread[:3]), "moment": _triple(spread[3:])}
    return {
        "a_over_b": comparison.attrs["a_over_b"],
        "poisson_ratio": comparison.attrs["poisson_ratio"],
        "laws": laws,
        "grid_error": _grid_error(comparison),
        "rollerrig_version": __version__,
        "keys": CREEP_KEYS,
    }


def _triple(spread: Sequence[float]) -> Mapping[str, float]:
    return dict(zip(("median", "percentile_95", "worst"), (round(x, 3) for x in spread), strict=True))


def _grid_error(comparison: xr.Dataset) -> float:
    return round(100 * float(comparison["grid_error"].max()), 3)


def lead(comparison: xr.Dataset) -> str:
    """What came out, a line per law."""
    lines = []
    for law, entry in summary(comparison)["laws"].items():
        plain, spin = entry["no_spin"]["force"], entry["spin"]["force"]
        lines.append(
            f"{law}: force at most {plain['worst']:.1f} % of μN off without spin, {spin['worst']:.1f} % with spin; "
            f"{entry['nanoseconds']:.0f} ns per call."
        )
    return "\n".join(lines)


def report_page(comparison: xr.Dataset, figure: bytes) -> Page:
    """The report of the study."""
    errors = [
        (law, kind, *(round(x, 2) for x in spread), round(1e9 * float(comparison["seconds"].sel(law=law)), 1))
        for law, kind, *spread in error_table(comparison)
    ]
    header = (
        "law",
        "creepage",
        *(f"{what}, {which} %" for what in ("force", "moment") for which in ("median", "95th", "worst")),
    )
    attributes = comparison.attrs
    return Page(
        title=f"Creep laws on an ellipse a/b = {attributes['a_over_b']:g}",
        lead=lead(comparison),
        sections=[
            Section(
                "Forces",
                [
                    Figure(
                        figure,
                        "Forces in units of the friction limit μN and spin moment in μNc, c = √(ab), over the size of the "
                        "creepage. Points: exact theory; its bars are the difference to a coarser grid.",
                    )
                ],
            ),
            Section(
                "Errors and cost",
                [
                    Table(
                        (*header, "ns per call"),
                        errors,
                        "Against the exact theory, in % of μN and of μNc. Time: plain numbers, one call, this machine, now.",
                    ),
                    Text(
                        "Exact theory: Kalker's variational theory for half-spaces, solved here with boundary elements. "
                        f"Solutions on a coarser grid differ by at most {_grid_error(comparison):g} % of μN. "
                        f"Poisson's ratio {attributes['poisson_ratio']:g}. Rolling forward, signs of the force on the wheel."
                    ),
                ],
            ),
        ],
        footer=f"rollerrig {__version__}. Equations and sources: documentation, theory/creep_laws.",
    )
