"""Modes over speed as tables and figures: rows of CSV files, blocks of the report.

Dataset of `stability` -> [mode_tables] -> modes.csv, shapes.csv, tables and mode shapes
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from rollerrig.config import Case, Track
from rollerrig.plot import mode_shape, mode_shapes
from rollerrig.plot.modes import shown_modes
from rollerrig.plot.shapes import shape_speed
from rollerrig.results.termination import in_words
from rollerrig.study.report import Block, Picture, Table, Text

SUSPENSION_WORDS = ("car body", "bogie", "bogies", "front bogie", "rear bogie")
"""How the names of those modes begin whose shapes are drawn together."""

MODE_COLUMNS = ("speed_kmh", "mode", "growth_rate_per_s", "frequency_hz", "damping")


def line_sentences(case: Case) -> list[str]:
    """That the modes of a line of several segments are those of its first one; nothing for a line of one or none."""
    support = case.support.data
    line = support.line if isinstance(support, Track) else None
    if line is None or len(line.segments) < 2:
        return []
    return [
        f"The line of this case has {len(line.segments)} segments. Everything here belongs to the first, "
        f"{in_words(line.segments[0])}, continued without end: for a curve give a track that begins with it."
    ]


def mode_rows(modes: xr.Dataset) -> list[list[object]]:
    """Table of all modes over speed, header first."""
    rows: list[list[object]] = [list(MODE_COLUMNS)]
    speeds, names = modes["speed"].to_numpy(), modes["mode"].to_numpy()
    values = [modes[v].transpose("speed", "mode").to_numpy() for v in ("growth_rate", "frequency", "damping")]
    for at in np.ndindex(values[0].shape):
        rows.append([float(speeds[at[0]]), str(names[at[1]]), *(float(v[at]) for v in values)])
    return rows


def shape_rows(modes: xr.Dataset) -> list[list[object]]:
    """Table of all mode shapes over speed, header first."""
    rows: list[list[object]] = [["speed_kmh", "mode", "body", "direction", "amplitude", "phase_deg", "energy_share"]]
    names = ("shape_amplitude", "shape_phase", "energy_share")
    values = [modes[name].transpose("speed", "mode", "body", "direction").to_numpy() for name in names]
    speeds = modes["speed"].to_numpy()
    labels = [[str(label) for label in modes[d].to_numpy()] for d in ("mode", "body", "direction")]
    for at in np.ndindex(values[0].shape):
        named = [float(speeds[at[0]]), *(label[k] for label, k in zip(labels, at[1:], strict=True))]
        rows.append([*named, *(float(v[at]) for v in values)])
    return rows


def mode_table(modes: xr.Dataset) -> Table:
    """Frequency and damping of the modes shown, at the lowest, a middle and the highest speed."""
    picks = sorted({0, modes.sizes["speed"] // 2, modes.sizes["speed"] - 1})
    rows = []
    for name in shown_modes(modes):
        one = modes.sel(mode=name)
        rows.append(
            [name, *(f"{float(one['frequency'][k]):.2f},  {100 * float(one['damping'][k]):.1f}" for k in picks)]
        )
    header = ["mode", *(f"{modes['speed'][k]:g} km/h: f [Hz], damping [%]" for k in picks)]
    return Table(header, rows, "Frequency and damping; all modes at all speeds are in modes.csv.")


def shape_blocks(modes: xr.Dataset) -> list[Block]:
    """Pictures and tables of the mode shapes."""
    speed, shown = shape_speed(modes), shown_modes(modes)
    blocks: list[Block] = [
        Text(
            f"All at {speed:g} km/h, the speed of the table nearest to the linear critical one, or the highest. Displacements "
            f"are not to scale; outlines are schematic: {_colours(modes)}, dashed in their design position. x points forward, "
            "y to the left."
        )
    ]
    critical = modes.attrs["linear_critical_mode"] or modes.attrs["hunting_mode"]
    if critical and float(modes["frequency"].sel(mode=critical, speed=speed)) > 0.0:
        figure = mode_shape(modes, critical, speed)
        blocks.append(Picture("critical_mode", figure, f"The mode '{critical}', from above and from behind."))
    suspension = [name for name in shown if name.startswith(SUSPENSION_WORDS)]
    if suspension:
        caption = "Modes of the suspension, each in the view that shows most of it."
        blocks.append(Picture("mode_shapes", mode_shapes(modes, suspension, speed), caption))
    scale = (
        "In the tables: displacement amplitudes in m and rad, scaled so that the largest is 1, and phase in degrees. Parts below "
        "0.02 are left out. All modes at all speeds are in shapes.csv."
    )
    ordered = sorted(shown, key=lambda name: not name.startswith("hunting"))
    return [*blocks, Text(scale), *(_shape_table(modes.sel(speed=speed, mode=name)) for name in ordered)]


def _colours(modes: xr.Dataset) -> str:
    """Which outline is what: 'wheelsets red, bogies blue, car body green', of the bodies that there are."""
    count = [str(role) for role in modes["role"].to_numpy()]
    wheelsets, bogies = count.count("wheelsets"), count.count("bogie")
    words = [("wheelset red", "wheelsets red", wheelsets), ("bogie blue", "bogies blue", bogies)]
    words.append(("car body green", "car bodies green", len(count) - wheelsets - bogies))
    return ", ".join(one if number == 1 else many for one, many, number in words if number)


def _shape_table(mode: xr.Dataset) -> Table:
    directions = [str(name) for name in mode["direction"].to_numpy()]
    rows = []
    for body in mode["body"].to_numpy():
        cells = []
        for direction in directions:
            a, p = (
                float(mode[name].sel(body=body, direction=direction)) for name in ("shape_amplitude", "shape_phase")
            )
            cells.append(f"{a:.2f} ∠ {round(p):d}°" if a >= 0.02 else "")
        rows.append([str(body).replace("_", " "), *cells])
    caption = f"{mode['mode'].item()}, {float(mode['frequency']):.2f} Hz at {float(mode['speed']):g} km/h"
    return Table(["body", *directions], rows, caption)
