"""Which controller of the roller drives tolerates what: one test under many variants, and the limit each exceeds first.

Case -> families of variants -> [ControlStudy] -> tracking and ripple of each run -> failure thresholds, ranking
     -> lightly excited runs over the gains -> growth, beside the eigenvalues of the linear loop

Tracking is the wheel's speed less the virtual wheel's, over the train's speed (docs/theory/rig_control.md).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.torque_ripple import RIPPLE_ABOVE, torque_ripple
from rollerrig.analysis.tracking import largest, rms, slip, tracking
from rollerrig.config import Case, ConfigError, ConfigProblem, Rig
from rollerrig.config.errors import nearest
from rollerrig.mechatronics import users_controllers
from rollerrig.plot import control as figures
from rollerrig.study.control_ranking import RIPPLE_LIMIT, TRACKING_LIMIT, Rank, Result, Threshold, ranking
from rollerrig.study.control_stability import LOOP_QUANTITIES, loop_blocks, loop_jobs, loop_numbers
from rollerrig.study.control_variants import FAMILIES, REFERENCES, USER, Family
from rollerrig.study.frame import Study
from rollerrig.study.jobs import Done, Progress, Round, job, whole_run
from rollerrig.study.quantities import Numbers, Quantities, Quantity
from rollerrig.study.report import Picture, Section, Table

OUTPUT_STEP = 2e-3
"""Of the runs compared [s]; ripple is seen up to its Nyquist frequency, 250 Hz."""

KEPT = ["axle_speed", "virtual_speed", "train_speed", "train_distance", "real_sliding", "roller_torque", "valve"]
PERCENT = ("%", 100.0)

RUN = (
    Quantity("*.*.status", "how the run ended"),
    Quantity("*.*.ended_s", "when", "s"),
    Quantity("*.*.tracking_rms", "wheel less virtual wheel over train speed, RMS", "1", "tracking RMS", 3, PERCENT),
    Quantity("*.*.tracking_largest", "largest of the same", "1", "largest", 3, PERCENT),
    Quantity("*.*.largest_slip", "of the wheels against the virtual train, over its speed", "1"),
    Quantity("*.*.real_sliding_rms_mps", "wheel against roller", "m/s"),
    Quantity("*.*.real_sliding_largest_mps", "largest of the same", "m/s", "real sliding", 3, ("mm/s", 1e3)),
    Quantity("*.*.roller_torque_largest_nm", "of a roller drive", "N m", "roller torque", 3, ("kN m", 1e-3)),
    Quantity("*.*.distance_m", "run by the virtual train", "m"),
    Quantity("*.*.distance_relative", "over that of the case as shipped, less 1", "1", "distance, less shipped", 3, PERCENT),
    Quantity("*.*.dump_cycles", "of the slide protection, all axles", "", "dump cycles"),
    Quantity("*.*.air_litres", "taken by the cylinders, at ambient pressure", "l", "air", 3),
    Quantity("*.*.ripple_nm", f"persistent roller torque above {RIPPLE_ABOVE:g} Hz, RMS, median of 0.25 s", "N m", "ripple", 3),
    Quantity("*.*.ripple_hz", "where that ripple has most power", "Hz"),
)  # fmt: skip
QUANTITIES = Quantities(
    Quantity("case", "name of the case"),
    Quantity("duration_s", "of each run", "s"),
    Quantity("limits.tracking_rms", "tracking RMS from which on a variant fails", "1"),
    Quantity("limits.ripple_nm", "torque ripple from which on a variant fails", "N m"),
    RUN,
    Quantity("results.*.family", "what is varied"),
    Quantity("results.*.curve", "under which fixed change"),
    Quantity("results.*.value", "on the family's axis"),
    Quantity("results.*.cause", "of the failure: tracking, ripple, or the status of a run that ended early"),
    Quantity("ranking.*.**", "every curve, the worst first; thresholds: where it fails going out from the case's own value: the "
             "value at which a limit is passed, interpolated, or a test first ended early; the last good value; the cause"),
    LOOP_QUANTITIES,
)  # fmt: skip
REFERENCE_COLUMNS = ("status", "tracking_rms", "tracking_largest", "real_sliding_largest_mps", "roller_torque_largest_nm",
                     "ripple_nm", "distance_relative", "dump_cycles", "air_litres")  # fmt: skip


@dataclass(frozen=True)
class Found:
    """Results of the references and of the families, courses over time by label, and the points of the loop."""

    references: list[Result]
    results: list[Result]
    courses: dict[str, xr.Dataset]
    loop: list[dict[str, float]]


@dataclass(frozen=True)
class ControlStudy(Study[Found]):
    """One test under many variants of the controller.

    Attributes:
        case: of `study_case`.
        families: names of FAMILIES; none: all.
        user: 'file.py:Class' of a controller to be compared with the built-in one.
        loop: also find where the loop becomes unstable, computed and measured.
    """

    case: Case
    families: tuple[str, ...] = ()
    user: str | None = None
    loop: bool = True

    command = "control"
    quantities = QUANTITIES
    irrelevant = ("description", "families", "loop")
    round_ends = (0.98, 1.0)

    def __post_init__(self) -> None:
        """Refuse an unknown family, and a user's controller that cannot be used.

        Raises:
            ConfigError: it is.
        """
        known = [family.name for family in FAMILIES]
        problems = []
        for name in (name for name in self.families if name not in known):
            guess = nearest(name, tuple(known))
            allowed = f"allowed: {', '.join(known)}" + (f"; did you mean {guess!r}?" if guess else "")
            problems.append(ConfigProblem(self.case.name, "families", repr(name), allowed))
        if problems:
            raise ConfigError(problems)
        if self.user is not None:
            users_controllers(self.case.with_changes({"rig_control.user": self.user}), {})

    @property
    def title(self) -> str:
        return f"{self.case.name}: controllers of the roller drives compared"

    def limitations(self) -> list[str]:
        return [
            *super().limitations(),
            "One test and one course of the slide protection, whose valves switch on small differences: errors of neighbouring "
            "values scatter by some tenths. Each variant changes one thing.",
        ]

    # ------------------------------------------------------------------------------------------------------ jobs

    @cached_property
    def chosen(self) -> list[Family]:
        """The families that are run."""
        known = {family.name: family for family in FAMILIES}
        return [known[name] for name in dict.fromkeys(self.families or known)]

    @cached_property
    def variants(self) -> dict[tuple[str, str, float], Case]:
        """Family, curve and value of each variant -> its case; those of 'references' have no value."""
        own: dict[str, Any] = {USER: {"rig_control.user": self.user}} if self.user else {}
        references = {("references", label, math.nan): changes for label, changes in (REFERENCES | own).items()}
        varied = {
            (family.name, label, float(value)): family.changes(self.case, curve, value)
            for family in self.chosen
            for label, curve in (dict(family.curves) | (own if family.user else {})).items()
            for value in family.values
        }
        return {key: self.case.with_changes(changes) for key, changes in (references | varied).items()}

    def rounds(self, done: Done) -> Iterator[Round]:
        jobs = {_name(key): job(run_variant, case, key[0] == "references") for key, case in self.variants.items()}
        yield {**jobs, **(loop_jobs(self.case) if self.loop else {})}
        yield {f"course of {_name(key)}": job(run_variant, self.variants[key], True) for key in self._worst(done)}

    def _worst(self, done: Done) -> list[tuple[str, str, float]]:
        """The worst variant of each cause whose test came to its end."""
        results = self._results(done)[1]
        worst = (max((r for r in results if r.cause == cause), key=lambda r: r.severity, default=None)
                 for cause in ("tracking", "ripple"))  # fmt: skip
        return [(r.family, r.curve, r.value) for r in worst if r is not None]

    def _results(self, done: Done) -> tuple[list[Result], list[Result]]:
        found = [Result(*key, done[_name(key)]["numbers"]) for key in self.variants if _name(key) in done]
        return [r for r in found if r.family == "references"], [r for r in found if r.family != "references"]

    def collect(self, done: Done) -> Found | None:
        references, results = self._results(done)
        if not references or references[0].curve != next(iter(REFERENCES)):
            return None
        base = done[_name(("references", references[0].curve, math.nan))]["course"].isel(time=slice(None, None, 50))
        references, results = (
            [replace(r, numbers=_against(r.numbers, base)) for r in rs] for rs in (references, results)
        )
        courses = {references[0].curve: done[_name(("references", references[0].curve, math.nan))]["course"]}
        for key in self._worst(done):
            family = next(f for f in FAMILIES if f.name == key[0])
            if f"course of {_name(key)}" in done:
                label = f"{family.name.replace('_', ' ')},\n{key[1]}: {family.text(key[2])}"
                courses[label] = done[f"course of {_name(key)}"]["course"]
        return Found(
            references,
            results,
            courses,
            sorted((done[n] for n in done if n.startswith("gains times ")), key=lambda point: point["factor"]),
        )

    # --------------------------------------------------------------------------------------------------- numbers

    def numbers(self, results: Found) -> dict[str, Any]:
        return {
            "case": self.case.name,
            "duration_s": self.case.time.duration,
            "limits": {"tracking_rms": TRACKING_LIMIT, "ripple_nm": RIPPLE_LIMIT},
            "references": {r.curve: r.numbers for r in results.references},
            "results": [
                {"family": r.family, "curve": r.curve, "value": r.value, "cause": r.cause, **r.numbers}
                for r in results.results
            ],
            "ranking": [_rank_numbers(rank) for rank in self._ranking(results)],
            "loop": loop_numbers(self.case, results.loop) if results.loop else None,
        }

    def _ranking(self, results: Found) -> list[Rank]:
        return ranking(self.case, self.chosen, results.results)

    def summary(self, results: Found, numbers: Numbers) -> list[str]:
        lines = [
            f"As shipped the wheels follow the virtual train within {100 * results.references[0].numbers['tracking_rms']:.2g} % "
            f"RMS of its speed. A variant fails above {100 * TRACKING_LIMIT:g} %, with a persistent torque ripple above "
            f"{RIPPLE_LIMIT:g} N m RMS, or where the test ends early."
        ]
        failing: dict[str, list[Rank]] = {}
        for rank in (rank for rank in self._ranking(results) if rank.thresholds):
            failing.setdefault(rank.family.name, []).append(rank)
        lines.append("Failure thresholds, worst first:" if failing else "No variant failed within the ranges run.")
        return lines + [f"– {self._sentence(ranks)}" for ranks in failing.values()]

    def _sentence(self, ranks: Sequence[Rank]) -> str:
        """Where the curves of one family fail."""
        family = ranks[0].family
        base = f" (shipped: {family.text(family.base(self.case))})" if family.base is not None else ""
        return f"{family.title}{base} – {'; '.join(f'{rank.curve}: {_thresholds_text(rank)}' for rank in ranks)}."

    def files(self, results: Found, numbers: Numbers) -> Mapping[str, Any]:
        names = ("family", "curve", "value", "cause", *(q.key for q in RUN))
        rows = [{"family": r.family, "curve": r.curve, "value": r.value, "cause": r.cause, **r.numbers}
                for r in (*results.references, *results.results)]  # fmt: skip
        loop = {"loop.csv": [list(results.loop[0]), *(list(p.values()) for p in results.loop)]} if results.loop else {}
        return {"variants.csv": QUANTITIES.csv(rows, names), **loop}

    def sections(self, results: Found, numbers: Numbers) -> list[Section]:
        ranked = self._ranking(results)
        references = {r.curve: r.numbers for r in results.references}
        courses = figures.courses(results.courses, self.case.vehicle.data.wheel.radius)
        caption = "Leading axle over time: the case as shipped, and the worst runs of each kind that came to their end."
        sections = [
            Section("Failure thresholds", [self._range_chart(ranked, results), self._ranking_table(ranked)]),
            Section("Where the error comes from", [
                QUANTITIES.table(references, REFERENCE_COLUMNS, "the case, and where its error comes from", "run"),
                Picture("courses", courses, caption)]),
        ]  # fmt: skip
        if numbers["loop"] is not None:
            sections.append(Section("Stability of the loop", loop_blocks(numbers["loop"], results.loop)))
        return sections + [
            Section(f.title, [self._family_picture(f, results)])
            for f in self.chosen
            if any(r.family == f.name for r in results.results)
        ]

    def _range_chart(self, ranked: Sequence[Rank], results: Found) -> Picture:
        bars = []
        for rank in ranked:
            points = [p.numbers for p in rank.points if p.completed] or [rank.worst.numbers]
            error = [max(100.0 * n["tracking_rms"], 1e-4) for n in points]
            ripple = [max(n["ripple_nm"], 0.1) for n in points if math.isfinite(n["ripple_nm"])] or [math.nan]
            label = f"{rank.family.name.replace('_', ' ')}, {rank.curve}"
            bars.append(
                figures.Bar(label, (min(error), max(error)), (min(ripple), max(ripple)), not rank.worst.completed)
            )
        base = results.references[0].numbers
        picture = figures.ranges(
            bars, (100.0 * base["tracking_rms"], base["ripple_nm"]), (100.0 * TRACKING_LIMIT, RIPPLE_LIMIT)
        )
        caption = "Range of the errors along each axis, the worst on top. Dashed: failure limit; red: above it; dotted: shipped."
        return Picture("ranges", picture, caption)

    def _ranking_table(self, ranked: Sequence[Rank]) -> Table:
        rows = []
        for rank in ranked:
            worst, family = rank.worst, rank.family
            shipped = family.text(family.base(self.case)) if family.base is not None else "–"
            cells = [QUANTITIES[name].cell(worst.numbers[name]) for name in ("tracking_rms", "ripple_nm")]
            error = cells[0] if worst.completed else "ended early"
            fails = _thresholds_text(rank) or "no failure"
            rows.append([family.title, rank.curve, fails, shipped, family.text(worst.value), error, cells[1]])
        header = ("varied", "curve", "failure threshold", "shipped", "worst at", "tracking RMS [%]", "ripple [N m]")
        return Table(header, rows, "every curve, the worst first")

    def _family_picture(self, family: Family, results: Found) -> Picture:
        curves = []
        for label in dict.fromkeys(r.curve for r in results.results if r.family == family.name):
            points = sorted(
                (r for r in results.results if (r.family, r.curve) == (family.name, label)), key=lambda r: r.value
            )
            values = {key: [p.numbers[key] for p in points] for key in ("tracking_rms", "ripple_nm")}
            tracking_percent = [100.0 * value for value in values["tracking_rms"]]
            ended = [not p.completed for p in points]
            curves.append(figures.Curve(label, [p.value for p in points], tracking_percent, values["ripple_nm"], ended))
        base = family.base(self.case) if family.base is not None else None
        limits = (100.0 * TRACKING_LIMIT, RIPPLE_LIMIT)
        picture = figures.over_parameter(curves, family.axis, family.scale, base, limits)
        return Picture(family.name, picture, f"{family.title}. Dashed: failure limit; dotted: the case as shipped.")


# ------------------------------------------------------------------------------------------------------------- cases


def study_case(case: Case, duration: float | None) -> Case:
    """The case as it is compared: shortened, and recorded finely enough to see ripple.

    Raises:
        ConfigError: it has no rig controller, or nothing that it could follow.
    """

    def missing(key: str, value: str, needed: str) -> ConfigError:
        return ConfigError([ConfigProblem(case.name, key, value, f"needed: {needed}")])

    if not isinstance(case.support.data, Rig) or case.rig_control is None:
        raise missing("rig_control", "missing", "a case on rollers with [rig_control], the controller to be compared")
    if case.rig_control.user is not None:
        needed = "the built-in controller in the case; give your own with --controller, beside it"
        raise missing("rig_control.user", repr(case.rig_control.user), needed)
    if case.brake is None and case.traction is None:
        raise missing("brake", "missing", "[brake] or [traction], the test that the controllers are compared in")
    length = case.time.duration if duration is None else min(duration, case.time.duration)
    return case.with_changes({"time.duration": length, "time.output_step": max(OUTPUT_STEP, case.time.sampling_step)})


# -------------------------------------------------------------------------------------------------------------- jobs


def _name(key: tuple[str, str, float]) -> str:
    """Of a variant's job."""
    return ", ".join(map(str, key[:2] if math.isnan(key[2]) else key))


