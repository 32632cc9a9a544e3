"""Critical speeds as several studies report them: runs from a disturbance, rollers' radius, effects of the rollers.

critical speeds -> [critical_speeds] -> jobs, numbers, CSV rows, tables, sentences, figures
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rollerrig.analysis import critical_speed
from rollerrig.analysis.critical_speed import (
    EFFECTS,
    RANGE_KMH,
    TRACK,
    CriticalSpeedByDisturbance,
    CriticalSpeedOverRadius,
    EffectSplit,
    LinearCriticalSpeed,
)
from rollerrig.analysis.hunting import HuntingRun, HuntingSettings, hunting_run
from rollerrig.config import Case
from rollerrig.plot.compare import critical_over_radius, effect_bars
from rollerrig.study.jobs import Done, Job, Round, job
from rollerrig.study.report import Block, Picture, Table, Text

EFFECT_LABELS = {
    "curvature": "curvature along x: shorter patch",
    "conicity": "conicity of the roller",
    "spin": "spin of the roller",
    "yaw": "yawed wheel leaves the crown",
}


def words(name: str) -> str:
    """A part of the vehicle, or a body: 'leading bogie'."""
    return name.replace("_", " ")


def disturbance_rounds(
    cases: Mapping[str, Case],
    speeds_kmh: Mapping[str, Sequence[float]],
    width_kmh: float,
    settings: HuntingSettings,
    done: Done,
) -> Iterator[Round]:
    """Rounds of runs from a disturbance, until each critical speed is bracketed to a width."""
    runs: dict[str, list[HuntingRun]] = {label: [] for label in cases}
    for wanted in critical_speed.rounds_by_disturbance(speeds_kmh, width_kmh, runs, settings.disturbance):
        yield {_run_name(label, v): job(hunting_run, (cases[label], v, settings)) for label, v in wanted}
        for label, speed in wanted:
            runs[label].append(done[_run_name(label, speed)])


def brackets(labels: Sequence[str], settings: HuntingSettings, done: Done) -> dict[str, CriticalSpeedByDisturbance]:
    """Label -> critical speed by disturbance, of the labels that have runs."""
    runs = {label: [run for name, run in done.items() if name.startswith(f"run {label}, ")] for label in labels}
    return {label: critical_speed.bracket(found, settings.disturbance) for label, found in runs.items() if found}


def _run_name(label: str, speed: float) -> str:
    return f"run {label}, {3.6 * speed:.6g} km/h"


def disturbance_numbers(found: CriticalSpeedByDisturbance) -> dict[str, Any]:
    """The runs and the bracket they give."""
    return {
        "disturbance_mm": 1e3 * found.disturbance,
        "decays_kmh": 3.6 * found.decays,
        "persists_kmh": 3.6 * found.persists,
        "runs": [
            {
                "speed_kmh": round(3.6 * run.speed, 6),
                "amplitude_mm": 1e3 * run.final.amplitude if run.valid else math.nan,
                "frequency_hz": run.final.frequency if run.valid else math.nan,
                "growth_rate_at_end_per_s": run.final.rate if run.valid else math.nan,
                "persists": run.persists,
                "decays": run.decays,
                "status": run.motion.attrs["status"],
                "energy_relative_residual": run.motion.attrs["energy_relative_residual"],
            }
            for run in found.runs
        ],
    }


def ended_early(runs: Sequence[tuple[float, str]], count: int) -> str:
    """Which runs of `count` did not come to their end, by speed [m/s] and message, and how the slowest ended; '' if all did."""
    if not runs:
        return ""
    speeds = sorted({round(3.6 * speed, 1) for speed, _ in runs})
    where = f"at {speeds[0]:g} km/h" if len(speeds) == 1 else f"from {speeds[0]:g} to {speeds[-1]:g} km/h"
    _, message = min(runs)
    return (
        f"{len(runs)} of {count} runs, {where}, did not come to their end or to a decision and count neither as limit cycle nor "
        "as decay. "
        f"{'It' if len(runs) == 1 else 'The slowest'} ended so: {message}"
    )


def ended_early_sentence(found: CriticalSpeedByDisturbance) -> str:
    """The same of the runs from a disturbance."""
    runs = [(run.speed, str(run.motion.attrs["status_message"])) for run in found.ended_early]
    return ended_early(runs, len(found.runs))


def roller_jobs(
    rig: Case, parts: Sequence[str], radii: Sequence[float], speeds_kmh: Sequence[float] = RANGE_KMH, label: str = ""
) -> dict[str, Job]:
    """Linear critical speeds in a range, over the rollers' radius and with effects switched off."""
    speeds = [v / 3.6 for v in speeds_kmh]
    cases = {_place_name(label, *place): case for place, case in critical_speed.radius_cases(rig, parts, radii).items()}
    cases |= {_effects_name(label, on): case for on, case in critical_speed.effect_cases(rig).items()}
    return {name: job(critical_speed.scan_linear, (case, speeds)) for name, case in cases.items()}


