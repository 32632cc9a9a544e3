"""Checks of the paper's two studies: computed beside expected values, each with the reason of its tolerance.

runs of PaperStudy -> [paper_checks] -> Check for the table of the report and for summary.json
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np
import xarray as xr

from rollerrig.analysis.fits import Fit, fit
from rollerrig.config import Case, Rig
from rollerrig.study.checks import Check
from rollerrig.study.interval import Interval

FRONT, REAR = "wheelset_1_right", "wheelset_2_right"
"""The wheels of the paper's figure 8."""
PLACES = ((FRONT, "front"), (REAR, "rear"))

SPIN_REASON = "relative to the largest torque; the patches' mean radius is used, spin moments on the cone are left out"
ORDER_REASON = "above the linear critical speed every disturbance grows; linear speed to 0.1 km/h"
HUNTING_REASON = "of the energy turned over; the runs are integrated to a relative tolerance of 1e-4 per step"


def traction_checks(run: xr.Dataset, study: xr.Dataset, case: Case) -> Iterator[Check]:
    """Figure 8 against theory; none if the run was cut off.

    Args:
        run: all signals.
        study: the same wheels beside the closed forms, of `with_theory`.
        case: what was run.
    """
    if run.attrs["status"] != "ok":
        return
    for wheel, place in PLACES:
        yield from _sliding_checks(study, wheel, place)
    for variable in ("longitudinal_sliding", "longitudinal_creep_force", "vertical_force"):
        yield _symmetry_check(run, variable)
    wheelset, roller = spin_balance(run, study, case, "wheelset_1", "roller_1")
    yield Check("torque - Σ creep force × radius = J dω/dt, front wheelset", wheelset, 0.0, 0.002, SPIN_REASON)
    yield Check("Σ creep force × radius = J dω/dt, front roller pair", roller, 0.0, 0.002, SPIN_REASON)
    for check in (_force_check, _load_transfer_check):
        for wheel, place in PLACES:
            yield check(study.sel(wheel=wheel), place)
    yield Check(
        "vertical wheel loads sum to the weight and the load of the secondary suspension on the frame",
        float(run["vertical_force"].isel(time=0).sum()),
        carried_weight(run, case),
        1e-6,
        "accuracy of the starting equilibrium",
        "N",
        relative=True,
    )
    yield Check(
        "traction: energy, work in = kinetic + potential + dissipated",
        float(run.attrs["energy_relative_residual"]),
        0.0,
        1e-6,
        "of the energy turned over; the error of the integration",
    )


def sliding_course(study: xr.Dataset, wheel: str) -> tuple[Fit, Fit]:
    """The sliding of a wheel fitted by a parabola while the torque rises, and by a straight line at its final value."""
    torque = study["torque"].to_numpy()
    sliding, time = study.sel(wheel=wheel)["sliding"].to_numpy(), study["time"].to_numpy()
    final = torque >= torque.max() * (1 - 1e-12)
    rising, steady = (torque > 0) & ~final, final & (time > time[final][0] + 0.2)
    return (
        fit(sliding[rising], np.ones(int(rising.sum())), time[rising], time[rising] ** 2),
        fit(sliding[steady], np.ones(int(steady.sum())), time[steady]),
    )


def _sliding_checks(study: xr.Dataset, wheel: str, place: str) -> Iterator[Check]:
    """Course of the sliding: while the torque rises, and at its final value."""
    torque, own = study["torque"].to_numpy(), study.sel(wheel=wheel)
    speed, sliding = study["speed"].to_numpy(), own["sliding"].to_numpy()
    parabola, straight = sliding_course(study, wheel)
    course = (
        (
            "a fit c₀V + c₁ × torque × speed",
            fit(sliding, speed, speed * torque),
            0.03,
            "of the largest sliding; saturation and load transfer bend the creep law by a few per cent",
        ),
        (
            "a parabola leaves while the torque rises",
            parabola,
            0.03,
            "the speed itself rises quadratically, so torque × speed has a small cubic part",
        ),
        (
            "a straight line leaves at constant torque",
            straight,
            0.005,
            "acceleration and force are constant, 0.2 s after the corner of the torque",
        ),
    )
    for what, found, tolerance, reason in course:
        verb = what if "leaves" in what else f"{what} leaves"
        yield Check(f"sliding, {place}: what {verb}", found.largest, 0.0, tolerance, reason)
    end = own.isel(time=-1)
    yield Check(
        f"sliding at the end, {place}: slope of the creep law at the start × force × speed",
        1e3 * float(end["sliding"]),
        1e3 * float(end["sliding_theory"]),
        0.1,
        "the slope changes with load (load transfer) and with saturation (two patches pull against each other)",
        "mm/s",
        relative=True,
    )