def run_variant(case: Case, with_course: bool, progress: Progress | None = None) -> dict[str, Any]:
    """One run: its `numbers`, and where wanted its `course` over time."""
    run = whole_run(case, progress)
    return {"numbers": run_numbers(run), "course": run[KEPT].load() if with_course else None}


def run_numbers(run: xr.Dataset) -> dict[str, Any]:
    """The numbers of one run by name of RUN; as `distance_relative`, time and distance of the last instant compared."""
    error, largest_error = tracking(run)
    ripple, frequency = torque_ripple(run["time"].to_numpy(), run["roller_torque"].to_numpy())
    last, compared = run.isel(time=-1), run.isel(time=slice(None, None, 50)).isel(time=-1)
    return {
        "status": run.attrs["status"],
        "ended_s": float(run.attrs["stopped_at_s"]),
        "tracking_rms": error,
        "tracking_largest": largest_error,
        "largest_slip": largest(slip(run)),
        "real_sliding_rms_mps": rms(run["real_sliding"]),
        "real_sliding_largest_mps": float(np.abs(run["real_sliding"]).max()),
        "roller_torque_largest_nm": float(np.abs(run["roller_torque"]).max()),
        "distance_m": float(last["train_distance"]),
        "distance_relative": [float(compared["time"]), float(compared["train_distance"])],
        "dump_cycles": int(last["dump_cycles"].sum()),
        "air_litres": 1e3 * float(last["air"].sum()),
        "ripple_nm": ripple,
        "ripple_hz": frequency,
    }


