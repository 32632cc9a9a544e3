"""Statistics of a brake or traction test: slip, tracking error of the rig, torque ripple, wheel flats.

    run of `simulate` with brake or traction -> [test_record] -> TestRecord: measures, distribution of slip, distance over time

Equations: docs/theory/rig_control.md. A ratio to the speed of a train slower than LEAST_SPEED is not defined: NaN.

Slide protection and wheel-slip control make a limit cycle whose phase differs from start to start: two such tests are compared
by what is counted, averaged or distributed over each of them, never point by point.

The volume worn off a wheel that does not turn is in proportion to the energy, and a segment of its circle under a chord:
V = k E, V = b L^3 / (12 r) for L << r, (H1) and (H2) of docs/theory/wheel_flats.md. Heat, martensite and the rounding of the
flat's ends are left out. On the rig no wheel slides so: the estimate is what the virtual train's wheels would get.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig.analysis.virtual_rail import patch_of, slipperiest_peak
from rollerrig.assembly.model import assemble
from rollerrig.common.arrays import Array, Mask
from rollerrig.config import Case, Rig
from rollerrig.config.schema.brakes import ReservoirAir
from rollerrig.results import COMPLETED
from rollerrig.results.run_info import RunInfo
from rollerrig.results.summary import contact_losses

LEAST_SPEED = 2.0  # below this a train is too slow for errors relative to its speed [m/s]


def wheel_radius(run: xr.Dataset) -> float:
    """Nominal radius of the wheels [m], of the run's own case."""
    return RunInfo.of(run).wheel_radius


def under_test(run: xr.Dataset) -> xr.Dataset:
    """The run with those axles alone that are wheelsets of the vehicle, on rollers or on track; the train may have others."""
    bodies = set(run["body"].to_numpy().tolist())
    names = run["axle"].to_numpy().tolist()
    tested = [name for name in names if name in bodies]
    return run if len(tested) == len(names) else run.sel(axle=tested)


def axle_columns(runs: Mapping[str, xr.Dataset], names: Sequence[str]) -> dict[str, Array]:
    """Columns `NAME_AXLE_RUN` of signals of the axles, `NAME_RUN` of the train's, over `time_s` as long as all runs go."""
    count = min(run.sizes["time"] for run in runs.values())
    columns = {"time_s": next(iter(runs.values()))["time"]}
    for name in names:
        for label, run in ((label, run) for label, run in runs.items() if name in run):
            own = run[name]
            axles = own["axle"].to_numpy() if "axle" in own.dims else ()
            columns |= {f"{name}_{axle}_{label}": own.sel(axle=axle) for axle in axles} or {f"{name}_{label}": own}
    return {name: column.to_numpy()[:count] for name, column in columns.items()}


def slip(run: xr.Dataset) -> xr.DataArray:
    """(wheel speed - train speed) / train speed, over time and axle [-]."""
    return _relative(run, wheel_radius(run) * run["axle_speed"] - run["train_speed"])


def virtual_slip(run: xr.Dataset) -> xr.DataArray:
    """The same of the virtual wheels of a rig."""
    return _relative(run, wheel_radius(run) * run["virtual_speed"] - run["train_speed"])


def tracking_error(run: xr.Dataset) -> xr.DataArray:
    """(wheel speed - virtual wheel speed) / train speed, over time and axle under test [-]."""
    run = under_test(run)
    return _relative(run, wheel_radius(run) * (run["axle_speed"] - run["virtual_speed"]))


def tracking(run: xr.Dataset) -> tuple[float, float]:
    """RMS and largest magnitude of the tracking error [-]; NaN if the train is never fast enough."""
    return rms(tracking_error(run)), largest(tracking_error(run))


def following(run: xr.Dataset) -> dict[str, float]:
    """How the wheels of a rig follow their virtual train and slide on their rollers, by names of the registry."""
    error, greatest = tracking(run)
    return {"tracking_rms": error, "tracking_largest": greatest, **real_sliding(run)}


def real_sliding(run: xr.Dataset) -> dict[str, float]:
    """Sliding of the wheels on rollers or rails, by names of the registry."""
    sliding = run["real_sliding"].to_numpy()
    return {"real_sliding_largest_mps": largest(sliding), "real_sliding_rms_mps": rms(sliding)}


def rms(values: Any) -> float:
    """Root mean square of what is finite; NaN if nothing is."""
    finite = np.asarray(values)[np.isfinite(values)]
    return float(np.sqrt(np.mean(finite**2))) if finite.size else math.nan


def largest(values: Any) -> float:
    """Largest magnitude of what is finite; NaN if nothing is."""
    finite = np.asarray(values)[np.isfinite(values)]
    return float(np.abs(finite).max()) if finite.size else math.nan


def stopped(run: xr.Dataset) -> bool:
    """Whether the train came to a stop."""
    return bool(run.attrs["status"] == "stopped")


