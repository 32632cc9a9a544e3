"""What a fit runs: measured columns, what the model gives in their place, and the search over free numbers of the case.

    Record, case -> [MODELS] -> values of each channel at its abscissa -> [search] -> Found: estimate, values, errors

A log is one of four kinds: signals of a run or pressure of a cylinder over time, hunting over speed, traction over creepage.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.analysis.estimation import Estimate, estimate, widening
from rollerrig.analysis.signals import low_pass
from rollerrig.assembly.actuators import pneumatics
from rollerrig.assembly.laws import core_law
from rollerrig.common.arrays import Array
from rollerrig.config import Case, ConfigError, ConfigProblem, case_from_toml
from rollerrig.config.errors import show_value
from rollerrig.config.load.fit import FreeKeyNumber, WholeFit
from rollerrig.contact_analysis.static_contact import contact
from rollerrig.contact_analysis.traction_curve import LoadedWheel, traction_coefficient
from rollerrig.results import COMPLETED
from rollerrig.results.other_formats import table_columns
from rollerrig.simulation.run import simulate
from rollerrig.study.jobs import Progress, whole_modes, whole_run

STEP = 1e-3
"""Step of the differences, over the range of a free number."""
WORSE = 1e6
"""Deviation that stands for a run that left the validity of its model: the search turns back."""
REWEIGHTINGS, SETTLED = 4, 0.02
"""How often standard deviations that are not known are found anew, and the change at which that ends."""

Values = list[list[Array]]
"""Values at the abscissa of each record, a list of channels in a list of records."""


@dataclass(frozen=True, eq=False)
class Channel:
    """One measured column.

    Attributes:
        of: output of the model.
        unit: SI unit of it.
        measured: values at the abscissa of the record.
        error: standard deviation of each value; NaN: not known.
        fitted: whether a value is fitted to; those held back are not.
        low_pass: cut-off of the measurement's filter [Hz]; None: none.
        any_offset: whether only changes count.
    """

    of: str
    unit: str
    measured: Array
    error: Array
    fitted: Array
    low_pass: float | None = None
    any_offset: bool = False

    def counted(self, values: Array) -> Array:
        """What counts of a deviation, or of its derivative: all but the mean where only changes do."""
        return values - values[self.fitted].mean() if self.any_offset else values


@dataclass(frozen=True, eq=False)
class Record:
    """One log and the case that is to reproduce it.

    Attributes:
        file: the log.
        case: with its changes, starts and inputs.
        kind: run, brake_unit, modes or creep.
        x: abscissa: time from the begin of the run [s], speed [m/s], or creepage [-].
        channels: what is compared.
        a_over_b: shape of the contact patch of a creep log; None: that of the case.
        valve: commands of the dump valve at the rows of a log of a brake unit.
    """

    file: str
    case: Case
    kind: str
    x: Array
    channels: tuple[Channel, ...]
    a_over_b: float | None = None
    valve: Array | None = None


class UnusableRunError(RuntimeError):
    """A run that left the validity of its model."""


def _columns(run: xr.Dataset) -> dict[str, tuple[str, Array]]:
    """Output -> unit, values over the run's time."""
    split = ((heading.partition(" ["), values) for heading, values in table_columns(run).items())
    return {name: (unit.rstrip("]") or "1", values) for (name, _, unit), values in split}


def _run_outputs(case: Case) -> dict[str, str]:
    """Those of a run of one step."""
    run = simulate(case.with_changes({"time.duration": f"{case.time.output_step!r} s"}))
    return {name: unit for name, (unit, _) in _columns(run).items() if name != "time"}


def _run_values(record: Record, case: Case) -> list[Array]:
    run = whole_run(case)
    if run.attrs["status"] not in COMPLETED or float(run["time"][-1]) < record.x[-1]:
        raise UnusableRunError(f"{record.file}: {run.attrs['status_message']}")
    return _sampled(record, run)


