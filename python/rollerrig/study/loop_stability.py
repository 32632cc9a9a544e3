"""Stability of the roller drives' loop over its gains: eigenvalues of the linear loop, and lightly excited runs beside them.

Case -> [loop_jobs] -> points: growth rate computed with and without the vehicle, and measured -> numbers, figure

An excited run rolls on a dry virtual rail; a light brake application excites the loop. What then grows above ABOVE is compared
with the least damped eigenvalue there; what decays soon is hidden by the slow motions that the excitation leaves.
"""

import math
from typing import Any

import numpy as np

from rollerrig.analysis.control_loop import Loop, creep_slope, loop_of, margins
from rollerrig.analysis.loop_stability import (
    ABOVE,
    LINEAR_RANGE,
    gain_limit,
    growth,
    measured_growth,
    rolling_plant,
    vehicle_plant,
)
from rollerrig.common.formatting import number
from rollerrig.config import Case
from rollerrig.plot.control import loop_growth
from rollerrig.study.jobs import Progress, Round, job, whole_run
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Block, Picture, Text
from rollerrig.study.runs.control import RIPPLE_CRITERION

FACTORS = tuple(float(f) for f in np.geomspace(1.0, 256.0, 25))
"""On the gains of the PI controller, in the runs that measure its stability."""

EXCITED_AT, EXCITED_DURATION = 0.2, 4.0  # [s]


def excited_case(case: Case) -> Case:
    """A short run at speed on a dry virtual rail, lightly excited by the brake or the drive."""
    changes: dict[str, object] = {
        "adhesion": {"rail": "dry"},
        "rig_control.feedback.kind": "proportional_integral",
        "track_brake": None,
        "sanding": None,
        "slide_protection": None,
        "wheel_slip_control": None,
        "time.duration": EXCITED_DURATION,
        "time.output_step": max(1e-3, case.time.sampling_step),
    }
    if case.brake is not None:
        changes["brake.demand"] = [[0.0, 0.0], [EXCITED_AT, 0.0], [EXCITED_AT + 0.01, "0.2 bar"]]
    if case.traction is not None:
        push = 0.0 if case.brake is not None else 200.0
        changes["traction.demand"] = [[0.0, 0.0], [EXCITED_AT, 0.0], [EXCITED_AT + 0.01, push]]
    return case.with_changes(changes)


def loop_jobs(case: Case) -> Round:
    """Excited runs over FACTORS; none where the linear loop has no equations."""
    excited = excited_case(case)
    creep = creep_slope(excited)
    loop = loop_of(excited, creep, sliding=False)
    if loop is None:
        return {}
    scaled = {factor: loop.scaled(factor) for factor in FACTORS}
    gains = {factor: {f"rig_control.feedback.{name}": getattr(one, name) for name in ("proportional", "integral")}
             for factor, one in scaled.items()}  # fmt: skip
    return {
        f"gains times {f:.4g}": job(loop_point, f, excited.with_changes(gains[f]), scaled[f], creep) for f in FACTORS
    }


def loop_point(
    factor: float, case: Case, loop: Loop, creep: float, progress: Progress | None = None
) -> dict[str, float]:
    """One excited run beside the eigenvalues of its loop, by the names of `loop.points`."""
    measured, amplitude = measured_growth(whole_run(case, progress), EXCITED_AT + 0.1)
    plants = {"rolling": rolling_plant(loop.real, creep), "vehicle": vehicle_plant(case)}
    found = {of: growth(loop, plant, above=ABOVE) for of, plant in plants.items()} | {"measured": measured}
    point = {
        f"{of}_{end}": value for of, pair in found.items() for end, value in zip(("rate", "hz"), pair, strict=True)
    }
    unstable = math.isfinite(measured[0]) or amplitude > 0.1 * LINEAR_RANGE[1]  # or saturated from the start
    return {"factor": factor, **point, "unstable": float(unstable)}


def loop_numbers(case: Case, points: list[dict[str, float]]) -> dict[str, Any] | None:
    """Margins and gain limits of the PI loop as shipped."""
    excited = excited_case(case)
    creep = creep_slope(excited)
    loop, sliding = (loop_of(excited, creep, sliding=slides) for slides in (False, True))
    if loop is None or sliding is None:
        return None
    found, vehicle = margins(loop), vehicle_plant(excited)
    return {
        "crossover_hz": found.phase_frequency,
        "phase_margin_deg": math.degrees(found.phase),
        "gain_margin": found.gain,
        "unstable_from_factor_alone": gain_limit(loop, rolling_plant(loop.real, creep)),
        "unstable_from_factor": gain_limit(loop, vehicle),
        "unstable_from_factor_sliding": gain_limit(sliding, vehicle),
        "points": points,
    }


def loop_blocks(loop: Numbers, points: list[dict[str, float]]) -> list[Block]:
    """Text and figure of the report."""
    shown = {key: number(value, 3) if isinstance(value, float) else "–" for key, value in loop.items()}
    text = (
        f"The feedback of one axle alone, in closed form, crosses over at {shown['crossover_hz']} Hz with a phase margin of "
        f"{shown['phase_margin_deg']}°; its gains could be {shown['gain_margin']} times as large. As it is sampled, with "
        "estimator and feed-forward, wheel and roller alone are unstable from "
        f"{shown['unstable_from_factor_alone']} times on. In the vehicle the wheelsets oscillate on their springs along the "
        f"track, and this decides: unstable from {shown['unstable_from_factor']} times on while the virtual wheel rolls on a dry "
        f"rail, from {shown['unstable_from_factor_sliding']} times while it slides."
    )
    means = (
        "Unstable means that the smallest oscillation grows; limits of torque and adhesion then hold it at some size, which may "
        f"fall again at larger gains. Whether that is a failure is decided by its size alone: {RIPPLE_CRITERION}. Computed is "
        "the least damped motion above 10 Hz, from the core's exact linearisation of the vehicle and the linear controller; "
        "measured: lightly excited runs on a dry rail."
    )
    picture = loop_growth({key: [point[key] for point in points] for key in points[0]})
    shape = Picture("loop_growth", picture, "Growth rate and frequency of the loop over its gains.")
    return [Text(text), Text(means), shape]
