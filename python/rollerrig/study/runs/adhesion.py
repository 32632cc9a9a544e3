"""What is run and assessed in the adhesion study: the track that a rig reproduces, the rig without some of its imperfections.

Case of a rig with [rig_control] -> [track_case, variant] -> ensembles of TestRecords
    -> [cause_shares] -> shares of the distance that go away with each imperfection; they add up to the whole
    -> [assessment_rows] -> rows: value with interval, target and where it comes from, outcome

A row is met where the whole interval of its value, of many starts, is within its target, and not met where nothing of it is.
A row says nothing, and is left out, only where no test has its number or all have zero; zero against not zero is not met, a
number that some tests lack is not decided. Nothing is met by a bad run: a run that ended early, also with finer steps, an open
energy balance, lost contact, starts that do not differ, axles that hardly passed the peak of the creep curve, drives that
oscillate or are at their limit, and a contact force away from the virtual one leave every agreement undecided, since it is then
no property of the rig.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from rollerrig.analysis.slide_statistics import OSCILLATES, TestRecord
from rollerrig.cases import on_track, rig_of
from rollerrig.config import Case, ConfigError
from rollerrig.config.schema.rig_control import EstimatedTorque, ExactEstimator, LeadCommand
from rollerrig.results import summary
from rollerrig.results.quantities import Quantity
from rollerrig.simulation.run import ENERGY_WARNING
from rollerrig.study.assessment import NOT_DECIDED, SHOWN, Outcome, outcome, overall
from rollerrig.study.ensemble import SEED, Estimate, difference, distances, measure, relative, stepped, values_of

STARTS = 8  # tests of an ensemble whose scatter is known well enough to tell how many would decide
STEPS = ("rolling", "drives", "estimator")
VARIANTS = {
    "rig": "the rig as it is",
    "rolling": "pure rolling of its wheels on the rollers",
    "drives": "and roller drives without lag and torque limit",
    "estimator": "and force and torque of the axles known exactly",
    "static_loads": "the rig as it is, its virtual train without load transfer",
}
FAST_MOTOR_HZ, NO_LIMIT = 400.0, 1e7  # more is not to be had with samples of 1 ms; [N m]


def track_case(case: Case) -> Case:
    """The same test on straight track with the rig's rail head, what the rig is to reproduce; ConfigError: there is none."""
    rig_of(case)
    if case.brake is None and case.traction is None:
        needed = "needed: [brake] or [traction], the test that is done on rail and rig"
        raise ConfigError.of(case.name, "brake", "missing", needed)
    return on_track(case).model_copy(update={"name": f"{case.name}_track"})


def variants_of(case: Case) -> tuple[str, ...]:
    """Names of the variants that say something about this case."""
    return (*STEPS, "static_loads") if rig_of(case)[1].load_transfer != "none" else STEPS


def variant(case: Case, name: str) -> Case:
    """The rig without some of its imperfections; see VARIANTS."""
    control = rig_of(case)[1]
    if name == "static_loads":
        return case.model_copy(update={"rig_control": control.model_copy(update={"load_transfer": "none"})})
    taken = STEPS[: STEPS.index(name) + 1]
    changes: dict[str, Any] = {}
    if "drives" in taken:
        fast = {"bandwidth": FAST_MOTOR_HZ, "damping_ratio": 0.0, "envelope": None}
        changes["motor"] = control.motor.model_copy(update=fast)
        changes["drive_command"] = LeadCommand()
        changes["feedback"] = control.feedback.model_copy(update={"largest": NO_LIMIT})
    if "estimator" in taken:
        changes["estimator"] = ExactEstimator(kind="exact", torque=control.estimator.torque)
        changes["axle_torque"] = EstimatedTorque(kind="estimated")
    contact = case.contact.model_copy(update={"pure_rolling": True})
    return case.model_copy(update={"rig_control": control.model_copy(update=changes), "contact": contact})


TOGETHER = "together"
CAUSES = {
    "rolling": "sliding of the wheels on the rollers",
    "drives": "lag and torque limit of the roller drives",
    "estimator": "lag of the estimated torque",
    "model": "simplifications of the virtual train, and sampling",
}
PAIRS = {**dict(zip(CAUSES, pairwise(("rig", *STEPS, "track")), strict=True)), TOGETHER: ("rig", "track")}
"""Ensembles whose difference in distance is the share of a cause."""
LARGEST_ERROR = 5e-4
"""More starts of both are made until the standard error of a share is below this part of the distance."""


