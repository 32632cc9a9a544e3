"""The same test on degraded track and on the dry rig that reproduces it, and how far the two are apart.

Case of a rig with [rig_control] -> [adhesion] -> both runs, fidelity numbers

Numbers of tracking compare the rig's axles with the virtual train that they follow; numbers of fidelity compare the rig with
the run on real track, which also contains what the virtual train leaves out. Equations: docs/theory/rig_control.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.parallel import run_jobs
from rollerrig.analysis.tracking import LEAST_SPEED, distances, slip, stopped, tracking, wheel_radius
from rollerrig.cases import on_track
from rollerrig.config import Case, ConfigError, ConfigProblem, Rig
from rollerrig.simulation import simulate
from rollerrig.studies.adhesion.causes import (
    LATER,
    VARIANT_WORDS,
    begun_later,
    shares,
    spread,
    variant,
    variants_of,
)
from rollerrig.studies.output import finite

Progress = Callable[[float, str], None]


@dataclass(frozen=True)
class Comparison:
    """Results of both runs.

    Attributes:
        case: the rig's.
        track, rig: Datasets of the runs.
        variants: further runs of the rig, by name in VARIANT_WORDS; empty if not asked for.
        track_again, rig_again: the same two tests begun a little later; empty if not asked for.
        interrupted: whether Ctrl-C was pressed.
    """

    case: Case
    track: xr.Dataset
    rig: xr.Dataset
    variants: dict[str, xr.Dataset]
    track_again: tuple[xr.Dataset, ...] = ()
    rig_again: tuple[xr.Dataset, ...] = ()
    interrupted: bool = False


def track_case(case: Case) -> Case:
    """The same test on straight track with the rig's rail head: what the rig is to reproduce.

    Raises:
        ConfigError: the case is not that of a rig with [rig_control].
    """
    if not isinstance(case.support.data, Rig) or case.rig_control is None:
        needed = "needed: a case on rollers with [rig_control], which reproduces a track"
        raise ConfigError([ConfigProblem(case.name, "rig_control", "missing", needed)])
    if case.brake is None and case.traction is None:
        needed = "needed: [brake] or [traction], the test that is done on rail and rig"
        raise ConfigError([ConfigProblem(case.name, "brake", "missing", needed)])
    return on_track(case).model_copy(update={"name": f"{case.name}_track"})


def compare_adhesion(
    case: Case, *, causes: bool = True, processes: int = 2, progress: Progress | None = None
) -> Comparison | None:
    """Run the test on track and on the rig at the same time.

    Args:
        case: of the rig.
        causes: also run the variants that say what a difference comes from, and both tests begun a little later.
        processes: runs at a time.
        progress: called with the fraction done and a text.

    Returns:
        The results; None where Ctrl-C came before either of the two runs had begun to give any.

    Raises:
        ConfigError, StartError: as `simulate`, and `track_case`.
    """
    counterpart = track_case(case)
    jobs = {"track": counterpart, "rig": case}
    if causes:
        jobs.update({name: variant(case, name) for name in variants_of(case)})
        for seconds in LATER:
            jobs[f"track {seconds:g} s later"] = begun_later(counterpart, seconds)
            jobs[f"rig {seconds:g} s later"] = begun_later(case, seconds)
    done = run_jobs(_run, list(jobs.values()), processes=processes, progress=progress, names=list(jobs))
    found = {name: run for name, run in zip(jobs, done.results, strict=True) if run is not None}
    if "track" not in found or "rig" not in found:
        return None
    interrupted = done.interrupted or any("interrupted" in found[name].attrs["status"] for name in ("track", "rig"))
    again = {
        label: tuple(run for name, run in found.items() if name.startswith(f"{label} ")) for label in ("track", "rig")
    }
    variants = {name: run for name, run in found.items() if name in VARIANT_WORDS and name != "rig"}
    return Comparison(case, found["track"], found["rig"], variants, again["track"], again["rig"], interrupted)


def _run(case: Case, progress: Progress) -> xr.Dataset:
    return simulate(case, progress=progress)


# ------------------------------------------------------------------------------------------------------ numbers

KEYS = {
    "case": "name of the case",
    "track.*, rig.*": "the run on degraded track and on the dry rig",
    "*.status, *.status_message": "how the run ended",
    "*.stopped": "whether the train came to a stop before the end of the run",
    "*.distance_m": "run by the train [m]: on the rig the virtual one",
    "*.duration_s": "time at the end of the test [s]",
    "*.speed_end_kmh": "of the train at the end [km/h]",
    "*.largest_slip": "largest |wheel speed - train speed| over train speed, above 2 m/s [-]",
    "*.mean_slip": "mean of the same over all axles and times [-]",
    "*.adhesion_used_mean": "mean of |contact force| over static axle load while brake or traction act [-]",
    "*.adhesion_used_largest": "largest of the same [-]",
    "*.dump_cycles": "times that dump valves opened to vent, all axles",
    "*.air_litres": "air at ambient pressure taken by all cylinders [l]",
    "*.energy_relative_residual": "energy audit [-]",
    "rig.real_sliding_largest_mps, rig.real_sliding_rms_mps": "wheel against roller, the sliding that damages both [m/s]",
    "rig.roller_torque_largest_nm": "of a roller drive [N m]",
    "fidelity.tracking_rms, fidelity.tracking_largest": "wheel speed of rig less virtual train, over train speed [-]",
    "fidelity.tracking_by_own_motion": "part of its variance in proportion to the wheelsets' own motion along the track [-]",
    "fidelity.wheel_speed_rms, fidelity.wheel_speed_largest": "wheel speed of rig less track at the same time, over train "
    "speed, any axle [-]",
    "fidelity.train_speed_largest_mps": "virtual train less train on track at the same time [m/s]",
    "fidelity.distance_relative": "stopping distance of rig over that of track, less 1; null if either did not stop [-]",
    "fidelity.distance_at_end_relative": "the same at the end of the shorter run [-]",
    "fidelity.slip_difference_rms": "slip of rig less slip of track at the same time [-]",
    "fidelity.torque_difference_rms_nm": "brake and traction torque of rig less track [N m]",
    "rig.drive_limited_s": "time during which the command of some roller drive stands at its limit [s]",
    "variants.*.*": "the rig without some of its imperfections, docs/studies.md: tracking error RMS [-], distance over that "
    "of track less 1 [-], dump cycles, mean slip [-]",
    "causes.*": "part of (distance of rig over that of track, less 1) that goes away with it [-]; they add up to the whole",
    "spread.track, spread.rig": "range of the distances of the same test begun 0 to 40 ms later, over their mean [-]: "
    "less than this is chance",
    "targets.*": "the project's aims: tracking RMS below 1 % of train speed, stopping distance within 2 %; null: not known",
}
"""Key of summary.json -> meaning; `*` stands for a name."""


def fidelity(results: Comparison) -> dict[str, Any]:
    """The numbers of a comparison under the keys of KEYS."""
    track, rig = results.track, results.rig
    compared = _compared(results)
    error, largest = tracking(rig)
    distance = compared["distance_relative"]
    return {
        "case": results.case.name,
        "track": _numbers(track),
        "rig": {**_numbers(rig), **_of_rig(rig, results.case)},
        "fidelity": {
            "tracking_rms": finite(error),
            "tracking_largest": finite(largest),
            "tracking_by_own_motion": by_own_motion(rig),
            **compared,
        },
        "variants": {name: _of_variant(results, run) for name, run in results.variants.items()},
        "causes": shares(track, rig, results.variants),
        "spread": {"track": spread([track, *results.track_again]), "rig": spread([rig, *results.rig_again])},
        "targets": {
            "tracking_rms_below_1_percent": bool(error < 0.01) if np.isfinite(error) else None,
            "stopping_distance_within_2_percent": None if distance is None else abs(distance) <= 0.02,
        },
        "rollerrig_version": rig.attrs["rollerrig_version"],
    }


def by_own_motion(run: xr.Dataset) -> float | None:
    """Part of the variance of the tracking error that is in proportion to the wheelsets' own motion along the track, (D10)."""
    moving = run["train_speed"].to_numpy() > LEAST_SPEED
    error = (run["axle_speed"] - run["virtual_speed"]).to_numpy()[moving].ravel()
    own = run["longitudinal_velocity"].sel(body=list(run["axle"].to_numpy())).to_numpy()[moving].ravel()
    if not (error.size and float(np.std(error)) > 0.0 and float(np.std(own)) > 0.0):
        return None
    return float(np.corrcoef(error, own)[0, 1] ** 2)


