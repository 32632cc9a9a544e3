"""What `rollerrig envelope` leaves beside its runs.

Dataset of `envelope`, some of its runs over time -> [write] -> envelope.nc, envelope.csv, summary.json, report.html
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.config import Case
from rollerrig.plot import envelope as figures
from rollerrig.plot import figure_bytes
from rollerrig.report import Figure, Page, Preformatted, Section, Table, Text, number, render
from rollerrig.results import save_run, write_text
from rollerrig.simulation import simulate
from rollerrig.studies.envelope.borders import Border, borders, slides
from rollerrig.studies.envelope.compute import LINES, NUMBERS
from rollerrig.studies.envelope.judge import FINE, FULL, HELD, IMITATED, REGIONS
from rollerrig.studies.envelope.plan import BEGIN, RISE, Plan, Point, point_case, torque_text
from rollerrig.studies.envelope.virtual_rail import SLIDES
from rollerrig.studies.output import finite, write_rows

KEYS = {
    "case": "name of the case",
    "speed_kmh": "of the train at the start of each run [km/h]",
    "runs": "on the map",
    "regions": "number of runs in each region; `keys` says what they are",
    "reproduced": "part of the runs in which the rig reproduces: no limit met, tracking below 1 % RMS of train speed",
    "vehicle_torque_nm": "largest torque of the vehicle's own brake or motor on an axle, per side [N m]; null: no limit is known",
    "vehicle_reproduced": "whether all runs up to that torque are reproduced, per side; null: no limit is known",
    "borders": "per side, load and adhesion: largest torque up to which all is reproduced, the next one run, its limit, and "
    "where the closed forms put the border [N m]; null: none",
    "borders.*.agrees": "whether closed form and map agree within a cell of the map; null: not to be compared",
    "agreement.borders, agreement.slides": "borders that agree, and how many were compared: of limits; of sliding (V2)",
    **{f"regions.{name}": meaning for name, meaning in REGIONS.items()},
}
"""Key of summary.json -> meaning."""

METHOD = (
    f"Each point is a run of the whole rig, {{duration:g}} s long, from {{speed:.4g}} km/h: the torque rises from "
    f"{BEGIN:g} s to {BEGIN + RISE:g} s and stays; slide protection or wheel-slip control lets the wheels slide and regain "
    f"speed. A region is named after the limit that is met first for at least {1e3 * HELD:g} ms: creep force of "
    f"{FULL:g} of the friction between wheel and roller, or the whole torque of a roller's drive. Where no limit is "
    f"met the tracking error decides: {100 * FINE:g} % of train speed, RMS. Wheels slide where the virtual slip "
    f"exceeds {SLIDES[0]:g} times that of the creep curve's peak by {100 * SLIDES[1]:g} %. Cells between different "
    "regions are halved; colours between runs are those of the nearest one."
)
CLOSED_FORMS = (
    "Lines are closed forms, not fits: rolling without sliding, steady forces, no lag of drives and estimator. Load "
    "transfer is that of the vehicle at rest under a steady force; (V2) and (V6) take the peak of the creep "
    "curve of the rail, (V5) the adhesion at the slip where the protection acts. The torque in (V6) is that which the "
    "protection leaves on the axle, not the one asked for: a run to the right of (V2) is limited on the way out of its "
    "slide if the protection takes off more than that. Where the protection takes torque off before all of it acts, as "
    "wheel-slip control does, the rig reaches beyond (V5). A border agrees if its line passes within a cell of the map."
)
LEFT_OUT = (
    "The torque comes at once, from ideal cylinders or motors: the vehicle's own would be slower and slide more "
    "gently. Runs are short: heat and wear of rollers and drives do not limit them. The rail does not change along "
    "the way."
)


def example_runs(plan: Plan, found: xr.Dataset) -> dict[str, tuple[Point, xr.Dataset]]:
    """A run of each region from well within it, at the load nearest to the case's own."""
    chosen = {}
    for region in REGIONS:
        point = _middle(found, region)
        if point is not None and region != "failed":
            chosen[region] = (point, simulate(point_case(plan, point)))
    return chosen


def _middle(found: xr.Dataset, region: str) -> Point | None:
    """The run of a region that lies farthest from any other and from the map's edge, counted in places of the lattice."""
    for load in sorted(found["load"].to_numpy(), key=lambda value: abs(value - 1.0)):
        regions = found["region"].sel(load=load).to_numpy()
        own = np.argwhere(regions == region)
        if not len(own):
            continue
        others = np.argwhere((regions != region) & (regions != ""))
        edge = np.minimum(own, np.array(regions.shape) - 1 - own).min(axis=1) + 1.0
        apart = [math.inf if not len(others) else np.hypot(*(others - place).T).min() for place in own]
        distance = np.minimum(edge, apart)
        row, column = own[int(np.argmax(distance))]
        return Point(float(load), float(found["torque"][column]), float(found["adhesion"][row]))
    return None


