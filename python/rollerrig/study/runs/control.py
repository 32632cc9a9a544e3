"""What is run in a comparison of controllers: FAMILIES, whose entries are data, and what is kept of a run.

A family has an axis of values and one or more curves: fixed changes under which the whole axis is run. Changes are dotted keys
of the case with their new values. Stability of the loop over its gains: eigenvalues of the linear loop with and without the
vehicle.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import xarray as xr

from rollerrig.analysis import loop_stability
from rollerrig.analysis.control_loop import Wheel, creep_slope, loop_of, margins, users_loop, wheel_of
from rollerrig.analysis.slide_statistics import following, largest, slip, under_test, unwanted_ripple
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.cases import rig_of
from rollerrig.config import Case
from rollerrig.config.schema import rig_control as schema
from rollerrig.results.dataset import COMPLETED
from rollerrig.similitude.scale_case import factors_of, scaled_table
from rollerrig.simulation.controllers import ControllerError
from rollerrig.simulation.mechatronics import feedback_gains
from rollerrig.study.jobs import Progress, whole_run

Changes = Mapping[str, object]
Vary = Callable[[Case, float], Changes]

BENCH_STEP = 1e-3  # step of the plant under slow controllers [s]


@dataclass(frozen=True)
class Family:
    """One thing that is varied."""

    name: str  # for files and the command line
    title: str  # for the report
    axis: str  # label of the axis, with its unit
    unit: str  # of a value in a text
    values: tuple[float, ...]  # along the axis, in ascending order
    curves: Mapping[str, Changes | Vary]  # label -> changes that hold for all values, or a function as `vary` beside it
    key: str = ""  # dotted key of the case that is varied, where it is one
    vary: Vary | None = None  # changes of a case for one value; None: the key
    own: float = math.nan  # value of a case that has no such key; NaN: it does not stand on the axis
    scale: Literal["log", "linear"] = "log"
    # whether a user's own controller is run here too; not where the axis is a property of the built-in one
    user: bool = False

    def base(self, case: Case) -> float | None:
        """Value of the case as it is, where it stands on the axis."""
        found = number_at(case, self.key, self.own)
        return None if math.isnan(found) else found

    def changes(self, case: Case, curve: Changes | Vary, value: float) -> Changes:
        """What one variant changes."""
        own = self.vary(case, value) if self.vary is not None else {self.key: value} if self.key else {}
        return {**(curve(case, value) if callable(curve) else curve), **own}

    def text(self, value: float) -> str:
        """A value of the axis with its unit."""
        if self.unit == "s":
            return f"{1e3 * value:.3g} ms"
        if self.unit == "%":
            return f"{value:+.3g} %" if value else "0 %"
        unit = self.unit if self.unit == "×" else f" {self.unit}"
        return (f"{value:,.0f}".replace(",", "\u202f") if value >= 1000 else f"{value:.3g}") + unit


def _of_kind(part: Literal["estimator", "feedback"], table: schema.Estimator | schema.Feedback) -> Vary:
    """An estimator or a feedback: the case's numbers where its own kind has them, for the rest the defaults at its scale."""

    def changes(case: Case, _value: float) -> Changes:
        own = getattr(rig_of(case)[1], part)
        usual = table if case.similitude is None else scaled_table(table, factors_of(case))
        more = {name: getattr(usual, name) for name in type(usual).model_fields if name not in type(own).model_fields}
        key = f"rig_control.{part}"
        return {f"{key}.kind": getattr(table, "kind", None)} | {f"{key}.{name}": value for name, value in more.items()}

    return changes


OBSERVER, PI, SLIDING_MODE = schema.Observer(), schema.ProportionalIntegral(), schema.SlidingMode(kind="sliding_mode")

