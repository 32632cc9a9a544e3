"""A sweep: many cases that differ in a few keys, and some numbers of each.

WholePlan -> a job per case -> [SweepStudy] -> Dataset over what is varied; quantiles, tornado, Sobol indices, report
"""

from __future__ import annotations

import math
import pickle
import tomllib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import islice
from pathlib import Path
from typing import Any

import xarray as xr

from rollerrig.cases import as_case
from rollerrig.common.formatting import number
from rollerrig.config import Case, ConfigError, ConfigProblem, Plan, WholePlan, plan_of_case
from rollerrig.config.errors import nearest, one_of, show_value
from rollerrig.config.validate.messages import validate
from rollerrig.plot import sweep as figures
from rollerrig.study.cluster import cluster
from rollerrig.study.frame import Study, dataset_rows
from rollerrig.study.jobs import Done, Job, Progress, Round
from rollerrig.study.measures import MEASURES, measured, quantities
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Block, Picture, Section, Table, Text
from rollerrig.study.runs import sweep as runs
from rollerrig.study.runs.sweep import FAILED, Points, Record, statistics

MOST_PICTURED = 12
"""Numbers that have pictures of their own; all are in the tables and files."""

MOST_UNASKED = 100_000
"""More cases than that are probably a slip of the pen."""

MOST = 1_000_000
"""Their records take some 4 GB of memory, and 400 MB of jobs.jsonl: well below what is read of one."""

Compute = Callable[[Case], Mapping[str, float]]
"""A measure of the user's own: a case -> numbers by name."""


