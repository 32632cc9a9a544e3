"""Sphinx extension: the reference of the results, written from a short run and from the key tables of the studies.

core's field tables, key tables -> Dataset of one run -> [this file] -> reference/generated/results.md
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import xarray as xr
from sphinx.application import Sphinx

DIMENSIONS = {
    ("time", "body"): "Per body",
    ("time", "wheel"): "Per wheel",
    ("time", "wheel", "patch"): "Per contact patch",
    ("time", "element"): "Per force element",
    ("time",): "Of the whole run",
    ("reading_time", "wheel"): "Readings per wheel",
    ("reading_time",): "Readings of the whole run",
}

ATTRIBUTES = {
    "title": "description of the case",
    "case": "name of the case",
    "status": "`ok`, `interrupted`, or why the run stopped",
    "status_message": "the same as a sentence, with time, wheel and remedy",
    "stopped_at_s": "time that the integration reached [s]",
    "stopped_wheel": "wheel at which the run stopped; empty if none",
    "stopped_at_m": "distance at the last output time [m]",
    "stopped_segment": "segment of the track there; empty if it has none",
    "stopped_quotient": "largest |Y|/Q of the wheelset that stopped the run in the half second before; NaN if none did",
    "stopped_quotient_wheel": "wheel that had it; empty if none",
    "solver_statistics": "counts of the integrator, JSON",
    "contact_counters": "counts of the contacts, JSON; the table below",
    "run_info": "bodies, wheels, loads, laws and actuators of the case, JSON; `RunInfo.of(run)` reads it",
    "sources": "sources of model and data, JSON",
    "config_toml": "the whole configuration; `rollerrig run` takes it as a file",
    "rollerrig_version": "version of the program",
    "energy_turned_over_j": "half the sum of the total variations of all energy accounts [J]",
    "energy_relative_residual": "largest energy residual over the energy turned over",
    "contact_losses": "wheels that lost contact, with time and place, JSON",
    "warnings": "restrictions of the validity of the run, one line each; empty if none",
}

COUNTERS = {
    "checked": "wheels evaluated: wheels times accepted steps",
    "several_patches": "wheels with more than one patch",
    "refined": "wheels whose strips had not settled and were solved again with more of them, (S5)",
    "overlapping": "neighbouring patches of one wheel whose ellipses overlap",
    "faded": "patches whose blending weight, (F4) or (S8), was below 1",
    "limited_curvature": "patches whose curvatures were outside Hertz' theory and were limited",
    "clamped_aspect": "patches with a/b outside Kalker's table",
    "lost": "wheels without contact",
    "negative_dissipation": "patches whose creep force added energy",
}


def write_reference(app: Sphinx) -> None:
    """Write the tables that reference/results.md includes."""
    target = Path(app.srcdir) / "reference" / "generated" / "results.md"
    text = "\n".join(reference())
    target.parent.mkdir(exist_ok=True)
    if not target.is_file() or target.read_text() != text:  # an unchanged file keeps its date: no rebuild
        target.write_text(text)


def reference() -> list[str]:
    """The whole reference as lines of MyST Markdown."""
    from rollerrig import load_case, simulate
    from rollerrig.contact_analysis.static_contact import _VARIABLES
    from rollerrig.study import studies

    run = simulate(load_case("wheelset_rollers").with_changes({"time.duration": "0.01 s"}))
    return [
        *variables(run),
        *described("Attributes of a run", "attribute", run.attrs, ATTRIBUTES),
        *described("Counters of the contacts", "counter", json.loads(run.attrs["contact_counters"]), COUNTERS),
        *columns({column: meaning for _, column, _, meaning in _VARIABLES.values()}),
        *(
            line
            for study in studies()
            for line in keys(f"rollerrig {study.command}".replace("_", " --"), study.quantities.described())
        ),
    ]


def variables(run: xr.Dataset) -> list[str]:
    """One table per combination of dimensions; every variable once."""
    lines: list[str] = []
    written: set[str] = set()
    for dimensions, title in DIMENSIONS.items():
        rows = [
            (f"`{name}`", unit(str(variable.attrs["units"])), str(variable.attrs["long_name"]))
            for name, variable in run.data_vars.items()
            if variable.dims == dimensions
        ]
        written |= {str(name) for name, variable in run.data_vars.items() if variable.dims == dimensions}
        names = ", ".join(f"`{d}`" for d in dimensions)
        lines += [f"## {title}", "", f"Dimensions: {names}.", "", *table(("variable", "unit", "meaning"), rows)]
    if missing := {str(name) for name in run.data_vars} - written:
        raise RuntimeError(f"variables without a section in the reference: {', '.join(sorted(missing))}")
    return lines


def described(title: str, head: str, found: Mapping[str, object], meanings: Mapping[str, str]) -> list[str]:
    """A table of names whose meanings stand above; a name too many or too few stops the build."""
    if different := set(found) ^ set(meanings):
        raise RuntimeError(f"{title}: described and existing names differ: {', '.join(sorted(different))}")
    rows = [(f"`{name}`", meaning) for name, meaning in meanings.items()]
    return [f"## {title}", "", *table((head, "meaning"), rows)]


def columns(meanings: Mapping[str, str]) -> list[str]:
    """The columns of the table of `rollerrig contact`."""
    rows = [(f"`{name}`", meaning) for name, meaning in meanings.items()]
    return ["## Columns of `rollerrig contact --csv`", "", *table(("column", "meaning"), rows)]


def keys(command: str, meanings: Mapping[str, str]) -> list[str]:
    """The keys of one command's summary.json."""
    rows = [(f"`{name}`", meaning) for name, meaning in meanings.items()]
    return [f"## `summary.json` of `{command}`", "", *table(("key", "meaning"), rows)]


def unit(name: str) -> str:
    """The unit; a dash for a pure number."""
    return "–" if name == "1" else name.replace("^2", "²")


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> list[str]:
    """A Markdown table."""
    lines = [head, ("---",) * len(head), *rows]
    return ["| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines] + [""]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("builder-inited", write_reference)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