LIMITED: dict[str, Vary] = {
    table.kind.replace("_", " "): _of_kind("estimator", table)
    for table in (OBSERVER, schema.FilteredDerivative(kind="filtered_derivative"), schema.KalmanFilter(kind="kalman"))
}
"""Estimators of limited bandwidth."""
ESTIMATORS: dict[str, Vary] = {**LIMITED, "exact": _of_kind("estimator", schema.ExactEstimator(kind="exact"))}
"""Every kind of estimator that the case file knows."""

FEEDBACKS: dict[str, Vary] = {
    "PI": _of_kind("feedback", PI),
    "sliding mode": _of_kind("feedback", SLIDING_MODE),
    "no feedback": _of_kind("feedback", schema.NoFeedback(kind="none")),
}

USER = "user's controller"  # label of the user's own controller


def users_controller(user: str) -> Changes:
    """What puts it in place of ours: a class as 'file.py:Class' or 'module:Class', or an FMU."""
    return {f"rig_control.{'fmu' if user.endswith('.fmu') else 'user'}": user}


def number_at(case: Case, key: str, otherwise: float) -> float:
    """The number at a dotted key of a case, or another one where its table has no such key."""
    value: object = case
    for part in key.split("."):
        value = getattr(value, part, otherwise)
    assert isinstance(value, int | float)
    return float(value)


def _pi_gains(case: Case, factor: float) -> Changes:
    """PI feedback with its gains times a factor."""
    proportional, integral = feedback_gains(assemble_with_actuators(case))
    gains = {"proportional": factor * proportional, "integral": factor * integral}
    return {**FEEDBACKS["PI"](case, factor), **{f"rig_control.feedback.{key}": gain for key, gain in gains.items()}}


def _switching(case: Case, factor: float) -> Changes:
    """A sliding mode with its torque times a factor."""
    key = "rig_control.feedback.switching"
    changes = FEEDBACKS["sliding mode"](case, factor)
    return {**changes, key: factor * number_at(case.with_changes(changes), key, SLIDING_MODE.switching)}


def _sample_time(_case: Case, value: float) -> Changes:
    """A fast controller needs a finer grid."""
    return {"rig_control.sample_time": value, "time.sampling_step": min(value, BENCH_STEP)}


def _encoders(**values: float) -> Changes:
    """The same encoder on axles and rollers."""
    return {f"sensors.{where}.{key}": value for where in ("axles", "rollers") for key, value in values.items()}


def _wrong(name: str) -> Vary:
    """A controller that assumes a number of wheelset or roller so many per cent larger than it is."""
    return lambda case, percent: {f"rig_control.assumed.{name}": getattr(wheel_of(case), name) * (1.0 + 0.01 * percent)}


COUNTS, WINDOW = 4096.0, 8  # counts and window of an encoder where another property of it is varied

_PERCENT = (-5.0, -4.0, -3.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0)
_ENCODERS = f"encoders of {COUNTS:g} counts, differenced over {WINDOW} samples"