def _numbers(run: xr.Dataset) -> dict[str, Any]:
    acting = abs(run["brake_torque"]) + abs(run["traction_torque"]) > 1.0
    load = _axle_load(run)
    used = (abs(run["contact_force"]) / load).where(acting)
    slips = abs(slip(run)).to_numpy()
    slips = slips[np.isfinite(slips)]
    last = run.isel(time=-1)
    return {
        "status": run.attrs["status"],
        "status_message": run.attrs["status_message"],
        "stopped": stopped(run),
        "distance_m": float(last["train_distance"]),
        "duration_s": float(run.attrs["stopped_at_s"]),
        "speed_end_kmh": 3.6 * float(last["train_speed"]),
        "largest_slip": float(slips.max()) if slips.size else None,
        "mean_slip": float(slips.mean()) if slips.size else None,
        "adhesion_used_mean": finite(float(used.mean())),
        "adhesion_used_largest": finite(float(used.max())),
        "dump_cycles": int(last["dump_cycles"].sum()),
        "air_litres": 1e3 * float(last["air"].sum()),
        "energy_relative_residual": run.attrs["energy_relative_residual"],
    }


def _axle_load(run: xr.Dataset) -> float:
    """Static load of an axle, from the wheels' forces at the start [N]."""
    return float(run["vertical_force"].isel(time=0).sum()) / run.sizes["axle"]


