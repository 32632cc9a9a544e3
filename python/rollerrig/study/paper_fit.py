"""Which material fits the paper's critical speed: intervals against 100 km/h, the material's effect, the sensitivity.

results of PaperStudy -> [paper_fit] -> paragraphs and a table of verdicts, each of which a whole interval supports
"""

from __future__ import annotations

import math

from rollerrig.study.contact_sensitivity import sensitivity_table
from rollerrig.study.critical_speeds import linear_cell
from rollerrig.study.interval import NOT_DECIDED, Interval, in_words
from rollerrig.study.paper_numbers import QUANTITIES
from rollerrig.study.paper_plan import MATERIALS, NAMES, PAPER_CRITICAL_KMH, PaperPlan, rig_case
from rollerrig.study.paper_results import Results
from rollerrig.study.paper_text import onset_wavelength
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Block, Table, Text

NEAR = 0.1
"""A critical speed within this share of the paper's fits it [1]."""

NAMELESS = (
    "The paper names its vehicle, but neither profiles nor friction nor the radius of its rollers; no parameter was tuned here "
    "to close the gap."
)
"""Why the paper's critical speed cannot be had."""


def critical_speeds(results: Results) -> dict[tuple[str, str], Interval]:
    """Material and definition -> where the critical speed of the bogie on the rig lies [km/h]; those that are known."""
    found = {}
    for material in MATERIALS:
        value = results.linear_kmh(material)
        found[material, "linear"] = Interval(value, value)
        found[material, "by disturbance"] = results.by_disturbance(material)
    return {key: one for key, one in found.items() if one.known}


def fits(speed: Interval) -> bool | None:
    """Whether a critical speed [km/h] is near the paper's; None: not decided."""
    return speed.within((1 - NEAR) * PAPER_CRITICAL_KMH, (1 + NEAR) * PAPER_CRITICAL_KMH)


def fit_paragraphs(results: Results) -> list[str]:
    """Which material the paper's critical speed fits, and why."""
    found = critical_speeds(results)
    if not found:
        return []
    texts = [f"The paper reports growing oscillations above {PAPER_CRITICAL_KMH:z.0f} km/h. {_nearest(found)}"]
    if all(m in results.contact for m in MATERIALS):
        texts.append(_effect_of_the_material(results))
    sensitivity = _sensitivity(results)
    return [*texts, sensitivity] if sensitivity else texts


def _nearest(found: dict[tuple[str, str], Interval]) -> str:
    """The nearest critical speed, where the intervals tell which it is."""
    distances = {key: one.distance(PAPER_CRITICAL_KMH) for key, one in found.items()}
    nearest = min(distances, key=lambda key: distances[key].high)
    if any(other.low < distances[nearest].high for key, other in distances.items() if key != nearest):
        return (
            f"Which critical speed is nearest to that is {NOT_DECIDED} at the width of the intervals below. {NAMELESS}"
        )
    (material, kind), speed = nearest, found[nearest]
    text = f"The nearest critical speed is that of {NAMES[material]} ({kind}), {speed.text('km/h', 1)}"
    others = [distance.low for (other, _), distance in distances.items() if other != material]
    text += f"; the other material differs from the paper by at least {min(others):z.0f} km/h. " if others else ". "
    verdict = fits(speed)
    if verdict:
        return f"{text}That is within a tenth of the paper's value."
    if verdict is None:
        return f"{text}Whether that is within a tenth of the paper's value is {NOT_DECIDED}. {NAMELESS}"
    off = Interval(100 * (speed.low / PAPER_CRITICAL_KMH - 1), 100 * (speed.high / PAPER_CRITICAL_KMH - 1))
    return f"{text}That is {_apart(off)} the paper's value: neither reproduces it. {NAMELESS}"


def _apart(off: Interval) -> str:
    """A deviation that is known to be on one side [%] in words."""
    if off.low > 0:
        return f"{off.text('%')} above"
    return f"{Interval(-off.high, -off.low).text('%')} below"


