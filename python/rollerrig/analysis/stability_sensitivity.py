"""Derivatives of eigenvalues and of the linear critical speed by numbers of a case: which spring moves it, and by how much.

    Case, keys -> [exact Jacobians at +-h of each number, each in its own equilibrium] -> dA/dp -> Dataset over parameters

With right and left eigenvectors v, w of an eigenvalue s of A(V, p), and V_c the speed at which Re s = 0,

    ds/dp = w^H (dA/dp) v / (w^H v),        dV_c/dp = -Re(ds/dp) / Re(ds/dV)

A is exact, its derivatives are central differences; the shift of the equilibrium is in them.
Source: L. C. Rogers, Derivatives of eigenvalues and eigenvectors, AIAA J. 8 (1970).
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis import SPEEDS_KMH
from rollerrig.analysis.mode_table import first_onset, modes_over_speed, zero_crossings
from rollerrig.analysis.modes import Linearisation, Lineariser, eigensystem
from rollerrig.cases import as_case
from rollerrig.common.arrays import Array, Complex
from rollerrig.config import Case
from rollerrig.config.write.explain import unit_of
from rollerrig.results import variable
from rollerrig.simulation.sensitivity import changed_cases

RELATIVE_WIDTH = 1e-4  # half width of the differences by a number, and by speed, over their size [1]

_NUMBERS = ("stiffness", "damping", "damper.damping", "damper.series_stiffness")
"""Numbers of a linear force element in one direction."""


def stability_sensitivity(
    case: Case | str, parameters: Sequence[str] | None = None, speeds_kmh: Sequence[float] = SPEEDS_KMH
) -> xr.Dataset:
    """Derivatives of the linear critical speed, and of all oscillations there, by numbers of a case.

    Args:
        case: what runs, or its name in the catalogue; its rollers or rails are speed-controlled.
        parameters: dotted keys of numbers, as `sensitivity` takes them; None: those of `suspension_parameters`.
        speeds_kmh: where the critical speed is looked for [km/h], rising.

    Returns:
        Dimensions parameter and mode: `value` of each number, in SI, `parameter_unit`; `critical_speed_derivative` [km/h per SI
        unit]; `critical_speed_change`, of a number larger by 1 % of itself [km/h]; at the critical speed `growth_rate` and
        `angular_frequency` of all oscillations, [1/s], and `growth_rate_derivative`, `angular_frequency_derivative`. The
        attributes `linear_critical_speed_kmh` and `linear_critical_mode` say where.

    Raises:
        ConfigError: a key is that of no number, or of one that is 0.
        ValueError: no oscillation begins to grow at these speeds.
        StartError: no rolling equilibrium at one of the speeds.

    Example:
        >>> import rollerrig as rr
        >>> found = rr.stability_sensitivity("bogie_track", ["vehicle.element.primary_*.x.stiffness"])
        >>> bool(found["critical_speed_derivative"][0] > 0.0)
        True
    """
    case = as_case(case)
    keys = list(suspension_parameters(case) if parameters is None else parameters)
    modes = modes_over_speed(case, [v / 3.6 for v in speeds_kmh])
    onset = first_onset(zero_crossings(modes))
    if onset is None:
        raise ValueError(f"speeds_kmh: {case.name} has no linear critical speed between them; give higher ones")
    lineariser, speed = modes.lineariser, onset.speed
    here = lineariser.at(speed)
    system = eigensystem(here.matrix)
    columns = np.flatnonzero(system.values.imag > 0.0)
    columns = columns[np.argsort(system.values.imag[columns])]
    left, right = system.left[:, columns], system.vectors[:, columns]

    def by(above: Linearisation, below: Linearisation, half_width: float) -> Complex:
        change = (above.matrix - below.matrix) / (2.0 * half_width)
        return np.asarray(np.sum(left.conj() * (change @ right), axis=0) / np.sum(left.conj() * right, axis=0))

    values, derivatives = np.empty(len(keys)), np.empty((len(keys), len(columns)), dtype=np.complex128)
    for k, key in enumerate(keys):
        values[k], cases = changed_cases(case, key, RELATIVE_WIDTH)
        above, below = (Lineariser(one, near=here.equilibrium).at(speed) for one in cases)
        derivatives[k] = by(above, below, RELATIVE_WIDTH * abs(values[k]))
    width = RELATIVE_WIDTH * speed
    by_speed = by(lineariser.at(speed + width), lineariser.at(speed - width), width)
    critical = int(np.argmin(np.abs(system.values[columns] - 2j * np.pi * onset.frequency)))
    slope = -3.6 * derivatives[:, critical].real / by_speed[critical].real
    return _dataset(keys, values, slope, system.values[columns], derivatives).assign_attrs(
        title=f"Linear critical speed of {case.name} over numbers of it",
        case=case.name,
        linear_critical_speed_kmh=3.6 * speed,
        linear_critical_mode=onset.name,
    )


def suspension_parameters(case: Case) -> Iterator[str]:
    """Keys of all stiffnesses and dampings that are not 0; one with `*` for equal elements that differ by number and side."""
    groups: dict[tuple[str, str], dict[str, float]] = {}
    for element in case.vehicle.data.elements_in(case.vehicle.part):
        stem = re.sub(r"(_(\d+|left|right|front|rear))+$", "_*", element.name)
        for (direction, law), number in itertools.product(element.laws.items(), _NUMBERS):
            table, _, name = number.rpartition(".")
            value = getattr(getattr(law, table, None) if table else law, name, None)
            if isinstance(value, float) and value != 0.0:
                groups.setdefault((stem, f"{direction}.{number}"), {})[element.name] = value
    for (stem, rest), found in groups.items():
        names = [stem] if len(set(found.values())) == 1 else list(found)
        yield from (f"vehicle.element.{name}.{rest}" for name in names)


def parameter_rows(found: xr.Dataset, changes: Mapping[str, xr.DataArray]) -> list[dict[str, Any]]:
    """A row per number of the case, of a sensitivity's Dataset: key, value, unit, changes; the largest first one on top."""
    rows = [
        {
            "parameter": str(found["parameter"][k].item()),
            "value": float(found["value"][k]),
            "unit": str(found["parameter_unit"][k].item()),
            **{key: float(change[k]) for key, change in changes.items()},
        }
        for k in range(found.sizes["parameter"])
    ]
    return sorted(rows, key=lambda row: -abs(row[next(iter(changes))]))


def _dataset(keys: list[str], values: Array, slope: Array, roots: Complex, derivatives: Complex) -> xr.Dataset:
    one, each, both = "parameter", "mode", ("parameter", "mode")
    per = "per SI unit of the parameter"
    variables = {
        "value": variable(one, values, "SI", "number of the case"),
        "parameter_unit": (one, [unit_of(key) for key in keys], {"long_name": "unit of the number"}),
        "critical_speed_derivative": variable(one, slope, f"km/h {per}", "of the linear critical speed"),
        "critical_speed_change": variable(one, 0.01 * values * slope, "km/h", "by a number larger by 1 % of itself"),
        "growth_rate": variable(each, roots.real, "1/s", "real part of the eigenvalue at the critical speed"),
        "angular_frequency": variable(each, roots.imag, "rad/s", "its imaginary part"),
        "growth_rate_derivative": variable(both, derivatives.real, f"1/s {per}", "of the real part"),
        "angular_frequency_derivative": variable(both, derivatives.imag, f"rad/s {per}", "of the imaginary part"),
    }
    return xr.Dataset(variables, {"parameter": keys})
