"""What a sweep computes of each case: numbers with unit and meaning.

case, table of the plan -> [measured] -> name -> number

To add one: a table in `config/schema/plan.py`, a table of quantities, and a function here that gives their numbers.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from rollerrig import _core
from rollerrig.analysis.critical_speed import scan_linear
from rollerrig.analysis.slide_statistics import TestRecord
from rollerrig.analysis.wheel_rail_forces import filtered, wheel_forces
from rollerrig.assembly.laws import core_law
from rollerrig.config import CRITERIA, Case, Programme, case_from_toml
from rollerrig.config.schema import plan
from rollerrig.config.schema.actuators import SlideProtection
from rollerrig.config.schema.programme import FlatWear
from rollerrig.contact_analysis.static_contact import contact
from rollerrig.results import COMPLETED, RunInfo
from rollerrig.results.quantities import registered
from rollerrig.simulation.starting_state import StartError
from rollerrig.study.ensemble import recorded
from rollerrig.study.jobs import Progress, whole_modes, whole_run
from rollerrig.study.runs import wsp
from rollerrig.study.runs.adhesion import track_case

Progressing = Progress | None
Numbers = dict[str, Any]


def quantities(kind: str) -> dict[str, tuple[str, str]]:
    """Name -> unit and meaning of the numbers of a measure."""
    return {one.key: (one.unit, one.meaning) for one in registered(f"measure.{kind}")}


def measured(case: Case, options: Any, progress: Progressing = None) -> dict[str, float]:
    """The numbers that a table of the plan asks of a case.

    Raises:
        ConfigError: the case is not of the kind that the measure needs.
        KeyboardInterrupt: Ctrl-C came before the end.
        RuntimeError: a run left the validity of its model.
        StartError: no rolling equilibrium.
        ValueError: nothing is left to be assessed, or a wheel does not touch.
    """
    return {name: float(value) for name, value in MEASURES[options.kind](case, options, progress).items()}


def _run(case: Case, options: plan.RunMeasure, progress: Progressing) -> Numbers:
    """Forces as EN 14363 assesses them, and lateral motion of the wheelsets, both from `options.begin` on."""
    run = whole_run(case, progress)
    if run.attrs["status"] not in COMPLETED:
        raise RuntimeError(run.attrs["status_message"])
    late = {"time": slice(options.begin, None)}
    forces = filtered(wheel_forces(run)).sel(late)
    if forces.sizes["time"] < 2:
        raise ValueError(f"measure.begin: {options.begin:g} s is beyond the run, which ended at {run['time'][-1]:g} s")
    lateral = run["lateral"].sel(late).sel(body=[body.name for body in RunInfo.of(run).wheelsets])
    size = abs(forces)
    return {
        "guiding_force_largest": size["guiding_force"].max(),
        "guiding_force_mean": size["guiding_force"].mean("time").max(),
        "guiding_force_sum_largest": size["guiding_force_sum"].max(),
        "derailment_quotient_largest": size["derailment_quotient"].max(),
        "wheel_load_least": forces["wheel_load"].min(),
        "wheel_load_largest": forces["wheel_load"].max(),
        "wear_number_largest": forces["wear_number"].mean("time").max(),
        "lateral_largest": abs(lateral).max(),
        "lateral_rms": lateral.std("time").max(),
        "energy_relative_residual": run.attrs["energy_relative_residual"],
    }


def _stability(case: Case, _options: plan.StabilityMeasure, progress: Progressing) -> Numbers:
    """The mode that comes nearest to growing at the case's speed, and hunting there."""
    modes = whole_modes(case, [3.6 * case.motion.speed], progress).isel(speed=0)
    mode = modes.isel(mode=int(np.nanargmax(modes["growth_rate"].to_numpy())))
    of_mode = {name: mode[name] for name in ("growth_rate", "damping", "frequency")}
    return of_mode | {name: modes[name] for name in ("hunting_frequency", "hunting_damping")}


def _onset(case: Case, options: plan.CriticalSpeedMeasure, progress: Progressing) -> Numbers:
    """Where an oscillatory mode begins to grow, looked for between two speeds and above them."""
    found = scan_linear(case, [3.6 * options.slowest, 3.6 * options.fastest], True, progress)
    if found.problem:
        raise StartError(found.problem)
    return {"linear_critical_speed": found.speed_kmh}


def _contact(case: Case, options: plan.ContactMeasure, _progress: Progressing) -> Numbers:
    """Patches of the leading wheelset at one position, and rolling radii by side."""
    table, radii = contact(case, [(options.lateral, options.yaw)]), {}
    for side in ("left", "right"):
        own = table.isel(row=(table["side"] == side).to_numpy())
        if not own.sizes["row"]:
            raise ValueError(f"the {side} wheel does not touch")
        radii[side] = float(own["rolling_radius"][int(np.argmax(own["normal"].to_numpy()))])
    return {
        "patches": table.sizes["row"],
        "peak_pressure": table["peak_pressure"].max(),
        "contact_area": table["area"].sum(),
        "normal_largest": table["normal"].max(),
        "contact_angle_largest": abs(table["angle"]).max(),
        "rolling_radius_difference": radii["left"] - radii["right"],
    }


