"""The figures of the paper report.

PaperResults -> [plot] -> name -> picture
"""

from __future__ import annotations

import math

from matplotlib.figure import Figure

from rollerrig.analysis import HuntingRun, hunting_table
from rollerrig.config import Rig
from rollerrig.plot import amplitude_over_speed, hunting_over_time, ramp_over_speed, traction_forces, traction_sliding
from rollerrig.plot.modes import hunting_frequencies
from rollerrig.studies.compare.figures import causes_figure, radius_figure
from rollerrig.studies.paper.compute import PaperResults
from rollerrig.studies.paper.plan import MATERIALS, VEHICLE, rig_case
from rollerrig.studies.paper.text import NAMES

BODY = "front_frame"
WHEELS = {"wheelset_1_right": "front right wheel", "wheelset_2_right": "rear right wheel"}
LABELS = {m: NAMES[m].removeprefix("the ").capitalize() for m in MATERIALS} | {"paper": "Paper's material, G = 10 GPa"}

CAPTIONS = {
    "figure_7a_ramp": "Figure 7a. Lateral displacement of the bogie frame over speed while the rollers are slowly "
    "sped up (dark) from a disturbed start and slowed down again (light). Triangles: sideways perturbations.",
    "figure_7a_time_steel": "Figure 7a, at constant speeds, steel. Lateral displacement of the bogie frame after a "
    "lateral offset of the leading wheelset.",
    "figure_7a_time_paper": "Figure 7a, at constant speeds, paper's material. Lateral displacement of the bogie "
    "frame after a lateral offset of the leading wheelset.",
    "figure_7a_amplitude": "Amplitude that is left at the end of each run at constant speed. Filled: the "
    "oscillation goes on; open: it dies out. Dashed lines: linear critical speeds.",
    "figure_7b_steel": "Figure 7b, steel. Frequency of the lateral oscillation of the (front) bogie frame, whole vehicle on the "
    "rails against bogie on the rig: of the runs from a disturbance, as in the paper (markers: open where it dies out, filled "
    "where it goes on), and of the linear model's hunting mode (lines, cross where its damping vanishes).",
    "figure_7b_paper": "Figure 7b, paper's material, drawn likewise.",
    "radius_steel": "Steel. Linear critical speed over the radius of the rollers; horizontal: on track.",
    "radius_paper": "Paper's material. Linear critical speed over the radius of the rollers; horizontal: on track.",
    "causes": "Steel. What takes the linear critical speed of the bogie from that on track to that on the rig.",
    "figure_8a": "Figure 8a. Absolute sliding of the right wheels on their rollers (longitudinal, mean of the "
    "patches weighted with normal force), torque and speed. Dotted: slope of the creep law at the start × force × "
    "speed.",
    "figure_8b": "Figure 8b. Longitudinal and vertical contact force on the right wheels. Dotted: closed forms from "
    "the balance of wheelset, roller and frame.",
}
"""Name -> what the figure shows."""


def paper_figures(results: PaperResults) -> dict[str, Figure]:
    """All figures for which something was computed, by name."""
    figures: dict[str, Figure] = {}
    if results.ramps:
        critical = {
            LABELS[m]: {"linear": results.linear_kmh(m), "by disturbance": results.by_disturbance_kmh(m)}
            for m in results.ramps
        }
        ramps = {LABELS[m]: ramp for m, ramp in results.ramps.items()}
        figures["figure_7a_ramp"] = ramp_over_speed(ramps, BODY, critical)
    tables = {}
    for material, found in results.runs.items():
        chosen = [(3.6 * run.speed, run.motion) for run in around_onset(found.runs, found.speed)]
        figures[f"figure_7a_time_{material}"] = hunting_over_time(chosen, BODY, LABELS[material])
        tables[material] = hunting_table(found.runs, found.disturbance)
    if tables:
        critical_lines = {f"linear, {m}": results.linear_kmh(m) for m in tables}
        labelled = {LABELS[m]: table for m, table in tables.items()}
        figures["figure_7a_amplitude"] = amplitude_over_speed(labelled, critical_lines)
    for material, modes in results.modes.items():
        runs = {"bogie on the rig": tables[material]} if material in tables else {}
        if material in results.vehicle_runs:
            found = results.vehicle_runs[material]
            runs[VEHICLE] = hunting_table(found.runs, found.disturbance)
        figures[f"figure_7b_{material}"] = hunting_frequencies(modes, runs, LABELS[material])
    for material, zero_crossings in results.tables.items():
        figures[f"radius_{material}"] = radius_figure(zero_crossings, roller_radius())
    if MATERIALS[0] in results.causes:
        figures["causes"] = causes_figure(results.causes[MATERIALS[0]])
    if results.traction_theory is not None:
        figures["figure_8a"] = traction_sliding(results.traction_theory, WHEELS)
        figures["figure_8b"] = traction_forces(results.traction_theory, WHEELS)
    return {name: figures[name] for name in CAPTIONS if name in figures}


def roller_radius() -> float:
    """Radius of the rig's rollers [m]."""
    rig = rig_case(MATERIALS[0]).support.data
    assert isinstance(rig, Rig)
    return rig.roller_radius


def around_onset(runs: list[HuntingRun], onset: float, count: int = 6) -> list[HuntingRun]:
    """Runs on both sides of the onset [m/s] and further away, by speed; spread evenly if there is no onset."""
    if not math.isfinite(onset):
        step = max(1, math.ceil(len(runs) / count))
        return runs[::step]
    below = [run for run in runs if run.speed < onset]
    above = [run for run in runs if run.speed >= onset]
    picked = below[-1:] + above[:1]
    far_below = [run for run in below[:-1] if run.speed < onset - 8 / 3.6]
    far_above = [run for run in above[1:] if run.speed > onset + 8 / 3.6]
    picked += far_below[-1:] + far_above[:1] + far_above[2:3] + far_above[-1:]
    unique = {run.speed: run for run in picked}
    return [unique[speed] for speed in sorted(unique)][:count]
