"""The sentences of the paper report, made from its numbers."""

from __future__ import annotations

import math

from rollerrig.analysis import CriticalSpeedByDisturbance, end_of_hunting
from rollerrig.analysis.hunting import decay_frequency
from rollerrig.study import critical_speeds as speeds
from rollerrig.study.checks import counts_text
from rollerrig.study.interval import Interval
from rollerrig.study.paper_contacts import paper_speed_sentence
from rollerrig.study.paper_plan import EXACT, MATERIALS, NAMES, OWN, RIG, TABLE_PARTS, VEHICLE, PaperPlan
from rollerrig.study.paper_results import Results
from rollerrig.study.quantities import Numbers

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


def linear(value: float, plan: PaperPlan) -> str:
    """A linear critical speed [km/h] as text; where there is none, the range that was looked at."""
    if math.isfinite(value):
        return f"{value:z.1f} km/h"
    return f"none from {plan.linear_kmh[0]:g} to {plan.linear_kmh[-1]:g} km/h"


def _name(material: str) -> str:
    return NAMES[material].capitalize()


def summary(results: Results, numbers: Numbers, plan: PaperPlan) -> list[str]:
    """The whole in a few lines."""
    size = 1e3 * plan.hunting.disturbance
    lines = [
        f"{_name(m)}: critical speed on the rig, linear: {linear(results.linear_kmh(m), plan)}; by disturbance (from {size:g} "
        f"mm): {results.by_disturbance(m).text('km/h', 1)}."
        for m in results.modes
    ]
    lines += contact_sentences(results)
    found_by_runs = [one for runs in (results.runs, results.vehicle_runs) for one in runs.values()]
    lines += [sentence for one in found_by_runs if (sentence := speeds.ended_early_sentence(one))]
    end = numbers["traction"]
    if end is not None:
        front, rear = (end[f"wheelset_{k}_right"]["sliding_mmps"] for k in (1, 2))
        lines.append(
            f"Traction: at the end the front wheels slide at {front:z.1f} mm/s and the rear ones at {rear:z.1f} mm/s, "
            f"at a speed of {end['speed_kmh']:z.0f} km/h."
        )
    return [*lines, counts_text(results.checks)] if results.checks else lines


def contact_sentences(results: Results) -> list[str]:
    """What the paper's critical speed is with its own contact and with the exact one, by material."""
    return [
        paper_speed_sentence(
            NAMES[m],
            {OWN: results.linear_kmh(m), EXACT: results.exact.linear_kmh(m, RIG)},
            {OWN: results.by_disturbance(m), EXACT: results.exact.by_disturbance(m, RIG)},
        )
        for m in results.exact.linear
        if m in results.modes
    ]


def ramp_text(plan: PaperPlan) -> str:
    """What was done in the ramps."""
    ramp = plan.ramps[MATERIALS[0]]
    every, rate = (round(3.6 * value, 6) for value in (ramp.perturbation_every, ramp.acceleration))
    return RAMP.format(every=every, perturbation=1e3 * ramp.perturbation, rate=rate)


def critical_paragraphs(results: Results) -> list[str]:
    """What figure 7 says about the critical speed."""
    texts = []
    for material, found in results.runs.items():
        small, large = results.linear_kmh(material), results.by_disturbance(material)
        if not (math.isfinite(small) and large.known):
            continue
        text = (
            f"{_name(material)}: small disturbances grow above {small:z.1f} km/h. From {1e3 * found.disturbance:g} mm the "
            f"critical speed is {large.text('km/h', 1)}; at the lower end the motion decays, at the upper one it persists."
        )
        if large.high < small - 5:
            text += (
                f" From {large.high:z.0f} to {small:z.0f} km/h both are possible: small disturbances decay, larger ones end in "
                "a limit cycle, and a hunting bogie continues to hunt while the rollers slow down, until the lower of the two "
                "speeds (hysteresis, a subcritical bifurcation)."
            )
        ramp = results.ramps.get(material)
        end = 3.6 * end_of_hunting(ramp, "front_frame") if ramp is not None else math.nan
        texts.append(text + (f" On the ramp down, the hunting ends at {end:z.0f} km/h." if math.isfinite(end) else ""))
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
        rig, vehicle = results.by_disturbance(material), results.by_disturbance(material, VEHICLE)
        text = (
            f"{_name(material)}: at the {len(apart)} speeds at which both oscillate, the frequency of the bogie on "
            f"the rig differs from that of the vehicle on the rails by {100 * min(apart):+z.0f} to {100 * max(apart):+z.0f} %."
        )
        if rig.known and vehicle.known:
            ratio = rig.over(vehicle)
            lower = Interval(100 * (1 - ratio.high), 100 * (1 - ratio.low))
            text += (
                f" The critical speed by disturbance, from {1e3 * plan.hunting.disturbance:g} mm, is {rig.text('km/h')} "
                f"on the rig and {vehicle.text('km/h')} on the rails"
                + (f", lower on the rig by {lower.text('%')}." if lower.bounded else ".")
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
            ends = f"{min(known):+z.1f} to {max(known):+z.1f} %"
            text += f" The bogie with fixed car body differs by {ends} from the whole vehicle."
        texts.append(text)
    return texts + [f"{_name(m)}, bogie. {speeds.effects_sentence(split)}" for m, split in results.effects.items()]


def onset_wavelength(results: Results, material: str) -> float:
    """Wavelength of the limit cycle at the lowest speed at which it was found [m]; NaN if there is none."""
    found = results.runs.get(material)
    lasting = [run for run in found.runs if run.persists] if found else []
    return lasting[0].speed / lasting[0].final.frequency if lasting else math.nan
