"""Where an unloaded wheelset touches over its lateral shift, how the rolling radii differ, and its equivalent conicity.

    Case -> [touching points of the core] -> xarray.Dataset over `lateral` and `side`
    rolling radius difference over lateral shift -> [kinematic motion integrated] -> wavelength, conicity over amplitude

Rigid profiles, the wheelset above the crown, without yaw. Left of the running direction is positive. As in EN 15302
each wheel is lowered on its own (roll neglected) unless the wheelset is asked to roll until both touch.

The points of touch lie in the plane through the wheelset's and the roller's axis. There a roller is its generatrix, so
wheel and roller touch where wheel and rail do; what differs is what the contact does to the rolling.

The equivalent conicity is that of the cone whose wheelset would weave as long. A free wheelset that rolls without slip
follows, over the arc length x of the track,

    y'' + Δr(y) / (e r0) = 0                                                       (K1)

which has the first integral y'^2 / 2 = [U(m + ŷ) - U(y)] / (e r0), U(y) = ∫ Δr dy. Half of its wave is the way from one
outer position m - ŷ to the other, m + ŷ, at which U is the same; where both sides have the same profiles m is 0:

    λ(ŷ) = 2 sqrt(e r0) ∫_(m-ŷ)^(m+ŷ) dy / sqrt(2 [U(m + ŷ) - U(y)])                (K2)
    tan γ_e = 2 e r0 (π / λ)^2                                                     (K3)

On rollers Δr is the effective difference, which counts the rollers' radii as well, and x is the way of the surface.

Units   SI. The conicity depends on neither e nor r0; the wavelength does.
Source  EN 15302:2021, clause 9 and annex E (direct integration of the nonlinear differential equation); EN 15302:2008,
        annex B; Klingel (1883) for (K3).
"""

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from rollerrig import _core
from rollerrig.assembly.model import assemble
from rollerrig.common.arrays import Array
from rollerrig.config import Case, Rig
from rollerrig.contact_analysis.static_contact import leading_wheelset
from rollerrig.profiles import ProfileTable
from rollerrig.results import variable

SIDES = ("left", "right")

JUMP = 1e-3
"""Rows are set closer together where a contact moves further than this from row to row [m]..."""

FINEST = 1e-6
"""...down to this distance [m]: so well is a jump of the contact placed."""

_JUST_TOUCHING = 1e-9
"""A touching point whose gap is larger than this is none [m]; the core closes gaps to 1e-13 m."""

LEVEL = 1e-10
"""Both wheels touch where their heights differ by less [m]."""

MOST_STEPS = 40

_VARIABLES = {
    "wheel_abscissa": ("m", "EN abscissa S of the contact on the wheel profile, negative towards the flange"),
    "rail_abscissa": ("m", "contact on rail or roller, 0 at the highest point, negative towards the gauge side"),
    "rail_height": ("m", "height of the head there over its highest point: what the roller's radius gains"),
    "rolling_radius": ("m", "wheel radius at the contact"),
    "contact_angle": ("rad", "inclination of the contact plane, positive as at the flange"),
}

_Touch = Array
"""Both wheels at one shift, left first: _VARIABLES, and the roll angle; shape (2, 6)."""

_Toucher = Callable[[float, float], _Touch | None]
"""Both wheels touching at a lateral shift [m], from a roll angle on [rad]; None where one does not."""


