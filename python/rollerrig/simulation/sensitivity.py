"""Derivatives of a run's outputs by numbers of its case, through contact.

    Case, keys -> [Case changed by +-h at each key, assembled] -> core: S' = J S + df/dp beside the run -> Sensitivity

S takes the steps of the run: it is the derivative of what the run computes. How a number enters the model is known to the
assembly alone: df/dp, and the derivative of the starting state, are differences between two models.
Equations: core/include/rollerrig/simulate/tangent_run.hpp.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig import _core
from rollerrig.assembly.actuators import assemble_as_run
from rollerrig.assembly.model import AssembledModel
from rollerrig.cases import as_case
from rollerrig.common.arrays import Array
from rollerrig.config import Case, ConfigError, ConfigProblem
from rollerrig.config.errors import nearest, one_of
from rollerrig.config.load.change import matching_paths, parts_of, value_in, whole_key
from rollerrig.config.write.differences import tables_of
from rollerrig.config.write.explain import unit_of
from rollerrig.results import COMPLETED, Outcome, run_draft
from rollerrig.simulation.run import Progress, outcome, prepare

RELATIVE_WIDTH = 1e-5
"""Half width of the differences by a number, over its size [1]: their error is its square."""

METHOD = "exponential_adams"
"""Whose steps the derivatives take."""

STEP, RELATIVE_TOLERANCE, ABSOLUTE_TOLERANCE = 0.2e-3, 1e-9, 1e-12
"""Longest step [s] and largest tolerances: derivatives of normal forces are wrong with those that suffice for a run."""

_SLICES = 100
"""Slices of a run, for its progress and Ctrl-C."""

_SWITCHING = ("slide_protection", "wheel_slip_control", "brake_unit", "sanding")
"""Tables of a case whose blocks switch: what they do has no derivative."""

_BESIDE_CONTACTS = re.compile(r"vehicle\.(element\..*|body\.[^.]*\.(mass|inertia\..*))")
"""Keys of numbers on which contact forces in a given state do not depend: their models need not look for contacts."""


@dataclass(frozen=True)
class Sensitivity:
    """A run, and how it changes with numbers of its case.

    Attributes:
        run: the outputs asked for, as `simulate` returns them.
        values: numbers of the case at the keys, in SI, shape (parameter,).
        derivatives: variables of the same names, with a first dimension `parameter`, whose coordinate are the keys; each in
            its unit per SI unit of the number, `parameter_unit`.
    """

    run: xr.Dataset
    values: Array
    derivatives: xr.Dataset


def sensitivity(
    case: Case | str,
    parameters: Sequence[str],
    outputs: Sequence[str],
    *,
    progress: Progress | None = None,
) -> Sensitivity:
    """Run a case by exponential_adams, with the derivatives of its outputs by any of its numbers.

    Its steps are at most 0.2 ms and its tolerances 1e-9 and 1e-12, whatever the case names: those of a run do not suffice.

    Args:
        case: what to run, or its name in the catalogue.
        parameters: dotted keys of numbers, as `Case.with_changes` takes them; one with `*` stands for all that match, which
            must be equal, and are changed together.
        outputs: variables of the results of `simulate`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: a key is that of no number, or of one that is 0; the case has a controller that switches.
        ValueError: there is no such output.
        StartError: no equilibrium was found to start from.
        ArithmeticError: the run did not come to its end.

    Example:
        >>> import rollerrig as rr
        >>> case = rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.1 s"})
        >>> found = rr.sensitivity(case, ["vehicle.body.wheelset_1.mass"], ["lateral"])
        >>> found.derivatives["lateral"].dims
        ('parameter', 'time', 'body')
    """
    case = as_case(case)
    require_smooth(case)
    case = with_fine_steps(case)
    values = [number_of(case, key) for key in parameters]
    model = assemble_as_run(case)
    simulation = prepare(model)
    layout = _layout(model, simulation.width, outputs)
    kept = np.unique(np.concatenate([layout[name].values.ravel() for name in outputs])).astype(np.intp)
    pairs = [_changed_runs(model, key, value) for key, value in zip(parameters, values, strict=True)]
    run = _core.TangentRun(simulation, pairs, np.zeros((0, 0)), kept.tolist(), list(model.breakpoints))
    times, rows, derivatives = [], [], []
    duration, code, done = case.time.duration, _core.status_codes["ok"], 0
    while done < _SLICES and code == _core.status_codes["ok"]:
        done += 1
        code = run.advance(duration * done / _SLICES)
        for time, row, by_number in run.take_outputs():
            times.append(time)
            rows.append(row)
            derivatives.append(by_number)
        if progress is not None:
            progress(done / _SLICES, f"t = {run.time:.2f} s of {duration:g} s")
    ended = outcome(simulation, model, code)
    if ended.status not in COMPLETED:
        raise ArithmeticError(f"{case.name}: {ended.message}")
    found = _dataset(layout, np.array(times), kept, np.stack(derivatives, axis=1), parameters)
    return Sensitivity(_dataset(layout, np.array(times), kept, np.array(rows)), np.array(values), found)


def changed_cases(case: Case, key: str, relative_width: float = RELATIVE_WIDTH) -> tuple[float, tuple[Case, Case]]:
    """The number at a key in SI, and the cases in which it is larger and smaller by a part of itself.

    Raises:
        ConfigError: as `number_of`, or the case is not allowed with them.
    """
    value = number_of(case, key)
    width = relative_width * abs(value)
    return value, (changed_case(case, key, value + width), changed_case(case, key, value - width))


def number_of(case: Case, key: str) -> float:
    """The number at a key, in SI.

    Raises:
        ConfigError: there is no such number, several that differ, or it is 0.
    """
    tables = tables_of(case)
    paths = matching_paths(tables, parts_of(whole_key(key)), key, case.name)
    if isinstance(paths, ConfigProblem):
        raise ConfigError([paths.shortened()])
    found = {_number_at(tables, path, key, case.name) for path in paths}
    if len(found) > 1:
        shown = ", ".join(f"{value:g}" for value in sorted(found))
        allowed = "allowed: keys of equal numbers, which are changed together; name each of them"
        raise ConfigError.of(case.name, key, f"stands for {shown}", allowed)
    value = found.pop()
    if value == 0.0:
        allowed = "allowed: a number that is not 0, whose size says how far to change it; give it a small one"
        raise ConfigError.of(case.name, key, "is 0", allowed)
    return value


def changed_case(case: Case, key: str, value: float) -> Case:
    """The case with another number at a key, in SI.

    Raises:
        ConfigError: the number is not allowed there.
    """
    unit = unit_of(key)
    return case.with_changes({key: f"{value!r} {unit}" if unit else value})


def require_smooth(case: Case) -> None:
    """Refuse a case in which something switches.

    Raises:
        ConfigError: it does; the message names it.
    """
    switching = [name for name in _SWITCHING if getattr(case, name) is not None]
    for name in ("axles", "rollers", "vehicle") if case.sampled else ():
        sensor = getattr(case.sensors, name)
        if sensor is not None and getattr(sensor, "counts", 1.0) > 0.0:
            switching.append(f"sensors.{name}")
    for name in ("axle_load", "roller_torque") if case.sampled else ():
        sensor = getattr(case.sensors, name)
        if sensor is not None and sensor.resolution > 0.0:
            switching.append(f"sensors.{name}")
    allowed = "allowed: a case without it: what switches or counts has no derivative"
    problems = [ConfigProblem(case.name, name, "switches, or counts", allowed) for name in switching]
    if case.rig_control is not None and (case.rig_control.user or case.rig_control.fmu):
        allowed = "allowed: a controller of the core"
        problems.append(ConfigProblem(case.name, "rig_control", "is another program", allowed))
    if problems:
        raise ConfigError(problems)


def with_fine_steps(case: Case) -> Case:
    """The case with the method, steps and tolerances of derivatives; finer ones of its own stay."""
    time, own = case.time, case.integration
    step = own.step if own.method == METHOD else time.sampling_step if case.sampled else STEP
    assert step is not None
    step /= math.ceil(step / STEP - 1e-9)  # a whole part of the sampling step stays one
    return case.with_changes({
        "time.method": METHOD,
        "time.step": min(step, time.duration),
        "time.relative_tolerance": min(time.relative_tolerance, RELATIVE_TOLERANCE),
        "time.absolute_tolerance": min(time.absolute_tolerance, ABSOLUTE_TOLERANCE),
    })  # fmt: skip


def _number_at(tables: Mapping[str, Any], path: Sequence[str], key: str, file: str) -> float:
    found = value_in(tables, path)
    if isinstance(found, bool) or not isinstance(found, int | float):
        shown = "there is no such number" if found is None else "is no number"
        raise ConfigError.of(file, key, shown, "allowed: keys of numbers; `rollerrig explain` lists them")
    return float(found)


def _changed_runs(
    model: AssembledModel, key: str, value: float
) -> tuple[_core.Simulation, _core.Simulation, float, bool]:
    """Runs with the number above and below its own, half their difference, and whether contact forces depend on the number."""

    def changed(number: float) -> _core.Simulation:
        one = assemble_as_run(changed_case(model.case, key, number))
        if model.breakpoints != one.breakpoints:
            allowed = "allowed: numbers that move no corner in time of a torque or speed"
            raise ConfigError.of(model.case.name, key, "moves one", allowed)
        return prepare(one, allow_unrestrained=True)

    width = RELATIVE_WIDTH * abs(value)
    return changed(value + width), changed(value - width), width, _BESIDE_CONTACTS.fullmatch(key) is None


def _layout(model: AssembledModel, width: int, outputs: Sequence[str]) -> xr.Dataset:
    """The outputs at one time, of which each value is its place in a row.

    Raises:
        ValueError: there is no such output.
    """
    nothing = Outcome("ok", "", 0.0, "", {}, {})
    every = run_draft(model, np.zeros(1), np.arange(float(width))[np.newaxis], nothing).dataset()
    for name in outputs:
        if name not in every:
            names = tuple(str(one) for one in every)
            raise ValueError(f"outputs: '{name}'; did you mean '{nearest(name, names)}'? {one_of(sorted(names))}")
    return every[list(outputs)].isel(time=0, drop=True)


def _dataset(
    layout: xr.Dataset, times: Array, kept: NDArray[np.intp], rows: Array, parameters: Sequence[str] = ()
) -> xr.Dataset:
    """The kept columns of rows as the outputs of a layout: of shape (time, column), or (parameter, time, column)."""
    leading = ("parameter", "time") if rows.ndim == 3 else ("time",)
    suffix = " per unit of the parameter" if parameters else ""
    variables = {
        str(name): (
            (*leading, *one.dims),
            rows[..., np.searchsorted(kept, one.values)],
            {"units": one.attrs["units"] + suffix, "long_name": one.attrs["long_name"]},
        )
        for name, one in layout.items()
    }
    filled = xr.Dataset(variables, layout.coords)
    filled = filled.assign_coords(time=("time", times, {"units": "s", "long_name": "time since the start"}))
    if rows.ndim == 3:
        units = [unit_of(key) for key in parameters]
        filled = filled.assign_coords(parameter=list(parameters), parameter_unit=("parameter", units))
    return filled
