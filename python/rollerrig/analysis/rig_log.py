"""The log of a rig as its controller measures it: speeds and torques of the axles at the controller's sample times.

Log of a rig, Case -> [read_rig_log] -> Dataset: inputs of the controller, and what the log has to compare them with

Signs   speeds positive in forward running; torques positive where they drive the wheel forward, so that of a brake is negative.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.integrate import cumulative_trapezoid
from scipy.ndimage import uniform_filter1d

from rollerrig.assembly.actuators import friction_brake
from rollerrig.cases import rig_of, wheelsets
from rollerrig.common.arrays import Array
from rollerrig.config import Case, ConfigError
from rollerrig.config.schema.rig_control import ESTIMATORS, BandwidthEstimator
from rollerrig.results import variable
from rollerrig.results.logs import Log, column_of, log_quantity, read_log, time_problem
from rollerrig.results.run_info import ResultsError

RADIUS_ERROR = 0.01
"""Largest part by which the circumference of a wheel may run faster or slower than that of its roller, in the median [-]."""

ROWS_A_PERIOD = 10
"""Rows that a period of the estimator's bandwidth needs: what happens between two rows is a straight line."""

LEAST_PERIODS = 10  # periods of the estimator's bandwidth that a log needs
LEAST_SPEED = 1.0  # speed from which on wheels and rollers are compared [m/s]

MEAN_OVER = 0.5
"""Speeds, and torques, are compared by their means over this time, in which steps of encoders hardly count [s]."""

REFERENCES = {
    "creep_force": ("N", "force on the axle that really acts, forward"),
    "estimated_force": ("N", "force on the axle as the rig estimated it, forward"),
    "estimated_torque": ("N m", "torque on the axle as the rig estimated it"),
    "virtual_speed": ("rad/s", "speed of the axle of the rig's virtual train"),
}
"""What a log may have beside what the controller measures, to be compared with what the replay finds."""


def check_case(case: Case) -> None:
    """Refuse with a ConfigError a case whose rig's controller cannot run on a log."""
    control = rig_of(case)[1]
    if not control.is_ours:
        allowed = "allowed: our own controller, whose estimator and virtual train are known"
        raise ConfigError.of(case.name, "rig_control", "a controller of your own", allowed)
    if not isinstance(control.estimator, BandwidthEstimator):
        allowed = f"allowed: {', '.join(kind for kind in ESTIMATORS if kind != 'exact')}: no log has what really acts"
        raise ConfigError.of(case.name, "rig_control.estimator.kind", repr(control.estimator.kind), allowed)
    if control.estimator.torque != "measured":
        raise ConfigError.of(case.name, "rig_control.estimator.torque", "'commanded'", "allowed: 'measured'")


