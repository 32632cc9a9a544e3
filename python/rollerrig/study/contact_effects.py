"""What the choice of contact model changes: critical speed, limit cycle and guiding force of a vehicle with each of them.

Case on rig and track -> every normal contact with every creep law asked for -> rows of one table
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rollerrig.analysis import LimitCycleSettings, linear_critical_speed
from rollerrig.config import Case
from rollerrig.config.schema.contact_law import NORMAL_LAWS
from rollerrig.study.jobs import Job, job
from rollerrig.study.limit_cycles import limit_cycles
from rollerrig.study.quantities import Quantity

CREEP_LAWS = ("kalker_saturated", "table")
"""The paper's and the exact one; what lies between them is in the theory."""

COUNTERPART = {"rig": ("track", "uic60_track"), "track": ("rig", "full_scale_rig")}
"""Kind of support -> the other kind, and the catalogue's support of that kind."""

SETTINGS = LimitCycleSettings(longest=8.0)

QUANTITIES = (
    Quantity("contact_effects.*.support", "rig or track"),
    Quantity("contact_effects.*.normal", "contact.normal"),
    Quantity("contact_effects.*.creep", "contact.creep"),
    Quantity("contact_effects.*.linear_critical_speed_kmh", "null: none in the range", "km/h"),
    Quantity("contact_effects.*.frequency_hz", "of the mode that loses its damping", "Hz", digits=3),
    Quantity("contact_effects.*.run_speed_kmh", "speed of the run", "km/h"),
    Quantity(
        "contact_effects.*.limit_cycle_mm", "half the range of the wheelset that moves most; 0: it comes to rest", "mm"
    ),
    Quantity("contact_effects.*.guiding_force_kn", "largest |Y| of any wheel in it, unfiltered", "kN"),
    Quantity("contact_effects.*.status", "how the run ended"),
)


@dataclass(frozen=True)
class ContactEffect:
    """One combination: numbers under the names of QUANTITIES."""

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
    normals: Sequence[str] = NORMAL_LAWS,
    creeps: Sequence[str] = CREEP_LAWS,
) -> dict[str, Job]:
    """A job per combination, on the case's own support and on the catalogue's of the other kind.

    Args:
        case: of the vehicle.
        speeds_kmh: range in which the critical speed is looked for [km/h].
        run_speed_kmh: speed of the run from a lateral offset [km/h].
        normals: names for `contact.normal`.
        creeps: names for `contact.creep`.
    """
    own = case.support.data.kind
    other, support = COUNTERPART[own]
    cases: Mapping[str, Case] = {own: case, other: case.with_changes({"support.use": support})}
    return {
        f"contact model {label}, {normal}, {creep}": job(
            contact_effect, cases[label], (label, normal, creep), tuple(speeds_kmh), run_speed_kmh
        )
        for label, normal, creep in itertools.product(cases, normals, creeps)
    }


def contact_effect(
    case: Case, names: tuple[str, str, str], speeds_kmh: Sequence[float], run_speed_kmh: float
) -> ContactEffect:
    """Linear critical speed, and the limit cycle at one speed from a lateral offset, with one contact model."""
    support, normal, creep = names
    chosen = case.with_changes({"contact.normal": normal, "contact.creep": creep})
    onset = linear_critical_speed(chosen, [v / 3.6 for v in speeds_kmh])
    linear = 3.6 * onset.speed if onset else math.nan
    point = limit_cycles(chosen, [run_speed_kmh], linear, SETTINGS).down[0]
    frequency = onset.frequency if onset else math.nan
    sizes = 1e3 * point.amplitude, 1e-3 * point.guiding_force
    return ContactEffect(support, normal, creep, linear, frequency, run_speed_kmh, *sizes, point.status)
