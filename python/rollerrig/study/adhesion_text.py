"""What the adhesion study says: the verdict first, then why, in sentences from its numbers.

rows of the verdict, numbers -> [adhesion text] -> lines of terminal and report
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rollerrig.results import COMPLETED
from rollerrig.study.adhesion_causes import CAUSES, LARGEST_ERROR, TOGETHER
from rollerrig.study.adhesion_verdicts import GROUPS, SHOWN, Row, verdict_of
from rollerrig.study.quantities import Numbers
from rollerrig.wording import number, percent


def verdict_lines(rows: Sequence[Row]) -> Iterator[str]:
    """The verdict of each group, and what is not met or not decided."""
    for group, title in GROUPS.items():
        own, word = [row for row in rows if row.group == group], verdict_of(rows, group)
        met = sum(row.verdict == "met" for row in own)
        open_ones = sorted((row for row in own if row.verdict != "met"), key=lambda row: row.verdict != "not met")
        yield f"{title}: {word.upper() if word == 'not met' else word}; {met} of {len(own)} targets met." + "".join(
            f" {SHOWN[row.verdict]}: {_row(row)}." for row in open_ones
        )


def target_lines(rows: Sequence[Row]) -> Iterator[str]:
    """The table of the verdict as lines."""
    for row in rows:
        yield f"{SHOWN[row.verdict]}, {row.group}: {_row(row)}"


def _row(row: Row) -> str:
    return f"{row.text} {row.value_text}, target {row.target_text}"


def findings(numbers: Numbers) -> Iterator[str]:
    """Sentences after the verdict."""
    yield (
        f"The protection's limit cycle has another phase in every test: rig and track are compared by means over "
        f"{numbers['starts']} starts each, with intervals of 95 %, and not point by point."
    )
    yield from _regrip(numbers)
    yield from _causes(numbers)
    yield from _dead_time(numbers)
    yield from _ends(numbers)


def _regrip(numbers: Numbers) -> Iterator[str]:
    row = numbers["verdicts"].get("regrip_adhesion")
    if row is not None and row["verdict"] == "not met":
        track, rig = (number(numbers[where]["regrip_adhesion"]["mean"], 3) for where in ("track", "rig"))
        force = f"the largest force on an axle that has slid is {track} of its load on track, {rig} on the rig"
        yield f"Regripping is not reproduced: {force}."


def _causes(numbers: Numbers) -> Iterator[str]:
    causes = numbers["causes"]
    if not causes:
        return
    known = sorted((n for n in CAUSES if not causes[n]["within_its_error"]), key=lambda n: -abs(causes[n]["share"]))
    hidden = [name for name in CAUSES if causes[name]["within_its_error"]]
    text = ", ".join(f"{CAUSES[name]} {share_text(causes[name])}" for name in known) or "none is larger than its error"
    text += f"; not told from zero: {', '.join(CAUSES[name] for name in hidden)}" if hidden else ""
    yield f"Causes of the difference of {share_text(causes[TOGETHER])} in distance: {text}."
    rough = max(one["standard_error"] or 0.0 for one in causes.values())
    if rough >= LARGEST_ERROR:
        yield f"The shares are rough: standard errors up to {percent(rough)} of the distance, aimed at {percent(LARGEST_ERROR)}."
    sliding = causes["rolling"]
    ends = f"between {percent(sliding['low'], signed=True)} and {percent(sliding['high'], signed=True)}"
    yield (
        f"The real sliding of the wheels on the rollers, {1e3 * numbers['rig']['real_sliding_largest_mps']['mean']:.3g} mm/s at "
        f"most, changes the distance by {ends}" + (": not told from zero." if sliding["within_its_error"] else ".")
    )


def share_text(one: Numbers) -> str:
    """A share with its standard error."""
    if one["standard_error"] is None:
        return percent(one["share"], signed=True)
    return f"{100.0 * one['share']:+.2f} ± {100.0 * one['standard_error']:.2f} %"


def _dead_time(numbers: Numbers) -> Iterator[str]:
    found = numbers["dead_time"]
    if not found:
        return
    parts = f"{1e3 * found['torque_s']:z.1f} ms of the axle's torque, {1e3 * found['drive_s']:z.1f} ms of the drives"
    more = f"{1e3 * found['predicted_s']:z.1f} ms more ({parts})"
    text = f"Equivalent dead time: the rig acts like a track whose protection has {more}"
    measured = found.get("measured_s")
    if measured is not None:
        text += f"; measured: {1e3 * measured:z.1f} ms"
        if found["low_s"] is not None:
            text += f", between {1e3 * found['low_s']:.1f} and {1e3 * found['high_s']:.1f} ms"
    elif found.get("track"):
        delays = [0.0, *(float(delay) for delay in found["track"])]
        text += f"; measured: none, no dead time from 0 to {max(delays):g} ms gives the track the rig's distance"
    yield f"{text}."


def _ends(numbers: Numbers) -> Iterator[str]:
    for label in ("track", "rig"):
        if numbers[label]["status"] not in COMPLETED:
            yield f"{label}: {numbers[label]['status_message']}"