def _relative(run: xr.Dataset, speed: xr.DataArray) -> xr.DataArray:
    train = run["train_speed"]
    return (speed / train).where(train > LEAST_SPEED)


RIPPLE_ABOVE = 10.0  # slide protection acts at a few hertz; what is faster is the loop or its noise [Hz]

WINDOW = 0.25  # [s]
PERCENTILE = 95.0


class Ripple(NamedTuple):
    """Ripple of the worst axle's torque."""

    rms: float  # not passed for PERCENTILE of the time [N m]
    spell: float  # the longest in which it stays above a limit, of any axle [s]
    frequency: float  # of most power [Hz]


def torque_ripple(time: Array, torque: Array, limit: float = math.inf) -> Ripple:
    """Ripple above RIPPLE_ABOVE, in windows of a quarter of a second, of torques [N m], shape (time, axle), at even times [s].

    A spell lasts while the RMS of a window is above a limit [N m]. NaN where the run is shorter than two windows or has no torque
    at some time.
    """
    if time.size < 2 or time[-1] - time[0] < 2.0 * WINDOW or not np.isfinite(torque).all():
        return Ripple(math.nan, math.nan, math.nan)
    from scipy.signal import butter, sosfiltfilt, welch  # slow to load, and seldom needed

    step = float(time[1] - time[0])
    window = round(WINDOW / step)
    high = sosfiltfilt(butter(4, RIPPLE_ABOVE, "highpass", fs=1.0 / step, output="sos"), torque, axis=0)
    count = len(high) // window
    windows = np.sqrt(np.mean(high[: count * window].reshape(count, window, -1) ** 2, axis=1))  # of window and axle
    spell = longest = np.zeros(windows.shape[1])
    for above in windows > limit:
        spell = np.where(above, spell + WINDOW, 0.0)
        longest = np.maximum(longest, spell)
    sizes = np.percentile(windows, PERCENTILE, axis=0)
    worst = int(np.argmax(sizes))
    frequency, power = welch(high[:, worst], fs=1.0 / step, nperseg=min(len(high), 4 * window))
    return Ripple(float(sizes[worst]), float(longest.max()), float(frequency[np.argmax(power)]))


SLIP_EDGES = np.append(np.linspace(0.0, 1.0, 51), np.inf)  # edges of the classes of |slip| [-]; the last one is open
SLIDES = 0.10  # an axle that has slid by more than this regains adhesion some time [-]
LOCKED = 0.05  # an axle slower than this part of the train's speed is locked [-]

OSCILLATES = 100.0
"""Torque of a drive from which its ripple counts as an oscillation [N m]: 1 % of the torque that brakes an axle."""

LIMITED = 0.999  # part of the largest torque from which a command is at its limit
SERIES_STEP = 0.1  # step of the distance over time that is kept [s]


@dataclass(frozen=True)
class TestRecord:
    """What is kept of a test."""

    # status, message: how it ended
    status: str
    message: str
    measures: dict[str, float]  # name -> value; NaN where there is none
    # of the time of all axles under test in the classes of SLIP_EDGES, while the train is faster than LEAST_SPEED and
    # brake or traction act; shape (class,), zeros where they never do
    slip_shares: Array
    # time, distance: of the train, every SERIES_STEP and at the end [s, m]
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
    time, tested = run["time"].to_numpy(), under_test(run)
    every = max(1, round(SERIES_STEP / (time[1] - time[0]))) if time.size > 1 else 1
    kept = np.unique([*range(0, time.size, every), time.size - 1])
    last = tested[["dump_cycles", "air"]].isel(time=-1).sum("axle")
    valves = {"dump_cycles": float(last["dump_cycles"]), "air_litres": 1e3 * float(last["air"])}
    measures = {**_train(run), **valves, **_axles(tested), "beyond_peak_s": beyond_peak(tested, case)}
    if case.rig_control is not None and isinstance(case.support.data, Rig):
        measures |= _rig(tested, case.rig_control.feedback.largest, case.support.data.roller_radius)
    return TestRecord(
        run.attrs["status"],
        run.attrs["status_message"],
        {name: float(value) for name, value in measures.items()},
        _slip_shares(tested),
        time[kept],
        run["train_distance"].to_numpy()[kept],
    )


