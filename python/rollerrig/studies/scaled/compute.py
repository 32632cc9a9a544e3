"""The same test on a full-scale rig and on its scaled model, mapped back, and what each violated similitude costs.

Full-scale case, its model -> [compare_scaled] -> both runs at full scale, runs with one violation at a time, critical speeds

Beside the model as it is, the model is run with everything scaled, and with one violation at a time: the share of each in the
difference. The ideal model is full scale again but for round-off; once a slide protection switches valves, round-off decides
some of the switchings, and what the ideal model differs by is what no model can tell.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis import linear_critical_speed
from rollerrig.analysis.parallel import run_jobs
from rollerrig.analysis.tracking import wheel_radius
from rollerrig.cases import at_speed
from rollerrig.config import Case
from rollerrig.results import RunInfo
from rollerrig.similitude import (
    ContactAtRest,
    Requirement,
    Similitude,
    contact_at_rest,
    factors_of,
    map_back,
    requirements,
    scale_case,
)
from rollerrig.simulation import simulate
from rollerrig.starting_state import StartError
from rollerrig.studies.output import finite

Progress = Callable[[float, str], None]

SPEEDS = tuple(v / 3.6 for v in range(40, 521, 40))
"""Full-scale speeds among which the linear critical speed is looked for [m/s]."""

LEAST_SPEED = 2.0
"""Below this a train is too slow for errors relative to its speed [m/s]."""

CAUSE_WORDS = {
    "full": "full scale",
    "model": "the model as it is",
    "ideal": "ideal: everything scaled",
    "gravity": "gravity alone not scaled",
    "material": "material alone not scaled",
    "clock": "controllers' clock alone not scaled",
    "drives": "bandwidth of the drives alone not scaled",
    "own": "the model's own machines alone",
}


@dataclass(frozen=True)
class ScaledComparison:
    """Results at full scale.

    Attributes:
        full: the full-scale case.
        model: the model's, at its own scale.
        run: of the full-scale case.
        mapped: of the model, mapped back.
        causes: further runs by name of CAUSE_WORDS, mapped back; those asked for.
        critical: linear critical speed by name [m/s], mapped back; NaN: none within SPEEDS.
        violations: all requirements, met or not.
        contact: the contact at rest of both, the model's at its own scale.
        interrupted: whether Ctrl-C was pressed.
    """

    full: Case
    model: Case
    run: xr.Dataset
    mapped: xr.Dataset
    causes: Mapping[str, xr.Dataset]
    critical: Mapping[str, float]
    violations: list[Requirement]
    contact: tuple[ContactAtRest, ContactAtRest]
    interrupted: bool = False


@dataclass(frozen=True)
class Plan:
    """A full-scale case and the models made of it.

    Attributes:
        full: the case.
        model: as it is.
        causes: models with one violation each, by name of CAUSE_WORDS.
    """

    full: Case
    model: Case
    causes: dict[str, Case] = field(default_factory=dict)


def plan_scaled(
    full: Case,
    factors: Similitude,
    *,
    strategy: str,
    keep: tuple[str, ...],
    changes: Mapping[str, object] | None = None,
    causes: bool = True,
) -> Plan:
    """The cases of a study.

    Args:
        full: full-scale case.
        factors: full/model.
        strategy: name of the strategy.
        keep: what is not scaled, as in `scale_case`.
        changes: what the model has of its own, as in `scale_case`.
        causes: also the ideal model, and models with one of the violations each.

    Raises:
        ConfigError: as `scale_case`.
    """

    def model(kept: tuple[str, ...], own: Mapping[str, object] | None) -> Case:
        return scale_case(full, factors, strategy=strategy, keep=kept, changes=own)

    as_it_is = model(keep, changes)
    if not causes:
        return Plan(full, as_it_is)
    single = {"ideal": model((), None)}
    for name in keep:
        alone = model((name,), None)
        if any(not one.met for one in requirements(full, alone)):
            single[name] = alone
    if changes:
        single["own"] = model((), changes)
    return Plan(full, as_it_is, single)


def compare_scaled(plan: Plan, *, processes: int = 2, progress: Progress | None = None) -> ScaledComparison | None:
    """Run the test at full scale and on the models.

    Args:
        plan: of `plan_scaled`.
        processes: runs at a time.
        progress: called with the fraction done and a text.

    Returns:
        The results; None where Ctrl-C came before full scale and model had begun to give any.

    Raises:
        ConfigError, StartError: as `simulate`.
    """
    names = ["full", "model", *plan.causes]
    cases = [plan.full, plan.model, *plan.causes.values()]
    done = run_jobs(_run, cases, processes=processes, progress=progress, names=[CAUSE_WORDS[name] for name in names])
    runs = {name: run for name, run in zip(names, done.results, strict=True) if run is not None}
    if "full" not in runs or "model" not in runs:
        return None
    mapped = {name: map_back(run) for name, run in runs.items() if name != "full"}
    stopped = done.interrupted or any(run.attrs["status"] == "interrupted" for run in runs.values())
    critical = {} if stopped else {name: _critical(case) for name, case in zip(names, cases, strict=True)}
    return ScaledComparison(
        plan.full,
        plan.model,
        runs["full"],
        mapped.pop("model"),
        mapped,
        critical,
        requirements(plan.full, plan.model),
        (contact_at_rest(plan.full), contact_at_rest(plan.model)),
        stopped,
    )


def _run(case: Case, progress: Progress) -> xr.Dataset:
    return simulate(case, progress=progress)


def _critical(case: Case) -> float:
    """Linear critical speed at full scale on speed-controlled rollers [m/s]; NaN if there is none in the range."""
    factor = factors_of(case).speed if case.similitude is not None else 1.0
    try:
        found = linear_critical_speed(at_speed(case).with_changes({"axle_torque": []}), [v / factor for v in SPEEDS])
    except StartError:
        return float("nan")
    return found.speed * factor if found else float("nan")


# ------------------------------------------------------------------------------------------------------ numbers

KEYS = {
    "case, model": "names of the full-scale case and of its model",
    "similitude.*": "strategy, factors full/model, and what was not scaled",
    "full.*, model_mapped_back.*": "the run at full scale, and that of the model mapped back to full scale",
    "*.status, *.status_message": "how the run ended",
    "*.stopped": "whether the train came to a stop before the end of the run",
    "*.duration_s": "end of the test [s]",
    "*.distance_m": "run by the train [m]",
    "*.speed_end_kmh": "of the train at the end [km/h]",
    "*.wheel_slip_largest": "largest |wheel speed - train speed| over train speed, above 2 m/s [-]",
    "*.tracking_rms": "RMS of wheel speed less that of the virtual train, over train speed [-]",
    "*.real_sliding_largest_mps": "wheel against roller [m/s]",
    "*.axle_torque_largest_nm": "of brake and traction on one axle [N m]",
    "*.dump_cycles": "times that dump valves opened to vent, all axles",
    "*.wheel_load_n": "mean wheel load at the start [N]",
    "*.lateral_largest_m": "largest lateral displacement of a wheelset [m]",
    "*.critical_speed_kmh": "linear critical speed with the rollers held [km/h]; null: none from 40 to 520 km/h",
    "fidelity.*": "the model mapped back less full scale at the same time: wheel_speed_rms and wheel_speed_largest over the "
    "train's highest speed [-], train_speed_largest_mps [m/s], distance_relative and critical_speed_relative [-], "
    "lateral_rms_m [m]",
    "causes.*": "the same numbers of the ideal model, which differs by round-off only, and with one violation alone",
    "violations": "one entry per requirement of similitude: what the model should have, what it has, deviation [-], and the "
    "effect; deviation null: nothing of the kind exists at full scale",
    "contact.full.*, contact.model.*": "first wheel in steady running, each at its own scale: wheel_load [N], semi_axis "
    "sqrt(a b) [m], pressure [Pa], roller_share, semi-axis over the roller's radius [-]",
    "motor_limited_share": "part of the time in which a motor of the model could not give the torque asked for [-]; null: it "
    "has no limit",
}
"""Key of summary.json -> meaning; `*` stands for a name."""


def numbers(results: ScaledComparison) -> dict[str, Any]:
    """The numbers of a comparison under the keys of KEYS."""
    record = results.model.similitude
    assert record is not None
    there, own = results.contact
    return {
        "case": results.full.name,
        "model": results.model.name,
        "similitude": record.model_dump(exclude={"case"}),
        "full": {**of_run(results.run), "critical_speed_kmh": _kmh(results, "full")},
        "model_mapped_back": {**of_run(results.mapped), "critical_speed_kmh": _kmh(results, "model")},
        "fidelity": {**fidelity(results.run, results.mapped), "critical_speed_relative": _relative(results, "model")},
        "causes": {
            name: {**fidelity(results.run, run), "critical_speed_relative": _relative(results, name)}
            for name, run in results.causes.items()
        },
        "violations": [
            {
                "name": one.name,
                "quantity": one.quantity,
                "unit": one.unit,
                "required": one.required,
                "actual": one.actual,
                "deviation": finite(one.deviation),
                "met": one.met,
                "effect": "" if one.met else one.effect,
            }
            for one in results.violations
        ],
        "contact": {"full": vars(there), "model": vars(own)},
        "motor_limited_share": motor_limited(results),
        "rollerrig_version": results.run.attrs["rollerrig_version"],
    }


def _kmh(results: ScaledComparison, name: str) -> float | None:
    return finite(3.6 * results.critical.get(name, np.nan))


def _relative(results: ScaledComparison, name: str) -> float | None:
    return finite(results.critical.get(name, np.nan) / results.critical.get("full", np.nan) - 1.0)


def of_run(run: xr.Dataset) -> dict[str, Any]:
    """Numbers of one run at full scale."""
    found: dict[str, Any] = {
        "status": run.attrs["status"],
        "status_message": run.attrs["status_message"],
        "duration_s": float(run.attrs["stopped_at_s"]),
        "wheel_load_n": float(run["normal_force"].isel(time=0).mean()),
        "lateral_largest_m": float(np.abs(_wheelsets(run)).max()),
    }
    if "train_speed" not in run:
        return found
    last, speed = run.isel(time=-1), run["train_speed"]
    slips = _relative_speed(run, speed)
    virtual = wheel_radius(run) * run["virtual_speed"]
    return found | {
        "stopped": "The train has stopped" in run.attrs["status_message"],
        "distance_m": float(last["train_distance"]),
        "speed_end_kmh": 3.6 * float(last["train_speed"]),
        "wheel_slip_largest": finite(float(np.nanmax(np.abs(slips), initial=0.0))),
        "tracking_rms": _rms(_relative_speed(run, virtual)) if float(np.abs(virtual).max()) > 0 else None,
        "real_sliding_largest_mps": float(np.abs(run["real_sliding"]).max()),
        "axle_torque_largest_nm": float(np.abs(axle_torque(run)).max()),
        "dump_cycles": int(last["dump_cycles"].sum()),
    }


def fidelity(full: xr.Dataset, mapped: xr.Dataset) -> dict[str, float | None]:
    """The model less full scale at the same times, as far as both ran."""
    other = at_times_of(full, mapped)
    full = full.isel(time=slice(0, other.sizes["time"]))
    lateral = _wheelsets(other) - _wheelsets(full)
    found: dict[str, float | None] = {"lateral_rms_m": _rms(lateral)}
    if "train_speed" not in full:
        return found
    speed = full["train_speed"]
    relative = (wheel_radius(full) * (other["axle_speed"] - full["axle_speed"]) / float(speed.max())).to_numpy()
    return found | {
        "wheel_speed_rms": _rms(relative),
        "wheel_speed_largest": finite(float(np.nanmax(np.abs(relative), initial=0.0))),
        "train_speed_largest_mps": float(np.abs(other["train_speed"] - speed).max()),
        "distance_relative": finite(
            float(mapped["train_distance"][-1]) / float(full["train_distance"][-1]) - 1.0
            if all("has stopped" in run.attrs["status_message"] for run in (full, mapped))
            else float(other["train_distance"][-1]) / float(full["train_distance"][-1]) - 1.0
        ),
    }


def at_times_of(full: xr.Dataset, other: xr.Dataset) -> xr.Dataset:
    """Another run at the times of the first, as far as both ran; what is counted or no number keeps its nearest value."""
    end = min(float(full["time"][-1]), float(other["time"][-1])) * (1 + 1e-12)
    times = full["time"].to_numpy()
    times = times[times <= end]
    names = [n for n in ("lateral", "axle_speed", "train_speed", "train_distance") if n in other]
    return other[names].interp(time=np.minimum(times, float(other["time"][-1])), assume_sorted=True)


def motor_limited(results: ScaledComparison) -> float | None:
    """Part of the time in which the brake's or the demanded torque is beyond the model's motors."""
    traction = results.model.traction
    run = results.mapped
    if traction is None or traction.motor.envelope is None or "brake_torque" not in run:
        return None
    factors = factors_of(results.model)
    speeds, torques = (np.array(column) for column in zip(*traction.motor.envelope, strict=True))
    limit = factors.factor("N m") * np.interp(np.abs(run["axle_speed"]) / factors.factor("rad/s"), speeds, torques)
    asked = run["torque_factor"] * run["traction_demand"]
    if RunInfo.of(run).motors_reproduce_brakes:
        asked = asked + run["brake_torque"]
    return float((np.abs(asked) > limit * (1 + 1e-9)).mean())


def axle_torque(run: xr.Dataset) -> xr.DataArray:
    """Torque of brake and motor on each axle, positive forward [N m]."""
    return (
        run["traction_torque"]
        if RunInfo.of(run).motors_reproduce_brakes
        else run["brake_torque"] + run["traction_torque"]
    )


def _wheelsets(run: xr.Dataset) -> np.ndarray[Any, np.dtype[np.float64]]:
    names = [str(name) for name in run["body"].to_numpy() if str(name).startswith("wheelset")]
    return np.asarray(run["lateral"].sel(body=names))


def _relative_speed(run: xr.Dataset, reference: xr.DataArray) -> np.ndarray[Any, np.dtype[np.float64]]:
    speed = run["train_speed"]
    return ((wheel_radius(run) * run["axle_speed"] - reference) / speed).where(speed > LEAST_SPEED).to_numpy()


def _rms(values: np.ndarray[Any, np.dtype[np.float64]]) -> float | None:
    kept = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(kept**2))) if kept.size else None


__all__ = [
    "CAUSE_WORDS",
    "KEYS",
    "Plan",
    "ScaledComparison",
    "at_times_of",
    "axle_torque",
    "compare_scaled",
    "fidelity",
    "motor_limited",
    "numbers",
    "plan_scaled",
    "wheel_radius",
]