def write_envelope(
    case: Case, found: xr.Dataset, examples: Mapping[str, tuple[Point, xr.Dataset]], folder: Path
) -> list[Path]:
    """Write all files.

    Args:
        case: of the map.
        found: of `envelope`.
        examples: of `example_runs`.
        folder: an existing folder.

    Returns:
        The files, the report last.

    Raises:
        OutputError: a file could not be written.
    """
    kept = found.drop_attrs(deep=False).assign_attrs(
        {key: value for key, value in found.attrs.items() if key not in ("processor_seconds", "runs_from_before")}
    )  # the same map, the same bytes
    numbers = summary(found)
    text = json.dumps({**numbers, "keys": KEYS}, indent=2, ensure_ascii=False)
    return [
        save_run(kept, folder / "envelope.nc"),
        write_rows(folder / "envelope.csv", _rows(found)),
        write_text(folder / "summary.json", text + "\n"),
        write_text(folder / "report.html", report(case, found, examples, numbers)),
    ]


def _rows(found: xr.Dataset) -> list[list[object]]:
    """One row per run."""
    words = ("region", "limits", "status")
    header: list[object] = ["load", "axle_load_n", "torque_nm", "adhesion", *words, *NUMBERS]
    rows = [header]
    for load, adhesion, torque in np.argwhere(found["region"].to_numpy() != ""):
        here = found.isel(load=load, adhesion=adhesion, torque=torque)
        place: list[object] = [float(here[name]) for name in ("load", "axle_load", "torque", "adhesion")]
        rows.append([*place, *(str(here[name].item()) for name in words), *(float(here[name]) for name in NUMBERS)])
    return rows


# --------------------------------------------------------------------------------------------------------- numbers


def summary(found: xr.Dataset) -> dict[str, Any]:
    """The numbers of a map under the keys of KEYS."""
    regions = found["region"].to_numpy()
    counts = {name: int((regions == name).sum()) for name in REGIONS}
    runs = sum(counts.values())
    reach, begin = borders(found), slides(found)
    own = {str(side): _vehicle_torque(found, str(side)) for side in found["side"].to_numpy()}
    return {
        "case": found.attrs["case"],
        "speed_kmh": found.attrs["speed_kmh"],
        "runs": runs,
        "regions": counts,
        "reproduced": sum(counts[name] for name in IMITATED) / max(1, runs),
        "vehicle_torque_nm": own,
        "vehicle_reproduced": {side: _vehicle_reproduced(found, side, torque) for side, torque in own.items()},
        "agreement": {"borders": _agreement(reach), "slides": _agreement(begin)},
        "borders": [_border(border) for border in reach],
        "rollerrig_version": found.attrs["rollerrig_version"],
    }


def _vehicle_torque(found: xr.Dataset, side: str) -> float | None:
    return finite(float(found["line_vehicle"].sel(side=side).isel(load=0, line_adhesion=0)))


def _vehicle_reproduced(found: xr.Dataset, side: str, torque: float | None) -> bool | None:
    if torque is None:
        return None
    signed = (-1.0 if side == "brake" else 1.0) * found["torque"].to_numpy()
    regions = found["region"].to_numpy()[..., (signed > 0.0) & (signed <= torque)]
    run = regions[regions != ""]
    return bool(np.isin(run, IMITATED).all()) if run.size else None


def _agreement(rows: list[Border]) -> dict[str, int]:
    compared = [row.agrees for row in rows if row.agrees is not None]
    return {"agree": sum(compared), "of": len(compared)}


def _border(border: Border) -> dict[str, Any]:
    return {
        "side": border.side,
        "load": border.load,
        "adhesion": border.adhesion,
        "reproduced_up_to_nm": border.reached,
        "beyond_nm": finite(border.beyond),
        "limit": border.limit or None,
        "predicted_nm": finite(border.predicted),
        "agrees": border.agrees,
    }


def lead(found: xr.Dataset) -> str:
    """The verdict in a few lines."""
    numbers = summary(found)
    counts = numbers["regions"]
    limits = sorted((name for name in REGIONS if counts[name] and name not in IMITATED), key=lambda name: -counts[name])
    lines = [
        f"{numbers['runs']} runs at {numbers['speed_kmh']:.4g} km/h: "
        f"the rig reproduces {100 * numbers['reproduced']:.0f} % of them."
    ]
    if limits:
        lines.append(
            "What limits the others first: " + "; ".join(f"{REGIONS[n]} ({_runs(counts[n])})" for n in limits) + "."
        )
    for side, torque in numbers["vehicle_torque_nm"].items():
        if torque is not None:
            machine = "brake" if side == "brake" else "motor"
            reproduced = numbers["vehicle_reproduced"][side]
            verdict = {True: "is reproduced on every rail and load", None: "lies below the map"}.get(reproduced)
            lines.append(
                f"What the vehicle's own {machine} exerts, up to {torque_text(float(f'{torque:.3g}'))} per axle, "
                f"{verdict or 'is not reproduced everywhere: see the table'}."
            )
    agreement = numbers["agreement"]
    told = [
        f"{agreement[key]['agree']} of {agreement[key]['of']} {what}"
        for key, what in _AGREEMENTS
        if agreement[key]["of"]
    ]
    if told:
        lines.append(f"Closed forms and runs agree within a cell of the map on {' and '.join(told)}.")
    return "\n".join(lines)


