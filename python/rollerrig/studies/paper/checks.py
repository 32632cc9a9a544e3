"""The checks of the two studies: numbers that came out beside numbers that must come out.

PaperResults -> [checks] -> report.Check for the table of the report and for summary.json
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from rollerrig.analysis import HuntingRun
from rollerrig.analysis.fits import fit
from rollerrig.report import Check
from rollerrig.studies.paper.compute import PaperResults
from rollerrig.studies.paper.plan import MATERIALS, traction_case

FRONT, REAR = "wheelset_1_right", "wheelset_2_right"
"""The wheels of the paper's figure 8."""


def traction_checks(results: PaperResults) -> list[Check]:
    """Figure 8 against theory; empty if the run was cut off."""
    run, study = results.traction, results.traction_theory
    if run is None or study is None or run.attrs["status"] != "ok":
        return []
    return [
        *_sliding_checks(study),
        *_symmetry_checks(run),
        *_force_checks(results, run, study),
        Check(
            "traction: energy, work in = kinetic + potential + dissipated",
            float(run.attrs["energy_relative_residual"]),
            0.0,
            1e-6,
            "of the energy turned over; the error of the integration",
        ),
    ]


def _phases(study: xr.Dataset) -> tuple[xr.Dataset, xr.Dataset]:
    """The part in which the torque rises, and the part in which it has its final value."""
    torque = study["torque"].to_numpy()
    final = torque >= torque.max() * (1 - 1e-12)
    return study.isel(time=(torque > 0) & ~final), study.isel(time=final)


def _sliding_checks(study: xr.Dataset) -> list[Check]:
    ramp, final = _phases(study)
    checks = []
    for wheel, place in ((FRONT, "front"), (REAR, "rear")):
        own, speed, torque = study.sel(wheel=wheel), study["speed"].to_numpy(), study["torque"].to_numpy()
        product = fit(own["sliding"].to_numpy(), speed, speed * torque)
        checks.append(
            Check(
                f"sliding, {place}: what a fit c₀V + c₁ × torque × speed leaves",
                product.largest,
                0.0,
                0.03,
                "of the largest sliding; saturation and load transfer bend the creep law by a few per cent",
            )
        )
        rising, time = ramp.sel(wheel=wheel), ramp["time"].to_numpy()
        parabola = fit(rising["sliding"].to_numpy(), np.ones_like(time), time, time**2)
        checks.append(
            Check(
                f"sliding, {place}: what a parabola leaves while the torque rises",
                parabola.largest,
                0.0,
                0.03,
                "the speed itself rises quadratically, so torque × speed has a small cubic part",
            )
        )
        steady, time = final.sel(wheel=wheel), final["time"].to_numpy()
        settled = time > time[0] + 0.2
        line = fit(steady["sliding"].to_numpy()[settled], np.ones(int(settled.sum())), time[settled])
        checks.append(
            Check(
                f"sliding, {place}: what a straight line leaves at constant torque",
                line.largest,
                0.0,
                0.005,
                "acceleration and force are constant, 0.2 s after the corner of the torque",
            )
        )
        end = own.isel(time=-1)
        checks.append(
            Check(
                f"sliding at the end, {place}: slope of the creep law at the start × force × speed",
                1e3 * float(end["sliding"]),
                1e3 * float(end["sliding_theory"]),
                0.1,
                "the slope changes with load (load transfer) and with saturation (two patches pull against each other)",
                "mm/s",
                relative=True,
            )
        )
    return checks


def _symmetry_checks(run: xr.Dataset) -> list[Check]:
    checks = []
    for variable, what in (
        ("longitudinal_sliding", "sliding"),
        ("longitudinal_force", "longitudinal force"),
        ("vertical_force", "vertical force"),
    ):
        values = run[variable]
        worst = 0.0
        for wheelset in ("wheelset_1", "wheelset_2"):
            left, right = values.sel(wheel=f"{wheelset}_left"), values.sel(wheel=f"{wheelset}_right")
            worst = max(worst, float(np.abs(left - right).max() / np.abs(values).max()))
        checks.append(
            Check(
                f"left = right, {what}",
                worst,
                0.0,
                1e-6,
                "relative; the model is symmetric, only the integration's error remains",
            )
        )
    return checks


