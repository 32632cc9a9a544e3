"""A wheel that its brake holds on the rig, by estimator: what its loop would do, and what the drives do as it is treated, (D15).

Case of a braked rig -> [held_jobs] -> growth of the linear loop with the wheel held, ripple of a run without slide protection
                                                                              -> [held_blocks] -> table of the report

Taken for one that turns the virtual wheel, the reaction of the brake to the drive's own torque returns to the drive. Equations:
docs/theory/rig_control.md, locked wheels.
"""

from __future__ import annotations

import math

import numpy as np

from rollerrig.actuators import friction_brake
from rollerrig.analysis.control_loop import creep_slope, loop_of
from rollerrig.analysis.loop_stability import ABOVE, growth, rolling_plant
from rollerrig.analysis.torque_ripple import torque_ripple
from rollerrig.analysis.tracking import wheel_radius
from rollerrig.config import Case
from rollerrig.study.control_variants import ESTIMATORS
from rollerrig.study.jobs import Done, Progress, Round, job, whole_run
from rollerrig.study.quantities import Numbers, Quantities, Quantity
from rollerrig.study.report import Block, Table, Text

DURATION = 15.0
"""Of the runs [s]: on low adhesion full service locks the wheels within some seconds."""

STANDS, SETTLES = 1e-4, 0.5
"""Speed at which a brake's torque over speed is taken, within its regularisation [rad/s]; after locking the ripple of the slide
itself fades [s]."""

HELD_QUANTITIES = (
    Quantity("held_wheel", "a wheel held by its brake, by estimator; null: no friction brake in the case"),
    Quantity("held_wheel.*.growth_rate", "of the linear loop, were the held wheel's torque that of a turning one; null: no "
             "equations for it", "1/s", "loop without (D15): growth", 3),
    Quantity("held_wheel.*.growth_hz", "its frequency", "Hz", "frequency", 3),
    Quantity("held_wheel.*.held_s", "time for which all wheels stood in the run, with (D15)", "s", "wheels held for", 3),
    Quantity("held_wheel.*.held_ripple_nm", "torque ripple of the drives in that time, RMS; null: no wheel was held for long",
             "N m", "with (D15): ripple", 3),
)  # fmt: skip


def held_jobs(case: Case) -> Round:
    """A job for each estimator; none without a friction brake."""
    if case.brake is None:
        return {}
    whole = case.with_changes({"slide_protection": None, "time.duration": DURATION})
    return {f"held wheel, {label}": job(held_wheel, whole.with_changes(vary(whole, 0.0)))
            for label, vary in ESTIMATORS.items()}  # fmt: skip


def held_wheel(case: Case, progress: Progress | None = None) -> dict[str, float]:
    """Of one estimator, by name of HELD_QUANTITIES."""
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
    """For how long all wheels of a run were held [s], the last time, and the ripple of the drives in it [N m].

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
    """By estimator, as far as its job is done; None where there is none."""
    found = {label: done[name] for label in ESTIMATORS if (name := f"held wheel, {label}") in done}
    return found or None


def held_blocks(numbers: Numbers, quantities: Quantities) -> list[Block]:
    """Text and table of the report."""
    text = (
        "Without slide protection the brake locks the wheels. A locked wheel's estimated torque is the brake's reaction to the "
        "drive's own: through virtual train and feed-forward it would return to the drive with the gain J_r (r/R)²/J_w. The "
        "growth rate is that of this linear loop, the torque as estimated: where it is positive the drives would ring. A "
        "locked wheel is therefore held in the virtual train too, (D15); the ripple is that of a run so treated."
    )
    names = [quantity.name for quantity in HELD_QUANTITIES[1:]]
    table: Table = quantities.table(dict(numbers), names, "a wheel held by its brake", "estimator")
    return [Text(text), table]
