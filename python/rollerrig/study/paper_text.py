"""The sentences of the paper report, made from its numbers."""

from __future__ import annotations

import math

from rollerrig.analysis import CriticalSpeedByDisturbance, end_of_hunting
from rollerrig.analysis.hunting import decay_frequency
from rollerrig.study import critical_speeds as speeds
from rollerrig.study.paper_plan import MATERIALS, PAPER_CRITICAL_KMH, TABLE_PARTS, VEHICLE, PaperPlan, Results, rig_case
from rollerrig.study.quantities import Numbers

NAMES = {"steel": "steel", "paper": "the paper's material"}

CONSTANT_SPEED = (
    "At constant speeds the leading wheelset is displaced laterally and released. Runs are repeated between the highest speed at "
    "which the motion decays and the lowest at which it persists, until the two are close. Near the highest speeds the flanges "
    "strike and the motion becomes irregular: its amplitude is meaningful, its course is sensitive to the smallest change."
)
TRACTION = (
    "No torque for one second, then a linear rise to the maximum at 5 s, then constant. The rollers turn freely, so they and the "
    "wheelsets are accelerated; the motors are mounted on the frame, which takes the opposite torque. The sliding does not start "
    "from zero: the two patches of each wheel have different rolling radii and work against each other even without torque, and "
    "what is drawn is their mean, weighted with normal force."
)
RAMP = (
    "The rollers are sped up slowly from a disturbed start, as in the paper, and then slowed down again. The model has no "
    "irregularities: below the critical speed the first disturbance decays within seconds to exact rest, and a bogie at exact "
    "rest stays there far above the critical speed, whatever its stability. The bogie is therefore perturbed at every "
    "{every:g} km/h on the way up (triangles): all its moving bodies are given a lateral velocity of {perturbation:g} mm/s. "
    "What remains of one perturbation before the next shows whether disturbances grow. The rollers gain {rate:g} km/h per "
    "second."
)


def kmh(value: float, digits: int = 0) -> str:
    """A speed as text; a dash where there is none."""
    return f"{value:.{digits}f} km/h" if math.isfinite(value) else "–"


def _name(material: str) -> str:
    return NAMES[material].capitalize()


def summary(results: Results, numbers: Numbers, plan: PaperPlan) -> list[str]:
    """The whole in a few lines."""

    def found(value: float, digits: int = 0) -> str:
        return kmh(value, digits) if math.isfinite(value) else "not found"

    size = 1e3 * plan.hunting.disturbance
    lines = [
        f"{_name(m)}: linear critical speed on the rig {found(results.linear_kmh(m), 1)}, by disturbance (from {size:g} mm) "
        f"{found(results.by_disturbance_kmh(m))}."
        for m in results.modes
    ]
    end = numbers["traction"]
    if end is not None:
        front, rear = (end[f"wheelset_{k}_right"]["sliding_mmps"] for k in (1, 2))
        lines.append(
            f"Traction: at the end the front wheels slide at {front:.1f} mm/s and the rear ones at {rear:.1f} mm/s, "
            f"at a speed of {end['speed_kmh']:.0f} km/h."
        )
    return lines


def ramp_text(plan: PaperPlan) -> str:
    """What was done in the ramps."""
    ramp = plan.ramps[MATERIALS[0]]
    every, rate = (round(3.6 * value, 6) for value in (ramp.perturbation_every, ramp.acceleration))
    return RAMP.format(every=every, perturbation=1e3 * ramp.perturbation, rate=rate)


def critical_paragraphs(results: Results) -> list[str]:
    """What figure 7 says about the critical speed."""
    texts = []
    for material, found in results.runs.items():
        linear, lowest = results.linear_kmh(material), results.by_disturbance_kmh(material)
        if not (math.isfinite(linear) and math.isfinite(lowest)):
            continue
        text = (
            f"{_name(material)}: small disturbances grow above {linear:.1f} km/h. From {1e3 * found.disturbance:g} mm the motion "
            f"decays at {3.6 * found.decays:.1f} km/h and persists at {3.6 * found.persists:.1f} km/h."
        )
        if lowest < linear - 5:
            text += (
                f" Between {lowest:.0f} and {linear:.0f} km/h both are possible: small disturbances decay, larger ones end in "
                "a limit cycle, and a hunting bogie continues to hunt while the rollers slow down, until the lower of the two "
                "speeds (hysteresis, a subcritical bifurcation)."
            )
        ramp = results.ramps.get(material)
        end = 3.6 * end_of_hunting(ramp, "front_frame") if ramp is not None else math.nan
        texts.append(text + (f" On the ramp down, the hunting ends at {end:.0f} km/h." if math.isfinite(end) else ""))
    return texts


