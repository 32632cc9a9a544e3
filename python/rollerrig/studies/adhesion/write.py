"""What `rollerrig adhesion` leaves.

Comparison -> [write] -> track.nc, rig.nc, summary.json, axles.csv, report.html
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from rollerrig.analysis.tracking import wheel_radius
from rollerrig.plot import adhesion as figures
from rollerrig.plot import figure_bytes
from rollerrig.report import Figure, Page, Preformatted, Section, Table, Text, number, render
from rollerrig.results import save_run, write_text
from rollerrig.studies.adhesion.causes import CAUSE_WORDS, VARIANT_WORDS
from rollerrig.studies.adhesion.compute import KEYS, Comparison, fidelity
from rollerrig.studies.adhesion.verdict import percent, verdict
from rollerrig.studies.output import write_rows

LEFT_OUT = (
    "The virtual train rolls straight ahead on centred wheels, each on one ellipse: no lateral motion, no spin, and loads that "
    "follow its acceleration at once. Rails and rollers are rigid. The slide protection is written after published principles "
    "and is no certified device. Estimator and feedback see speeds that are exact unless [sensors] says otherwise."
)


SLIDING = (
    "Full: the rig with its contact model; dotted: wheels that roll on the rollers without sliding. Below, the wheelsets' own "
    "motion along the track: the bogie swings on its traction rod, which the control law does not know of, and the wheels turn "
    "by it (D10)."
)
CAUSES = (
    "Part of the difference in distance that goes away with each cause, one after the other. Grey: the range in which the same "
    "test ends when it begins up to 40 ms later."
)


def write_adhesion(results: Comparison, folder: Path) -> list[Path]:
    """Write all files.

    Args:
        results: of `compare_adhesion`.
        folder: an existing folder.

    Returns:
        The files, the report last.

    Raises:
        OutputError: a file could not be written.
    """
    numbers = fidelity(results)
    text = json.dumps({**numbers, "keys": KEYS}, indent=2, ensure_ascii=False)
    return [
        save_run(results.track, folder / "track.nc"),
        save_run(results.rig, folder / "rig.nc"),
        write_text(folder / "summary.json", text + "\n"),
        write_rows(folder / "axles.csv", _rows(results)),
        write_text(folder / "report.html", report(results, numbers)),
    ]


def _rows(results: Comparison) -> list[list[object]]:
    """Speeds and forces of each axle, rig beside track, as long as both ran."""
    count = min(results.track.sizes["time"], results.rig.sizes["time"])
    names = ("axle_speed", "cylinder_pressure", "contact_force", "brake_torque", "traction_torque")
    axles = [str(axle) for axle in results.rig["axle"].to_numpy()]
    header: list[object] = ["time_s", "train_speed_track", "train_speed_rig"]
    columns = [results.rig["time"], results.track["train_speed"], results.rig["train_speed"]]
    for name in (*names, "virtual_speed", "real_sliding", "roller_torque"):
        for axle in axles:
            for label, run in (("track", results.track), ("rig", results.rig)):
                if label == "rig" or name in names:
                    header.append(f"{name}_{axle}_{label}")
                    columns.append(run[name].sel(axle=axle))
    values = [column.to_numpy()[:count].tolist() for column in columns]
    return [header, *(list(row) for row in zip(*values, strict=True))]


def lead(results: Comparison) -> str:
    """The verdict, one finding a line."""
    return "\n".join(verdict(fidelity(results)))


def report(results: Comparison, numbers: dict[str, Any]) -> str:
    """One self-contained HTML page."""
    track, rig, radius = results.track, results.rig, wheel_radius(results.rig)
    load = float(rig["vertical_force"].isel(time=0).sum()) / rig.sizes["axle"]
    ideal = results.variants.get("rolling")
    pictures = [
        (figures.speeds(track, rig, radius), "Speeds", "Train and wheels: the rig, the virtual train, the track."),
        (figures.closer(track, rig, radius), "The first slide", "Slip of the wheels, and what is done about it."),
    ]
    if results.case.brake is not None:
        pictures.append(
            (figures.brakes(track, rig), "Brakes", "Cylinder pressure, dump cycles of the dump valves, air taken.")
        )
    if results.case.traction is not None:
        pictures.append(
            (figures.tractions(track, rig), "Traction", "Torque of the motors and part of the demand left.")
        )
    pictures += [
        (
            figures.forces(track, rig, load),
            "Adhesion used",
            "Force of rail or rollers on each axle over its static load.",
        ),
        (
            figures.rollers(rig),
            "Roller drives",
            "Torque of the roller drives, positive where it drives the wheels forward.",
        ),
        (figures.sliding(rig, ideal, radius), "Real sliding, and what it does to the control", SLIDING),
        (
            figures.errors(track, rig, radius),
            "Rig less track",
            "At the same time; valve switchings that fall apart show.",
        ),
    ]
    sections = []
    if numbers["causes"] is not None:
        words = {CAUSE_WORDS[cause]: share for cause, share in numbers["causes"].items()}
        picture = figures.causes(words, numbers["spread"])
        sections.append(
            Section("Why rig and track differ", [Figure(figure_bytes(picture, "png"), CAUSES), _variants(numbers)])
        )
    sections.append(Section("Numbers", [_runs(numbers), _fidelity(numbers)]))
    sections += [Section(title, [Figure(figure_bytes(figure, "png"), caption)]) for figure, title, caption in pictures]
    sections.append(Section("What is left out", [Text(LEFT_OUT)]))
    whole = Preformatted("the whole case", rig.attrs["config_toml"])
    sources = list(json.loads(rig.attrs["sources"]).items())
    sections.append(Section("Case and sources", [Table(("of", "source"), sources), whole]))
    title = f"{results.case.name}: degraded track and the rig that reproduces it"
    return render(Page(title, lead(results), sections, f"rollerrig {rig.attrs['rollerrig_version']}"))


LABELS = {
    "stopped": "stopped",
    "distance_m": "distance [m]",
    "duration_s": "duration [s]",
    "speed_end_kmh": "speed at the end [km/h]",
    "largest_slip": "largest slip [-]",
    "mean_slip": "mean slip [-]",
    "adhesion_used_mean": "adhesion used, mean [-]",
    "adhesion_used_largest": "adhesion used, largest [-]",
    "dump_cycles": "dump cycles of dump valves, all axles",
    "air_litres": "air taken by the cylinders [l]",
    "energy_relative_residual": "residual of the energy audit [-]",
    "tracking_rms": "wheel less virtual wheel, over train speed, RMS [-]",
    "tracking_largest": "the same, largest [-]",
    "tracking_by_own_motion": "part of its variance that follows the wheelsets' own motion along the track [-]",
    "wheel_speed_rms": "wheel of rig less wheel on track, over train speed, RMS [-]",
    "wheel_speed_largest": "the same, largest [-]",
    "train_speed_largest_mps": "virtual train less train on track, largest [m/s]",
    "distance_relative": "stopping distance of rig over track, less 1 [-]",
    "distance_at_end_relative": "distance at the end of the shorter run, less 1 [-]",
    "slip_difference_rms": "slip of rig less slip on track, RMS [-]",
    "torque_difference_rms_nm": "torque of brake and motor, rig less track, RMS [N m]",
    "real_sliding_largest_mps": "sliding of a wheel on its roller, largest [m/s]",
    "real_sliding_rms_mps": "the same, RMS [m/s]",
    "roller_torque_largest_nm": "torque of a roller drive, largest [N m]",
    "drive_limited_s": "time with a drive's command at its limit [s]",
}


def _runs(numbers: dict[str, Any]) -> Table:
    keys = [key for key in numbers["track"] if key in LABELS]
    rows = [[LABELS[key], _cell(numbers["track"][key]), _cell(numbers["rig"][key])] for key in keys]
    return Table(("", "track", "rig"), rows, "both runs")


def _fidelity(numbers: dict[str, Any]) -> Table:
    extra = {key: value for key, value in numbers["rig"].items() if key not in numbers["track"]}
    rows = [[LABELS[key], _cell(value)] for key, value in {**numbers["fidelity"], **extra}.items()]
    return Table(("", "value"), rows, "how faithful the rig is")


def _variants(numbers: dict[str, Any]) -> Table:
    at_rig = {
        "tracking_rms": numbers["fidelity"]["tracking_rms"],
        "distance_relative": numbers["fidelity"]["distance_at_end_relative"]
        if numbers["fidelity"]["distance_relative"] is None
        else numbers["fidelity"]["distance_relative"],
        "dump_cycles": numbers["rig"]["dump_cycles"],
        "mean_slip": numbers["rig"]["mean_slip"],
    }
    of_track = {
        "tracking_rms": None,
        "distance_relative": 0.0,
        **{k: numbers["track"][k] for k in ("dump_cycles", "mean_slip")},
    }
    runs = {VARIANT_WORDS["rig"]: at_rig, **{VARIANT_WORDS[name]: entry for name, entry in numbers["variants"].items()}}
    rows = [
        [
            name,
            percent(entry["distance_relative"], True),
            percent(entry["tracking_rms"]),
            percent(entry["mean_slip"]),
            _cell(entry["dump_cycles"]),
        ]
        for name, entry in {**runs, "the track": of_track}.items()
    ]
    header = ("run", "distance, against track", "tracking error, RMS", "mean slip", "dump cycles")
    return Table(header, rows, "each of the first lines takes one more imperfection away")


def _cell(value: object) -> object:
    if value is None:
        return "–"
    return ("yes" if value else "no") if isinstance(value, bool) else number(value)
