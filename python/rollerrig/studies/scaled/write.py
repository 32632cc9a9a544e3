"""What `rollerrig scale --run` leaves.

ScaledComparison -> [write] -> full.nc, model.nc (mapped back), summary.json, axles.csv, report.html
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure as Drawing

from rollerrig.plot import figure_bytes
from rollerrig.plot import scaled as figures
from rollerrig.report import Figure, Page, Preformatted, Section, Table, Text, number, render
from rollerrig.results import save_run, write_text
from rollerrig.similitude import FACTORS, STRATEGIES, factors_of
from rollerrig.studies.output import write_rows
from rollerrig.studies.scaled.compute import (
    CAUSE_WORDS,
    KEYS,
    ScaledComparison,
    at_times_of,
    axle_torque,
    numbers,
    of_run,
    wheel_radius,
)
from rollerrig.studies.scaled.words import HEADER, lead, percent, rows

LEFT_OUT = (
    "The suspension of the model is built to scale: elements, bearings and play of a real model have friction and tolerances of "
    "their own. Where the weight is to be right although gravity is not scaled, a model needs vertical forces beside its own "
    "weight; leave `gravity` out of --keep for such a one. What is computed beside the model, virtual train and rail, pneumatic "
    "brake, slide protection, runs at the model's time."
)


def write_scaled(results: ScaledComparison, folder: Path) -> list[Path]:
    """Write all files.

    Args:
        results: of `compare_scaled`.
        folder: an existing folder.

    Returns:
        The files, the report last.

    Raises:
        OutputError: a file could not be written.
    """
    found = numbers(results)
    text = json.dumps({**found, "keys": KEYS}, indent=2, ensure_ascii=False)
    files = [
        save_run(results.run, folder / "full.nc"),
        save_run(results.mapped, folder / "model.nc"),
        write_text(folder / "summary.json", text + "\n"),
    ]
    if "train_speed" in results.run:
        files.append(write_rows(folder / "axles.csv", _rows(results)))
    files.append(write_text(folder / "report.html", report(results, found)))
    return files


def _rows(results: ScaledComparison) -> list[list[object]]:
    """Speeds at full scale, the model's at the same times."""
    other = at_times_of(results.run, results.mapped)
    run = results.run.isel(time=slice(0, other.sizes["time"]))
    header: list[object] = ["time_s", "train_speed_full_mps", "train_speed_model_mps"]
    columns = [run["time"], run["train_speed"], other["train_speed"]]
    for axle in run["axle"].to_numpy():
        for label, one in (("full", run), ("model", other)):
            header.append(f"axle_speed_{axle}_{label}_rad_per_s")
            columns.append(one["axle_speed"].sel(axle=axle))
    values = [column.to_numpy().tolist() for column in columns]
    return [header, *(list(row) for row in zip(*values, strict=True))]


def verdict(results: ScaledComparison) -> str:
    """The model, what it violates, and how far its results are from full scale."""
    found = numbers(results)
    near = found["fidelity"]
    lines = [lead(results.model, results.violations)]
    if near.get("wheel_speed_rms") is not None:
        lines.append(
            f"Mapped back, wheel speeds differ from full scale by {_percent(near['wheel_speed_rms'])} RMS of the highest "
            f"train speed, {_percent(near['wheel_speed_largest'])} at most; distance by "
            f"{_percent(near['distance_relative'], True)}."
        )
        ideal = found["causes"].get("ideal", {}).get("wheel_speed_rms")
        if ideal is not None and ideal > 1e-6:
            lines.append(
                f"The ideal model differs by {_percent(ideal)} RMS: round-off decides single switchings of the valves, and so "
                "much of the difference is no fault of the model."
            )
    elif near["lateral_rms_m"] is not None:
        lines.append(f"Mapped back, the wheelsets lie {1e3 * near['lateral_rms_m']:.3g} mm RMS beside full scale.")
    if near["critical_speed_relative"] is not None:
        lines.append(
            f"Linear critical speed: {found['full']['critical_speed_kmh']:.1f} km/h at full scale, "
            f"{found['model_mapped_back']['critical_speed_kmh']:.1f} km/h by the model "
            f"({_percent(near['critical_speed_relative'], True)})."
        )
    if found["motor_limited_share"]:
        lines.append(
            f"The motors cannot give the torque asked for in {_percent(found['motor_limited_share'])} of the time."
        )
    for label, run in (("full scale", results.run), ("model", results.mapped)):
        if run.attrs["status"] != "ok":
            lines.append(f"{label}: {run.attrs['status_message']}")
    return "\n".join(lines)


def _percent(value: float | None, signed: bool = False) -> str:
    return "–" if value is None else f"{100 * value:{'+' if signed else ''}.3g} %"