def _sampled(record: Record, run: xr.Dataset) -> list[Array]:
    """What a run, or its derivative by a number, has at the rows of a log: filtered as the measurement."""
    from scipy.interpolate import CubicSpline

    names = {channel.of.rpartition(".")[2] for channel in record.channels}
    columns, time = _columns(run[list(names)]), run["time"].to_numpy()
    found = []
    for channel in record.channels:
        values = columns[channel.of][1]
        if channel.low_pass is not None:
            signal = xr.DataArray(values, coords={"time": time}, dims="time")
            values = low_pass(signal, channel.low_pass).to_numpy()
        found.append(np.asarray(CubicSpline(time, values)(record.x)))
    return found


def _brake_unit_values(record: Record, case: Case) -> list[Array]:
    """Pressure of one cylinder that is empty at the begin, at the sampling steps of the case."""
    brake, step = case.brake, case.time.sampling_step
    if brake is None or record.valve is None:
        raise UnusableRunError(f"{record.file}: no brake")
    unit = _core.BrakeUnit(pneumatics=pneumatics(brake), reservoir=[], relay_valve=[])
    sampling = _core.Sampling(every=1, delay=0, external=False)
    controller = _core.SampledController(sampling=sampling, controller=unit)
    still: dict[str, Any] = {"axles": ["axle"], "train_speed": 0.0, "axle_speed": [0.0], "roller_speed": [0.0]}
    plant = _core.ControllerPlant(_core.ControllerPart(name=case.name, step=step, controller=controller, **still))
    plant.start()
    place = {variable.name: k for k, variable in enumerate(plant.variables)}
    time = step * np.arange(math.ceil(record.x[-1] / step) + 2)
    row = np.searchsorted(record.x, time + 0.01 * step, side="right") - 1
    demand = np.interp(time, *np.transpose(brake.demand))
    pressure = np.zeros_like(time)
    for k, command in enumerate(record.valve[np.maximum(row[:-1], 0)]):
        plant.set_input(place["axle.dump_valve"], command)
        plant.set_input(place["axle.brake_demand"], demand[k])
        plant.advance(time[k + 1])
        pressure[k + 1] = plant.get(place["axle.cylinder_pressure_command"])
    return _sampled(record, xr.Dataset({"cylinder_pressure": ("time", pressure, {"units": "Pa"})}, {"time": time}))


def _modes_values(record: Record, case: Case) -> list[Array]:
    speeds, row = np.unique(record.x, return_inverse=True)  # a speed may be measured twice, in any order
    modes = whole_modes(case, (3.6 * speeds).tolist())
    found = [modes[channel.of].to_numpy()[row] for channel in record.channels]
    if not np.isfinite(found).all():
        raise UnusableRunError(f"{record.file}: there is no hunting mode at some of its speeds")
    return found


def _creep_values(record: Record, case: Case) -> list[Array]:
    material, rail = case.contact.material, case.adhesion.rail if case.adhesion else None
    load, a_over_b = _at_rest(record.case.to_toml())
    wheel = LoadedWheel(
        radius=case.vehicle.data.wheel.radius,
        load=load,
        speed=case.motion.speed,
        a_over_b=record.a_over_b or a_over_b,
        shear_modulus=material.shear_modulus,
        poisson_ratio=material.poisson_ratio,
    )
    friction = core_law(rail.friction if rail else case.contact.friction)
    reduction = (rail.k_A, rail.k_S) if rail else None
    return [traction_coefficient(wheel, record.x, friction, core_law(case.contact.creep), reduction)]


@lru_cache(maxsize=8)
def _at_rest(case: str) -> tuple[float, float]:
    """Load of the leading left wheel [N], and a/b of its largest patch, of a case as TOML."""
    table = contact(case_from_toml(case, allow_code=True), [(0.0, 0.0)])
    left = table.isel(row=(table["side"] == "left").to_numpy())
    patch = left.isel(row=int(np.argmax(left["normal"].to_numpy())))
    return float(left["normal"].sum()), float(patch["a"] / patch["b"])


