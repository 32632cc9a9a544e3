"""The report of a test programme: verdicts and sums first, then the stops side by side, then each of them.

results, numbers -> [wsp_sections] -> sections with tables and figures
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollerrig.analysis.slide_statistics import SLIP_EDGES
from rollerrig.config import Programme
from rollerrig.config.write.toml import to_toml
from rollerrig.plot.wsp import Ends, means_with_intervals, slip_grid, stop_over_time
from rollerrig.study.adhesion_verdicts import SHOWN
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Block, Picture, Preformatted, Section, Table, Text
from rollerrig.study.wsp_numbers import MEASURED, QUANTITIES
from rollerrig.study.wsp_text import NAMES, NOT_QUOTED, limit_text, value_text
from rollerrig.study.wsp_verdicts import SUPPORTS
from rollerrig.wording import number

FIRST = ("distance_m", "increase_over_dry", "k_wet", "mean_deceleration_mps2", "air_litres", "dump_cycles")
SECOND = ("adhesion_utilisation", "large_slip_share", "longest_lock_s", "flat_length_m")

CLAIMS = (
    NOT_QUOTED,
    "K_wet is 100 / (100 + increase over dry in %). Distances run from the demand to motion.stop_speed, at which the train "
    "counts as stationary; below 2 m/s no slip and no lock is counted.",
    "The length of a flat is an estimate of its order, from the energy dissipated under a locked wheel, (H1) and (H2) of "
    "docs/theory/wheel_flats.md; on the rig it is that of the train which the rig stands for, whose wheels would slide.",
    "Intervals are of 95 %, of the mean over starts whose first speeds differ by up to 3 mm/s: the limit cycle's phase. They say "
    "nothing of what differs from one vehicle, rail or day to another.",
    "Eight tests out of eight within a limit say with 95 % that at least 69 % of all such tests are.",
)


def wsp_sections(programme: Programme, results: Mapping[str, Any], numbers: Numbers) -> list[Section]:
    """All sections of the report."""
    return [
        Section("Verdict", [_overview(programme, numbers), _sums(numbers)]),
        Section("Criteria", [_criteria(numbers)]),
        Section("Stops", [*_stop_tables(numbers), *_pictures(results, numbers)]),
        *_each_stop(results, numbers),
        Section("What is not claimed", [Text(text) for text in CLAIMS]),
        Section("Programme", [Preformatted(f"The whole programme: {programme.name}", to_toml(programme))]),
    ]


def _shown(word: str | None) -> str:
    return "–" if word is None else SHOWN[word]


def _overview(programme: Programme, numbers: Numbers) -> Table:
    described = {stop.name: stop.description for stop in programme.stop}
    rows = []
    for name, one in numbers["stops"].items():
        same = one["rig_like_track"]
        words = [_shown(one[on]["verdict"]) for on in SUPPORTS]
        text = ", ".join(filter(None, (one["kind"], f"{one['speed_kmh']:.4g} km/h", described[name])))
        rows.append((*words, name.replace("_", " "), text, _shown(same["tracking"]), _shown(same["fidelity"])))
    header = ("on track", "on the rig", "stop", "", "rig follows its virtual axles", "rig as the track")
    return Table(header, rows, "All criteria of each stop; and the verdict on the rig itself.")


def _sums(numbers: Numbers) -> Table:
    names = ("distance_m", "air_litres", "dump_cycles", "longest_lock_s", "flat_length_m")
    entries: dict[str, Numbers] = {
        on: {f"sums.*.{name}": numbers["sums"][on][name] for name in names} for on in SUPPORTS
    }
    return QUANTITIES.table(
        entries, [f"sums.*.{name}" for name in names], "All stops: sums of means; worst of all tests.", ""
    )


def _criteria(numbers: Numbers) -> Table:
    rows = []
    for stop, own in numbers["stops"].items():
        for name, one in own["criteria"].items():
            found = [one.get(on, {"verdict": None, "mean": None, "why": ""}) for on in SUPPORTS]
            whys = dict.fromkeys(two["why"] for two in found if two["why"])
            rows.append((
                *(_shown(two["verdict"]) for two in found), stop.replace("_", " "), NAMES[name],
                *(value_text(name, two) for two in found), limit_text(name, one), one["clause"] or "–",
                "; ".join((*whys, one["origin"])),
            ))  # fmt: skip
    header = (
        "on track",
        "on the rig",
        "stop",
        "criterion",
        "track",
        "rig",
        "limit",
        "clause",
        "why nothing is decided; who set it",
    )
    return Table(
        header, rows, "Every criterion: means of all starts (intervals of 95 %)." if rows else "No limit is set."
    )


def _stop_tables(numbers: Numbers) -> Iterator[Table]:
    for names, caption in ((FIRST, "Distances, air, ventings."), (SECOND, "Sliding.")):
        labels = [QUANTITIES[f"stops.*.*.{name}.mean"].heading for name in names]
        rows = [
            (stop.replace("_", " "), on, *(_ends_text(name, own[on][name]) for name in names))
            for stop, own in numbers["stops"].items()
            for on in SUPPORTS
        ]
        yield Table(("stop", "on", *labels), rows, f"{caption} Means of all starts, with intervals of 95 %.")


def _ends_text(name: str, one: Numbers) -> str:
    shown = next(row[4] for row in MEASURED if row[0] == name)
    factor = shown[1] if shown else 1.0
    if one["mean"] is None:
        return "–"
    mean = number(factor * one["mean"])
    if one["low"] is None or one["high"] is None or one["low"] == one["high"]:
        return mean
    return f"{mean} ± {number(0.5 * factor * (one['high'] - one['low']), 2)}"


def _pictures(results: Mapping[str, Any], numbers: Numbers) -> Iterator[Block]:
    stops = numbers["stops"]
    dry = [one["track"]["dry_distance_m"] for one in stops.values()]
    caption = "Distance since the demand, mean and interval of 95 %, and the dry distance of the same speed and demand."
    yield Picture(
        "distances", means_with_intervals(list(stops), _ends(stops, "distance_m"), "distance [m]", dry=dry), caption
    )
    stopping = {name: one for name, one in stops.items() if one["track"]["k_wet"]["mean"] is not None}
    if stopping:
        limits = [one["criteria"].get("k_wet", {}).get("limit") for one in stopping.values()]
        caption = (
            "K_wet: dry distance over distance, mean and interval of 95 %; diamonds: least that the programme allows."
        )
        found = means_with_intervals(list(stopping), _ends(stopping, "k_wet"), "K_wet [-]", limits=limits)
        yield Picture("k_wet", found, caption)
    shares: dict[str, dict[str, NDArray[np.float64]]] = {
        name: {on: np.mean([test.slip_shares for test in one.tests[on].tests], axis=0) for on in SUPPORTS}
        for name, one in results.items()
    }
    caption = "Part of the time that the axles spent at a slip, mean of all starts, while the brake acts above 2 m/s."
    yield Picture("slip_histograms", slip_grid(SLIP_EDGES, shares), caption)


def _ends(stops: Mapping[str, Numbers], name: str) -> dict[str, list[Ends | None]]:
    return {on: [_three(one[on][name]) for one in stops.values()] for on in SUPPORTS}


def _three(one: Numbers) -> Ends | None:
    if one["mean"] is None:
        return None
    low, high = (np.nan if one[end] is None else one[end] for end in ("low", "high"))
    return one["mean"], low, high


def _each_stop(results: Mapping[str, Any], numbers: Numbers) -> Iterator[Section]:
    for name, one in results.items():
        own = numbers["stops"][name]
        rows = []
        for measure, *_ in MEASURED:
            heading = QUANTITIES[f"stops.*.*.{measure}.mean"].heading
            rows.append((heading, *(_ends_text(measure, own[on][measure]) for on in SUPPORTS)))
        table = Table(
            ("", *SUPPORTS),
            rows,
            f"Means of {own['track']['tests']} and {own['rig']['tests']} tests ± half an interval of 95 %.",
        )
        blocks: list[Block] = [table]
        if all(one.signals[on] for on in SUPPORTS):
            caption = f"{name.replace('_', ' ')}: the first tests on track and on the rig."
            blocks.insert(0, Picture(f"stop_{name}", stop_over_time(one.signals), caption))
        yield Section(f"Stop {name.replace('_', ' ')}", blocks)
