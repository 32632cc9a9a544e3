"""What rollers change: linear critical speed over their radius, and its loss from track to rig split by the roller's effects.

case on a rig -> [cases with other radii, with effects switched off] -> linear critical speeds -> tables
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rollerrig.analysis.critical_speed import LinearCriticalSpeed
from rollerrig.cases import on_rig, on_track, part_of
from rollerrig.config import Case

RADII = (0.46, 0.725, 1.0, 2.0, 5.0, 10.0)
"""Radii of the rollers in the table [m]."""

TRACK = math.inf
"""The radius of a track [m]."""

EFFECTS = ("curvature", "conicity", "spin", "yaw")
"""Switches of `contact.roller_effects`."""

RANGE_KMH = tuple(float(v) for v in range(30, 601, 30))
"""Where critical speeds are looked for; the search refines it [km/h]."""

Place = tuple[str, float]
"""Part of the vehicle, radius of the rollers [m]."""
On = frozenset[str]
"""Effects that are on."""


@dataclass(frozen=True)
class CriticalSpeedOverRadius:
    """Linear critical speeds of parts of a vehicle on track and on rollers.

    Attributes:
        parts: cuts of the vehicle.
        radii: of the rollers [m], rising; last TRACK.
        found: (part, radius) -> what was found; absent where Ctrl-C came first.
    """

    parts: tuple[str, ...]
    radii: tuple[float, ...]
    found: Mapping[Place, LinearCriticalSpeed]

    def kmh(self, part: str, radius: float) -> float:
        """Critical speed [km/h]; NaN if there is none or it was not computed."""
        scan = self.found.get((part, radius))
        return math.nan if scan is None else scan.speed_kmh

    def rises_with_radius(self, part: str) -> bool:
        """Whether smaller rollers always have the lower critical speed, and all of them a lower one than the track."""
        speeds = [self.kmh(part, radius) for radius in self.radii]
        return bool(np.all(np.diff(speeds) > 0))  # NaN compares as false


@dataclass(frozen=True)
class EffectSplit:
    """Linear critical speeds on a rig with some of the roller's effects switched off.

    Attributes:
        found: effects that are on -> what was found.
    """

    found: Mapping[On, LinearCriticalSpeed]

    def kmh(self, on: On) -> float:
        """Critical speed with these effects [km/h]; NaN if there is none or it was not computed."""
        scan = self.found.get(on)
        return math.nan if scan is None else scan.speed_kmh

    @property
    def rig(self) -> float:
        """All effects on [km/h]."""
        return self.kmh(frozenset(EFFECTS))

    @property
    def track(self) -> float:
        """All effects off: the track of the same head [km/h]."""
        return self.kmh(frozenset())

    @property
    def loss(self) -> float:
        """Loss from track to rig [km/h]."""
        return self.track - self.rig

    @property
    def switched_off(self) -> dict[str, float]:
        """Effect -> what the rig gains without it [km/h]."""
        return {effect: self.kmh(frozenset(EFFECTS) - {effect}) - self.rig for effect in EFFECTS}

    @property
    def alone(self) -> dict[str, float]:
        """Effect -> what it alone takes from the track [km/h]."""
        return {effect: self.track - self.kmh(frozenset({effect})) for effect in EFFECTS}

    def interaction(self, parts: Mapping[str, float]) -> float:
        """What the sum of single effects leaves of the loss [km/h]."""
        return self.loss - sum(parts.values())


def radius_cases(rig: Case, parts: Sequence[str], radii: Sequence[float] = RADII) -> dict[Place, Case]:
    """Cases of the table: each part on rollers of each radius and on the track of the same head."""
    track = on_track(rig)
    cases: dict[Place, Case] = {}
    for part in parts:
        own = part_of(rig, part)
        for radius in sorted(radii):
            cases[part, radius] = on_rig(own, radius)
        cases[part, TRACK] = part_of(track, part)
    return cases


def effect_cases(rig: Case) -> dict[On, Case]:
    """The rig with all effects, without each one, with each one alone, and with none."""
    every = frozenset(EFFECTS)
    wanted = [every, *(every - {e} for e in EFFECTS), *(frozenset({e}) for e in EFFECTS), frozenset[str]()]
    return {
        on: rig.with_changes({f"contact.roller_effects.{effect}": effect in on for effect in EFFECTS}) for on in wanted
    }


def critical_speed_over_radius(
    places: Sequence[Place], found: Mapping[Place, LinearCriticalSpeed]
) -> CriticalSpeedOverRadius:
    """The table of all places of `radius_cases`, from what was computed for them."""
    parts = tuple(dict.fromkeys(part for part, _ in places))
    radii = tuple(sorted({radius for _, radius in places}))
    return CriticalSpeedOverRadius(parts, radii, dict(found))