def _runs(count: int) -> str:
    return "1 run" if count == 1 else f"{count} runs"


_AGREEMENTS = (("borders", "borders of the limits"), ("slides", "borders of sliding"))


# ---------------------------------------------------------------------------------------------------------- report


def report(
    case: Case, found: xr.Dataset, examples: Mapping[str, tuple[Point, xr.Dataset]], numbers: Mapping[str, Any]
) -> str:
    """One self-contained HTML page."""
    maps: list[Any] = [
        Figure(
            figure_bytes(figures.region_map(found, float(load), REGIONS), "png"),
            f"Regions at an axle load of {1e-3 * float(found['axle_load'].sel(load=load)):.4g} kN: what limits the rig first.",
        )
        for load in found["load"].to_numpy()
    ]
    method = METHOD.format(duration=found.attrs["duration_s"], speed=found.attrs["speed_kmh"])
    sections = [
        Section("Map", [Text(method), *maps]),
        Section("How far the rig reaches", [_reach(found)]),
        Section(
            "Closed forms", [Text(CLOSED_FORMS), Table(("line", "meaning"), list(LINES.items())), _deviations(found)]
        ),
        Section("Runs over time", _over_time(case, examples)),
        Section("Runs by region", [_counts(numbers)]),
        Section("What is left out", [Text(LEFT_OUT)]),
        Section("Case", [Preformatted("the whole case", found.attrs["config_toml"])]),
    ]
    title = f"{found.attrs['case']}: where the rig can reproduce a degraded rail"
    return render(Page(title, lead(found), sections, f"rollerrig {found.attrs['rollerrig_version']}"))


def _reach(found: xr.Dataset) -> Table:
    """Largest reproduced torque over adhesion, a column per side and load."""
    rows = borders(found)
    columns = list(dict.fromkeys((row.side, row.load) for row in rows))
    cells = {(row.side, row.load, row.adhesion): _reach_cell(row) for row in rows}
    table = [
        [number(adhesion), *(cells.get((side, load, adhesion), "–") for side, load in columns)]
        for adhesion in sorted({row.adhesion for row in rows})
    ]
    load_kn = 1e-3 * found["axle_load"].to_numpy()
    names = dict(zip(map(float, found["load"].to_numpy()), load_kn, strict=True))
    header = ("adhesion", *(f"{side}, axle load {names[load]:.4g} kN" for side, load in columns))
    return Table(
        header, table, "largest torque on an axle up to which every run is reproduced, and what limits the next"
    )


def _reach_cell(row: Border) -> str:
    reached = torque_text(row.reached)
    return f"{reached}; {REGIONS[row.limit]}" if row.limit else f"{reached}, the whole map"


def _deviations(found: xr.Dataset) -> Table:
    """Closed form against the two runs on either side of each border."""
    rows = []
    for what, found_rows in (("limit", borders(found)), ("slide, (V2)", slides(found))):
        for row in found_rows:
            if row.agrees is not None:
                between = f"{torque_text(row.reached)} … {torque_text(row.beyond)}"
                name = REGIONS[row.limit] if what == "limit" else what
                verdict = "✔" if row.agrees else "✘"
                rows.append([row.side, row.load, row.adhesion, name, between, torque_text(row.predicted), verdict])
    header = (
        "side",
        "load",
        "adhesion",
        "border of",
        "runs on either side",
        "closed form",
        "within a cell",
    )
    return Table(header, rows)


def _over_time(case: Case, examples: Mapping[str, tuple[Point, xr.Dataset]]) -> list[Any]:
    radius, friction = case.vehicle.data.wheel.radius, case.contact.friction
    pictures: list[Any] = []
    names = list(examples)
    for begin in range(0, len(names), 3):
        group = names[begin : begin + 3]
        runs = [(f"{REGIONS[name]}: {examples[name][0].label}", examples[name][1]) for name in group]
        caption = (
            "The axle that uses most friction, in a run from within each region: "
            + "; ".join(REGIONS[name] for name in group)
            + "."
        )
        pictures.append(Figure(figure_bytes(figures.runs_over_time(runs, radius, friction), "png"), caption))
    return pictures


def _counts(numbers: Mapping[str, Any]) -> Table:
    rows = [[meaning, numbers["regions"][name]] for name, meaning in REGIONS.items()]
    return Table(("region", "runs"), rows)
