"""What the lags of estimator and drives cost, and what each way of compensating them leaves: ensembles beside the track.

Case of a braked rig -> [compensation_jobs] -> ends of runs by variant and start -> means, errors, equivalent dead time

A rig that is late acts like a track whose slide protection has more dead time: the same test on track with some more of it
gives the scale on which the rig's dump cycles are read.
"""

from collections.abc import Mapping

from rollerrig.analysis.equivalent_dead_time import lags
from rollerrig.analysis.slide_statistics import under_test
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.common.formatting import number
from rollerrig.config import Case
from rollerrig.config.schema.rig_control import BandwidthEstimator
from rollerrig.study.ensemble import difference, means, measured_dead_time, start_jobs, started
from rollerrig.study.jobs import Done, Progress, Round, job, whole_run
from rollerrig.study.quantities import Numbers, Quantities
from rollerrig.study.report import Block, Table, Text
from rollerrig.study.runs.adhesion import track_case
from rollerrig.study.runs.control import Changes

TRACK = "track"
NONE: Changes = {"rig_control.axle_torque.kind": "estimated", "rig_control.drive_command.kind": "direct"}
_KNOWN: Changes = {"rig_control.axle_torque.kind": "known"}
_LEAD: Changes = {"rig_control.drive_command.kind": "lead"}
_LOOP: Changes = {"rig_control.drive_command.kind": "torque_loop"}
VARIANTS: Mapping[str, Changes] = {
    "no compensation": NONE,
    "estimator with 100 Hz": {**NONE, "rig_control.estimator.bandwidth": 100.0},
    "estimated torque extrapolated": {**NONE, "rig_control.axle_torque.kind": "extrapolated"},
    "torque from the pressure": {**NONE, **_KNOWN},
    "lead of the drives": {**NONE, **_LEAD},
    "loop over the drives' torque": {**NONE, **_LOOP},
    "pressure, and loop": {**_KNOWN, **_LOOP},
    "pressure, and lead": {**_KNOWN, **_LEAD},
    "the same, pads rub 20 % less than assumed": {**_KNOWN, **_LEAD, "rig_control.axle_torque.brake_friction": 1.25},
    "torque known exactly, and lead": {**NONE, **_LEAD, "rig_control.estimator": {"kind": "exact"}},
}
"""Ways to compensate, the rig as it would be without any at first."""

DEAD_TIMES = (3e-3, 6e-3, 9e-3, 12e-3, 15e-3)
"""Added to that of the slide protection on track [s]."""

STARTS = 8
RESULTS = ("distance_m", "dump_cycles", "air_litres")


def compensation_cases(case: Case) -> dict[str, Case]:
    """Label -> the case; none where no slide protection could show a lag."""
    if case.brake is None or case.slide_protection is None or not case.slide_protection.is_ours:
        return {}
    assert case.rig_control is not None
    track, own = track_case(case), case.slide_protection.delay
    found = {TRACK: track}
    for seconds in DEAD_TIMES:
        found[_later(seconds)] = track.with_changes({"slide_protection.delay": own + seconds})
    for label, changes in VARIANTS.items():
        if "rig_control.estimator.bandwidth" in changes and not isinstance(
            case.rig_control.estimator, BandwidthEstimator
        ):
            continue
        found[label] = case.with_changes(changes)
    return found


def compensation_jobs(case: Case) -> Round:
    """A job for each variant and start."""
    return start_jobs(compensation_cases(case), lambda one, _: job(run_end, one), STARTS)


def run_end(case: Case, progress: Progress | None = None) -> dict[str, float]:
    """What a run has come to at its end, by name of RESULTS."""
    last = under_test(whole_run(case, progress)).isel(time=-1)
    values = (last["train_distance"], last["dump_cycles"].sum(), 1e3 * last["air"].sum())
    return {name: float(value) for name, value in zip(RESULTS, values, strict=True)}


def compensation_numbers(case: Case, done: Done) -> dict[str, dict[str, float]] | None:
    """Means and errors by label, and the dead time on track that each variant of the rig is like."""
    cases = compensation_cases(case)
    runs = {label: started(done, label) for label in cases}
    if not cases or any(len(one) < STARTS for one in runs.values()):
        return None
    cycles = {label: [one["dump_cycles"] for one in tests] for label, tests in runs.items()}
    estimates = {label: difference(one, cycles[TRACK]) for label, one in cycles.items()}
    added = {TRACK: 0.0, **{_later(seconds): seconds for seconds in DEAD_TIMES}}
    curve = {seconds: estimates[label] for label, seconds in added.items()}
    numbers: dict[str, dict[str, float]] = {}
    for label, one in cases.items():
        like = measured_dead_time(estimates[label], curve)
        late = added[label] if label in added else lags(assemble_with_actuators(one)).total
        times = {"measured_ms": 1e3 * like.mean, "measured_ms_standard_error": 1e3 * like.standard_error}
        numbers[label] = {"predicted_ms": 1e3 * late, **means(runs[label], RESULTS), **times}
    return numbers


def _later(seconds: float) -> str:
    return f"{TRACK}, {1e3 * seconds:g} ms more dead time"


def compensation_blocks(numbers: Numbers, quantities: Quantities) -> list[Block]:
    """Text and table of the report."""
    text = (
        f"Means of {STARTS} starts, which draw by [ensemble] alike, and their standard errors. A rig that is late by some time "
        "acts like a track whose slide protection has that much more dead time: predicted is the sum of the lags (D17), measured "
        "what a track needs for as many dump cycles, linear between the dead times that were run."
    )
    names = [q.name for q in quantities.below("compensation.*")]
    table: Table = quantities.table(dict(numbers), names, "what each compensation leaves of the lag", "variant")
    return [Text(text), table]


def compensation_text(numbers: Numbers) -> str:
    """The finding in a sentence."""
    track, none, best = (numbers[label] for label in (TRACK, "no compensation", "pressure, and lead"))

    def against(one: Numbers, name: str) -> str:
        return f"{100.0 * (one[name] / track[name] - 1.0):+.1f} %" if track[name] else "–"

    def measured(one: Numbers) -> str:
        return f"{number(one['measured_ms'], 2)} ± {number(one['measured_ms_standard_error'], 1)} ms"

    return (
        f"Without compensation the rig acts like a track with {measured(none)} more dead time (predicted "
        f"{number(none['predicted_ms'], 3)} ms), dump cycles {against(none, 'dump_cycles')}, air {against(none, 'air_litres')}; "
        f"with the torque known from the brake's pressure and a lead of the drives {measured(best)}, dump cycles "
        f"{against(best, 'dump_cycles')}, air {against(best, 'air_litres')}."
    )
