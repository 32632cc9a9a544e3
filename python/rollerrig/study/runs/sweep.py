"""What is run in a sweep: values of the varied keys by case, all numbers as a Dataset, statistics of each number.

WholePlan -> [Points] -> number of a case -> dotted key -> value; records -> [sweep_dataset] -> [statistics]

Samples are points of the unit cube, the same for the same seed; a distribution turns each coordinate into a value.
Source of the samples for Sobol indices: A. Saltelli et al., Comput. Phys. Commun. 181 (2010) 259.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from rollerrig import __version__
from rollerrig.analysis.distributions import quantile_function
from rollerrig.common.arrays import Array
from rollerrig.config import ConfigError, ConfigProblem, Plan, WholePlan
from rollerrig.config.errors import show_value
from rollerrig.config.load.plan import numbers_below
from rollerrig.config.schema.plan import Lognormal, Normal, Variation
from rollerrig.config.schema.units import Quantity
from rollerrig.results import variable
from rollerrig.study.ensemble import Estimate, estimate

_EDGE = 1e-12
"""Samples keep away from the ends of a distribution by this much probability."""


@dataclass(frozen=True)
class Axis:
    """One thing that is varied.

    Attributes:
        name: in results.
        key: dotted key of the case.
        quantity: at the key; None where words or lists stand.
        values: all of them, of a list or range; empty for samples of a distribution.
        quantile: probability -> value, of samples.
    """

    name: str
    key: str
    quantity: Quantity | None
    values: tuple[Any, ...] = ()
    quantile: Callable[[Array], Array] | None = None

    @property
    def unit(self) -> str:
        """Unit of its values; '' where they are no numbers."""
        return self.quantity.unit if self.is_number and self.quantity else ""

    @property
    def is_number(self) -> bool:
        """Whether its values are numbers."""
        return self.quantile is not None or all(
            isinstance(v, int | float) and not isinstance(v, bool) for v in self.values
        )

    def at(self, probability: Array) -> list[Any]:
        """Values at probabilities, shape (case,)."""
        if self.quantile is not None:
            return [float(value) for value in self.quantile(np.clip(probability, _EDGE, 1.0 - _EDGE))]
        return [self.values[min(int(p * len(self.values)), len(self.values) - 1)] for p in probability]

    def written(self, value: Any) -> Any:
        """A value as a file holds it."""
        number = isinstance(value, float) and self.quantity is not None
        return self.quantity.as_written(value) if number and self.quantity else value


def number_of_cases(plan: Plan) -> int:
    """How many cases a plan has, before any value is made."""
    lengths = [len(one.values) if one.values is not None else one.count or 0 for one in plan.vary]
    match plan.design.kind:
        case "grid":
            return math.prod(lengths)
        case "list":
            return lengths[0]
        case "saltelli":
            return (plan.design.samples or 0) * (len(lengths) + 2)
    return plan.design.samples or 0


class Points:
    """All cases of a plan; sized like a list."""

    def __init__(self, whole: WholePlan) -> None:
        """Find the axes.

        Raises:
            ConfigError: a value that does not fit its key, a range or distribution without values, lists of different lengths.
        """
        self.design, self._count = whole.plan.design, number_of_cases(whole.plan)
        self.axes: list[Axis] = []
        problems: list[ConfigProblem] = []
        for number, (variation, quantity) in enumerate(zip(whole.plan.vary, whole.quantities, strict=True)):
            try:
                self.axes.append(_axis(variation, quantity, whole, f"vary[{number}]"))
            except ConfigError as error:
                problems += error.problems
        lengths = {axis.name: len(axis.values) for axis in self.axes}
        if not problems and self.design.kind == "list" and len(set(lengths.values())) > 1:
            found = ", ".join(f"{name} {count}" for name, count in lengths.items())
            problems.append(ConfigProblem(whole.file, "vary", found, "needed by a list: as many values of each"))
        if problems:
            raise ConfigError(problems)

    def __len__(self) -> int:
        """Number of cases."""
        return self._count

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a grid."""
        return tuple(len(axis.values) for axis in self.axes)

    @cached_property
    def columns(self) -> list[list[Any]]:
        """Values of each axis over all cases."""
        if self.design.kind == "grid":
            places = np.unravel_index(np.arange(len(self)), self.shape)
            return [[axis.values[i] for i in place] for axis, place in zip(self.axes, places, strict=True)]
        if self.design.kind == "list":
            return [list(axis.values) for axis in self.axes]
        cube = self._cube()
        return [axis.at(cube[:, k]) for k, axis in enumerate(self.axes)]

    def changes(self) -> Iterator[dict[str, Any]]:
        """Changes of each case: dotted key -> value as a file holds it."""
        keys = [axis.key for axis in self.axes]
        for values in zip(*self.columns, strict=True):
            yield {k: axis.written(v) for k, axis, v in zip(keys, self.axes, values, strict=True)}

    def _cube(self) -> Array:
        """Samples of the unit cube, shape (case, axis)."""
        from scipy.stats import qmc

        count, width = self.design.samples or 0, len(self.axes)
        generator = np.random.default_rng(self.design.seed)
        match self.design.kind:
            case "random":
                return generator.random((count, width))
            case "latin_hypercube":
                return np.asarray(qmc.LatinHypercube(width, seed=generator).random(count))
            case "sobol":
                return np.asarray(qmc.Sobol(width, seed=generator).random(count))
        both = np.asarray(qmc.Sobol(2 * width, seed=generator).random(count))
        a, b = both[:, :width], both[:, width:]
        blocks = np.repeat(a[:, None, :], width + 2, axis=1)  # A, A with one column of B after the other, B
        for k in range(width):
            blocks[:, k + 1, k] = b[:, k]
        blocks[:, -1] = b
        return blocks.reshape(-1, width)