def shift_table(case: Case, largest: float = 8e-3, step: float = 0.1e-3, free_to_roll: bool = False) -> xr.Dataset:
    """Touching points and rolling radii of the leading wheelset over its lateral shift.

    Args:
        case: its wheel, support and their profiles; nothing else matters.
        largest: lateral shift to both sides [m].
        step: distance of the rows [m]; where a contact jumps, rows are added until the jump is placed to FINEST.
        free_to_roll: roll the wheelset until both wheels touch; else each wheel is lowered on its own, as EN 15302 allows.

    Returns:
        Over `lateral` and `side`: wheel_abscissa, rail_abscissa, rail_height, rolling_radius, contact_angle. Over
        `lateral`: roll [rad], rolling_radius_difference r_left - r_right [m], and effective_difference [m], which on
        rollers is less by what the rollers' own radii differ, (r0/R0) (R_left - R_right). If a wheel finds no contact
        the table ends before that shift, on both sides, and attrs["ended"] says so.

    Raises:
        ValueError: shift or step is not positive, or the wheels do not touch even in the middle.
    """
    if not (0 < step <= largest):
        raise ValueError(f"step {step:g} m and largest shift {largest:g} m: positive, and the step not larger")
    model = assemble(case)
    contact = leading_wheelset(model).contact
    wheel, support = case.vehicle.data.wheel, case.support.data
    contact_distance = wheel.back_to_back + 2 * wheel.tape_circle
    touch_at = partial(_touch, contact, contact_distance if free_to_roll else None)

    steps = np.minimum(step * np.arange(1, math.ceil(largest / step - 1e-9) + 1), largest)
    touches, ended = _outward(touch_at, steps)
    if model.right_rail_profile is model.rail_profile:
        mirrored = np.array([1.0, 1.0, 1.0, 1.0, 1.0, -1.0])  # the roll angle is the other way
        touches |= {-y: touch[::-1] * mirrored for y, touch in touches.items() if y > 0.0}
    else:
        others, early = _outward(touch_at, -steps)
        touches, ended = {**others, **touches}, ended or early
    roller_radius = support.roller_radius if isinstance(support, Rig) else np.inf
    table = _dataset(touches, (model.rail_profile, model.right_rail_profile)).assign_attrs(
        title=case.description,
        support=support.kind,
        wheel_radius_m=wheel.radius,
        roller_radius_m=roller_radius,
        contact_distance_m=contact_distance,
        gauge_m=support.gauge,
        back_to_back_m=wheel.back_to_back,
        roll="free" if free_to_roll else "neglected",
        ended=ended,
    )
    difference = _left_less_right(table["rolling_radius"])
    of_rollers = _left_less_right(table["rail_height"])
    table["rolling_radius_difference"] = difference.assign_attrs(
        units="m", long_name="rolling radius, left less right wheel"
    )
    table["effective_difference"] = (difference - wheel.radius / roller_radius * of_rollers).assign_attrs(
        units="m", long_name="rolling radius difference less that of the rollers, in the wheel's scale"
    )
    return table


def _dataset(touches: dict[float, _Touch], rails: tuple[ProfileTable, ProfileTable]) -> xr.Dataset:
    """Touching points over the lateral shift; the core's height of the head at each."""
    values = np.stack([touches[y] for y in sorted(touches)], axis=-1)  # (side, variable, lateral)
    of = dict(zip((*_VARIABLES, "roll"), np.moveaxis(values, 0, -1), strict=True))
    of["rail_height"] = np.stack(
        [rail.evaluate(y) for rail, y in zip(rails, of["rail_abscissa"].T, strict=True)], axis=1
    )
    variables = {
        name: variable(("lateral", "side"), of[name], unit, meaning) for name, (unit, meaning) in _VARIABLES.items()
    }
    variables["roll"] = variable("lateral", of["roll"][:, 0], "rad", "roll angle of the wheelset")
    lateral = variable("lateral", sorted(touches), "m", "lateral shift, left")
    return xr.Dataset(variables, coords={"lateral": lateral, "side": list(SIDES)})


def _left_less_right(values: xr.DataArray) -> xr.DataArray:
    return values.sel(side="left", drop=True) - values.sel(side="right", drop=True)


def _outward(touch_at: _Toucher, shifts: Array) -> tuple[dict[float, _Touch], str]:
    """Rows from the middle to one side, as far as both wheels touch; why they end early, or nothing.

    Rows are added where a contact moves fast or jumps.
    """
    middle = touch_at(0.0, 0.0)
    if middle is None:
        raise ValueError("the wheels do not touch in the middle; check gauge, back-to-back distance and profiles")
    touches, last, ended = {0.0: middle}, middle, ""
    for y in shifts.tolist():
        touch = touch_at(y, last[0, -1])
        if touch is None:
            ended = f"no contact from {1e3 * y:g} mm on: a wheel is off its profile or off the rail"
            break
        touches[y] = last = touch
    new = True
    while new:
        lateral = sorted(touches)
        new = False
        for low, high in zip(lateral, lateral[1:], strict=False):
            if high - low > FINEST and np.abs(touches[low] - touches[high])[:, 0].max() > JUMP:
                touch = touch_at(0.5 * (low + high), touches[low][0, -1])
                if touch is None:
                    return touches, ended
                touches[0.5 * (low + high)], new = touch, True
    return touches, ended


