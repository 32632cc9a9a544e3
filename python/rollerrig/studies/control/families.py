"""What is varied in a comparison of controllers, as data: a family is one entry of FAMILIES.

A family has an axis of values and one or more curves: fixed changes under which the whole axis is run. Changes are dotted keys
of the case with what is to stand there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, get_args

from rollerrig.config import Case
from rollerrig.config.schema.rig_control import Estimator, Feedback
from rollerrig.studies.control.loop import Wheel, default_gains, wheel_of

Changes = Mapping[str, object]
Vary = Callable[[Case, float], Changes]

BENCH_STEP = 1e-3
"""Of the plant under slow controllers [s]."""


@dataclass(frozen=True)
class Family:
    """One thing that is varied.

    Attributes:
        name: for files and the command line.
        title: in words.
        axis: label of the axis, with its unit.
        values: along it, in ascending order.
        vary: changes of a case for one value.
        curves: label -> changes that hold for all values, or a function as `vary` beside it.
        scale: of the axis.
        base: value of the case as it is, where it stands on the axis.
        unit: for the value in words.
        user: whether a user's own controller is tried here too: where our sample time, gains and beliefs mean nothing to it, no.
    """

    name: str
    title: str
    axis: str
    values: tuple[float, ...]
    vary: Vary
    curves: Mapping[str, Changes | Vary]
    scale: Literal["log", "linear"] = "log"
    base: Callable[[Case], float] | None = None
    unit: str = ""
    user: bool = False

    def changes(self, case: Case, curve: Changes | Vary, value: float) -> Changes:
        """What one variant changes."""
        return {**(curve(case, value) if callable(curve) else curve), **self.vary(case, value)}


def _kinds(of: type[Estimator] | type[Feedback]) -> tuple[str, ...]:
    return get_args(of.model_fields["kind"].annotation)


def words(key: str) -> str:
    """A key as people say it."""
    return key.replace("proportional_integral", "PI").replace("_", " ")


ESTIMATORS: dict[str, Changes | Vary] = {
    words(kind): {"rig_control.estimator.kind": kind} for kind in _kinds(Estimator)
}
"""Every kind of estimator that the case file knows."""

FEEDBACKS: dict[str, Changes | Vary] = {
    "PI": {"rig_control.feedback.kind": "proportional_integral"},
    "sliding mode": {"rig_control.feedback.kind": "sliding_mode"},
    "no feedback": {"rig_control.feedback.kind": "none"},
}

USER = "your controller"
"""Label of the user's own controller."""


def _as_it_is(key: str) -> Callable[[Case], float]:
    """The number that stands at a dotted key of a case."""

    def read(case: Case) -> float:
        value: object = case
        for part in key.split("."):
            value = getattr(value, part)
        assert isinstance(value, int | float)
        return float(value)

    return read


def _set_all(changes: Changes) -> Vary:
    return lambda _case, _value: changes


def _set(key: str) -> Vary:
    return lambda _case, value: {key: value}


def _gain(case: Case, factor: float) -> Changes:
    """Gains of all kinds of feedback times a factor."""
    control = case.rig_control
    assert control is not None
    table = control.feedback
    gains = default_gains(wheel_of(case), 2.0 * math.pi * table.bandwidth, table.damping_ratio)
    proportional = gains[0] if table.proportional is None else table.proportional
    integral = gains[1] if table.integral is None else table.integral
    return {
        "rig_control.feedback.proportional": factor * proportional,
        "rig_control.feedback.integral": factor * integral,
        "rig_control.feedback.switching": factor * table.switching,
    }


def _sample_time_changes(value: float) -> Changes:
    """A fast controller needs a finer grid."""
    return {"rig_control.sample_time": value, "bench.step": min(value, BENCH_STEP)}


def _sample_time(_case: Case, value: float) -> Changes:
    return _sample_time_changes(value)


def _encoders(**values: float) -> Changes:
    """The same encoder on axles and rollers."""
    return {f"sensors.{where}.{key}": value for where in ("axles", "rollers") for key, value in values.items()}


COUNTS, WINDOW = 4096.0, 8
"""Of an encoder where another property of it is varied."""


def _wrong(name: str) -> Vary:
    """A controller that takes a number of wheelset or roller for so many per cent more than it is."""
    return lambda case, percent: {f"rig_control.assumed.{name}": getattr(wheel_of(case), name) * (1.0 + 0.01 * percent)}


_PERCENT = (-5.0, -4.0, -3.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0)


REFERENCES: dict[str, Changes] = {
    "as shipped": {},
    "roller drives with 400 Hz": {"rig_control.motor.bandwidth": 400.0},
    "estimator with 100 Hz": {"rig_control.estimator.bandwidth": 100.0},
    "both": {"rig_control.motor.bandwidth": 400.0, "rig_control.estimator.bandwidth": 100.0},
    "both, sampled each 0.2 ms": {
        "rig_control.motor.bandwidth": 400.0,
        "rig_control.estimator.bandwidth": 100.0,
        **_sample_time_changes(2e-4),
    },
    "as shipped, rolling without sliding": {"bench.pure_rolling": True},
    "both, rolling without sliding": {
        "rig_control.motor.bandwidth": 400.0,
        "rig_control.estimator.bandwidth": 100.0,
        "bench.pure_rolling": True,
    },
}
"""Runs that say where the tracking error of the case itself comes from."""

