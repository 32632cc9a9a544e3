"""What the paper says, what is found here, and why they differ: the first table of the paper report.

results of PaperStudy -> [compared] -> Section
"""

from __future__ import annotations

import xarray as xr

from rollerrig.analysis.fits import fit
from rollerrig.study.paper_checks import FRONT, REAR, sliding_course
from rollerrig.study.paper_fit import NAMELESS
from rollerrig.study.paper_plan import MATERIALS, NAMES, PAPER_CRITICAL_KMH, RIG, VEHICLE, PaperPlan
from rollerrig.study.paper_results import Results
from rollerrig.study.paper_text import frequency_differences, linear
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Section, Table, Text
from rollerrig.wording import number, percent

PAPER = (
    "M. Malvezzi, E. Meli, L. Pugi, Simulation of degraded wheel/rail adhesion conditions on a railway roller rig for the "
    "evaluation of the effect of wheel/roller contact on control performance, 2010."
)
TITLE = "The paper and this computation"
NOT_READ = (
    "These are all statements on results in the paper's text and captions. The curves of its figures 7 and 8 were not at hand, "
    "only the text: none of their points can be read, and none stands beside the curves computed here. Of the figures' numbers "
    "the paper states one, 100 km/h; of the traction test it states neither the torque nor the speed at the start."
)

RIGHT = (FRONT, REAR)
SHORT = "the roller's local radius and the shorter patches change the creep forces: see What the rig changes"
AGREES = "agrees"
STATIC = "agrees but for the static loads, which differ here"

Row = tuple[str, str, str, str]


def compared(results: Results, numbers: Numbers, plan: PaperPlan) -> Section:
    """The section; rows of what was computed."""
    rows = [*_critical(results, plan), *_rig_and_rails(results), *_traction(results, numbers)]
    header = ("of", "paper", "here", "why they differ")
    table = Table(header, rows, "Statements of the paper beside what is computed here; nothing was tuned.")
    return Section(
        TITLE, [Text(f"The paper: {PAPER}"), *([table, Text(NOT_READ)] if rows else [Text("Not computed.")])]
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
            rows.append(
                (f"frequency of hunting, rig against rails, {NAMES[material]} (figure 7b)", "similar", here, SHORT)
            )
        rig, rails = results.by_disturbance(material), results.by_disturbance(material, VEHICLE)
        if rig.known and rails.known:
            here = f"{rig.text('km/h')} on the rig, {rails.text('km/h')} on the rails"
            rows.append((f"critical speed, rig against rails, {NAMES[material]}", "similar", here, SHORT))
    return rows


def _traction(results: Results, numbers: Numbers) -> list[Row]:
    """Figure 8: sliding and forces of the right wheels."""
    run, study = results.traction, results.theory
    if numbers["traction"] is None or run is None or study is None:
        return []
    found = [
        (
            "sliding of the right wheels in the traction test (figure 8a)",
            "null at first, then of second order while the torque rises, then linear",
            _sliding(study),
            "two patches of a wheel have different rolling radii and work against each other without torque",
        )
    ]
    torque, force = study["torque"].to_numpy(), study["longitudinal_creep_force"]
    off = max(fit(force.sel(wheel=wheel).to_numpy(), torque).largest for wheel in RIGHT)
    ends = [study["vertical_force"].sel(wheel=wheel).isel(time=k) for k in (0, -1) for wheel in RIGHT]
    kilonewtons = [number(1e-3 * float(force), 4) for force in ends]
    unlike = max(float(abs(_of(run, side, "left") - _of(run, side, "right")).max()) for side in (1, 2))
    unlike /= float(abs(run["longitudinal_sliding"]).max())
    return [
        *found,
        (
            "longitudinal force of the right wheels (figure 8b)",
            "follows the torque",
            f"a constant times the torque leaves {percent(off)} of the largest",
            AGREES,
        ),
        (
            "vertical force of the right wheels (figure 8b)",
            "the same in front and behind, then linearly to different values",
            f"{kilonewtons[0]} and {kilonewtons[1]} kN at first, {kilonewtons[2]} and {kilonewtons[3]} kN at the end",
            "agrees: the motors' reaction turns the frame" if kilonewtons[0] == kilonewtons[1] else STATIC,
        ),
        (
            "left wheels in the traction test",
            "as the right ones",
            f"their sliding differs by {number(unlike, 1)} of the largest",
            AGREES,
        ),
    ]


def _sliding(study: xr.Dataset) -> str:
    """Its course, by the fits of the checks, and its values."""
    first, last = ([1e3 * float(study["sliding"].sel(wheel=wheel).isel(time=k)) for wheel in RIGHT] for k in (0, -1))
    courses = [sliding_course(study, wheel) for wheel in RIGHT]
    curved, straight = (max(course[k].largest for course in courses) for k in (0, 1))
    return (
        f"{first[0]:z.2f} mm/s in front and {first[1]:z.2f} mm/s behind at first; while the torque rises a parabola leaves "
        f"{percent(curved)} of the largest, at constant torque a straight line {percent(straight)}; at the end "
        f"{last[0]:z.1f} and {last[1]:z.1f} mm/s"
    )


def _of(run: xr.Dataset, wheelset: int, side: str) -> xr.DataArray:
    return run["longitudinal_sliding"].sel(wheel=f"wheelset_{wheelset}_{side}", drop=True)