def read_rig_log(path: str | Path, case: Case) -> xr.Dataset:
    """Read the log of a rig.

    Of each wheelset NAME: `NAME.axle_speed [rad/s]`, `NAME.roller_speed [rad/s]`, `NAME.roller_torque [N m]` of its drive; with
    [brake] `NAME.cylinder_pressure [Pa]` or `NAME.brake_torque [N m]`; with motors `NAME.motor_torque [N m]`; in these units or
    others, speeds also of the circumference [m/s]. A column `measured_...` goes before the one without, of the drive's torque
    where the case has a flange.

    Returns:
        Over `time`, the controller's sample times from the first row on, and `axle`: inputs of `_core.ControllerPlant`, and those
        of REFERENCES that the log has. Attributes: `file`, `rows_apart_s`, `train_speed` at the start [m/s].

    Raises:
        ConfigError: see `check_case`.
        FileNotFoundError: no such file.
        ResultsError: a column is missing, has no or another unit, or holds no numbers; times do not rise, have a gap or are too
            far apart; wheels do not roll on their rollers; a brake that drives.
    """
    check_case(case)
    log = read_log(path)
    time = log_quantity(log, "time", {"s": 1.0})
    _check_time(case, log, time)
    axles, period = [body.name for body in wheelsets(case)], rig_of(case)[1].sample_time
    count = int(np.floor((time[-1] - time[0]) / period + 1e-6)) + 1
    at = time[0] + period * np.arange(count)

    def sampled(values: Array) -> Array:
        return np.stack([np.interp(at, time, column) for column in values.T], axis=1)

    found = {name: (unit, meaning, values) for name, unit, meaning, values in _measured(case, log, axles)}
    data = {name: variable(("time", "axle"), sampled(v), unit, text) for name, (unit, text, v) in found.items()}
    drive = found["drive_torque"][2]
    now, integral = sampled(drive), sampled(cumulative_trapezoid(drive, time, axis=0, initial=0))
    flange = case.sensors.roller_torque is not None  # read at the samples alone
    mean = 0.5 * (now[1:] + now[:-1]) if flange else np.diff(integral, axis=0) / period
    mean = np.concatenate([now[:1], mean])
    data["roller_torque"] = variable(("time", "axle"), mean, "N m", "of the roller's drive, mean since the last sample")
    start = case.vehicle.data.wheel.radius * float(found["axle_speed"][2][0].mean())
    if column_of(log, "train.speed"):
        start = float(log_quantity(log, "train.speed", {"m/s": 1.0})[0])
    about = {"file": log.file, "rows_apart_s": float(np.median(np.diff(time))), "train_speed": start}
    whole = xr.Dataset(data, {"time": variable("time", at - time[0], "s", "since the first row"), "axle": axles}, about)
    _check_rolling(case, whole)
    return whole


def _check_time(case: Case, log: Log, time: Array) -> None:
    slowest = 1.0 / case.rig_control.estimator.bandwidth  # type: ignore[union-attr]
    if len(time) < 3 or time[-1] - time[0] < LEAST_PERIODS * slowest:
        needed = f"needed: {LEAST_PERIODS * slowest:g} s, {LEAST_PERIODS} periods of the estimator's bandwidth"
        raise ResultsError(f"{log.file}: time: {len(time)} rows over {np.ptp(time):g} s; {needed}")
    if problem := time_problem(time):
        raise ResultsError(f"{log.file}: time: {problem}")
    if (apart := float(np.median(np.diff(time)))) > 1.001 * slowest / ROWS_A_PERIOD:
        needed = f"allowed: {slowest / ROWS_A_PERIOD:g} s, 1/{ROWS_A_PERIOD} of a period of the estimator's bandwidth"
        raise ResultsError(f"{log.file}: time: rows are {apart:g} s apart; {needed}")


def _measured(case: Case, log: Log, axles: list[str]) -> Iterator[tuple[str, str, str, Array]]:
    """Name, unit, meaning and values (row, axle) of what the controller measures, and of the references."""
    (rig, control), brake = rig_of(case), case.brake
    turning = {"rad/s": 1.0, "m/s": 1.0 / case.vehicle.data.wheel.radius}
    speed = _per_axle(log, axles, "axle_speed", turning)
    yield "axle_speed", "rad/s", "measured speed of the axle", speed
    rolling = {"rad/s": 1.0, "m/s": 1.0 / rig.roller_radius}
    yield "roller_speed", "rad/s", "measured speed of the roller", _per_axle(log, axles, "roller_speed", rolling)
    # What is read at samples alone stands still in between: where there is no flange, the drive's own torque is better.
    own = case.sensors.roller_torque is None and column_of(log, f"{axles[0]}.roller_torque")
    torque = _per_axle(log, axles, "roller_torque", {"N m": 1.0}, measured=not own)
    yield "drive_torque", "N m", "of the roller's drive now", torque
    if brake is not None and not brake.by_traction_motors:
        yield "brake_torque", "N m", "of the axle's friction brake", _brake_torque(case, log, axles, speed)
    if case.traction is not None or (brake is not None and (brake.electrodynamic or brake.by_traction_motors)):
        yield "motor_torque", "N m", "of the axle's motor", _motor_torque(log, axles)
    others = {
        "axle_load": ("N", "vertical force under the axle", control.loads == "measured"),
        "sand_flow": ("kg/s", "of sand on each rail", case.sanding is not None),
        "track_brake_force": ("N", "of all track brakes against running", case.track_brake is not None),
        "force_of_others": ("N", "of simulated axles", case.train.axles is not None and case.train.axles.simulated),
        **{name: (*about, column_of(log, f"{axles[0]}.{name}")) for name, about in REFERENCES.items()},
    }
    for name, (unit, meaning, there) in others.items():
        if there:
            yield name, unit, meaning, _per_axle(log, axles, name, {unit: 1.0})


