"""The logs of a fit as its plan reads them: columns in SI, rows that are used; every mistake is found before the first run.

WholeFit, files -> [records] -> Record: case, abscissa, measured channels
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from rollerrig.analysis.signals import sampling_rate
from rollerrig.common.arrays import Array
from rollerrig.config import Case, ConfigError, ConfigProblem
from rollerrig.config.errors import nearest, one_of, show_value
from rollerrig.config.load.fit import WholeFit
from rollerrig.config.schema.fit import BrakeUnitLog, CreepLog, Log, Output, TimeLog
from rollerrig.config.schema.units import Quantity, unit_factor
from rollerrig.results.logs import Log as Table
from rollerrig.results.logs import read_log, time_problem
from rollerrig.study.runs.fit import MODELS, Channel, Record

MOST_LISTED = 20
"""More outputs of a model are not listed in a message."""


def records(whole: WholeFit, files: Sequence[str | Path | Table]) -> tuple[Record, ...]:
    """The logs with their cases.

    Raises:
        ConfigError: a mistake in columns, times or units of each log; fewer points than free numbers.
        FileNotFoundError, ResultsError: a file cannot be read.
    """
    logs, problems, found = whole.plan.log, list[ConfigProblem](), list[Record]()
    if not files or (len(logs) > 1 and len(files) != len(logs)):
        needed = f"needed: {f'as many logs as tables [[log]], {len(logs)}' if files else 'at least one log'}"
        raise ConfigError([ConfigProblem(whole.file, "log", f"{len(files)} logs", needed)])
    for number, file in enumerate(files):
        k = number if len(logs) > 1 else 0
        table = file if isinstance(file, Table) else read_log(file)
        try:
            found.append(_Reader(table, logs[k], whole.file, f"log[{k}]").record(whole.cases[k], whole.plan.held_back))
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
    raise ConfigError([ConfigProblem(file, key, value, allowed, hint)])


@dataclass(frozen=True)
class _Reader:
    """One log as a table of the plan says; each mistake is a ConfigError."""

    table: Table
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
            used = (x >= begin) & (x <= (math.inf if log.end is None else log.end))
            if used.sum() < 2:
                allowed = f"allowed: a part of the log with two rows or more; it has {x.min():g} to {x.max():g} s"
                _refuse(self.plan, f"{self.at}.begin", f"{begin:g} s", allowed)
            if problem := time_problem(x[used]):
                allowed = "allowed: times that rise without a gap; cut it with `begin` and `end`, or make it two logs"
                _refuse(self.table.file, name, problem, allowed)
            x = x - begin
            case = self._driven(case, x[used], used, log)
            case = case.with_changes({"time.duration": f"{float(x[used][-1]) + case.time.output_step!r} s"})
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
        error = np.full(len(measured), math.nan)
        try:
            if output.error_column is not None:
                error = self._column(output.error_column, f"{at}.error_column", factor, used)
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
        for number, given in enumerate(log.input):
            unit = given.unit or self.table.units.get(given.column, "")
            values = given.factor * self._column(given.column, f"input[{number}].column", 1.0, used)
            slope = np.diff(values) / np.diff(x)
            corner = np.r_[True, slope[1:] != slope[:-1], True]  # a run stops at each row of a table
            rows = zip(x[corner].tolist(), values[corner].tolist(), strict=True)
            changes[given.key] = [[t, f"{v!r} {unit}" if unit else v] for t, v in rows]
        try:
            return case.with_changes(changes) if changes else case
        except ConfigError as error:
            raise ConfigError(
                [replace(p, file=self.plan, key=f"{self.at}.input, {p.key}") for p in error.problems]
            ) from None

    def _factor(self, column: str, given: str | None, si: str, key: str) -> float:
        """Factor to SI of a column; refuses a unit of something else, or another one than in the heading."""
        heading = self.table.units.get(column, "")
        if given and heading and given != heading:
            allowed = f"allowed: the unit in the heading of {self.table.file}, {heading}"
            _refuse(self.plan, f"{self.at}.{key}", show_value(given), allowed)
        factor = unit_factor(*("dimensionless" if unit == "1" else unit for unit in (given or heading or si, si)))
        if factor is None:
            place = (self.plan, f"{self.at}.{key}") if given else (self.table.file, column)
            _refuse(*place, show_value(given or heading), f"allowed: a unit of what is compared, such as {si}")
        return float(factor)

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
            _refuse(self.table.file, name, f"nothing in row {int(rows[int(np.argmax(missing))]) + 1}", allowed)
        return np.asarray(values)
