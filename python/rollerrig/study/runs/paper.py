"""What is computed of the paper's two studies: cases, speeds and lengths of runs, their results, checks against theory.

PaperPlan -> [first_jobs, further_rounds] -> results of the jobs -> [results_of] -> Results with checks

The paper's own contact is Hertz' ellipse at each minimum of the gap, with Kalker's linear theory saturated by friction. The exact
one is a non-elliptical patch with Kalker's theory of rolling contact: `strips` and `table`, what every other study uses.
"""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import xarray as xr

from rollerrig.analysis.control_loop import ContactState, contact_state
from rollerrig.analysis.critical_speed import RADII, CriticalSpeedByDisturbance, effect_split, scan_linear
from rollerrig.analysis.hunting import HuntingRun, HuntingSettings
from rollerrig.analysis.ramp import RampSettings, ramp_run
from rollerrig.analysis.traction import asymmetry, carried_weight, sliding_course, spin_balance, with_theory
from rollerrig.cases import restrained_along_track
from rollerrig.config import Case, load_case
from rollerrig.study import critical_speeds as speeds
from rollerrig.study.assessment import Check, Interval, counts
from rollerrig.study.frame import dataset_rows
from rollerrig.study.jobs import Chains, Done, Job, Round, job, whole_modes, whole_run
from rollerrig.study.report import Mark

MATERIALS = ("steel", "paper")  # names in the catalogue; `paper` has the G = 10 GPa of the paper
NAMES = {"steel": "steel", "paper": "the paper's material"}  # material -> what it is called in sentences

OWN, EXACT = "own contact", "exact contact"
CONTACTS: dict[str, dict[str, object]] = {  # contact -> changes of a case
    OWN: {"contact.normal": {"kind": "hertz"}, "contact.creep": {"kind": "kalker_saturated"}},
    EXACT: {"contact.normal": {"kind": "strips"}, "contact.creep": {"kind": "table"}},
}

VARIANTS = {  # what is linearised: label -> case, cut
    "bogie on the rig": ("bogie_rollers_constant", "leading_bogie"),
    "bogie on track": ("bogie_track", "leading_bogie"),
    "vehicle on track": ("bogie_track", "vehicle"),
}

RIG, VEHICLE = "bogie on the rig", "vehicle on track"  # the variants that figure 7b compares
TABLE_PARTS = ("leading_bogie", "vehicle")  # parts in the table of critical speeds over the rollers' radius
FRONT, REAR = "wheelset_1_right", "wheelset_2_right"  # the wheels of the paper's figure 8


@dataclass(frozen=True)
class PaperPlan:
    """Speeds and lengths of what is computed."""

    linear_kmh: tuple[float, ...]  # speeds at which modes are computed [km/h]
    # material -> speeds of runs at constant speed [km/h], of the bogie on the rig and of the vehicle on track
    runs_kmh: dict[str, tuple[float, ...]]
    bracket_kmh: float  # width to which the critical speed by disturbance is narrowed down [km/h]
    ramps: dict[str, RampSettings]
    hunting: HuntingSettings = field(default_factory=HuntingSettings)
    radii: tuple[float, ...] = RADII  # of the rollers in the table of critical speeds [m]
    mark: Mark | None = None  # said on every page, table and figure; None: the numbers may be relied on


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
    hunting=HuntingSettings(duration=1.0, output_step=1e-2, longest=6.0),
    radii=(0.725,),
    mark=Mark("quick", "few and short runs, which show that everything works; no number here is a result to be quoted"),
)


def case_of(variant: str, material: str, contact: str = OWN) -> Case:
    """The case of one of VARIANTS with a material of the catalogue and one of CONTACTS."""
    name, cut = VARIANTS[variant]
    changes = {"contact.material": material, "vehicle.cut": cut, **CONTACTS[contact]}
    return restrained_along_track(load_case(name).with_changes(changes))


def rig_case(material: str) -> Case:
    """The bogie on the rig."""
    return case_of(RIG, material)


def traction_case(contact: str = OWN) -> Case:
    """The case of figure 8."""
    return load_case("bogie_rollers_traction").with_changes(CONTACTS[contact])


ALL = tuple(itertools.product(CONTACTS, MATERIALS, VARIANTS))
RUNS = tuple(key for key in ALL if key[2] in (RIG, VEHICLE))
"""Contact, material and variant of the runs from a disturbance."""


def _label(contact: str, material: str, variant: str) -> str:
    return f"{variant} {material}" if contact == OWN else f"{contact} {variant} {material}"


