"""Where the curves of a comparison of controllers fail, in words with the limit that decides, and as numbers.

Rank -> [control_text] -> 'persistent torque ripple above 500 N m RMS from 21.3× to 98× (largest 2310 N m at 64×)'
"""

from __future__ import annotations

import math
from typing import Any

from rollerrig.study.control_ranking import RIPPLE_CRITERION, TRACKING_CRITERION, Failure, Rank
from rollerrig.wording import number


def rank_numbers(rank: Rank) -> dict[str, Any]:
    """Of one curve, for summary.json."""
    return {
        "family": rank.family.name,
        "curve": rank.curve,
        "worst_value": rank.worst.value,
        "worst_tracking_rms": rank.worst.numbers["tracking_rms"],
        "worst_ripple_nm": rank.worst.numbers["ripple_nm"],
        "failures": [vars(failure) for failure in rank.failures],
    }


def failures_text(rank: Rank) -> str:
    """All parts of a curve that fail; empty where none does."""
    return " and ".join(_failure_text(rank, failure) for failure in rank.failures)


def _failure_text(rank: Rank, failure: Failure) -> str:
    known = {"tracking": TRACKING_CRITERION, "ripple": RIPPLE_CRITERION}
    cause = known.get(failure.cause, f"{failure.cause.replace('_', ' ')}, test ends early,")
    return f"{cause} {_where(rank, failure)}{_largest(rank, failure)}"


def _where(rank: Rank, failure: Failure) -> str:
    text, begin, end = rank.family.text, failure.begin, failure.end
    if failure.throughout:
        return f"throughout, {text(rank.points[0].value)} to {text(rank.points[-1].value)}"
    if math.isnan(begin):
        return f"up to {text(end)}"
    if math.isnan(end):
        return f"from {text(begin)} on"
    return f"at {text(begin)}" if begin == end else f"from {text(begin)} to {text(end)}"


def _largest(rank: Rank, failure: Failure) -> str:
    if math.isnan(failure.largest):
        return ""
    scale, unit = (100.0, "%") if failure.cause == "tracking" else (1.0, "N m")
    return f" (largest {number(scale * failure.largest, 3)} {unit} at {rank.family.text(failure.largest_at)})"