@dataclass(frozen=True)
class SweepStudy(Study[xr.Dataset]):
    """All cases of a plan; more than MOST_UNASKED only if `many` says so.

    `compute` is a measure of the user's own, beside or in place of those of the plan.
    """

    whole: WholePlan
    many: bool = False
    compute: Compute | None = None
    _seen: dict[str, float] = field(default_factory=dict, compare=False, repr=False)

    command = "sweep"
    writes = ("sweep.nc", "sweep.csv", "plan.toml")
    keeps_jobs = True
    irrelevant = ("description", "plan.name", "plan.description")

    def __post_init__(self) -> None:
        """Refuse with a ConfigError values that do not fit their key, numbers that no measure has, too many cases."""
        count, file = runs.number_of_cases(self.whole.plan), self.whole.file
        allowed = f"allowed: up to {MOST} cases, which are held in memory; several plans can share the work"
        if count > MOST_UNASKED and not self.many:
            allowed = f"allowed: up to {MOST_UNASKED} cases; more with --yes (many=True)"
        if count > (MOST if self.many else MOST_UNASKED):
            raise ConfigError.of(file, "design", f"{count} cases", allowed)
        if problems := self._check_kept():
            raise ConfigError(problems)

    def _check_kept(self) -> list[ConfigProblem]:
        problems, seen = [], [axis.name for axis in self.points.axes]
        for index, measure in enumerate(self.whole.plan.measure):
            known = quantities(measure.kind)
            for place, name in enumerate(measure.keep or known):
                at = f"measure[{index}].keep" + (f"[{place}]" if measure.keep else "")
                if name not in known:
                    allowed, near = one_of(known), nearest(name, tuple(known))
                    problems.append(ConfigProblem(self.whole.file, at, show_value(name), allowed, near))
                elif name in seen:
                    allowed = "allowed: each name once; keep others, or give the varied key another `name`"
                    problems.append(ConfigProblem(self.whole.file, at, show_value(name), allowed))
                seen.append(name)
        return problems

    @cached_property
    def points(self) -> Points:
        """All cases of the plan."""
        return Points(self.whole)

    @property
    def title(self) -> str:
        return f"Sweep {self.whole.plan.name}: {self.whole.plan.description or self.whole.case.name}"

    def described(self) -> list[str]:
        """What `rollerrig check` prints of the plan."""
        plan = self.whole.plan
        varied = ", ".join(f"{axis.name} ({axis.key})" for axis in self.points.axes)
        return [
            f"{plan.name}: {len(self.points)} cases of {self.whole.case.name}, design {plan.design.kind}",
            f"varied: {varied}",
            f"computed: {', '.join(measure.kind for measure in plan.measure)}",
        ]

    def cases(self) -> Mapping[str, Case]:
        return {self.whole.case.name: self.whole.case}

    def plan(self) -> dict[str, Any]:
        own = self.whole.plan.model_dump(mode="json", exclude_none=True)
        name = {} if self.compute is None else {"compute": f"{self.compute.__module__}:{self.compute.__qualname__}"}
        return {"plan": own, **name, "case": tomllib.loads(self.whole.case.to_toml())}

    def rounds(self, done: Done) -> Iterator[Round]:
        packed = pickle.dumps((self.whole.case, self.whole.plan.measure, self.compute))
        yield {_name(i): Job(run_case, (packed, changes), lost_case) for i, changes in enumerate(self.points.changes())}

    def progress_text(self, done: Done, seconds: float) -> str:
        count = len(done)
        taken_over = self._seen.setdefault("taken over", count)
        failed = self._failed(done)
        rate = f", {(count - taken_over) / seconds:.3g} per s" if seconds > 1.0 else ""
        return f"{count} of {len(self.points)} cases{rate}{f', {failed} failed' if failed else ''}"

    def _failed(self, done: Done) -> int:
        """Failed cases so far; only those that came since the last time are looked at."""
        seen = int(self._seen.get("seen", 0))
        new = islice(reversed(done.values()), max(len(done) - seen, 0))  # the last ones, however many there are before
        self._seen["failed"] = self._seen.get("failed", 0) + sum(1 for record in new if record[FAILED])
        self._seen["seen"] = max(seen, len(done))
        return int(self._seen["failed"])

    def collect(self, done: Done) -> xr.Dataset | None:
        records: list[Record | None] = [done.get(_name(i)) for i in range(len(self.points))]
        if not any(records):
            return None
        return runs.sweep_dataset(self.whole, self.points, records, self._units(records))

    def _units(self, records: list[Record | None]) -> dict[str, tuple[str, str]]:
        """Name of each kept number -> unit and meaning."""
        found: dict[str, tuple[str, str]] = {}
        for measure in self.whole.plan.measure:
            known = quantities(measure.kind)
            found |= {name: known[name] for name in measure.keep or known}
        for record in records:
            for name in (record or {}).get("numbers", {}):
                found.setdefault(name, ("", name.replace("_", " ")))
        return found

    def numbers(self, results: xr.Dataset) -> dict[str, Any]:
        return {
            "plan": self.whole.plan.name,
            "case": self.whole.case.name,
            "design": self.whole.plan.design.kind,
            **{name: results.attrs[name] for name in ("cases", "finished", "failed")},
            "failures": dict(Counter(filter(None, results[FAILED].to_numpy().ravel().tolist())).most_common()),
            "numbers": statistics(results, self.points),
        }

    def summary(self, results: xr.Dataset, numbers: Numbers) -> list[str]:
        lines = [f"{numbers['finished']} of {numbers['cases']} cases finished, {numbers['failed']} failed."]
        for name, one in numbers["numbers"].items():
            if one["least"] is not None:
                unit = "" if one["unit"] in ("1", "") else f" {one['unit']}"
                least, largest, median = (number(one[key]) for key in ("least", "largest", "median"))
                lines.append(f"{name.replace('_', ' ')}: {least} to {largest}{unit}, median {median}.")
                widest = max(one["tornado"], key=lambda key: _span(one["tornado"][key]), default=None)
                if widest is not None and math.isfinite(span := _span(one["tornado"][widest])) and span > 0.0:
                    lines[-1] += f" It follows {widest.replace('_', ' ')} most."
        return lines

    def files(self, results: xr.Dataset, numbers: Numbers) -> Mapping[str, Any]:
        return {"sweep.nc": results, "sweep.csv": sweep_rows(results)}

    def sections(self, results: xr.Dataset, numbers: Numbers) -> list[Section]:
        points, rows = self.points, list[list[object]]()
        for axis, column in zip(points.axes, points.columns, strict=True):
            ends = [min(column), max(column), len(axis.values) or ""] if axis.is_number else ["", "", len(axis.values)]
            rows.append([axis.name.replace("_", " "), axis.key, axis.unit if axis.unit != "1" else "", *ends])
        varied = Table(("varied", "key of the case", "unit", "from", "to", "values"), rows)
        seed = f", seed {points.design.seed}." if points.design.samples else "."
        how = f"Design: {points.design.kind.replace('_', ' ')}, {len(points)} cases{seed}"
        asked, caption = ("unit", "least", "median", "largest"), "Of all finished cases."
        overview = self.quantities.table(numbers["numbers"], asked, caption, "number")
        sections = [Section("Overview", [Text(how), varied, overview])]
        for place, (name, one) in enumerate(numbers["numbers"].items()):
            blocks = self._pictures(results, name, one) if place < MOST_PICTURED and one["least"] is not None else []
            meaning, title = results[name].attrs["long_name"], name.replace("_", " ").capitalize()
            said = Text(f"{meaning[:1].upper()}{meaning[1:]}.")
            sections.append(Section(title, [said, *blocks, *self._tables(one)]))
        if numbers["failures"]:
            reasons = Table(("reason", "cases"), [[reason, count] for reason, count in numbers["failures"].items()])
            note = Text("Each failed case is in sweep.csv with its reason.")
            sections.append(Section("Failed cases", [note, reasons]))
        return sections

    def _pictures(self, data: xr.Dataset, name: str, one: Numbers) -> list[Block]:
        """Pictures of one number."""
        title, design = name.replace("_", " "), self.points.design
        if design.kind == "grid":
            found: list[Block] = [Picture(f"map_{name}", figures.grid_map(data, name), f"{title} over what is varied.")]
        else:
            caption = f"{title} of each case over each varied key."
            found = [Picture(f"scatter_{name}", figures.scatter(data, name), caption)]
        known = {key: tuple(ends.values()) for key, ends in one["tornado"].items() if None not in ends.values()}
        if len(known) > 1:
            pairs = dict(sorted(known.items(), key=lambda item: -abs(item[1][1] - item[1][0])))
            unit = f" [{one['unit']}]" if one["unit"] not in ("", "1") else ""
            middle = float(data[name].mean())
            picture = figures.pair_bars(pairs, ("low end", "high end"), f"mean{unit}", middle=middle)
            what = "lowest and highest fifth of values" if design.samples else "lowest and highest value"
            found.append(Picture(f"tornado_{name}", picture, f"Mean of {title} at the {what} of each varied key."))
        if sobol := one.get("sobol"):
            pairs, errors = (
                {key: (own[f"first{end}"], own[f"total{end}"]) for key, own in sobol.items()}
                for end in ("", "_confidence")
            )
            picture = figures.pair_bars(pairs, ("first order", "total"), "part of the variance [-]", errors)
            found.append(Picture(f"sobol_{name}", picture, f"Sobol indices of {title}, intervals of 95 %."))
        return found

    def _tables(self, one: Numbers) -> list[Block]:
        """Tables of one number."""
        alike = (
            "Means of all finished cases with a word; the change from the first word is that of cases that are otherwise alike, "
            "with its interval of 95 %."
        )
        found: list[Block] = [
            self.quantities.table(words, "numbers.*.words.*.*", alike, key.replace("_", " "))
            for key, words in one.get("words", {}).items()
        ]
        for part, caption, head in (
            (
                "quantiles",
                "Intervals of 95 % as of independent samples; –: an end that so few do not have.",
                "of the samples are below",
            ),
            ("sobol", "Sobol indices; confidence: half of the interval of 95 %.", "varied"),
        ):
            if part in one:
                found.append(self.quantities.table(one[part], f"numbers.*.{part}.*", caption, head))
        return found


