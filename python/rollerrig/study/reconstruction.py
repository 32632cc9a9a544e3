"""A measured stop on degraded rails brought into the program: the rail's friction over distance, and the stop on it again.

Case, log of a stop -> [reconstruct] -> friction over distance -> the case on that rail -> [run on track] -> measured and computed
stop over each other; case.toml with that rail, for the rig and for every other study
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import xarray as xr

from rollerrig.analysis import adhesion_reconstruction
from rollerrig.analysis.adhesion_reconstruction import StopLog, read_stop
from rollerrig.analysis.slide_statistics import rms, wheel_radius
from rollerrig.cases import as_case
from rollerrig.common.formatting import percent
from rollerrig.config import Case, Rig
from rollerrig.plot.logs import friction_over_distance, pressures_over_time, stop_over_time
from rollerrig.study.frame import Content, Outcome, Study
from rollerrig.study.jobs import Done, Progress, Round, job, whole_run
from rollerrig.study.options import Option, command
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Picture, Section, Text
from rollerrig.study.runs.adhesion import track_case

ASSUMED = (
    "Mass, brake and creep law are those of the case: an error of the pads' friction is one of the rail's. What a sliding axle "
    "does not say is not known: between such pieces friction is interpolated, before the first and behind the last it stays."
)

LARGEST_DIFFERENCE, LARGEST_APART = 0.02, 0.05
"""Deviation of the computed distance, and of the axles' frictions at a place: with more the map is doubted [-]."""

BEGINS = 0.05  # share of the largest mean pressure from which on the cylinders fill [-]


@dataclass(frozen=True)
class ReconstructionStudy(Study[xr.Dataset]):
    """The rail of a measured stop; attributes as the arguments of `rollerrig.reconstruct`, `log` read."""

    case: Case
    log: StopLog
    piece: float = 10.0

    command = "reconstruct"
    heading = "{case.name}: the rail of the stop {log.file}"
    assumes = (ASSUMED,)
    writes = ("case.toml", "adhesion_map.csv", "stop.nc")
    resumable = False

    def __post_init__(self) -> None:
        """Refuse a case that does not say what a stop's pressures mean."""
        adhesion_reconstruction.check_case(self.case)

    @cached_property
    def rail(self) -> xr.Dataset:
        """Friction over distance."""
        return adhesion_reconstruction.reconstruct(self.case, self.log, self.piece)

    @cached_property
    def measured_case(self) -> Case:
        """The case on that rail, from the speed at which the log begins, and as long at least."""
        length = 1.2 * float(self.log.time[-1] - self.log.time[0])
        return adhesion_reconstruction.with_map(self.case, self.rail).with_changes({
            "motion.speed": f"{float(self.log.train_speed[0])!r} m/s",
            "time.duration": max(self.case.time.duration, length),
        })  # fmt: skip

    def rounds(self, done: Done) -> Iterator[Round]:
        case = self.measured_case
        yield {"stop": job(whole_run, track_case(case) if isinstance(case.support.data, Rig) else case)}

    def collect(self, done: Done) -> xr.Dataset | None:
        return done.get("stop")

    def statuses(self, results: xr.Dataset) -> list[str]:
        return [results.attrs["status"]]

    def numbers(self, results: xr.Dataset) -> dict[str, Any]:
        rail, log, pressure = self.rail, self.log, self.log.pressure.mean(axis=1)
        assert self.case.brake is not None
        time = log.time - log.time[0]
        both = time <= float(results["time"][-1])
        computed = np.interp(time[both], results["time"], results["train_speed"])
        measured_m, computed_m = float(log.distance[-1]), float(results["train_distance"][-1])
        friction = rail["friction"].to_numpy()
        return {
            "case": self.case.name,
            "log": log.file,
            "piece_m": self.piece,
            "pieces": rail.sizes["distance"],
            "pieces_measured": int(rail["measured"].sum()),
            "friction_mean": float(friction.mean()),
            "friction_least": float(friction.min()),
            "friction_largest": float(friction.max()),
            "friction_apart": rail.attrs["axles_apart"],
            "distance_measured_m": measured_m,
            "distance_computed_m": computed_m,
            "distance_difference": computed_m / measured_m - 1.0,
            "demand_begins_s": max((t for t, value in self.case.brake.demand if value == 0.0), default=0.0),
            "pressure_begins_s": float(time[np.argmax(pressure > BEGINS * pressure.max())]),
            "speed_difference_rms_kmh": 3.6 * rms(computed - log.train_speed[both]),
            "status": results.attrs["status"],
        }

    def summary(self, results: xr.Dataset, numbers: Numbers) -> list[str]:
        unchecked = (
            "The log begins with the brake on: whether the wheels have the radius of the case could not be checked, and an error "
            "of it would be taken for slip."
        )
        checked = len(adhesion_reconstruction.unbraked(self.log)) >= adhesion_reconstruction.LEAST_SAMPLES
        told = [f"{one.label}: {one.told(numbers[one.key])}." for one in self.quantities if one.label]
        return [*told, *_doubts(numbers), *(() if checked else (unchecked,))]

    def files(self, results: xr.Dataset, numbers: Numbers) -> Mapping[str, Content]:
        rail = self.rail
        columns = {"distance_m": rail["distance"], "friction": rail["friction"], "measured": rail["measured"]}
        for axle in rail["axle"].to_numpy():
            for name in ("friction_of_axle", "used_adhesion"):
                columns[f"{name.removesuffix('_of_axle')}_{axle}"] = rail[name].sel(axle=axle)
        return {"case.toml": self.measured_case.to_toml(), "adhesion_map.csv": columns, "stop.nc": results}

    def sections(self, results: xr.Dataset, numbers: Numbers) -> list[Section]:
        radius = wheel_radius(results)
        return [
            Section("The rail", [
                Picture("rail", friction_over_distance(self.rail), "Friction at no slip, and the adhesion that each axle used."),
            ]),
            Section("The stop", [
                Picture("stop", stop_over_time(self.log.signals, results, radius), "Solid: measured; dashed: computed."),
                Picture("pressures", pressures_over_time(self.log.signals, results), "Solid: measured; dashed: computed."),
                Text("The case's own slide protection acts in the computed stop: its cycles are of the same kind as the measured "
                     "ones, not the same."),
            ]),
        ]  # fmt: skip


