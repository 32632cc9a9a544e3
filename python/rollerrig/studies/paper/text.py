"""The sentences of the paper report, made from its numbers."""

from __future__ import annotations

import math

from rollerrig.analysis import end_of_hunting
from rollerrig.analysis.hunting import decay_frequency
from rollerrig.studies.compare.critical import CriticalTable, cause_sentence, order_sentences
from rollerrig.studies.paper.compute import PaperResults
from rollerrig.studies.paper.plan import MATERIALS, PAPER_CRITICAL_KMH, rig_case

NAMES = {"steel": "steel", "paper": "the paper's material"}


def kmh(value: float, digits: int = 0) -> str:
    """A speed as text; a dash where there is none."""
    return f"{value:.{digits}f} km/h" if math.isfinite(value) else "–"


def _found(results: PaperResults, value: float, digits: int = 0) -> str:
    """A critical speed as text, in a sentence."""
    missing = "not computed" if results.interrupted else "not found in the range"
    return kmh(value, digits) if math.isfinite(value) else missing


def lead(results: PaperResults) -> str:
    """The whole in a few lines."""
    lines = [
        f"{NAMES[m].capitalize()}: linear critical speed on the rig {_found(results, results.linear_kmh(m), 1)}, by disturbance "
        f"(from {1e3 * results.plan.hunting.disturbance:g} mm) {_found(results, results.by_disturbance_kmh(m))}."
        for m in MATERIALS
        if m in results.modes
    ]
    study = results.traction_theory
    if study is not None:
        end = study.isel(time=-1)
        front, rear = (float(end["sliding"].sel(wheel=w)) for w in ("wheelset_1_right", "wheelset_2_right"))
        lines.append(
            f"Traction: at the end the front wheels slide at {1e3 * front:.1f} mm/s and the rear ones at "
            f"{1e3 * rear:.1f} mm/s while they run at {3.6 * float(end['speed']):.0f} km/h."
        )
    if results.interrupted:
        lines.insert(0, "Interrupted: this report holds what was computed until then.")
    return "\n".join(lines)


def critical_paragraphs(results: PaperResults) -> list[str]:
    """What figure 7 says about the critical speed."""
    texts = []
    for material in MATERIALS:
        linear, by_disturbance = results.linear_kmh(material), results.by_disturbance_kmh(material)
        if not (math.isfinite(linear) and math.isfinite(by_disturbance)):
            continue
        found = results.runs[material]
        size = 1e3 * found.disturbance
        text = (
            f"{NAMES[material].capitalize()}: small disturbances grow above {linear:.1f} km/h. From {size:g} mm the "
            f"bogie calms down at {3.6 * found.decays:.1f} km/h and keeps hunting at {3.6 * found.persists:.1f} km/h."
        )
        if by_disturbance < linear - 5:
            text += (
                f" Between {by_disturbance:.0f} and {linear:.0f} km/h both are possible: small disturbances decay, "
                f"larger ones end in a limit cycle, and a bogie that hunts goes on doing so while the rollers slow "
                f"down, until the lower of the two speeds (hysteresis, a subcritical bifurcation)."
            )
        ramp = results.ramps.get(material)
        end = 3.6 * end_of_hunting(ramp, "front_frame") if ramp is not None else math.nan
        if math.isfinite(end):
            text += f" On the ramp down, the hunting ends at {end:.0f} km/h."
        texts.append(text)
    return texts


def frequency_paragraphs(results: PaperResults) -> list[str]:
    """What figure 7b says: how far the bogie on the rig and the whole vehicle on the rails are apart."""
    texts = [
        "Figure 7b of the paper shows the frequency of the lateral oscillation that its simulations gave at each speed, "
        "for a whole vehicle on the rails and a bogie on the rig, and calls frequency and critical speed similar. Here both "
        "are released from the same lateral offset, and the frequency is that of the frame's half-waves: while they die out "
        "(down to a tenth of the largest), or at the end where they go on."
    ]
    for material in MATERIALS:
        apart = frequency_differences(results, material)
        if not apart:
            continue
        rig, vehicle = results.by_disturbance_kmh(material), results.vehicle_by_disturbance_kmh(material)
        low, high = min(apart), max(apart)
        text = (
            f"{NAMES[material].capitalize()}: at the {len(apart)} speeds that both were run at and oscillate, the bogie on the "
            f"rig has a frequency {100 * low:+.0f} to {100 * high:+.0f} % against the vehicle on the rails."
        )
        if math.isfinite(rig) and math.isfinite(vehicle):
            text += (
                f" Hunting from {1e3 * results.plan.hunting.disturbance:g} mm begins at {rig:.0f} km/h on the rig and at "
                f"{vehicle:.0f} km/h on the rails, {100 * (1 - rig / vehicle):.0f} % apart."
            )
        texts.append(text)
    return texts if len(texts) > 1 else []


