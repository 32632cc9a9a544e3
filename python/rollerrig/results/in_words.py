"""`rr.summary`: a run in a few lines of words, as Python and notebooks print them.

Dataset of a run -> [summary] -> Summary: what ran, how long, how it ended, its energy residual -> text, HTML
"""

from pathlib import Path

import numpy as np
import xarray as xr

from rollerrig.common.formatting import Summary, number
from rollerrig.results.files import load_run
from rollerrig.results.run_info import ResultsError, RunInfo


def summary(results: xr.Dataset | str | Path) -> Summary:
    """A run in a few lines: what it was, how long, how it ended, its energy residual and its warnings.

    Args:
        results: of `simulate`, or a file of them. Of other results xarray itself shows what they hold.

    Raises:
        FileNotFoundError: no such file.
        ResultsError: no run; a file is damaged or of another version.

    Example:
        >>> import rollerrig as rr
        >>> case = rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.1 s"})
        >>> print(rr.summary(rr.simulate(case)).rows[1])
        ('time', '0.1 s, 51 samples, one every 2 ms')
    """
    run = results if isinstance(results, xr.Dataset) else load_run(results)
    info, attributes = RunInfo.of(run), run.attrs
    if "energy_relative_residual" not in attributes:
        raise ResultsError("these results are those of no run: print them as they are")
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
    residual, turned = attributes["energy_relative_residual"], number(1e-3 * attributes["energy_turned_over_j"], 3)
    rows.append(("energy", f"balance closed to {number(residual, 2)} of the {turned} kJ turned over"))
    rows += (("warning", line) for line in str(attributes["warnings"]).splitlines())
    return Summary(f"Run of {attributes['case']}: {attributes['title']}", tuple(rows))
