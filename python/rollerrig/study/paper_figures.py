"""The figures of the paper report and their captions.

results of PaperStudy -> [figures] -> matplotlib figures by name
"""

from __future__ import annotations

import math

from matplotlib.figure import Figure

from rollerrig.analysis import HuntingRun, hunting_table
from rollerrig.config import Rig
from rollerrig.plot import amplitude_over_speed, hunting_over_time, ramp_over_speed, traction_forces, traction_sliding
from rollerrig.plot.modes import hunting_frequencies
from rollerrig.study import critical_speeds as speeds
from rollerrig.study.paper_checks import FRONT, REAR
from rollerrig.study.paper_plan import MATERIALS, PAPER_CRITICAL_KMH, RIG, VEHICLE, rig_case
from rollerrig.study.paper_results import Results

BODY = "front_frame"
WHEELS = {FRONT: "front right wheel", REAR: "rear right wheel"}
PAPER = {"the paper": PAPER_CRITICAL_KMH}
"""The one number that the paper states of its figure 7; points of its curves were not available."""
LABELS = {"steel": "Steel", "paper": "Paper's material, G = 10 GPa"}

CAPTIONS = {
    "figure_7a_ramp": "Figure 7a. Lateral displacement of the bogie frame over speed while the rollers are slowly sped up (dark) "
    "from a disturbed start and slowed down again (light). Triangles: lateral perturbations. Of its own curve the paper states "
    "that it grows beyond 100 km/h.",
    "figure_7a_time_steel": "Figure 7a, at constant speeds, steel. Lateral displacement of the bogie frame after a "
    "lateral offset of the leading wheelset.",
    "figure_7a_time_paper": "Figure 7a, at constant speeds, paper's material, drawn likewise.",
    "figure_7a_amplitude": "Amplitude at the end of each run at constant speed. Filled: the oscillation persists; open: it "
    "decays; with the paper's own contact and with the exact one. Dashed lines: linear critical speeds with its own, and the "
    "critical speed that the paper states.",
    "figure_7b_steel": "Figure 7b, steel. Frequency of the lateral oscillation of the (front) bogie frame, whole vehicle on the "
    "rails against bogie on the rig: of the runs from a disturbance, as in the paper (markers: open where it decays, "
    "filled where it persists), and of the linear model's hunting mode (lines, cross where its damping vanishes).",
    "figure_7b_paper": "Figure 7b, paper's material, drawn likewise.",
    "radius_steel": "Steel. Linear critical speed over the radius of the rollers; horizontal: on track.",
    "radius_paper": "Paper's material. Linear critical speed over the radius of the rollers; horizontal: on track.",
    "roller_effects": "Steel. Loss of linear critical speed of the bogie from track to rig.",
    "figure_8a": "Figure 8a. Absolute sliding of the right wheels on their rollers (longitudinal, mean of the patches weighted "
    "with normal force), torque and speed. Dotted: slope of the creep law at the start × force × speed.",
    "figure_8b": "Figure 8b. Longitudinal creep force and vertical contact force on the right wheels. Dotted: closed forms "
    "from the balance of wheelset, roller and frame.",
}
"""Picture -> what it shows."""


def figures(results: Results) -> dict[str, Figure]:
    """All figures for which something was computed, by name."""
    found: dict[str, Figure] = {}
    if results.ramps:
        lines: dict[str, dict[str, float | tuple[float, float]]] = {
            LABELS[m]: {**PAPER, "linear": results.linear_kmh(m), "by disturbance": (by.low, by.high)}
            for m in results.ramps
            for by in [results.by_disturbance(m)]
        }
        found["figure_7a_ramp"] = ramp_over_speed({LABELS[m]: ramp for m, ramp in results.ramps.items()}, BODY, lines)
    by_speed = {m: hunting_table(one.runs, one.disturbance) for m, one in results.runs.items()}
    for material, one in results.runs.items():
        chosen = [(3.6 * run.speed, run.motion) for run in around_onset(one.runs, one.persists)]
        found[f"figure_7a_time_{material}"] = hunting_over_time(chosen, BODY, LABELS[material])
    if by_speed:
        critical = {**PAPER, **{f"linear, {m}": results.linear_kmh(m) for m in by_speed}}
        amplitudes = {LABELS[m]: t for m, t in by_speed.items()}
        for material, one in results.exact.runs.get(RIG, {}).items():
            amplitudes[f"{LABELS[material]}, exact contact"] = hunting_table(one.runs, one.disturbance)
        found["figure_7a_amplitude"] = amplitude_over_speed(amplitudes, critical)
    for material, modes in results.modes.items():
        runs = {RIG: by_speed[material]} if material in by_speed else {}
        if material in results.vehicle_runs:
            vehicle = results.vehicle_runs[material]
            runs[VEHICLE] = hunting_table(vehicle.runs, vehicle.disturbance)
        found[f"figure_7b_{material}"] = hunting_frequencies(modes, runs, LABELS[material])
    rig = rig_case(MATERIALS[0]).support.data
    assert isinstance(rig, Rig)
    for material, table in results.over_radius.items():
        found[f"radius_{material}"] = speeds.radius_picture("", table, rig.roller_radius, "").figure
    if MATERIALS[0] in results.effects:
        found["roller_effects"] = speeds.effects_picture("", results.effects[MATERIALS[0]], "").figure
    if results.theory is not None:
        found["figure_8a"] = traction_sliding(results.theory, WHEELS)
        found["figure_8b"] = traction_forces(results.theory, WHEELS)
    return found


def around_onset(runs: list[HuntingRun], onset: float, count: int = 6) -> list[HuntingRun]:
    """Runs on both sides of the onset [m/s] and further away, by speed; spread evenly if there is no onset."""
    if not math.isfinite(onset):
        return runs[:: max(1, math.ceil(len(runs) / count))]
    below = [run for run in runs if run.speed < onset]
    above = [run for run in runs if run.speed >= onset]
    far_below = [run for run in below[:-1] if run.speed < onset - 8 / 3.6]
    far_above = [run for run in above[1:] if run.speed > onset + 8 / 3.6]
    picked = below[-1:] + above[:1] + far_below[-1:] + far_above[:1] + far_above[2:3] + far_above[-1:]
    unique = {run.speed: run for run in picked}
    return [unique[speed] for speed in sorted(unique)][:count]
