"""Critical speeds over the rollers' radius, and what makes that of a rig differ from that of the track.

cases -> [linear critical speeds, jobs of their own] -> CriticalTable, Causes
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rollerrig.analysis import LinearCriticalSpeed
from rollerrig.cases import on_rig, on_track, part_of
from rollerrig.config import Case

RADII = (0.46, 0.725, 1.0, 2.0, 5.0, 10.0)
"""Radii of the rollers in the table [m]."""

TRACK = math.inf
"""The radius of a track [m]."""

EFFECTS = {
    "curvature": "curvature along x: shorter patch",
    "conicity": "conicity of the roller",
    "spin": "spin of the roller",
    "yaw": "yawed wheel leaves the crown",
}
"""Switch of `contact.roller_effects` -> words."""

RANGE_KMH = tuple(float(v) for v in range(30, 601, 30))
"""Where critical speeds are looked for; the search refines it [km/h]."""

Place = tuple[str, float]
On = frozenset[str]


@dataclass(frozen=True)
class CriticalTable:
    """Linear critical speeds of parts of a vehicle on track and on rollers.

    Attributes:
        parts: cuts of the vehicle.
        radii: of the rollers [m], rising; last TRACK.
        found: (part, radius) -> what was found; absent where Ctrl-C came first.
    """

    parts: tuple[str, ...]
    radii: tuple[float, ...]
    found: dict[Place, LinearCriticalSpeed]

    def kmh(self, part: str, radius: float) -> float:
        """Critical speed [km/h]; NaN if there is none or it was not computed."""
        scan = self.found.get((part, radius))
        return math.nan if scan is None else scan.speed_kmh

    def falls_with_radius(self, part: str) -> bool:
        """Whether smaller rollers always have the lower critical speed, and all of them a lower one than the track."""
        speeds = [self.kmh(part, radius) for radius in self.radii]
        return bool(np.all(np.diff(speeds) > 0))  # NaN compares as false


@dataclass(frozen=True)
class Causes:
    """Linear critical speeds on a rig with some of the roller's effects left out.

    Attributes:
        found: effects that are on -> what was found.
    """

    found: dict[On, LinearCriticalSpeed]

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
        """From track to rig [km/h]."""
        return self.track - self.rig

    def when_switched_off(self, effect: str) -> float:
        """What the rig gains without one effect [km/h]."""
        return self.kmh(frozenset(EFFECTS) - {effect}) - self.rig

    def alone(self, effect: str) -> float:
        """What one effect alone takes from the track [km/h]."""
        return self.track - self.kmh(frozenset({effect}))

    def remainder(self, parts: Sequence[float]) -> float:
        """What the sum of single effects leaves of the loss: their interaction [km/h]."""
        return self.loss - sum(parts)


def table_cases(rig: Case, parts: Sequence[str], radii: Sequence[float] = RADII) -> dict[Place, Case]:
    """Cases of the table: each part on rollers of each radius and on the track of the same head."""
    track = on_track(rig)
    cases: dict[Place, Case] = {}
    for part in parts:
        own = part_of(rig, part)
        for radius in sorted(radii):
            cases[part, radius] = on_rig(own, radius)
        cases[part, TRACK] = part_of(track, part)
    return cases


def cause_cases(rig: Case) -> dict[On, Case]:
    """The rig with all effects, without each one, with each one alone, and with none."""
    every = frozenset(EFFECTS)
    wanted = [every, *(every - {e} for e in EFFECTS), *(frozenset({e}) for e in EFFECTS), frozenset[str]()]
    return {
        on: rig.with_changes({f"contact.roller_effects.{effect}": effect in on for effect in EFFECTS}) for on in wanted
    }


def critical_table(places: Collection[Place], found: Mapping[Place, LinearCriticalSpeed]) -> CriticalTable:
    """The table of all places, from what was computed for `table_cases`."""
    parts = tuple(dict.fromkeys(part for part, _ in places))
    radii = tuple(sorted({radius for _, radius in places}))
    return CriticalTable(parts, radii, dict(found))


# ------------------------------------------------------------------------------------------------- tables and words


def words(part: str) -> str:
    """A cut as the reader sees it: 'leading bogie'."""
    return part.replace("_", " ")


def radius_words(radius: float) -> str:
    """'rollers of 0.725 m', or 'track'."""
    return "track" if radius == TRACK else f"rollers of {radius:g} m"


def cell(scan: LinearCriticalSpeed | None) -> str:
    """A critical speed as a cell of a table."""
    if scan is None:
        return "not computed"
    if scan.problem:
        return "no equilibrium"
    if scan.grows_at_start:
        return f"grows at {RANGE_KMH[0]:g}"
    return f"{scan.speed_kmh:.1f}" if scan.onset else f"none to {RANGE_KMH[-1]:g}"


def table_rows(table: CriticalTable) -> tuple[list[str], list[list[str]]]:
    """Header and rows: a row per support, a column per part, the change against the track beside each."""
    header = ["on"]
    for part in table.parts:
        header += [f"{words(part)} [km/h]", "against track"]
    rows = []
    for radius in (TRACK, *reversed(table.radii[:-1])):
        row = [radius_words(radius)]
        for part in table.parts:
            change = table.kmh(part, radius) / table.kmh(part, TRACK) - 1
            shown = f"{100 * change:+.1f} %" if math.isfinite(change) and radius != TRACK else ""
            row += [cell(table.found.get((part, radius))), shown]
        rows.append(row)
    return header, rows


def order_sentences(table: CriticalTable) -> list[str]:
    """The order of the critical speeds in words, with figures."""
    texts = []
    for part in table.parts:
        speeds = {radius: table.kmh(part, radius) for radius in table.radii}
        known = {radius: v for radius, v in speeds.items() if math.isfinite(v)}
        if len(known) < 2:
            texts.append(f"{words(part).capitalize()}: no critical speed up to {RANGE_KMH[-1]:g} km/h to be compared.")
            continue
        smallest, largest = min(known), max(known)
        texts.append(
            f"{words(part).capitalize()}: {known[smallest]:.1f} km/h on {radius_words(smallest)}, {known[largest]:.1f} km/h on "
            f"{radius_words(largest)}; "
            + (
                "the smaller the rollers, the lower, and all below the track."
                if table.falls_with_radius(part)
                else "not in the order of the radii."
            )
        )
    return texts


def cause_rows(causes: Causes) -> tuple[list[str], list[list[str]]]:
    """Header and rows of the split of the loss."""
    header = ["effect", "switched off alone: gain [km/h]", "on alone: loss [km/h]"]
    off = [causes.when_switched_off(effect) for effect in EFFECTS]
    alone = [causes.alone(effect) for effect in EFFECTS]
    rows = [[text, signed(a), signed(b)] for text, a, b in zip(EFFECTS.values(), off, alone, strict=True)]
    rows.append(["sum of the four", signed(sum(off)), signed(sum(alone))])
    rows.append(["interaction: what the sum leaves", signed(causes.remainder(off)), signed(causes.remainder(alone))])
    rows.append(["track less rig", signed(causes.loss), signed(causes.loss)])
    return header, rows


def signed(value: float) -> str:
    """A change of speed; a dash where there is none."""
    return f"{value:+.1f}" if math.isfinite(value) else "–"


def cause_sentence(causes: Causes) -> str:
    """The split in words."""
    if not math.isfinite(causes.loss):
        return "Track or rig has no critical speed in the range: nothing to split."
    off = {effect: causes.when_switched_off(effect) for effect in EFFECTS}
    known = {effect: gain for effect, gain in off.items() if math.isfinite(gain)}
    most = max(known, key=lambda effect: known[effect], default="")
    text = (
        f"Of {causes.track:.1f} km/h on track {causes.rig:.1f} km/h are left on the rig, "
        f"{100 * causes.loss / causes.track:.1f} % less."
    )
    if most:
        text += f" Most of it comes with the {EFFECTS[most].split(':')[0]}: without it alone {known[most]:+.1f} km/h."
    helping = [EFFECTS[effect].split(":")[0] for effect, gain in known.items() if gain < -0.05]
    if helping:
        text += f" On the other side stands the {' and the '.join(helping)}, which raises the critical speed."
    return text