def _axis(variation: Variation, quantity: Quantity | None, whole: WholePlan, at: str) -> Axis:
    """One axis from its table; a ConfigError where a value does not fit its key, or range or distribution have none."""
    file, design = whole.file, whole.plan.design
    reader = _Reader(file, at, quantity)
    if variation.values is not None:
        values = tuple(reader.one(f"values[{number}]", value) for number, value in enumerate(variation.values))
        _try_out(whole, variation, values, at)
        return Axis(variation.label, variation.key, quantity, values)
    if quantity is None:
        below = numbers_below(whole.case, variation.key)
        hint = f"; its numbers are {', '.join(below)}" if below else ""
        needed = f"needed: `values`; this key holds no number, which alone has a range{hint}"
        raise reader.problem("key", variation.key, needed)
    in_grid = design.kind in ("grid", "list")
    if in_grid and (variation.distribution is not None or variation.count is None):
        needed = f"needed in a {design.kind}: `values`, or `least`, `most` and `count`"
        raise reader.problem("distribution" if variation.distribution else "count", "missing", needed)
    if not in_grid and variation.count is not None:
        raise reader.problem("count", variation.count, "allowed: in a grid or list; samples have [design] samples")
    ends = (("least", variation.least), ("most", variation.most))
    least, most = (None if value is None else reader.one(key, value) for key, value in ends)
    if least is not None and most is not None and not least < most:
        raise reader.problem("most", variation.most, f"allowed: more than `least`, {variation.least}")
    if variation.scale == "logarithmic" and not (least is not None and least > 0.0):
        raise reader.problem("scale", "logarithmic", "allowed: with a positive `least`")
    if variation.count is not None and least is not None and most is not None:
        space = np.geomspace if variation.scale == "logarithmic" else np.linspace
        values = tuple(float(f"{v:.12g}") for v in space(least, most, variation.count))
        _try_out(whole, variation, (values[0], values[-1]), at)
        return Axis(variation.label, variation.key, quantity, values)
    spread = variation.distribution
    numbers = {
        key: reader.any(f"distribution.{key}", value)
        for key in ("mean", "deviation", "median", "mode")
        if spread is not None and (value := getattr(spread, key, None)) is not None
        and not (isinstance(spread, Lognormal) and key == "deviation")
    }  # fmt: skip
    if isinstance(spread, Lognormal):
        numbers["deviation"] = spread.deviation
    for key in ("deviation",) if isinstance(spread, Normal) else ("median",) if isinstance(spread, Lognormal) else ():
        if not numbers[key] > 0.0:
            raise reader.problem(f"distribution.{key}", getattr(spread, key), "allowed: positive")
    try:
        quantile, tried = quantile_function(spread.kind if spread else variation.scale, numbers, least, most, quantity)
    except ValueError as error:
        raise reader.problem("distribution", spread.kind if spread else "range", str(error)) from None
    _try_out(whole, variation, tried, at)
    return Axis(variation.label, variation.key, quantity, (), quantile)


