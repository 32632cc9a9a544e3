"""Where the loop of the roller drives begins to ring: eigenvalues of the linear loop, and short quiet runs that show it.

Case -> [ring_jobs] -> RingJob -> [ring_run] -> RingPoint: growth rate computed with and without the vehicle, and measured

A quiet run rolls on a dry virtual rail; a light brake application kicks the loop. What then grows or decays above RING_ABOVE
is compared with the least damped eigenvalue there; what decays soon drowns in the slow motions that the push leaves.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from rollerrig.config import Case
from rollerrig.simulation import simulate
from rollerrig.studies.control.loop import Loop, creep_slope, growth, loop_of, rolling_plant, vehicle_plant

Array = NDArray[np.float64]
Progress = Callable[[float, str], None]

RING_ABOVE = 10.0
"""The slow motions of bogie and loop, which are damped, stay below [Hz]."""

FACTORS = tuple(float(f) for f in np.geomspace(1.0, 256.0, 25))
"""On the gains of the PI controller."""

KICK_AT, DURATION = 0.2, 4.0  # [s]
LEAST_WINDOWS = 4
"""Tenths of a second over which a rate is read."""

LARGEST_RING, LEAST_RING = 2e-2, 1e-10
"""Between the two a ring grows as a linear one: above, torque and adhesion saturate; below is rounding [rad/s]."""


@dataclass(frozen=True)
class RingJob:
    """A quiet run with the feedback's gains times a factor."""

    factor: float
    case: Case
    loop: Loop
    creep: float


@dataclass(frozen=True)
class RingPoint:
    """Growth of the least damped motion above RING_ABOVE.

    Attributes:
        factor: on the gains.
        rolling, vehicle: growth rate [1/s] and frequency [Hz] computed with wheel and roller alone, and with the vehicle.
        measured: rate and frequency of what grew in the run; NaN where nothing did, or where it was large from the start.
        amplitude: of what rings at the end [rad/s].
    """

    factor: float
    rolling: tuple[float, float]
    vehicle: tuple[float, float]
    measured: tuple[float, float]
    amplitude: float

    @property
    def rang(self) -> bool:
        """Whether the run rang: it grew, or had grown as far as torque and adhesion let it."""
        return math.isfinite(self.measured[0]) or self.amplitude > 0.1 * LARGEST_RING


def whole_run(case: Case, progress: Progress | None) -> xr.Dataset:
    """A run that Ctrl-C did not cut short: half a test says nothing about a controller.

    Raises:
        KeyboardInterrupt: it did.
    """
    run = simulate(case, progress=progress)
    if run.attrs["status"] == "interrupted":
        raise KeyboardInterrupt
    return run


def quiet_case(case: Case) -> Case:
    """A short run at speed on a dry virtual rail, with a light push by the brake or the drive.

    Raises:
        StartError: no rolling equilibrium was found.
    """
    changes: dict[str, object] = {
        "adhesion": {"rail": "dry"},
        "rig_control.feedback.kind": "proportional_integral",
        "slide_protection": None,
        "wheel_slip_control": None,
        "time.duration": DURATION,
        "time.output_step": max(1e-3, case.bench.step),
    }
    if case.brake is not None:
        changes["brake.demand"] = [[0.0, 0.0], [KICK_AT, 0.0], [KICK_AT + 0.01, "0.2 bar"]]
    if case.traction is not None:
        push = 0.0 if case.brake is not None else 200.0
        changes["traction.demand"] = [[0.0, 0.0], [KICK_AT, 0.0], [KICK_AT + 0.01, push]]
    return case.with_changes(changes)


def ring_jobs(case: Case) -> list[RingJob]:
    """Quiet runs over FACTORS; none where the loop has no equations here."""
    quiet = quiet_case(case)
    creep = creep_slope(quiet)
    loop = loop_of(quiet, creep, sliding=False)
    if loop is None:
        return []
    jobs = []
    for factor in FACTORS:
        scaled = loop.scaled(factor)
        gains = {
            "rig_control.feedback.proportional": scaled.proportional,
            "rig_control.feedback.integral": scaled.integral,
        }
        jobs.append(RingJob(factor, quiet.with_changes(gains), scaled, creep))
    return jobs


def ring_run(job: RingJob, progress: Progress | None = None) -> RingPoint:
    """One quiet run beside the eigenvalues of its loop."""
    run = whole_run(job.case, progress)
    error = (run["virtual_speed"] - run["axle_speed"]).to_numpy()
    measured, amplitude = ringing(run["time"].to_numpy(), error)
    return RingPoint(
        job.factor,
        growth(job.loop, rolling_plant(job.loop.real, job.creep), above=RING_ABOVE),
        growth(job.loop, vehicle_plant(job.case), above=RING_ABOVE),
        measured,
        amplitude,
    )


def ringing(time: Array, error: Array) -> tuple[tuple[float, float], float]:
    """Rate [1/s] and frequency [Hz] at which an error rings above RING_ABOVE, and its RMS at the end.

    Args:
        time: evenly spaced [s], shape (time,).
        error: [rad/s], shape (time, axle).
    """
    step = float(time[1] - time[0])
    sos = butter(8, RING_ABOVE, "highpass", fs=1.0 / step, output="sos")
    after = round((KICK_AT + 0.1) / step)
    high = sosfiltfilt(sos, error, axis=0)[after:]
    window = round(0.1 / step)
    count = len(high) // window
    parts = high[: count * window].reshape(count, window, -1)
    size = np.sqrt(np.mean(parts**2, axis=(1, 2)))
    linear = (size < LARGEST_RING) & (size > 3.0 * max(float(size[:-2].min()), LEAST_RING))
    linear[-2:] = False  # the filter's end
    late = _last_run(linear)[-12:]
    if len(late) < LEAST_WINDOWS:
        return (math.nan, math.nan), float(size[-3])
    middle = (np.arange(count) + 0.5) * window * step
    rate = float(np.polyfit(middle[late], np.log(size[late]), 1)[0])
    piece = high[late[0] * window : (late[-1] + 1) * window]
    shown = piece[:, int(np.argmax(np.abs(piece).max(axis=0)))] * np.exp(-rate * step * np.arange(len(piece)))
    power = np.abs(np.fft.rfft(shown * np.hanning(len(shown)), 8 * len(shown)))
    frequency = float(np.argmax(power) / (8 * len(shown) * step))
    return (rate, frequency) if rate > 0.0 and frequency > RING_ABOVE else (math.nan, math.nan), float(size[-3])


def _last_run(flags: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Indices of the last run of true values that is long enough for a rate, or of the last one."""
    at = np.flatnonzero(flags)
    runs = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1)
    return next((run for run in reversed(runs) if len(run) >= LEAST_WINDOWS), runs[-1])