FAMILIES: tuple[Family, ...] = (
    Family(
        name="estimator_bandwidth",
        title="Estimators and their bandwidth",
        axis="bandwidth of the estimator [Hz]",
        values=(1, 2, 5, 10, 20, 50, 100, 200),
        vary=_set("rig_control.estimator.bandwidth"),
        curves=ESTIMATORS,
        base=_as_it_is("rig_control.estimator.bandwidth"),
        unit="Hz",
    ),
    Family(
        name="feedback_gain",
        title="Gains of the feedback",
        axis="factor on the gains [-]",
        values=(0.1, 0.25, 0.5, 1, 2, 4, 8, 16, 32, 64, 128, 256),
        vary=_gain,
        curves={key: FEEDBACKS[key] for key in ("PI", "sliding mode")},
        base=lambda _case: 1.0,
        unit="×",
    ),
    Family(
        name="feedback_bandwidth",
        title="Bandwidth of the PI loop",
        axis="bandwidth of the loop [Hz]",
        values=(0.05, 0.1, 0.2, 0.35, 0.7, 1.4, 2.8, 5.6, 11.2),
        vary=_set("rig_control.feedback.bandwidth"),
        curves={"PI": FEEDBACKS["PI"]},
        base=_as_it_is("rig_control.feedback.bandwidth"),
        unit="Hz",
    ),
    Family(
        name="sample_time",
        title="Sample time",
        axis="sample time of the controller [s]",
        values=(1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2),
        vary=_sample_time,
        curves={**FEEDBACKS, **{f"PI, {key}": fixed for key, fixed in ESTIMATORS.items() if key != "observer"}},
        base=_as_it_is("rig_control.sample_time"),
        unit="s",
    ),
    Family(
        name="drive_bandwidth",
        title="Bandwidth of the roller drives",
        axis="bandwidth of the roller drives [Hz]",
        values=(1, 2, 5, 10, 20, 50, 100, 200),
        vary=_set("rig_control.motor.bandwidth"),
        curves={**FEEDBACKS, "PI, torque as commanded": {"rig_control.estimator.torque": "commanded"}},
        base=_as_it_is("rig_control.motor.bandwidth"),
        unit="Hz",
        user=True,
    ),
    Family(
        name="delay",
        title="Delay of the command",
        axis="delay from sample to torque command [s]",
        values=(0.0, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2),
        vary=_set("rig_control.delay"),
        curves=FEEDBACKS,
        scale="linear",
        base=_as_it_is("rig_control.delay"),
        unit="s",
        user=True,
    ),
    Family(
        name="wrong_belief",
        title="Wrong numbers in the controller",
        axis="error of the controller's number [%]",
        values=_PERCENT,
        vary=_set_all({}),
        curves={words(name): _wrong(name) for name in Wheel.__dataclass_fields__},
        scale="linear",
        base=lambda _case: 0.0,
        unit="%",
    ),
    Family(
        name="wrong_belief_unprotected",
        title="Wrong radii in the controller, with a protection that never acts",
        axis="error of the controller's number [%]",
        values=_PERCENT,
        vary=_set_all({"rig_control.protection.slip": 100.0}),
        curves={words(name): _wrong(name) for name in ("wheel_radius", "roller_radius")},
        scale="linear",
        base=lambda _case: 0.0,
        unit="%",
    ),
    Family(
        name="encoder_counts",
        title=f"Counts of the encoders, differenced over {WINDOW} samples",
        axis="counts per turn, axles and rollers [-]",
        values=(256, 512, 1024, 2048, 4096, 8192, 16384, 65536),
        vary=lambda _case, value: _encoders(counts=value, window=WINDOW),
        curves=ESTIMATORS,
        unit="counts",
        user=True,
    ),
    Family(
        name="encoder_window",
        title=f"Samples over which an encoder of {COUNTS:g} counts is differenced",
        axis="samples [-]",
        values=(1, 2, 4, 8, 16),
        vary=lambda _case, value: _encoders(counts=COUNTS, window=int(value)),
        curves=ESTIMATORS,
        unit="samples",
    ),
    Family(
        name="encoder_jitter",
        title=f"Jitter of encoders of {COUNTS:g} counts, differenced over {WINDOW} samples",
        axis="standard deviation of the edges [counts]",
        values=(0.0, 0.1, 0.2, 0.5, 1.0, 2.0),
        vary=lambda _case, value: _encoders(counts=COUNTS, window=WINDOW, jitter=value),
        curves=ESTIMATORS,
        scale="linear",
        unit="counts",
    ),
    Family(
        name="estimator_bandwidth_encoders",
        title=f"Bandwidth of the estimators behind encoders of {COUNTS:g} counts, differenced over {WINDOW} samples",
        axis="bandwidth of the estimator [Hz]",
        values=(1, 2, 5, 10, 20, 50, 100),
        vary=lambda _case, value: {
            **_encoders(counts=COUNTS, window=WINDOW),
            "rig_control.estimator.bandwidth": value,
        },
        curves=ESTIMATORS,
        unit="Hz",
    ),
)
"""Everything that `rollerrig control` varies."""
