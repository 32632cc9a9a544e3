"""The limit-cycle diagram as a study reports it: numbers, sentence, figure, table of all runs.

Diagram -> [limit_cycle_report] -> summary.json, limit_cycles.csv, blocks of the report
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import xarray as xr

from rollerrig.analysis import Diagram, LimitCycleSettings, limit_cycle_table
from rollerrig.analysis.limit_cycle import KIND_SENTENCES, CyclePoint
from rollerrig.plot import limit_cycle_diagram
from rollerrig.study.critical_speeds import ended_early
from rollerrig.study.quantities import Quantities, Quantity
from rollerrig.study.report import Block, Picture, Text

POINT = "limit_cycles.points.*"
POINTS = (
    Quantity(
        f"{POINT}.sweep", "up: from a small perturbation at each speed; down: from the limit cycle of the speed before"
    ),
    Quantity(f"{POINT}.speed_kmh", "of the run", "km/h", "speed", 5),
    Quantity(f"{POINT}.amplitude_mm", "half the range of the wheelset that moves most; 0: rest", "mm", "amplitude"),
    Quantity(f"{POINT}.peak_mm", "its largest displacement", "mm", "peak"),
    Quantity(f"{POINT}.frequency_hz", "of the limit cycle", "Hz", "frequency", 3),
    Quantity(f"{POINT}.guiding_force_n", "largest |Y|, unfiltered", "N", "largest |Y|", 3, ("kN", 1e-3)),
    Quantity(f"{POINT}.growth_rate_at_end_per_s", "of the amplitude", "1/s", "growth rate at the end", 2),
    Quantity(f"{POINT}.settled", "whether the amplitude has settled"),
    Quantity(f"{POINT}.duration_s", "simulated", "s", "time", 3),
    Quantity(f"{POINT}.status", "how the run ended"),
)
QUANTITIES = (
    Quantity("limit_cycles.bifurcation", "none, subcritical, supercritical, detached, unstable throughout, or open"),
    Quantity("limit_cycles.critical_speed_by_continuation_kmh", "lowest speed with a lasting limit cycle; null: none", "km/h"),
    Quantity("limit_cycles.decays_kmh", "highest speed below it at which every motion comes to rest", "km/h"),
    Quantity("limit_cycles.jump_up_kmh", "lowest speed run at which the perturbation grows into a limit cycle", "km/h"),
    Quantity("limit_cycles.hysteresis_kmh", "lowest and highest speed at which the sweeps end differently; null: none", "km/h"),
    Quantity("limit_cycles.tolerance_kmh", "to which the critical speed by continuation was looked for", "km/h"),
    Quantity("limit_cycles.disturbance_mm", "lateral offset of the leading wheelset at the start of the downward sweep", "mm"),
    Quantity("limit_cycles.perturbation_mm", "the same on the upward sweep", "mm"),
    Quantity("limit_cycles.ended_early", "number of runs that did not come to their end: neither limit cycle nor rest"),
    *POINTS,
)  # fmt: skip


def cycle_numbers(found: Diagram, settings: LimitCycleSettings) -> dict[str, Any]:
    """The diagram and what follows from it."""
    sweeps: tuple[tuple[str, list[CyclePoint]], ...] = (("up", found.up), ("down", found.down))
    return {
        "bifurcation": found.kind,
        "critical_speed_by_continuation_kmh": 3.6 * found.lowest_cycle,
        "decays_kmh": 3.6 * found.decays,
        "jump_up_kmh": 3.6 * found.jumps,
        "hysteresis_kmh": None if found.hysteresis is None else [3.6 * v for v in found.hysteresis],
        "tolerance_kmh": settings.tolerance_kmh,
        "disturbance_mm": 1e3 * settings.disturbance,
        "perturbation_mm": 1e3 * settings.perturbation,
        "ended_early": len(found.ended_early),
        "points": [
            {
                "sweep": sweep,
                "speed_kmh": round(3.6 * point.speed, 6),
                "amplitude_mm": 1e3 * point.amplitude,
                "peak_mm": 1e3 * point.peak,
                "frequency_hz": point.frequency,
                "guiding_force_n": point.guiding_force,
                "growth_rate_at_end_per_s": point.rate,
                "settled": point.settled,
                "duration_s": point.duration,
                "status": point.status,
            }
            for sweep, points in sweeps
            for point in points
        ],
    }


def continuation_sentences(found: Diagram) -> list[str]:
    """The critical speed by continuation, the kind of bifurcation, and which runs did not come to their end."""
    runs = [*found.up, *found.down]
    if not runs:
        return ["Limit cycles: no run was finished."]
    early = ended_early([(p.speed, p.message) for p in found.ended_early], len(runs))
    return [_continuation(found), early] if early else [_continuation(found)]


def _continuation(found: Diagram) -> str:
    if not math.isfinite(found.lowest_cycle):
        decaying = [p.speed for p in (*found.up, *found.down) if p.decays]
        if not decaying:
            return "Critical speed by continuation: not found, no run came to its end."
        if found.ended_early:
            return (
                f"No limit cycle was found; the disturbance decays in the {len(decaying)} runs that came to their end."
            )
        return f"No limit cycle up to {3.6 * max(decaying):.1f} km/h: every disturbance decays."
    text = f"Critical speed by continuation: {3.6 * found.lowest_cycle:.1f} km/h, the lowest with a limit cycle"
    rest = (
        f"; at {3.6 * found.decays:.1f} km/h every motion comes to rest"
        if math.isfinite(found.decays)
        else " and the lowest run that came to its end"
    )
    text += f"{rest}. {KIND_SENTENCES[found.kind]}"
    if found.hysteresis is not None:
        low, high = (f"{3.6 * v:.1f}" for v in found.hysteresis)
        where = f"At {low} km/h" if low == high else f"From {low} to {high} km/h"
        text += f" {where} the upward and the downward sweep end differently."
    return text


def cycle_blocks(
    found: Diagram, modes: xr.Dataset, settings: LimitCycleSettings, points: Sequence[Mapping[str, Any]]
) -> list[Block]:
    """The section of a report.

    Args:
        found: the diagram.
        modes: Dataset of `stability`.
        settings: of the runs.
        points: of `cycle_numbers`.
    """
    blocks: list[Block] = [Text(sentence) for sentence in continuation_sentences(found)]
    if points:
        caption = (
            "What each run ends in, with the speed stepped up and stepped down. Amplitude: half the range of the lateral "
            "displacement of the wheelset that moves most. |Y|: unfiltered; where flanges strike rigid rails it is short and "
            "very high. A run that did not come to its end has no point; how it ended is written in its place."
        )
        blocks.append(Picture("limit_cycles", limit_cycle_diagram(limit_cycle_table(found), modes), caption))
    method = (
        f"Way up: from a lateral offset of the leading wheelset of {1e3 * settings.perturbation:g} mm until a limit "
        f"cycle is reached. Way down: from {1e3 * settings.disturbance:g} mm at the highest speed, then from the "
        "limit cycle of the speed above; where that has decayed, from the same offset again. Each run lasts until its "
        f"amplitude has settled, or {settings.longest:g} s. The perturbation need not grow or decay as the linear "
        "model predicts: that is exact only as long as the contact stays on the smooth piece of the profiles around its "
        "position, often less than a tenth of a millimetre."
    )
    table = Quantities(POINTS).table(points, [quantity.key for quantity in POINTS], "All runs.")
    return [*blocks, Text(method), table]
