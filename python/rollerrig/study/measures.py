"""What a sweep computes of each case: numbers with unit, meaning and how each is read off.

case, table of the plan -> [Measure.measure] -> name -> number

To add one: a table in `config/schema/plan.py`, a table of quantities, a function here that says what the numbers are read off,
and a Measure of it.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.analysis.critical_speed import onset_from
from rollerrig.analysis.slide_statistics import TestRecord
from rollerrig.analysis.wheel_rail_forces import filtered, wheel_forces
from rollerrig.assembly.laws import core_law
from rollerrig.config import Case, Programme, case_from_toml
from rollerrig.config.schema import plan
from rollerrig.config.schema.actuators import SlideProtection
from rollerrig.config.schema.programme import FlatWear
from rollerrig.contact_analysis.static_contact import contact_table
from rollerrig.results import COMPLETED, RunInfo
from rollerrig.results.quantities import registered
from rollerrig.study.ensemble import recorded
from rollerrig.study.jobs import Progress, whole_modes, whole_run
from rollerrig.study.runs import wsp
from rollerrig.study.runs.adhesion import track_case


@dataclass(frozen=True)
class Measure:
    """A kind of measure.

    Attributes:
        kind: its name; the numbers are those of its table in results/quantities.toml.
        source: case, its table of the plan, progress -> what the numbers are read off.
        numbers: name -> function of the source's parts.
    """

    kind: str
    source: Callable[[Case, Any, Progress | None], tuple[Any, ...]]
    numbers: Mapping[str, Callable[..., Any]]

    @property
    def quantities(self) -> dict[str, tuple[str, str]]:
        """Name -> unit and meaning."""
        return {one.key: (one.unit, one.meaning) for one in registered(f"measure.{self.kind}")}

    def measure(self, case: Case, options: Any, progress: Progress | None = None) -> dict[str, float]:
        """The numbers of a case.

        Raises:
            ConfigError: the case is not of the kind that the measure needs.
            KeyboardInterrupt: Ctrl-C came before the end.
            RuntimeError: a run left the validity of its model.
            StartError: no rolling equilibrium.
            ValueError: nothing is left to be assessed, or a wheel does not touch.
        """
        parts = self.source(case, options, progress)
        return {name: float(read(*parts)) for name, read in self.numbers.items()}


def _run(
    case: Case, options: plan.RunMeasure, progress: Progress | None
) -> tuple[xr.Dataset, xr.DataArray, xr.Dataset]:
    """Forces as EN 14363 assesses them, lateral motion of the wheelsets, both from `options.begin` on, and the run."""
    run = whole_run(case, progress)
    if run.attrs["status"] not in COMPLETED:
        raise RuntimeError(run.attrs["status_message"])
    late = {"time": slice(options.begin, None)}
    forces = filtered(wheel_forces(run)).sel(late)
    if forces.sizes["time"] < 2:
        raise ValueError(f"measure.begin: {options.begin:g} s is beyond the run, which ended at {run['time'][-1]:g} s")
    return forces, run["lateral"].sel(late).sel(body=[body.name for body in RunInfo.of(run).wheelsets]), run


def _modes(case: Case, _options: plan.StabilityMeasure, progress: Progress | None) -> tuple[xr.Dataset, xr.Dataset]:
    """The mode that comes nearest to growing at the case's speed, and all modes there."""
    modes = whole_modes(case, [3.6 * case.motion.speed], progress).isel(speed=0)
    return modes.isel(mode=int(np.nanargmax(modes["growth_rate"].to_numpy()))), modes


def _onset(case: Case, options: plan.CriticalSpeedMeasure, progress: Progress | None) -> tuple[float]:
    """Where an oscillatory mode begins to grow, looked for between two speeds and above them."""
    onset, _ = onset_from(case, [3.6 * options.slowest, 3.6 * options.fastest], progress)
    return (math.nan if onset is None else 3.6 * onset.speed,)


def _contact(
    case: Case, options: plan.ContactMeasure, _progress: Progress | None
) -> tuple[xr.Dataset, dict[str, float]]:
    """Patches of the leading wheelset at one position, and rolling radii by side."""
    table, radii = contact_table(case, [(options.lateral, options.yaw)]), {}
    for side in ("left", "right"):
        own = table.isel(row=(table["side"] == side).to_numpy())
        if not own.sizes["row"]:
            raise ValueError(f"the {side} wheel does not touch")
        radii[side] = float(own["rolling_radius"][int(np.argmax(own["normal"].to_numpy()))])
    return table, radii


def _creep(case: Case, options: plan.CreepMeasure, _progress: Progress | None) -> tuple[Any, Any]:
    """The patch with the largest normal force, wheelset centred, and the force of the case's creep law on it over that."""
    table = contact_table(case, [(0.0, 0.0)])
    patch = table.isel(row=int(np.argmax(table["normal"].to_numpy())))
    a, b, normal = (float(patch[name]) for name in ("a", "b", "normal"))
    creepage = np.array([[options.longitudinal, options.lateral, options.spin]])
    elastic = case.contact.creep_shear_modulus, case.contact.material.poisson_ratio
    law, friction = core_law(case.contact.creep), case.contact.friction.mu_0
    return patch, _core.creep_forces(creepage, a, b, normal, friction, *elastic, law)[0] / normal


