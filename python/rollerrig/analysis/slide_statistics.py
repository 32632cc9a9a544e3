"""Statistics of a brake or traction test that do not depend on the phase of its limit cycle.

run of `simulate` with brake or traction -> [slide_statistics] -> TestRecord: measures, distribution of slip, distance over time

Slide protection and wheel-slip control make a limit cycle whose phase differs from start to start: two such tests are compared
by what is counted, averaged or distributed over each of them, never point by point.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig.analysis.rig_limits import patch_of, slipperiest_peak
from rollerrig.analysis.torque_ripple import RIPPLE_ABOVE, largest_ripple
from rollerrig.analysis.tracking import LEAST_SPEED, following, largest, rms, slip, under_test
from rollerrig.assembly.model import assemble
from rollerrig.config import Case, Rig
from rollerrig.config.schema.pneumatics import ReservoirAir
from rollerrig.results import COMPLETED

Array = NDArray[np.float64]

SLIP_EDGES = np.append(np.linspace(0.0, 1.0, 51), np.inf)
"""Edges of the classes of |slip| [-]; the last one is open."""

SLIDES = 0.10
"""An axle that has slid by more than this regains adhesion some time [-]."""

LOCKED = 0.05
"""An axle slower than this part of the train's speed is locked [-]."""

OSCILLATES = 100.0
"""Torque of a drive from which its ripple counts as an oscillation [N m]: 1 % of the torque that brakes an axle."""

LIMITED = 0.999
"""Part of the largest torque from which a command is at its limit."""

SERIES_STEP = 0.1
"""Step of the distance over time that is kept [s]."""


@dataclass(frozen=True)
class TestRecord:
    """What is kept of a test.

    Attributes:
        status, message: how it ended.
        measures: name -> value; NaN where there is none.
        slip_shares: of the time of all axles under test in the classes of SLIP_EDGES, while the train is faster than
            LEAST_SPEED and brake or traction act; shape (class,), zeros where they never do.
        time, distance: of the train, every SERIES_STEP and at the end [s, m].
    """

    status: str
    message: str
    measures: dict[str, float]
    slip_shares: Array
    time: Array
    distance: Array

    __test__ = False  # the name is no test's

    @property
    def completed(self) -> bool:
        """Whether it went to its end."""
        return self.status in COMPLETED

    @property
    def stopped(self) -> bool:
        """Whether the train came to a stop."""
        return self.status == "stopped"


def test_record(run: xr.Dataset, case: Case) -> TestRecord:
    """The record of a run of `case` on track or rig: of the train, and of its axles under test."""
    kept = _kept(run["time"].to_numpy())
    tested = under_test(run)
    measures = {**_train(run, case), **_valves(tested), **_axles(tested), "beyond_peak_s": beyond_peak(tested, case)}
    if case.rig_control is not None and isinstance(case.support.data, Rig):
        measures |= _rig(tested, case.rig_control.feedback.largest, case.support.data.roller_radius)
    return TestRecord(
        run.attrs["status"],
        run.attrs["status_message"],
        {name: float(value) for name, value in measures.items()},
        _slip_shares(tested),
        run["time"].to_numpy()[kept],
        run["train_distance"].to_numpy()[kept],
    )


def _kept(time: Array) -> NDArray[np.intp]:
    every = max(1, round(SERIES_STEP / (time[1] - time[0]))) if time.size > 1 else 1
    return np.unique([*range(0, time.size, every), time.size - 1])