FAMILIES: tuple[Family, ...] = (
    Family("estimator_bandwidth", "Estimators and their bandwidth", "bandwidth of the estimator [Hz]", "Hz",
           (1, 2, 5, 10, 20, 50, 100, 200), LIMITED, "rig_control.estimator.bandwidth", own=OBSERVER.bandwidth),
    Family("feedback_gain", "Gains of the feedback", "factor on the gains [-]", "×",
           (0.1, 0.25, 0.5, 1, 2, 4, 8, 16, 32, 64, 128, 256), {"PI": _pi_gains, "sliding mode": _switching}, own=1.0),
    Family("feedback_bandwidth", "Bandwidth of the PI loop", "bandwidth of the loop [Hz]", "Hz",
           (0.05, 0.1, 0.2, 0.35, 0.7, 1.4, 2.8, 5.6, 11.2), {"PI": FEEDBACKS["PI"]}, "rig_control.feedback.bandwidth",
           own=PI.bandwidth),
    Family("sample_time", "Sample time", "sample time of the controller [s]", "s", (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2),
           {**FEEDBACKS, **{f"PI, {key}": fixed for key, fixed in ESTIMATORS.items() if key != "observer"}},
           "rig_control.sample_time", _sample_time),
    Family("drive_bandwidth", "Bandwidth of the roller drives", "bandwidth of the roller drives [Hz]", "Hz",
           (1, 2, 5, 10, 20, 50, 100, 200),
           {**FEEDBACKS, "PI, torque as commanded": {"rig_control.estimator.torque": "commanded"}},
           "rig_control.motor.bandwidth", user=True),
    Family("delay", "Delay of the command", "delay from sample to torque command [s]", "s",
           (0.0, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2), FEEDBACKS, "rig_control.delay", scale="linear", user=True),
    Family("assumed_parameters", "Wrong assumed parameters", "error of the assumed parameter [%]", "%", _PERCENT,
           {name.replace("_", " "): _wrong(name) for name in Wheel.__dataclass_fields__}, own=0.0, scale="linear"),
    Family("assumed_radii_unprotected", "Wrong assumed radii, without protection of the rollers",
           "error of the assumed parameter [%]", "%", _PERCENT,
           {name.replace("_", " "): _wrong(name) for name in ("wheel_radius", "roller_radius")},
           vary=lambda _case, _value: {"rig_control.protection.slip": 100.0}, own=0.0, scale="linear"),
    Family("encoder_counts", f"Counts of the encoders, differenced over {WINDOW} samples",
           "counts per turn, axles and rollers [-]", "counts", (256, 512, 1024, 2048, 4096, 8192, 16384, 65536), ESTIMATORS,
           vary=lambda _case, value: _encoders(counts=value, window=WINDOW), user=True),
    Family("encoder_window", f"Samples over which an encoder of {COUNTS:g} counts is differenced", "samples [-]", "samples",
           (1, 2, 4, 8, 16), ESTIMATORS, vary=lambda _case, value: _encoders(counts=COUNTS, window=int(value))),
    Family("encoder_jitter", f"Jitter of {_ENCODERS}", "standard deviation of the edges [counts]", "counts",
           (0.0, 0.1, 0.2, 0.5, 1.0, 2.0), ESTIMATORS,
           vary=lambda _case, value: _encoders(counts=COUNTS, window=WINDOW, jitter=value), scale="linear"),
    Family("estimator_bandwidth_encoders", f"Bandwidth of the estimators behind {_ENCODERS}",
           "bandwidth of the estimator [Hz]", "Hz", (1, 2, 5, 10, 20, 50, 100), LIMITED,
           vary=lambda _case, value: {**_encoders(counts=COUNTS, window=WINDOW), "rig_control.estimator.bandwidth": value}),
)  # fmt: skip
"""Everything that `rollerrig control` varies."""


OUTPUT_STEP = 2e-3  # output step of the runs compared [s]; ripple is seen up to its Nyquist frequency, 250 Hz


def run_variant(case: Case, progress: Progress | None = None) -> dict[str, Any]:
    """The numbers of one run."""
    return run_numbers(whole_run(case, progress), rig_of(case)[0].roller_radius)


def run_numbers(run: xr.Dataset, roller_radius: float) -> dict[str, Any]:
    """The numbers of one run as the registry has them, of the axles under test."""
    run = under_test(run)
    ripple = unwanted_ripple(run, roller_radius)
    last = run.isel(time=-1)
    return {
        "status": run.attrs["status"],
        "ended_s": float(run.attrs["stopped_at_s"]),
        **following(run),
        "largest_slip": largest(slip(run)),
        "roller_torque_largest_nm": float(np.abs(run["roller_torque"]).max()),
        "distance_m": float(last["train_distance"]),
        "dump_cycles": int(last["dump_cycles"].sum()),
        "air_litres": 1e3 * float(last["air"].sum()),
        "ripple_nm": ripple.rms,
        "ripple_hz": ripple.frequency,
    }


TRACKING_LIMIT = 0.01
"""Tracking RMS over train speed from which on a variant fails: the project's aim for the shipped cases [-]."""