def rounds(plan: PaperPlan) -> Iterator[Round | Chains]:
    """All jobs: what is linear first, then ramps and runs."""
    linear: dict[str, Job] = {}
    further: dict[str, Job] = {}
    for m in MATERIALS:
        for variant in VARIANTS:
            linear[f"modes {m}, {variant}"] = job(whole_modes, case_of(variant, m), plan.linear_kmh)
            further[f"{EXACT} linear {m}, {variant}"] = job(scan_linear, case_of(variant, m, EXACT), plan.linear_kmh)
        rig = rig_case(m)
        linear[f"contact {m}"] = job(contact_state, rig)
        linear |= speeds.roller_jobs(rig, TABLE_PARTS, plan.radii, plan.linear_kmh, f" {m}")
        further[f"ramp {m}"] = job(ramp_run, (rig, plan.ramps[m], plan.hunting))
    further[f"{EXACT} traction"] = job(whole_run, traction_case(EXACT))
    further["traction"] = job(whole_run, traction_case())
    yield linear
    cases = {_label(*key): case_of(key[2], key[1], key[0]) for key in RUNS}
    begun = {_label(*key): plan.runs_kmh[key[1]] for key in RUNS}
    runs = speeds.disturbance_chains(cases, begun, plan.bracket_kmh, plan.hunting)
    yield Chains((lambda _done: further, *runs.chains), len(further) + runs.expected)


Place = tuple[str, str, str]  # contact, material, variant


@dataclass
class Results:
    """What was computed; parts that Ctrl-C cut off are missing."""

    modes: dict[str, dict[str, xr.Dataset]]  # material -> variant -> Dataset of `stability`, with the paper's contact
    linear: dict[Place, tuple[float, float]]  # linear critical speed [km/h] and its frequency [Hz]; NaN: none
    runs: dict[Place, CriticalSpeedByDisturbance]  # critical speed by disturbance, with its runs
    contact: dict[str, ContactState]  # the wheels' contact in steady rolling on the rig, by material
    ramps: dict[str, xr.Dataset]  # Datasets of `ramp_run`, by material
    over_radius: dict[str, speeds.Scans]  # critical speeds over the rollers' radius, by material
    effects: dict[str, speeds.Split]  # of the rollers on the bogie's critical speed, by material
    traction: xr.Dataset | None  # the traction run, all signals
    theory: xr.Dataset | None  # the same wheels beside the closed forms; those with the exact contact
    exact_theory: xr.Dataset | None
    checks: list[Check] = field(default_factory=list)

    def linear_kmh(self, material: str, variant: str = RIG, contact: str = OWN) -> float:
        """Linear critical speed [km/h]; NaN if there is none or it was not computed."""
        return self.linear.get((contact, material, variant), (math.nan, math.nan))[0]

    def by_disturbance(self, material: str, variant: str = RIG, contact: str = OWN) -> Interval:
        """Where the critical speed by disturbance lies [km/h]; without ends if it was not computed."""
        return Interval.of_bracket(self.runs.get((contact, material, variant)))

    def runs_of(self, variant: str = RIG, contact: str = OWN) -> dict[str, CriticalSpeedByDisturbance]:
        """Material -> critical speed by disturbance, of the materials that have runs."""
        return {m: self.runs[contact, m, variant] for m in MATERIALS if (contact, m, variant) in self.runs}

    def frequency_differences(self, material: str) -> list[float]:
        """Frequency of the bogie on the rig over that of the vehicle on track, less one, at each speed both were run at."""
        tables = [one.table for variant in (RIG, VEHICLE) if (one := self.runs_of(variant).get(material))]
        known = [one["oscillation_frequency"].where(one["persists"] == 1, one["decay_frequency"]) for one in tables]
        found = [one.assign_coords(speed=one["speed"].round(3)) for one in known]
        return (found[0] / found[1] - 1).dropna("speed").to_numpy().tolist() if len(found) == 2 else []


def results_of(plan: PaperPlan, done: Done) -> Results:
    """Everything that can be said from what is done."""
    modes = {m: {v: done[n] for v in VARIANTS if (n := f"modes {m}, {v}") in done} for m in MATERIALS}
    linear = {
        (OWN, m, v): (float(found.attrs["linear_critical_speed_kmh"]), float(found.attrs["linear_critical_frequency_hz"]))
        for m, variants in modes.items()
        for v, found in variants.items()
    }  # fmt: skip
    for m, v in itertools.product(MATERIALS, VARIANTS):
        if (scan := done.get(f"{EXACT} linear {m}, {v}")) is not None:
            linear[EXACT, m, v] = scan.speed_kmh, math.nan if scan.onset is None else scan.onset.frequency
    runs = {key: one for key in RUNS for one in speeds.brackets([_label(*key)], plan.hunting, done).values()}
    rollers = {m: speeds.roller_results(rig_case(m), TABLE_PARTS, plan.radii, done, f" {m}") for m in MATERIALS}
    run, exact = done.get("traction"), done.get(f"{EXACT} traction")
    found = Results(
        modes={m: variants for m, variants in modes.items() if variants},
        linear=linear,
        runs=runs,
        contact={m: done[n] for m in MATERIALS if (n := f"contact {m}") in done},
        ramps={m: done[n] for m in MATERIALS if (n := f"ramp {m}") in done},
        over_radius={m: one for m, (one, _) in rollers.items() if one},
        effects={m: effect_split(one) for m, (_, one) in rollers.items() if one},
        traction=run,
        theory=None if run is None else with_theory(run, traction_case()),
        exact_theory=None if exact is None else with_theory(exact, traction_case(EXACT)),
    )
    if run is not None and found.theory is not None:
        found.checks += traction_checks(run, found.theory, traction_case())
    found.checks += _hunting_checks(found)
    return found