def _symmetry_check(run: xr.Dataset, variable: str) -> Check:
    values = run[variable]
    sides = [(values.sel(wheel=f"{w}_left"), values.sel(wheel=f"{w}_right")) for w in ("wheelset_1", "wheelset_2")]
    worst = max(float(np.abs(left - right).max() / np.abs(values).max()) for left, right in sides)
    name = {"longitudinal_sliding": "sliding"}.get(variable, variable.replace("_", " "))
    reason = "relative; the model is symmetric, only the integration's error remains"
    return Check(f"left = right, {name}", worst, 0.0, 1e-6, reason)


def _force_check(own: xr.Dataset, place: str) -> Check:
    last = own.isel(time=-1)
    return Check(
        f"longitudinal creep force at the end, {place}: what accelerates wheelset and roller",
        float(last["longitudinal_creep_force"]),
        float(last["longitudinal_creep_force_theory"]),
        0.005,
        "closed form with the nominal radius; free rolling resistance (a few newtons) left out",
        "N",
        relative=True,
    )


def _load_transfer_check(own: xr.Dataset, place: str) -> Check:
    start, last = own.isel(time=0), own.isel(time=-1)
    change = [float(last[name] - start[name]) for name in ("vertical_force", "vertical_force_theory")]
    reason = "closed form, small angles, springs linear"
    name = f"load transfer at the end, {place}: balance of the frame's moments"
    return Check(name, change[0], change[1], 0.01, reason, "N", relative=True)


def spin_balance(run: xr.Dataset, study: xr.Dataset, case: Case, wheelset: str, roller: str) -> tuple[float, float]:
    """Largest imbalance about the axes of a wheelset and its roller pair, over the largest torque [1]."""
    torque = study["torque"].to_numpy()
    inertia = next(b.inertia[1] for b in case.vehicle.data.body if b.name == wheelset)
    rig = case.support.data
    assert isinstance(rig, Rig)
    on_wheel, on_roller = np.zeros_like(torque), np.zeros_like(torque)
    for wheel in (w for w in run["wheel"].to_numpy() if str(w).startswith(wheelset)):
        own = run.sel(wheel=wheel)
        force = own["patch_creep_force_x"].fillna(0.0).sum("patch").to_numpy()
        on_wheel -= force * own["rolling_radius"].to_numpy()
        on_roller -= force * rig.roller_radius
    spin = run["pitch_acceleration"]
    left = torque + on_wheel - inertia * spin.sel(body=wheelset).to_numpy()
    left_roller = on_roller - rig.roller_inertia[1] * spin.sel(body=roller).to_numpy()
    inside = slice(1, -1)  # at the very ends an acceleration may belong to the other side of a corner
    scale = float(torque.max())
    return float(np.abs(left[inside]).max()) / scale, float(np.abs(left_roller[inside]).max()) / scale


def carried_weight(run: xr.Dataset, case: Case) -> float:
    """Weight of frame and wheelsets and the load of the secondary suspension at the first output time [N]."""
    part, vehicle = case.vehicle.part, case.vehicle.data
    load = case.gravity * sum(b.mass for b in vehicle.bodies_in(part) if b.name not in part.fixed)
    for element in vehicle.elements_in(part):
        if element.between[0] in part.fixed:
            load -= float(run["element_force_z"].sel(element=element.name).isel(time=0))
    return float(load)


def energy_checks(material: str, runs: Iterable[xr.Dataset], ramp: xr.Dataset | None) -> Iterator[Check]:
    """Figure 7: energy of the runs at constant speed and of the ramp."""
    audits = [float(run.attrs["energy_relative_residual"]) for run in runs]
    if audits:
        name = f"energy of the runs at constant speed, {material}: the worst"
        yield Check(name, max(audits), 0.0, 1e-5, HUNTING_REASON)
    if ramp is not None:
        residual = float(ramp.attrs["energy_relative_residual"])
        yield Check(f"energy of the ramp, {material}", residual, 0.0, 1e-5, HUNTING_REASON)


def order_check(name: str, by_disturbance: Interval, linear: float) -> Iterator[Check]:
    """Figure 7: what is disturbed hunts from a speed on that is not above the linear one; none where either is unknown.

    Args:
        name: of material, vehicle and support.
        by_disturbance: where that critical speed lies [km/h].
        linear: the linear critical speed [km/h]; NaN: none in the range.
    """
    if by_disturbance.known and math.isfinite(linear):
        title = f"critical speed by disturbance is not above the linear one, {name}"
        yield Check(title, by_disturbance, linear, 0.1, ORDER_REASON, "km/h", kind="at most")