def _against(numbers: Mapping[str, Any], base: xr.Dataset) -> dict[str, Any]:
    """With the distance over that of the base at the same time, less 1."""
    time, distance = numbers["distance_relative"]
    shipped = float(np.interp(time, base["time"], base["train_distance"]))
    return {**numbers, "distance_relative": distance / shipped - 1.0 if shipped > 0.0 else None}


# -------------------------------------------------------------------------------------------------------------- texts


def _rank_numbers(rank: Rank) -> dict[str, Any]:
    return {
        "family": rank.family.name,
        "curve": rank.curve,
        "worst_value": rank.worst.value,
        "worst_tracking_rms": rank.worst.numbers["tracking_rms"],
        "worst_ripple_nm": rank.worst.numbers["ripple_nm"],
        "thresholds": [vars(threshold) for threshold in rank.thresholds],
    }


def _thresholds_text(rank: Rank) -> str:
    return " and ".join(_threshold_text(rank, threshold) for threshold in rank.thresholds)


def _threshold_text(rank: Rank, threshold: Threshold) -> str:
    family, known = rank.family, {"tracking": "tracking error above its limit", "ripple": "persistent torque ripple"}
    cause = known.get(threshold.cause, f"{threshold.cause.replace('_', ' ')}, test ends early,")
    if math.isnan(threshold.last_good):
        return f"{cause} throughout, {family.text(rank.points[0].value)} to {family.text(rank.points[-1].value)}"
    if threshold.cause in known:
        return f"{cause} {'below' if threshold.value < threshold.last_good else 'above'} {family.text(threshold.value)}"
    return f"{cause} between {family.text(threshold.last_good)} and {family.text(threshold.value)}"
