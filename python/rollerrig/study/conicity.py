"""The contact characteristics of one pair of profiles, on rails and, where asked, on rollers beside them.

wheel, rail -> [ConicityStudy] -> tables over lateral shift and amplitude, equivalent conicity
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import xarray as xr

from rollerrig.config import Case
from rollerrig.contact_analysis import conicity_table, pair_case, shift_table
from rollerrig.plot.contact import characteristics_figure
from rollerrig.study.frame import Study, dataset_rows
from rollerrig.study.jobs import Done, Round, job
from rollerrig.study.options import Option, command
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Block, Picture, Section, Table, Text

REFERENCE_AMPLITUDE = 3e-3  # at which conicities are quoted [m]

METHOD = (
    "integration of the kinematic motion y'' + Δr(y)/(e r0) = 0 over a wave; EN 15302:2021, clause 9 and annex E "
    "(EN 15302:2008, annex B)"
)
SIDE_COLUMNS = {
    "rolling_radius": ("mm", 1e3),
    "wheel_abscissa": ("mm", 1e3),
    "rail_abscissa": ("mm", 1e3),
    "rail_height": ("mm", 1e3),
    "contact_angle": ("rad", 1.0),
}


@dataclass(frozen=True)
class Characteristics:
    """Tables of `shift_table` and `conicity_table` by label of the support."""

    shifts: dict[str, xr.Dataset]
    conicity: dict[str, xr.Dataset]

    def dataset(self) -> xr.Dataset:
        """All of it over `support`, lateral shift, side and amplitude."""
        pairs = ([self.shifts[label], self.conicity[label]] for label in self.shifts)
        tables = [xr.merge(pair, combine_attrs="override") for pair in pairs]
        labels = xr.DataArray(list(self.shifts), dims="support", name="support")
        return xr.concat(tables, labels, join="outer", combine_attrs="override")


@dataclass(frozen=True)
class ConicityStudy(Study[Characteristics]):
    """Characteristics of a pair on rails, and on rollers of the same head; attributes as the arguments of `rollerrig.conicity`.

    Amplitudes beyond the end of the table of shifts are left out.
    """

    wheel: str
    rail: str
    amplitudes: tuple[float, ...]
    roller_radius: float | None
    largest: float
    step: float
    free_to_roll: bool
    lengths: Mapping[str, float]

    command = "conicity"
    writes = ("shift.csv", "conicity.csv")
    formats = ("svg", "png")
    resumable = False

    def __post_init__(self) -> None:
        """Refuse with a ConfigError profiles and lengths that cannot be used."""
        self.cases()

    @property
    def title(self) -> str:
        return f"Contact characteristics: {self.cases()['rail'].description}"

    def cases(self) -> Mapping[str, Case]:
        found = {"rail": pair_case(self.wheel, self.rail, **self.lengths)}
        if self.roller_radius is not None:
            rollers = pair_case(self.wheel, self.rail, roller_radius=self.roller_radius, **self.lengths)
            found[f"roller R = {1e3 * self.roller_radius:g} mm"] = rollers
        return found

    def limitations(self) -> list[str]:
        return ["Profiles are rigid and do not wear; the conicity is that of a free wheelset in pure rolling."]

    def rounds(self, done: Done) -> Iterator[Round]:
        rows = (self.largest, self.step, self.free_to_roll)
        yield {label: job(shift_table, case, *rows) for label, case in self.cases().items()}

    def collect(self, done: Done) -> Characteristics | None:
        if len(done) < len(self.cases()):
            return None
        ends = {label: float(table["lateral"][-1]) * (1 + 1e-12) for label, table in done.items()}
        known = {label: [a for a in self.amplitudes if a <= end] for label, end in ends.items()}
        conicity = {label: conicity_table(table, known[label]) for label, table in done.items()}
        return Characteristics(dict(done), conicity)

    def statuses(self, results: Characteristics) -> Sequence[str]:
        return ["ended early" if table.attrs["ended"] else "ok" for table in results.shifts.values()]

    def numbers(self, results: Characteristics) -> dict[str, Any]:
        first = next(iter(results.shifts.values())).attrs
        return {
            "wheel": self.wheel,
            "rail": self.rail,
            "gauge_mm": 1e3 * first["gauge_m"],
            "back_to_back_mm": 1e3 * first["back_to_back_m"],
            "wheel_radius_mm": 1e3 * first["wheel_radius_m"],
            "roll": first["roll"],
            "method": METHOD,
            "supports": {label: support_numbers(table) for label, table in results.shifts.items()},
        }

    def summary(self, results: Characteristics, numbers: Numbers) -> list[str]:
        lines = []
        for label, values in numbers["supports"].items():
            said = self.quantities.said(values, list(AT_3_MM))
            missing = "no equivalent conicity at 3 mm: nothing restores, or the table ends before"
            lines.append(f"{label}: {said or missing}.")
            lines += [f"{label}: {values['ended']}."] * bool(values["ended"])
        return lines

    def files(self, results: Characteristics, numbers: Numbers) -> Mapping[str, Any]:
        return {"shift.csv": shift_rows(results.shifts), "conicity.csv": conicity_rows(results.conicity)}

    def sections(self, results: Characteristics, numbers: Numbers) -> list[Section]:
        figure = characteristics_figure(results.shifts, results.conicity)
        caption = "Contact characteristics over lateral shift and amplitude; all supports in one picture."
        blocks: list[Block] = [
            Picture("characteristics", figure, caption),
            _amplitude_table(results.conicity),
            Text(f"Conicity: {METHOD}. Roll of the wheelset: {numbers['roll']}. Rigid profiles, no yaw."),
        ]
        return [Section("Characteristics", blocks)]


def support_numbers(table: xr.Dataset) -> dict[str, Any]:
    """What is reported of one support, without the ends of the keys' names."""
    end = float(table["lateral"][-1])
    at = conicity_table(table, [REFERENCE_AMPLITUDE] if end >= REFERENCE_AMPLITUDE else [])
    return {
        "roller_radius_mm": 1e3 * table.attrs["roller_radius_m"],
        **{key: float(at[name][0]) if at[name].size else math.nan for key, name in AT_3_MM.items()},
        "nonlinearity_per_mm": at.attrs["nonlinearity_per_mm"],
        "largest_shift_mm": round(1e3 * end, 9),
        "ended": table.attrs["ended"],
    }