def cause_shares(records: Mapping[str, Sequence[TestRecord]]) -> dict[str, Estimate] | None:
    """Parts of (mean distance of the rig over that of the track, less 1) by cause, and `together` the whole.

    Each over the starts that both of its PAIRS have: they add up to the whole, within their errors where some have more.
    None where an ensemble is missing, of `track`, `rig` and each of STEPS.
    """
    names = ("rig", *STEPS, "track")
    if any(not records.get(name) for name in names):
        return None
    found = dict(zip(names, distances([records[name] for name in names]), strict=True))
    on_track = float(np.mean(found["track"]))
    return {name: difference(found[a], found[b]).times(1.0 / on_track) for name, (a, b) in PAIRS.items()}


def is_within_error(share: Estimate) -> bool:
    """Whether nothing is known of a share, not even its sign."""
    interval = share.interval
    return interval.low <= 0.0 <= interval.high


def to_refine(shares: Mapping[str, Estimate] | None) -> list[tuple[str, str]]:
    """Pairs of ensembles whose share has too large a standard error; the others need no more starts."""
    return [PAIRS[name] for name, share in (shares or {}).items() if not share.standard_error < LARGEST_ERROR]


Group = Literal["tracking", "fidelity"]
GROUPS: Mapping[Group, str] = {
    "tracking": "Tracking, wheels of the rig against their virtual axles",
    "fidelity": "Fidelity, rig against track",
}
RESAMPLES = 400  # resamples of the starts, for the scatter of the difference of two distributions


@dataclass(frozen=True)
class Row:
    """One row of the assessment."""

    group: Group
    key: str  # its name in summary.json
    text: str  # what is compared
    value: Estimate  # of many starts, in SI units
    # low, high: target; low = 0: of a size, at most `high`
    low: float
    high: float
    origin: str  # where the target comes from
    # unit, factor: in which it is shown
    unit: str = "%"
    factor: float = 100.0
    gate: bool = False  # whether nothing is met where this is not
    undecided: bool = False  # whether it is not decided in place of not met: what it lacks is no fault of the rig
    shown: str = ""  # the value in words, where it is no number
    bad_run: bool = False  # whether an agreement is left undecided because the run is bad

    @property
    def outcome(self) -> Outcome:
        """A size is never below 0, its interval may be, where starts differ by more than their mean."""
        found = outcome(self.value.interval, self.low or -math.inf, self.high, excluded=self.bad_run)
        return NOT_DECIDED if self.undecided and found == "not met" else found

    @property
    def starts_needed(self) -> float:
        """Number of starts that decide it, if mean and scatter stay; inf: more than MANY, or none does."""
        mean, ends = self.value.mean, (self.low or -math.inf, self.high)
        if self.undecided or (self.bad_run and ends[0] <= mean <= ends[1]):
            return math.inf
        return self.value.tests_within(min(abs(mean - end) for end in ends))

    @property
    def value_text(self) -> str:
        """Mean and interval."""
        if self.shown or math.isinf(self.value.mean):
            return self.shown or "not zero, against zero"
        if math.isnan(self.value.mean):
            return "no number in some tests"
        found = self.value.as_dict() | ({} if self.low else {"low": max(0.0, self.value.interval.low)})
        return self._shown.told(found)

    @property
    def target_text(self) -> str:
        """The target."""
        if self.shown:
            return "all"
        return f"{'within' if self.low == -self.high else 'at most'} {self._shown.told(self.high)}"

    @property
    def _shown(self) -> Quantity:
        return Quantity("", "", self.unit, digits=2, shown=(self.unit, self.factor))

    @property
    def told(self) -> str:
        """Outcome, value and target in words, and how many starts would decide it, where its scatter is known well enough."""
        decidable = self.outcome == NOT_DECIDED and self.value.freedom >= STARTS - 1
        count = self.starts_needed if decidable else math.inf
        more = f" (about {count:g} starts would decide, if mean and scatter stay)" if count < math.inf else ""
        return f"{SHOWN[self.outcome]}: {self.finding}{more}"

    @property
    def finding(self) -> str:
        """Value and target in words."""
        return f"{self.text} {self.value_text}, target {self.target_text}"

    def as_dict(self) -> dict[str, Any]:
        """Dictionary for summary.json."""
        found = {"group": self.group, "outcome": self.outcome, "value": self.value.mean, **vars(self.value.interval)}
        return found | {"target_low": self.low, "target_high": self.high, "target_from": self.origin}


Tests = tuple[Sequence[TestRecord], Sequence[TestRecord]]
"""Records of track and rig, from the same starts."""