def frequency_paragraphs(results: Results, plan: PaperPlan) -> list[str]:
    """What figure 7b says: how far the bogie on the rig and the whole vehicle on the rails are apart."""
    texts = [
        "Figure 7b of the paper shows the frequency of the lateral oscillation in its simulations at each speed, for a whole "
        "vehicle on the rails and a bogie on the rig, and calls frequency and critical speed similar. Here both are released "
        "from the same lateral offset, and the frequency is that of the frame's half-waves: while they decay (down to a tenth "
        "of the largest), or at the end where they persist."
    ]
    for material in MATERIALS:
        apart = frequency_differences(results, material)
        if not apart:
            continue
        rig, vehicle = results.by_disturbance_kmh(material), results.by_disturbance_kmh(material, VEHICLE)
        text = (
            f"{_name(material)}: at the {len(apart)} speeds at which both oscillate, the frequency of the bogie on "
            f"the rig differs from that of the vehicle on the rails by {100 * min(apart):+.0f} to {100 * max(apart):+.0f} %."
        )
        if math.isfinite(rig) and math.isfinite(vehicle):
            text += (
                f" The critical speed by disturbance, from {1e3 * plan.hunting.disturbance:g} mm, is {rig:.0f} km/h "
                f"on the rig and {vehicle:.0f} km/h on the rails, {100 * (1 - rig / vehicle):.0f} % apart."
            )
        texts.append(text)
    return texts if len(texts) > 1 else []


def frequency_differences(results: Results, material: str) -> list[float]:
    """Frequency of the bogie on the rig over that of the vehicle on track, less one, at each speed both were run at."""

    def frequencies(found: CriticalSpeedByDisturbance | None) -> dict[float, float]:
        known = {
            round(3.6 * run.speed, 3): run.final.frequency if run.persists else decay_frequency(run)
            for run in (found.runs if found else [])
        }
        return {speed: value for speed, value in known.items() if math.isfinite(value)}

    rig, vehicle = frequencies(results.runs.get(material)), frequencies(results.vehicle_runs.get(material))
    return [rig[speed] / vehicle[speed] - 1 for speed in sorted(rig.keys() & vehicle.keys())]


def rig_paragraphs(results: Results) -> list[str]:
    """Order of the critical speeds and the split of the loss."""
    texts = []
    bogie, vehicle = TABLE_PARTS
    for material, table in results.over_radius.items():
        apart = [table.kmh(bogie, radius) / table.kmh(vehicle, radius) - 1 for radius in table.radii]
        known = [100 * value for value in apart if math.isfinite(value)]
        text = f"{_name(material)}. {' '.join(speeds.radius_sentences(table))}"
        if known:
            text += f" The bogie with fixed car body differs by {min(known):+.1f} to {max(known):+.1f} % from the whole vehicle."
        texts.append(text)
    return texts + [f"{_name(m)}, bogie. {speeds.effects_sentence(split)}" for m, split in results.effects.items()]