ORDER_REASON = "above the linear critical speed every disturbance grows; linear speed to 0.1 km/h"
HUNTING_REASON = "of the energy turned over; the runs are integrated to a relative tolerance of 1e-4 per step"
SPIN_REASON = "relative to the largest torque; the patches' mean radius is used, spin moments on the cone are left out"
COURSE = (
    ("what a fit c₀V + c₁ × torque × speed leaves", 0.03,
     "of the largest sliding; saturation and load transfer bend the creep law by a few per cent"),
    ("what a parabola leaves while the torque rises", 0.03,
     "the speed itself rises quadratically, so torque × speed has a small cubic part"),
    ("what a straight line leaves at constant torque", 0.005,
     "acceleration and force are constant, 0.2 s after the corner of the torque"),
)  # fmt: skip


def _hunting_checks(found: Results) -> Iterator[Check]:
    """Figure 7: energy of runs and ramps, and the order of the critical speeds where both are known."""
    for material in MATERIALS:
        own, ramp = found.runs_of(RIG).get(material), found.ramps.get(material)
        steady = [one.motion for one in own.runs] if own else []
        audits = {"runs at constant speed, {}: the worst": steady, "ramp, {}": [] if ramp is None else [ramp]}
        for name, runs in audits.items():
            if runs:
                worst = max(float(run.attrs["energy_relative_residual"]) for run in runs)
                yield Check(f"energy of the {name.format(material)}", worst, 0.0, 1e-5, HUNTING_REASON)
    for material, variant in itertools.product(MATERIALS, (RIG, VEHICLE)):
        by, linear = found.by_disturbance(material, variant), found.linear_kmh(material, variant)
        if by.known and math.isfinite(linear):
            name = f"critical speed by disturbance is not above the linear one, {NAMES[material]}, {variant}"
            yield Check(name, by, linear, 0.1, ORDER_REASON, "km/h", kind="at most")


def traction_checks(run: xr.Dataset, study: xr.Dataset, case: Case) -> Iterator[Check]:
    """Figure 8 against theory, all signals of a run beside its closed forms of `with_theory`; none if the run was cut off."""
    if run.attrs["status"] != "ok":
        return
    places = {"front": study.sel(wheel=FRONT), "rear": study.sel(wheel=REAR)}
    for place, own in places.items():
        for (what, tolerance, reason), fitted in zip(COURSE, sliding_course(own), strict=True):
            yield Check(f"sliding, {place}: {what}", fitted.largest, 0.0, tolerance, reason)
        last, theory = (1e3 * float(own[name].isel(time=-1)) for name in ("sliding", "sliding_theory"))
        name = f"sliding at the end, {place}: slope of the creep law at the start × force × speed"
        reason = "the slope changes with load (load transfer) and with saturation (two patches pull against each other)"
        yield Check(name, last, theory, 0.1, reason, "mm/s", relative=True)
    for variable in ("longitudinal_sliding", "longitudinal_creep_force", "vertical_force"):
        name = {"longitudinal_sliding": "sliding"}.get(variable, variable.replace("_", " "))
        reason = "relative; the model is symmetric, only the integration's error remains"
        yield Check(f"left = right, {name}", asymmetry(run, variable), 0.0, 1e-6, reason)
    wheelset, roller = spin_balance(run, study, case, "wheelset_1", "roller_1")
    yield Check("torque - Σ creep force × radius = J dω/dt, front wheelset", wheelset, 0.0, 0.002, SPIN_REASON)
    yield Check("Σ creep force × radius = J dω/dt, front roller pair", roller, 0.0, 0.002, SPIN_REASON)
    for place, own in places.items():
        force = [float(own[f"longitudinal_creep_force{kind}"].isel(time=-1)) for kind in ("", "_theory")]
        reason = "closed form with the nominal radius; free rolling resistance (a few newtons) left out"
        name = f"longitudinal creep force at the end, {place}: what accelerates wheelset and roller"
        yield Check(name, force[0], force[1], 0.005, reason, "N", relative=True)
    for place, own in places.items():
        loads = [own[f"vertical_force{kind}"] for kind in ("", "_theory")]
        change = [float(load.isel(time=-1) - load.isel(time=0)) for load in loads]
        name = f"load transfer at the end, {place}: balance of the frame's moments"
        reason = "closed form, small angles, springs linear"
        yield Check(name, change[0], change[1], 0.01, reason, "N", relative=True)
    name = "vertical wheel loads sum to the weight and the load of the secondary suspension on the frame"
    total, reason = float(run["vertical_force"].isel(time=0).sum()), "accuracy of the starting equilibrium"
    yield Check(name, total, carried_weight(run, case), 1e-6, reason, "N", relative=True)
    residual, reason = run.attrs["energy_relative_residual"], "of the energy turned over; the error of the integration"
    yield Check("traction: energy, work in = kinetic + potential + dissipated", float(residual), 0.0, 1e-6, reason)


