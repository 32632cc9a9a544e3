"""The contact characteristics of one pair of profiles, on rails and, where asked, on rollers beside them.

wheel, rail -> [conicity study] -> report.html, shift.csv, conicity.csv, characteristics.png, summary.json
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from rollerrig import __version__
from rollerrig.characteristics import conicity_table, pair_case, shift_table
from rollerrig.config import Case
from rollerrig.plot.characteristics import characteristics_figure
from rollerrig.plot.style import figure_bytes
from rollerrig.report import Figure, Page, Preformatted, Section, Table, Text, render
from rollerrig.results import output_folder, write_bytes, write_text
from rollerrig.studies.output import finite, write_rows

CONICITY_KEYS = {
    "wheel": "wheel profile as asked for",
    "rail": "rail profile as asked for",
    "gauge_mm": "distance between the gauge sides [mm]",
    "back_to_back_mm": "distance between the flange backs [mm]",
    "wheel_radius_mm": "radius at the tape circle [mm]",
    "roll": "'neglected': each wheel is lowered on its own; 'free': the wheelset rolls until both wheels touch",
    "yaw_mrad": "yaw angle at which the wheelset is shifted [mrad]",
    "method": "how the conicity is computed, and after which standard",
    "supports": "per support, rail and where asked roller, the numbers below",
    "supports.*.roller_radius_mm": "radius at the crown [mm]; null: a rail",
    "supports.*.conicity_3mm": "equivalent conicity at 3 mm of amplitude [-]; null: none, or out of the range",
    "supports.*.conicity_of_wheels_3mm": "its part from the radii of the wheels [-]; null: none",
    "supports.*.conicity_of_rollers_3mm": "its part from the radii of the rollers [-], 0 on rails; null: none",
    "supports.*.wavelength_3mm_m": "wavelength of the kinematic motion there [m]",
    "supports.*.nonlinearity_per_mm": "change of the conicity from 2 to 4 mm, per millimetre [1/mm]",
    "supports.*.largest_shift_mm": "end of the table of lateral shifts [mm]",
    "supports.*.ended": "why the table ends earlier than asked, empty if it does not",
    "supports.*.jumps_mm": "lateral shifts to the left at which a contact jumps by more than 1 mm [mm]",
    "rollerrig_version": "version of this program",
}
"""Key of summary.json -> meaning and unit."""

METHOD = (
    "integration of the kinematic motion y'' + Δr(y)/(e r0) = 0 over a wave; EN 15302:2021, clause 9 and annex E "
    "(EN 15302:2008, annex B)"
)

REFERENCE_AMPLITUDE = 3e-3  # [m], the amplitude at which conicities are quoted


@dataclass(frozen=True)
class ConicityStudy:
    """What was computed.

    Attributes:
        wheel: wheel profile as asked for.
        rail: rail profile as asked for.
        case: the pair on rails.
        shifts: label of a support -> what `shift_table` returns.
        conicity: label of a support -> what `conicity_table` returns.
    """

    wheel: str
    rail: str
    case: Case
    shifts: dict[str, xr.Dataset]
    conicity: dict[str, xr.Dataset]


def conicity_study(
    wheel: str,
    rail: str,
    amplitudes: Sequence[float],
    *,
    roller_radius: float | None = None,
    largest: float = 8e-3,
    step: float = 0.1e-3,
    free_to_roll: bool = False,
    yaw: float = 0.0,
    **lengths: float,
) -> ConicityStudy:
    """Characteristics of a pair on rails, and on rollers of the same head.

    Args:
        wheel: wheel profile: a name of the catalogue or a file.
        rail: rail profile, likewise.
        amplitudes: of the conicity [m]; those beyond the end of the table of shifts are left out.
        roller_radius: radius at the crown of the rollers [m]; None: rails only.
        largest: lateral shift to both sides [m].
        step: distance of the rows [m].
        free_to_roll: see `shift_table`.
        yaw: see `shift_table` [rad].
        **lengths: gauge, gauge_depth, back_to_back, radius of `pair_case` [m].

    Raises:
        ConfigError: a profile or a length cannot be used.
        ValueError: the wheels do not touch.
    """
    cases = {"rail": pair_case(wheel, rail, **lengths)}
    if roller_radius is not None:
        cases[f"roller R = {1e3 * roller_radius:g} mm"] = pair_case(wheel, rail, roller_radius=roller_radius, **lengths)
    shifts = {
        name: shift_table(case, largest, step, free_to_roll=free_to_roll, yaw=yaw) for name, case in cases.items()
    }
    conicity = {}
    for name, table in shifts.items():
        end = float(table["lateral"][-1]) * (1 + 1e-12)
        conicity[name] = conicity_table(table, [a for a in amplitudes if a <= end])
    return ConicityStudy(wheel, rail, cases["rail"], shifts, conicity)


def write_study(study: ConicityStudy, out: str | Path) -> list[Path]:
    """Write report.html, shift.csv, conicity.csv, characteristics.png and summary.json.

    Raises:
        OutputError: a file could not be written.
    """
    folder = output_folder(out)
    figure = characteristics_figure(study.shifts, study.conicity)
    return [
        write_rows(folder / "shift.csv", shift_rows(study)),
        write_rows(folder / "conicity.csv", conicity_rows(study)),
        write_bytes(folder / "characteristics.png", figure_bytes(figure, "png")),
        write_text(folder / "summary.json", json.dumps(summary(study), indent=2, ensure_ascii=False) + "\n"),
        write_text(folder / "report.html", render(report_page(study, figure_bytes(figure)))),
    ]


_SIDE_COLUMNS = {
    "rolling_radius": ("mm", 1e3),
    "wheel_abscissa": ("mm", 1e3),
    "rail_abscissa": ("mm", 1e3),
    "rail_height": ("mm", 1e3),
    "contact_angle": ("rad", 1.0),
    "longitudinal": ("mm", 1e3),
}


def shift_rows(study: ConicityStudy) -> list[list[object]]:
    """Table over lateral shift, header first."""
    header: list[object] = [
        *("support", "lateral_mm", "roll_mrad", "rolling_radius_difference_mm", "effective_difference_mm"),
        *(f"{name}_{side}_{unit}" for side in ("left", "right") for name, (unit, _) in _SIDE_COLUMNS.items()),
    ]
    rows = [header]
    for label, table in study.shifts.items():
        common = ("lateral", "roll", "rolling_radius_difference", "effective_difference")
        columns = [1e3 * table[name].to_numpy() for name in common]
        for side in ("left", "right"):
            columns += [factor * table[name].sel(side=side).to_numpy() for name, (_, factor) in _SIDE_COLUMNS.items()]
        rows += [[label, *(float(v) + 0.0 for v in values)] for values in zip(*columns, strict=True)]
    return rows


def conicity_rows(study: ConicityStudy) -> list[list[object]]:
    """Table over amplitude, header first."""
    rows: list[list[object]] = [
        ["support", "amplitude_mm", "equivalent_conicity", "conicity_of_wheels", "conicity_of_rollers", "wavelength_m"]
    ]
    for label, table in study.conicity.items():
        columns = (1e3 * table["amplitude"], *(table[n] for n in ("conicity", "of_wheels", "of_rollers", "wavelength")))
        rows += [[label, *map(float, values)] for values in zip(*(c.to_numpy() for c in columns), strict=True)]
    return rows


def summary(study: ConicityStudy) -> dict[str, Any]:
    """The numbers of the study under the keys of CONICITY_KEYS, and the keys themselves."""
    first = next(iter(study.shifts.values())).attrs
    return {
        "wheel": study.wheel,
        "rail": study.rail,
        "gauge_mm": 1e3 * first["gauge_m"],
        "back_to_back_mm": 1e3 * first["back_to_back_m"],
        "wheel_radius_mm": 1e3 * first["wheel_radius_m"],
        "roll": first["roll"],
        "yaw_mrad": 1e3 * first["yaw_rad"],
        "method": METHOD,
        "supports": {label: _support(table) for label, table in study.shifts.items()},
        "rollerrig_version": __version__,
        "keys": CONICITY_KEYS,
    }


def _support(table: xr.Dataset) -> dict[str, Any]:
    end = float(table["lateral"][-1])
    at = conicity_table(table, [REFERENCE_AMPLITUDE] if end >= REFERENCE_AMPLITUDE else [])
    conicity, wheels, rollers, wavelength = (
        float(at[name][0]) if at.sizes["amplitude"] else np.nan
        for name in ("conicity", "of_wheels", "of_rollers", "wavelength")
    )
    radius = finite(table.attrs["roller_radius_m"])
    return {
        "roller_radius_mm": None if radius is None else 1e3 * radius,
        "conicity_3mm": finite(conicity),
        "conicity_of_wheels_3mm": finite(wheels),
        "conicity_of_rollers_3mm": finite(rollers),
        "wavelength_3mm_m": finite(wavelength),
        "nonlinearity_per_mm": finite(at.attrs["nonlinearity_per_mm"]),
        "largest_shift_mm": round(1e3 * end, 9),
        "ended": table.attrs["ended"],
        "jumps_mm": jumps(table),
    }


def jumps(table: xr.Dataset) -> list[float]:
    """Lateral shifts to the left at which a contact on a wheel jumps by more than 1 mm [mm], to 1e-3 mm."""
    y = table["lateral"].to_numpy()
    way = np.abs(np.diff(table["wheel_abscissa"].to_numpy(), axis=0)).max(axis=1)
    return [round(1e3 * float(at), 3) for at in (0.5 * (y[1:] + y[:-1]))[way > 1e-3] if at > 0]


def lead(study: ConicityStudy) -> str:
    """What came out, a sentence per support."""
    lines = []
    for label, values in summary(study)["supports"].items():
        conicity, wave = values["conicity_3mm"], values["wavelength_3mm_m"]
        if conicity is None:
            text = "no equivalent conicity at 3 mm: nothing drives the wheelset back, or the table ends before"
        elif wave is None:
            text = "equivalent conicity 0 at 3 mm: the rolling radii do not differ"
        else:
            text = f"equivalent conicity {conicity:.4f} at 3 mm, wavelength {wave:.2f} m"
            if values["roller_radius_mm"] is not None:
                wheels, rollers = values["conicity_of_wheels_3mm"], values["conicity_of_rollers_3mm"]
                text += f"; {wheels:.4f} from the wheels' radii, {rollers:+.4f} from the rollers'"
        lines.append(f"{label}: {text}.")
        if values["ended"]:
            lines.append(f"{label}: {values['ended']}.")
    return "\n".join(lines)


def report_page(study: ConicityStudy, figure: bytes) -> Page:
    """The report of the study."""
    rows = [
        (label, *(float(table["conicity"].sel(amplitude=a, method="nearest")) for a in _quoted(table)))
        for label, table in study.conicity.items()
    ]
    header = ("support", *(f"{1e3 * a:g} mm" for a in _quoted(next(iter(study.conicity.values())))))
    first = next(iter(study.shifts.values())).attrs
    yaw = f"yaw {1e3 * first['yaw_rad']:g} mrad" if first["yaw_rad"] else "no yaw"
    texts = [
        Text(f"Conicity: {METHOD}. Roll of the wheelset: {first['roll']}. Rigid profiles, {yaw}."),
        Text(
            "A roller's generatrix is the rail's head, so without yaw the wheels touch both in the same points. On rollers "
            "the rolling radius difference counts the rollers' radii as well, Δr - (r0/R0) ΔR, and the wavelength is the "
            "way of the rollers' surface. What the rollers add to the conicity stands beside the wheels' own part."
        ),
    ]
    sections = [
        Section(
            "Characteristics",
            [
                Figure(
                    figure, "Contact characteristics over lateral shift and amplitude; all supports in one picture."
                ),
                Table(header, rows, "Equivalent conicity over the amplitude of the motion"),
                *_parts(study),
                *texts,
            ],
        ),
        Section("Pair", [Preformatted("the whole configuration", study.case.to_toml())]),
    ]
    return Page(f"Contact characteristics: {first['title']}", lead(study), sections, f"rollerrig {__version__}")


def _parts(study: ConicityStudy) -> list[Table]:
    """The conicity on rollers as the wheels' part and the rollers'; nothing on rails alone."""
    names = {"of_wheels": "of the wheels", "of_rollers": "of the rollers", "conicity": "together"}
    tables = []
    for label, table in study.conicity.items():
        if study.shifts[label].attrs["support"] == "track":
            continue
        header = ("part", *(f"{1e3 * a:g} mm" for a in _quoted(table)))
        rows = [
            (words, *(float(table[name].sel(amplitude=a, method="nearest")) for a in _quoted(table)))
            for name, words in names.items()
        ]
        tables.append(Table(header, rows, f"Where the conicity comes from: {label}"))
    return tables


def _quoted(table: xr.Dataset) -> list[float]:
    """Amplitudes nearest to whole millimetres."""
    amplitudes = table["amplitude"].to_numpy()
    return [float(a) for a in amplitudes if abs(1e3 * a - round(1e3 * a)) < 1e-6 and a > 0.5e-3]