def _per_axle(log: Log, axles: list[str], name: str, units: dict[str, float], *, measured: bool = True) -> Array:
    """A column of each axle in SI, if need be as measured, shape (row, axle); one of the train counts for each of them."""
    if name in log.columns:
        return np.repeat(log_quantity(log, name, units)[:, None], len(axles), axis=1)

    prefix = "measured_" if measured and column_of(log, f"{axles[0]}.measured_{name}") else ""
    return np.column_stack([log_quantity(log, f"{axle}.{prefix}{name}", units) for axle in axles])


def _motor_torque(log: Log, axles: list[str]) -> Array:
    """Torque of the motors as a rig logs it, or as a run of ours has it, what drives and what brakes apart."""
    apart = [name for name in ("traction_torque", "electrodynamic_torque") if column_of(log, f"{axles[0]}.{name}")]
    names = ["motor_torque"] if column_of(log, f"{axles[0]}.motor_torque") or not apart else apart
    return np.asarray(np.sum([_per_axle(log, axles, name, {"N m": 1.0}) for name in names], axis=0))


def _brake_torque(case: Case, log: Log, axles: list[str], speed: Array) -> Array:
    """Torque of the brakes, from pressure and nominal friction of the pads as the controller has it, or as it was measured."""
    if column_of(log, f"{axles[0]}.cylinder_pressure") or not column_of(log, f"{axles[0]}.brake_torque"):
        pressure = _per_axle(log, axles, "cylinder_pressure", {"Pa": 1.0})
        brake = friction_brake(case.brake)  # type: ignore[arg-type]
        return np.asarray(np.vectorize(brake.torque, otypes=[float])(pressure, speed))
    torque = _per_axle(log, axles, "brake_torque", {"N m": 1.0})
    for axle, power in zip(axles, (torque * speed).sum(axis=0), strict=True):
        if power > 0.0:
            allowed = "allowed: one against the turning, negative in forward running"
            raise ResultsError(f"{log.file}: {axle}.brake_torque drives the axle; {allowed}")
    return torque


def means(values: Array, period: float) -> Array:
    """Means over MEAN_OVER about each row; rows, along the first axis, are a period [s] apart."""
    return np.asarray(uniform_filter1d(values, max(round(MEAN_OVER / period), 1), axis=0, mode="nearest"))


def _check_rolling(case: Case, data: xr.Dataset) -> None:
    """Refuse with a ResultsError wheels that do not roll on their rollers by the radii of the case."""
    rig, radius = rig_of(case)[0], case.vehicle.data.wheel.radius
    period = float(data["time"][1] - data["time"][0])
    for axle in data["axle"].to_numpy():
        own = data.sel(axle=axle)
        wheel, roller = (
            r * means(own[name].to_numpy(), period)
            for name, r in (("axle_speed", radius), ("roller_speed", rig.roller_radius))
        )
        moving = np.maximum(np.abs(roller), np.abs(wheel)) > LEAST_SPEED
        with np.errstate(divide="ignore"):
            ratio = float(np.median(wheel[moving] / roller[moving])) if moving.any() else 1.0
        if abs(ratio - 1.0) > RADIUS_ERROR:
            raise ResultsError(
                f"{data.attrs['file']}: {axle}: by the case's radii, {radius:g} and {rig.roller_radius:g} m, its circumference "
                f"runs at {ratio:.3g} times the speed of that of its roller; allowed: 1 within {100 * RADIUS_ERROR:g} %, "
                "both speeds positive in forward running"
            )
