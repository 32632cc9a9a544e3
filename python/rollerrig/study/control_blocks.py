"""Tables and figures of a comparison of controllers.

Ranks and results -> [control_blocks] -> blocks of the report
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from rollerrig.config import Case
from rollerrig.plot import control as figures
from rollerrig.study.control_ranking import RIPPLE_LIMIT, TRACKING_LIMIT, Rank, Result
from rollerrig.study.control_runs import QUANTITIES
from rollerrig.study.control_text import failures_text
from rollerrig.study.control_variants import Family
from rollerrig.study.report import Picture, Table

LIMITS = f"limits of failure, {100 * TRACKING_LIMIT:g} % and {RIPPLE_LIMIT:g} N m"


def range_chart(ranked: Sequence[Rank], shipped: Result) -> Picture:
    """Range of the errors of every curve beside the limits."""
    bars = []
    for rank in ranked:
        points = [p.numbers for p in rank.points if p.completed] or [rank.worst.numbers]
        error = [max(100.0 * n["tracking_rms"], 1e-4) for n in points]
        ripple = [max(n["ripple_nm"], 0.1) for n in points if math.isfinite(n["ripple_nm"])] or [math.nan]
        label = f"{rank.family.name.replace('_', ' ')}, {rank.curve}"
        bars.append(figures.Bar(label, (min(error), max(error)), (min(ripple), max(ripple)), not rank.worst.completed))
    base = shipped.numbers
    picture = figures.ranges(
        bars, (100.0 * base["tracking_rms"], base["ripple_nm"]), (100.0 * TRACKING_LIMIT, RIPPLE_LIMIT)
    )
    caption = (
        f"Range of the errors along each axis, the worst on top. Dashed: {LIMITS}; red: above it; dotted: shipped."
    )
    return Picture("ranges", picture, caption)


def ranking_table(case: Case, ranked: Sequence[Rank]) -> Table:
    """Where every curve fails, and its worst run."""
    rows = []
    for rank in ranked:
        worst, family = rank.worst, rank.family
        shipped = family.text(family.base(case)) if family.base is not None else "–"
        cells = [QUANTITIES[name].cell(worst.numbers[name]) for name in ("tracking_rms", "ripple_nm")]
        error = cells[0] if worst.completed else "ended early"
        fails = failures_text(rank) or "no failure"
        rows.append([family.title, rank.curve, fails, shipped, family.text(worst.value), error, cells[1]])
    header = ("varied", "curve", "fails", "shipped", "worst at", "tracking RMS [%]", "ripple [N m]")
    return Table(header, rows, "every curve, the worst first")


def family_picture(case: Case, family: Family, results: Sequence[Result]) -> Picture:
    """Errors over the axis of a family, a line per curve."""
    curves = []
    for label in dict.fromkeys(r.curve for r in results if r.family == family.name):
        points = sorted((r for r in results if (r.family, r.curve) == (family.name, label)), key=lambda r: r.value)
        values = {key: [p.numbers[key] for p in points] for key in ("tracking_rms", "ripple_nm")}
        tracking_percent = [100.0 * value for value in values["tracking_rms"]]
        ended = [not p.completed for p in points]
        curves.append(figures.Curve(label, [p.value for p in points], tracking_percent, values["ripple_nm"], ended))
    base = family.base(case) if family.base is not None else None
    limits = (100.0 * TRACKING_LIMIT, RIPPLE_LIMIT)
    picture = figures.over_parameter(curves, family.axis, family.scale, base, limits)
    return Picture(family.name, picture, f"{family.title}. Dashed: {LIMITS}; dotted: the case as shipped.")