def fit_table(results: Results) -> Table | None:
    """Each critical speed against the paper's; None where there is none."""
    rows = []
    for (material, kind), speed in critical_speeds(results).items():
        off = Interval(*(100 * (end / PAPER_CRITICAL_KMH - 1) for end in (speed.low, speed.high)))
        rows.append([NAMES[material], kind, speed.text("km/h", 1), off.text("%"), in_words(fits(speed))])
    header = ("material", "critical speed", "computed", f"less {PAPER_CRITICAL_KMH:g} km/h", "within a tenth of it")
    caption = "Bogie on the rig against the paper's critical speed."
    return Table(header, rows, caption) if rows else None


def _effect_of_the_material(results: Results) -> str:
    steel, soft = (results.contact[m] for m in MATERIALS)
    moduli = [rig_case(m).contact.material.shear_modulus for m in MATERIALS]
    text = (
        f"Effect of the material: with G = {1e-9 * moduli[1]:z.0f} GPa the wheels sink in {soft.approach / steel.approach:z.1f} "
        f"times as deep ({1e6 * soft.approach:z.0f} instead of {1e6 * steel.approach:z.0f} µm), and the creep stiffness Σf₁₁ of "
        f"a wheel falls to {100 * soft.creep_stiffness / steel.creep_stiffness:z.0f} % (Hertz and Kalker together give G^(1/3), "
        f"which is {100 * (moduli[1] / moduli[0]) ** (1 / 3):z.0f} %): the creep forces at the same creepage fall by as much."
    )
    soft_name, steel_name = MATERIALS[1], MATERIALS[0]
    by_disturbance = results.by_disturbance(soft_name).below(results.by_disturbance(steel_name))
    if results.linear_kmh(soft_name) < results.linear_kmh(steel_name) and by_disturbance:
        text += " Both the linear critical speed and that by disturbance fall with it."
    waves = [onset_wavelength(results, m) for m in MATERIALS]
    if all(math.isfinite(w) for w in waves):
        steeper = [(state.wavelength / wave) ** 2 for state, wave in zip((steel, soft), waves, strict=True)]
        text += (
            " With either material the wheels steer more strongly at finite amplitude: at the onset of hunting the wavelength is "
            f"{waves[0]:.1f} m with steel and {waves[1]:.1f} m with the paper's material, against {steel.wavelength:.1f} m and "
            f"{soft.wavelength:z.1f} m for small motion at low speed, as if the conicity were {steeper[0]:z.1f} and "
            f"{steeper[1]:z.1f} times "
            "as large. This agrees with hunting from a disturbance well below the linear critical speed."
        )
    return text


def _sensitivity(results: Results) -> str:
    parts = []
    for material in MATERIALS:
        known = [v for scan in results.merging.get(material, {}).values() if math.isfinite(v := scan.speed_kmh)]
        if len(known) > 1:
            parts.append(f"{NAMES[material]} {min(known):z.0f} to {max(known):z.0f} km/h")
    if not parts:
        return ""
    return (
        "Accuracy of these numbers: near its centred position S1002 on UIC60 1:40 touches in two patches per wheel, and the "
        "method of the paper treats each as a Hertzian contact of its own. How two patches merge is a modelling choice "
        f"(contact.normal.merging_criterion). Over the values in the table the linear critical speed is {' and '.join(parts)}. "
        "The exact solution has a single patch there, so the linear critical speed of this pair should not be read more "
        "accurately than that."
    )


def fit_blocks(results: Results, numbers: Numbers, plan: PaperPlan) -> list[Block]:
    """The section of the report."""
    blocks: list[Block] = [Text(line) for line in fit_paragraphs(results)] or [Text("Not computed.")]
    table = fit_table(results)
    blocks += [table] if table else []
    if results.contact:
        entries = {NAMES[m]: numbers["materials"][m]["contact"] for m in results.contact if m in results.modes}
        names = ("patches", "approach_um", "creep_stiffness_n", "wavelength_m")
        blocks.append(QUANTITIES.table(entries, names, "Steady rolling on the rig, small motions.", "material"))
    if any(results.merging.values()):
        rows = [[f"{b:g}", *(linear_cell(results.merging[m].get(b)) for m in MATERIALS)] for b in plan.criteria]
        caption = "Linear critical speed [km/h] of the bogie on the rig over the merging criterion of adjacent patches."
        blocks.append(Table(("merging criterion", *(NAMES[m] for m in MATERIALS)), rows, caption))
    if results.sensitivity:
        blocks.append(sensitivity_table(results.sensitivity))
    return blocks
