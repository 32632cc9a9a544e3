"""Steady curving: the vehicle at constant speed in a curve of constant radius and cant, over radii and cant deficiencies.

    Case, radii, cant deficiencies -> [continuation from the straight] -> steady states -> Y, Q, Y/Q, angle of attack, wear number

No body accelerates against the track, whose frame turns with the curve: suspension, wheel loads and creep forces are in balance,
with the rotation of each wheelset among the unknowns. The heaviest body is hauled at constant speed: its longitudinal force
balances the resistance of the curve. Solver: the core's Newton method, docs/theory/equilibrium_and_linearisation.md.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.analysis.wheel_rail_forces import wheel_forces
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.cases import as_case, at_speed, on_track, without_actuators
from rollerrig.common.arrays import Array
from rollerrig.common.linear_algebra import eigenvalues
from rollerrig.config import Case, ConfigError, Rig
from rollerrig.config.schema.track import Curve
from rollerrig.results import Outcome, run_dataset, variable
from rollerrig.simulation.starting_state import StartError

GRID = ("radius", "cant_deficiency")
RADII = (1000.0, 500.0, 300.0, 250.0, 150.0)
DEFICIENCIES = (-0.06, 0.0, 0.06, 0.1, 0.15)
USUAL_CANT = 0.1  # cant of a case without a curve of its own [m]

SMALLEST_STEP = 1.0 / 64.0
"""Part of the way between two points: where Newton's method fails over this, there is no steady state next to the last one."""

SPEEDS, STRAIGHT = (1.0, 200.0), 1e-7
"""Slowest and fastest running [m/s]; least curvature, the end of the range of a curve's radius [1/m]."""

LIFTING, CLIMBING = 0.1, 0.9
"""Where there is no steady state beyond, a wheel with less of its static load lifts, one with more of Nadal's limit climbs."""


class SteadyState(NamedTuple):
    """A state in balance, and where: at a curvature [1/m], cant [m] and speed [m/s], on a model in an endless curve."""

    at: Array
    model: AssembledModel
    state: Array


def curving_case(case: Case) -> Case:
    """The whole vehicle of a case on rigid or elastic track without irregularities, nothing acting on it."""
    bare = without_actuators(case).with_changes({"disturbance": [], "axle_torque": []})
    if bare.vehicle.part.fixed:  # a part that hangs on a fixed body does not take part in the statics of the curve
        bare = bare.with_changes({"vehicle.cut": "vehicle"})
    return at_speed(on_track(bare) if isinstance(bare.support.data, Rig) else bare)


def curving_speed(case: Case, radius: float, cant: float, deficiency: float) -> float:
    """Speed that a cant deficiency b a / g belongs to, by (Y3) of docs/theory/layout.md [m/s]; NaN where there is none."""
    base = case.support.data.cant_base  # type: ignore[union-attr]
    square = case.gravity * radius * (cant + deficiency) / math.sqrt(base**2 - cant**2)
    return math.sqrt(square) if square > 0.0 else math.nan


def own_rails(case: Case) -> dict[str, Any]:
    """Gauge, inclination and heads that the first curve has in place of those of the track, as keys of a segment."""
    keys = {"gauge", "inclination", "profile", "right_profile"}
    return next((curve.model_dump(include=keys, exclude_none=True) for curve in curves_of(case)), {})


def curves_of(case: Case) -> list[Curve]:
    """The circular curves of its track."""
    return [segment for segment in getattr(case.support.data, "segment", ()) if segment.kind == "curve"]


def recorded(states: Sequence[SteadyState]) -> xr.Dataset:
    """What a run records, of states in place of times."""
    simulations = [_core.Simulation(one.model.core) for one in states]
    rows = [s.record(0.0, one.state, np.zeros(s.quadrature_count)) for s, one in zip(simulations, states, strict=True)]
    outcome = Outcome("ok", _core.status_sentence(0), 0.0, "", {}, {})
    return run_dataset(states[0].model, np.arange(float(len(states))), np.array(rows), outcome)


def solve(case: Case, at: Array, direction: str, near: SteadyState | None = None) -> SteadyState | float:
    """The steady state near another one, or as the core finds it; what remains unbalanced where there is none [N, N m]."""
    place = {"radius": float(1.0 / max(at[0], STRAIGHT)), "cant": float(at[1]), "direction": direction}
    curve = {"kind": "curve", "length": 1.0, **place, **own_rails(case)}
    model = assemble(case.with_changes({"support.segment": [curve], "motion.speed_mps": float(at[2])}))
    simulation = _core.Simulation(model.core)
    start = None
    if near is not None:
        start = near.state.copy()
        start[[simulation.rate_index[model.body_index(name)][4] for name in model.wheelsets]] *= at[2] / near.at[2]
    found = simulation.equilibrium(at[2], 0.0, [], start, only_near=near is not None)
    return SteadyState(at, model, np.asarray(found["x"])) if found["converged"] else float(found["residual"])