def assessment_rows(case: Case, tests: Tests, fine: Tests = ((), ())) -> list[Row]:
    """All rows that say something about the tests of a rig's case.

    `fine` are the first of them again with finer steps and samples; without, that part of the intervals is missing.
    """
    rows = _rows(case, tests)
    count = min(len(one) for one in (*tests, *fine))
    if count:
        coarse, close = ({row.key: row.value for row in _rows(case, (a[:count], b[:count]))} for a, b in (tests, fine))
        rows = [
            row if row.shown else replace(row, value=stepped(row.value, coarse.get(row.key), close.get(row.key)))
            for row in rows
        ]
        whole = [is_whole(one) for one in (*fine[0], *fine[1])]
        why = "what steps change is known of whole and sound tests alone"
        text = "tests with finer steps, on both, that came to their end, closed their energy balance and kept contact"
        rows.append(_all_of("fidelity", "fine_sound", text, whole, why, undecided=True))
    return [row if row.shown else replace(row, bad_run=_is_bad(rows, row.group)) for row in rows]


def _rows(case: Case, tests: Tests) -> list[Row]:
    return [*_gates(*tests), *_tracking(case, tests[1]), *_fidelity(case, *tests)]


def _is_bad(rows: Sequence[Row], group: Group) -> bool:
    """Whether a gate is not known to be met: all of them for fidelity; for tracking that the runs came to their end."""
    asked = [row for row in rows if row.gate and (group == "fidelity" or row.shown or row.undecided)]
    return any(row.outcome != "met" for row in asked)


def outcome_of(rows: Sequence[Row], group: Group) -> Outcome:
    """Outcome of a group: met where all its rows are, not met where one is not, else not decided."""
    return overall(row.outcome for row in rows if row.group == group) or NOT_DECIDED


def _all_of(group: Group, key: str, text: str, met: Sequence[bool], origin: str, **more: Any) -> Row:
    """A gate that is met where all of these are."""
    share, shown = Estimate(sum(met) / len(met), 0.0, math.inf), f"{sum(met)} of {len(met)}"
    return Row(group, key, text, share, 1.0, 1.0, origin, shown=shown, gate=True, **more)


LEAST_SLIDE = 1.0
"""Time of all axles together beyond the peak of the creep curve [s]: some three cycles of slide and readhesion; less may be the
swing of a bogie, and tests nothing that acts on slides."""


def keeps_contact(test: TestRecord) -> bool:
    """Whether no wheel of a test left its rail or roller."""
    names = ("contact_lost_s", "contact_lost_total_s", "duration_s")
    return summary.keeps_contact(*(test.measures.get(name, math.nan) for name in names))


GATES: Mapping[str, tuple[str, str, Callable[[TestRecord, Sequence[TestRecord]], bool]]] = {
    "ended": ("came to their end", "a test that ended early is none", lambda one, _: one.completed),
    "closed": ("closed their energy balance", "energy from nowhere makes no test",
               lambda one, _: one.measures.get("energy_relative_residual", math.nan) <= ENERGY_WARNING),
    "contact": ("kept contact", "a wheel that leaves its rail or roller makes no test", lambda one, _: keeps_contact(one)),
    "differ": ("differ", "equal starts are one test, however many are made: their scatter of zero says nothing",
               lambda _, tests: len({one.measures.get("distance_m") for one in tests}) == len(tests)),
    "slid": (f"had axles beyond the peak of the creep curve for {LEAST_SLIDE:g} s in all",
             "where nothing slides nothing is tested", lambda one, _: one.measures.get("beyond_peak_s", math.nan) >= LEAST_SLIDE),
}  # fmt: skip
"""What no bad run has: what its tests did, why that is asked for, whether one of these tests did it."""


def is_whole(test: TestRecord) -> bool:
    """Whether a test came to its end, closed its energy balance and kept contact."""
    return all(GATES[key][2](test, (test,)) for key in ("ended", "closed", "contact"))


def _gates(track: Sequence[TestRecord], rig: Sequence[TestRecord]) -> Iterator[Row]:
    """Whether the tests pass GATES, and stop on both supports or on neither."""
    tests: Mapping[Group, tuple[str, Sequence[TestRecord]]] = {"tracking": ("rig", rig), "fidelity": ("track", track)}
    for group, (label, records) in tests.items():
        for key, (text, why, has) in GATES.items():
            met = [has(one, records) for one in records]
            yield _all_of(
                group, f"{label}_{key}", f"tests on the {label} that {text}", met, why, undecided=key != "ended"
            )
    ends = [a.stopped == b.stopped for a, b in zip(track, rig, strict=False) if a.completed and b.completed]
    if not all(ends):
        text, why = "starts with a stop on both, or on neither", "a stopping distance needs a stop"
        yield replace(_all_of("fidelity", "stops", text, ends, why), value=Estimate(0.0, 0.0, math.inf))


