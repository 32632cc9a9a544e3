"""The files of the comparison.

CompareResults -> [write] -> report.html, figures, CSV, NetCDF, summary.json
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from rollerrig import __version__
from rollerrig.plot import figure_bytes
from rollerrig.report import render
from rollerrig.results import output_folder, save_run, write_text
from rollerrig.results.files import write_bytes
from rollerrig.studies.compare.compute import CompareResults
from rollerrig.studies.compare.critical import EFFECTS, TRACK, Causes, CriticalTable
from rollerrig.studies.compare.figures import compare_figures
from rollerrig.studies.compare.page import DISTURBED, WHEEL_HEADER, compare_page, disturbed_numbers, wheel_numbers
from rollerrig.studies.output import finite, write_rows
from rollerrig.studies.stability import disturbance_summary, mode_rows, run_rows

COMPARE_KEYS = {
    "vehicle": "name of the vehicle",
    "cut": "part of it that was compared",
    "supports": "per support, as named after --on, the numbers below",
    "supports.*.support": "name of the rig or track",
    "supports.*.roller_radius_m": "radius of its rollers [m]; null: a track",
    "supports.*.linear_critical_speed_kmh": "speed at which an oscillation begins to grow [km/h]; null: none from 30 to "
    "600 km/h",
    "supports.*.linear_critical_frequency_hz": "its frequency [Hz]",
    "supports.*.linear_critical_mode": "name of the mode",
    "supports.*.by_disturbance": "runs from a lateral offset of the leading wheelset: its size [mm], highest speed below the "
    "onset at which it decays and lowest at which it persists [km/h], and each run",
    "supports.*.static_wheel_load_kn": "per wheel, load in steady rolling at the lowest speed [kN]",
    "supports.*.conicity_3mm": "equivalent conicity at 3 mm, on rollers with their own radii",
    "supports.*.disturbed": "largest magnitudes of the leading wheelset in the disturbed run: guiding force [kN], sum of guiding "
    "forces [kN], longitudinal force [kN], wheel unloading [%], Y/Q [-], wear number [N]",
    "disturbed_kmh": "speed of the disturbed run [km/h]",
    "critical_speed_over_radius_kmh": "per part of the vehicle and roller radius [m] ('track': none) the linear critical speed "
    "[km/h]; null: none in the range",
    "causes": "split of the linear critical speed's loss from track to rig [km/h], of the part that was compared",
    "causes.track_kmh": "on track, all effects off [km/h]",
    "causes.rig_kmh": "on the rig, all effects on [km/h]",
    "causes.gain_switched_off_kmh": "per effect: rig without it, less rig [km/h]",
    "causes.loss_alone_kmh": "per effect: track less track with it alone [km/h]",
    "causes.interaction_switched_off_kmh": "loss less the sum of the gains [km/h]",
    "causes.interaction_alone_kmh": "loss less the sum of the single losses [km/h]",
    "interrupted": "whether Ctrl-C ended the study early; parts that are missing were not computed",
    "rollerrig_version": "version of this program",
}
"""Key of summary.json -> meaning and unit; `*` stands for a support."""


def write_comparison(results: CompareResults, out: str | Path) -> list[Path]:
    """Write everything; the report comes last.

    Raises:
        OutputError: a file could not be written.
    """
    folder = output_folder(out)
    written = _write_data(results, folder)
    pictures: dict[str, bytes] = {}
    drawings = output_folder(folder / "figures")
    for name, figure in compare_figures(results).items():
        pictures[name] = figure_bytes(figure)
        written.append(write_bytes(drawings / f"{name}.svg", pictures[name]))
        written.append(write_bytes(drawings / f"{name}.png", figure_bytes(figure, "png", dpi=200)))
    written.append(write_text(folder / "summary.json", json.dumps(summary(results), indent=2) + "\n"))
    return [*written, write_text(folder / "report.html", render(compare_page(results, pictures)))]


def _write_data(results: CompareResults, folder: Path) -> list[Path]:
    written = []
    tables = {
        "modes.csv": {label: mode_rows(modes) for label, modes in results.modes.items()},
        "runs.csv": {label: run_rows(found) for label, found in results.runs.items()},
        "wheels.csv": {label: _wheel_rows(results, label) for label in results.states},
    }
    for file, by_label in tables.items():
        if by_label:
            header = next(iter(by_label.values()))[0]
            rows = [[label, *row] for label, table in by_label.items() for row in table[1:]]
            written.append(write_rows(folder / file, [["on", *header], *rows]))
    if results.table is not None and results.table.found:
        written.append(write_rows(folder / "critical_speeds.csv", _critical_rows(results)))
    if results.causes is not None and results.causes.found:
        written.append(write_rows(folder / "causes.csv", _cause_rows(results)))
    for label, run in results.disturbed.items():
        written.append(save_run(run, folder / f"disturbed_{label}.nc"))
    return written


def _wheel_rows(results: CompareResults, label: str) -> list[list[object]]:
    header: list[object] = ["wheel", *WHEEL_HEADER[2:]]
    wheels = [str(w) for w in results.states[label].wheels["wheel"].to_numpy()]
    return [header, *([wheel, *wheel_numbers(results, label, wheel)] for wheel in wheels)]


def _critical_rows(results: CompareResults) -> list[list[object]]:
    rows: list[list[object]] = [
        ["part", "roller_radius_m", "linear_critical_speed_kmh", "frequency_hz", "mode", "note"]
    ]
    assert results.table is not None
    for (part, radius), scan in results.table.found.items():
        found = scan.onset
        note = scan.problem or ", ".join(f"{name} grows at the lowest speed" for name in scan.grows_at_start)
        numbers = (scan.speed_kmh, found.frequency, found.name) if found else (float("nan"), float("nan"), "")
        rows.append([part, "track" if radius == TRACK else radius, *numbers, note])
    return rows


def _cause_rows(results: CompareResults) -> list[list[object]]:
    assert results.causes is not None
    rows: list[list[object]] = [[*EFFECTS, "linear_critical_speed_kmh"]]
    for on in results.causes.found:
        rows.append([*(int(effect in on) for effect in EFFECTS), results.causes.kmh(on)])
    return rows


def summary(results: CompareResults) -> dict[str, object]:
    """The numbers of the report under the keys of COMPARE_KEYS, and the keys themselves."""
    first = next(iter(results.plan.cases.values()))
    return {
        "vehicle": first.vehicle.data.name,
        "cut": first.vehicle.cut,
        "supports": {label: _support(results, label) for label in results.plan.cases},
        "disturbed_kmh": finite(results.disturbed_kmh),
        "critical_speed_over_radius_kmh": critical_summary(results.table),
        "causes": cause_summary(results.causes),
        "interrupted": results.interrupted,
        "rollerrig_version": __version__,
        "keys": COMPARE_KEYS,
    }


def _support(results: CompareResults, label: str) -> dict[str, Any]:
    support = results.plan.cases[label].support.data
    numbers: dict[str, Any] = {"support": support.name, "roller_radius_m": getattr(support, "roller_radius", None)}
    if label in results.critical:
        critical = results.critical[label].onset
        numbers["linear_critical_speed_kmh"] = finite(results.linear_kmh(label))
        numbers["linear_critical_frequency_hz"] = finite(critical.frequency) if critical else None
        numbers["linear_critical_mode"] = critical.name if critical else ""
    if label in results.runs:
        numbers["by_disturbance"] = disturbance_summary(results.runs[label])
    if label in results.states:
        load = results.states[label].wheels["vertical_force"]
        numbers["static_wheel_load_kn"] = {str(w): 1e-3 * float(load.sel(wheel=w)) for w in load["wheel"].to_numpy()}
    if label in results.conicity and float(results.conicity[label]["amplitude"][-1]) >= 3e-3:
        at = results.conicity[label]["conicity"].sel(amplitude=3e-3, method="nearest")
        numbers["conicity_3mm"] = finite(float(at))
    if label in results.disturbed:
        values = disturbed_numbers(results.disturbed[label])
        numbers["disturbed"] = {name: finite(value) for name, value in zip(DISTURBED, values, strict=True)}
    return numbers


def critical_summary(table: CriticalTable | None) -> dict[str, dict[str, float | None]]:
    """Part -> radius -> critical speed."""
    if table is None:
        return {}
    return {
        part: {
            "track" if radius == TRACK else f"{radius:g}": finite(table.kmh(part, radius))
            for radius in table.radii
            if (part, radius) in table.found
        }
        for part in table.parts
    }


def cause_summary(causes: Causes | None) -> dict[str, object] | None:
    """The split in numbers."""
    if causes is None or not causes.found:
        return None
    off = {effect: causes.when_switched_off(effect) for effect in EFFECTS}
    alone = {effect: causes.alone(effect) for effect in EFFECTS}
    return {
        "track_kmh": finite(causes.track),
        "rig_kmh": finite(causes.rig),
        "gain_switched_off_kmh": {effect: finite(value) for effect, value in off.items()},
        "loss_alone_kmh": {effect: finite(value) for effect, value in alone.items()},
        "interaction_switched_off_kmh": finite(causes.remainder(list(off.values()))),
        "interaction_alone_kmh": finite(causes.remainder(list(alone.values()))),
    }