def follow(case: Case, begin: SteadyState, end: Array, direction: str) -> tuple[SteadyState, str]:
    """Continuation with steps that are halved where Newton's method fails, and doubled after they succeed.

    The last steady state on the way, and why it is not that of the end; "": it is.
    """
    last, done, step = begin, 0.0, 1.0
    while done < 1.0:
        part = min(done + step, 1.0)
        found = solve(case, begin.at + part * (end - begin.at), direction, last)
        if isinstance(found, SteadyState):
            last, done, step = found, part, 2.0 * step
        elif (step := 0.5 * step) < SMALLEST_STEP:
            return last, why_not_beyond(last, found)
    return last, ""


def why_not_beyond(last: SteadyState, unbalanced: float) -> str:
    """What a state looks like next to which there is none."""
    forces = wheel_forces(recorded([last])).isel(time=0)
    loads, quotient = forces["wheel_load"] / forces["static_wheel_load"], forces["derailment_quotient"]
    place = f"R = {1.0 / max(last.at[0], STRAIGHT):.0f} m and {3.6 * last.at[2]:.1f} km/h"
    if float(loads.min()) < LIFTING:
        return f"{loads.idxmin().item()} lifts: {100 * float(loads.min()):.0f} % of its load is left at {place}"
    if float(quotient.max()) > CLIMBING * float(forces["nadal_limit"]):
        return f"{quotient.idxmax().item()} climbs its rail: Y/Q = {float(quotient.max()):.2f} at {place}"
    return f"no steady state was found beyond {place}: at least {unbalanced:.2g} N or N m remain unbalanced"


def in_curves(case: Case, cant: float | None) -> tuple[Case, float]:
    """What is solved of a case, and the cant of its curves [m]: as given, that of its first curve, or the usual one."""
    curves = curves_of(case)
    first = [curve.model_dump(exclude_none=True) for curve in curves[:1]]
    height = (curves[0].cant if curves else USUAL_CANT) if cant is None else cant
    return curving_case(case).with_changes({"support.segment": first}), height


def steady_state(
    bare: Case, end: Array, direction: str, nearby: Sequence[SteadyState | None] = ()
) -> tuple[SteadyState | None, str]:
    """The steady state at a curvature, cant and speed, or why there is none.

    Followed from those nearby, then from the straight, at last from the core's own first guess.
    """
    if not SPEEDS[0] <= end[2] <= SPEEDS[1]:
        return None, f"no speed between {SPEEDS[0]:g} and {SPEEDS[1]:g} m/s has this cant deficiency"
    failure = ""
    for begin in (*nearby, end * [0.0, 0.0, 1.0], end):
        try:
            first = solve(bare, begin, direction) if isinstance(begin, np.ndarray) else begin
            last, why = follow(bare, first, end, direction) if isinstance(first, SteadyState) else (None, "")
        except ConfigError as refused:  # a radius or a speed that no vehicle runs in or at
            last, why = None, str(refused)
        if last is not None and not why:
            return last, ""
        failure = failure or why
    return None, failure or "no steady state on straight track"