def frequency_differences(results: PaperResults, material: str) -> list[float]:
    """Frequency of the bogie on the rig over that of the vehicle on track, less one, at each speed both were run at."""
    runs = [brackets.get(material) for brackets in (results.runs, results.vehicle_runs)]
    found = []
    for bracket in runs:
        frequency = {
            round(3.6 * run.speed, 3): run.ending.frequency if run.persists else decay_frequency(run)
            for run in (bracket.runs if bracket else [])
        }
        found.append({speed: value for speed, value in frequency.items() if math.isfinite(value)})
    rig, vehicle = found
    return [rig[speed] / vehicle[speed] - 1 for speed in sorted(rig.keys() & vehicle.keys())]


def rig_paragraphs(results: PaperResults) -> list[str]:
    """Order of the critical speeds and the split of the loss, in words with figures."""
    texts = []
    for material, table in results.tables.items():
        texts.append(
            f"{NAMES[material].capitalize()}. {' '.join(order_sentences(table))} {_bogie_and_vehicle(table)}".strip()
        )
    texts += [
        f"{NAMES[material].capitalize()}, bogie. {cause_sentence(causes)}"
        for material, causes in results.causes.items()
    ]
    return texts


def _bogie_and_vehicle(table: CriticalTable) -> str:
    bogie, vehicle = table.parts
    apart = [table.kmh(bogie, radius) / table.kmh(vehicle, radius) - 1 for radius in table.radii]
    known = [value for value in apart if math.isfinite(value)]
    if not known:
        return ""
    return (
        f"The bogie with its car body held is {100 * min(known):+.1f} to {100 * max(known):+.1f} % from the whole vehicle on the "
        "same support."
    )


RAMP_TEXT = (
    "The rollers are sped up slowly from a disturbed start, as in the paper, and then slowed down again. The model "
    "has no irregularities: below the critical speed the first disturbance decays within seconds to exact rest, and "
    "a bogie at exact rest stays there far above the critical speed, whatever its stability. So the bogie gets a "
    "sideways perturbation at every {every:g} km/h on the way up (triangles): all its moving bodies are given a lateral "
    "velocity of {perturbation:g} mm/s. What remains of one perturbation before the next shows whether disturbances grow. The "
    "rollers gain {rate:g} km/h per second."
)


def ramp_text(results: PaperResults) -> str:
    """What was done in the ramps."""
    ramp = results.plan.ramps[MATERIALS[0]]
    return RAMP_TEXT.format(
        every=round(3.6 * ramp.perturbation_every, 6),
        perturbation=1e3 * ramp.perturbation,
        rate=round(3.6 * ramp.acceleration, 6),
    )


def fit_paragraphs(results: PaperResults) -> list[str]:
    """Which material the paper's critical speed fits, and why; from the numbers."""
    values = {
        (m, kind): value
        for m in MATERIALS
        for kind, value in (("linear", results.linear_kmh(m)), ("by disturbance", results.by_disturbance_kmh(m)))
        if math.isfinite(value)
    }
    if not values:
        return []
    nearest = min(values, key=lambda key: abs(values[key] - PAPER_CRITICAL_KMH))
    by_material = {
        m: min((abs(v - PAPER_CRITICAL_KMH) for (n, _), v in values.items() if n == m), default=math.inf)
        for m in MATERIALS
    }
    material, kind = nearest
    texts = [
        f"The paper reports growing oscillations above {PAPER_CRITICAL_KMH:.0f} km/h. Nearest comes "
        f"{NAMES[material]}, with its {kind} critical speed of {values[nearest]:.0f} km/h; the other material comes "
        f"no nearer than {max(v for v in by_material.values() if math.isfinite(v)):.0f} km/h. "
        f"{_verdict(values[nearest])}"
    ]
    if all(m in results.contact for m in MATERIALS):
        texts.append(_why(results))
    sensitivity = _sensitivity(results)
    return [*texts, sensitivity] if sensitivity else texts


