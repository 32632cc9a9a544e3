"""The first lines of a run's report: what the vehicle did, whether it was safe, how the computation ended.

numbers of a run, what is left of its sideways motion, assessed forces -> [run_text] -> lines
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rollerrig.analysis.assessment import Row
from rollerrig.analysis.lateral_rest import LateralRest
from rollerrig.study.quantities import Numbers
from rollerrig.wording import number

_LIMITED = {"derailment_quotient": "Y/Q", "guiding_force_sum": "ΣY"}
"""Quantities with a limit."""


def rest_numbers(rest: LateralRest) -> dict[str, Any]:
    """As they stand in summary.json."""
    final = rest.final
    return {
        "body": rest.body,
        "amplitude_mm": 1e3 * final.amplitude,
        "frequency_hz": final.frequency,
        "growth_rate_per_s": final.rate,
        "persists": rest.persists,
    }


def answer(numbers: Numbers, rest: LateralRest | None, rows: Sequence[Row]) -> list[str]:
    """The findings, the one that the run was made for first."""
    lines = [] if rest is None else [_rest(rest)]
    if safe := _safety(rows):
        lines.append(safe)
    lines.append(f"{numbers['case']}: {numbers['stopped_at_s']:g} s computed. {numbers['status_message']}")
    speeds = ""
    if numbers["samples"]:
        speeds = f"Speed {numbers['speed_start_kmh']:.4g} km/h at the start, {numbers['speed_end_kmh']:.4g} km/h at the end. "
    lines.append(
        f"{speeds}Energy balance closed to {number(numbers['energy_relative_residual'], 2)} of the "
        f"{number(numbers['energy_turned_over_j'] / 1e3)} kJ turned over."
    )
    return [*lines, *(f"Warning: {line}." for line in numbers["warnings"].splitlines())]


def _rest(rest: LateralRest) -> str:
    body, final = rest.body.replace("_", " "), rest.final
    motion = f"by ±{number(1e3 * final.amplitude, 2)} mm at {number(final.frequency, 2)} Hz"
    if rest.persists:
        return f"It hunts: in the last third of the run {body} still moves sideways {motion}."
    was = f"by up to {number(1e3 * rest.largest, 2)} mm"
    if final.amplitude == 0.0:
        return f"It calms down: {body} moved sideways {was}, and no longer does so in the last third of the run."
    return f"It calms down: {body} moved sideways {was}, in the last third of the run {motion}, and less and less."


def _safety(rows: Sequence[Row]) -> str:
    """The quantities with a limit, each where it comes nearest to it."""
    nearest: dict[str, Row] = {}
    for row in rows:
        if row.quantity in _LIMITED and math.isfinite(row.part_of_limit):
            other = nearest.get(row.quantity)
            if other is None or row.part_of_limit > other.part_of_limit:
                nearest[row.quantity] = row
    if not nearest:
        return ""
    beyond = any(row.part_of_limit > 1.0 for row in nearest.values())
    parts = (
        f"{_LIMITED[name]} reaches {number(100.0 * row.part_of_limit, 2)} % ({row.place.replace('_', ' ')})"
        for name, row in nearest.items()
    )
    return f"Running safety: {' and '.join(parts)} of the limit{', which it exceeds' if beyond else ''}."