def _test(case: Case, options: plan.AdhesionMeasure, progress: Progress | None) -> tuple[Any, Any]:
    """Measures of the test on track and on the rig that is to reproduce it; the same track is run once per worker."""
    if options.longest is not None:
        case = case.with_changes({"time.duration": options.longest})
    track, rig = _on_track(track_case(case).to_toml()), recorded(case, progress)
    for place, record in (("track", track), ("rig", rig)):
        if not record.completed:
            raise RuntimeError(f"on the {place}: {record.message}")
    return track.measures, rig.measures


@lru_cache(maxsize=64)
def _on_track(text: str) -> TestRecord:
    return recorded(case_from_toml(text, allow_code=True))


def _stop(case: Case, options: plan.WspMeasure, progress: Progress | None) -> tuple[wsp.StopTests]:
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
    return (found,)


@lru_cache(maxsize=64)
def _dry_on_track(text: str) -> TestRecord:
    return wsp.stop_record(case_from_toml(text, allow_code=True), FlatWear(), keep=False).test


OF_PROTECTION = {
    "largest_slip": "largest_slip",
    "longest_lock": "longest_lock_s",
    "dump_cycles": "dump_cycles",
    "odometer_error": "odometer_error_m",
}
"""Number of the slide protection in a test -> measure of its record."""


def _of(support: int, key: str) -> Callable[..., Any]:
    return lambda *records: records[support][key]


def _of_stop(name: str, factor: float) -> Callable[..., Any]:
    return lambda found: factor * found.values(name)[0]


def _largest(name: str) -> Callable[..., Any]:
    return lambda forces, *_: abs(forces[name]).max()


MEASURES: Mapping[str, Measure] = {
    "run": Measure("run", _run, {
        "guiding_force_largest": _largest("guiding_force"),
        "guiding_force_mean": lambda forces, *_: abs(forces["guiding_force"]).mean("time").max(),
        "guiding_force_sum_largest": _largest("guiding_force_sum"),
        "derailment_quotient_largest": _largest("derailment_quotient"),
        "wheel_load_least": lambda forces, *_: forces["wheel_load"].min(),
        "wheel_load_largest": lambda forces, *_: forces["wheel_load"].max(),
        "wear_number_largest": lambda forces, *_: forces["wear_number"].mean("time").max(),
        "lateral_largest": lambda _, lateral, __: abs(lateral).max(),
        "lateral_rms": lambda _, lateral, __: lateral.std("time").max(),
        "energy_relative_residual": lambda _, __, run: run.attrs["energy_relative_residual"],
    }),
    "stability": Measure("stability", _modes, {
        "growth_rate": lambda mode, _: mode["growth_rate"],
        "damping": lambda mode, _: mode["damping"],
        "frequency": lambda mode, _: mode["frequency"],
        "hunting_frequency": lambda _, modes: modes["hunting_frequency"],
        "hunting_damping": lambda _, modes: modes["hunting_damping"],
    }),
    "critical_speed": Measure("critical_speed", _onset, {"linear_critical_speed": lambda speed: speed}),
    "contact": Measure("contact", _contact, {
        "patches": lambda table, _: table.sizes["row"],
        "peak_pressure": lambda table, _: table["peak_pressure"].max(),
        "contact_area": lambda table, _: table["area"].sum(),
        "normal_largest": lambda table, _: table["normal"].max(),
        "contact_angle_largest": lambda table, _: abs(table["angle"]).max(),
        "rolling_radius_difference": lambda _, radii: radii["left"] - radii["right"],
    }),
    "adhesion": Measure("adhesion", _test, {
        "distance_track": lambda track, _: track["distance_m"],
        "distance_rig": lambda _, rig: rig["distance_m"],
        "distance_error": lambda track, rig: rig["distance_m"] / track["distance_m"] - 1.0,
        "tracking_rms": lambda _, rig: rig["tracking_rms"],
        "mean_slip_track": lambda track, _: track["mean_slip"],
        "mean_slip_rig": lambda _, rig: rig["mean_slip"],
        "air_track": lambda track, _: 1e-3 * track["air_litres"],
        "air_rig": lambda _, rig: 1e-3 * rig["air_litres"],
        **{f"{name}_{on}": _of(k, key) for name, key in OF_PROTECTION.items() for k, on in enumerate(("track", "rig"))},
    }),
    "wsp": Measure("wsp", _stop, {
        **{criterion: _of_stop(*one) for criterion, one in wsp.MEASURES.items()},
        "largest_slip": _of_stop("largest_slip", 1.0),
        "odometer_error": _of_stop("odometer_error_m", 1.0),
    }),
    "creep": Measure("creep", _creep, {
        "longitudinal_force": lambda _, force: force[0],
        "lateral_force": lambda _, force: force[1],
        "semi_axis_along": lambda patch, _: patch["a"],
        "semi_axis_across": lambda patch, _: patch["b"],
        "normal_force": lambda patch, _: patch["normal"],
    }),
}  # fmt: skip
"""Kind of a measure in a plan -> what it computes."""
