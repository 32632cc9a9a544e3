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
from rollerrig.analysis.slide_statistics import torque_ripple, wheel_radius
from rollerrig.assembly.actuators import friction_brake
from rollerrig.common.formatting import number
from rollerrig.config import Case
from rollerrig.plot.control import loop_growth
from rollerrig.study.jobs import Done, Progress, Round, job, whole_run
from rollerrig.study.quantities import Numbers, Quantities
from rollerrig.study.report import Block, Picture, Table, Text
from rollerrig.study.runs.control import ESTIMATORS, RIPPLE_CRITERION

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


DURATION = 15.0
"""Duration of the runs [s]: on low adhesion full service locks the wheels within some seconds."""

STANDS, SETTLES = 1e-4, 0.5
"""Speed at which a brake's torque over speed is taken, within its regularisation [rad/s]; after locking the ripple of the slide
itself fades [s]."""


def held_jobs(case: Case) -> Round:
    """A job for each estimator; none without a friction brake."""
    if case.brake is None:
        return {}
    whole = case.with_changes({"slide_protection": None, "time.duration": DURATION})
    return {f"held wheel, {label}": job(held_wheel, whole.with_changes(vary(whole, 0.0)))
            for label, vary in ESTIMATORS.items()}  # fmt: skip


def held_wheel(case: Case, progress: Progress | None = None) -> dict[str, float]:
    """Numbers of one estimator, by the names of `held_wheel`."""
    rate, frequency = held_growth(case)
    run = whole_run(case, progress)
    held, ripple = held_ripple(run["time"].to_numpy(), wheel_radius(run) * np.abs(run["axle_speed"].to_numpy()),
                               run["train_speed"].to_numpy(), run["roller_torque"].to_numpy(), case)  # fmt: skip
    return {"growth_rate": rate, "growth_hz": frequency, "held_s": held, "held_ripple_nm": ripple}


def held_growth(case: Case) -> tuple[float, float]:
    """Rate [1/s] and frequency [Hz] of the sampled loop of one axle whose wheel is held, its torque as estimated, no feedback."""
    estimated = case.with_changes(
        {"rig_control.axle_torque.kind": "estimated", "rig_control.drive_command.kind": "direct"}
    )
    at_rest = creep_slope(case) * case.motion.speed / case.contact.creepage_regularisation_speed
    loop = loop_of(estimated, at_rest, sliding=True)
    if loop is None or case.brake is None:
        return math.nan, math.nan
    holds = -friction_brake(case.brake).torque(max(row[1] for row in case.brake.demand), STANDS) / STANDS
    return growth(loop.scaled(0.0), rolling_plant(loop.real, loop.creep, holds), above=ABOVE)


def held_ripple(
    time: np.ndarray, rolling: np.ndarray, train: np.ndarray, torque: np.ndarray, case: Case
) -> tuple[float, float]:
    """Time for which all wheels of a run were held [s], the last time, and the ripple of the drives in it [N m].

    Args:
        time: evenly spaced [s], shape (time,).
        rolling: speed of the wheels' circumference [m/s], shape (time, axle).
        train: speed of the train [m/s].
        torque: of the roller drives [N m], shape (time, axle).
        case: for the speed below which a wheel is locked.
    """
    assert case.rig_control is not None
    locked = case.rig_control.locked_speed
    held = ((rolling < locked) & (train[:, None] - rolling > locked)).all(axis=1)
    at = np.flatnonzero(held)
    if not at.size:
        return 0.0, math.nan
    last = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1)[-1]
    settled = last[time[last] > time[last[0]] + SETTLES]
    return float(time[last[-1]] - time[last[0]]), torque_ripple(time[settled], torque[settled])[0]


def held_numbers(done: Done) -> dict[str, dict[str, float]] | None:
    """Numbers by estimator, as far as its job is done; None where there is none."""
    found = {label: done[name] for label in ESTIMATORS if (name := f"held wheel, {label}") in done}
    return found or None


def held_blocks(numbers: Numbers, quantities: Quantities) -> list[Block]:
    """Text and table of the report."""
    text = (
        "Without slide protection the brake locks the wheels. A locked wheel's estimated torque is the brake's reaction to the "
        "drive's own: through virtual train and feed-forward it would return to the drive with the gain J_r (r/R)²/J_w. The "
        "growth rate is that of this linear loop, the torque as estimated: where it is positive the drives would oscillate. A "
        "locked wheel is therefore held in the virtual train too, (D15); the ripple is that of a run so treated."
    )
    table: Table = quantities.table(numbers, "held_wheel.*", "a wheel held by its brake", "estimator")
    return [Text(text), table]
