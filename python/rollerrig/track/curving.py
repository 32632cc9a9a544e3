"""Quasi-static curving: the lateral acceleration in the plane of the track, and the speeds that statics allows.

On a curve of curvature k, the rails inclined by phi = asin(cant / base), gravity and centrifugal force have the resultant
g sqrt(1 + (v^2 k / g)^2), inclined against the track's normal by

    atan(v^2 k / g) - phi ,

whose tangent p is the lateral force per unit of load on the track. Equations: docs/theory/layout.md.
"""

import math


def plane_acceleration(speed: float, curvature: float, cant: float, cant_base: float, gravity: float) -> float:
    """Lateral acceleration in the plane of the track that the cant leaves, outward of a curve to the left [m/s^2].

    Args:
        speed: running speed [m/s].
        curvature: positive in a curve to the left [1/m].
        cant: height of the right rail over the left one [m].
        cant_base: distance over which the cant is measured [m].
        gravity: its acceleration [m/s^2].
    """
    phi = math.asin(cant / cant_base)
    return speed**2 * curvature * math.cos(phi) - gravity * math.sin(phi)


def equilibrium_speed(curvature: float, cant: float, cant_base: float, gravity: float) -> float:
    """Speed at which no lateral acceleration is left [m/s]; NaN where there is none."""
    ratio = math.tan(math.asin(cant / cant_base)) / curvature if curvature else math.nan
    return math.sqrt(gravity * ratio) if ratio >= 0 else math.nan


def highest_speed(curvature: float, cant: float, cant_base: float, limit: float, gravity: float) -> float:
    """Speed at which the lateral force per load reaches a limit on the outer side [m/s].

    Args:
        curvature: positive in a curve to the left [1/m]; not 0.
        cant: height of the right rail over the left one [m].
        cant_base: distance over which the cant is measured [m].
        limit: lateral force per load [-].
        gravity: its acceleration [m/s^2].

    Returns:
        The speed; infinite where the cant carries any.
    """
    angle = math.copysign(1.0, curvature) * math.asin(cant / cant_base) + math.atan(limit)
    if angle >= math.pi / 2:
        return math.inf
    return math.sqrt(max(gravity * math.tan(angle) / abs(curvature), 0.0))


def nadal_limit(flange_angle: float, friction: float) -> float:
    """Largest Y/Q at which a flange that slides down its rail keeps sliding (R1).

    Args:
        flange_angle: steepest angle of the flange δ [rad].
        friction: coefficient of friction μ [-].

    Returns:
        The limit [-]; NaN where friction alone holds the wheel, tan δ <= μ: no flange.

    Example:
        >>> round(nadal_limit(math.radians(70.0), 0.36), 3)
        1.2
    """
    slope = math.tan(flange_angle)
    return (slope - friction) / (1.0 + friction * slope) if slope > friction else math.nan


def limit_of_lateral_force(
    height: float, base: float, flange_angle: float | None, friction: float
) -> tuple[float, str]:
    """Lateral force per load of a vehicle at which statics ends: it overturns or its flange climbs.

    The load moves to the outer rail by the fraction eta = 2 h p / b, and the vehicle overturns at eta = 1. Until then the
    outer wheels carry Q = (1 + eta) W / 2 and at least the lateral force Y = p W, so that Y/Q = 2 p / (1 + eta): the
    lateral creep force of the inner wheels, which adds to Y where they roll at an angle, is left out, and the result is
    an upper bound. A flange of angle delta climbs at Nadal's (tan delta - mu) / (1 + mu tan delta).

    Args:
        height: of the centre of mass above the rails [m].
        base: distance between the points of contact [m].
        flange_angle: largest inclination of the flange [rad]; None for wheels without one.
        friction: coefficient of friction mu [-].

    Returns:
        The limit of p [-], and which of the two it is: "overturning" or "flange climb".
    """
    overturning = base / (2 * height)
    if flange_angle is None:
        return overturning, "overturning"
    nadal = nadal_limit(flange_angle, friction)
    nadal = 0.0 if math.isnan(nadal) else nadal  # friction lifts the wheel at any lateral force
    share = 2 - nadal * 2 * height / base
    climb = nadal / share if share > 0 else math.inf
    if climb < overturning:
        return max(climb, 0.0), "flange climb"
    return overturning, "overturning"
