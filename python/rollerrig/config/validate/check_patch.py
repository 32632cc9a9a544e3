"""Check that wheel and roller are large against the patch between them: contact theory takes both for half-spaces.

Case -> [check_patch] -> problems

The patch is estimated as the Hertzian circle of two balls of the radii of wheel and roller, under the mean wheel load.
"""

from collections.abc import Iterator

from rollerrig import _core
from rollerrig.config.errors import ConfigProblem
from rollerrig.config.schema.case import CaseTables
from rollerrig.config.schema.support import Rig

LARGEST_SHARE = 0.1
"""Largest share of the radius: half of the patch's length may be at most so long [-]."""


def check_patch(case: CaseTables, file: str) -> Iterator[ConfigProblem]:
    """Rollers, and wheels, that are too small for what presses on them."""
    support = case.support.data
    if not isinstance(support, Rig):
        return
    wheel, roller = case.vehicle.data.wheel.radius, support.roller_radius
    patch = patch_size(case, roller)
    if patch <= LARGEST_SHARE * min(wheel, roller):
        return
    load, modulus = _wheel_load(case), case.contact.material.young_modulus
    reason = (
        f"the patch between wheel and roller is about {_length(patch)} long to either side (load {load:.3g} N, "
        f"E {modulus:.3g} Pa), and contact theory takes both for bodies much larger than it"
    )
    least = _least_radius(case) if patch_size(case, 1e3) <= LARGEST_SHARE * wheel else None
    if least is None:
        allowed = f"{reason}; the wheels of {_length(wheel)} are too small themselves: less load, or a harder material"
        yield ConfigProblem(file, "vehicle.data.wheel.radius", _length(wheel), allowed)
        return
    allowed = f"{reason}; allowed: at least {_length(least)}, or less load, or a harder material"
    yield ConfigProblem(file, "support.data.roller_radius", _length(roller), allowed)


def patch_size(case: CaseTables, roller_radius: float) -> float:
    """Half of the patch's length [m]."""
    material = case.contact.material
    curvature = 0.5 * (1.0 / case.vehicle.data.wheel.radius + 1.0 / roller_radius)  # (14)
    ellipse = _core.hertz_ellipse(
        _wheel_load(case), curvature, curvature, material.shear_modulus, material.poisson_ratio
    )
    return float(ellipse[0])


def _wheel_load(case: CaseTables) -> float:
    """Mean over the whole vehicle [N]."""
    bodies = case.vehicle.data.body
    wheelsets = sum(body.kind == "wheelset" for body in bodies)
    return case.gravity * sum(body.mass for body in bodies) / (2 * wheelsets)


def _least_radius(case: CaseTables) -> float:
    """Radius from which on a roller is large enough [m], rounded up to two digits."""
    from scipy.optimize import brentq

    exact = brentq(lambda radius: patch_size(case, radius) - LARGEST_SHARE * radius, 1e-6, 1e3)
    return float(f"{1.05 * exact:.1e}")


def _length(value: float) -> str:
    return f"{1e3 * value:.3g} mm"