def _touch(contact: _core.StaticWheelsetContact, arm: float | None, y: float, roll: float) -> _Touch | None:
    """Both wheels touching, see _Toucher.

    With an arm, about how far the contacts are apart [m], the wheelset rolls until both wheels touch.
    """

    def heights() -> tuple[float, float]:
        """Heights at which the left and the right wheel touch [m]."""
        left, right = (contact.touch_height(0.0, y, 0.0, roll, right) for right in (False, True))
        return left, right

    left, right = heights()
    slope = -(arm or 0.0)  # secant steps; a metre's arm gains a metre per radian
    for _ in range(MOST_STEPS):
        if arm is None or abs(left - right) < LEVEL:
            break
        turn, before = (right - left) / slope, left - right
        roll += turn
        left, right = heights()
        # On a flange, roll moves the wheel sideways as well: steeper than the arm. At a jump the slope has a step.
        slope = min(max((left - right - before) / turn, -4 * arm), -0.5 * arm)
    sides = [_first_touch(contact, y, left, roll, False), _first_touch(contact, y, right, roll, True)]
    return None if None in sides else np.array(sides)


def _first_touch(
    contact: _core.StaticWheelsetContact, y: float, height: float, roll: float, right: bool
) -> tuple[float, ...] | None:
    """The point of touch of one wheel, a row of a _Touch, if there is one."""
    patch = max(contact.minima(0.0, y, height, 0.0, roll, right, 1e-6), key=lambda found: found.approach, default=None)
    if patch is None or abs(patch.approach) > _JUST_TOUCHING:
        return None
    _, lean, upward = patch.direction
    angle = math.atan2(lean if right else -lean, upward)
    return patch.wheel_s, patch.rail_y, patch.point[2], patch.wheel_radius, angle, roll


POINTS = 2000
"""Points of the quadrature in (K2); the kink that a jump of the contact leaves in U costs 1e-6 of the conicity."""

CYLINDRICAL = 1e-7
"""Rolling radius differences up to this one count as none [m]: profile files print no more digits."""


def equivalent_conicity(lateral: Array, difference: Array, amplitudes: Sequence[float]) -> Array:
    """Equivalent conicity tan γ_e over the amplitude of the kinematic motion.

    Args:
        lateral: lateral shifts, increasing, 0 among them [m]; only those from 0 on: the other side is their mirror image.
        difference: rolling radius difference, left less right, at these shifts [m]; straight lines between them.
        amplitudes: amplitudes ŷ, half of the distance between the outer positions [m].

    Returns:
        One value per amplitude [-]: 0 where the radii do not differ, NaN where nothing drives the wheelset
        back, or where the shifts given end too early.

    Raises:
        ValueError: an amplitude is not positive or beyond the shifts given.

    Example:
        >>> y = np.linspace(-8e-3, 8e-3, 161)
        >>> equivalent_conicity(y, 2 * 0.05 * y, [3e-3]).round(6).tolist()  # a cone 1:20
        [0.05]
    """
    y, dr = lateral, difference
    if not np.any(y == 0.0) or y[-1] <= 0.0:
        raise ValueError("lateral: the shift 0 and positive ones are needed")
    if y[0] == 0.0:
        y, dr = np.concatenate([-y[:0:-1], y]), np.concatenate([-dr[:0:-1], dr])
    for amplitude in amplitudes:
        if not 0 < amplitude <= y[-1] * (1 + 1e-12):
            raise ValueError(f"amplitude {1e3 * amplitude:g} mm; allowed above 0 and up to {1e3 * y[-1]:g} mm")
    areas, middle = 0.5 * (dr[1:] + dr[:-1]) * np.diff(y), int(np.flatnonzero(y == 0.0)[0])
    potential = np.concatenate((-np.cumsum(areas[:middle][::-1])[::-1], [0.0], np.cumsum(areas[middle:])))
    slope = np.diff(dr) / np.diff(y)

    def energy(at: Array) -> Array:
        """U(y) of the straight lines, exact [m^2]."""
        k = np.clip(np.searchsorted(y, at, side="right") - 1, 0, len(slope) - 1)
        t = at - y[k]
        return np.asarray(potential[k] + t * (dr[k] + 0.5 * slope[k] * t))

    # y = m + ŷ sin θ takes the roots at the turning points out of the integrand.
    theta = (np.arange(2 * POINTS) + 0.5) * (0.5 * math.pi / POINTS) - 0.5 * math.pi
    result = []
    for amplitude in amplitudes:
        at = _middle(energy, amplitude, float(y[0]), float(y[-1])) + amplitude * np.sin(theta)
        if np.max(np.abs(np.interp(at, y, dr))) < CYLINDRICAL:
            result.append(0.0)
            continue
        rest = energy(at[-1:] + amplitude * (1.0 - np.sin(theta[-1:]))) - energy(at)
        if not np.all(rest > 0.0):
            result.append(math.nan)
            continue
        half = np.sum(amplitude * np.cos(theta) / np.sqrt(2 * rest)) * (0.5 * math.pi / POINTS)
        result.append(2 * (math.pi / (2 * half)) ** 2)  # (K2) in (K3)
    return np.array(result)