def _creep(case: Case, options: plan.CreepMeasure, _progress: Progressing) -> Numbers:
    """The patch with the largest normal force, wheelset centred, and the force of the case's creep law on it over that."""
    table = contact(case, [(0.0, 0.0)])
    patch = table.isel(row=int(np.argmax(table["normal"].to_numpy())))
    a, b, normal = (float(patch[name]) for name in ("a", "b", "normal"))
    creepage = np.array([[options.longitudinal, options.lateral, options.spin]])
    elastic = case.contact.creep_shear_modulus, case.contact.material.poisson_ratio
    law, friction = core_law(case.contact.creep), case.contact.friction.mu_0
    force = _core.creep_forces(creepage, a, b, normal, friction, *elastic, law)[0] / normal
    names = ("longitudinal_force", "lateral_force", "semi_axis_along", "semi_axis_across", "normal_force")
    return dict(zip(names, (force[0], force[1], a, b, normal), strict=True))


def _test(case: Case, options: plan.AdhesionMeasure, progress: Progressing) -> Numbers:
    """Measures of the test on track and on the rig that is to reproduce it; the same track is run once per worker."""
    if options.longest is not None:
        case = case.with_changes({"time.duration": options.longest})
    track, rig = _on_track(track_case(case).to_toml()), recorded(case, progress)
    for place, record in (("track", track), ("rig", rig)):
        if not record.completed:
            raise RuntimeError(f"on the {place}: {record.message}")
    distance = rig.measures["distance_m"]
    found = {
        "distance_error": distance / track.measures["distance_m"] - 1.0,
        "tracking_rms": rig.measures["tracking_rms"],
    }
    for place, record in (("track", track), ("rig", rig)):
        own = record.measures | {"air": 1e-3 * record.measures["air_litres"]}
        found |= {f"{name}_{place}": own[key] for name, key in OF_A_TEST.items()}
    return found


@lru_cache(maxsize=64)
def _on_track(text: str) -> TestRecord:
    return recorded(case_from_toml(text, allow_code=True))


def _stop(case: Case, options: plan.WspMeasure, progress: Progressing) -> Numbers:
    """The stop on track, with its dry reference where it ends in a standstill; the same reference is run once per worker.

    Nothing slides in the reference, so that it has our law with the default thresholds whatever those of the case are. A stop
    without slides is kept: where thresholds, demand or rail are varied, it is a result that nothing slides at some of them.
    """
    stop, programme = options.stop, Programme(name="sweep", stop=(options.stop,))
    wsp.check_case(case, programme)
    protection = case.slide_protection
    assert protection is not None
    own, dry = (track_case(make(case, programme, stop)) for make in (wsp.stop_case, wsp.dry_case))
    test = wsp.stop_record(own, programme.flat, keep=False, progress=progress).test
    idle = SlideProtection(sample_time=protection.sample_time, delay=protection.delay)
    reference = _dry_on_track(dry.model_copy(update={"slide_protection": idle}).to_toml()) if stop.stops else None
    found = wsp.StopTests(stop, "track", case, 1, [test], reference)
    bad = [*wsp.faults(found, must_slide=False), *(wsp.dry_faults(found) if stop.stops else ())]
    if bad:
        raise RuntimeError("; ".join(bad))
    numbers = {name: one.factor * found.values(one.measure)[0] for name, one in CRITERIA.items()}
    more = {"largest_slip": "largest_slip", "odometer_error": "odometer_error_m"}
    return numbers | {name: found.values(measure)[0] for name, measure in more.items()}


@lru_cache(maxsize=64)
def _dry_on_track(text: str) -> TestRecord:
    return wsp.stop_record(case_from_toml(text, allow_code=True), FlatWear(), keep=False).test


OF_A_TEST = {
    "distance": "distance_m",
    "mean_slip": "mean_slip",
    "air": "air",
    "largest_slip": "largest_slip",
    "longest_lock": "longest_lock_s",
    "dump_cycles": "dump_cycles",
    "odometer_error": "odometer_error_m",
}
"""Number of a test on track or rig -> measure of its record."""

MEASURES: Mapping[str, Callable[..., Numbers]] = {
    "run": _run,
    "stability": _stability,
    "critical_speed": _onset,
    "contact": _contact,
    "adhesion": _test,
    "wsp": _stop,
    "creep": _creep,
}
"""Kind of a measure in a plan -> case, its table of the plan, progress -> the numbers of its table in results/quantities.toml."""