def over_radius(
    done: Done, parts: Sequence[str], radii: Sequence[float], label: str = ""
) -> CriticalSpeedOverRadius | None:
    """Table from the results of `roller_jobs`; None if there are none yet."""
    places = [(part, radius) for part in parts for radius in (*sorted(radii), TRACK)]
    found = {place: done[name] for place in places if (name := _place_name(label, *place)) in done}
    return critical_speed.critical_speed_over_radius(places, found) if found else None


def effect_split(done: Done, label: str = "") -> EffectSplit | None:
    """Table from the results of `roller_jobs`; None if there are none yet."""
    every = frozenset(EFFECTS)
    sets = [every, frozenset[str](), *(every - {e} for e in EFFECTS), *(frozenset({e}) for e in EFFECTS)]
    found = {on: done[name] for on in sets if (name := _effects_name(label, on)) in done}
    return EffectSplit(found) if found else None


def _place_name(label: str, part: str, radius: float) -> str:
    return f"linear critical speed{label}, {words(part)} on {support_words(radius)}"


def _effects_name(label: str, on: frozenset[str]) -> str:
    return f"linear critical speed{label} with roller effects: {', '.join(e for e in EFFECTS if e in on) or 'none'}"


def support_words(radius: float) -> str:
    """'rollers of 0.725 m', or 'track'."""
    return "track" if radius == TRACK else f"rollers of {radius:g} m"


def radius_numbers(table: CriticalSpeedOverRadius | None) -> dict[str, dict[str, float]]:
    """Part -> radius -> critical speed [km/h]."""
    if table is None:
        return {}
    return {
        part: {
            "track" if radius == TRACK else f"{radius:g}": table.kmh(part, radius)
            for radius in table.radii
            if (part, radius) in table.found
        }
        for part in table.parts
    }


def effect_numbers(split: EffectSplit | None) -> dict[str, Any] | None:
    """The split of the loss from track to rig [km/h]."""
    if split is None:
        return None
    off, alone = split.switched_off, split.alone
    both = {"gain_switched_off_kmh": off, "loss_alone_kmh": alone}
    left = {"interaction_switched_off_kmh": split.interaction(off), "interaction_alone_kmh": split.interaction(alone)}
    return {"track_kmh": split.track, "rig_kmh": split.rig, **both, **left}


def radius_rows(table: CriticalSpeedOverRadius | None) -> list[list[object]]:
    """critical_speeds.csv, header first."""
    rows: list[list[object]] = [
        ["part", "roller_radius_m", "linear_critical_speed_kmh", "frequency_hz", "mode", "note"]
    ]
    for (part, radius), scan in (table.found if table else {}).items():
        onset, grows = scan.onset, (f"{name} grows at the lowest speed" for name in scan.grows_at_start)
        note = scan.problem or ", ".join(grows)
        found = (scan.speed_kmh, onset.frequency, onset.name) if onset else (math.nan, math.nan, "")
        rows.append([part, "track" if math.isinf(radius) else radius, *found, note])
    return rows


def effect_rows(split: EffectSplit | None) -> list[list[object]]:
    """roller_effects.csv, header first."""
    rows: list[list[object]] = [[*EFFECTS, "linear_critical_speed_kmh"]]
    return rows + [[*(int(e in on) for e in EFFECTS), split.kmh(on)] for on in (split.found if split else {}) if split]


