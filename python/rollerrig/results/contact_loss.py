"""Wheels that lost contact during a run: how often, how long, when and where.

spells without contact of the core -> [contact_loss] -> attribute `contact_losses`, warnings
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
import xarray as xr

from rollerrig.results.dataset import Draft

ATTRIBUTE = "contact_losses"

LONGEST_SPELL = 10e-3
"""Without contact for longer than this a wheel has left its rail; shorter ones are vibrations on the contact's spring [s]."""

LARGEST_PART = 1e-2
"""Part of a run that a wheel may vibrate without contact before a warning [-]."""

Spells = tuple[int, float, float, float]
"""Number, sum, longest [s], and when that one began [s]."""


@dataclass(frozen=True)
class ContactLoss:
    """What one wheel ran without contact.

    Attributes:
        wheel: its name.
        spells: number of times.
        total_s: sum of their durations [s].
        longest_s: duration of the longest [s].
        longest_from_s: time at which that one began [s].
        longest_from_m: distance there [m].
    """

    wheel: str
    spells: int
    total_s: float
    longest_s: float
    longest_from_s: float
    longest_from_m: float

    def in_words(self, on_rollers: bool) -> str:
        """Text for a warning: the wheel, how long, when and where."""
        times = "once" if self.spells == 1 else f"{self.spells} times, {1e3 * self.total_s:.3g} ms in all"
        place = "" if on_rollers else f", {self.longest_from_m:.5g} m"
        longest = f"{1e3 * self.longest_s:.3g} ms at t = {self.longest_from_s:.4g} s{place}"
        return f"{self.wheel} without contact {times}; the longest {longest}"


def add_contact_losses(draft: Draft, wheels: Sequence[str], spells: Sequence[Spells]) -> list[ContactLoss]:
    """Add the losses of all wheels that had any, as JSON among the attributes.

    Args:
        draft: results with `distance`; it is changed.
        wheels: names, in the order of `spells`.
        spells: of each wheel.

    Returns:
        The losses.
    """
    times, distances = draft.values("time"), draft.values("distance")
    losses = [
        ContactLoss(wheel, count, total, longest, at, float(np.interp(at, times, distances)) if len(times) else 0.0)
        for wheel, (count, total, longest, at) in zip(wheels, spells, strict=True)
        if count
    ]
    draft.attributes[ATTRIBUTE] = json.dumps([asdict(loss) for loss in losses])
    return losses


def contact_losses(run: xr.Dataset) -> list[ContactLoss]:
    """Losses of every wheel that lost contact, in the order of the wheels."""
    return [ContactLoss(**loss) for loss in json.loads(run.attrs.get(ATTRIBUTE, "[]"))]


def contact_loss_warning(losses: Sequence[ContactLoss], duration: float, *, on_rollers: bool, advice: str = "") -> str:
    """One line that names the wheels whose contact was lost for longer than vibrations explain; empty if there are none.

    Args:
        losses: of a run.
        duration: of the run [s].
        on_rollers: whether it was on a rig.
        advice: what to try, a sentence.
    """
    gross = [
        loss
        for loss in losses
        if loss.longest_s > LONGEST_SPELL or (loss.longest_s > 0.0 and loss.total_s > LARGEST_PART * duration)
    ]
    if not gross:
        return ""
    told = "wheels lost contact: " + "; ".join(loss.in_words(on_rollers) for loss in gross)
    return f"{told}. {advice}" if advice else told