def _middle(energy: Callable[[Array], Array], amplitude: float, low: float, high: float) -> float:
    """The middle m of a motion whose outer positions have the same potential [m]; NaN if they are not between low and high."""

    def surplus(middle: float) -> float:
        left, right = energy(np.array([middle - amplitude, middle + amplitude]))
        return float(right - left)

    first, last = low + amplitude, high - amplitude
    if abs(surplus(0.0)) <= 1e-9 * float(np.abs(energy(np.array([-amplitude, amplitude]))).max()):
        return 0.0
    return brentq(surplus, first, last, xtol=1e-12) if surplus(first) * surplus(last) < 0.0 else math.nan


def conicity_table(shifts: xr.Dataset, amplitudes: Sequence[float]) -> xr.Dataset:
    """Conicity and wavelength of the kinematic motion over its amplitude.

    Args:
        shifts: what `shift_table` returns.
        amplitudes: [m].

    Returns:
        Over `amplitude`: conicity [-], and wavelength [m], infinite where the conicity is 0. The attribute
        nonlinearity_per_mm is the `nonlinearity_parameter`, NaN where it does not exist.
    """
    lateral, difference = shifts["lateral"].to_numpy(), shifts["effective_difference"].to_numpy()
    conicity = equivalent_conicity(lateral, difference, amplitudes)
    product = shifts.attrs["contact_distance_m"] * shifts.attrs["wheel_radius_m"]
    with np.errstate(divide="ignore"):
        wavelength = math.pi * np.sqrt(2 * product / conicity)  # (K3)
    return xr.Dataset(
        {
            "conicity": variable("amplitude", conicity, "1", "equivalent conicity"),
            "wavelength": variable("amplitude", wavelength, "m", "wavelength of the kinematic motion"),
        },
        coords={"amplitude": variable("amplitude", np.array(amplitudes), "m", "amplitude")},
        attrs={
            "title": shifts.attrs["title"],
            "support": shifts.attrs["support"],
            "nonlinearity_per_mm": nonlinearity_parameter(lateral, difference),
        },
    )


def nonlinearity_parameter(lateral: Array, difference: Array) -> float:
    """Change of the conicity from 2 to 4 mm of amplitude, per millimetre.

        N_P = [tan γ_e(4 mm) - tan γ_e(2 mm)] / 2 mm

    Negative where the conicity falls with the amplitude, which goes with a gradual onset of small limit cycles;
    positive with a sudden one of large ones.

    Args:
        lateral: as in `equivalent_conicity`.
        difference: as there.

    Returns:
        N_P [1/mm]; NaN if the shifts end before 4 mm.

    Source: O. Polach, Vehicle System Dynamics 48 Suppl. (2010) 19-36; EN 15302:2021, clause 9.
    """
    if lateral[-1] < 4e-3:
        return math.nan
    two, four = equivalent_conicity(lateral, difference, [2e-3, 4e-3])
    return float(four - two) / 2