RIPPLE_LIMIT = 500.0
"""Fast torque that the virtual rail does not demand [N m] from which on a variant fails: a tenth of what low adhesion asks for,
R T_v. Every assessment names it, see RIPPLE_CRITERION.
"""

RIPPLE_CRITERION = f"torque ripple above {RIPPLE_LIMIT:g} N m RMS for 5 % of the time"
TRACKING_CRITERION = f"tracking error above {100 * TRACKING_LIMIT:g} % RMS"


@dataclass(frozen=True)
class Result:
    """What came out of a run of a curve of a family; its value on the axis is NaN for a reference."""

    family: str
    curve: str
    value: float
    numbers: dict[str, Any]

    @property
    def completed(self) -> bool:
        """Whether the test came to its end."""
        return bool(self.numbers["status"] in COMPLETED)

    @property
    def cause(self) -> str:
        """Why it fails: the status of a run that ended early, 'tracking', 'ripple', or ''."""
        if not self.completed:
            return str(self.numbers["status"])
        if not self.numbers["tracking_rms"] < TRACKING_LIMIT:
            return "tracking"
        return "ripple" if self.numbers["ripple_nm"] > RIPPLE_LIMIT else ""

    @property
    def severity(self) -> tuple[float, float]:
        """Order of results: an ended test before any error, the earlier the worse; then the larger error over its limit.

        A ripple within its limit does not count: it scatters with the switching of valves.
        """
        if not self.completed:
            return math.inf, -float(self.numbers["ended_s"])
        ripple, tracking = self.numbers["ripple_nm"] / RIPPLE_LIMIT, self.numbers["tracking_rms"] / TRACKING_LIMIT
        return max(tracking, ripple if ripple > 1.0 else 0.0), 0.0


SLOW_GROWTH = 1.0  # rate from which a slow motion grows, beyond what answers of a quarter of a second tell of it [1/s]


def loop_case(case: Case) -> Case:
    """The case whose loop is linearised: with the PI feedback, on a dry virtual rail."""
    return case.with_changes({"adhesion": {"rail": "dry"}, "rig_control.feedback.kind": "proportional_integral"})


def loop_numbers(case: Case, user: str | None) -> dict[str, Any] | None:
    """Margins and gain limits of the PI loop as shipped, motion under a user's controller; None: no linear loop."""
    rolling = loop_case(case)
    creep = creep_slope(rolling)
    loop, sliding = (loop_of(rolling, creep, sliding=slides) for slides in (False, True))
    if loop is None or sliding is None:
        return None
    found, vehicle = margins(loop), loop_stability.vehicle_plant(rolling)
    return {
        "crossover_hz": found.phase_frequency,
        "phase_margin_deg": math.degrees(found.phase),
        "gain_margin": found.gain,
        "unstable_from_factor_alone": loop_stability.gain_limit(loop, loop_stability.rolling_plant(loop)),
        "unstable_from_factor": loop_stability.gain_limit(loop, vehicle),
        "unstable_from_factor_sliding": loop_stability.gain_limit(sliding, vehicle),
        "users": users_motion(rolling.with_changes(users_controller(user)), creep) if user else None,
    }


def users_motion(case: Case, creep: float) -> dict[str, Any]:
    """The least damped motion above ABOVE with a user's controller, or a slow one that grows; or why it has none."""
    try:
        loop = users_loop(case, creep)
    except ControllerError as error:
        return {"vehicle_rate": math.nan, "vehicle_hz": math.nan, "no_loop": str(error)}
    vehicle = loop_stability.vehicle_plant(case)
    fast, least_damped = (loop_stability.growth(loop, vehicle, above) for above in (loop_stability.ABOVE, 0.0))
    slow_grows = not fast[0] > 0.0 and least_damped[0] > SLOW_GROWTH
    rate, frequency = least_damped if slow_grows else fast
    return {"vehicle_rate": rate, "vehicle_hz": frequency, "no_loop": ""}