def _of_rig(run: xr.Dataset, case: Case) -> dict[str, float]:
    sliding = run["real_sliding"].to_numpy()
    assert case.rig_control is not None
    limited = (abs(run["roller_command"].to_numpy()) >= 0.999 * case.rig_control.feedback.largest).any(axis=1)
    return {
        "real_sliding_largest_mps": float(np.abs(sliding).max()),
        "real_sliding_rms_mps": float(np.sqrt(np.mean(sliding**2))),
        "roller_torque_largest_nm": float(np.abs(run["roller_torque"]).max()),
        "drive_limited_s": float(limited.mean()) * float(run["time"][-1]),
    }


def _of_variant(results: Comparison, run: xr.Dataset) -> dict[str, float | None]:
    numbers = _numbers(run)
    way_track, way = distances([results.track, run])
    return {
        "tracking_rms": finite(tracking(run)[0]),
        "distance_relative": way / way_track - 1.0,
        "dump_cycles": numbers["dump_cycles"],
        "mean_slip": numbers["mean_slip"],
    }


def _compared(results: Comparison) -> dict[str, float | None]:
    """Rig against track at the same times, as far as both ran."""
    count = min(results.track.sizes["time"], results.rig.sizes["time"])
    track, rig = (run.isel(time=slice(0, count)) for run in (results.track, results.rig))
    speed = track["train_speed"].to_numpy()
    fast = speed > LEAST_SPEED
    wheel = wheel_radius(rig) * (rig["axle_speed"].to_numpy() - track["axle_speed"].to_numpy())
    relative = wheel[fast] / speed[fast, None]
    slips = slip(rig).to_numpy() - slip(track).to_numpy()
    slips = slips[np.isfinite(slips)]
    torque = sum(rig[name].to_numpy() - track[name].to_numpy() for name in ("brake_torque", "traction_torque"))
    way = track["train_distance"].to_numpy(), rig["train_distance"].to_numpy()
    both = stopped(results.track) and stopped(results.rig)
    ends = [float(run["train_distance"][-1]) for run in (results.track, results.rig)]
    return {
        "wheel_speed_rms": _rms(relative),
        "wheel_speed_largest": finite(float(np.abs(relative).max(initial=0.0))),
        "train_speed_largest_mps": float(np.abs(rig["train_speed"].to_numpy() - speed).max()),
        "distance_relative": ends[1] / ends[0] - 1.0 if both else None,
        "distance_at_end_relative": float(way[1][-1] / way[0][-1] - 1.0) if way[0][-1] > 0 else None,
        "slip_difference_rms": _rms(slips),
        "torque_difference_rms_nm": _rms(np.asarray(torque)),
    }


def _rms(values: np.ndarray[Any, np.dtype[np.float64]]) -> float | None:
    return float(np.sqrt(np.mean(values**2))) if values.size else None
