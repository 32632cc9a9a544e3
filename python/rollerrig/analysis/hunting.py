"""Runs from a lateral disturbance at constant speed: does it decay, or end in a limit cycle?

    Case, speeds -> [run, signals] -> amplitude, frequency and growth rate over speed -> critical speed by disturbance

The critical speed by disturbance is the lowest at which a disturbance of a given size ends in a persistent oscillation. It
depends on that size, and it can lie below the linear one.

What is left of the sideways motion of a run at constant speed: has it decayed, or does the vehicle hunt?

    run -> [lateral_rest] -> the body that moves most at the end, amplitude, frequency, growth rate -> report

It is asked only where nothing but the start disturbs the vehicle: straight and smooth, without actuators, at constant speed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig.analysis.crew import Progress
from rollerrig.analysis.signals import FinalMotion, final_motion, half_waves
from rollerrig.analysis.wheel_rail_forces import curved, irregular
from rollerrig.cases import at_speed, displaced, leading_wheelset
from rollerrig.config import Case
from rollerrig.results import RunInfo, variable
from rollerrig.simulation.run import simulate

LEAST_AMPLITUDE = 2e-5
"""A limit cycle below 0.02 mm is not counted as one [m]."""

SLOWEST_DECAY = 0.2
"""An oscillation that decays faster than this at the end of its run counts as decaying [1/s]."""

SIGNALS = ("lateral", "yaw")


@dataclass(frozen=True)
class HuntingSettings:
    """How the runs of a hunting study are done.

    Attributes:
        disturbance: lateral offset of the leading wheelset at the start [m].
        duration: length of each run [s].
        output_step: interval of the samples [s].
        relative_tolerance: of the integrator.
        absolute_tolerance: of the integrator, for displacements [m].
    """

    disturbance: float = 3e-3
    duration: float = 6.0
    output_step: float = 5e-3
    relative_tolerance: float = 1e-4
    absolute_tolerance: float = 1e-7


@dataclass(frozen=True)
class HuntingRun:
    """One run.

    Attributes:
        speed: running speed [m/s].
        body: whose lateral motion decides.
        motion: Dataset over time and body, with the run's attributes.
        final: the motion at the end of the run.
    """

    speed: float
    body: str
    motion: xr.Dataset
    final: FinalMotion

    @property
    def valid(self) -> bool:
        """Whether the run came to its end; one that did not says neither that the motion persists nor that it decays."""
        return str(self.motion.attrs["status"]) == "ok"

    @property
    def persists(self) -> bool:
        """Whether the run came to its end in an oscillation that persists."""
        return self.valid and self.final.persists(LEAST_AMPLITUDE, SLOWEST_DECAY)

    @property
    def decays(self) -> bool:
        """Whether the run came to its end, and the disturbance had decayed or was decaying."""
        return self.valid and not self.final.persists(LEAST_AMPLITUDE, SLOWEST_DECAY)


def hunting_case(case: Case, speed: float, settings: HuntingSettings) -> Case:
    """The case at one speed [m/s], disturbed and integrated as the settings say."""
    return displaced(at_speed(case, speed), settings.disturbance).with_changes(
        {
            "time.duration": settings.duration,
            "time.output_step": settings.output_step,
            "time.method": "rodas4",
            "time.step": None,
            "time.relative_tolerance": settings.relative_tolerance,
            "time.absolute_tolerance": settings.absolute_tolerance,
        }
    )


def observed_body(case: Case) -> str:
    """The body whose lateral motion stands for the vehicle: the first frame, else the leading wheelset."""
    bodies = case.vehicle.data.bodies_in(case.vehicle.part)
    frames = [b.name for b in bodies if "frame" in b.name]
    return frames[0] if frames else leading_wheelset(case).name


def hunting_run(job: tuple[Case, float, HuntingSettings], progress: Progress | None = None) -> HuntingRun:
    """One run from a disturbance at constant speed.

    Args:
        job: case, running speed [m/s], settings.
        progress: called with the fraction done and a short text.

    Raises:
        KeyboardInterrupt: Ctrl-C came before the end.
        StartError: no state was found from which the run can start.
    """
    case, speed, settings = job
    run = simulate(hunting_case(case, speed, settings), progress=progress)
    if run.attrs["status"] == "interrupted":
        raise KeyboardInterrupt
    body = observed_body(case)
    moving = RunInfo.of(run).moving
    motion = run[list(SIGNALS)].sel(body=moving).copy(deep=True)
    lateral = motion["lateral"].sel(body=body).to_numpy()
    return HuntingRun(speed, body, motion, final_motion(motion["time"].to_numpy(), lateral))


DECAY_SHARE = 0.1
"""Half-waves of a decaying oscillation count for its frequency down to this share of the largest one [1]."""


def decay_frequency(run: HuntingRun) -> float:
    """Frequency of an oscillation while it decays [Hz]; NaN if it does not, or within less than two half-waves."""
    if not run.decays:
        return math.nan
    time, lateral = run.motion["time"].to_numpy(), run.motion["lateral"].sel(body=run.body).to_numpy()
    waves = half_waves(time, lateral, LEAST_AMPLITUDE)
    if len(waves.amplitude) < 2:
        return math.nan
    small = np.flatnonzero(waves.amplitude < DECAY_SHARE * waves.amplitude.max())
    counted = waves.duration[: small[0] if small.size else None]
    return 0.5 * len(counted) / float(counted.sum()) if len(counted) >= 2 else math.nan


def hunting_table(runs: Sequence[HuntingRun], disturbance: float) -> xr.Dataset:
    """Runs as a Dataset over speed: amplitude, frequency, growth rate at the end; whether it persists or decays.

    A run that did not come to its end does neither; amplitude, frequency and growth rate are NaN.
    """
    ordered = sorted(runs, key=lambda run: run.speed)
    ended = [run.final if run.valid else FinalMotion(math.nan, math.nan, math.nan) for run in ordered]
    amplitude = np.array([final.amplitude for final in ended])
    frequency = np.array([final.frequency for final in ended])
    rate = np.array([final.rate for final in ended])
    persists = np.array([run.persists for run in ordered], dtype=np.int8)
    decays = np.array([run.decays for run in ordered], dtype=np.int8)
    decaying = np.array([decay_frequency(run) for run in ordered])
    body = ordered[0].body if ordered else ""
    return xr.Dataset(
        {
            "amplitude": variable("speed", amplitude, "m", f"lateral amplitude of {body} at the end"),
            "oscillation_frequency": variable("speed", frequency, "Hz", "frequency at the end"),
            "decay_frequency": variable("speed", decaying, "Hz", "frequency while it decays"),
            "rate_at_end": variable("speed", rate, "1/s", "growth rate at the end"),
            "persists": variable("speed", persists, "1", "1: the run ends in an oscillation that persists"),
            "decays": variable(
                "speed", decays, "1", "1: the oscillation decays; neither: the run did not come to its end"
            ),
        },
        {"speed": variable("speed", np.array([3.6 * r.speed for r in ordered]), "km/h", "running speed")},
        {"disturbance_mm": 1e3 * disturbance, "body": body},
    )


CONSTANT = 0.01
"""Share of the speed: a run whose speed varies by less is one at constant speed [1]."""


@dataclass(frozen=True)
class LateralRest:
    """Sideways motion in the last third of a run.

    Attributes:
        body: that moves most there.
        largest: distance from its place in the whole run, either side [m].
        final: what is left of its motion [m].
    """

    body: str
    largest: float
    final: FinalMotion

    @property
    def persists(self) -> bool:
        """Whether it goes on at the end: larger than a limit cycle must be to count as one, and not decaying."""
        return self.final.persists(LEAST_AMPLITUDE, SLOWEST_DECAY)


def lateral_rest(run: xr.Dataset) -> LateralRest | None:
    """What is left of the sideways motion.

    Args:
        run: of `simulate`.

    Returns:
        None where that is not to be said: the run did not come to its end, something else than the start disturbs the vehicle,
        it was at rest all the time, or it ended within two half-waves.
    """
    info, speed = RunInfo.of(run), run["speed"].to_numpy()
    if run.attrs["status"] != "ok" or len(speed) < 4 or info.actuators or curved(run) or irregular(run):
        return None
    if float(np.ptp(speed)) > CONSTANT * float(np.abs(speed).max()):
        return None
    bodies = info.moving
    lateral = run["lateral"].sel(body=bodies).transpose("body", "time").to_numpy()
    time = run["time"].to_numpy()
    tail = lateral[:, time >= time[-1] - (time[-1] - time[0]) / 3]
    ranges, largest = 0.5 * np.ptp(tail, axis=1), np.abs(lateral).max(axis=1)
    at = int(ranges.argmax() if ranges.max() >= LEAST_AMPLITUDE else largest.argmax())
    final = final_motion(time, lateral[at])
    if largest[at] < LEAST_AMPLITUDE or (ranges[at] >= LEAST_AMPLITUDE and final.amplitude == 0.0):
        return None
    return LateralRest(bodies[at], float(largest[at]), final)