def _tracking(case: Case, rig: Sequence[TestRecord]) -> Iterator[Row]:
    gate: dict[str, Any] = {"gate": True}
    rows: tuple[tuple[str, str, float, str, dict[str, Any]], ...] = (
        ("tracking_rms", "wheel less virtual wheel, RMS over train speed", 0.01,
         "ours: a sixth or less of the slip at which slide protection acts", {}),
        ("tracking_largest", "wheel less virtual wheel, largest over train speed", *_fill_slip(case), {}),
        ("force_error_rms", "contact force less virtual force, RMS over RMS", 0.05,
         "ours: the force that stops the train is the virtual one", gate),
        ("drive_oscillation_nm", "fast torque that the virtual rail does not demand, RMS, not passed for 95 % of the time",
         OSCILLATES, "ours: 1 % of the torque that brakes an axle; an oscillating loop gives thousands",
         {**gate, "unit": "N m", "factor": 1.0}),
        ("drive_oscillation_spell_s",
         f"longest spell of fast torque above {OSCILLATES:g} N m that the virtual rail does not demand", 1.0,
         "ours: the response to a switched valve lasts for a window or two of 0.25 s", {**gate, "unit": "s", "factor": 1.0}),
        ("drive_limited_share", "time with a drive's command at its limit", 0.01,
         "ours: a drive at its limit does not reproduce the rail", gate),
        ("crown_gravity_largest", "gravity on the rollers' crown over axle load, largest", 0.02,
         "ours: a quarter of the friction of low adhesion", {}),
    )  # fmt: skip
    for key, text, high, origin, more in rows:
        yield Row("tracking", key, text, measure(rig, key), 0.0, high, origin, **more)


def _fill_slip(case: Case) -> tuple[float, str]:
    """Slip at which this test's protection changes what it does, and where that stands."""
    if case.slide_protection is not None and case.brake is not None:
        return (
            case.slide_protection.fill_slip,
            "the slip at which cylinders are filled again: a larger error decides what the valves do",
        )
    if case.wheel_slip_control is not None:
        return case.wheel_slip_control.slip, "wheel_slip_control.slip: a larger error decides what it does"
    return 0.05, "ours: no protection acts in this test"


def _fidelity(case: Case, track: Sequence[TestRecord], rig: Sequence[TestRecord]) -> Iterator[Row]:
    both = (rig, track)
    stops = all(record.stopped for record in (*track, *rig))
    way = "deceleration" if case.brake is not None else "acceleration"
    changes = (
        ("distance", "stopping distance" if stops else "distance after the same time", 0.02,
         "ours: what an overestimated adhesion of 2 % does"),
        ("mean_deceleration_mps2", f"mean {way} since the demand", 0.02, "ours: as the distance"),
        ("dump_cycles", "dump cycles, all axles under test", 0.05,
         "ours: wear of the valves, and the first thing a supplier counts"),
        ("air_litres", "air taken by the cylinders", 0.05, "ours: size of the reservoir"),
        ("adhesion_at_readhesion", "largest force on an axle that has slid (readhesion)", 0.10, "ours: load on the drive line"),
    )  # fmt: skip
    for key, text, reach, origin in changes:
        pair = distances(both) if key == "distance" else [values_of(one, key) for one in both]
        values = np.concatenate(pair)
        if not (np.isnan(values).all() or (values == 0.0).all()):
            yield Row("fidelity", key, text, relative(*pair), -reach, reach, origin)
    slips, lock = slip_difference(track, rig), difference(*(values_of(one, "longest_lock_s") for one in both))
    what, why = "shares of time up to each slip, largest difference", "ours: 5 % of the time at another slip"
    yield Row("fidelity", "slip_distribution", what, slips, 0.0, 0.05, why)
    what, why = "longest lock of a wheel", "ours: a flat grows with the length slid while locked"
    yield Row("fidelity", "longest_lock_s", what, lock, -0.1, 0.1, why, unit="s", factor=1.0)


def slip_difference(track: Sequence[TestRecord], rig: Sequence[TestRecord]) -> Estimate:
    """Largest difference between the summed frequencies of |slip| of both ensembles [-], its error by resampling the starts."""
    sums = [np.cumsum([record.slip_shares for record in records], axis=1) for records in (track, rig)]
    if any(not (one[:, -1] > 0.5).all() for one in sums):
        return Estimate(math.nan, math.nan, 0.0)
    largest = float(np.abs(sums[1].mean(axis=0) - sums[0].mean(axis=0)).max())
    generator = np.random.default_rng(SEED)
    count = min(len(track), len(rig))
    drawn = generator.integers(0, count, (RESAMPLES, count))  # of starts that both have
    pairs = sums[1][:count] - sums[0][:count]
    scatter = float(np.std(np.abs(pairs[drawn].mean(axis=1)).max(axis=1), ddof=1))
    return Estimate(largest, scatter if count > 1 else math.nan, count - 1.0)
