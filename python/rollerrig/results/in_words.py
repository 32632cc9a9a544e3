"""`rr.summary`: results in a few lines of words, as Python and notebooks print them.

    Dataset of a run, or of an analysis -> [summary] -> Summary: (what, words) -> text, HTML

Of a run: what ran, how long, how it ended, its energy residual. Of anything else: what it is over, and what it holds.
"""

from pathlib import Path

import numpy as np
import xarray as xr

from rollerrig.common.formatting import Summary, number, quantity
from rollerrig.results.files import load_run
from rollerrig.results.run_info import ATTRIBUTE, RunInfo

_NOT_SHOWN = {"title", "case", "config_toml", "warnings", "rollerrig_version", ATTRIBUTE}
_LONGEST = 60
"""Longest text of an attribute that is shown [letters]."""
_NAMED = 8
"""Variables, of results that are no run."""
_UNITS = {"kmh": "km/h", "hz": "Hz", "s": "s", "m": "m", "n": "N", "rad": "rad", "nm": "N m"}
"""In which the names of attributes end."""


def summary(results: xr.Dataset | str | Path) -> Summary:
    """Results in a few lines: of a run what it was, how long, how it ended, its energy residual and its warnings.

    Args:
        results: of `simulate`, `stability`, `envelope`, `sweep` or another function, or a file of them.

    Raises:
        FileNotFoundError: no such file.
        ResultsError: a file is damaged or of another version.

    Example:
        >>> import rollerrig as rr
        >>> case = rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.1 s"})
        >>> print(rr.summary(rr.simulate(case)).rows[1])
        ('time', '0.1 s, 51 samples, one every 2 ms')
    """
    found = results if isinstance(results, xr.Dataset) else load_run(results)
    case, title = str(found.attrs.get("case", "")), str(found.attrs.get("title", ""))
    of_run = ATTRIBUTE in found.attrs and "energy_relative_residual" in found.attrs
    headline = f"{'Run of' if of_run else 'Results of'} {case}" if case else "Results"
    rows = _of_run(found) if of_run else _of_others(found)
    return Summary(f"{headline}: {title}" if title else headline, tuple(rows))


def _of_run(run: xr.Dataset) -> list[tuple[str, str]]:
    info, attributes = RunInfo.of(run), run.attrs
    on = "track" if info.roller_radius is None else f"rollers of {1e3 * info.roller_radius:g} mm"
    times, speed = run["time"].to_numpy(), 3.6 * run["speed"].to_numpy() if "speed" in run else np.empty(0)
    part = info.part.replace("_", " ")
    rows = [("what", f"{part} on {on}: moving bodies {len(info.moving)}, wheels {len(info.wheels)}")]
    length = f"{number(attributes['stopped_at_s'])} s, {number(len(times))} samples"
    every = f", one every {number(1e3 * float(np.median(np.diff(times))))} ms" if len(times) > 1 else ""
    rows.append(("time", length + every))
    if len(speed):
        ends = [number(float(value)) for value in (speed[0], speed[-1])]
        rows.append(("speed", f"{ends[0]} km/h" if ends[0] == ends[1] else f"{ends[0]} to {ends[1]} km/h"))
    rows.append(("ended", f"{attributes['status']}: {attributes['status_message']}"))
    residual, turned = attributes["energy_relative_residual"], quantity(attributes["energy_turned_over_j"], "J")
    rows.append(("energy", f"balance closed to {number(residual, 2)} of the {turned} turned over"))
    return [*rows, *(("warning", line) for line in str(attributes["warnings"]).splitlines())]


def _of_others(found: xr.Dataset) -> list[tuple[str, str]]:
    rows = [("over", f"{name}: {_span(found, str(name))}") for name in found.sizes if str(name) in found.coords]
    names = [f"{name}{_unit(values)}" for name, values in found.data_vars.items()]
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED + 1 else ""
    rows.append(("holds", ", ".join(names[: _NAMED if more else None]) + more))
    for name, value in found.attrs.items():
        if name in _NOT_SHOWN or isinstance(value, np.ndarray | list):
            continue
        text = number(float(value)) if isinstance(value, float | np.floating) else str(value)
        if 0 < len(text) <= _LONGEST and "\n" not in text and not text.startswith(("{", "[")):
            words, _, last = str(name).rpartition("_")
            unit = _UNITS.get(last, "") if words else ""
            rows.append(((words if unit else str(name)).replace("_", " "), f"{text} {unit}".rstrip()))
    return rows


def _span(found: xr.Dataset, name: str) -> str:
    """How many there are of a coordinate, from where to where."""
    values = found[name].to_numpy()
    if not len(values):
        return "none"
    ends = values[[0, -1]]
    first, last = (number(float(end)) if np.issubdtype(values.dtype, np.number) else str(end) for end in ends)
    if len(values) == 1:
        return f"{first}{_unit(found[name])}"
    return f"{len(values)} from {first} to {last}{_unit(found[name])}"


def _unit(values: xr.DataArray) -> str:
    unit = str(values.attrs.get("units", ""))
    return f" [{unit}]" if unit not in ("", "1") else ""
