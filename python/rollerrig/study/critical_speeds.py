"""Critical speeds as several studies report them: runs from a disturbance, rollers' radius, effects of the rollers.

critical speeds -> [critical_speeds] -> jobs, numbers, CSV rows, tables, sentences
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

from rollerrig.analysis import critical_speed
from rollerrig.analysis.critical_speed import (
    EFFECTS,
    RANGE_KMH,
    TRACK,
    CriticalSpeedByDisturbance,
    LinearCriticalSpeed,
    On,
    Place,
)
from rollerrig.analysis.hunting import HuntingRun, HuntingSettings, hunting_run
from rollerrig.config import Case
from rollerrig.study.jobs import Chain, Chains, Done, Job, Round, job
from rollerrig.study.report import Table

EFFECT_LABELS = {
    "curvature": "curvature along x: shorter patch",
    "conicity": "conicity of the roller",
    "spin": "spin of the roller",
    "yaw": "yawed wheel leaves the crown",
}


def words(name: str) -> str:
    """A part of the vehicle, or a body: 'leading bogie'."""
    return name.replace("_", " ")


def disturbance_chains(
    cases: Mapping[str, Case],
    speeds_kmh: Mapping[str, Sequence[float]],
    width_kmh: float,
    settings: HuntingSettings,
) -> Chains:
    """Runs from a disturbance, first at these speeds [km/h] of each label, until its critical speed is bracketed to a width."""

    def chain(label: str) -> Chain:
        def following(done: Done) -> Round:
            runs: list[HuntingRun] = []
            wanted = sorted((v / 3.6 for v in speeds_kmh[label]), reverse=True)  # the fastest take longest
            while wanted:
                names = {_run_name(label, v): job(hunting_run, (cases[label], v, settings)) for v in wanted}
                if missing := {name: one for name, one in names.items() if name not in done}:
                    return missing
                runs += [done[name] for name in names]
                wanted = critical_speed.bracket(runs, settings.disturbance).further_speeds(width_kmh / 3.6)
            return {}

        return following

    expected = sum(len(speeds) + 2 * narrowings(speeds, width_kmh, 3) for speeds in speeds_kmh.values())
    return Chains(tuple(map(chain, cases)), expected)


def narrowings(speeds_kmh: Sequence[float], width_kmh: float, parts: int) -> int:
    """How often the widest step between rising speeds must be divided into parts until it is no wider than a width [km/h]."""
    widest = max((b - a for a, b in itertools.pairwise(speeds_kmh)), default=width_kmh)
    return math.ceil(math.log(max(1.0, widest / width_kmh), parts) - 1e-9)


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


Scans = Mapping[Place, LinearCriticalSpeed]
"""Linear critical speeds by part of the vehicle and radius of the rollers; absent where Ctrl-C came first."""
Split = Mapping[str, Any]  # what the effects of a roller cost, of `critical_speed.effect_split`


def roller_jobs(
    rig: Case, parts: Sequence[str], radii: Sequence[float], speeds_kmh: Sequence[float] = RANGE_KMH, label: str = ""
) -> dict[str, Job]:
    """Linear critical speeds in a range, over the rollers' radius and with effects switched off."""
    cases = {_place_name(label, *place): case for place, case in critical_speed.radius_cases(rig, parts, radii).items()}
    cases |= {_effects_name(label, on): case for on, case in critical_speed.effect_cases(rig).items()}
    return {name: job(critical_speed.scan_linear, case, speeds_kmh) for name, case in cases.items()}


def roller_results(
    rig: Case, parts: Sequence[str], radii: Sequence[float], done: Done, label: str = ""
) -> tuple[Scans, dict[On, LinearCriticalSpeed]]:
    """What is done of `roller_jobs`: over the radius, and by the effects that are on."""
    places = critical_speed.radius_cases(rig, parts, radii)
    return (
        {place: done[name] for place in places if (name := _place_name(label, *place)) in done},
        {on: done[name] for on in critical_speed.effect_cases(rig) if (name := _effects_name(label, on)) in done},
    )


def _place_name(label: str, part: str, radius: float) -> str:
    return f"linear critical speed{label}, {words(part)} on {support_words(radius)}"


