"""Rows of plain numbers become a Dataset: names, dimensions, units, provenance, energy audit, limits of the drives.

    recorder's rows, names of the model's parts, how the run ended -> [dataset] -> Draft, energy audit, ... -> xarray.Dataset
    results with the core's accounts -> [energy] -> the same with `energy_residual` and two attributes, docs/theory/energy.md (E1)
    times that the core counted -> [drive_limits] -> a warning
    readings of the core between output times -> Recording -> [add_readings] -> variables over `reading_time`

The order of a row is the recorder's (core/include/rollerrig/simulate/recorder.hpp): bodies, wheels, patches, elements, run.
Nothing is copied: the variables are views of the rows. A Dataset takes a millisecond to build and as long for every variable
that is added to it; a draft holds plain dictionaries, and becomes a Dataset once everything is in it. Of short runs one after the
other the empty Dataset is kept: filling a copy of it takes less than half of the time.

Wheel-rail forces hold vibrations of the wheels on their contacts at some hundred hertz. Taken every 5 or 10 ms they fold down
below 20 Hz, where no filter finds them any more; every millisecond they do not. Whole rows so often would fill the disk, so
that between output times only what is to be filtered at 20 Hz is kept.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import xarray as xr

from rollerrig import __version__, _core
from rollerrig.assembly.model import AssembledModel
from rollerrig.common.arrays import Array
from rollerrig.config import Case
from rollerrig.results import run_info
from rollerrig.results.run_info import sources_of

Field = tuple[str, str, str]
"""Name, unit, meaning."""

COMPLETED = ("ok", "stopped")
"""Statuses of a run that ended as asked: at its duration, or where the train had stopped."""


@dataclass(frozen=True)
class Outcome:
    """How a run ended."""

    status: str  # name of the core's status: 'ok', 'stopped', 'derailed', 'interrupted', ...
    message: str  # a sentence with time, wheel and remedy
    stopped_at: float  # time that the integration reached [s]
    wheel: str  # the wheel that the status speaks of, or ""
    statistics: Mapping[str, float]  # counts of the integrator
    counters: Mapping[str, int]  # counts of the contacts


Variable = tuple[Any, Any, dict[str, str]]
"""Dimensions, values, attributes."""

Names = tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...], tuple[str, ...]]
"""Names of bodies, wheels, elements, axles."""

_Layout = tuple[tuple[str, Any, Any, tuple[tuple[str, str], ...]], ...]
"""Layout of the variables: of each its name, dimensions, shape or the bytes of its values, attributes."""

_SHORT = 65536
"""Bytes of the times of runs of which the empty Dataset is kept: of longer ones it costs little to make another."""


@dataclass(frozen=True)
class Draft:
    """Results in the making."""

    variables: dict[str, Variable]  # by name
    times: dict[str, Variable]  # coordinates of the dimensions that are times
    attributes: dict[str, Any]  # of the whole
    # coordinates of the other dimensions: of bodies, wheels, elements and axles; no axles: there is no such dimension;
    # None: there is none of them
    names: Names | None = None

    def values(self, name: str) -> Array:
        """Values of a variable, or of a coordinate that is a time.

        Raises:
            KeyError: there is none of that name.
        """
        _, values, _ = self.times[name] if name in self.times else self.variables[name]
        return np.asarray(values)

    def dataset(self) -> xr.Dataset:
        """What is in it now, as results."""
        layout = tuple(
            (name, dims, np.shape(values), tuple(attributes.items()))
            for name, (dims, values, attributes) in self.variables.items()
        )
        times = tuple(
            (name, dims, np.asarray(values, dtype=np.float64).tobytes(), tuple(attributes.items()))
            for name, (dims, values, attributes) in self.times.items()
        )
        short = sum(len(values) for _, _, values, _ in times) <= _SHORT
        empty = (_empty if short else _empty.__wrapped__)(layout, times, self.names)
        filled = empty.copy(data={name: values for name, (_, values, _) in self.variables.items()})
        filled.attrs = self.attributes
        return filled


@lru_cache(maxsize=16)
def _empty(layout: _Layout, times: _Layout, names: Names | None) -> xr.Dataset:
    """A Dataset with times, names and attributes, all of whose variables are one NaN."""
    variables = {
        name: xr.Variable(dims, np.broadcast_to(np.nan, shape), dict(attributes), fastpath=True)
        for name, dims, shape, attributes in layout
    }
    own = {name: (dims, np.frombuffer(values), dict(attributes)) for name, dims, values, attributes in times}
    given = xr.Coordinates(own)
    parts = _parts(*names) if names else xr.Coordinates()
    coordinates = xr.Coordinates({**given.variables, **parts.variables}, {**given.xindexes, **parts.xindexes})
    return xr.Dataset(variables, coordinates)


def variable(dims: str | tuple[str, ...], values: Any, units: str, meaning: str) -> Variable:
    """A variable or coordinate of a Dataset, with its unit and meaning as attributes."""
    return dims, values, {"units": units, "long_name": meaning}


def run_dataset(model: AssembledModel, times: Array, rows: Array, outcome: Outcome) -> xr.Dataset:
    """The Dataset of a run as `run_draft` has it."""
    return run_draft(model, times, rows, outcome).dataset()


def run_draft(model: AssembledModel, times: Array, rows: Array, outcome: Outcome) -> Draft:
    """The results of a run, without the energy audit.

    Args:
        model: the model that was run.
        times: output times [s], shape (time,).
        rows: one row of the recorder per output time, shape (time, width); the wider ones of runs with sensors, controllers
            or actuators have those of each axle and of the train behind them.
        outcome: how the run ended.

    Returns:
        Dimensions time, body, wheel, patch, element, and axle where rows are wide; each variable has `units` and `long_name`.
    """
    wheels = [wheel.name for wheel in model.wheels]
    sizes = {"body": len(model.bodies), "wheel": len(wheels), "element": len(model.elements)}
    sizes |= {"patch": _core.patches_recorded, "axle": len(model.axle_names)}
    blocks = _blocks()
    without_axles = [block for block in blocks if block[1] not in (_core.axle_fields, _core.train_fields)]
    if rows.shape[1] <= sum(math.prod(sizes[dim] for dim in dims) * len(fields) for dims, fields, _ in without_axles):
        blocks = without_axles
    variables: dict[str, Variable] = {}
    start = 0
    for dims, fields, prefix in blocks:
        shape = tuple(sizes[dim] for dim in dims)
        width = math.prod(shape) * len(fields)
        block = rows[:, start : start + width].reshape(len(times), *shape, len(fields))
        start += width
        for column, (name, unit, meaning) in enumerate(fields):
            attributes = {"units": unit, "long_name": meaning}
            variables[prefix + name] = (("time", *dims), block[..., column], attributes)
    axles = model.axle_names if "axle_speed" in variables else ()
    return Draft(
        variables,
        {"time": variable("time", times, "s", "time since the start")},
        _attributes(model, outcome),
        (model.bodies, tuple(wheels), model.elements, axles),
    )


def _blocks() -> list[tuple[tuple[str, ...], list[Field], str]]:
    """What a row of the recorder holds: dimensions beside time, fields of the core, and what stands here before their names."""
    return [
        (("body",), _core.body_fields, ""),
        (("wheel",), _core.wheel_fields, ""),
        (("wheel", "patch"), _core.patch_fields, "patch_"),
        (("element",), _core.element_fields, "element_"),
        ((), _core.run_fields, ""),
        (("axle",), _core.axle_fields, ""),
        ((), _core.train_fields, ""),
    ]


def recorded_names(results: xr.Dataset) -> list[str]:
    """Variables of every run that has these dimensions."""
    of_axles = () if "axle" in results.sizes else (_core.axle_fields, _core.train_fields)
    return [prefix + one[0] for _, fields, prefix in _blocks() if fields not in of_axles for one in fields]


_OF_RUN = {
    **dict.fromkeys(("title", "case", "status", "status_message", "warnings", "config_toml", run_info.ATTRIBUTE), str),
    **dict.fromkeys(("stopped_at_s", "energy_turned_over_j", "energy_relative_residual"), float),
}
"""Attributes of a run that are read, and their types."""


def wrong_attribute(results: xr.Dataset) -> str:
    """Which attribute a run lacks or has of another type, in words; '' where all are right, or where it is no run."""
    recorded = "patch_normal" in results and "time" in results.sizes
    if not recorded and "energy_relative_residual" not in results.attrs:
        return ""
    wrong = (name for name, kind in _OF_RUN.items() if not isinstance(results.attrs.get(name), kind))
    return next((f"its attribute {name} is missing or of another kind" for name in wrong), "")


def wrong_dimensions(results: xr.Dataset) -> str:
    """Which variable of a run has other dimensions than a run gives it, in words; '' where none has, or where it is no run.

    One moment of a run, as of steady rolling, has a time in place of times.
    """
    if "patch_normal" not in results or "config_toml" not in results.attrs:
        return ""
    moment = "time" in results.variables and results["time"].dims == ()
    for dims, fields, prefix in _blocks():
        for name in (prefix + field[0] for field in fields):
            wanted = dims if moment else ("time", *dims)
            if name in results and results[name].dims != wanted:
                found, right = (", ".join(map(str, some)) or "nothing" for some in (results[name].dims, wanted))
                return f"{name} over {found}, not over {right}"
    return ""


@lru_cache(maxsize=64)
def _parts(
    bodies: tuple[str, ...], wheels: tuple[str, ...], elements: tuple[str, ...], axles: tuple[str, ...]
) -> xr.Coordinates:
    """Coordinates of the dimensions that are no times; `axles` empty: there is no such dimension."""
    coordinates = {
        "body": (list(bodies), "body"),
        "wheel": (list(wheels), "wheel"),
        "patch": (np.arange(1, _core.patches_recorded + 1), "patch of a wheel, from the flange outwards"),
        "element": (np.array(elements, dtype=str), "force element"),
        **({"axle": (list(axles), "wheelset under test, or simulated axle of the train")} if axles else {}),
    }
    return xr.Coordinates({name: (name, of, {"long_name": meaning}) for name, (of, meaning) in coordinates.items()})


def _attributes(model: AssembledModel, outcome: Outcome) -> dict[str, Any]:
    case = model.case
    # JSON knows no infinity: a run of no steps has no smallest one
    statistics = {key: value if math.isfinite(value) else None for key, value in outcome.statistics.items()}
    return {
        "title": case.description or case.name,
        "case": case.name,
        "status": outcome.status,
        "status_message": outcome.message,
        "stopped_at_s": outcome.stopped_at,
        "stopped_wheel": outcome.wheel,
        "solver_statistics": json.dumps(statistics, sort_keys=True),
        "contact_counters": json.dumps(dict(outcome.counters), sort_keys=True),
        run_info.ATTRIBUTE: run_info.describe(model).to_json(),
        "sources": json.dumps(sources_of(case), ensure_ascii=False, sort_keys=True),
        "config_toml": case.to_toml(),
        "rollerrig_version": __version__,
    }


WORK_IN = ("energy_work_of_drive", "energy_work_of_torque")
"""Accounts of work put in since the start [J]."""

STORED = ("energy_kinetic", "energy_gravity", "energy_elements", "energy_stored_contacts")
"""Accounts of stored energy; only their change counts [J]."""

DISSIPATED = tuple(f"energy_dissipated_{name}" for name in ("elements", "normal", "creep", "brakes"))
"""Accounts of heat since the start [J]."""

_SIGNS = ((WORK_IN, 1.0), (STORED, -1.0), (DISSIPATED, -1.0))


def add_energy_audit(draft: Draft) -> None:
    """Add the energy balance of a run to a draft with the accounts: the variable `energy_residual` and two attributes.

    `energy_residual` = work in - change of what is stored - heat [J]. The energy turned over, `energy_turned_over_j`, is half
    the sum of the total variations of all accounts between the output times: each joule that moves leaves one account and
    enters another. `energy_relative_residual` is the largest residual over that.
    """
    accounts = np.stack([draft.values(name) for names, _ in _SIGNS for name in names])
    signs = np.array([[sign] for names, sign in _SIGNS for _ in names])
    residual = (signs * (accounts - accounts[:, :1])).sum(axis=0)
    turned_over = 0.5 * float(np.abs(np.diff(accounts)).sum(axis=1).sum())
    meaning = "work in minus change of kinetic, potential and stored energy minus heat; 0 but for integration errors"
    largest = float(np.abs(residual).max(initial=0.0))
    draft.variables["energy_residual"] = variable("time", residual, "J", meaning)
    draft.attributes["energy_turned_over_j"] = turned_over
    draft.attributes["energy_relative_residual"] = largest / turned_over if turned_over > 0 else 0.0


LIMITS = {"torque": "drive_torque_limited", "power": "drive_power_limited", "speed": "drive_speed_limited"}
"""Limit of a roller's drive -> how long it has acted."""

