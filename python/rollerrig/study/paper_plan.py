"""What the paper study computes: cases, speeds, lengths of runs, and what comes of them."""

from __future__ import annotations

from dataclasses import dataclass, field

from rollerrig.analysis import HuntingSettings, RampSettings
from rollerrig.analysis.roller_effects import RADII
from rollerrig.cases import restrained_along_track
from rollerrig.config import Case, load_case
from rollerrig.study.contact_sensitivity import sensitivity_cases
from rollerrig.study.report import Mark

MATERIALS = ("steel", "paper")
"""Names in the catalogue; `paper` has the G = 10 GPa of the paper."""

NAMES = {"steel": "steel", "paper": "the paper's material"}
"""Material -> what it is called in sentences."""

OWN, EXACT = "own contact", "exact contact"
"""The paper's contact: Hertz' ellipses with Kalker's linear theory saturated by friction; and the exact one."""

CONTACT_CHANGES: dict[str, dict[str, object]] = {
    OWN: {"contact.normal": {"kind": "hertz"}, "contact.creep": {"kind": "kalker_saturated"}},
    EXACT: {"contact.normal": {"kind": "strips"}, "contact.creep": {"kind": "table"}},
}

PAPER_CRITICAL_KMH = 100.0
"""Speed above which the paper's figure 7a grows [km/h]."""

VARIANTS = {
    "bogie on the rig": ("bogie_rollers_constant", "leading_bogie"),
    "bogie on track": ("bogie_track", "leading_bogie"),
    "vehicle on track": ("bogie_track", "vehicle"),
}
"""What is linearised: label -> case, cut."""

RIG, VEHICLE = "bogie on the rig", "vehicle on track"
"""The variants that figure 7b compares."""

TABLE_PARTS = ("leading_bogie", "vehicle")
"""Parts in the table of critical speeds over the rollers' radius."""

MERGING_CRITERIA = (0.0, 0.005, 0.01, 0.015, 0.02, 0.05)
"""Values of contact.normal.merging_criterion for which the sensitivity of the critical speed is shown."""


@dataclass(frozen=True)
class PaperPlan:
    """Speeds and lengths.

    Attributes:
        linear_kmh: speeds at which modes are computed [km/h].
        runs_kmh: material -> speeds of runs at constant speed [km/h], of the bogie on the rig and of the vehicle on track.
        bracket_kmh: width to which the critical speed by disturbance is narrowed down [km/h].
        ramps: material -> ramp.
        hunting: disturbance, length and tolerances of the runs.
        traction_case: name of the case in the catalogue.
        traction_changes: changes to it.
        criteria: values of contact.normal.merging_criterion for the sensitivity.
        sensitivity_kmh: first speeds of runs of the bogie, steel, with each model of normal contact [km/h].
        radii: of the rollers in the table of critical speeds [m].
        mark: said on every page, table and figure; None: the numbers may be relied on.
    """

    linear_kmh: tuple[float, ...]
    runs_kmh: dict[str, tuple[float, ...]]
    bracket_kmh: float
    ramps: dict[str, RampSettings]
    hunting: HuntingSettings = field(default_factory=HuntingSettings)
    traction_case: str = "bogie_rollers_traction"
    traction_changes: dict[str, object] = field(default_factory=dict)
    criteria: tuple[float, ...] = MERGING_CRITERIA
    sensitivity_kmh: tuple[float, ...] = (120.0, 160.0, 200.0, 240.0, 280.0)
    radii: tuple[float, ...] = RADII
    mark: Mark | None = None


def _kmh(low: float, high: float, acceleration: float, perturbation_every: float) -> RampSettings:
    return RampSettings(low / 3.6, high / 3.6, acceleration / 3.6, perturbation_every=perturbation_every / 3.6)


FULL = PaperPlan(
    linear_kmh=tuple(float(v) for v in range(20, 401, 10)),
    runs_kmh={
        "steel": tuple(float(v) for v in range(100, 301, 20)),
        "paper": tuple(float(v) for v in range(80, 221, 20)),
    },
    bracket_kmh=2.5,
    ramps={"steel": _kmh(60, 280, 3, 10), "paper": _kmh(40, 220, 3, 10)},
)

QUICK = PaperPlan(
    linear_kmh=(180.0, 260.0),
    runs_kmh={"steel": (100.0, 200.0), "paper": (100.0, 160.0)},
    bracket_kmh=1000.0,
    ramps={"steel": _kmh(140, 180, 40, 20), "paper": _kmh(100, 140, 40, 20)},
    hunting=HuntingSettings(duration=1.0, output_step=1e-2),
    criteria=(0.0, 0.01),
    sensitivity_kmh=(100.0, 200.0),
    radii=(0.725,),
    mark=Mark("quick", "few and short runs, which show that everything works; no number here is a result to be quoted"),
)


def case_of(variant: str, material: str, contact: str = OWN) -> Case:
    """The case of one of VARIANTS with a material of the catalogue and one of CONTACT_CHANGES."""
    name, cut = VARIANTS[variant]
    changes = {"contact.material": material, "vehicle.cut": cut, **CONTACT_CHANGES[contact]}
    return restrained_along_track(load_case(name).with_changes(changes))


def rig_case(material: str) -> Case:
    """The bogie on the rig."""
    return case_of(RIG, material)


def contact_model_cases(plan: PaperPlan) -> dict[str, Case]:
    """The bogie, steel, on rig and track with each model of normal contact."""
    supports = {"rig": rig_case(MATERIALS[0]), "track": case_of("bogie on track", MATERIALS[0])}
    return sensitivity_cases(supports, plan.criteria)


def traction_case(plan: PaperPlan, contact: str = OWN) -> Case:
    """The case of figure 8."""
    return load_case(plan.traction_case).with_changes({**CONTACT_CHANGES[contact], **plan.traction_changes})
