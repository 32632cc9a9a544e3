"""Reported numbers of a test programme, from the tests of its stops.

StopTests, judgements -> [wsp numbers] -> numbers of summary.json, each explained in QUANTITIES; rows of the CSV files
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rollerrig.config import CRITERIA
from rollerrig.study.adhesion_verdicts import GROUPS, verdict_rows
from rollerrig.study.adhesion_verdicts import verdict_of as group_verdict
from rollerrig.study.ensemble import estimate
from rollerrig.study.quantities import Quantities, Quantity
from rollerrig.study.wsp_verdicts import SUPPORTS, Judgement, StopTests, Support, counts, verdict_of

Tests = Mapping[Support, StopTests]
PERCENT = ("%", 100.0)
MEASURED = (
    ("distance_m", "run by the train since the demand, on the rig by the virtual one", "m", "distance", None),
    ("increase_over_dry", "distance over that of the dry stop, less 1", "1", "increase over dry", PERCENT),
    ("k_wet", "100 / (100 + increase over dry in %): dry distance over distance", "1", "K_wet", None),
    ("mean_deceleration_mps2", "of the train since the demand, over the distance", "m/s^2", "mean deceleration", None),
    ("duration_s", "time at the end of the test", "s", "duration", None),
    ("speed_end_kmh", "of the train at the end", "km/h", "speed at the end", None),
    (
        "adhesion_utilisation",
        "creep forces over what the rail's friction at no slip would give, both summed over braked axles and time",
        "1",
        "adhesion utilisation",
        None,
    ),
    ("mean_slip", "mean |wheel speed - train speed| over train speed, above 2 m/s", "1", "", PERCENT),
    ("largest_slip", "largest of the same", "1", "", PERCENT),
    ("large_slip_share", "part of the time at a slip above 30 %", "1", "time at slip above 30 %", PERCENT),
    ("longest_lock_s", "longest time that an axle turned slower than 5 % of the train", "s", "longest lock", None),
    (
        "flat_length_m",
        "estimated length of the longest flat of a locked wheel, (H2)",
        "m",
        "flat, estimated",
        ("mm", 1e3),
    ),
    ("air_litres", "air at ambient pressure taken by the cylinders of the axles under test", "l", "air", None),
    ("dump_cycles", "times that dump valves opened to vent, all axles under test", "1", "ventings", None),
    ("energy_relative_residual", "energy audit", "1", "residual of the energy audit", None),
    ("contact_lost_s", "longest time of a wheel without contact", "s", "longest loss of contact", None),
)
ENDS = (("mean", "mean of all starts", 4), ("low", "lower end of its interval of 95 %", 4), ("high", "upper end", 4))


def _measured() -> list[Quantity]:
    found = []
    for name, meaning, unit, label, shown in MEASURED:
        heading = label or " ".join(name.split("_"))
        for end, text, digits in (*ENDS, ("largest", "largest of all starts", 4)):
            whole = f"{meaning}; {text}" if end == "mean" else text
            found.append(Quantity(f"stops.*.*.{name}.{end}", whole, unit, heading, digits, shown))
    return found


QUANTITIES = Quantities(
    Quantity("case", "name of the case"),
    Quantity("programme", "name of the programme"),
    Quantity("starts", "tests of each stop on each support, which differ by up to 3 mm/s in their first speed", "1"),
    Quantity("starts_needed", "without which nothing is decided", "1"),
    Quantity("stops.*.kind", "kind of the stop"),
    Quantity("stops.*.speed_kmh", "of the train at the demand", "km/h", "speed"),
    Quantity("stops.*.*.verdict", "of all criteria of the stop: met, not met, not decided; null: none is judged"),
    Quantity("stops.*.*.tests", "that were made", "1"),
    Quantity("stops.*.*.stopped", "in which the train came to a stop", "1"),
    Quantity("stops.*.*.dry_distance_m", "of the same stop on a dry rail", "m", "dry distance"),
    _measured(),
    Quantity("stops.*.criteria.*.limit", "in the SI unit of the criterion"),
    Quantity("stops.*.criteria.*.kind", "at least or at most"),
    Quantity("stops.*.criteria.*.origin", "who set it, and why"),
    Quantity("stops.*.criteria.*.clause", "of the standard that it is taken from, as the programme has it"),
    Quantity("stops.*.criteria.*.*.verdict", "met: the whole interval is within the limit; not met: nothing of it"),
    Quantity("stops.*.criteria.*.*.mean", "mean of all starts, in the unit of the limit"),
    Quantity("stops.*.criteria.*.*.low", "lower end of its interval of 95 %"),
    Quantity("stops.*.criteria.*.*.high", "upper end"),
    Quantity("stops.*.criteria.*.*.worst", "of all starts; with a lock or a flat each start must be within the limit"),
    Quantity("stops.*.criteria.*.*.why", "why nothing is decided"),
    Quantity("stops.*.rig_like_track.*", "verdict on the rig: tracking of the virtual axles, fidelity to the track"),
    Quantity("sums.*.criteria.*", "number of criteria of all stops: met, not met, not decided", "1"),
    Quantity("sums.*.distance_m", "of all stops, means", "m", "distance"),
    Quantity("sums.*.air_litres", "of all stops, means", "l", "air"),
    Quantity("sums.*.dump_cycles", "of all stops, means", "1", "ventings"),
    Quantity("sums.*.longest_lock_s", "of all tests", "s", "longest lock"),
    Quantity("sums.*.flat_length_m", "of all tests", "m", "longest flat, estimated", 4, ("mm", 1e3)),
)


def stop_numbers(tests: Tests, judged: Sequence[Judgement]) -> dict[str, Any]:
    """Of one stop."""
    track, rig = tests["track"], tests["rig"]
    rows = verdict_rows(rig.case, track.tests, rig.tests)
    return {
        "kind": track.stop.kind,  # type: ignore[attr-defined]
        "speed_kmh": 3.6 * track.stop.speed,
        **{on: _support_numbers(tests[on], [one for one in judged if one.support == on]) for on in SUPPORTS},
        "criteria": _criteria(judged),
        "rig_like_track": {group: group_verdict(rows, group) for group in GROUPS},
    }


def _support_numbers(found: StopTests, judged: Sequence[Judgement]) -> dict[str, Any]:
    numbers: dict[str, Any] = {
        "verdict": verdict_of(judged),
        "tests": len(found.tests),
        "stopped": sum(one.stopped for one in found.tests),
        "dry_distance_m": None if found.dry is None else found.dry.measures["distance_m"],
    }
    for name, *_ in MEASURED:
        values = found.values(name)
        mean = estimate(values)
        ends = {"mean": mean.mean, "low": mean.interval.low, "high": mean.interval.high}
        numbers[name] = {**ends, "largest": max(values) if np.isfinite(values).all() else None}
    return numbers


def _criteria(judged: Sequence[Judgement]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for one in judged:
        limit = one.limit
        kind = "at least" if CRITERIA[limit.criterion].least else "at most"
        head = {"limit": limit.value, "kind": kind, "origin": limit.origin, "clause": limit.clause}
        interval = one.mean.interval
        found.setdefault(limit.criterion, head)[one.support] = {
            "verdict": one.verdict,
            "mean": one.mean.mean,
            "low": interval.low,
            "high": interval.high,
            "worst": one.worst,
            "why": one.why,
        }
    return found


def sum_numbers(stops: Sequence[Tests], judged: Sequence[Judgement]) -> dict[str, Any]:
    """Of all stops."""
    found: dict[str, Any] = {}
    for on in SUPPORTS:
        own = [tests[on] for tests in stops]
        means = {
            name: sum(float(np.mean(one.values(name))) for one in own)
            for name in ("distance_m", "air_litres", "dump_cycles")
        }
        worst = {name: max(max(one.values(name)) for one in own) for name in ("longest_lock_s", "flat_length_m")}
        found[on] = {"criteria": counts([one for one in judged if one.support == on]), **means, **worst}
    return found


# -------------------------------------------------------------------------------------------------------- CSV files


def test_rows(tests: Tests) -> list[list[object]]:
    """A line per test of a stop, header first."""
    names = [name for name, *_ in MEASURED]
    rows: list[list[object]] = [["support", "start", "status", *names]]
    for on in SUPPORTS:
        found = tests[on]
        columns = [found.values(name) for name in names]
        for number, one in enumerate(found.tests):
            rows.append([on, number + 1, one.status, *(column[number] for column in columns)])
    return rows


test_rows.__test__ = False  # type: ignore[attr-defined]  # the name is no test's


def signal_columns(signals: Mapping[Support, Mapping[str, Any]]) -> Mapping[str, Any]:
    """Signals of the first tests, rig beside track, as long as both ran."""
    count = min((len(next(iter(one.values()))) for one in signals.values() if one), default=0)
    found: dict[str, Any] = {}
    for on, own in signals.items():
        for name, values in own.items():
            found.setdefault(name if name == "time_s" else f"{name}_{on}", values[:count])
    return found