_LEAST = 0.01
"""A drive that is held back for less is not worth a line [s]."""


def drive_warning(draft: Draft) -> str:
    """Which limits of the roller drives acted, for how long, and the power that was asked for; "" if none did."""
    if LIMITS["torque"] not in draft.variables or not len(draft.values("time")):
        return ""
    longest = {name: float(draft.values(key)[-1].max()) for name, key in LIMITS.items()}
    acted = [f"of {name} for {time:.3g} s" for name, time in longest.items() if time >= _LEAST]
    if not acted:
        return ""
    wanted = float(np.abs(draft.values("demanded_roller_power")).max())
    delivered = float(np.abs(draft.values("roller_power")).max())
    return (
        f"the roller drives met their limit {', '.join(acted)} (one axle, the longest); asked for up to {wanted / 1e3:.4g} kW, "
        f"they gave up to {delivered / 1e3:.4g} kW"
    )


READING_STEP, LONGEST_READING_STEP = 1e-3, 2e-3
"""Interval of the readings [s]: 50 in a period of 20 Hz; 25 where the run's own step is as long, and shows no more: a reading at
the end of a step is free, one within it costs as much as half a step."""

MOST_READINGS = 20
"""Per output time: a run of which so little is kept has no readings."""


def readings_per_sample(case: Case) -> int:
    """How many readings there are from one output time to the next; 1: none between.

    With actuators or controllers outputs are at multiples of the sampling step. On a scaled model all is as fast as its time.
    """
    output, scale = case.time.output_step, case.similitude.time if case.similitude else 1.0
    _, step = case.integration
    interval = READING_STEP
    if step and not case.sampled:
        interval = min(max(interval, scale * step), LONGEST_READING_STEP)
    wanted = math.ceil(scale * output / interval * (1.0 - 1e-9))
    if wanted > MOST_READINGS:
        return 1
    if not case.sampled:
        return wanted
    steps = max(1, round(output / case.time.sampling_step))
    return next(count for count in range(1, steps + 1) if steps % count == 0 and count >= min(wanted, steps))


