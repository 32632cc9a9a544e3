"""What `rollerrig adhesion` leaves.

Comparison -> [write] -> track.nc, rig.nc, summary.json, axles.csv, report.html
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from rollerrig.plot import adhesion as figures
from rollerrig.plot import figure_bytes
from rollerrig.report import Figure, Page, Preformatted, Section, Table, Text, number, render
from rollerrig.results import save_run, write_text
from rollerrig.studies.adhesion.compute import KEYS, VARIANT_WORDS, Comparison, fidelity, wheel_radius
from rollerrig.studies.output import write_rows

LEFT_OUT = (
    "The virtual train rolls straight ahead on centred wheels with static axle loads: no load transfer, no lateral motion. "
    "Rigid rollers and rails. The slide protection is written after published principles and is no certified device. "
    "Estimator and feedback see speeds that are exact unless [sensors] says otherwise."
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
    """The verdict in a few lines."""
    numbers = fidelity(results)
    f, rig = numbers["fidelity"], numbers["rig"]
    lines = [
        f"Wheels of the rig follow the virtual train within {_percent(f['tracking_rms'])} RMS of train speed, "
        f"{_percent(f['tracking_largest'])} at most; real sliding of wheel on roller at most "
        f"{1e3 * rig['real_sliding_largest_mps']:.3g} mm/s."
    ]
    if f["distance_relative"] is not None:
        lines.append(
            f"Stopping distance: {numbers['track']['distance_m']:.1f} m on track, {rig['distance_m']:.1f} m on the rig "
            f"({_percent(f['distance_relative'], True)})."
        )
    else:
        lines.append(
            f"At the end of the shorter run the distances differ by {_percent(f['distance_at_end_relative'], True)}."
        )
    for label in ("track", "rig"):
        if numbers[label]["status"] != "ok":
            lines.append(f"{label}: {numbers[label]['status_message']}")
    for key, met in numbers["targets"].items():
        if met is False:
            lines.append(f"Target missed: {key.replace('_', ' ')}.")
    return "\n".join(lines)


def _percent(value: float | None, signed: bool = False) -> str:
    return "–" if value is None else f"{100 * value:{'+' if signed else ''}.3g} %"


def report(results: Comparison, numbers: dict[str, Any]) -> str:
    """One self-contained HTML page."""
    track, rig, radius = results.track, results.rig, wheel_radius(results.rig)
    load = float(rig["vertical_force"].isel(time=0).sum()) / rig.sizes["axle"]
    pictures = [
        (figures.speeds(track, rig, radius), "Speeds", "Train and wheels: the rig, the virtual train, the track.")
    ]
    if results.case.brake is not None:
        pictures.append((figures.brakes(track, rig), "Brakes", "Cylinder pressure and state of the dump valves."))
    if results.case.traction is not None:
        pictures.append(
            (figures.tractions(track, rig), "Traction", "Torque of the motors and part of the demand left.")
        )
    pictures += [
        (figures.forces(track, rig, load), "Contact", "Force of rail or rollers on each axle, and the adhesion used."),
        (figures.rollers(rig, radius), "Rollers", "What the rig's drives do, and how truly."),
        (
            figures.errors(track, rig, radius),
            "Rig less track",
            "At the same time; valve switchings that fall apart show.",
        ),
    ]
    sections = [Section("Numbers", [_runs(numbers), _fidelity(numbers)])]
    sections += [Section(title, [Figure(figure_bytes(figure, "png"), caption)]) for figure, title, caption in pictures]
    if results.variants:
        sections.append(Section("Causes of the tracking error", [_causes(numbers)]))
    sections.append(Section("What is left out", [Text(LEFT_OUT)]))
    whole = Preformatted("the whole case", rig.attrs["config_toml"])
    sources = list(json.loads(rig.attrs["sources"]).items())
    sections.append(Section("Case and sources", [Table(("of", "source"), sources), whole]))
    title = f"{results.case.name}: degraded track and the rig that imitates it"
    return render(Page(title, lead(results), sections, f"rollerrig {rig.attrs['rollerrig_version']}"))


def _runs(numbers: dict[str, Any]) -> Table:
    keys = [key for key in numbers["track"] if not key.startswith("status")]
    rows = [[key.replace("_", " "), _cell(numbers["track"][key]), _cell(numbers["rig"][key])] for key in keys]
    return Table(("", "track", "rig"), rows, "both runs; meanings and units in summary.json")


def _fidelity(numbers: dict[str, Any]) -> Table:
    extra = {key: value for key, value in numbers["rig"].items() if key not in numbers["track"]}
    rows = [[key.replace("_", " "), _cell(value)] for key, value in {**numbers["fidelity"], **extra}.items()]
    return Table(("", "value"), rows, "how faithful the rig is")


def _causes(numbers: dict[str, Any]) -> Table:
    errors = {"rig": numbers["fidelity"]["tracking_rms"]}
    errors.update({name: entry["tracking_rms"] for name, entry in numbers["causes"].items()})
    rows = [[VARIANT_WORDS[name], _percent(error)] for name, error in errors.items()]
    return Table(("run", "tracking error, RMS of train speed"), rows)


def _cell(value: object) -> object:
    if value is None:
        return "–"
    return ("yes" if value else "no") if isinstance(value, bool) else number(value)