def sweep_rows(data: xr.Dataset) -> list[list[object]]:
    """A row per case, header first: values of the varied keys in SI, numbers, reason of failure."""
    units = {str(name): data[name].attrs["units"] for name in (*data.coords, *data.data_vars)}
    columns = {name if unit in ("", "1") else f"{name} [{unit}]": name for name, unit in units.items()}
    return dataset_rows(data, columns, *map(str, data[FAILED].dims))


def sweep_study(case: Case, vary: Mapping[str, Any], measure: Any, design: Any, *, many: bool = False) -> SweepStudy:
    """The study of `rollerrig.sweep`, whose arguments these are; a ConfigError has all mistakes found."""
    compute = measure if callable(measure) else None
    several = [] if compute else [measure] if isinstance(measure, str | Mapping) else list(measure)
    varied = [{"key": k, **(one if isinstance(one, Mapping) else {"values": _listed(one)})} for k, one in vary.items()]
    raw = {"name": "sweep", "case": case.name, "design": design, "vary": varied, "measure": several}
    plan, problems = validate(Plan, raw, "sweep")
    if plan is None:
        raise ConfigError(problems)
    if compute is None and not plan.measure:
        raise ConfigError.of("sweep", "measure", "missing", one_of(tuple(MEASURES)))
    return SweepStudy(plan_of_case(plan, case, "sweep"), many, compute)


