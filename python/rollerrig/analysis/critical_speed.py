"""Critical speed by its three definitions, each under its own name in every output, and what rollers change of it.

    linear             lowest speed at which an oscillatory mode of the linearised vehicle begins to grow
    by disturbance     lowest speed at which a perturbation of a given size persists: runs at constant speed, bracketed
    by continuation    lowest speed of a stable limit cycle: speed stepped down, each run begun with the state of the one before

    Case, speeds -> [modes over speed | runs from a disturbance] -> LinearCriticalSpeed | CriticalSpeedByDisturbance
    case on a rig -> [cases with other radii, with effects switched off] -> linear critical speeds -> tables

A limit cycle exists only above the fold of its branch, and above the linear critical speed every perturbation grows: for a
subcritical bifurcation

    by continuation  <=  by disturbance  <=  linear

each within the width to which it was found.

Equations: docs/theory/equilibrium_and_linearisation.md, (L7) and section Limit cycles.
Source: O. Polach, On non-linear methods of bogie stability assessment, Proc. IMechE F 220 (2006).
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.hunting import HuntingRun, hunting_table
from rollerrig.analysis.mode_table import Crossing, first_onset, growing_at_start, modes_over_speed, zero_crossings
from rollerrig.analysis.modes import Lineariser
from rollerrig.cases import on_rig, on_track, part_of
from rollerrig.config import Case
from rollerrig.simulation.run import Progress
from rollerrig.simulation.starting_state import StartError

HIGHEST_KMH = 600.0
"""Where a linear critical speed is looked for at most, unless higher speeds are asked for [km/h]: no train runs faster."""


@dataclass(frozen=True)
class LinearCriticalSpeed:
    """Linear critical speed of one case in a range."""

    onset: Crossing | None = None  # the lowest speed above which an oscillation grows; None: there is none
    grows_at_start: tuple[str, ...] = ()  # names of the modes that grow already at the lowest speed
    problem: str = ""  # why nothing could be computed; '' if it could
    searched_to_kmh: float = math.nan  # highest speed looked at [km/h]

    @property
    def speed_kmh(self) -> float:
        """The linear critical speed [km/h]; NaN if there is none."""
        return math.nan if self.onset is None else 3.6 * self.onset.speed


def scan_linear(
    case: Case | Lineariser, speeds_kmh: Sequence[float], above: bool = False, progress: Progress | None = None
) -> LinearCriticalSpeed:
    """Linear critical speed of one case; a missing equilibrium at the speeds asked for is returned as `problem`, not raised.

    Args:
        case: the case, or its lineariser.
        speeds_kmh: range of speeds [km/h], rising; where they are far apart, further ones are put between them.
        above: look up to HIGHEST_KMH where no oscillation grows at these speeds.
        progress: called with the fraction done and a short text.

    Raises:
        KeyboardInterrupt: Ctrl-C came before the end.
        ValueError: speeds not positive and rising.
    """
    try:
        modes = modes_over_speed(case, [v / 3.6 for v in speeds_kmh], progress)
    except StartError as problem:
        return LinearCriticalSpeed(problem=str(problem))
    if modes.followed.interrupted:
        raise KeyboardInterrupt
    highest = speeds_kmh[-1]
    found = LinearCriticalSpeed(first_onset(zero_crossings(modes)), growing_at_start(modes), searched_to_kmh=highest)
    if above and found.onset is None and not found.grows_at_start and highest < HIGHEST_KMH:
        further = scan_linear(case, [highest, HIGHEST_KMH], progress=progress)
        return found if further.problem else further
    return found


SAME = 2e-5  # part of a speed by which another must differ to be another one: thirds hit on speeds of runs but for rounding


@dataclass(frozen=True)
class CriticalSpeedByDisturbance:
    """Between which speeds a perturbation of one size begins to persist."""

    decays: float  # highest speed, below the onset, at which it decayed [m/s]; NaN if it never did
    persists: float  # lowest speed at which it persisted [m/s]; NaN if it never did
    disturbance: float  # its size, lateral offset of the leading wheelset [m]
    runs: list[HuntingRun]  # all runs made for it, by speed; those that did not come to their end count neither way

    def further_speeds(self, width: float) -> list[float]:
        """Speeds of the next round of runs, the bracket in thirds [m/s]; none if it is narrower than a width [m/s].

        None either where runs have been made there that did not come to their end.
        """
        if not self.persists - self.decays > width:  # also where one of them is NaN
            return []
        thirds, tried = np.linspace(self.decays, self.persists, 4)[1:-1], np.array([run.speed for run in self.runs])
        return [float(v) for v in thirds if np.abs(tried - v).min() > SAME * v]

    @property
    def table(self) -> xr.Dataset:
        """The runs as a Dataset of `hunting_table`."""
        return hunting_table(self.runs, self.disturbance)

    @property
    def ended_early(self) -> list[HuntingRun]:
        """Runs that did not come to their end: neither decay nor limit cycle."""
        return [run for run in self.runs if not run.valid]


def bracket(runs: Iterable[HuntingRun], disturbance: float) -> CriticalSpeedByDisturbance:
    """The critical speed by disturbance among runs at several speeds."""
    ordered = sorted(runs, key=lambda run: run.speed)
    persists = min((run.speed for run in ordered if run.persists), default=math.nan)
    decays = max((run.speed for run in ordered if run.decays and not run.speed > persists), default=math.nan)
    return CriticalSpeedByDisturbance(decays, persists, disturbance, ordered)


RADII = (0.46, 0.725, 1.0, 2.0, 5.0, 10.0)  # radii of the rollers in the table [m]
TRACK = math.inf  # the radius of a track [m]
EFFECTS = ("curvature", "conicity", "spin", "yaw")  # switches of `contact.roller_effects`

RANGE_KMH = tuple(float(v) for v in range(30, 601, 30))
"""Where critical speeds are looked for; the search refines it [km/h]."""

Place = tuple[str, float]  # part of the vehicle, radius of the rollers [m]
On = frozenset[str]  # effects that are on


def radius_cases(rig: Case, parts: Sequence[str], radii: Sequence[float] = RADII) -> dict[Place, Case]:
    """Each part of the vehicle on rollers of each radius, rising, and on the track of the same head."""
    track = on_track(rig)
    return {
        (part, radius): part_of(track, part) if radius == TRACK else on_rig(part_of(rig, part), radius)
        for part in parts
        for radius in (*sorted(radii), TRACK)
    }


ALL_ON, ALL_OFF = frozenset(EFFECTS), frozenset[str]()


def effect_cases(rig: Case) -> dict[On, Case]:
    """The rig with all effects, without each one, with each one alone, and with none."""
    wanted = (ALL_ON, *(ALL_ON - {e} for e in EFFECTS), *(frozenset({e}) for e in EFFECTS), ALL_OFF)
    return {
        on: rig.with_changes({f"contact.roller_effects.{effect}": effect in on for effect in EFFECTS}) for on in wanted
    }


def effect_split(found: Mapping[On, LinearCriticalSpeed]) -> dict[str, Any]:
    """What each effect of a roller costs, of the critical speeds of `effect_cases` [km/h]; NaN where one is missing.

    Returns:
        As in summary.json: all effects off, the track of the same head, and on, the rig; what the rig gains without one effect;
        what one alone takes from the track; what the sums of either leave of the loss from track to rig.
    """
    kmh = {on: scan.speed_kmh for on, scan in found.items()}
    rig, track = (kmh.get(on, math.nan) for on in (ALL_ON, ALL_OFF))
    off = {effect: kmh.get(ALL_ON - {effect}, math.nan) - rig for effect in EFFECTS}
    alone = {effect: track - kmh.get(frozenset({effect}), math.nan) for effect in EFFECTS}
    left = {f"interaction_{n}_kmh": track - rig - sum(v.values()) for n, v in (("switched_off", off), ("alone", alone))}
    return {"track_kmh": track, "rig_kmh": rig, "gain_switched_off_kmh": off, "loss_alone_kmh": alone, **left}
