"""What the numbers of a comparison say, in words.

numbers of `fidelity` -> [verdict] -> sentences: each target met or missed, and which cause is responsible
"""

from __future__ import annotations

from typing import Any

from rollerrig.studies.adhesion.causes import CAUSE_WORDS

TRACKING_TARGET, DISTANCE_TARGET = 0.01, 0.02


def percent(value: float | None, signed: bool = False) -> str:
    """A ratio as a percentage, '–' where there is none."""
    return "–" if value is None else f"{100 * value:{'+' if signed else ''}.2g} %"


def verdict(numbers: dict[str, Any]) -> list[str]:
    """Sentences, the targets first."""
    return [*_tracking(numbers), *_distance(numbers), *_causes(numbers), *_sliding(numbers), *_ends(numbers)]


def _tracking(numbers: dict[str, Any]) -> list[str]:
    error, largest = numbers["fidelity"]["tracking_rms"], numbers["fidelity"]["tracking_largest"]
    if error is None:
        return []
    met = "Target met" if error < TRACKING_TARGET else "Target missed"
    text = (
        f"{met}: wheels of the rig follow the virtual train within {percent(error)} RMS of train speed (aim: below "
        f"{percent(TRACKING_TARGET)}), {percent(largest)} at most."
    )
    limited = numbers["rig"]["drive_limited_s"]
    if limited > 0.0:
        text += f" For {limited:.2g} s a roller drive was asked for more than its limit."
    return [text]


def _distance(numbers: dict[str, Any]) -> list[str]:
    relative, track, rig = numbers["fidelity"]["distance_relative"], numbers["track"], numbers["rig"]
    if relative is None:
        at_end = numbers["fidelity"]["distance_at_end_relative"]
        return [f"No stop to compare: at the end of the shorter run the distances differ by {percent(at_end, True)}."]
    met = "Target met" if abs(relative) <= DISTANCE_TARGET else "Target missed"
    return [
        f"{met}: stopping distance {track['distance_m']:.1f} m on track, {rig['distance_m']:.1f} m on the rig, "
        f"{percent(relative, True)} (aim: within {percent(DISTANCE_TARGET)})."
    ]


def _causes(numbers: dict[str, Any]) -> list[str]:
    shares, chance = numbers["causes"], numbers["spread"]
    if shares is None:
        return []
    ranked = sorted(shares, key=lambda cause: -abs(shares[cause]))
    parts = ", ".join(f"{CAUSE_WORDS[cause]} {percent(shares[cause], True)}" for cause in ranked)
    lines = [f"Where the difference of {percent(sum(shares.values()), True)} in distance comes from: {parts}."]
    known = [value for value in chance.values() if value is not None]
    if not known:
        return lines
    largest = max(known)
    both = ", ".join(f"{percent(value)} on the {label}" for label, value in chance.items() if value is not None)
    lines.append(
        f"Chance: begun 10 to 40 ms later, the same test ends in distances that range over {both}; less means nothing."
    )
    if abs(shares[ranked[0]]) > largest:
        lines.append(f"Responsible above all: {CAUSE_WORDS[ranked[0]]}.")
    else:
        lines.append("No cause stands out of chance.")
    return lines


def _sliding(numbers: dict[str, Any]) -> list[str]:
    text = f"Wheels slide on the rollers by at most {1e3 * numbers['rig']['real_sliding_largest_mps']:.3g} mm/s"
    ideal = numbers["variants"].get("rolling", {}).get("tracking_rms")
    if ideal is None:
        return [f"{text}."]
    real = numbers["fidelity"]["tracking_rms"]
    return [
        f"{text}; if they rolled ideally, the tracking error would be {percent(ideal)} instead of {percent(real)} RMS."
    ]


def _ends(numbers: dict[str, Any]) -> list[str]:
    labels = ("track", "rig")
    return [f"{label}: {numbers[label]['status_message']}" for label in labels if numbers[label]["status"] != "ok"]