def _doubts(numbers: Numbers) -> Iterator[str]:
    """A sentence where friction over distance is not all that the stop depended on."""
    differs, apart = numbers["distance_difference"], numbers["friction_apart"] or 0.0
    found = []
    if abs(differs) > LARGEST_DIFFERENCE:
        found.append(f"the distance on it differs by {percent(differs, signed=True)}")
    if apart > LARGEST_APART:
        found.append(f"the axles' frictions at a place differ by {percent(apart)}")
    if found:
        yield (
            f"One map does not describe this rail: {' and '.join(found)}. Where an axle cleans the rail by sliding, the next one "
            "finds another; noise of the measured speeds does the same."
        )


@command
def reconstruct(
    case: Case | str,
    log: StopLog | str | Path,
    *,
    piece_m: Annotated[float, Option(least=0.5, most=1000.0)] = 10.0,
    progress: Progress | None = None,
) -> Outcome[xr.Dataset]:
    """A measured stop on degraded rails: the rail's friction over distance, and the case on that rail beside the measurement.

    Args:
        case: with [brake] and [adhesion]: a name of the catalogue or a TOML file.
        log: speeds and brake pressures of the stop, .csv, .mat, .nc or .parquet: time [s], train_speed [m/s] and of each
            wheelset NAME.axle_speed [rad/s] and NAME.cylinder_pressure [Pa], or in other units.
        piece_m: length of a piece of the way with one friction [m].
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case lacks a brake or a rail's condition, or has other brakes beside.
        ResultsError: the log lacks a column or a unit, its times do not rise, or no axle slid.
        ValueError: the model does not take what the log has.
        StartError: the case finds no equilibrium to start from.
    """
    whole = as_case(case)
    stop = log if isinstance(log, StopLog) else read_stop(log, whole)
    return ReconstructionStudy(whole, stop, piece_m).outcome(progress=progress)
