"""The files of the paper report.

PaperResults -> [write] -> report.html, figures (SVG and PNG), NetCDF, CSV, summary.json
"""

from __future__ import annotations

import json
from pathlib import Path

from rollerrig import __version__
from rollerrig.analysis import CriticalSpeedByDisturbance, hunting_table
from rollerrig.plot import figure_bytes
from rollerrig.report import Check, render
from rollerrig.results import output_folder, save_run, write_text
from rollerrig.results.files import write_bytes
from rollerrig.studies.compare.write import cause_summary, critical_summary
from rollerrig.studies.output import finite, write_rows
from rollerrig.studies.paper.checks import hunting_checks, traction_checks
from rollerrig.studies.paper.compute import PaperResults
from rollerrig.studies.paper.figures import paper_figures
from rollerrig.studies.paper.page import paper_page
from rollerrig.studies.paper.text import onset_wavelength
from rollerrig.studies.stability import disturbance_summary

PAPER_KEYS = {
    "interrupted": "whether Ctrl-C ended the study early; parts that are missing were not computed",
    "materials": "per material, 'steel' and 'paper' (G = 10 GPa), the numbers below",
    "materials.*.linear": "per variant (bogie on the rig, bogie on track, vehicle on track), the two numbers below",
    "materials.*.linear.*.critical_speed_kmh": "speed at which the least damped oscillation loses its damping "
    "[km/h]; null: none",
    "materials.*.linear.*.frequency_hz": "its frequency [Hz]",
    "materials.*.merging_criterion": "linear critical speed of the bogie on the rig [km/h] per value of "
    "contact.merging_criterion",
    "materials.*.contact": "steady rolling on the rig: patches per wheel, deepest approach [µm], sum of f11 of a "
    "wheel [N], wavelength of slow hunting [m]",
    "materials.*.onset_wavelength_m": "wavelength of the limit cycle at the lowest speed at which it was found [m]",
    "materials.*.by_disturbance": "runs from a lateral offset of the leading wheelset at constant speed: its size [mm], "
    "highest speed below the onset at which it dies out and lowest at which it goes on [km/h], and each run",
    "materials.*.vehicle_on_track": "the same runs of the whole vehicle on track",
    "materials.*.critical_speed_over_radius_kmh": "per part of the vehicle and roller radius [m] ('track': none) the "
    "linear critical speed [km/h]; null: none in the range",
    "materials.*.causes": "split of the bogie's linear critical speed from track to rig [km/h]: both ends, per effect the gain "
    "when it is switched off alone and the loss when it is on alone, and what the sums leave of the whole loss",
    "traction": "figure 8 at the last output time: speed [km/h], per right wheel sliding [mm/s] and forces [N]",
    "checks": "each check: value, expected, deviation, tolerance (relative or in the unit), whether it passed, and "
    "why this tolerance",
    "checks_passed": "number of checks that passed",
    "checks_failed": "number of checks that failed",
    "rollerrig_version": "version of this program",
}
"""Key of summary.json -> meaning and unit; `*` stands for a material or variant."""


def write_paper(results: PaperResults, out: str | Path) -> list[Path]:
    """Write everything; the report comes last.

    Raises:
        OutputError: a file could not be written.
    """
    folder = output_folder(out)
    checks = [*traction_checks(results), *hunting_checks(results)]
    written = _write_data(results, output_folder(folder / "data"))
    drawings = output_folder(folder / "figures")
    pictures: dict[str, bytes] = {}
    for name, figure in paper_figures(results).items():
        pictures[name] = figure_bytes(figure, "svg", dpi=200)
        written.append(write_bytes(drawings / f"{name}.svg", pictures[name]))
        written.append(write_bytes(drawings / f"{name}.png", figure_bytes(figure, "png", dpi=200)))
    written.append(write_text(folder / "summary.json", json.dumps(summary(results, checks), indent=2) + "\n"))
    return [*written, write_text(folder / "report.html", render(paper_page(results, pictures, checks)))]


def _write_data(results: PaperResults, folder: Path) -> list[Path]:
    written = []
    for material, variants in results.modes.items():
        for variant, modes in variants.items():
            written.append(save_run(modes, folder / f"modes_{material}_{variant.replace(' ', '_')}.nc"))
    for material, ramp in results.ramps.items():
        written.append(save_run(ramp, folder / f"ramp_{material}.nc"))
    for material, found in results.runs.items():
        for run in found.runs:
            written.append(save_run(run.motion, folder / f"run_{material}_{3.6 * run.speed:.2f}_kmh.nc"))
        written.append(write_rows(folder / f"figure_7_runs_{material}.csv", _run_rows(found)))
    for material, found in results.vehicle_runs.items():
        written.append(write_rows(folder / f"figure_7b_vehicle_runs_{material}.csv", _run_rows(found)))
    if results.modes:
        written.append(write_rows(folder / "figure_7b_linear.csv", _frequency_rows(results)))
    if results.traction is not None:
        written.append(save_run(results.traction, folder / "traction.nc"))
    if results.traction_theory is not None:
        written.append(write_rows(folder / "figure_8.csv", _traction_rows(results)))
    return written