@dataclass(frozen=True)
class Model:
    """What logs of a kind are compared with.

    Attributes:
        abscissa: what it is called, and its unit.
        outputs: case -> output -> unit.
        values: record, case -> values of each channel at the abscissa.
    """

    abscissa: tuple[str, str]
    outputs: Callable[[Case], Mapping[str, str]]
    values: Callable[[Record, Case], list[Array]]


MODELS: Mapping[str, Model] = {
    "run": Model(("time", "s"), _run_outputs, _run_values),
    "brake_unit": Model(("time", "s"), lambda _: {"cylinder_pressure": "Pa"}, _brake_unit_values),
    "modes": Model(("speed", "m/s"), lambda _: {"hunting_frequency": "Hz", "hunting_damping": "1"}, _modes_values),
    "creep": Model(("creepage", "1"), lambda _: {"traction_coefficient": "1"}, _creep_values),
}
"""Kind of a log -> what it is compared with."""
OVER_TIME = tuple(kind for kind, model in MODELS.items() if model.abscissa[0] == "time")
"""Kinds whose residuals may follow each other."""


@dataclass(frozen=True, eq=False)
class Found:
    """Where a search ended: the numbers, values of the model at all rows, standard deviations as they were used."""

    estimate: Estimate
    values: Values
    errors: Values


class _Comparison:
    """Records and their model over the free numbers; each set of values is run once."""

    def __init__(self, free: Sequence[FreeKeyNumber], records: Sequence[Record], progress: Progress | None) -> None:
        self._free, self._records, self._progress = free, records, progress
        self._seen: dict[bytes, Values] = {}
        self.points = sum(int(one.fitted.sum()) for record in records for one in record.channels)
        self.errors = [[_first_error(channel) for channel in record.channels] for record in records]

    def values(self, at: Array) -> Values:
        """What the model gives."""
        if at.tobytes() not in self._seen:
            changes = {one.key: one.quantity.as_written(float(v)) for one, v in zip(self._free, at, strict=True)}
            runs = [MODELS[one.kind].values(one, one.case.with_changes(changes)) for one in self._records]
            self._seen[at.tobytes()] = runs
            if self._progress is not None:
                self._progress(1.0 - 1.0 / (1.0 + 0.01 * len(self._seen)), f"evaluation {len(self._seen)}")
        return self._seen[at.tobytes()]

    def residuals(self, at: Array) -> Array:
        """Residuals of all channels, over their standard deviations; large where a run is unusable."""
        try:
            found = self.values(at)
        except (UnusableRunError, ConfigError):
            return np.full(self.points, WORSE)
        return self._stacked(found, measured=True)

    def jacobian(self, at: Array) -> Array:
        """Derivatives of the residuals by the free numbers, shape (points, free)."""
        return np.stack([self._stacked(one) for one in differences(self.values, at, self._free)], axis=1)

    def _stacked(self, found: Values, *, measured: bool = False) -> Array:
        rows = [
            (channel.counted(values - channel.measured if measured else values) / error)[channel.fitted]
            for values, channel, error in self._channels(found)
        ]
        return np.concatenate(rows)

    def widenings(self, residuals: Array) -> Array:
        """Factor of each residual on its standard deviation: those of a run follow each other."""
        channels = [(record.kind, one.fitted.sum()) for record in self._records for one in record.channels]
        series = np.split(residuals, np.cumsum([count for _, count in channels])[:-1])
        fitted = len(self._free)
        factors = [
            widening(one, fitted) if kind in OVER_TIME else 1.0 for (kind, _), one in zip(channels, series, strict=True)
        ]
        return np.repeat(factors, [count for _, count in channels])

    def _channels(self, found: Values) -> Iterable[tuple[Array, Channel, Array]]:
        for own, record, errors in zip(found, self._records, self.errors, strict=True):
            yield from zip(own, record.channels, errors, strict=True)

    def reweight(self, at: Array) -> float:
        """Take unknown standard deviations from what is left; the largest change of one, over itself."""
        change = 0.0
        for values, channel, error in self._channels(self.values(at)):
            if np.isnan(channel.error).any():
                left = channel.counted(values - channel.measured)[channel.fitted]
                size = math.sqrt(np.mean(left**2) / max(1.0 - len(self._free) / self.points, 1e-3)) or 1e-300
                change = max(change, abs(size / float(error[0]) - 1.0))
                error[:] = size
        return change


