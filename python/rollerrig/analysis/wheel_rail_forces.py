"""What engineers read off a run: wheel forces, their quotients and limits, unloading, wear number; sections of the line.

    run -> [track_sections] -> which output times belong to which section: straights, transitions, curves by their radius
    run -> [wheel_forces] -> Y, Q, sum of Y, Y/Q, wear number over time -> [filtered] -> as EN 14363 assesses them

A vehicle is in a straight or a curve from where its last wheelset has come in until its first one leaves; between, it is in a
transition, where nothing is quasi-static.

Signs (EN 14363): forces are those of the wheel on the rail.
    Y    guiding force of a wheel, parallel to the track's plane: positive outwards, as the flange pushes its rail
    Q    wheel load, normal to the track's plane: positive downwards
    ΣY   of a wheelset: positive to the left, Y_left - Y_right; it shifts the track
On a rig the rollers are the rails.

    Y/Q  ≤  (tan δ - μ) / (1 + μ tan δ)        Nadal: the flange, steepest at δ, does not climb          (R1)
    |ΣY| ≤  k (10 kN + 2 Q0 / 3)               Prud'homme: the track does not shift, Q0 per wheel         (R2)
    r.m.s. of ΣY over 100 m ≤ half of (R2)     the vehicle is stable; f_0 ± 2 Hz, f_0 the frequency of its oscillation
    Tγ   =  -(T_x ν_x + T_y ν_y + M φ)         per patch [N]: heat per metre                              (R3)

with creep forces T, spin moment M on the wheel and creepages ν, φ of the wheel against the rail. Tγ V is the power that the
creep forces turn into heat, V the rolling speed that creepages are divided by.

Source: EN 14363:2016; J. Nadal, Annales des Mines 10 (1896); A. Prud'homme, Revue générale des chemins de fer (1967);
    T. G. Pearce, N. D. Sherratt, Wear 144 (1991) for the wear number.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig.analysis.signals import away_from_ends, low_pass, narrow_band, sliding_mean
from rollerrig.common.arrays import Array, Mask
from rollerrig.results.dataset import DIMENSION, MOST_READINGS, PREFIX, READING_STEP, readings_of
from rollerrig.results.run_info import RunInfo, TrackSegment
from rollerrig.track import nadal_limit

WHOLE_RUN = "whole run"

STEADY_SPEED = 0.05
"""Part of its mean by which the speed may range in a section with quasi-static values; EN 14363: 5 km/h either side."""

TEST_ZONES = ((600.0, 2), (400.0, 3), (250.0, 4))
"""Radius [m] and test zone of curves above it; of 400 and 250 m including it. Straights are zone 1."""


@dataclass(frozen=True)
class TrackSection:
    """A part of a run."""

    name: str  # number in the order of the run and what it is; unique
    constant: bool  # whether curvature, cant and speed are constant there, so that it has quasi-static values
    within: Mask  # which output times belong to it, shape (time,)


def track_sections(run: xr.Dataset) -> list[TrackSection]:
    """The sections that a run has come through, in their order; the whole run is the only one without curves and on a rig.

    Args:
        run: results of `simulate` or `load_run`.
    """
    info = RunInfo.of(run)
    speed, distance = run["speed"].to_numpy(), run["distance"].to_numpy()
    if len(info.segments) < 2:
        everywhere = np.ones(run.sizes["time"], dtype=bool)
        name = "rollers" if info.support == "rig" else in_words(info.segments[0]) if info.segments else "straight"
        return [TrackSection(name, _steady(speed), everywhere)]
    constant = [segment for segment in info.segments if segment.kind != "transition"]
    numbers = _numbers(info, constant, distance)
    found: list[TrackSection] = []
    for number in np.unique(numbers).tolist():
        within = numbers == number
        segment = constant[number // 2] if number % 2 == 0 else None
        name = f"{len(found) + 1} {in_words(segment) if segment else 'transition'}"
        found.append(TrackSection(name, segment is not None and _steady(speed[within]), within))
    return found


def section_names(run: xr.Dataset) -> NDArray[np.str_]:
    """Name of the section at every output time, shape (time,)."""
    names = np.full(run.sizes["time"], "", dtype=object)
    for section in track_sections(run):
        names[section.within] = section.name
    return names.astype(str)


def _numbers(info: RunInfo, constant: Sequence[TrackSegment], distance: Array) -> NDArray[np.int_]:
    """2 k where the vehicle is wholly in the constant segment k, 2 k + 1 on its way from there to the next, -1 before all."""
    places = [body.position[0] for body in info.wheelsets]
    rear, front = distance + min(places), distance + max(places)
    ends = [math.inf if segment is info.segments[-1] else segment.end for segment in constant]
    left = np.searchsorted(ends, front, side="left")
    numbers = 2 * left - 1
    for k, segment in enumerate(constant):
        come = (rear >= segment.start) | (segment is info.segments[0])
        numbers = np.where(come & (left == k), 2 * k, numbers)
    return np.asarray(numbers)


def in_words(segment: TrackSegment) -> str:
    """`straight`, or a curve with its radius, direction and test zone."""
    if segment.curvature == 0.0:
        return "straight"
    radius = 1.0 / abs(segment.curvature)
    side = "left" if segment.curvature > 0 else "right"
    zone = test_zone(radius)
    return f"curve R {radius:.0f} m {side}" + (f", test zone {zone}" if zone else "")


def test_zone(radius: float) -> int | None:
    """Test zone of EN 14363 of curves of a radius [m]; None below 250 m."""
    large = TEST_ZONES[0]
    if radius > large[0] * (1.0 + 1e-9):
        return large[1]
    return next((zone for least, zone in TEST_ZONES[1:] if radius >= least * (1.0 - 1e-9)), None)


def _steady(speed: Array) -> bool:
    return not len(speed) or float(np.ptp(speed)) <= STEADY_SPEED * abs(float(speed.mean()))


def curved(run: xr.Dataset) -> bool:
    """Whether the run met a curve or cant."""
    return "curvature" in run and bool((run["curvature"] != 0.0).any() or (run["cant"] != 0.0).any())


def irregular(run: xr.Dataset) -> bool:
    """Whether rails or rollers were irregular."""
    return "rail_lateral" in run and bool((run["rail_lateral"] != 0.0).any() or (run["rail_vertical"] != 0.0).any())


FORCE_CUTOFF = 20.0
"""Low pass of Y, Q, Y/Q and ΣY [Hz]."""

INSTABILITY_LENGTH = 100.0
"""Distance over which the r.m.s. of ΣY says whether a vehicle is stable [m]."""

INSTABILITY_BAND, SLOWEST, FASTEST = 2.0, 0.4, 18.0
"""Half the width of its band pass, least lower end and largest centre [Hz]."""

PRUDHOMME_FACTOR = 1.0
"""k in (R2): 1 for locomotives, power cars and passenger coaches; 0.85 for freight wagons."""

QUOTIENT_LIMIT = 0.8
"""Largest sliding mean of Y/Q that EN 14363 allows, whatever flange and friction [-]."""


def prudhomme_limit(wheel_load: float, factor: float = PRUDHOMME_FACTOR) -> float:
    """Largest sum of guiding forces of a wheelset that does not shift the track (R2) [N].

    Args:
        wheel_load: static load of one wheel Q0 [N].
        factor: k [-].

    Example:
        >>> round(prudhomme_limit(54.55e3))
        46367
    """
    return factor * (10e3 + 2.0 * wheel_load / 3.0)


def wheel_forces(run: xr.Dataset, *, prudhomme_factor: float = PRUDHOMME_FACTOR) -> xr.Dataset:
    """Forces, quotients, unloading and wear number of every wheel of a run, unfiltered.

    Args:
        run: results of `simulate` or `load_run`; for a part of it hand in `run.sel(time=slice(2.0, None))`.
        prudhomme_factor: k in (R2) [-].

    Returns:
        Over time and wheel: guiding_force Y, wheel_load Q [N], derailment_quotient Y/Q (NaN where unloaded),
        wheel_unloading (Q0 - Q)/Q0, wear_number Tγ [N]; over time, wheel and patch: patch_wear_number [N]; over time and
        wheelset: guiding_force_sum ΣY [N]; over time: distance [m] (on a rig that of the rollers' surface). The same but
        for patches between the output times, over `reading_time` and with names that begin with `reading_`: what
        `filtered` filters; absent where the run has no readings.
        The coordinate `section` over time names the straight, transition or curve that the vehicle is in.
        Without time: static_wheel_load Q0 [N] per wheel, guiding_force_sum_limit [N] per wheelset, nadal_limit [-].
        Signs: see the module's text.

    Example:
        >>> import rollerrig as rr
        >>> case = rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.2 s", "disturbance": []})
        >>> read = rr.wheel_forces(rr.simulate(case))
        >>> read["wheel_load"].isel(time=-1).round(-2).to_numpy().tolist()  # both wheels carry alike
        [54300.0, 54300.0]
        >>> bool(abs(read["guiding_force_sum"]).max() < 1.0)  # centred: both wheels push outwards alike
        True
    """
    info = RunInfo.of(run)
    loads = {body.name: body.wheel_load or 0.0 for body in info.wheelsets}
    wheelsets = list(loads)
    wheels = [str(wheel) for wheel in run["wheel"].to_numpy()]
    sides = xr.DataArray([1.0 if wheel.endswith("_left") else -1.0 for wheel in wheels], {"wheel": wheels}, "wheel")
    static = xr.DataArray([loads[wheel.rpartition("_")[0]] for wheel in wheels], {"wheel": wheels}, "wheel")
    variables = _over_time(run, sides, static, wheelsets)
    variables["patch_wear_number"] = run["patch_wear_number"]
    readings = readings_of(run)
    if readings is not None:
        between = _over_time(readings, sides, static, wheelsets)
        variables |= {f"{PREFIX}{name}": values.rename(time=DIMENSION) for name, values in between.items()}
    variables["static_wheel_load"] = _named(static, "N", "static wheel load Q0")
    limits = [prudhomme_limit(loads[name], prudhomme_factor) for name in wheelsets]
    variables["guiding_force_sum_limit"] = _named(
        xr.DataArray(limits, {"wheelset": wheelsets}, "wheelset"), "N", "Prud'homme's limit of ΣY"
    )
    limit = nadal_limit(info.flange_angle, info.friction)
    variables["nadal_limit"] = _named(xr.DataArray(limit), "1", "Nadal's limit of Y/Q")
    attributes = {
        "title": run.attrs["title"],
        "case": run.attrs["case"],
        "flange_angle_rad": info.flange_angle,
        "friction": info.friction,
        "prudhomme_factor": prudhomme_factor,
    }
    section = xr.Variable("time", section_names(run), {"long_name": "section of the run"})
    return xr.Dataset(variables, attrs=attributes).assign_coords(section=section)


def _over_time(
    run: xr.Dataset, sides: xr.DataArray, static: xr.DataArray, wheelsets: Sequence[str]
) -> dict[str, xr.DataArray]:
    """What changes along a run or its readings; sides: left +1, right -1."""
    to_the_left = -run["lateral_force"]  # of the wheel on the rail
    guiding, load = to_the_left * sides, run["vertical_force"]
    sums = [to_the_left.sel(wheel=[f"{name}_left", f"{name}_right"]).sum("wheel") for name in wheelsets]
    summed = xr.concat(sums, xr.DataArray(list(wheelsets), dims="wheelset", name="wheelset"))
    return {
        "guiding_force": _named(guiding, "N", "guiding force Y on the rail, positive outwards"),
        "wheel_load": _named(load, "N", "wheel load Q on the rail, positive downwards"),
        "derailment_quotient": _named((guiding / load).where(load > 0.0), "1", "Y/Q"),
        "wheel_unloading": _named(1.0 - load / static, "1", "wheel unloading (Q0 - Q)/Q0"),
        "guiding_force_sum": _named(
            summed.transpose("time", "wheelset"), "N", "sum of guiding forces ΣY on the track, positive to the left"
        ),
        "wear_number": _named(run["wear_number"], "N", "wear number Tγ of the wheel"),
        "distance": _named(run["distance"], "m", "distance run"),
    }


def filtered(read: xr.Dataset) -> xr.Dataset:
    """The forces as EN 14363 assesses them, at the output times.

    Y, Q and the wear number: low pass 20 Hz, the latter cut at 0 where it overshoots; NaN within 50 ms of both ends, where
    they depend on how the run goes on. Y/Q and ΣY: low pass 20 Hz, then the sliding mean over 2 m, which is NaN within a
    further 1 m. The instability criterion `guiding_force_sum_rms`: ΣY through f_0 ± 2 Hz, then the r.m.s. over 100 m, in a run
    of that length. Wheel unloading is that of the filtered load. Filtered are the readings between the output times where the
    run has them.

    Args:
        read: what `wheel_forces` returns.

    Returns:
        The same variables over `time`, without those of patches and readings; each says in its attribute `filter` what
        was done to it.

    Raises:
        ValueError: the steps of what is filtered are too coarse, or the run too short.
    """
    dense, kept = unfiltered(read), at_output_times(read)
    if (
        kept.sizes["time"] == dense.sizes["time"] > 1
        and float(np.diff(kept["time"][:2])[0]) > MOST_READINGS * READING_STEP
    ):
        raise ValueError(
            f"they are filtered from readings between the outputs, which a run has with an output_step of at most "
            f"{1e3 * MOST_READINGS * READING_STEP:g} ms"
        )
    names = ("guiding_force", "wheel_load", "wear_number", "guiding_force_sum")
    through = {name: away_from_ends(low_pass(dense[name], FORCE_CUTOFF), FORCE_CUTOFF) for name in names}
    load = through["wheel_load"]
    through["wheel_unloading"] = dense["wheel_unloading"].copy(data=1.0 - load / read["static_wheel_load"])
    if float(np.ptp(dense["distance"].to_numpy())) >= INSTABILITY_LENGTH:
        through["guiding_force_sum_rms"] = _instability(dense)
    quotient = (through["guiding_force"] / load).where(load > 0.0)
    through["derailment_quotient"] = dense["derailment_quotient"].copy(data=quotient)
    for name, values in through.items():
        done = str(values.attrs.get("filter", f"{FORCE_CUTOFF:g} Hz"))
        if name in ("derailment_quotient", "guiding_force_sum"):
            values, done = sliding_mean(values, dense["distance"]), f"{done}, mean over 2 m"
        if name == "wear_number":  # a heat: the filter's overshoot below its least value is no part of it
            values, done = values.clip(min=min(0.0, float(dense[name].min()))), f"{done}, not below 0"
        through[name] = values.sel(time=kept["time"]).assign_attrs(filter=done)
    return kept.assign(through)


def _instability(dense: xr.Dataset) -> xr.DataArray:
    """Moving r.m.s. of ΣY in a band about the frequency at which it oscillates most."""
    force, time = dense["guiding_force_sum"], dense["time"].to_numpy()
    duration = float(time[-1] - time[0])
    varying = (force - force.mean("time")).transpose("time", "wheelset").to_numpy()
    spectrum = (np.abs(np.fft.rfft(varying * np.hanning(len(time))[:, None], axis=0)) ** 2).sum(axis=1)
    frequency = np.fft.rfftfreq(len(time), duration / (len(time) - 1))
    within = (frequency >= SLOWEST) & (frequency <= FASTEST)
    centre = float(frequency[within][spectrum[within].argmax()]) if within.any() else FASTEST
    low, high = max(centre - INSTABILITY_BAND, SLOWEST, (1.0 + 1e-9) / duration), centre + INSTABILITY_BAND
    square = narrow_band(force, low, high) ** 2
    rms = sliding_mean(square, dense["distance"], INSTABILITY_LENGTH).clip(min=0.0) ** 0.5
    meaning = "instability criterion: moving r.m.s. of ΣY"
    return _named(rms, "N", meaning).assign_attrs(filter=f"{low:.1f} to {high:.1f} Hz, r.m.s. over 100 m")


def at_output_times(read: xr.Dataset) -> xr.Dataset:
    """What `wheel_forces` returns, of wheels and wheelsets at the output times only."""
    others = [str(name) for name in read.variables if str(name).startswith(PREFIX)]
    return read.drop_vars(["patch_wear_number", *others])


def unfiltered(read: xr.Dataset) -> xr.Dataset:
    """What `wheel_forces` returns, of wheels and wheelsets, over the times of the readings where the run has them."""
    if f"{PREFIX}distance" not in read:
        return at_output_times(read)
    between = [str(name) for name in read.data_vars if str(name).startswith(PREFIX)]
    whole = read[between].rename({name: name.removeprefix(PREFIX) for name in between} | {DIMENSION: "time"})
    return at_output_times(read).drop_dims("time").merge(whole).assign_attrs(read.attrs)


STATISTICS = {
    "quasi_static": "median over a section of constant curvature, cant and speed",
    "percentile_0_15": "0.15 % of the values are smaller",
    "percentile_99_85": "99.85 % of the values are smaller",
    "rms": "root mean square, about zero",
    "largest": "largest magnitude",
}
"""Statistic -> meaning."""


def statistics(values: xr.DataArray) -> xr.DataArray:
    """Quasi-static value, percentiles, r.m.s. and largest magnitude over time.

    Args:
        values: any quantity with the dimension `time`; NaN is left out.

    Returns:
        The other dimensions, and `statistic` with the names of STATISTICS; NaN where no value exists.
    """
    data = np.moveaxis(values.to_numpy(), values.get_axis_num("time"), 0)
    rows = [_statistics_of(data[(slice(None), *column)]) for column in np.ndindex(*data.shape[1:])]
    others = [str(dim) for dim in values.dims if dim != "time"]
    coordinates = {dim: values[dim] for dim in others if dim in values.coords} | {"statistic": list(STATISTICS)}
    shape = (*data.shape[1:], len(STATISTICS))
    return xr.DataArray(np.reshape(rows, shape), coordinates, [*others, "statistic"], attrs=values.attrs)


def _statistics_of(series: Array) -> list[float]:
    known = series[np.isfinite(series)]
    if not known.size:
        return [math.nan] * len(STATISTICS)
    low, middle, high = np.percentile(known, [0.15, 50.0, 99.85])
    return [middle, low, high, float(np.sqrt(np.mean(known**2))), float(np.abs(known).max())]


def _named(values: xr.DataArray, units: str, meaning: str) -> xr.DataArray:
    return values.drop_attrs().assign_attrs(units=units, long_name=meaning)