def _run_rows(found: CriticalSpeedByDisturbance) -> list[list[object]]:
    table = hunting_table(found.runs, found.disturbance)
    names = ("speed", "amplitude", "oscillation_frequency", "decay_frequency", "rate_at_end", "persists")
    header: list[object] = [
        "speed_kmh",
        "amplitude_m",
        "frequency_hz",
        "decay_frequency_hz",
        "rate_at_end_per_s",
        "persists",
    ]
    columns = (table[name].to_numpy().tolist() for name in names)
    return [header, *(list(row) for row in zip(*columns, strict=True))]


def _frequency_rows(results: PaperResults) -> list[list[object]]:
    rows: list[list[object]] = [["material", "variant", "speed_kmh", "hunting_frequency_hz", "hunting_damping"]]
    for material, variants in results.modes.items():
        for variant, modes in variants.items():
            hunting = modes.sel(mode=modes.attrs["hunting_mode"])
            for k, speed in enumerate(modes["speed"].to_numpy().tolist()):
                rows.append([material, variant, speed, float(hunting["frequency"][k]), float(hunting["damping"][k])])
    return rows


_TRACTION_COLUMNS = {
    "sliding": "sliding_mps",
    "sliding_theory": "sliding_theory_mps",
    "longitudinal_force": "longitudinal_force_n",
    "longitudinal_force_theory": "longitudinal_force_theory_n",
    "vertical_force": "vertical_force_n",
    "vertical_force_theory": "vertical_force_theory_n",
}


def _traction_rows(results: PaperResults) -> list[list[object]]:
    study = results.traction_theory
    assert study is not None
    wheels = [str(w) for w in study["wheel"].to_numpy()]
    header: list[object] = ["time_s", "speed_mps", "torque_nm"]
    columns = [study[name].to_numpy() for name in ("time", "speed", "torque")]
    for wheel in wheels:
        for name, column in _TRACTION_COLUMNS.items():
            header.append(f"{wheel}.{column}")
            columns.append(study[name].sel(wheel=wheel).to_numpy())
    return [header, *(list(row) for row in zip(*(c.tolist() for c in columns), strict=True))]


def summary(results: PaperResults, checks: list[Check]) -> dict[str, object]:
    """The numbers of the report under the keys of PAPER_KEYS, and the keys themselves."""
    return {
        "interrupted": results.interrupted,
        "materials": {material: _material(results, material) for material in results.modes},
        "traction": _traction(results),
        "checks": [check.as_dict() for check in checks],
        "checks_passed": sum(check.passed for check in checks),
        "checks_failed": sum(not check.passed for check in checks),
        "rollerrig_version": __version__,
        "keys": PAPER_KEYS,
    }


def _material(results: PaperResults, material: str) -> dict[str, object]:
    linear = {
        variant: {
            "critical_speed_kmh": finite(results.linear_kmh(material, variant)),
            "frequency_hz": finite(float(modes.attrs["linear_critical_frequency_hz"])),
        }
        for variant, modes in results.modes[material].items()
    }
    numbers: dict[str, object] = {
        "linear": linear,
        "merging_criterion": {f"{b:g}": finite(3.6 * v) for b, v in results.barriers.get(material, {}).items()},
        "onset_wavelength_m": finite(onset_wavelength(results, material)),
    }
    if material in results.contact:
        contact = results.contact[material]
        numbers["contact"] = {
            "patches": contact.patches,
            "approach_um": 1e6 * contact.approach,
            "creep_stiffness_n": contact.creep_stiffness,
            "wavelength_m": finite(contact.wavelength),
        }
    if material in results.runs:
        numbers["by_disturbance"] = disturbance_summary(results.runs[material])
    if material in results.vehicle_runs:
        numbers["vehicle_on_track"] = disturbance_summary(results.vehicle_runs[material])
    if material in results.tables:
        numbers["critical_speed_over_radius_kmh"] = critical_summary(results.tables[material])
    if material in results.causes:
        numbers["causes"] = cause_summary(results.causes[material])
    return numbers


def _traction(results: PaperResults) -> dict[str, object] | None:
    if results.traction_theory is None:
        return None
    end = results.traction_theory.isel(time=-1)
    wheels = [str(w) for w in end["wheel"].to_numpy() if str(w).endswith("right")]
    numbers: dict[str, object] = {"speed_kmh": 3.6 * float(end["speed"])}
    for wheel in wheels:
        own = end.sel(wheel=wheel)
        numbers[wheel] = {
            "sliding_mmps": 1e3 * float(own["sliding"]),
            "longitudinal_force_n": float(own["longitudinal_force"]),
            "vertical_force_n": float(own["vertical_force"]),
        }
    return numbers
