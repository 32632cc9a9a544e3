"""A plan of a fit: a case, its free numbers, and what columns of measured logs are compared with."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field

from rollerrig.config.schema.base import Mistakes, Named, Table, by_kind, needed, optional
from rollerrig.config.schema.plan import Lognormal, Normal, OfKey, Value
from rollerrig.config.schema.units import Quantity

AnyPrior = Annotated[Normal | Lognormal, Discriminator("kind")]
LogTime = Annotated[float, Quantity("s", -1e9, 1e9)]
Part = Annotated[float, Quantity("1", 0.0, 0.9)]


class FreeKey(OfKey):
    """A number of the case that is sought."""

    least: Value = needed("lower end of its range")
    most: Value = needed("upper end of its range")
    start: Value | None = optional(None, "value from which the search begins; absent: the case's own value")
    scale: Literal["linear", "logarithmic"] = optional("linear", "whether the number or its logarithm is sought")
    prior: AnyPrior | None = optional(None, "knowledge from before, as one more measurement; absent: none")


class Output(Table):
    """A measured column, and what it is compared with."""

    of: str = needed("output of the model, as `rollerrig export` calls it: wheelset_1.lateral", min_length=1)
    column: str | None = optional(None, "column of the log; absent: one of the output's name")
    unit: str | None = optional(
        None, "unit of the column; absent: what its heading says in brackets; one of the two is needed"
    )
    error: Value | None = optional(None, "standard deviation of one value; absent: found from what the fit leaves")
    error_column: str | None = optional(None, "column with the standard deviation of each value, in its place")
    low_pass: Annotated[float, Quantity("Hz", 1e-3, 1e6)] | None = optional(
        None, "cut-off of the measurement's filter, put on the run likewise, without phase; absent: none"
    )
    any_offset: bool = optional(False, "whether the sensor's zero is unknown: only changes count")

    def _mistakes(self) -> Mistakes:
        if self.error is not None and self.error_column is not None:
            yield "error", "allowed: one of `error` and `error_column`"


class Input(Table):
    """A measured column that drives the run."""

    key: str = needed("dotted key of a table over time, such as motion.torque_table", min_length=1)
    column: str = needed("column of the log", min_length=1)
    unit: str | None = optional(None, "unit of the column; absent: what its heading says in brackets")
    factor: Annotated[float, Quantity("1", -1e6, 1e6)] = optional(1.0, "factor of the values: a gear ratio, or -1")
    between: Literal["line", "hold"] = optional(
        "line", "course between two rows: linear, or held until the next row, as what is switched"
    )


class Log(Table):
    """What every kind of log has."""

    case: str | None = optional(None, "another case than the plan's: a name of the catalogue, or a file")
    changes: dict[str, Any] = optional({}, "changes of the case for this log: dotted key -> value")
    over: str | None = optional(None, "column of times, speeds or creepages; absent: time, speed or creepage, by kind")
    unit: str | None = optional(None, "unit of that column; absent: what its heading says in brackets")
    output: tuple[Output, ...] = needed("compared outputs", min_length=1, max_length=50)


class TimeLog(Log):
    """What every log over time has."""

    begin: LogTime | None = optional(None, "time of the log at which the run begins; absent: the first")
    end: LogTime | None = optional(None, "last time used; absent: the last")
    input: tuple[Input, ...] = optional((), "columns that drive the run", max_length=20)


class RunLog(TimeLog):
    """Signals over time, compared with a run of the case."""

    kind: Literal["run"] = needed("signals over time, compared with a run")


class BrakeUnitLog(TimeLog):
    """Pressure of one cylinder over time, compared with that of the case's [brake] alone: no runs."""

    kind: Literal["brake_unit"] = needed("pressure of a cylinder, empty at the begin, compared with [brake] alone")
    valve: str = optional("valve", "column of dump valve commands, each until the next row: 0 fill, 1 hold, 2 vent")


class ModesLog(Log):
    """Frequency and damping over speed, compared with the modes of the case: no runs."""

    kind: Literal["modes"] = needed("frequency and damping of hunting over speed, compared with modes")


class CreepLog(Log):
    """Traction coefficient over creepage, compared with the case's creep law on one wheel: no runs."""

    kind: Literal["creep"] = needed("traction coefficient over creepage, by the vehicle's speed, and the creep law")
    a_over_b: Annotated[float, Quantity("1", 0.01, 100.0)] | None = optional(
        None, "semi-axis of the contact patch along the rail over that across; absent: that of the case at rest"
    )


AnyLog = Annotated[RunLog | BrakeUnitLog | ModesLog | CreepLog, by_kind("run")]


def _one_or_more(value: Any) -> Any:
    return [value] if isinstance(value, dict) else value


class FitPlan(Named):
    """A case, its free numbers, and logs to fit them to."""

    case: str = needed("the case: a name of the catalogue, or a file", min_length=1)
    changes: dict[str, Any] = optional({}, "changes of the case for all logs: dotted key -> value")
    free: tuple[FreeKey, ...] = needed("keys that are sought", min_length=1, max_length=50)
    log: Annotated[tuple[AnyLog, ...], BeforeValidator(_one_or_more)] = needed(
        "tables by which the logs are read, one after the other; a single one serves for all",
        min_length=1,
        max_length=100,
    )
    loss: Literal["linear", "soft_l1", "huber", "cauchy"] = optional(
        "linear", "weight of a deviation; with the others a few wrong points do not pull"
    )
    held_back: Part = optional(0.0, "part of each log kept for checking: the end of runs, rows spread over other logs")
    starts: Annotated[int, Field(ge=1, le=100)] = optional(
        1, "searches from so many places: from the case's own values, and spread over the ranges"
    )
    seed: Annotated[int, Field(ge=0, lt=2**32)] = optional(1, "seed of those places")
