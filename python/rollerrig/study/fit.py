"""A fit: numbers of a case from measured logs, with intervals, and what the logs do not determine.

WholeFit, files -> [records] -> Record: case, abscissa, measured channels; every mistake is found before the first run
    -> [FitStudy] -> estimates, correlations, residuals, part held back; fitted.toml, estimates.csv, log_1.csv
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, NoReturn

import numpy as np

from rollerrig.analysis.estimation import correlation, widening
from rollerrig.analysis.signals import sampling_rate
from rollerrig.common.arrays import Array
from rollerrig.common.formatting import number
from rollerrig.config import Case, ConfigError, ConfigProblem
from rollerrig.config.errors import nearest, one_of, show_value
from rollerrig.config.load.fit import WholeFit, load_fit
from rollerrig.config.schema.fit import BrakeUnitLog, CreepLog, Log, Output, TimeLog
from rollerrig.config.schema.units import Quantity, unit_factor
from rollerrig.plot import fit as figures
from rollerrig.results import logs
from rollerrig.study.frame import Content, Outcome, Study
from rollerrig.study.jobs import Done, Progress, Round, job
from rollerrig.study.options import OneProcess, Option, command
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Block, Picture, Section, Table, Text
from rollerrig.study.runs.fit import MODELS, OVER_TIME, Channel, Found, Record, search, starts

LARGEST_MEASURED = 1e30
"""Largest value of a channel, in SI: squares of more are no finite numbers, and no free key can be blamed for it."""
MOST_LISTED = 20
"""More outputs of a model are not listed in a message."""
JUMP = 1e-3
"""Part of the time between two rows, its last, in which a held input moves to the next row: tables have no jumps."""


def records(whole: WholeFit, files: Sequence[str | Path | logs.Log | Mapping[str, Any]]) -> tuple[Record, ...]:
    """The logs with their cases.

    Raises:
        ConfigError: a mistake in columns, times or units of each log; fewer points than free numbers.
        FileNotFoundError, ResultsError: a file cannot be read.
    """
    asked, problems, found = whole.plan.log, list[ConfigProblem](), list[Record]()
    if not files or (len(asked) > 1 and len(files) != len(asked)):
        needed = f"needed: {f'as many logs as tables [[log]], {len(asked)}' if files else 'at least one log'}"
        raise ConfigError.of(whole.file, "log", f"{len(files)} logs", needed)
    for place, file in enumerate(files):
        k = place if len(asked) > 1 else 0
        table = logs.read_log(file, f"log {place + 1}")
        try:
            found.append(_Reader(table, asked[k], whole.file, f"log[{k}]").record(whole.cases[k], whole.plan.held_back))
        except ConfigError as error:
            problems += error.problems
    points = sum(int(channel.fitted.sum()) for record in found for channel in record.channels)
    keys = sum(one.prior is None for one in whole.free)
    if not problems and points <= keys:
        allowed = f"allowed: fewer free keys than points, {points}; a `prior` counts as a point"
        problems = [ConfigProblem(whole.file, "free", f"{keys} keys without a prior", allowed)]
    if problems:
        raise ConfigError(problems)
    return tuple(found)


def _refuse(file: str, key: str, value: str, allowed: str, hint: str = "") -> NoReturn:
    raise ConfigError.of(file, key, value, allowed, hint)


@dataclass(frozen=True)
class _Reader:
    """One log as a table of the plan says; each mistake is a ConfigError."""

    table: logs.Log
    log: Log
    plan: str
    at: str

    def record(self, case: Case, held_back: float) -> Record:
        """The record."""
        log, kind = self.log, str(getattr(self.log, "kind", ""))
        name, unit = log.over or MODELS[kind].abscissa[0], MODELS[kind].abscissa[1]
        x = self._column(name, "over", self._factor(name, log.unit, unit, "unit"))
        used: Any = np.ones(len(x), dtype=bool)
        if isinstance(log, TimeLog):
            begin = float(x[0]) if log.begin is None else log.begin
            first, last = -math.inf if log.begin is None else log.begin, math.inf if log.end is None else log.end
            used = (x >= first) & (x <= last)
            if used.sum() < 2:
                allowed = f"allowed: a part of the log with two rows or more; it has {x.min():g} to {x.max():g} s"
                _refuse(self.plan, f"{self.at}.begin", f"{begin:g} s", allowed)
            if problem := logs.time_problem(x[used]):
                allowed = "allowed: times that rise without a gap; cut it with `begin` and `end`, or make it two logs"
                _refuse(self.table.file, name, problem, allowed)
            if (span := float(np.ptp(x[used]))) < case.time.output_step:
                least = f"time.output_step of the case, {case.time.output_step:g} s"
                allowed = f"allowed: at least {least}; is its unit right?"
                _refuse(self.table.file, name, f"{span:.3g} s in all", allowed)
            x = x - begin
            case = self._driven(case, x[used], used, log)
            case = case.with_changes({"time.duration": f"{float(x[used][-1]) + case.time.output_step!r} s"})
        elif unit == "1" and (middle := float(np.median(np.abs(x)))) > 1.0:  # a wheel that spins has more than 1
            allowed = "allowed: parts of the vehicle's speed, most of them from -1 to 1; is it in per cent?"
            _refuse(self.table.file, name, f"{middle:g} in the median", allowed)
        elif unit != "1" and (wrong := x <= 0.0).any():
            first = int(np.argmax(wrong))
            _refuse(self.table.file, name, f"{x[first]:g} in row {first + 1}", f"allowed: more than 0 {unit}")
        outputs, fitted = MODELS[kind].outputs(case), self._fitted(int(used.sum()), held_back)
        channels = (
            self._channel(output, outputs, used, fitted, f"output[{number}]", case)
            for number, output in enumerate(log.output)
        )
        shape = log.a_over_b if isinstance(log, CreepLog) else None
        valve = self._commands(case, log, used) if isinstance(log, BrakeUnitLog) else None
        return Record(self.table.file, case, kind, x[used], tuple(channels), shape, valve)

    def _commands(self, case: Case, log: BrakeUnitLog, used: Array) -> Array:
        """Commands of the dump valve, in each row."""
        if case.brake is None:
            _refuse(self.plan, "case", show_value(case.name), "needed: a case with [brake]")
        commands = self._column(log.valve, "valve", 1.0, used)
        if not (known := np.isin(commands, (0.0, 1.0, 2.0))).all():
            allowed = "allowed: 0 fill, 1 hold, 2 vent"
            _refuse(self.table.file, log.valve, f"{commands[int(np.argmin(known))]:g}", allowed)
        return commands

    def _fitted(self, count: int, held_back: float) -> Array:
        """Which rows are fitted to: the first of a run, of other logs all but some that are spread over it."""
        kept, held = np.ones(count, dtype=bool), round(held_back * count)
        spread = np.linspace(0, count - 1, held + 2).round().astype(int)[1:-1]
        kept[np.arange(count - held, count) if isinstance(self.log, TimeLog) else spread] = False
        return kept

    def _channel(
        self, output: Output, outputs: Mapping[str, str], used: Array, fitted: Array, at: str, case: Case
    ) -> Channel:
        place, name = f"{self.at}.{at}", output.column or output.of
        if output.of not in outputs:
            few = one_of(outputs) if len(outputs) < MOST_LISTED else "allowed: a column of `rollerrig export`"
            _refuse(self.plan, f"{place}.of", show_value(output.of), few, nearest(output.of, tuple(outputs)))
        unit = outputs[output.of]
        factor = self._factor(name, output.unit, unit, f"{at}.unit")
        measured = self._column(name, f"{at}.column", factor, used)
        if (largest := float(np.abs(measured).max())) > LARGEST_MEASURED:
            allowed = f"allowed: up to {LARGEST_MEASURED:g} {unit}"
            _refuse(self.table.file, name, f"{largest:.3g} {unit}", allowed)
        error = np.full(len(measured), math.nan)
        try:
            if output.error_column is not None:
                key = f"{at}.error_column"
                if self.table.units.get(output.error_column):  # else in the unit of what it belongs to
                    factor = self._factor(output.error_column, None, unit, key)
                error = self._column(output.error_column, key, factor, used)
            elif output.error is not None:
                error[:] = Quantity(unit, 0.0, 1e300).parse(output.error)
            if output.low_pass is not None:
                sampling_rate(np.arange(0.0, case.time.duration, case.time.output_step), output.low_pass)
        except ValueError as mistake:
            key = "error" if np.isnan(error).all() and output.error is not None else "low_pass"
            _refuse(self.plan, f"{place}.{key}", show_value(getattr(output, key)), str(mistake))
        if (error <= 0.0).any():
            _refuse(self.plan, f"{place}.error", "0", "allowed: a positive standard deviation")
        return Channel(output.of, unit, measured, error, fitted, output.low_pass, output.any_offset)

    def _driven(self, case: Case, x: Array, used: Array, log: TimeLog) -> Case:
        """The case with the columns that drive it as tables over time."""
        changes: dict[str, object] = {}
        for place, given in enumerate(log.input):
            values = given.factor * self._column(given.column, f"input[{place}].column", 1.0, used)
            if not (unit := given.unit or self.table.units.get(given.column, "")):
                self._needs_unit(given.column, "UNIT", f"input[{place}].unit")
            times = x
            if given.between == "hold":
                after = np.arange(1, len(x))
                times = np.insert(x, after, x[1:] - JUMP * np.diff(x))
                values = np.insert(values, after, values[:-1])
            slope = np.diff(values) / np.diff(times)
            corner = np.r_[True, slope[1:] != slope[:-1], True]  # a run stops at each row of a table
            rows = zip(times[corner].tolist(), values[corner].tolist(), strict=True)
            changes[given.key] = [[t, v if unit == "1" else f"{v!r} {unit}"] for t, v in rows]
        try:
            return case.with_changes(changes) if changes else case
        except ConfigError as error:
            raise ConfigError(
                [replace(p, file=self.plan, key=f"{self.at}.input, {p.key}") for p in error.problems]
            ) from None

    def _factor(self, column: str, given: str | None, si: str, key: str) -> float:
        """Factor to SI of a column; refuses one without a unit, with one of something else, or another than in its heading."""
        heading = self.table.units.get(column, "")
        if column in self.table.columns and not (given or heading or si == "1"):
            self._needs_unit(column, si, key)
        if given and heading and given != heading:
            allowed = f"allowed: the unit in the heading of {self.table.file}, {heading}"
            _refuse(self.plan, f"{self.at}.{key}", show_value(given), allowed)
        factor = unit_factor(*("dimensionless" if unit == "1" else unit for unit in (given or heading or si, si)))
        if factor is None:
            place = (self.plan, f"{self.at}.{key}") if given else (self.table.file, column)
            _refuse(*place, show_value(given or heading), f"allowed: a unit of what is compared, such as {si}")
        return float(factor)

    def _needs_unit(self, column: str, unit: str, key: str) -> NoReturn:
        needed = f"needed: a heading '{column} [{unit}]', or `{self.at}.{key}` in the plan"
        _refuse(self.table.file, column, "has no unit", needed)

    def _column(self, name: str, key: str, factor: float = 1.0, used: Array | None = None) -> Array:
        """Values of a column in SI, of the rows that are used."""
        columns = self.table.columns
        if name not in columns:
            hint = nearest(name, tuple(columns))
            _refuse(self.table.file, f"{self.at}.{key}", f"no column {show_value(name)}", one_of(columns), hint)
        rows = np.arange(len(columns[name])) if used is None else np.flatnonzero(used)
        values = factor * columns[name][rows]
        if (missing := ~np.isfinite(values)).any():
            allowed = "allowed: a number in every row that is used; cut it with `begin` and `end`, or leave the row out"
            first = int(np.argmax(missing))
            shown = "nothing" if np.isnan(values[first]) else f"{values[first]:g}"
            _refuse(self.table.file, name, f"{shown} in row {int(rows[first]) + 1}", allowed)
        return np.asarray(values)


SAME = 1e-3
"""Searches whose sums of squares differ by this part ended at the same place."""
TOGETHER = 0.95
"""Correlation from which two numbers are reported as going together."""


@dataclass(frozen=True)
class Compared:
    """One channel beside what the fitted case gives; `residual`: fitted less measured, in so far as it counts."""

    name: str
    record: Record
    channel: Channel
    values: Any
    error: Any
    residual: Any

    def rms(self, rows: Any) -> float:
        """R.m.s. of the residual in some rows; NaN of none."""
        return float(np.sqrt(np.mean(self.residual[rows] ** 2))) if rows.any() else math.nan

    @property
    def autocorrelation(self) -> float:
        """Correlation of a residual of a run with the one before; NaN for other logs."""
        return correlation(self.residual[self.channel.fitted]) if self.record.kind in OVER_TIME else math.nan


@dataclass(frozen=True)
class Fit:
    """The best of the searches, its channels, and the costs of all searches, rising."""

    found: Found
    compared: tuple[Compared, ...]
    costs: tuple[float, ...]


@dataclass(frozen=True)
class FitStudy(Study[Fit]):
    """Free numbers of a case, fitted to logs."""

    whole: WholeFit
    records: tuple[Record, ...]

    command = "fit"
    writes = ("fitted*.toml", "estimates.csv", "log_*.csv")
    resumable = False
    assumes = (
        "Intervals of 95 % are those of a linear model about the estimate. Residuals that follow each other, or are larger than "
        "the errors that were given, widen them; else an error of the model itself is not in them.",
    )

    @property
    def title(self) -> str:
        return f"Fit {self.whole.plan.name}: {self.whole.plan.description or self.whole.cases[0].name}"

    def cases(self) -> Mapping[str, Case]:
        return {case.name: case for case in self.whole.cases}

    def plan(self) -> dict[str, Any]:
        cases = [tomllib.loads(case.to_toml()) for case in self.whole.cases]
        return {"plan": self.whole.plan.model_dump(mode="json", exclude_none=True), "case": cases}

    def rounds(self, done: Done) -> Iterator[Round]:
        jobs = (job(search, self.whole, self.records, start) for start in starts(self.whole))
        yield {f"search {k + 1}": one for k, one in enumerate(jobs)}

    def collect(self, done: Done) -> Fit | None:
        if not done:
            return None
        best: Found = min(done.values(), key=lambda found: float(found.estimate.cost))
        compared = []
        for k, (record, values, errors) in enumerate(zip(self.records, best.values, best.errors, strict=True)):
            for one, v, e in zip(record.channels, values, errors, strict=True):
                name = f"{one.of}, log {k + 1}" if len(self.records) > 1 else one.of
                compared.append(Compared(name, record, one, v, e, one.counted(v - one.measured)))
        return Fit(best, tuple(compared), tuple(sorted(float(found.estimate.cost) for found in done.values())))

    def numbers(self, results: Fit) -> dict[str, Any]:
        found, fitted = results.found.estimate, [one.channel.fitted for one in results.compared]
        names, same = list(found.values), results.costs[0] + SAME * (1.0 + results.costs[0])
        return {
            "plan": self.whole.plan.name,
            "logs": [record.file for record in self.records],
            "loss": self.whole.plan.loss,
            "points": sum(int(rows.sum()) for rows in fitted),
            "points_held_back": sum(len(rows) - int(rows.sum()) for rows in fitted),
            "degrees_of_freedom": found.degrees_of_freedom,
            "deviation": found.deviation,
            "searches": len(results.costs),
            "searches_at_the_same_end": sum(cost <= same for cost in results.costs),
            "numbers": {
                one.name: {
                    "key": one.key,
                    "unit": one.quantity.unit,
                    "value": found.values[one.name],
                    "standard_error": found.errors[one.name],
                    "lower": found.intervals[one.name][0],
                    "upper": found.intervals[one.name][1],
                    "start": one.start,
                    "least": one.least,
                    "most": one.most,
                    "at_an_end": one.name in found.at_an_end,
                }
                for one in self.whole.free
            },
            "correlations": {
                a: {b: found.correlations[i, j] for j, b in enumerate(names) if j != i} for i, a in enumerate(names)
            },
            "singular_values": found.singular_values,
            "undetermined": found.undetermined,
            "outputs": {
                one.name: {
                    "unit": one.channel.unit,
                    "error": float(np.mean(one.error)),
                    "rms": one.rms(one.channel.fitted),
                    "rms_held_back": one.rms(np.logical_not(one.channel.fitted)),
                    "autocorrelation": one.autocorrelation,
                    "widening": widening(one.residual[one.channel.fitted], len(names))
                    if one.record.kind in OVER_TIME
                    else 1.0,
                }
                for one in results.compared
            },
        }

    def summary(self, results: Fit, numbers: Numbers) -> list[str]:
        lines, names = [], list(numbers["numbers"])
        for name, one in numbers["numbers"].items():
            end = "; at an end of its range" if one["at_an_end"] else ""
            ends = _with_unit(f"{number(one['lower'])} to {number(one['upper'])}", one["unit"])
            lines.append(f"{name}: {_with_unit(number(one['value']), one['unit'])}, 95 % from {ends}{end}.")
        lines += [f"Not determined: {one}." for one in numbers["undetermined"]]
        for a, b in ((a, b) for k, a in enumerate(names) for b in names[k + 1 :]):
            if abs(value := numbers["correlations"][a][b]) > TOGETHER:
                lines.append(f"{a} and {b} go together: correlation {value:+.3f}.")
        for name, one in numbers["outputs"].items():
            held = "" if one["rms_held_back"] is None else f", of the part held back {number(one['rms_held_back'], 3)}"
            lines.append(f"{name}: r.m.s. of what is left {_with_unit(number(one['rms'], 3) + held, one['unit'])}.")
            if one["widening"] > 1.0:
                follows, times = number(one["autocorrelation"], 2), number(one["widening"], 2)
                lines.append(
                    f"{name}: residuals follow each other, correlation {follows}: intervals are widened {times} times for it; "
                    "the model or a filter may be wrong."
                )
        if results.found.estimate.known and results.found.estimate.scale > 1.0:
            times = number(results.found.estimate.deviation, 3)
            lines.append(
                f"What is left is {times} times the errors that were given: the model, or they, are wrong; intervals are widened."
            )
        if numbers["searches"] > 1:
            lines.append(
                f"{numbers['searches_at_the_same_end']} of {numbers['searches']} searches ended at this place."
            )
        return lines

    def files(self, results: Fit, numbers: Numbers) -> Mapping[str, Content]:
        names = ("key", "unit", "value", "standard_error", "lower", "upper", "start", "least", "most")
        found: dict[str, Content] = {"estimates.csv": self.quantities.csv(numbers["numbers"].values(), names)}
        texts = self._fitted_cases(results)
        for k, text in enumerate(texts):
            found[f"fitted_{k + 1}.toml" if len(texts) > 1 else "fitted.toml"] = text
        for k, record in enumerate(self.records):
            columns = {_heading(*MODELS[record.kind].abscissa): record.x}
            for one in (one for one in results.compared if one.record is record):
                for word, values in (("measured", one.channel.measured), ("fitted", one.values)):
                    columns[_heading(f"{one.channel.of} {word}", one.channel.unit)] = values
                columns[f"{one.channel.of} used"] = one.channel.fitted.astype(int)
            found[f"log_{k + 1}.csv"] = columns
        return found

    def _fitted_cases(self, results: Fit) -> list[str]:
        """Each case of the plan with the estimates; its first lines say where they come from."""
        found, logs = results.found.estimate, ", ".join(record.file for record in self.records)
        head = [f"# Fitted by `rollerrig fit`, plan {self.whole.plan.name}, to {logs}; all else is as in the plan."]
        for one in self.whole.free:
            low, high = found.intervals[one.name]
            ends = _with_unit(f"{low:.6g} to {high:.6g}", one.quantity.unit)
            head.append(
                f"# {one.key} = {found.values[one.name]:.6g}, 95 % from {ends}{', with its prior' * (one.prior is not None)}"
            )
        head += [f"# Not determined: {one}." for one in found.undetermined]
        changes = {one.key: one.quantity.as_written(float(f"{found.values[one.name]:.9g}")) for one in self.whole.free}
        texts = dict.fromkeys(case.with_changes(changes).to_short_toml() for case in self.whole.cases)
        return ["\n".join([*head, "", text]) for text in texts]

    def sections(self, results: Fit, numbers: Numbers) -> list[Section]:
        free, found = numbers["numbers"], results.found.estimate
        shown = ("key", "value", "standard_error", "lower", "upper", "unit", "start", "least", "most", "at_an_end")
        rows = [[a, *(number(row.get(b, 1.0), 3) for b in free)] for a, row in numbers["correlations"].items()]
        parts = [
            [number(size, 3), *(number(float(part), 2) for part in row)]
            for size, row in zip(numbers["singular_values"], found.combinations, strict=True)
        ]
        caption = "Combinations over the ranges, best known first; 1 over the singular value: its standard deviation."
        sections = [
            Section("Estimates", [
                self.quantities.table(free, shown, "Estimates; lower and upper: interval of 95 %.", "number"),
                Table(("", *free), rows, "Correlations of the estimates."),
            ]),
            Section("What the data determine", [
                *(Text(f"Not determined: {one}.") for one in numbers["undetermined"]),
                Table(("singular value", *free), parts, caption),
            ]),
            Section("What is left", [self.quantities.table(numbers["outputs"], "outputs.*", head="output")]),
        ]  # fmt: skip
        for k, one in enumerate(results.compared):
            x, channel = one.record.x, one.channel
            along, label = _axis(*MODELS[one.record.kind].abscissa), _axis(channel.of, channel.unit)
            fitted = channel.measured + one.residual
            picture = figures.comparison(x, channel.measured, fitted, channel.fitted, along, label)
            text = f"{one.name}: measured and fitted, and what is left; grey: held back."
            blocks: list[Block] = [Picture(f"output_{k + 1}", picture, text)]
            over_time = one.record.kind in OVER_TIME
            if over_time and (spectrum := figures.spectrum(x, one.residual, channel.unit)) is not None:
                text = f"{one.name}: spectrum of what is left; flat: noise alone."
                blocks.append(Picture(f"spectrum_{k + 1}", spectrum, text))
            sections.append(Section(one.name, blocks))
        return sections


def _with_unit(text: str, unit: str) -> str:
    return text if unit == "1" else f"{text} {unit}"


def _axis(name: str, unit: str) -> str:
    return f"{name.replace('_', ' ')} [{'-' if unit == '1' else unit}]"


def _heading(name: str, unit: str) -> str:
    return name if unit == "1" else f"{name} [{unit}]"


@command
def fit(
    plan: Mapping[str, Any] | str,
    logs: Sequence[str | Path | Mapping[str, Any]],
    *,
    changes: Annotated[Mapping[str, object] | None, Option("change")] = None,
    allow_code: bool = False,
    processes: OneProcess = 1,
    progress: Progress | None = None,
) -> Outcome[Fit]:
    """Numbers of a case from measured logs: estimates with intervals, what the logs do not determine, the fitted case.

    Args:
        plan: plan of a fit: a name of the catalogue or a TOML file.
        logs: files of measured signals (.csv, .mat, .nc, .parquet), one for each [[log]] of the plan.
        changes: other values of the plan's case, by dotted key.
        allow_code: also take controllers from outside the folder of the case that names them.
        processes: searches at a time.
        progress: called with the fraction done and a short text.

    From Python a plan may also be its tables, and a log its columns: heading -> values.

    Raises:
        ConfigError: all mistakes of plan and logs, found before the first run; a free key that changes nothing.
        FileNotFoundError: a log that is not there.
        ResultsError: a file that is no log.
        ValueError, RuntimeError: no run of the model can be compared with the logs.

    Example:
        >>> import rollerrig as rr
        >>> points = {"creepage [%]": [0.5, 1.1, 2.9, 6.0, 14.1], "traction_coefficient": [0.25, 0.288, 0.304, 0.297, 0.241]}
        >>> found = rr.fit("creep_curve", [{**points, "traction_error": [0.005] * 5}])
        >>> {name: round(one["value"], 1) for name, one in found.numbers["numbers"].items()}
        {'mu_0': 0.4, 'B': 0.5, 'k_S': 0.4}
    """
    whole = load_fit(plan, allow_code=allow_code, changes=changes)
    return FitStudy(whole, records(whole, logs)).outcome(processes, progress)