def around_onset(runs: list[HuntingRun], onset: float, count: int = 6) -> list[HuntingRun]:
    """Runs spread evenly over the speeds, and those next to the onset [m/s] on either side if there is one, by speed."""
    near = [i for i, run in enumerate(runs) if run.speed >= onset][:1]
    step = math.ceil(len(runs) / (count - 2 * len(near)))
    return [runs[i] for i in sorted({*range(0, len(runs), step), *near, *(max(i - 1, 0) for i in near)})]


ENDS = (  # key, variable and factor of what is reported of figure 8 at its end
    ("sliding_mmps", "sliding", 1e3),
    ("longitudinal_creep_force_n", "longitudinal_creep_force", 1.0),
    ("longitudinal_force_n", "longitudinal_force", 1.0),
    ("vertical_force_n", "vertical_force", 1.0),
)


def numbers_of(results: Results) -> dict[str, Any]:
    """What goes into summary.json."""
    found = {m: _contact_numbers(results, OWN, m) | _material_numbers(results, m) for m in results.modes}
    exact = {m: one for m in MATERIALS if (one := _contact_numbers(results, EXACT, m))}
    return {
        "materials": found,
        "exact_contact": {"materials": exact, "traction": _traction_numbers(results.exact_theory)},
        "traction": _traction_numbers(results.theory),
        "checks": [check.as_dict() for check in results.checks],
        **counts(results.checks),
    }


def _contact_numbers(results: Results, contact: str, material: str) -> dict[str, Any]:
    """What is reported with either contact; empty where nothing was computed."""
    pairs = {v: results.linear[place] for v in VARIANTS if (place := (contact, material, v)) in results.linear}
    found: dict[str, Any] = {}
    if pairs:
        found["linear"] = {v: {"critical_speed_kmh": value, "frequency_hz": hz} for v, (value, hz) in pairs.items()}
    for key, variant in (("by_disturbance", RIG), ("vehicle_on_track", VEHICLE)):
        if (contact, material, variant) in results.runs:
            found[key] = speeds.disturbance_numbers(results.runs[contact, material, variant])
    return found


def _material_numbers(results: Results, material: str) -> dict[str, Any]:
    """What is reported with the paper's contact alone."""
    found: dict[str, Any] = {}
    if material in results.contact:
        state = results.contact[material]
        found["contact"] = {
            "patches": state.patches,
            "approach_um": 1e6 * state.approach,
            "creep_stiffness_n": state.creep_stiffness,
            "wavelength_m": state.wavelength,
        }
    if material in results.over_radius:
        found["critical_speed_over_radius_kmh"] = speeds.radius_numbers(results.over_radius[material])
    if material in results.effects:
        found["roller_effects"] = results.effects[material]
    return found


def _traction_numbers(study: xr.Dataset | None) -> dict[str, Any] | None:
    """Figure 8 at its end."""
    if study is None:
        return None
    end = study.isel(time=-1)
    wheels = {wheel: end.sel(wheel=wheel) for wheel in (FRONT, REAR)}
    own = {w: {key: factor * float(one[name]) for key, name, factor in ENDS} for w, one in wheels.items()}
    return {"speed_kmh": 3.6 * float(end["speed"]), **own}


RUN_COLUMNS = {  # column of the runs' files -> variable
    "speed_kmh": "speed",
    "amplitude_m": "amplitude",
    "frequency_hz": "oscillation_frequency",
    "decay_frequency_hz": "decay_frequency",
    "rate_at_end_per_s": "rate_at_end",
    "persists": "persists",
}


def frequency_rows(results: Results) -> list[list[object]]:
    """Frequency and damping of hunting over speed, header first."""
    columns = {"speed_kmh": "speed", "hunting_frequency_hz": "hunting_frequency", "hunting_damping": "hunting_damping"}
    found = [([m, v], modes) for m, variants in results.modes.items() for v, modes in variants.items()]
    rows = [[*names, *row] for names, modes in found for row in dataset_rows(modes, columns, "speed")[1:]]
    return [["material", "variant", *columns], *rows]
