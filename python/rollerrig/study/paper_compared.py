"""What the paper says, what is found here, and why they differ: the first table of the paper report.

results of PaperStudy -> [compared] -> Section
"""

from __future__ import annotations

from rollerrig.study.paper_fit import NAMELESS
from rollerrig.study.paper_plan import MATERIALS, NAMES, PAPER_CRITICAL_KMH, RIG, VEHICLE, PaperPlan
from rollerrig.study.paper_results import Results
from rollerrig.study.paper_text import frequency_differences, linear
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Section, Table, Text

PAPER = (
    "M. Malvezzi, E. Meli, L. Pugi, Simulation of degraded wheel/rail adhesion conditions on a railway roller rig for the "
    "evaluation of the effect of wheel/roller contact on control performance, 2010."
)
TITLE = "The paper and this computation"

Row = tuple[str, str, str, str]


def compared(results: Results, numbers: Numbers, plan: PaperPlan) -> Section:
    """The section; rows of what was computed."""
    rows = [*_critical(results, plan), *_rig_and_rails(results), *_traction(numbers)]
    header = ("of", "paper", "here", "why they differ")
    table = Table(header, rows, "Statements of the paper beside what is computed here; nothing was tuned.")
    return Section(
        TITLE, [Text(f"The paper: {PAPER}"), table] if rows else [Text(f"The paper: {PAPER}"), Text("Not computed.")]
    )


def _critical(results: Results, plan: PaperPlan) -> list[Row]:
    rows = []
    for material in results.modes:
        by = results.by_disturbance(material)
        words = [f"with the paper's contact: linear {linear(results.linear_kmh(material), plan)}"]
        words += [f"from {1e3 * plan.hunting.disturbance:g} mm {by.text('km/h', 1)}"] if by.known else []
        if material in results.exact.linear:
            exact = results.exact.by_disturbance(material, RIG)
            words.append(f"with the exact one: linear {linear(results.exact.linear_kmh(material, RIG), plan)}")
            words += [f"from the offset {exact.text('km/h', 1)}"] if exact.known else []
        rows.append(
            (
                f"critical speed on the rig, {NAMES[material]} (figure 7a)",
                f"{PAPER_CRITICAL_KMH:g} km/h",
                "; ".join(words),
                NAMELESS,
            )
        )
    return rows


def _rig_and_rails(results: Results) -> list[Row]:
    """Figure 7b: bogie on the rig against the whole vehicle on the rails."""
    rows = []
    for material in MATERIALS:
        apart = frequency_differences(results, material)
        if apart:
            here = f"differs by {100 * min(apart):+z.0f} to {100 * max(apart):+z.0f} %"
            rig, rails = results.by_disturbance(material), results.by_disturbance(material, VEHICLE)
            if rig.known and rails.known:
                here += f"; critical speed {rig.text('km/h')} on the rig, {rails.text('km/h')} on the rails"
            why = "the roller's local radius and the shorter patches change the creep forces: see What the rig changes"
            rows.append(
                (f"frequency of hunting, rig against rails, {NAMES[material]} (figure 7b)", "similar", here, why)
            )
    return rows


def _traction(numbers: Numbers) -> list[Row]:
    """Figure 8a: sliding of the right wheels."""
    end = numbers["traction"]
    if end is None:
        return []
    front, rear = (end[f"wheelset_{k}_right"]["sliding_mmps"] for k in (1, 2))
    return [
        (
            "sliding of the right wheels in the traction test (figure 8a)",
            "null at first, then of second order, then linear",
            f"at the end {front:z.1f} mm/s in front, {rear:z.1f} mm/s behind; not null at first",
            "two patches of a wheel have different rolling radii and work against each other without torque",
        )
    ]
