"""What the choice of contact model changes, as far as studies report it.

Case on rig and track -> [contact_effect_jobs] -> critical speed, limit cycle, guiding force with every normal and creep law
cases by support -> [sensitivity_cases] -> critical speed by disturbance with each normal law and merging criterion

The linear critical speed is that of the smooth piece of the profiles around the centre, where the merging rule hardly acts; a
motion of millimetres crosses the places where patches come and go, so the nonlinear one depends on the rule from its first step.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rollerrig.analysis import CriticalSpeedByDisturbance, LimitCycleSettings, linear_critical_speed
from rollerrig.analysis.limit_cycle_runs import settling_run
from rollerrig.config import Case
from rollerrig.config.schema.contact import NORMAL_LAWS
from rollerrig.study.assessment import Interval
from rollerrig.study.jobs import Job, Progress, job
from rollerrig.study.report import Table

CREEP_LAWS = ("kalker_saturated", "table")
"""The paper's and the exact one; what lies between them is in the theory."""

COUNTERPART = {"rig": ("track", "uic60_track"), "track": ("rig", "full_scale_rig")}
"""Kind of support -> the other kind, and the catalogue's support of that kind."""

SETTINGS = LimitCycleSettings(longest=8.0)


@dataclass(frozen=True)
class ContactEffect:
    """One combination: numbers under their names in the registry."""

    support: str
    normal: str
    creep: str
    linear_critical_speed_kmh: float
    frequency_hz: float
    run_speed_kmh: float
    limit_cycle_mm: float
    guiding_force_kn: float
    status: str


def contact_effect_jobs(
    case: Case,
    speeds_kmh: Sequence[float],
    run_speed_kmh: float,
    creeps: Sequence[str] = CREEP_LAWS,
) -> dict[str, Job]:
    """A job per combination, on the case's own support and on the catalogue's of the other kind.

    The critical speed is looked for in a range [km/h], the run from a lateral offset has one speed [km/h].
    """
    own, speeds = case.support.data.kind, tuple(speeds_kmh)
    other, support = COUNTERPART[own]
    cases: Mapping[str, Case] = {own: case, other: case.with_changes({"support.use": support})}
    every = itertools.product(cases, NORMAL_LAWS, creeps)
    return {
        f"contact model {', '.join(one)}": job(contact_effect, cases[one[0]], one, speeds, run_speed_kmh)
        for one in every
    }


def contact_effect(
    case: Case,
    names: tuple[str, str, str],
    speeds_kmh: Sequence[float],
    run_speed_kmh: float,
    progress: Progress | None = None,
) -> ContactEffect:
    """Linear critical speed, and the limit cycle at one speed from a lateral offset, with one contact model."""
    support, normal, creep = names
    chosen = case.with_changes({"contact.normal": normal, "contact.creep": creep})
    onset = linear_critical_speed(chosen, [v / 3.6 for v in speeds_kmh])
    linear = 3.6 * onset.speed if onset else math.nan
    point, _ = settling_run(chosen, SETTINGS, SETTINGS.disturbance, run_speed_kmh / 3.6, None, progress)
    frequency = onset.frequency if onset else math.nan
    sizes = 1e3 * point.amplitude, 1e-3 * point.guiding_force
    return ContactEffect(support, normal, creep, linear, frequency, run_speed_kmh, *sizes, point.status)


_PAPER = {"contact.creep": "kalker_saturated"}
OTHERS: Mapping[str, Mapping[str, object]] = {
    "strips": {"contact.normal": "strips", **_PAPER},
    "strips, table": {"contact.normal": "strips", "contact.creep": "table"},
}
"""Models beside `hertz` with the paper's creep law: name -> changes."""

PREFIX = "contact model"


def contact_models(criteria: Sequence[float]) -> dict[str, dict[str, object]]:
    """Name of each model -> changes to a case: `hertz` with each merging criterion, then OTHERS."""
    hertz: dict[str, dict[str, object]] = {
        f"hertz, {value:g}": {"contact.normal": {"kind": "hertz", "merging_criterion": value}, **_PAPER}
        for value in criteria
    }
    return hertz | {name: dict(changes) for name, changes in OTHERS.items()}


def sensitivity_cases(supports: Mapping[str, Case], criteria: Sequence[float]) -> dict[str, Case]:
    """Label of a run -> case: each support with each model, `hertz` with each of the merging criteria."""
    return {
        _label(on, model): case.with_changes(changes)
        for on, case in supports.items()
        for model, changes in contact_models(criteria).items()
    }


def _label(on: str, model: str) -> str:
    return f"{PREFIX} {on}, {model}"


def _place(label: str) -> tuple[str, str]:
    on, _, model = label.removeprefix(f"{PREFIX} ").partition(", ")
    return on, model


Found = Mapping[str, CriticalSpeedByDisturbance]
"""Label of `sensitivity_cases` -> critical speed by disturbance; those that Ctrl-C cut off are missing."""


def sensitivity_numbers(found: Found) -> dict[str, Any]:
    """Support -> model -> both ends of the bracket [km/h]."""
    numbers: dict[str, Any] = {}
    for label, one in found.items():
        on, model = _place(label)
        numbers.setdefault(on, {})[model] = {"decays_kmh": 3.6 * one.decays, "persists_kmh": 3.6 * one.persists}
    return numbers


def sensitivity_table(found: Found) -> Table:
    """A row per model, a column per support [km/h]."""
    offset = next(iter(found.values())).disturbance
    caption = (
        "Critical speed by disturbance with each model of normal contact: from where the motion decays to where it persists, "
        f"after {1e3 * offset:g} mm. The merging criterion acts on it throughout: the motion crosses the places where patches "
        "come and go."
    )
    supports = list(dict.fromkeys(_place(label)[0] for label in found))
    rows = []
    for model in dict.fromkeys(_place(label)[1] for label in found):
        normal, _, other = model.partition(", ")
        hertz = normal == "hertz"
        own = (found.get(_label(on, model)) for on in supports)
        cells = ["not computed" if one is None else Interval.of_bracket(one).text("km/h", 1) for one in own]
        law = other if other and not hertz else "kalker_saturated"
        rows.append([normal, other if hertz else "–", law.replace("_", " "), *cells])
    return Table(("normal", "merging criterion", "creep", *(f"on {on}" for on in supports)), rows, caption)
