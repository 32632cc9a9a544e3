"""What the lateral study found, in words.

numbers by key of QUANTITIES -> [lateral_text] -> sentences
"""

from __future__ import annotations

from collections.abc import Iterator

from rollerrig.study.quantities import Numbers
from rollerrig.wording import number, percent


def control_text(numbers: Numbers) -> Iterator[str]:
    """How lateral motion disturbs the control of the rig."""
    runs, again = numbers["runs"], numbers["ensemble"]
    means = {"rig_centred": runs.get("rig_centred"), **{key: again.get(key) for key in ("rig", "rig_rigid")}}
    if not all(one and one["tracking_rms"] for one in means.values()):
        return
    errors = {key: one["tracking_rms"] for key, one in means.items() if one}
    yield (
        f"Tracking error, RMS of train speed: {percent(errors['rig_centred'])} while the bogie stays centred, "
        f"{percent(errors['rig_rigid'])} where it hunts on rigid rollers, {percent(errors['rig'])} on elastic ones "
        f"({number(errors['rig'] / errors['rig_centred'], 2)} times as much). Wheels then slide on the rollers at up to "
        f"{_interval(again['rig'])} m/s, rigid {_interval(again['rig_rigid'])} m/s, centred "
        f"{number(runs['rig_centred']['real_sliding_largest_mps'], 2)} m/s: means of runs whose disturbances differ by 10⁻⁹, and "
        "their standard errors, as flanges that strike move every single figure."
    )


def hunting_text(numbers: Numbers) -> Iterator[str]:
    """What becomes of hunting in a slide, on track and on the rig, and which of its causes ends it."""
    runs = numbers["runs"]

    def sizes(key: str) -> str:
        run = runs[key]
        return f"{number(run['amplitude_before_mm'], 2)} and {number(run['amplitude_in_slide_mm'], 2)} mm"

    def known(*keys: str) -> bool:
        return all(key in runs and runs[key]["amplitude_in_slide_mm"] is not None for key in keys)

    if known("track", "rig"):
        yield (
            "Hunting, amplitude of the leading wheelset before the slide and later than 1 s into it: on track "
            f"{sizes('track')}, on the rig {sizes('rig')}: its real wheels keep rolling on dry rollers."
        )
    if known("track_unbraked"):
        dies = runs["track_unbraked"]["amplitude_in_slide_mm"] < LEFT * runs["track_unbraked"]["amplitude_before_mm"]
        yield (
            f"On the same rail without braking it is {sizes('track_unbraked')} at these times: "
            + (
                "hunting dies there too, of the flatter creep curve of the contaminated rail (k_A, k_S) alone, and the run with "
                "braking does not show what sliding does."
                if dies
                else "it goes on, and the slide is what ends it."
            )
        )
    if known("track_stiff", "track_stiff_unbraked"):
        yield (
            f"With k_A = k_S = 1, where only friction is low, it is {sizes('track_stiff_unbraked')} unbraked and "
            f"{sizes('track_stiff')} braked: this pair separates the slide from the rail."
            + (
                f" With Polach's creep law it is {sizes('track_polach_stiff_unbraked')} unbraked: near the limit of friction it "
                "is softer."
                if known("track_polach_stiff_unbraked")
                else ""
            )
        )


def guidance_text(numbers: Numbers) -> Iterator[str]:
    """What is left of lateral creep on a sliding wheel, with which creep law."""
    laws = {"track": "the case's creep law", "track_paper": "the paper's law"}
    found = {law: numbers["guidance"][key] for key, law in laws.items() if key in numbers["guidance"]}
    if laws["track"] not in found:
        return
    own = found[laws["track"]]
    slopes = ", ".join(f"{one['slope']:z.2f} with {law}" for law, one in found.items())
    yield (
        f"What remains of lateral creep on a sliding wheel is viscous, {number(own['sliding_ns_per_m'], 3)} N s/m instead of "
        f"{number(own['rolling_ns_per_m'], 3)}. Against −F v_y/v_s its slope is {slopes}."
    )


LEFT = 0.2
"""Hunting of which less than this part is left has died [-]."""


def _interval(one: Numbers) -> str:
    """Largest sliding of an ensemble [m/s]; without an error where that is round-off."""
    mean, error = one["real_sliding_largest_mps"], one["real_sliding_largest_mps_standard_error"]
    return number(mean, 2) + (f" ± {number(error, 1)}" if error > 1e-3 * mean else "")
