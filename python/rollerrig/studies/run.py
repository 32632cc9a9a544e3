"""What `rollerrig run` leaves: every signal, the numbers, tables, and a report to open.

Dataset of a run -> [run] -> run.nc, summary.json, motion.csv, wheels.csv, readings.csv, report.html
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import xarray as xr

from rollerrig.analysis.assessment import assess, table
from rollerrig.plot import figure_bytes
from rollerrig.plot.run import energy_over_time, motion_over_time, sliding_over_time
from rollerrig.plot.wheel_rail_forces import curved, irregular, line_and_response
from rollerrig.report import Figure, Page, Preformatted, Section, Table, Text, number, render
from rollerrig.results import SUMMARY_KEYS, motion_table, save_run, summarise, wheel_table, write_csv, write_text
from rollerrig.studies.output import write_rows
from rollerrig.studies.wheel_rail_forces import READINGS_KEYS, readings_rows, readings_sections, readings_summary

LEFT_OUT = (
    "Rigid bodies, rails and rollers without flexibility of their own; profiles without irregularities or wear; Hertz "
    "ellipses also where the patch is none; Kalker's linear creep law with saturation, of which the spin moment is not "
    "saturated by default; a constant coefficient of friction."
)

COUNTERS = {
    "checked": "wheels looked at: accepted steps times wheels",
    "several_patches": "wheels that touched in more than one patch",
    "overlapping": "pairs of patches of one wheel whose ellipses overlap, where Hertz' theory would want them far apart",
    "faded": "patches that count in part, while two neighbours merge or part",
    "limited_curvature": "patches whose curvatures were outside Hertz' theory and were limited",
    "clamped_aspect": "patches more slender than Kalker's table; its last value was used",
    "negative_dissipation": "patches in which the creep law fed energy in",
    "lost": "wheels without contact",
}
"""Counter of the contact model -> what it says."""


def write_run(run: xr.Dataset, folder: Path) -> list[Path]:
    """Write all files of a run.

    Args:
        run: results of `simulate`.
        folder: an existing folder.

    Returns:
        The files, the report last.

    Raises:
        OutputError: a file could not be written; those before it are whole.
    """
    assessment = assess(run)
    rows = table(assessment)
    summary = {**summarise(run), **readings_summary(assessment, rows)}
    keys = {**SUMMARY_KEYS, **READINGS_KEYS}
    readings = readings_sections(assessment, rows, along_run(run))
    text = json.dumps({**summary, "keys": keys}, indent=2, ensure_ascii=False)
    return [
        save_run(run, folder / "run.nc"),
        write_text(folder / "summary.json", text + "\n"),
        write_csv(folder / "motion.csv", motion_table(run)),
        write_csv(folder / "wheels.csv", wheel_table(run)),
        write_rows(folder / "readings.csv", readings_rows(rows)),
        write_text(folder / "report.html", run_report(run, summary, readings)),
    ]


def along_run(run: xr.Dataset) -> xr.DataArray:
    """What the readings are drawn over: the distance where curves, cant or irregularities lie along it, else time."""
    if curved(run) or irregular(run):
        return run["distance"].assign_attrs(long_name="distance")
    return run["time"].assign_attrs(long_name="time")


def run_report(run: xr.Dataset, summary: dict[str, Any], readings: list[Section]) -> str:
    """One self-contained HTML page about a run.

    Args:
        run: results of `simulate`.
        summary: what `summarise` returns.
        readings: sections about what engineers read off it.
    """
    drawings = {
        "Motion": (motion_over_time, "Lateral displacement and yaw of the vehicle's bodies, and the running speed."),
        "Sliding": (sliding_over_time, "Longitudinal force and sliding, wheel minus roller; place of contact (EN S)."),
        "Energy": (energy_over_time, "Work put in = change of what is stored + heat + residual."),
    }
    sections = [Section("Numbers", [_bodies(summary), _wheels(summary)]), *readings]
    if run.sizes["time"] > 1:
        if curved(run) or irregular(run):
            caption = "What lies along the track, and how the wheelsets follow it."
            figure = line_and_response(run, along_run(run))
            sections.insert(1, Section("Track", [Figure(figure_bytes(figure, "png"), caption)]))
        for title, (draw, caption) in drawings.items():
            sections.append(Section(title, [Figure(figure_bytes(draw(run), "png"), caption)]))
    sections.append(Section("How it was computed", [_table("integration", summary["solver"]), _contact(summary)]))
    sections.append(Section("What is left out", [Text(LEFT_OUT)]))
    sources = json.loads(run.attrs["sources"])
    whole = Preformatted("the whole case", run.attrs["config_toml"])
    sections.append(Section("Case and sources", [Table(("of", "source"), list(sources.items())), whole]))
    footer = f"rollerrig {run.attrs['rollerrig_version']}"
    return render(Page(f"{run.attrs['case']}: {run.attrs['title']}", _lead(summary), sections, footer))


def _lead(summary: dict[str, Any]) -> str:
    ended = f"{summary['stopped_at_s']:g} s computed. {summary['status_message']}"
    speeds = ""
    if summary["samples"]:
        speeds = f"Speed {summary['speed_start_kmh']:.4g} km/h at the start, {summary['speed_end_kmh']:.4g} km/h at the end. "
    audit = (
        f"Energy balance closed to {number(summary['energy_relative_residual'], 2)} of the "
        f"{number(summary['energy_turned_over_j'] / 1e3)} kJ turned over."
    )
    warning = "".join(f"\nWarning: {line}." for line in summary["warnings"].splitlines())
    return f"{ended}\n{speeds}{audit}{warning}"


def _bodies(summary: dict[str, Any]) -> Table:
    header = (
        "body",
        "largest lateral [mm]",
        "lateral at the end [mm]",
        "largest in the last tenth [mm]",
        "largest yaw [mrad]",
    )
    return _numbers(header, summary["bodies"])


def _wheels(summary: dict[str, Any]) -> Table:
    header = (
        "wheel",
        "Q at start [N]",
        "Q at end [N]",
        "least Q [N]",
        "largest Y [N]",
        "largest Y/Q",
        "largest sliding [m/s]",
        "sliding at end [m/s]",
        "samples in several patches",
    )
    return _numbers(header, summary["wheels"])


def _numbers(header: tuple[str, ...], parts: dict[str, dict[str, float | None]]) -> Table:
    rows = [[name, *("–" if v is None else v for v in numbers.values())] for name, numbers in parts.items()]
    return Table(header, rows)


def _contact(summary: dict[str, Any]) -> Table:
    rows = [(_words(key), value, COUNTERS.get(key, "")) for key, value in summary["contact"].items()]
    return Table(("count", "value", "meaning"), rows, "contacts, counted over accepted steps and wheels")


def _table(caption: str, numbers: dict[str, float | None]) -> Table:
    return Table(
        ("count", "value"), [(_words(key), "–" if value is None else value) for key, value in numbers.items()], caption
    )


def _words(key: str) -> str:
    return key.replace("_", " ") + (" [s]" if key in ("largest_step", "smallest_step") else "")