AT_3_MM = {  # key of what is quoted at REFERENCE_AMPLITUDE -> variable of `conicity_table`
    "conicity_3mm": "conicity",
    "wavelength_3mm_m": "wavelength",
}


def _amplitude_table(conicity: Mapping[str, xr.Dataset]) -> Table:
    """Conicities at the amplitudes nearest to whole millimetres, a row for each support."""
    rows = {label: table["conicity"] for label, table in conicity.items()}
    first = next(iter(rows.values()))["amplitude"].to_numpy()
    quoted = [float(a) for a in first if abs(1e3 * a - round(1e3 * a)) < 1e-6 and a > 0.5e-3]
    cells = [(label, *(float(v.sel(amplitude=a, method="nearest")) for a in quoted)) for label, v in rows.items()]
    header = ("support", *(f"{1e3 * a:g} mm" for a in quoted))
    return Table(header, cells, "Equivalent conicity over the amplitude of the motion")


def shift_rows(shifts: Mapping[str, xr.Dataset]) -> list[list[object]]:
    """Table over lateral shift, header first."""
    names = ("rolling_radius_difference", "effective_difference")
    rows, columns = [], dict[str, xr.DataArray]()
    for label, table in shifts.items():
        columns = {"lateral_mm": 1e3 * table["lateral"], "roll_mrad": 1e3 * table["roll"]}
        columns |= {f"{name}_mm": 1e3 * table[name] for name in names}
        for side, (name, (unit, factor)) in itertools.product(("left", "right"), SIDE_COLUMNS.items()):
            columns[f"{name}_{side}_{unit}"] = factor * table[name].sel(side=side)
        rows += [[label, *values] for values in (np.stack(list(columns.values()), axis=1) + 0.0).tolist()]
    return [["support", *columns], *rows]