def _force_checks(results: PaperResults, run: xr.Dataset, study: xr.Dataset) -> list[Check]:
    wheelset, roller = spin_balance(results, run, "wheelset_1", "roller_1")
    last = study.isel(time=-1)
    checks = [
        Check("torque − Σ creep force × radius = J dω/dt, front wheelset", wheelset, 0.0, 0.002, _SPIN_REASON),
        Check("Σ creep force × radius = J dω/dt, front roller pair", roller, 0.0, 0.002, _SPIN_REASON),
    ]
    for wheel, place in ((FRONT, "front"), (REAR, "rear")):
        own = last.sel(wheel=wheel)
        checks.append(
            Check(
                f"longitudinal force at the end, {place}: what accelerates wheelset and roller",
                float(own["longitudinal_force"]),
                float(own["longitudinal_force_theory"]),
                0.005,
                "closed form with the nominal radius; free rolling resistance (a few newtons) left out",
                "N",
                relative=True,
            )
        )
    start = study.isel(time=0)
    for wheel, place in ((FRONT, "front"), (REAR, "rear")):
        change = [float(last[name].sel(wheel=wheel) - start[name].sel(wheel=wheel)) for name in _VERTICAL]
        checks.append(
            Check(
                f"load transfer at the end, {place}: balance of the frame's moments",
                change[0],
                change[1],
                0.01,
                "closed form, small angles, springs linear",
                "N",
                relative=True,
            )
        )
    total = float(run["vertical_force"].isel(time=0).sum())
    checks.append(
        Check(
            "vertical wheel loads sum to the weight and what the secondary suspension puts on the frame",
            total,
            carried_weight(results, run),
            1e-6,
            "accuracy of the starting equilibrium",
            "N",
            relative=True,
        )
    )
    return checks


_SPIN_REASON = (
    "relative to the largest torque; the patches' mean radius stands for each, spin moments on the cone are left out"
)
_VERTICAL = ("vertical_force", "vertical_force_theory")


def spin_balance(results: PaperResults, run: xr.Dataset, wheelset: str, roller: str) -> tuple[float, float]:
    """Largest imbalance about the axes of a wheelset and its roller pair, over the largest torque [1]."""
    case = traction_case(results.plan)
    study = results.traction_theory
    assert study is not None
    torque = study["torque"].to_numpy()
    inertia = next(b.inertia[1] for b in case.vehicle.data.body if b.name == wheelset)
    rig = case.support.data
    wheels = [w for w in run["wheel"].to_numpy() if str(w).startswith(wheelset)]
    on_wheel, on_roller = np.zeros_like(torque), np.zeros_like(torque)
    for wheel in wheels:
        own = run.sel(wheel=wheel)
        force = own["patch_creep_force_x"].fillna(0.0).sum("patch").to_numpy()
        on_wheel -= force * own["rolling_radius"].to_numpy()
        on_roller -= force * rig.roller_radius  # type: ignore[union-attr]
    spin = run["pitch_acceleration"]
    left = torque + on_wheel - inertia * spin.sel(body=wheelset).to_numpy()
    left_roller = on_roller - rig.roller_inertia[1] * spin.sel(body=roller).to_numpy()  # type: ignore[union-attr]
    inside = slice(1, -1)  # at the very ends an acceleration may belong to the other side of a corner
    scale = float(torque.max())
    return float(np.abs(left[inside]).max()) / scale, float(np.abs(left_roller[inside]).max()) / scale


def carried_weight(results: PaperResults, run: xr.Dataset) -> float:
    """Weight of frame and wheelsets and the load of the secondary suspension at the first output time [N]."""
    case = traction_case(results.plan)
    free = {
        b.name: b.mass for b in case.vehicle.data.bodies_in(case.vehicle.part) if b.name not in case.vehicle.part.fixed
    }
    load = 9.81 * sum(free.values())
    for element in case.vehicle.data.elements_in(case.vehicle.part):
        if element.between[0] in case.vehicle.part.fixed:
            load -= float(run["element_force_z"].sel(element=element.name).isel(time=0))
    return load


def hunting_checks(results: PaperResults) -> list[Check]:
    """Figure 7: energy of each run and ramp."""
    checks = []
    for material in MATERIALS:
        audits = [float(run.motion.attrs["energy_relative_residual"]) for run in _runs(results, material)]
        if audits:
            checks.append(
                Check(
                    f"energy of the runs at constant speed, {material}: the worst",
                    max(audits),
                    0.0,
                    1e-5,
                    _HUNTING_REASON,
                )
            )
        if material in results.ramps:
            residual = float(results.ramps[material].attrs["energy_relative_residual"])
            checks.append(Check(f"energy of the ramp, {material}", residual, 0.0, 1e-5, _HUNTING_REASON))
    return checks


def _runs(results: PaperResults, material: str) -> list[HuntingRun]:
    found = results.runs.get(material)
    return found.runs if found else []


_HUNTING_REASON = "of the energy turned over; the runs are integrated to a relative tolerance of 1e-4 per step"
