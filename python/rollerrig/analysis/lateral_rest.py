"""What is left of the sideways motion of a run at constant speed: has it decayed, or does the vehicle hunt?

    run -> [lateral_rest] -> the body that moves most at the end, amplitude, frequency, growth rate -> report

It is asked only where nothing but the start disturbs the vehicle: straight and smooth, without actuators, at constant speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig.analysis.limit_cycle import LEAST_AMPLITUDE, Decision, decide_motion
from rollerrig.analysis.signals import FinalMotion, final_motion
from rollerrig.analysis.track_sections import curved, irregular
from rollerrig.results import RunInfo

CONSTANT = 0.01
"""Share of the speed: a run whose speed varies by less is one at constant speed [1]."""


@dataclass(frozen=True)
class LateralRest:
    """Sideways motion in the last third of a run.

    Attributes:
        body: that moves most there.
        largest: distance from its place in the whole run, either side [m].
        final: what is left of its motion [m].
        decision: whether it persists or decays; 'open' where the run is too short to tell.
    """

    body: str
    largest: float
    final: FinalMotion
    decision: Decision


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
    return LateralRest(bodies[at], float(largest[at]), final, decide_motion(time, lateral[at], ended=True))
