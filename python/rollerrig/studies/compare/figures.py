"""The figures of the comparison.

CompareResults -> [plot] -> name -> picture
"""

from __future__ import annotations

from matplotlib.figure import Figure

from rollerrig.analysis import hunting_table
from rollerrig.config import Rig
from rollerrig.plot import amplitude_over_speed
from rollerrig.plot.characteristics import characteristics_figure
from rollerrig.plot.compare import causes_bars, critical_over_radius, disturbed_over_time, modes_side_by_side
from rollerrig.plot.modes import hunting_frequencies
from rollerrig.studies.compare.compute import CompareResults
from rollerrig.studies.compare.critical import EFFECTS, TRACK, Causes, CriticalTable, words

CAPTIONS = {
    "modes": "Frequency and damping of the modes over speed: one colour per mode, one line style per support. Drawn are hunting "
    "and the modes that differ most; all are in modes.csv.",
    "hunting": "Frequency of hunting: linear mode (lines, cross where its damping vanishes) and limit cycles of the runs from a "
    "disturbance (markers).",
    "amplitude": "Lateral amplitude at the end of each run from a disturbance: filled where it goes on, open where it dies out. "
    "Dashed: linear critical speeds.",
    "radius": "Linear critical speed over the radius of the rollers; horizontal: on track.",
    "causes": "What takes the critical speed from that on track to that on the rig.",
    "disturbed": "The leading wheelset after a lateral offset. Y is low-pass filtered at 20 Hz, ΣY averaged over 2 m of way "
    "besides (EN 14363); motion and longitudinal force are as computed.",
    "characteristics": "Contact characteristics of the leading wheelset without load. Without yaw the wheels touch rail and "
    "roller in the same points; what differs is the rolling.",
}
"""Name -> what the figure shows."""


def compare_figures(results: CompareResults) -> dict[str, Figure]:
    """All figures for which something was computed, by name."""
    figures: dict[str, Figure] = {}
    tables = {label: hunting_table(found.runs, found.disturbance) for label, found in results.runs.items()}
    if results.modes:
        figures["modes"] = modes_side_by_side(results.modes)
        persists = any(bool((table["persists"] == 1).any()) for table in tables.values())
        if persists or any(modes.attrs["hunting_mode"] for modes in results.modes.values()):
            figures["hunting"] = hunting_frequencies(results.modes, tables)
    if tables:
        top = results.plan.speeds_kmh[-1] * 1.1
        critical = {f"linear, {n}": v for n in results.critical if (v := results.linear_kmh(n)) < top}
        figures["amplitude"] = amplitude_over_speed(tables, critical)
    rig = results.plan.rig.support.data
    if results.table is not None and results.table.found:
        figures["radius"] = radius_figure(results.table, rig.roller_radius if isinstance(rig, Rig) else float("nan"))
    if results.causes is not None and results.causes.found:
        figures["causes"] = causes_figure(results.causes)
    if results.disturbed:
        figures["disturbed"] = disturbed_over_time(results.disturbed)
    if results.shifts:
        figures["characteristics"] = characteristics_figure(results.shifts, results.conicity)
    return {name: figures[name] for name in CAPTIONS if name in figures}


def radius_figure(table: CriticalTable, marked: float) -> Figure:
    """Critical speed of every part that has one over the rollers' radius."""
    radii = [radius for radius in table.radii if radius != TRACK]
    curves = {
        words(part): (radii, [table.kmh(part, radius) for radius in radii], table.kmh(part, TRACK))
        for part in table.parts
    }
    return critical_over_radius({label: c for label, c in curves.items() if any(v == v for v in c[1])}, marked)


def causes_figure(causes: Causes) -> Figure:
    """The split of the loss as bars."""
    off = {EFFECTS[effect]: causes.when_switched_off(effect) for effect in EFFECTS}
    alone = {EFFECTS[effect]: causes.alone(effect) for effect in EFFECTS}
    return causes_bars(off, alone, causes.loss)
