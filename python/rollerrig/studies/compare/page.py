"""The report of the comparison: tables and sentences, made from its numbers.

CompareResults, pictures -> [page] -> report.Page
"""

from __future__ import annotations

import math

import numpy as np

from rollerrig import __version__
from rollerrig.config import Rig
from rollerrig.report import Figure, Page, Preformatted, Section, Table, Text
from rollerrig.report.page import Block
from rollerrig.studies.compare.compute import CompareResults
from rollerrig.studies.compare.critical import (
    cause_rows,
    cause_sentence,
    cell,
    order_sentences,
    radius_words,
    table_rows,
    words,
)
from rollerrig.studies.compare.figures import CAPTIONS

AT_MM = (1.0, 2.0, 3.0, 4.0, 5.0)
"""Amplitudes whose conicity is quoted [mm]."""

WHEEL_HEADER = (
    "wheel",
    "on",
    "Q [kN]",
    "Y [kN]",
    "longitudinal creep force [N]",
    "patches",
    "deepest approach [µm]",
    "largest a × b [mm²]",
    "Σ f₁₁ [MN]",
)

DISTURBED = {
    "guiding_force": ("largest |Y| [kN]", 1e-3),
    "guiding_force_sum": ("largest |ΣY|, 2 m mean [kN]", 1e-3),
    "longitudinal_force": ("largest |longitudinal force| [kN]", 1e-3),
    "wheel_unloading": ("largest wheel unloading [%]", 1e2),
    "derailment_quotient": ("largest |Y/Q|, 2 m mean [-]", 1.0),
    "wear_number": ("largest wear number Tγ [N]", 1.0),
}
"""Variable of the readings -> heading and factor; all of the leading wheelset."""


def compare_page(results: CompareResults, pictures: dict[str, bytes]) -> Page:
    """The whole report."""

    def picture(*names: str) -> list[Block]:
        return [Figure(pictures[n], CAPTIONS[n]) for n in names if n in pictures] or [Text("Not computed.")]

    size = 1e3 * results.plan.hunting.disturbance
    sections = [
        Section(
            "Critical speeds",
            [
                critical_table(results),
                Text(
                    f"By disturbance: runs of {results.plan.hunting.duration:g} s after a lateral offset of {size:g} mm of the "
                    "leading wheelset. A linear critical speed is that of small motions."
                ),
                *picture("hunting", "amplitude"),
            ],
        ),
        Section("Modes", picture("modes")),
        Section("Radius of the rollers", radius_blocks(results, picture("radius"))),
        Section("Where the difference comes from", cause_blocks(results, picture("causes"))),
        Section("Wheel forces", force_blocks(results, picture("disturbed"))),
        Section("Contact characteristics", characteristics_blocks(results, picture("characteristics"))),
        Section("What was compared", setting_blocks(results)),
    ]
    name = next(iter(results.plan.cases.values())).vehicle
    title = f"{name.data.name}, {words(name.cut)}: {' and '.join(results.plan.cases)} side by side"
    return Page(title, lead(results), sections, f"rollerrig {__version__}")


# ----------------------------------------------------------------------------------------------------- sentences


def lead(results: CompareResults) -> str:
    """What came out, in a few sentences."""
    lines = ["Interrupted: what was computed until then."] if results.interrupted else []
    for label in results.plan.cases:
        if label not in results.critical:
            continue
        found = results.runs.get(label)
        text = f"On {label}: linear critical speed {cell(results.critical[label])}{_unit(results, label)}"
        if found is not None and found.runs:
            text += f", hunting from a disturbance {_onset(found.decays, found.persists)}"
        lines.append(text + ".")
    lines += _ratios(results)
    if results.causes is not None and math.isfinite(results.causes.loss):
        lines.append(cause_sentence(results.causes))
    return "\n".join(lines)


def _unit(results: CompareResults, label: str) -> str:
    scan = results.critical.get(label)
    return "" if scan is None or scan.problem else " km/h"


def _onset(decays: float, persists: float) -> str:
    if math.isfinite(persists) and math.isfinite(decays):
        return f"between {3.6 * decays:.1f} and {3.6 * persists:.1f} km/h"
    if math.isfinite(persists):
        return f"already at {3.6 * persists:.1f} km/h"
    return f"not up to {3.6 * decays:.1f} km/h"


def _ratios(results: CompareResults) -> list[str]:
    """How far each support's critical speeds are from the last one's."""
    *others, last = results.plan.cases
    lines = []
    for label in others:
        parts = []
        for kind, of in (("linear", results.linear_kmh), ("by disturbance", results.by_disturbance_kmh)):
            change = of(label) / of(last) - 1
            if math.isfinite(change):
                parts.append(
                    f"the {kind} critical speed is {100 * abs(change):.1f} % {'lower' if change < 0 else 'higher'}"
                )
        if parts:
            lines.append(f"Against {last}, on {label} {' and '.join(parts)}.")
    return lines


# -------------------------------------------------------------------------------------------------------- tables


def critical_table(results: CompareResults) -> Table:
    """Critical speeds on each support, linear and by disturbance."""
    rows = []
    for label in results.plan.cases:
        scan, found = results.critical.get(label), results.runs.get(label)
        critical = scan.onset if scan else None
        cycle = next((run for run in found.runs if run.persists and run.valid), None) if found else None
        rows.append(
            (
                label,
                cell(scan) + _unit(results, label),
                f"{critical.frequency:.2f} Hz" if critical else "–",
                critical.name if critical else "–",
                _onset(found.decays, found.persists) if found and found.runs else "not computed",
                f"{1e3 * cycle.ending.amplitude:.2f} mm, {cycle.ending.frequency:.2f} Hz" if cycle else "–",
            )
        )
    header = ("on", "linear critical speed", "its frequency", "mode", "hunting from a disturbance", "limit cycle there")
    return Table(header, rows)