def _train(run: xr.Dataset, case: Case) -> dict[str, float]:
    """Numbers of the train as a whole, which every axle brakes or pulls; a protection that is not ours has no reference speed."""
    speed, way = run["train_speed"].to_numpy(), run["train_distance"].to_numpy()
    acting = np.flatnonzero(_acting(run))
    begin = acting[0] if acting.size else -1
    run_since = way[-1] - way[begin]
    tables = [one for one in (case.slide_protection, case.wheel_slip_control) if one is not None]
    wrong = run["reference_speed_error"].to_numpy()[speed > LEAST_SPEED]
    if not all(table.is_ours for table in tables):
        wrong = np.full_like(wrong, np.nan)
    return {
        "distance_m": way[-1],
        "duration_s": run.attrs["stopped_at_s"],
        "speed_end_kmh": 3.6 * speed[-1],
        "mean_deceleration_mps2": 0.5 * (speed[begin] ** 2 - speed[-1] ** 2) / run_since
        if run_since > 0.0
        else math.nan,
        "reference_speed_error_rms_mps": rms(wrong),
        "reference_speed_error_largest_mps": largest(wrong),
        "energy_relative_residual": run.attrs["energy_relative_residual"],
    }


def _valves(run: xr.Dataset) -> dict[str, float]:
    """What the slide protection of the given axles did and took."""
    last = run[["dump_cycles", "air"]].isel(time=-1).sum("axle")
    return {"dump_cycles": float(last["dump_cycles"]), "air_litres": 1e3 * float(last["air"])}


def _acting(run: xr.Dataset) -> NDArray[np.bool_]:
    """Whether brake or traction act on any axle, over time."""
    return np.asarray((_torque(run) > 1.0).any("axle"))


def _torque(run: xr.Dataset) -> xr.DataArray:
    """Torque of friction brake and motor on each axle, their magnitudes [N m]."""
    return abs(run["brake_torque"]) + abs(run["traction_torque"]) + abs(run["electrodynamic_torque"])


def axle_load(run: xr.Dataset) -> float:
    """Static load of an axle, from the wheels' forces at the start [N]."""
    return 2.0 * float(run["vertical_force"].isel(time=0).sum()) / run.sizes["wheel"]


def _axles(run: xr.Dataset) -> dict[str, float]:
    slips = abs(slip(run)).transpose("time", "axle").to_numpy()
    torque = _torque(run).transpose("time", "axle").to_numpy()
    used = abs(run["creep_force"]).transpose("time", "axle").to_numpy() / axle_load(run)
    braked = used[torque > 1.0]
    return {
        "mean_slip": float(np.nanmean(slips)) if np.isfinite(slips).any() else math.nan,
        "largest_slip": largest(slips),
        "longest_lock_s": longest_lock(run),
        "regrip_adhesion": regrip_adhesion(slips, used),
        "adhesion_used_mean": float(braked.mean()) if braked.size else math.nan,
        "adhesion_used_largest": float(braked.max()) if braked.size else math.nan,
    }


def beyond_peak(run: xr.Dataset, case: Case) -> float:
    """Time that the axles together spent beyond the peak of the creep curve of the test's most slippery rail [s].

    The slip of the peak grows as the train slows: it is found at some speeds and linear between them. 0 without [adhesion].
    """
    speed, slips = run["train_speed"].to_numpy(), abs(slip(run)).transpose("time", "axle").to_numpy()
    if case.adhesion is None or not (speed > LEAST_SPEED).any():
        return 0.0
    patch, at = patch_of(assemble(case)), np.linspace(LEAST_SPEED, float(speed.max()), 6)
    peak = np.interp(speed, at, [slipperiest_peak(case, patch, float(v))[0] for v in at])
    count = np.count_nonzero(slips > peak[:, None])
    return float(count * (run["time"][1] - run["time"][0])) if count else 0.0


def idle_valves(case: Case) -> list[str]:
    """Sentences on dump valves whose pulses are too short to move them; none of a protection that is not ours."""
    air, table = getattr(case.brake, "air", None), case.slide_protection
    if not isinstance(air, ReservoirAir) or table is None or not table.is_ours:
        return []
    kinds = (
        ("fill", table.pulse_time, "open", air.opening_time),
        ("hold", table.pulse_pause, "close", air.closing_time),
    )
    return [
        f"Dump valves never {move} in stepwise filling: {1e3 * time:g} ms of {command}, {1e3 * dead:g} ms until they {move}"
        for command, pulse, move, dead in kinds
        if (time := max(pulse, air.least_pulse)) <= dead
    ]