def _first_error(channel: Channel) -> Array:
    known = np.isfinite(channel.error).all()
    return channel.error if known else np.full(len(channel.error), np.std(channel.measured) or 1.0)


def differences(function: Callable[[Array], Values], at: Array, free: Sequence[FreeKeyNumber]) -> list[Values]:
    """Derivatives of what a function gives by each free number, by differences: central where both sides can be run.

    Raises:
        UnusableRunError: neither side can be run.
    """
    found = []
    for k, one in enumerate(free):
        step = STEP * min(one.most - one.least, abs(at[k]) if one.logarithmic else math.inf)
        sides: list[tuple[float, Values]] = []
        reason: Exception | None = None
        for end in (min(one.most, at[k] + step), max(one.least, at[k] - step), at[k]):
            try:
                if len(sides) < 2 and all(end != other for other, _ in sides):
                    sides.append((end, function(np.array([*at[:k], end, *at[k + 1 :]]))))
            except (UnusableRunError, ConfigError) as error:
                reason = error
        if len(sides) < 2:
            raise UnusableRunError(f"no run about {one.key} = {at[k]:g} {one.quantity.unit}: {reason}")
        (above, high), (below, low) = sides
        pairs = [zip(*pair, strict=True) for pair in zip(high, low, strict=True)]
        found.append([[(a - b) / (above - below) for a, b in pair] for pair in pairs])
    return found


def search(
    whole: WholeFit, records: Sequence[Record], start: Sequence[float], progress: Progress | None = None
) -> Found:
    """Fit from one start.

    Raises:
        ConfigError: a free key changes nothing that is compared.
        RuntimeError: the start itself leaves the validity of the model.
        KeyboardInterrupt: Ctrl-C.
    """
    comparison, at, free = _Comparison(whole.free, records, progress), np.array(start, dtype=float), whole.free
    slopes = comparison.jacobian(at) * [one.slope(float(v)) for one, v in zip(free, at, strict=True)]
    size = np.abs(slopes).max(axis=0)
    idle = [k for k, one in enumerate(free) if one.prior is None and size[k] <= 1e-9 * max(size.max(), 1e-300)]
    if idle:
        allowed = "allowed: keys that some output depends on; it changes none of those that are compared"
        raise ConfigError([ConfigProblem(whole.file, f"free[{k}].key", show_value(free[k].key), allowed) for k in idle])
    known = all(np.isfinite(channel.error).all() for record in records for channel in record.channels)
    for _ in range(1 if known else REWEIGHTINGS):
        found = estimate(
            free,
            comparison.residuals,
            at,
            jacobian=comparison.jacobian,
            loss=whole.plan.loss,
            known=known,
            widenings=comparison.widenings,
        )
        at = np.array(list(found.values.values()))
        if known or comparison.reweight(at) < SETTLED:
            break
    return Found(found, comparison.values(at), comparison.errors)


def starts(whole: WholeFit) -> list[tuple[float, ...]]:
    """Where the searches begin: at the case's own values, then spread over the ranges."""
    from scipy.stats import qmc

    spread = qmc.LatinHypercube(len(whole.free), seed=np.random.default_rng(whole.plan.seed)).random(whole.plan.starts)
    others = [tuple(one.value(float(u)) for one, u in zip(whole.free, row, strict=True)) for row in spread]
    return [tuple(one.start for one in whole.free), *others[1:]]