def radius_blocks(results: CompareResults, pictures: list[Block]) -> list[Block]:
    """Critical speeds over the rollers' radius."""
    if results.table is None or not results.table.found:
        return [Text("Not computed.")]
    header, rows = table_rows(results.table)
    caption = (
        "Linear critical speeds. The rollers have the head and the gauge of the rig compared, the track the same head; only the "
        "radius changes."
    )
    return [Table(header, rows, caption), *(Text(line) for line in order_sentences(results.table)), *pictures]


def cause_blocks(results: CompareResults, pictures: list[Block]) -> list[Block]:
    """The split of the loss."""
    if results.causes is None or not results.causes.found:
        return [Text("Not computed.")]
    header, rows = cause_rows(results.causes)
    caption = "Linear critical speed, track less rig, split by switching the four effects of a roller (contact.roller_effects)."
    return [
        Text(cause_sentence(results.causes)),
        *pictures,
        Table(header, rows, caption),
        Text(
            "The effects are not independent: what one of them costs depends on which others are there. So they are looked at "
            "from both ends, and what the sums leave is stated. With all four off the rig is the track of the same head."
        ),
    ]


def force_blocks(results: CompareResults, pictures: list[Block]) -> list[Block]:
    """Static forces, and forces after a disturbance."""
    blocks: list[Block] = []
    if results.states:
        speed = 3.6 * next(iter(results.states.values())).speed
        rows = [
            (wheel, label, *wheel_numbers(results, label, wheel))
            for wheel in _wheels(results)
            for label in results.states
        ]
        blocks.append(
            Table(WHEEL_HEADER, rows, f"Steady rolling at {speed:g} km/h. Y of the wheel on the rail, outwards.")
        )
    if results.disturbed:
        size = 1e3 * results.plan.hunting.disturbance
        header = ["on", *(heading for heading, _ in DISTURBED.values())]
        numbers = [[label, *(f"{v:.3g}" for v in disturbed_numbers(run))] for label, run in results.disturbed.items()]
        caption = (
            f"The leading wheelset after a lateral offset of {size:g} mm at {results.disturbed_kmh:g} km/h, where it is "
            "stable on all supports; filtered as in EN 14363 but for the longitudinal force."
        )
        blocks += [*pictures, Table(header, numbers, caption)]
    return blocks or [Text("Not computed.")]


def _wheels(results: CompareResults) -> list[str]:
    return [str(w) for w in next(iter(results.states.values())).wheels["wheel"].to_numpy()]


def wheel_numbers(results: CompareResults, label: str, wheel: str) -> list[float]:
    """The cells of WHEEL_HEADER after the first two."""
    state = results.states[label]
    own = state.wheels.sel(wheel=wheel)
    outwards = -1.0 if wheel.endswith("left") else 1.0
    return [
        round(1e-3 * float(own["vertical_force"]), 3),
        round(outwards * 1e-3 * float(own["lateral_force"]), 3),
        round(float(own["longitudinal_force"]), 2),
        int(own["patch_count"]),
        1e6 * float(own["patch_approach"].max()),
        1e6 * float((own["patch_a"] * own["patch_b"]).max()),
        1e-6 * state.creep_stiffness[wheel],
    ]


def disturbed_numbers(run: object) -> list[float]:
    """Largest magnitudes of the leading wheelset, in the order of DISTURBED."""
    leading = str(run.attrs["leading"])  # type: ignore[attr-defined]
    numbers = []
    for name, (_, factor) in DISTURBED.items():
        values = run[name]  # type: ignore[index]
        if "wheel" in values.dims:
            values = values.sel(wheel=[f"{leading}_left", f"{leading}_right"])
        if "wheelset" in values.dims:
            values = values.sel(wheelset=leading)
        numbers.append(factor * float(np.abs(values).max()))
    return numbers


def characteristics_blocks(results: CompareResults, pictures: list[Block]) -> list[Block]:
    """Conicities and the picture."""
    if not results.conicity:
        return [Text("Not computed.")]
    rows = []
    for label, table in results.conicity.items():
        reached = 1e3 * float(table["amplitude"][-1])
        cells = [float(table["conicity"].sel(amplitude=1e-3 * mm, method="nearest")) for mm in AT_MM if mm <= reached]
        rows.append((label, *cells, *("–" for _ in AT_MM[len(cells) :])))
    header = ("on", *(f"{mm:g} mm" for mm in AT_MM))
    return [
        Table(
            header, rows, "Equivalent conicity (EN 15302) over the amplitude; on rollers with the rollers' own radii."
        ),
        *pictures,
    ]


def setting_blocks(results: CompareResults) -> list[Block]:
    """Supports, and the whole configurations folded away."""
    rows = []
    for label, case in results.plan.cases.items():
        support = case.support.data
        radius = support.roller_radius if isinstance(support, Rig) else math.inf
        rows.append((label, support.name, support.description, radius_words(radius), support.source))
    held = next(iter(results.plan.cases.values()))
    return [
        Table(("label", "support", "what it is", "radius", "source"), rows),
        Text(
            f"Vehicle: {held.vehicle.data.description}. Part: {words(held.vehicle.cut)}; held: "
            f"{', '.join(words(b) for b in held.vehicle.part.fixed) or 'nothing but its way along the track'}. Material "
            f"{held.contact.material.name}, friction {held.contact.friction:g}, creep law {held.contact.creep}. Rollers and "
            "rails are held at each speed."
        ),
        *(
            Preformatted(f"The whole configuration: {label}", case.to_toml())
            for label, case in results.plan.cases.items()
        ),
    ]
