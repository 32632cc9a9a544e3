"""Results of a scaled model as they stand for at full scale: every variable times the factor of its unit.

Dataset of a scaled case -> [map_back] -> Dataset at full scale
"""

from __future__ import annotations

import json
from typing import Any

import xarray as xr

from rollerrig.config import ConfigError, ConfigProblem
from rollerrig.results.run_info import ATTRIBUTE, RunInfo
from rollerrig.similitude.factors import Similitude

_SUFFIXES = {"_s": "s", "_m": "m", "_j": "J", "_kmh": "m/s", "_mps": "m/s", "_hz": "Hz", "_n": "N", "_per_s": "1/s"}
"""Endings of attributes and JSON keys that carry their unit in the name; the longest that fits counts."""


def map_back(run: xr.Dataset) -> xr.Dataset:
    """A run, or modes over speed, of a scaled case at full scale.

    Args:
        run: results of a scaled case; variables with `units`.

    Returns:
        The same names and units, also in the metadata (`RunInfo`): those of what the model stands for, where gravity that was
        kept is another one at full scale. The attribute `config_toml` still holds the model's own case.

    Raises:
        ConfigError: the case is no model of another one.
        ValueError: no metadata.
        UnknownUnitError: a variable has a unit that is not made of kg, m and s.
    """
    info = RunInfo.of(run)
    record = info.scaled_from
    if record is None:
        needed = "needed: a case made by `rollerrig scale`"
        raise ConfigError([ConfigProblem(info.case, "similitude", "missing", needed)])
    factors = Similitude(record.length, record.time, record.density)
    scaled = {name: _mapped(variable, factors) for name, variable in run.variables.items()}
    coordinates = {name: scaled.pop(name) for name in run.coords}
    mapped = xr.Dataset(scaled, coordinates)
    attributes = {str(key): _attribute(str(key), value, factors) for key, value in run.attrs.items()}
    of = f"{record.case} by a 1:{record.length:g} model, {record.strategy}"
    return mapped.assign_attrs({**attributes, ATTRIBUTE: info.mapped(factors.factor).to_json(), "mapped_back": of})


def _mapped(variable: xr.Variable, factors: Similitude) -> xr.Variable:
    unit = variable.attrs.get("units")
    if unit is None:
        return variable
    return xr.Variable(variable.dims, factors.factor(str(unit)) * variable.to_numpy(), variable.attrs)


def _attribute(key: str, value: Any, factors: Similitude) -> Any:
    """An attribute, JSON included, mapped by the unit in its name."""
    if isinstance(value, str) and value[:1] in "[{" and key in ("crossings", "diverging", "contact_losses"):
        return json.dumps(_inside(json.loads(value), factors))
    return _number(key, value, factors)


def _inside(value: Any, factors: Similitude) -> Any:
    if isinstance(value, list):
        return [_inside(item, factors) for item in value]
    if isinstance(value, dict):
        return {key: _number(key, item, factors) for key, item in value.items()}
    return value


def _number(key: str, value: Any, factors: Similitude) -> Any:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    suffix = max((end for end in _SUFFIXES if key.endswith(end)), key=len, default=None)
    return value if suffix is None else value * factors.factor(_SUFFIXES[suffix])