def _listed(values: Any) -> list[Any]:
    """Values as TOML has them, also those of NumPy."""
    if hasattr(values, "tolist"):
        return list(values.tolist())
    return list(values) if isinstance(values, Iterable) and not isinstance(values, str) else [values]


def _span(ends: Mapping[str, float | None]) -> float:
    low, high = ends["low"], ends["high"]
    return -math.inf if low is None or high is None else abs(high - low)


def _name(number: int) -> str:
    return f"case {number}"


@lru_cache(maxsize=4)
def _unpacked(packed: bytes) -> tuple[Case, tuple[Any, ...], Compute | None]:
    """The case of a sweep, read once per worker; its profiles and whatever else the library keeps stay with it."""
    found: tuple[Case, tuple[Any, ...], Compute | None] = pickle.loads(packed)
    return found


def run_case(packed: bytes, changes: Mapping[str, Any], progress: Progress | None = None) -> Record:
    """The numbers of one case; whatever goes wrong with it is its reason, not the end of the sweep.

    Raises:
        KeyboardInterrupt: Ctrl-C.
    """
    case, measures, compute = _unpacked(packed)
    numbers: dict[str, float] = {}
    try:
        changed = case.with_changes(changes)
        for measure in measures:
            found = measured(changed, measure, progress)
            numbers |= {name: float(found[name]) for name in measure.keep or found}
        if compute is not None:
            numbers |= {str(name): float(value) for name, value in compute(changed).items()}
    except Exception as error:  # named with its reason
        reason = (str(error).splitlines() or [""])[0]
        return _failed(changes, f"{type(error).__name__}: {reason}".removeprefix("ConfigError: "))
    return {"changes": dict(changes), "numbers": numbers, FAILED: ""}


def lost_case(_packed: bytes, changes: Mapping[str, Any]) -> Record:
    """The record of a case that ended its process twice."""
    return _failed(changes, "its worker process ended in the middle, twice: killed, or out of memory")


def _failed(changes: Mapping[str, Any], reason: str) -> Record:
    return {"changes": dict(changes), "numbers": {}, FAILED: reason}


def sweep(
    case: Case | str,
    vary: Mapping[str, Any],
    *,
    measure: str | Mapping[str, Any] | Sequence[str | Mapping[str, Any]] | Callable[[Case], Mapping[str, float]],
    design: str | Mapping[str, Any] = "grid",
    folder: str | Path | None = None,
    many: bool = False,
    workers: int = 1,
    dask: str | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Numbers of many cases that differ in a few keys.

    Args:
        case: the case that is varied.
        vary: dotted key -> list of values, or a table as in a plan, such as `{"least": "0.5 m", "most": "1 m", "count": 11}`.
        measure: what is computed: a kind such as 'critical_speed', a table or several of them as in a plan, or a function of
            your own from a case to numbers by name; for more than one worker it stands on the top level of a module.
        design: how cases are chosen, as in a plan: 'grid', or a table such as `{"kind": "sobol", "samples": 64}`.
        folder: where finished cases are kept and looked for; None: nowhere.
        many: whether more than 100 000 cases are meant.
        workers: cases at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        dask: address of the scheduler of a dask cluster that does the work instead.
        progress: called with the fraction done and a short text.

    Returns:
        Dataset: the varied keys as coordinates in SI, each number with its unit, `failed` with the reason of each failed case;
        over the keys for a grid, else over `sample`.

    Raises:
        ConfigError: an unknown key, a value that does not fit it, no cases or too many, or `folder` has the cases of another
            plan.
        ClusterError: `dask` leads to no usable cluster.
        KeyboardInterrupt: Ctrl-C; finished cases are in `folder`.

    Example:
        >>> import rollerrig as rr
        >>> radii = {"support.roller_radius": ["0.5 m", "1 m"]}
        >>> found = rr.sweep("bogie_rollers_constant", radii, measure="critical_speed")
        >>> found["linear_critical_speed"].round().to_numpy().tolist()
        [210.0, 234.0]
    """
    study = sweep_study(as_case(case), vary, measure, design, many=many)
    if dask is None:
        found = study.run(folder=folder, processes=workers, progress=progress)
    else:
        with cluster(dask) as executor:
            found = study.run(folder=folder, progress=progress, executor=executor)
    if found is None or found.interrupted:
        raise KeyboardInterrupt
    return found.results
