"""Derivatives of steady curving by numbers of a case: which spring, or friction, moves Y/Q, the wear number, the angle of attack.

    Case, keys, a curve -> [steady state, and those at +-h of each number, found from it] -> Dataset over parameters

A steady state is converged to rounding: central differences of two of them are exact but for the square of their width. What
follows a number by way of the speed, such as the base of the cant, is in it.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Literal

import numpy as np
import xarray as xr

from rollerrig.analysis.curving import (
    SteadyState,
    curving_case,
    curving_speed,
    in_curves,
    read_off,
    recorded,
    steady_state,
)
from rollerrig.analysis.stability_sensitivity import suspension_parameters
from rollerrig.cases import as_case
from rollerrig.common.arrays import Array
from rollerrig.config import Case
from rollerrig.config.write.explain import unit_of
from rollerrig.results import variable
from rollerrig.simulation.sensitivity import changed_cases
from rollerrig.simulation.starting_state import StartError

RELATIVE_WIDTH = 1e-4  # half width of the differences by a number, over its size [1]

OUTPUTS = (
    "guiding_force", "wheel_load", "derailment_quotient", "guiding_force_sum", "wear_number", "angle_of_attack", "lateral",
)  # fmt: skip
"""Variables of `curving` that are differentiated."""


def curving_sensitivity(
    case: Case | str,
    parameters: Sequence[str] | None = None,
    *,
    radius: float,
    deficiency: float,
    cant: float | None = None,
    direction: Literal["left", "right"] = "left",
    progress: Callable[[float, str], None] | None = None,
) -> xr.Dataset:
    """Steady curving of the whole vehicle in one curve, with the derivatives of its forces and angles by numbers of the case.

    Args:
        case: a vehicle on track or rollers, as `curving` takes it: on rails, without what drives it.
        parameters: dotted keys of numbers, as `sensitivity` takes them; None: those of `curving_parameters`.
        radius: of the track's middle [m].
        deficiency: cant deficiency [m], which with the cant decides the speed; negative: cant excess.
        cant: [m]; None: that of the case's first curve, or 0.1 m.
        direction: where the curve leads.
        progress: called with the fraction done and a short text.

    Returns:
        The OUTPUTS of `curving` over wheel or wheelset, and each as `..._derivative` over parameter too, per SI unit of the
        number; `value` of each number, in SI, and `parameter_unit`.

    Raises:
        ConfigError: a key is that of no number, or of one that is 0; the case cannot be used.
        StartError: there is no steady state in this curve, or none next to it; the message says why.

    Example:
        >>> import rollerrig as rr
        >>> found = rr.curving_sensitivity("vehicle_curve", ["contact.friction.mu_0"], radius=500.0, deficiency=0.0)
        >>> bool(found["wear_number_derivative"].sum() > 0.0)
        True
    """
    case = as_case(case)
    keys = list(curving_parameters(case) if parameters is None else parameters)
    changed = [changed_cases(case, key, RELATIVE_WIDTH) for key in keys]
    end, here = _state(case, radius, deficiency, cant, direction)

    def changed_outputs(one: Case) -> xr.Dataset:
        return _outputs(_state(one, radius, deficiency, cant, direction, here)[1], direction)

    derivatives = []
    for number, (key, (value, (above, below))) in enumerate(zip(keys, changed, strict=True)):
        if progress is not None:
            progress(number / len(keys), key)
        derivatives.append((changed_outputs(above) - changed_outputs(below)) / (2.0 * RELATIVE_WIDTH * abs(value)))
    found = _dataset(keys, np.array([value for value, _ in changed]), _outputs(here, direction), derivatives)
    attributes = {"case": case.name, "radius_m": radius, "cant_deficiency_m": deficiency, "cant_m": end[1]}
    title = f"Steady curving of {case.name} over numbers of it"
    return found.assign_attrs(title=title, **attributes, speed_kmh=3.6 * end[2], direction=direction)


def curving_parameters(case: Case) -> Iterator[str]:
    """Keys of all stiffnesses of the suspension, as `suspension_parameters` has them, and of friction; dampers are at rest."""
    yield from (key for key in suspension_parameters(curving_case(case)) if key.endswith(".stiffness"))
    yield "contact.friction.mu_0"
    if case.contact.gauge_face_friction is not None:
        yield "contact.gauge_face_friction"


def largest_change(found: xr.Dataset, output: str) -> xr.DataArray:
    """What 1 % more of each number of a Dataset of `curving_sensitivity` does to an output where its magnitude is largest."""
    one = found[output]
    return 0.01 * found["value"] * found[f"{output}_derivative"].sel({one.dims[0]: abs(one).idxmax()})


def _state(
    case: Case, radius: float, deficiency: float, cant: float | None, direction: str, near: SteadyState | None = None
) -> tuple[Array, SteadyState]:
    """Curvature, cant and speed, and the steady state there."""
    bare, height = in_curves(case, cant)
    end = np.array([1.0 / radius, height, curving_speed(bare, radius, height, deficiency)])
    found, why = steady_state(bare, end, direction, (near,))
    if found is None:
        where = f"with R = {radius:g} m and a cant deficiency of {1e3 * deficiency:g} mm"
        raise StartError(f"{case.name}: no steady state {where}: {why}")
    return end, found


def _outputs(state: SteadyState, direction: str) -> xr.Dataset:
    return read_off(recorded([state]), state.model.wheelsets, direction)[[*OUTPUTS]].isel(time=0)


def _dataset(keys: list[str], values: Array, here: xr.Dataset, derivatives: Sequence[xr.Dataset]) -> xr.Dataset:
    per = "per SI unit of the parameter"
    variables = {
        "value": variable("parameter", values, "SI", "number of the case"),
        "parameter_unit": ("parameter", [unit_of(key) for key in keys], {"long_name": "unit of the number"}),
    }
    for name, one in here.items():
        by_number = np.array([each[name].to_numpy() for each in derivatives]).reshape(len(keys), one.size)
        unit, meaning = f"{one.attrs['units']} {per}", f"of: {one.attrs['long_name']}"
        variables[f"{name}_derivative"] = variable(("parameter", str(one.dims[0])), by_number, unit, meaning)
    return here.assign(variables).assign_coords(parameter=keys)
