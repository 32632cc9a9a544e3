"""What the choice of contact model changes: critical speed, limit cycle and flange force of one vehicle with each of them.

Cases by support -> every normal contact with every creep law asked for -> rows of one table, a section of the report
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from rollerrig.analysis import LimitCycleSettings, limit_cycles, linear_critical_speed
from rollerrig.config import Case
from rollerrig.contact_comparison import NORMAL_CONTACTS
from rollerrig.report import Section, Table, Text

CREEP_LAWS = ("kalker_saturated", "table")
"""The paper's and the exact one; what lies between them is in the theory."""

COUNTERPART = {"rig": ("track", "uic60_track"), "track": ("rig", "full_scale_rig")}
"""Kind of support -> the other kind, and the catalogue's support of that kind."""


@dataclass(frozen=True)
class ContactEffect:
    """One combination.

    Attributes:
        support, normal, creep: names.
        critical_kmh: linear critical speed [km/h]; NaN: none in the range.
        frequency: of the motion that loses its damping [Hz].
        speed_kmh: speed of the run [km/h].
        amplitude: of its limit cycle, half the range of the wheelset that moves most [m]; 0: it comes to rest.
        guiding_force: largest |Y| of any wheel, unfiltered [N].
        status: of the run.
    """

    support: str
    normal: str
    creep: str
    critical_kmh: float
    frequency: float
    speed_kmh: float
    amplitude: float
    guiding_force: float
    status: str


def contact_effects(
    cases: Mapping[str, Case],
    speeds_kmh: Sequence[float],
    run_speed_kmh: float,
    *,
    normals: Sequence[str] = NORMAL_CONTACTS,
    creeps: Sequence[str] = CREEP_LAWS,
    settings: LimitCycleSettings | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> list[ContactEffect]:
    """Linear critical speed, and the limit cycle at one speed from a lateral offset, for every combination.

    Args:
        cases: name of the support -> case on it.
        speeds_kmh: range in which the critical speed is looked for [km/h].
        run_speed_kmh: speed of the run [km/h].
        normals: names for `contact.normal`.
        creeps: names for `contact.creep`.
        settings: of the runs.
        progress: called with the fraction done and a short text.
    """
    chosen = settings or LimitCycleSettings(longest=8.0)
    combinations = [(support, normal, creep) for support in cases for normal in normals for creep in creeps]
    effects = []
    for number, (support, normal, creep) in enumerate(combinations):
        if progress:
            progress(number / len(combinations), f"{support}, {normal}, {creep}")
        case = cases[support].with_changes({"contact.normal": normal, "contact.creep": creep})
        critical = linear_critical_speed(case, [v / 3.6 for v in speeds_kmh])
        linear = 3.6 * critical.speed if critical else math.nan
        ends = limit_cycles(case, [run_speed_kmh], linear, chosen, processes=1)
        point = ends.down[0]
        effects.append(
            ContactEffect(
                support,
                normal,
                creep,
                linear,
                critical.frequency if critical else math.nan,
                run_speed_kmh,
                point.amplitude,
                point.guiding_force,
                point.status,
            )
        )
    return effects


HEADER = ("support", "contact.normal", "contact.creep", "linear critical speed [km/h]", "frequency [Hz]",
          "speed of the run [km/h]", "limit cycle [mm]", "largest |Y| [kN]", "run")  # fmt: skip


def effect_rows(effects: Sequence[ContactEffect]) -> list[list[object]]:
    """contact_effects.csv, header first."""
    body: list[list[object]] = [
        [e.support, e.normal, e.creep, round(e.critical_kmh, 1), round(e.frequency, 2), e.speed_kmh,
         round(1e3 * e.amplitude, 2), round(1e-3 * e.guiding_force, 1), e.status]
        for e in effects
    ]  # fmt: skip
    return [list(HEADER), *body]


def effects_section(effects: Sequence[ContactEffect], disturbance: float) -> Section:
    """The table as a section of the stability report.

    Args:
        effects: what `contact_effects` returns.
        disturbance: lateral offset of the leading wheelset at the start of the runs [m].
    """
    text = (
        "The same vehicle with each normal contact and creep law. The limit cycle is what a run from a lateral offset of "
        f"{1e3 * disturbance:g} mm ends in at the speed given: half the range of the wheelset that moves most. Largest |Y|: "
        "guiding force of any wheel in it, unfiltered."
    )
    header, *rows = effect_rows(effects)
    return Section("What the contact model changes", [Text(text), Table([str(h) for h in header], rows)])
