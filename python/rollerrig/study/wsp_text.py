"""What a test programme says: the verdicts first, what is not met and why something is not decided, the sums.

numbers -> [wsp text] -> lines of terminal and report
"""

from __future__ import annotations

from collections.abc import Iterator

from rollerrig.config import CRITERIA
from rollerrig.study.quantities import Numbers
from rollerrig.study.wsp_verdicts import SUPPORTS
from rollerrig.wording import number

NAMES = {
    "k_wet": "K_wet",
    "increase_over_dry": "increase over dry",
    "distance": "distance",
    "mean_deceleration": "mean deceleration",
    "adhesion_utilisation": "adhesion utilisation",
    "longest_lock": "longest lock",
    "flat_length": "flat length, estimated",
    "large_slip_share": "time at slip above 30 %",
    "air": "air",
    "ventings": "ventings",
}
"""Of the criteria."""

UNITS = {
    "increase_over_dry": ("%", 100.0),
    "distance": ("m", 1.0),
    "mean_deceleration": ("m/s²", 1.0),
    "longest_lock": ("s", 1.0),
    "flat_length": ("mm", 1e3),
    "large_slip_share": ("%", 100.0),
    "air": ("l", 1e3),
}
"""In which they are shown, and the factor."""

NOT_QUOTED = (
    "Stops and limits are those of the programme file. EN 15595 and UIC 541-05 are not quoted: a verdict here is no approval, "
    "and says only what the limits of that file say."
)


def findings(numbers: Numbers, limits: int) -> Iterator[str]:
    """All lines."""
    yield from _verdicts(numbers, limits)
    yield from _not_met(numbers)
    yield from _not_decided(numbers)
    yield from _fidelity(numbers)
    yield from _sums(numbers)
    yield NOT_QUOTED


def _verdicts(numbers: Numbers, limits: int) -> Iterator[str]:
    count = len(numbers["stops"])
    head = f"{count} stops of {numbers['starts']} starts each, on track and on the rig."
    if not limits:
        yield f"{head} The programme sets no limit: nothing is judged."
        return
    parts = []
    for on in SUPPORTS:
        found = numbers["sums"][on]["criteria"]
        where = "on track" if on == "track" else "on the rig"
        parts.append(
            f"{where} {found['met']} of {sum(found.values())} criteria are met, {found['not_met'] or 'none'} not met, "
            f"{found['not_decided'] or 'none'} not decided"
        )
    text = "; ".join(parts)
    yield f"{text[0].upper()}{text[1:]}. {head}"


def _not_met(numbers: Numbers) -> Iterator[str]:
    for on in SUPPORTS:
        found = [
            f"{stop}: {NAMES[name]} {value_text(name, one[on])}, {limit_text(name, one)}"
            for stop, own in numbers["stops"].items()
            for name, one in own["criteria"].items()
            if on in one and one[on]["verdict"] == "not met"
        ]
        if found:
            yield f"NOT met on {'track' if on == 'track' else 'the rig'}: {'; '.join(found)}."


def _not_decided(numbers: Numbers) -> Iterator[str]:
    """Grouped by the reason."""
    for on in SUPPORTS:
        reasons: dict[str, dict[str, None]] = {}
        for stop, own in numbers["stops"].items():
            for name, one in own["criteria"].items():
                if on in one and one[on]["verdict"] == "not decided":
                    why = one[on]["why"]
                    inside = why == "the limit lies within the interval"
                    reasons.setdefault(why, {})[f"{stop} ({NAMES[name]})" if inside else stop] = None
        for why, stops in reasons.items():
            yield f"Not decided on {'track' if on == 'track' else 'the rig'}: {', '.join(stops).replace('_', ' ')}: {why}."


def _fidelity(numbers: Numbers) -> Iterator[str]:
    """How far a verdict on the rig is one on track."""
    words = [one["rig_like_track"]["fidelity"] for one in numbers["stops"].values()]
    differ = [
        f"{stop} ({NAMES[name]})"
        for stop, own in numbers["stops"].items()
        for name, one in own["criteria"].items()
        if {one[on]["verdict"] for on in SUPPORTS if on in one} == {"met", "not met"}
    ]
    met, against, open_ = (words.count(word) for word in ("met", "not met", "not decided"))
    yield (
        f"The rig does as the track within the targets of the command adhesion in {met} of {len(words)} stops, not in {against}, "
        f"not decided in {open_}: a verdict on the rig is one of the test on the rig. "
        f"Opposite verdicts on track and rig: {', '.join(differ).replace('_', ' ') or 'none'}."
    )


def _sums(numbers: Numbers) -> Iterator[str]:
    for on in SUPPORTS:
        one = numbers["sums"][on]
        flat = one["flat_length_m"]
        where = "track" if on == "track" else "the rig"
        yield (
            f"All stops on {where}: {number(one['distance_m'])} m, {number(one['air_litres'])} l of "
            f"air, {number(one['dump_cycles'])} ventings; longest lock {number(one['longest_lock_s'], 3)} s, longest flat "
            f"{number(1e3 * flat, 2) if flat is not None else '–'} mm (an estimate)."
        )


def value_text(name: str, one: Numbers) -> str:
    """Mean of a criterion, its interval, and the worst test where each counts."""
    if one["mean"] is None:
        return "–"
    unit, factor = UNITS.get(name, ("", 1.0))
    text = number(factor * one["mean"], 3)
    if one["low"] is not None and one["high"] is not None and one["low"] != one["high"]:
        text += f" ({number(factor * one['low'], 3)} … {number(factor * one['high'], 3)})"
    if CRITERIA[name].every and one["worst"] is not None:  # type: ignore[index]
        text += f", worst {number(factor * one['worst'], 3)}"
    return f"{text} {unit}".rstrip()


def limit_text(name: str, one: Numbers) -> str:
    """A limit."""
    unit, factor = UNITS.get(name, ("", 1.0))
    each = " in each test" if CRITERIA[name].every else ""  # type: ignore[index]
    return f"{one['kind']} {number(factor * one['limit'], 3)} {unit}".rstrip() + each