def _effects_name(label: str, on: On) -> str:
    return f"linear critical speed{label} with roller effects: {', '.join(e for e in EFFECTS if e in on) or 'none'}"


def support_words(radius: float) -> str:
    """'rollers of 0.725 m', or 'track'."""
    return "track" if radius == TRACK else f"rollers of {radius:g} m"


def radius_numbers(found: Scans) -> dict[str, dict[str, float]]:
    """Part -> radius -> critical speed [km/h]."""
    numbers: dict[str, dict[str, float]] = {part: {} for part, _ in found}
    for (part, radius), scan in found.items():
        numbers[part]["track" if radius == TRACK else f"{radius:g}"] = scan.speed_kmh
    return numbers


def radius_rows(found: Scans) -> list[list[object]]:
    """critical_speeds.csv, header first."""
    header = ["part", "roller_radius_m", "linear_critical_speed_kmh", "frequency_hz", "mode", "note"]
    rows: list[list[object]] = [list(header)]
    for (part, radius), scan in found.items():
        note = scan.problem or ", ".join(f"{name} grows at the lowest speed" for name in scan.grows_at_start)
        onset = (scan.onset.frequency, scan.onset.name) if scan.onset else (math.nan, "")
        rows.append([part, "track" if radius == TRACK else radius, scan.speed_kmh, *onset, note])
    return rows


def linear_cell(scan: LinearCriticalSpeed | None) -> str:
    """A linear critical speed [km/h] in a table."""
    if scan is None:
        return "not computed"
    if scan.problem:
        return "no equilibrium"
    if scan.grows_at_start:
        return "unstable at the lowest speed"
    return f"{scan.speed_kmh:.1f}" if scan.onset else "none in the range"


def radius_table(found: Scans, caption: str) -> Table:
    """A row per support, a column per part, the change against the track beside each."""
    parts, radii = dict.fromkeys(part for part, _ in found), sorted({radius for _, radius in found}, reverse=True)

    def cells(part: str, radius: float) -> tuple[str, str]:
        own, track = (found.get((part, r), LinearCriticalSpeed()).speed_kmh for r in (radius, TRACK))
        change = math.nan if radius == TRACK else own / track - 1.0
        return linear_cell(found.get((part, radius))), f"{100 * change:+.1f} %" if math.isfinite(change) else ""

    rows = [[support_words(radius), *itertools.chain(*(cells(part, radius) for part in parts))] for radius in radii]
    return Table(
        ["on", *itertools.chain(*((f"{words(part)} [km/h]", "against track") for part in parts))], rows, caption
    )


def effects_table(split: Split, caption: str) -> Table:
    """The split of the loss."""
    loss = split["track_kmh"] - split["rig_kmh"]
    columns = [
        [*single.values(), sum(single.values()), split[f"interaction_{name}_kmh"], loss]
        for name, single in (("switched_off", split["gain_switched_off_kmh"]), ("alone", split["loss_alone_kmh"]))
    ]
    names = (*EFFECT_LABELS.values(), "sum of the four", "interaction: loss less the sum", "track less rig")
    rows = [
        [name, *(f"{v:+.1f}" if math.isfinite(v) else "–" for v in row)]
        for name, *row in zip(names, *columns, strict=True)
    ]
    return Table(("effect", "switched off alone: gain [km/h]", "on alone: loss [km/h]"), rows, caption)


def effects_sentence(split: Split) -> str:
    """The split of the loss in words."""
    track, rig = split["track_kmh"], split["rig_kmh"]
    if not math.isfinite(track - rig):
        return "Track or rig has no critical speed in the range: there is no loss to split."
    change = 100 * (rig / track - 1.0)
    text = f"Linear critical speed: {track:.1f} km/h on track, {rig:.1f} km/h on the rig, {change:+.1f} %."
    gains = {e: gain for e, gain in split["gain_switched_off_kmh"].items() if math.isfinite(gain)}
    single = ", ".join(f"{EFFECT_LABELS[e].partition(':')[0]} {gain:+.1f}" for e, gain in gains.items())
    return text + (f" Without one effect it rises by, in km/h: {single}." if gains else "")