class _Reader:
    """Values of one table of a plan, in SI."""

    def __init__(self, file: str, at: str, quantity: Quantity | None) -> None:
        self._file, self._at, self._quantity = file, at, quantity

    def problem(self, key: str, value: object, allowed: str) -> ConfigError:
        """One mistake."""
        shown = value if isinstance(value, str) else show_value(value)
        return ConfigError.of(self._file, f"{self._at}.{key}", shown, allowed)

    def one(self, key: str, value: Any) -> Any:
        """A value that the key may have; words and lists as they are."""
        if self._quantity is None or not isinstance(value, int | float | str) or isinstance(value, bool):
            return value
        try:
            return self._quantity.parse(value)
        except ValueError as error:
            raise self.problem(key, show_value(value), str(error)) from None

    def any(self, key: str, value: Any) -> float:
        """A number in the unit of the key, beyond its range too."""
        assert self._quantity is not None
        try:
            return Quantity(self._quantity.unit, -1e300, 1e300).parse(value)
        except ValueError:
            allowed = self._quantity.allowed.split(", from ")[0]
            raise self.problem(key, show_value(value), allowed) from None


def _try_out(whole: WholePlan, variation: Variation, values: Sequence[Any], at: str) -> None:
    """Refuse values that the case itself refuses at this key; what only some combinations make wrong fails as a case."""
    tried = [values[0], values[-1]] if all(isinstance(v, int | float) for v in values) else values
    quantity = whole.quantities[whole.plan.vary.index(variation)]
    for value in tried:
        written = quantity.as_written(value) if quantity and isinstance(value, float) else value
        try:
            whole.case.with_changes({variation.key: written})
        except ConfigError as error:
            last, place = variation.key.split(".")[-1], (whole.file, f"{at}.values")
            own = [p for p in error.problems if p.key.split(".")[-1] == last]
            if own:
                raise ConfigError([ConfigProblem(*place, p.value, p.allowed, p.hint) for p in own]) from None


FAILED = "failed"
SAMPLE = "sample"
Record = dict[str, Any]
"""Record of a case: its changes, its numbers, why it failed."""


def sweep_dataset(
    whole: WholePlan, points: Points, records: Sequence[Record | None], units: Mapping[str, tuple[str, str]]
) -> xr.Dataset:
    """The varied keys as coordinates in SI, each number with its unit and meaning, `failed` with the reason of each failed case.

    Numbers of cases that failed, or were not reached (record None), are NaN. Attributes: cases, finished, failed, plan, case,
    design.
    """
    grid = points.design.kind == "grid"
    dims = tuple(axis.name for axis in points.axes) if grid else (SAMPLE,)
    shape = points.shape if grid else (len(points),)
    coordinates: dict[str, Any] = {
        axis.name: _coordinate(axis, axis.values if grid else column, axis.name if grid else SAMPLE)
        for axis, column in zip(points.axes, points.columns, strict=True)
    }
    variables: dict[str, Any] = {}
    for name, (unit, meaning) in units.items():
        values = [math.nan if one is None else one["numbers"].get(name, math.nan) for one in records]
        variables[name] = variable(dims, np.array(values, dtype=np.float64).reshape(shape), unit, meaning)
    reasons = ["" if one is None else one[FAILED] for one in records]
    variables[FAILED] = variable(dims, np.array(reasons, dtype=object).reshape(shape), "", "why a case failed")
    failed = sum(bool(reason) for reason in reasons)
    names = {"title": f"Sweep {whole.plan.name}", "plan": whole.plan.name, "case": whole.case.name}
    finished = sum(one is not None for one in records) - failed
    counts = {"design": points.design.kind, "cases": len(points), "finished": finished, "failed": failed}
    origin = {"config_toml": whole.case.to_toml(), "rollerrig_version": __version__}
    return xr.Dataset(variables, coordinates, {**names, **counts, **origin})


def _coordinate(axis: Axis, values: Sequence[Any], dim: str) -> Any:
    kept = np.array(values, dtype=np.float64) if axis.is_number else np.array([_text(v) for v in values], dtype=object)
    return variable(dim, kept, axis.unit, axis.key)


def _text(value: Any) -> str:
    return ("true" if value else "false") if isinstance(value, bool) else str(value)


QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
FIFTH = 0.2
LEAST_SAMPLES = 8
"""Fewer whole samples give no Sobol index."""