def curving(
    case: Case | str,
    radii: Sequence[float] = RADII,
    deficiencies: Sequence[float] = DEFICIENCIES,
    cant: float | None = None,
    *,
    direction: Literal["left", "right"] = "left",
    progress: Callable[[float, str], None] | None = None,
) -> xr.Dataset:
    """Steady curving of the whole vehicle: wheel forces, angles of attack and wear numbers over radius and cant deficiency.

    Args:
        case: a vehicle on track, or on rollers: then on rails of their profile. Actuators and irregularities are left out; gauge,
            inclination and heads are those of its first curve.
        radii: of the track's middle [m].
        deficiencies: cant deficiencies [m], which with the cant decide the speed; negative: cant excess.
        cant: of all curves [m]; None: that of the case's first curve, or 0.1 m.
        direction: where the curves lead.
        progress: called with the fraction done and a short text.

    Returns:
        Dimensions radius, cant_deficiency, and wheel or wheelset. Of wheels: guiding_force Y, wheel_load Q [N],
        derailment_quotient Y/Q, wear_number [N], contact_angle [rad] of the patch that carries most; of wheelsets, positive
        towards the outer rail: guiding_force_sum [N], angle_of_attack [rad], lateral [m]. Without: speed [m/s],
        unbalanced_force [N], growth_rate [1/s] (positive: the steady state is unstable, the vehicle hunts). Where no steady
        state was found the numbers are NaN and `failure` says why. static_wheel_load, guiding_force_sum_limit,
        nadal_limit as in `wheel_forces`.

    Raises:
        ConfigError: the case cannot be used.
        StartError: there is no steady state at all.

    Example:
        >>> import rollerrig as rr
        >>> found = rr.curving("vehicle_curve", [1000.0, 500.0], [0.0])
        >>> bool((found["angle_of_attack"].isel(wheelset=0).diff("radius") > 0).all())  # tighter: steeper
        True
    """
    case = as_case(case)
    bare, height = in_curves(case, cant)
    radii, deficiencies = sorted(set(radii), reverse=True), sorted(set(deficiencies))
    if radii and radii[-1] <= 0.0:
        raise ConfigError.of(
            case.name, "radii", f"{radii[-1]:g} m", "allowed: above 0; `direction` says where a curve leads"
        )
    speeds = np.array([[curving_speed(bare, r, height, d) for d in deficiencies] for r in radii])
    failure = np.full(speeds.shape, "", dtype=object)
    found: dict[tuple[int, int], SteadyState] = {}
    for j, i in np.ndindex(*speeds.T.shape):
        if progress is not None:
            progress((j * len(radii) + i) / speeds.size, f"R = {radii[i]:g} m")
        end = np.array([1.0 / radii[i], height, speeds[i, j]])
        # From the next larger radius, the next smaller deficiency.
        state, failure[i, j] = steady_state(bare, end, direction, (found.get((i - 1, j)), found.get((i, j - 1))))
        if state is not None:
            found[i, j] = state
    if not found:
        raise StartError(f"{case.name}: no steady state in any curve; R = {radii[0]:g} m: {failure[0, 0]}")
    states = {(radii[i], deficiencies[j]): state for (i, j), state in found.items()}
    table = _table(states, direction).reindex(radius=radii, cant_deficiency=deficiencies).transpose(*GRID, ...)
    table["radius"].attrs = {"units": "m", "long_name": "radius of the curve"}
    table["cant_deficiency"].attrs = {"units": "m", "long_name": "cant deficiency, negative: cant excess"}
    table["speed"] = variable(GRID, speeds, "m/s", "running speed")
    table["failure"] = (GRID, failure.astype(str), {"long_name": "why there is no steady state; empty: there is one"})
    title = f"Steady curving of {case.name}"
    return table.assign_attrs(title=title, case=case.name, cant_m=height, direction=direction)


def read_off(run: xr.Dataset, wheelsets: Sequence[str], direction: str) -> xr.Dataset:
    """Wheel forces, angles of attack and displacements in what is `recorded` of steady states, their number in place of time."""
    forces = wheel_forces(run)
    own = run.sel(body=list(wheelsets)).rename(body="wheelset")
    outer = -1.0 if direction == "left" else 1.0  # from positive to the left to positive towards the outer rail
    angle = run["patch_contact_angle"].isel(patch=run["patch_normal"].fillna(0.0).argmax("patch"))
    given = {
        "contact_angle": (angle, "rad", "contact angle of the patch that carries most"),
        "guiding_force_sum": (outer * forces["guiding_force_sum"], "N", "sum of guiding forces ΣY, positive outwards"),
        "angle_of_attack": (outer * own["yaw"], "rad", "angle of attack, positive towards the outer rail"),
        "lateral": (outer * own["lateral"], "m", "lateral displacement, positive towards the outer rail"),
    }
    kept = ["guiding_force", "wheel_load", "derailment_quotient", "wear_number", *forces.drop_dims("time").data_vars]
    named = {name: one.assign_attrs(units=unit, long_name=meaning) for name, (one, unit, meaning) in given.items()}
    return forces[kept].assign(named).drop_vars(["time", "section", "patch"])


def _table(found: Mapping[tuple[float, float], SteadyState], direction: str) -> xr.Dataset:
    """Steady states by radius and cant deficiency; what none was found for is NaN."""
    run, model = recorded(list(found.values())), next(iter(found.values())).model
    masses = xr.DataArray([model.masses[name] for name in model.bodies], dims="body")
    accelerations = run[[f"{way}_acceleration" for way in ("longitudinal", "lateral", "vertical")]].to_dataarray("way")
    unbalanced = abs(masses * accelerations).max(("way", "body")).to_numpy()
    linear = (_core.Simulation(one.model.core).jacobian(0.0, one.state)[0] for one in found.values())
    growth = [eigenvalues(matrix).real.max() for matrix in linear]
    flat = read_off(run, model.wheelsets, direction).assign(
        unbalanced_force=variable("time", unbalanced, "N", "largest unbalanced force of a body"),
        growth_rate=variable("time", growth, "1/s", "growth rate of the fastest growing small motion"),
    )
    places = {name: ("time", np.array(values)) for name, values in zip(GRID, zip(*found, strict=True), strict=True)}
    flat.attrs = {key: run.attrs[key] for key in ("run_info", "sources", "config_toml", "rollerrig_version")}
    return flat.assign_coords(places).set_index(time=GRID).unstack("time")