def _verdict(value: float) -> str:
    off = value / PAPER_CRITICAL_KMH - 1
    if abs(off) <= 0.1:
        return "That is within a tenth of the paper's value."
    word = "above" if off > 0 else "below"
    return (
        f"That is still {100 * abs(off):.0f} % {word} the paper's value, so neither repeats it. The paper names "
        "its vehicle, but neither profiles nor friction nor the radius of its rollers; no parameter was tuned here to close "
        "the gap."
    )


def onset_wavelength(results: PaperResults, material: str) -> float:
    """Wavelength of the limit cycle at the lowest speed at which it was found [m]; NaN if there is none."""
    found = results.runs.get(material)
    going = [run for run in found.runs if run.persists and run.valid] if found else []
    return going[0].speed / going[0].ending.frequency if going else math.nan


def _why(results: PaperResults) -> str:
    steel, soft = (results.contact[m] for m in MATERIALS)
    moduli = [rig_case(m).contact.material.shear_modulus for m in MATERIALS]
    text = (
        f"What the material changes: with G = {1e-9 * moduli[1]:.0f} GPa the wheels sink in "
        f"{soft.approach / steel.approach:.1f} times as deep ({1e6 * soft.approach:.0f} instead of "
        f"{1e6 * steel.approach:.0f} µm), and the creep stiffness Σf₁₁ of a wheel falls to "
        f"{100 * soft.creep_stiffness / steel.creep_stiffness:.0f} % (Hertz and Kalker together give G^(1/3), which is "
        f"{100 * (moduli[1] / moduli[0]) ** (1 / 3):.0f} %): the same creepage meets that much less force."
    )
    if all(f(MATERIALS[1]) < f(MATERIALS[0]) for f in (results.linear_kmh, results.by_disturbance_kmh)):
        text += " Both the linear critical speed and that by disturbance come down with it."
    waves = [onset_wavelength(results, m) for m in MATERIALS]
    if all(math.isfinite(w) for w in waves):
        steeper = [(state.wavelength / wave) ** 2 for state, wave in zip((steel, soft), waves, strict=True)]
        text += (
            " With either material the wheels steer more sharply once they move: where hunting begins, its wavelength is "
            f"{waves[0]:.1f} m with steel and {waves[1]:.1f} m with the paper's material, against "
            f"{steel.wavelength:.1f} m and {soft.wavelength:.1f} m for small motion at low speed, as if the conicity were "
            f"{steeper[0]:.1f} and {steeper[1]:.1f} times as large. That goes with hunting from a disturbance well below "
            "the linear critical speed."
        )
    return text


def _sensitivity(results: PaperResults) -> str:
    parts = []
    for material in MATERIALS:
        speeds = [3.6 * v for v in results.barriers.get(material, {}).values() if math.isfinite(v)]
        if len(speeds) > 1:
            parts.append(f"{NAMES[material]} {min(speeds):.0f} to {max(speeds):.0f} km/h")
    if not parts:
        return ""
    return (
        "How firm these numbers are: near its centred position S1002 on UIC60 1:40 touches in two patches per "
        "wheel, and the method of the paper treats each as a Hertz contact of its own. What happens where two "
        "patches become one is a modelling choice (contact.merging_criterion). Over the values in the table the linear "
        "critical speed is "
        + " and ".join(parts)
        + ". The exact solution has a single patch there, so the linear critical speed of this pair "
        "should not be read finer than that."
    )


LEFT_OUT = (
    "Track or roller irregularities, and any compliance of the rig itself: the rollers only spin.",
    "The car body's motion: it is held, as in the paper. The frame therefore settles on the contacts without the "
    "car body following, and the wheel loads are about 0.1 % below their static values.",
    "Contact of other than elliptic shape: two patches of one wheel are two Hertz ellipses, where the exact theory "
    "sees one patch; overlaps are counted in the table of counters.",
    "Transient rolling contact, falling friction, temperature and wear: creep forces follow Kalker's steady linear "
    "theory with saturation at constant friction.",
    "Flexible wheelsets and frames, and drive dynamics: torques are prescribed.",
    "The control of the rig: its rollers are held at a speed in figure 7 and turn freely in figure 8.",
)
"""What the model does not have."""