def fit_paragraphs(results: Results) -> list[str]:
    """Which material the paper's critical speed fits, and why."""
    kinds = (("linear", results.linear_kmh), ("by disturbance", results.by_disturbance_kmh))
    values = {(m, kind): v for m in MATERIALS for kind, of in kinds if math.isfinite(v := of(m))}
    if not values:
        return []
    nearest = min(values, key=lambda key: abs(values[key] - PAPER_CRITICAL_KMH))
    others = [abs(v - PAPER_CRITICAL_KMH) for (m, _), v in values.items() if m != nearest[0]]
    text = (
        f"The paper reports growing oscillations above {PAPER_CRITICAL_KMH:.0f} km/h. The nearest critical speed is that of "
        f"{NAMES[nearest[0]]} ({nearest[1]}), {values[nearest]:.0f} km/h"
    )
    if others:
        text += f"; the other material differs from the paper by at least {min(others):.0f} km/h"
    texts = [f"{text}. {_comparison(values[nearest])}"]
    if all(m in results.contact for m in MATERIALS):
        texts.append(_effect_of_the_material(results))
    sensitivity = _sensitivity(results)
    return [*texts, sensitivity] if sensitivity else texts


def _comparison(value: float) -> str:
    off = value / PAPER_CRITICAL_KMH - 1
    if abs(off) <= 0.1:
        return "That is within a tenth of the paper's value."
    return (
        f"That is still {100 * abs(off):.0f} % {'above' if off > 0 else 'below'} the paper's value: neither reproduces it. The "
        "paper names its vehicle, but neither profiles nor friction nor the radius of its rollers; no parameter was tuned here "
        "to close the gap."
    )


def onset_wavelength(results: Results, material: str) -> float:
    """Wavelength of the limit cycle at the lowest speed at which it was found [m]; NaN if there is none."""
    found = results.runs.get(material)
    lasting = [run for run in found.runs if run.persists and run.valid] if found else []
    return lasting[0].speed / lasting[0].final.frequency if lasting else math.nan


def _effect_of_the_material(results: Results) -> str:
    steel, soft = (results.contact[m] for m in MATERIALS)
    moduli = [rig_case(m).contact.material.shear_modulus for m in MATERIALS]
    text = (
        f"Effect of the material: with G = {1e-9 * moduli[1]:.0f} GPa the wheels sink in {soft.approach / steel.approach:.1f} "
        f"times as deep ({1e6 * soft.approach:.0f} instead of {1e6 * steel.approach:.0f} µm), and the creep stiffness Σf₁₁ of "
        f"a wheel falls to {100 * soft.creep_stiffness / steel.creep_stiffness:.0f} % (Hertz and Kalker together give G^(1/3), "
        f"which is {100 * (moduli[1] / moduli[0]) ** (1 / 3):.0f} %): the creep forces at the same creepage fall by as much."
    )
    soft_name, steel_name = MATERIALS[1], MATERIALS[0]
    if all(of(soft_name) < of(steel_name) for of in (results.linear_kmh, results.by_disturbance_kmh)):
        text += " Both the linear critical speed and that by disturbance fall with it."
    waves = [onset_wavelength(results, m) for m in MATERIALS]
    if all(math.isfinite(w) for w in waves):
        steeper = [(state.wavelength / wave) ** 2 for state, wave in zip((steel, soft), waves, strict=True)]
        text += (
            " With either material the wheels steer more strongly at finite amplitude: at the onset of hunting the wavelength is "
            f"{waves[0]:.1f} m with steel and {waves[1]:.1f} m with the paper's material, against {steel.wavelength:.1f} m and "
            f"{soft.wavelength:.1f} m for small motion at low speed, as if the conicity were {steeper[0]:.1f} and "
            f"{steeper[1]:.1f} times "
            "as large. This agrees with hunting from a disturbance well below the linear critical speed."
        )
    return text


def _sensitivity(results: Results) -> str:
    parts = []
    for material in MATERIALS:
        known = [v for scan in results.merging.get(material, {}).values() if math.isfinite(v := scan.speed_kmh)]
        if len(known) > 1:
            parts.append(f"{NAMES[material]} {min(known):.0f} to {max(known):.0f} km/h")
    if not parts:
        return ""
    return (
        "Accuracy of these numbers: near its centred position S1002 on UIC60 1:40 touches in two patches per wheel, and the "
        "method of the paper treats each as a Hertzian contact of its own. How two patches merge is a modelling choice "
        f"(contact.normal.merging_criterion). Over the values in the table the linear critical speed is {' and '.join(parts)}. "
        "The exact solution has a single patch there, so the linear critical speed of this pair should not be read more "
        "accurately than that."
    )