def _train(run: xr.Dataset) -> dict[str, float]:
    """Numbers of the train as a whole, which every axle brakes or pulls."""
    speed, way = run["train_speed"].to_numpy(), run["train_distance"].to_numpy()
    acting = np.flatnonzero(_acting(run))
    begin = acting[0] if acting.size else -1
    run_since = way[-1] - way[begin]
    wrong = run["reference_speed_error"].to_numpy()
    fast, losses = speed > LEAST_SPEED, contact_losses(run)
    return {
        "distance_m": way[-1],
        "duration_s": run.attrs["stopped_at_s"],
        "speed_end_kmh": 3.6 * speed[-1],
        "mean_deceleration_mps2": 0.5 * (speed[begin] ** 2 - speed[-1] ** 2) / run_since
        if run_since > 0.0
        else math.nan,
        "reference_speed_error_rms_mps": rms(wrong[fast]),
        "reference_speed_error_largest_mps": largest(wrong[fast]),
        "odometer_error_m": np.trapezoid(wrong, run["time"].to_numpy()),
        "energy_relative_residual": run.attrs["energy_relative_residual"],
        "contact_lost_s": max((loss.longest_s for loss in losses), default=0.0),
        "contact_lost_total_s": max((loss.total_s for loss in losses), default=0.0),
    }


def _acting(run: xr.Dataset) -> Mask:
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
        "adhesion_at_readhesion": adhesion_at_readhesion(slips, used),
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
    return max((float(time[end - 1] - time[first]) for _, first, end in _locks(run)), default=0.0)


def _locks(run: xr.Dataset) -> Iterator[tuple[int, int, int]]:
    """Number of the axle, first sample and the one after the last of each lock."""
    locked = (slip(run) < LOCKED - 1.0).transpose("axle", "time").to_numpy()
    for axle, own in enumerate(locked):
        yield from ((axle, int(first), int(end)) for first, end in zip(*spells(own), strict=True))


def spells(flags: Mask) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """First sample of each spell of true values, and the one after its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return edges[::2], edges[1::2]


def adhesion_at_readhesion(slips: Array, used: Array) -> float:
    """Largest force of an axle over its load once it has slid by more than SLIDES, at its readhesion [-]; NaN: none has.

    Of |slip|, NaN where the train is too slow, and |creep force| over static axle load, both of shape (time, axle).
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
    ripple = unwanted_ripple(run, roller_radius)
    return {
        **following(run),
        "force_error_rms": rms(force - virtual) / size if size > 0.0 else math.nan,
        "drive_oscillation_nm": ripple.rms,
        "drive_oscillation_spell_s": ripple.spell,
        "drive_limited_share": float(limited.mean()),
        "drive_power_demanded_kw": 1e-3 * largest(run["demanded_roller_power"]),
        "drive_power_limited_s": float(run["drive_power_limited"].isel(time=-1).max()),
        "crown_gravity_largest": largest(gravity) / axle_load(run),
        "roller_torque_largest_nm": largest(run["roller_torque"]),
    }


def unwanted_ripple(run: xr.Dataset, roller_radius: float) -> Ripple:
    """Ripple of the contact's force less the virtual one, times the radius, with the spells above OSCILLATES.

    Zero for a rig that follows, also while slide protection acts fast; an oscillation of the loop on a locked wheel is all of it.
    NaN where outputs are too rare to see it.
    """
    time = run["time"].to_numpy()
    if time.size < 2 or time[1] - time[0] > 1.0 / (4.0 * RIPPLE_ABOVE):
        return Ripple(math.nan, math.nan, math.nan)
    wrong = (run["creep_force"] - run["virtual_force"]).transpose("time", "axle").to_numpy()
    return torque_ripple(time, roller_radius * np.nan_to_num(wrong), OSCILLATES)


def flat_length(energy: float, radius: float, wear: float, width: float) -> float:
    """Length of a flat [m].

        V = k E        (H1)
        L = (12 r V / b)^(1/3)        (H2)

    Of the energy E dissipated under one wheel while it did not turn [J], its radius r [m], the volume k worn off per energy
    [m^3/J] and the width b of the flat across the tread [m].

    Example:
        >>> round(1e3 * flat_length(165e3, radius=0.46, wear=7e-13, width=0.012), 1)
        37.6
    """
    return float(np.cbrt(12.0 * radius * wear * energy / width))


def lock_energies(run: xr.Dataset) -> Array:
    """Energy dissipated under each wheel of an axle in each of its locks, of all axles [J].

    A lock lasts while the axle turns slower than LOCKED of the speed of a train that is not too slow for slips.
    """
    time, train = run["time"].to_numpy(), run["train_speed"].to_numpy()
    sliding = train[:, None] - wheel_radius(run) * run["axle_speed"].transpose("time", "axle").to_numpy()
    power = 0.5 * np.abs(run["creep_force"].transpose("time", "axle").to_numpy() * sliding)  # of one wheel
    # to the first sample at which it turns again, where there is one
    return np.array([np.trapezoid(power[a : b + 1, axle], time[a : b + 1]) for axle, a, b in _locks(run)])


def longest_flat(run: xr.Dataset, wear: float, width: float) -> float:
    """Length of the longest flat that a run leaves, each lock at another place of the tread [m]."""
    energies = lock_energies(run)
    return flat_length(float(energies.max()), wheel_radius(run), wear, width) if energies.size else 0.0