def linear_cell(scan: LinearCriticalSpeed | None) -> str:
    """A linear critical speed [km/h] in a table."""
    if scan is None:
        return "not computed"
    if scan.problem:
        return "no equilibrium"
    if scan.grows_at_start:
        return "unstable at the lowest speed"
    return f"{scan.speed_kmh:.1f}" if scan.onset else "none in the range"


def radius_table(table: CriticalSpeedOverRadius, caption: str) -> Table:
    """A row per support, a column per part, the change against the track beside each."""
    header = ["on"]
    for part in table.parts:
        header += [f"{words(part)} [km/h]", "against track"]
    rows = []
    for radius in (TRACK, *reversed(table.radii[:-1])):
        row = [support_words(radius)]
        for part in table.parts:
            change = table.kmh(part, radius) / table.kmh(part, TRACK) - 1
            shown = f"{100 * change:+.1f} %" if math.isfinite(change) and radius != TRACK else ""
            row += [linear_cell(table.found.get((part, radius))), shown]
        rows.append(row)
    return Table(header, rows, caption)


def effects_table(split: EffectSplit, caption: str) -> Table:
    """The split of the loss."""
    off, alone = split.switched_off, split.alone
    rows = [[text, _signed(off[effect]), _signed(alone[effect])] for effect, text in EFFECT_LABELS.items()]
    rows.append(["sum of the four", _signed(sum(off.values())), _signed(sum(alone.values()))])
    rows.append(["interaction: loss less the sum", _signed(split.interaction(off)), _signed(split.interaction(alone))])
    rows.append(["track less rig", _signed(split.loss), _signed(split.loss)])
    return Table(("effect", "switched off alone: gain [km/h]", "on alone: loss [km/h]"), rows, caption)


def _signed(value: float) -> str:
    return f"{value:+.1f}" if math.isfinite(value) else "–"


def effects_sentence(split: EffectSplit) -> str:
    """The split of the loss in words."""
    if not math.isfinite(split.loss):
        return "Track or rig has no critical speed in the range: there is no loss to split."
    known = {effect: gain for effect, gain in split.switched_off.items() if math.isfinite(gain)}
    text = (
        f"The linear critical speed falls from {split.track:.1f} km/h on track to {split.rig:.1f} km/h on the rig, by "
        f"{100 * split.loss / split.track:.1f} %."
    )
    if known:
        most = max(known, key=lambda effect: known[effect])
        text += f" The largest effect is the {_short(most)}: {known[most]:+.1f} km/h without it."
    helping = [_short(effect) for effect, gain in known.items() if gain < -0.05]
    verb = "raises" if len(helping) == 1 else "raise"
    return text + (f" The {' and the '.join(helping)} {verb} the critical speed." if helping else "")


def _short(effect: str) -> str:
    return EFFECT_LABELS[effect].split(":")[0]


def radius_picture(name: str, table: CriticalSpeedOverRadius, marked: float, caption: str) -> Picture:
    """Critical speed of every part that has one over the rollers' radius."""
    radii = [radius for radius in table.radii if radius != TRACK]
    curves = {
        words(part): (radii, [table.kmh(part, radius) for radius in radii], table.kmh(part, TRACK))
        for part in table.parts
    }
    shown = {label: curve for label, curve in curves.items() if any(map(math.isfinite, curve[1]))}
    return Picture(name, critical_over_radius(shown, marked), caption)


def effects_picture(name: str, split: EffectSplit, caption: str) -> Picture:
    """The split of the loss as bars."""
    off, alone = ({EFFECT_LABELS[e]: v for e, v in one.items()} for one in (split.switched_off, split.alone))
    return Picture(name, effect_bars(off, alone, split.loss), caption)


def effects_blocks(split: EffectSplit | None, caption: str) -> list[Block]:
    """All about the effects of the rollers, under a picture with this caption; nothing where they were not computed."""
    if split is None:
        return []
    table = "Linear critical speed, track less rig, split by switching the four effects of a roller (contact.roller_effects)."
    picture = effects_picture("roller_effects", split, caption)
    return [Text(effects_sentence(split)), picture, effects_table(split, table)]