def statistics(data: xr.Dataset, points: Points) -> dict[str, dict[str, Any]]:
    """Number of a sweep -> its statistics, as summary.json has them: `numbers.*` of its quantities.

    Samples have `quantiles`, a design `saltelli` has `sobol`; `tornado` has the keys that are numbers, `words` the others.
    """
    found = {}
    sampled = points.design.kind not in ("grid", "list")
    for name in (str(name) for name in data.data_vars if name != FAILED):
        values = data[name].to_numpy().ravel()
        known = values[np.isfinite(values)]
        least, median, most = (float(f(known)) if known.size else math.nan for f in (np.min, np.median, np.max))
        tables: dict[str, Any] = {
            "tornado": {
                axis.name: _ends(np.asarray(column, dtype=np.float64), values, sampled=sampled)
                for axis, column in zip(points.axes, points.columns, strict=True)
                if axis.is_number
            },
            "words": _by_word(values, points),
            "quantiles": {f"{100 * q:g} %": quantile(known, q) for q in QUANTILES if sampled and known.size},
        }
        if points.design.kind == "saltelli":
            tables["sobol"] = sobol_indices(values, [axis.name for axis in points.axes])
        kept = {key: table for key, table in tables.items() if table or key == "tornado"}
        found[name] = {"unit": data[name].attrs["units"], "least": least, "median": median, "largest": most, **kept}
    return found


def _by_word(values: Array, points: Points) -> dict[str, dict[str, dict[str, float]]]:
    """Means of a number by varied key and word, each with the mean difference to the first word and its interval.

    Differences are of cases in pairs, alike in all other varied keys, which only a grid has; the interval of 95 % takes the pairs
    for draws of what else is varied. NaN where there is nothing, or one pair.
    """
    found: dict[str, dict[str, dict[str, float]]] = {}
    for k, axis in enumerate(points.axes):
        if points.design.kind != "grid" or not all(isinstance(value, str | bool) for value in axis.values):
            continue
        rows = np.moveaxis(values.reshape(points.shape), k, 0).reshape(len(axis.values), -1)
        found[axis.name] = {}
        for word, row in zip(axis.values, rows, strict=True):
            known, pairs = row[np.isfinite(row)], (row - rows[0])[np.isfinite(row - rows[0])]
            change = estimate(pairs.tolist()) if pairs.size else Estimate(math.nan, math.nan, 0.0)
            ends = {name: end if math.isfinite(end) else math.nan for name, end in vars(change.interval).items()}
            mean = float(known.mean()) if known.size else math.nan
            found[axis.name][str(word).lower() if isinstance(word, bool) else word] = {
                "mean": mean,
                "change": change.mean,
                **ends,
            }
    return found


def quantile(values: Array, share: float) -> dict[str, float]:
    """A quantile of independent samples, with its interval of 95 % by order statistics; NaN: an end that so few do not have."""
    from scipy.stats import quantile_test

    low, high = np.asarray(quantile_test(values, p=share).confidence_interval(0.95)).tolist()
    return {"value": float(np.quantile(values, share)), "low": low, "high": high}


def _ends(column: Array, values: Array, *, sampled: bool) -> dict[str, float]:
    """Mean of a number where a varied key is low, and where it is high."""
    low, high = np.quantile(column, (FIFTH, 1.0 - FIFTH)) if sampled else (column.min(), column.max())
    parts = {"low": values[column <= low], "high": values[column >= high]}
    return {end: float(np.nanmean(part)) if np.isfinite(part).any() else math.nan for end, part in parts.items()}


def sobol_indices(values: Array, names: list[str], seed: int = 1) -> dict[str, dict[str, float]]:
    """First-order and total Sobol indices with half of their intervals of 95 %.

    Args:
        values: of the cases of a design `saltelli`, in its order, shape (samples * (names + 2),); NaN where one failed.
        names: of what is varied.
        seed: of the bootstrap.

    Returns:
        Name -> first, first_confidence, total, total_confidence; nothing where SALib is not installed, the number does not vary,
        or fewer than LEAST_SAMPLES samples are whole.
    """
    try:
        from SALib.analyze import sobol
    except ImportError:
        return {}
    blocks = values.reshape(-1, len(names) + 2)
    whole = blocks[np.isfinite(blocks).all(axis=1)]
    if len(whole) < LEAST_SAMPLES or not np.ptp(whole) > 0.0:
        return {}
    problem = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
    found = sobol.analyze(problem, whole.ravel(), calc_second_order=False, seed=seed)
    keys = {"first": "S1", "first_confidence": "S1_conf", "total": "ST", "total_confidence": "ST_conf"}
    return {name: {key: float(found[own][k]) for key, own in keys.items()} for k, name in enumerate(names)}