def conicity_rows(conicity: Mapping[str, xr.Dataset]) -> list[list[object]]:
    """Table over amplitude, header first."""
    columns = {"amplitude_mm": "amplitude", "equivalent_conicity": "conicity", "wavelength_m": "wavelength"}
    tables = {label: table.assign_coords(amplitude=1e3 * table["amplitude"]) for label, table in conicity.items()}
    rows = [[label, *row] for label, table in tables.items() for row in dataset_rows(table, columns, "amplitude")[1:]]
    return [["support", *columns], *rows]


@command
def conicity(
    wheel: str,
    rail: str,
    *,
    gauge: Annotated[float, Option("gauge_mm", "mm", 10.0, 5000.0)] = 1.435,
    gauge_depth: Annotated[float, Option("gauge_depth_mm", "mm", 0.01, 50.0)] = 14e-3,
    back_to_back: Annotated[float, Option("back_to_back_mm", "mm", 10.0, 5000.0)] = 1.36,
    radius: Annotated[float, Option("radius_mm", "mm", 10.0, 2000.0)] = 0.46,
    roller_radius: Annotated[float | None, Option("roller_radius_mm", "mm", 1.0, 1e9)] = None,
    amplitudes: Annotated[Sequence[float] | None, Option("amplitudes_mm", "mm")] = None,
    largest: Annotated[float, Option("shift_mm", "mm", 0.1, 50.0)] = 8e-3,
    step: Annotated[float, Option("step_mm", "mm", 0.005, 1.0)] = 1e-4,
    free_to_roll: Annotated[bool, Option("with_roll")] = False,
) -> xr.Dataset:
    """Rolling radius difference, contact angles and positions, and equivalent conicity of a pair of profiles.

    Args:
        wheel: wheel profile: a name of the catalogue or a file of points.
        rail: rail profile, also the generatrix of a roller: likewise.
        gauge: distance between the gauge sides [m].
        gauge_depth: depth of the gauge below the highest point [m].
        back_to_back: distance between the flange backs [m].
        radius: wheel radius at the tape circle [m].
        roller_radius: radius of rollers of this head, to be shown beside the rails [m]; None: rails only.
        amplitudes: amplitudes of the conicity [m]; None: 0.5 to 7 mm in steps of 0.1 mm, as far as the shift goes.
        largest: lateral shift to both sides [m].
        step: distance of the rows [m].
        free_to_roll: roll the wheelset until both wheels touch; neglected otherwise.

    Returns:
        Dataset over support, lateral shift, side and amplitude, see `shift_table` and `conicity_table`.

    Raises:
        ConfigError: a profile or a length cannot be used.
        ValueError: the wheels do not touch, or an amplitude is beyond the shift.

    Example:
        >>> import rollerrig as rr
        >>> found = rr.conicity("s1002", "en_60e1_1_40")
        >>> round(float(found["conicity"].sel(support="rail", amplitude=3e-3, method="nearest")), 3)
        0.174
    """
    if amplitudes is not None and not 0.0 < min(amplitudes) <= max(amplitudes) <= largest * (1.0 + 1e-9):
        least, most, end = (1e3 * one for one in (min(amplitudes), max(amplitudes), largest))
        raise ValueError(
            f"amplitudes from {least:g} to {most:g} mm: allowed above 0 and up to the largest shift, {end:g} mm"
        )
    values = sorted({round(1e-4 * k, 6) for k in range(5, 71)} if amplitudes is None else set(amplitudes))
    lengths = {"gauge": gauge, "gauge_depth": gauge_depth, "back_to_back": back_to_back, "radius": radius}
    rows = (largest, min(step, largest), free_to_roll)
    return ConicityStudy(wheel, rail, tuple(values), roller_radius, *rows, lengths).outcome().results.dataset()