def report(results: ScaledComparison, found: dict[str, Any]) -> str:
    """One self-contained HTML page."""
    sections = [
        Section(
            "Similitude", [_factors(results), Table(HEADER, rows(results.violations), "requirements, met or violated")]
        ),
        Section("Contact at rest", [_contact(results)]),
        Section("Numbers", [_numbers(found, _moves_sideways(results))]),
    ]
    sections += [
        Section(title, [Figure(figure_bytes(figure, "png"), caption)]) for figure, title, caption in _pictures(results)
    ]
    if found["causes"]:
        sections.append(Section("What each violation costs", [_causes(found, _moves_sideways(results))]))
    sections.append(Section("What is left out", [Text(LEFT_OUT)]))
    sources = list(json.loads(results.run.attrs["sources"]).items())
    whole = Preformatted("the model's case, at its own scale", results.model.to_toml())
    sections.append(Section("Case and sources", [Table(("of", "source"), sources), whole]))
    title = f"{results.full.name} at full scale, and by a 1:{found['similitude']['length']:g} model"
    return render(Page(title, verdict(results), sections, f"rollerrig {found['rollerrig_version']}"))


def _pictures(results: ScaledComparison) -> list[tuple[Drawing, str, str]]:
    runs = (results.run, results.mapped)
    pictures: list[tuple[Drawing, str, str]] = []
    if "train_speed" in results.run:
        radius = wheel_radius(results.run)
        torque = axle_torque(results.run), axle_torque(results.mapped)
        others = {
            "the model as it is": results.mapped,
            **{CAUSE_WORDS[name]: run for name, run in results.causes.items()},
        }
        aligned = {words: at_times_of(results.run, run) for words, run in others.items()}
        pictures += [
            (figures.speeds(runs, radius), "Speeds", "Train and wheels; the train is the virtual one on either rig."),
            (
                figures.torques(runs, torque),
                "Torque and contact",
                "Both at full scale: what the model measures, mapped back.",
            ),
            (
                figures.differences(results.run, aligned, radius),
                "Model less full scale",
                "At the same time; full the model as it is, broken one violation alone.",
            ),
        ]
    if _moves_sideways(results):
        pictures.append((figures.lateral(runs), "Lateral motion", "Wheelsets, positive to the left."))
    return pictures


def _moves_sideways(results: ScaledComparison) -> bool:
    """By more than a micrometre: anything less is round-off."""
    return any(float(of_run(run)["lateral_largest_m"]) > 1e-6 for run in (results.run, results.mapped))


def _factors(results: ScaledComparison) -> Table:
    factors, record = factors_of(results.model), results.model.similitude
    assert record is not None
    table = [[name, number(factors.factor(unit)), unit] for name, unit in FACTORS]
    return Table(("quantity", "full scale over model", "unit"), table, STRATEGIES[record.strategy].title)


def _contact(results: ScaledComparison) -> Table:
    there, own = results.contact
    factors = factors_of(results.model)
    lines = (
        ("wheel load [N]", there.wheel_load, own.wheel_load, factors.force),
        ("semi-axis of the largest patch [mm]", 1e3 * there.semi_axis, 1e3 * own.semi_axis, factors.length),
        ("largest pressure [MPa]", 1e-6 * there.pressure, 1e-6 * own.pressure, factors.pressure),
        ("semi-axis over the roller's radius [%]", 100 * there.roller_share, 100 * own.roller_share, 1.0),
    )
    table = [[name, number(a), number(b), number(b * f), percent(b * f / a - 1.0)] for name, a, b, f in lines]
    header = ("first wheel, steady running", "full scale", "model", "model, mapped back", "off by")
    return Table(header, table, "where several patches share a load, sizes follow it less closely than one patch would")


def _numbers(found: dict[str, Any], sideways: bool) -> Table:
    keys = [
        key for key in found["full"] if not key.startswith("status") and (sideways or not key.startswith("lateral"))
    ]
    table = [[key.replace("_", " "), _cell(found["full"][key]), _cell(found["model_mapped_back"][key])] for key in keys]
    table += [
        [key.replace("_", " "), "", _cell(value)]
        for key, value in found["fidelity"].items()
        if sideways or not key.startswith("lateral")
    ]
    table.append(["motor limited share", "", _cell(found["motor_limited_share"])])
    return Table(("", "full scale", "model, mapped back"), table, "meanings and units in summary.json")


def _causes(found: dict[str, Any], sideways: bool) -> Table:
    keys = [key for key in found["fidelity"] if sideways or not key.startswith("lateral")]
    entries = {"model": found["fidelity"], **found["causes"]}
    table = [[CAUSE_WORDS[name], *(_cell(entry[key]) for key in keys)] for name, entry in entries.items()]
    return Table(
        ("model", *(key.replace("_", " ") for key in keys)), table, "against full scale; units in summary.json"
    )


def _cell(value: object) -> object:
    if value is None:
        return "–"
    return ("yes" if value else "no") if isinstance(value, bool) else number(value)