def longest_lock(run: xr.Dataset) -> float:
    """Longest time that an axle turned slower than LOCKED of the speed of a train faster than LEAST_SPEED [s]."""
    time = run["time"].to_numpy()
    locked = (slip(run) < LOCKED - 1.0).transpose("axle", "time").to_numpy()
    longest = 0.0
    for axle in locked:
        edges = np.flatnonzero(np.diff(np.concatenate([[False], axle, [False]]).astype(int)))
        for first, end in zip(edges[::2], edges[1::2], strict=True):
            longest = max(longest, float(time[end - 1] - time[first]))
    return longest


def regrip_adhesion(slips: Array, used: Array) -> float:
    """Largest force of an axle over its load once it has slid: what acts on it at its readhesion [-].

    Args:
        slips: |slip|, shape (time, axle); NaN: the train is too slow.
        used: |creep force| over static axle load, same shape.

    Returns:
        The largest of all axles; NaN where none slid by more than SLIDES.
    """
    has_slid = np.logical_or.accumulate(np.nan_to_num(slips) > SLIDES, axis=0)
    return float(used[has_slid].max()) if has_slid.any() else math.nan


def _slip_shares(run: xr.Dataset) -> Array:
    slips = abs(slip(run)).transpose("time", "axle").to_numpy()[_acting(run)]
    counts = np.histogram(slips[np.isfinite(slips)], SLIP_EDGES)[0]
    return np.asarray(counts / max(1, counts.sum()))


def _rig(run: xr.Dataset, largest_torque: float, roller_radius: float) -> dict[str, float]:
    """Numbers of a rig alone: how it follows its virtual train."""
    limits = ("drive_torque_limited", "drive_power_limited", "drive_speed_limited")
    held = sum(run[name].transpose("time", "axle").to_numpy() for name in limits)
    asked = (abs(run["roller_command"]) >= LIMITED * largest_torque).transpose("time", "axle").to_numpy()
    limited = (asked | (np.diff(held, axis=0, prepend=0.0) > 0.0)).any(axis=1)
    fast = run["train_speed"].to_numpy() > LEAST_SPEED
    force, virtual = (run[name].transpose("time", "axle").to_numpy()[fast] for name in ("creep_force", "virtual_force"))
    size, gravity = rms(virtual), run["contact_force"] - run["creep_force"]
    return {
        **following(run),
        "force_error_rms": rms(force - virtual) / size if size > 0.0 else math.nan,
        **drive_oscillation(run, roller_radius),
        "drive_limited_share": float(limited.mean()),
        "drive_power_wanted_kw": 1e-3 * largest(run["wanted_roller_power"]),
        "drive_power_limited_s": float(run["drive_power_limited"].isel(time=-1).max()),
        "crown_gravity_largest": largest(gravity) / axle_load(run),
        "roller_torque_largest_nm": largest(run["roller_torque"]),
    }


def drive_oscillation(run: xr.Dataset, roller_radius: float) -> dict[str, float]:
    """Fast torque on the rollers that the virtual rail does not demand: 95th percentile of the worst axle, longest spell.

    The ripple of the contact's force less the virtual one, times the radius: zero for a rig that follows, also while slide
    protection acts fast; an oscillation of the loop on a locked wheel is all of it. NaN where outputs are too rare to see it.
    """
    time = run["time"].to_numpy()
    found = math.nan, math.nan
    if time.size >= 2 and time[1] - time[0] <= 1.0 / (4.0 * RIPPLE_ABOVE):
        wrong = (run["creep_force"] - run["virtual_force"]).transpose("time", "axle").to_numpy()
        found = largest_ripple(time, roller_radius * np.nan_to_num(wrong), OSCILLATES)
    return {"drive_oscillation_nm": found[0], "drive_oscillation_spell_s": found[1]}
