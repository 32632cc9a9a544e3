"""Causes of the difference between rig and track: shares of the distance that go away with each imperfection of the rig.

ensembles of track, rig and its variants -> [cause_shares] -> name -> share with its standard error; they add up to the whole
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rollerrig.analysis.slide_statistics import TestRecord
from rollerrig.study.adhesion_variants import STEPS
from rollerrig.study.ensemble import Estimate, difference, distances, estimate

TOGETHER = "together"
CAUSES = {
    "rolling": "sliding of the wheels on the rollers",
    "drives": "lag and torque limit of the roller drives",
    "estimator": "lag of the estimated torque",
    "model": "simplifications of the virtual train, and sampling",
}
LARGEST_ERROR = 5e-4
"""More starts are made until the standard error of every share is below this part of the distance."""


def cause_shares(records: Mapping[str, Sequence[TestRecord]]) -> dict[str, Estimate] | None:
    """Parts of (mean distance of the rig over that of the track, less 1) by cause, and `together` their sum.

    Args:
        records: of `track`, `rig` and each of STEPS, from several starts.

    Returns:
        None where an ensemble is missing.
    """
    names = ("rig", *STEPS, "track")
    if any(not records.get(name) for name in names):
        return None
    found = [estimate(values) for values in distances([records[name] for name in names])]
    on_track = found[-1].mean
    pairs = {name: (found[k], found[k + 1]) for k, name in enumerate(CAUSES)}
    pairs[TOGETHER] = found[0], found[-1]
    return {name: _over(difference(a, b), on_track) for name, (a, b) in pairs.items()}


def _over(one: Estimate, distance: float) -> Estimate:
    return Estimate(one.mean / distance, one.standard_error / distance, one.freedom)


def is_within_error(share: Estimate) -> bool:
    """Whether nothing is known of a share, not even its sign."""
    interval = share.interval
    return interval.low <= 0.0 <= interval.high


def are_known(shares: Mapping[str, Estimate] | None) -> bool:
    """Whether the standard error of every share is small enough."""
    return shares is None or all(share.standard_error < LARGEST_ERROR for share in shares.values())
