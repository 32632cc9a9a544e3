"""The log of a rig through the rig's controller: estimated forces with their errors, virtual train, where an estimate is wrong.

Case, log of a rig -> [replay] -> estimates, bands, virtual train -> errors against what the log knows, episodes -> report
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis import controller_replay
from rollerrig.analysis.controller_replay import REASONS, episodes, torque_ratio
from rollerrig.analysis.rig_log import check_case, read_rig_log
from rollerrig.analysis.slide_statistics import rms
from rollerrig.cases import as_case
from rollerrig.common.formatting import number
from rollerrig.config import Case
from rollerrig.plot.logs import forces_over_time, speeds_over_time, torques_over_time
from rollerrig.study.frame import Content, Outcome, Study
from rollerrig.study.jobs import Done, Progress, Round, job
from rollerrig.study.options import command
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Picture, Section, Table, Text

ASSUMED = (
    "Inertias and radii are those that the controller of the case assumes, and the rollers run without losses: the interval "
    "of an estimate does not contain their errors, nor those of phonic wheels and of lags of transducers."
)

OWN = {"force": ("force_at_once", "estimated_force"), "torque": ("torque_taken", "estimated_torque"),
       "virtual_speed": ("virtual_axle_speed", "virtual_speed")}  # fmt: skip
"""Reported difference -> what the replay finds, what the rig itself logged."""

LONGEST_TABLE = 30  # episodes in the report; all of them are in the file


@dataclass(frozen=True)
class ReplayStudy(Study[xr.Dataset]):
    """A log replayed; attributes as the arguments of `rollerrig.replay`, `log` as `read_rig_log` returns it."""

    case: Case
    log: xr.Dataset

    command = "replay"
    heading = "{case.name}: the rig's controller on the log {log.file}"
    assumes = (ASSUMED,)
    writes = ("replay.nc", "doubtful.csv")
    resumable = False

    def __post_init__(self) -> None:
        """Refuse a case whose controller cannot run on a log."""
        check_case(self.case)

    def rounds(self, done: Done) -> Iterator[Round]:
        yield {self.command: job(controller_replay.replay, self.case, self.log)}

    def numbers(self, results: xr.Dataset) -> dict[str, Any]:
        time, about = results["time"].to_numpy(), results.attrs
        axles = [str(axle) for axle in results["axle"].to_numpy()]
        return {
            "case": self.case.name,
            "log": about["file"],
            "duration_s": float(time[-1]),
            "sample_time_ms": 1e3 * float(time[1] - time[0]),
            "rows_apart_ms": 1e3 * about["rows_apart_s"],
            "force_delay_ms": 1e3 * about["force_delay_s"],
            "torque_delay_ms": 1e3 * about["torque_delay_s"],
            "force_noise_n": about["force_noise"],
            "torque_noise_nm": about["torque_noise"],
            "speed_end_kmh": 3.6 * float(results["train_speed"][-1]),
            "axles": {axle: self._of_axle(results.sel(axle=axle)) for axle in axles},
            "differences": {name: float(np.abs(results[ours] - results[theirs]).max()) if theirs in results else None
                            for name, (ours, theirs) in OWN.items()},
        }  # fmt: skip

    def _of_axle(self, own: xr.Dataset) -> dict[str, Any]:
        """Numbers of an axle: what its estimate is worth, and how long it is not to be relied on."""
        radius, period = self.case.vehicle.data.wheel.radius, float(own["time"][1] - own["time"][0])
        good = ~own["doubtful"].sel(reason="start").to_numpy()
        force, band, at_once, found, expected = (
            own[name].to_numpy()[good] for name in ("force", "force_band", "force_at_once", "torque", "torque_expected")
        )
        true = own["creep_force"].to_numpy()[good] if "creep_force" in own else np.full(len(force), np.nan)
        clear = ~own["doubtful"].any("reason").to_numpy()[good]
        inside = (np.abs(force - true) <= band)[clear] if own.attrs["force_noise"] > 0.0 else np.array([])
        doubtful = {str(one): period * float(own["doubtful"].sel(reason=one).sum()) for one in own["reason"].to_numpy()}
        return {
            "force_over_load_largest": float(np.abs(force).max() / own["axle_load"]),
            "band_n": float(np.median(band)) if own.attrs["force_noise"] > 0.0 else None,
            "late_by_n": rms(at_once - force),
            "torque_ratio": float(torque_ratio(found[:, None], expected[:, None])[0]),
            "virtual_speed_difference_rms_kmh": 3.6 * radius * rms((own["virtual_axle_speed"] - own["axle_speed"]).to_numpy()),
            "error_at_once_n": rms(at_once - true),
            "error_n": rms(force - true),
            "share_inside": float(inside.mean()) if inside.size and np.isfinite(true).all() else None,
            **{f"{reason}_s": seconds for reason, seconds in doubtful.items() if reason != "start"},
        }  # fmt: skip

    def summary(self, results: xr.Dataset, numbers: Numbers) -> list[str]:
        late = f"The estimate of the force is {number(numbers['force_delay_ms'], 3)} ms late."
        if not numbers["force_noise_n"]:
            late += " The sensors of the case are exact: no interval is given. State their noise in [sensors]."
        lines = [late]
        for quantity in self.quantities.below("axles.*"):
            found = {axle.replace("_", " "): one[quantity.name] for axle, one in numbers["axles"].items()}
            nothing = (None, 0.0) if quantity.unit == "s" else (None,)  # a doubt that lasts for no time is none
            told = [f"{quantity.told(value)} ({axle})" for axle, value in found.items() if value not in nothing]
            lines += [f"{quantity.label}: {', '.join(told)}."] if told else []
        return lines

    def files(self, results: xr.Dataset, numbers: Numbers) -> Mapping[str, Content]:
        rows: list[list[object]] = [["axle", "reason", "begin_s", "end_s"], *map(list, episodes(results))]
        return {"replay.nc": results.assign(doubtful=results["doubtful"].astype("int8")), "doubtful.csv": rows}

    def sections(self, results: xr.Dataset, numbers: Numbers) -> list[Section]:
        found = [piece for piece in episodes(results) if piece[1] != "start"]
        rows = [[axle.replace("_", " "), number(t0), number(t1), REASONS[reason]] for axle, reason, t0, t1 in found]
        caption = (
            f"The first {LONGEST_TABLE} of {len(rows)}; doubtful.csv has all." if len(rows) > LONGEST_TABLE else ""
        )
        table = Table(("axle", "from [s]", "to [s]", "reason"), rows[:LONGEST_TABLE], caption)
        radius = self.case.vehicle.data.wheel.radius
        return [
            Section("Forces", [
                Picture("forces", forces_over_time(results), "Force on each axle over its static load: adhesion used."),
                self.quantities.list_table(numbers["axles"], "axles.*", "Estimates of each axle."),
            ]),
            Section("Torques", [
                Picture("torques", torques_over_time(results), "Differences: friction of the pads, or a wrong sensor."),
            ]),
            Section("Speeds", [
                Picture("speeds", speeds_over_time(results, radius), "Wheels of the rig and of the virtual train, same torques."),
            ]),
            Section("Doubtful estimates", [table if rows else Text("None.")]),
        ]  # fmt: skip


@command
def replay(case: Case | str, log: xr.Dataset | str | Path, *, progress: Progress | None = None) -> Outcome[xr.Dataset]:
    """The rig's estimators and virtual train on the log of a rig: estimated forces with their errors, where they are wrong.

    Args:
        case: with [rig_control]: a name of the catalogue or a TOML file.
        log: speeds and torques of the rig, .csv, .mat, .nc, .parquet or .npz of `rollerrig serve`: time [s] and of each wheelset
            NAME.axle_speed [rad/s], NAME.roller_speed [rad/s], NAME.roller_torque [N m] and NAME.cylinder_pressure [Pa] or
            NAME.brake_torque [N m], or in other units.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case has no rig's controller of ours, or one that takes what no log has.
        ResultsError: the log lacks a column or a unit, its times do not rise, or its speeds or torques contradict each other.
        ValueError: the controller does not take what the log has.
        StartError: the case finds no equilibrium to start from.
    """
    whole = as_case(case)
    measured = log if isinstance(log, xr.Dataset) else read_rig_log(log, whole)
    return ReplayStudy(whole, measured).outcome(progress=progress)