class Recording:
    """Room for the rows and readings of one run.

    Args:
        count: output times of the whole run.
        width: columns of a row.
        every: readings per output time.
        columns: of a reading.

    Attributes:
        times, rows: [s] and values at the output times; NaN and empty where the run has not come to.
        reading_times, readings: the same of the readings, none with `every` = 1.
    """

    def __init__(self, count: int, width: int, every: int, columns: int) -> None:
        self.every = every
        self.times, self.rows = np.full(count, np.nan), np.empty((count, width))
        between = (count - 1) * every + 1 if every > 1 else 0
        self.reading_times, self.readings = np.empty(between), np.empty((between, columns))

    @property
    def filled(self) -> int:
        """Rows that are there."""
        return int(np.count_nonzero(np.isfinite(self.times)))

    @staticmethod
    def size(count: int, width: int, every: int, columns: int) -> int:
        """Numbers that a recording holds."""
        return count * (width + 1) + (count * every * (columns + 1) if every > 1 else 0)


PREFIX = "reading_"
DIMENSION = "reading_time"


def add_readings(draft: Draft, model: AssembledModel, times: Array, values: Array) -> None:
    """Add the readings of a run; nothing where there are none.

    Args:
        draft: what `run_draft` returns; it is changed.
        model: the model that was run.
        times: of the readings [s], shape (reading_time,).
        values: `_core.reading_fields` of one wheel after the other, then the distance; shape (reading_time, columns).
    """
    if not len(times):
        return

    def attributes(name: str) -> dict[str, str]:
        _, _, own = draft.variables[name]
        return {"units": own["units"], "long_name": f"{own['long_name']}; between the output times"}

    fields = _core.reading_fields
    wheels = values[:, :-1].reshape(len(times), len(model.wheels), len(fields))
    for k, name in enumerate(fields):
        draft.variables[f"{PREFIX}{name}"] = ((DIMENSION, "wheel"), wheels[..., k], attributes(name))
    draft.variables[f"{PREFIX}distance"] = ((DIMENSION,), values[:, -1], attributes("distance"))
    draft.times[DIMENSION] = variable(DIMENSION, times, "s", "time of the readings between the outputs")


def readings_of(run: xr.Dataset) -> xr.Dataset | None:
    """The readings over `time`, without their prefix, as far as the run's output times reach; None: it has none."""
    if f"{PREFIX}distance" not in run or not run.sizes["time"]:
        return None
    names = {f"{PREFIX}{name}": name for name in (*_core.reading_fields, "distance")}
    first, last = float(run["time"][0]), float(run["time"][-1])
    kept = run[list(names)].drop_vars("time", errors="ignore").sel({DIMENSION: slice(first, last)})
    return kept.rename({**names, DIMENSION: "time"})
