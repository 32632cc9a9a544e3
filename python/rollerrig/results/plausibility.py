"""What a run computes without complaint and hardly anybody can have meant: a line each, beside the results.

results, their model -> [plausibility] -> warnings: wheel loads, speed, friction, tolerance, steps beyond it, stiffness over
mass and step
"""

import json
import math
from collections.abc import Iterator, Mapping

import numpy as np

from rollerrig.assembly.model import AssembledModel
from rollerrig.results.dataset import Draft

WHEEL_LOADS = (100.0, 400e3)
"""Static loads of the wheels of vehicles and of models on a small scale [N]."""

LEAST_TOLERANCE = 1e-5
"""A smaller absolute tolerance is below any signal that is worth a run [m]."""

LEAST_SPEED, LEAST_FRICTION = 0.01, 1e-3
"""A slower run [m/s], and a more slippery rail, are none of a railway; 0 is rest, and no friction at all."""

COARSE_STEPS, LARGEST_ERROR = 0.01, 10.0
"""Part of the steps that may exceed the tolerance, and by how many times one of them may."""

_UNITS = "units may not be what is meant"


def plausibility_warnings(draft: Draft, model: AssembledModel) -> Iterator[str]:
    """What is out of proportion in the draft of a run's results, a line each."""
    low, high = WHEEL_LOADS
    for wheelset, load in model.axle_loads.items():
        if not low <= 0.5 * load <= high:
            usual = f"usual are {low / 1e3:g} to {high / 1e3:g} kN"
            yield f"{wheelset} stands on its rails with {0.5e-3 * load:.3g} kN a wheel; {usual}: masses, gravity or {_UNITS}"
            break
    yield from _absurdly_small(draft, model)
    time = model.case.time
    lateral, moving = draft.values("lateral"), [model.body_index(body) for body in model.lateral_bodies]
    largest = float(np.ptp(lateral[:, moving], axis=0).max()) if len(lateral) and moving else 0.0
    if not model.case.integration.fixed and time.absolute_tolerance > max(largest, LEAST_TOLERANCE):
        tolerance = f"the absolute tolerance, {1e3 * time.absolute_tolerance:.3g} mm,"
        yield f"{tolerance} is larger than the largest lateral motion, {1e3 * largest:.3g} mm, which is lost: it or {_UNITS}"
    yield from _coarse(json.loads(draft.attributes["solver_statistics"]))
    name, frequency = _fastest(model)
    step = model.case.integration.step
    if model.case.integration.fixed and step and 2.0 * math.pi * frequency * step > math.pi:
        mode = f"{name} has a mode of {frequency:.3g} Hz, faster than the step of {1e3 * step:.3g} ms resolves"
        yield f"{mode}: stiffness, masses or {_UNITS}"


def _absurdly_small(draft: Draft, model: AssembledModel) -> Iterator[str]:
    """Speeds and friction whose unit or exponent may not be what is meant."""
    case, distance = model.case, draft.values("distance")
    covered = float(np.ptp(distance)) if len(distance) else 0.0
    if 0.0 < abs(case.motion.speed) < LEAST_SPEED and covered < 2.0 * math.pi * case.vehicle.data.wheel.radius:
        way = f"at {case.motion.speed:.3g} m/s the run covers {covered:.3g} m, less than a turn of a wheel"
        yield f"{way}: the speed or {_UNITS}"
    rails = [case.adhesion.rail, *(piece.rail for piece in case.adhesion.piece)] if case.adhesion else [case.contact]
    least = min(rail.friction.mu_0 for rail in rails)
    if 0.0 < least < LEAST_FRICTION:
        yield f"a coefficient of friction of {least:.3g} is less than that of any rail: it or {_UNITS}"


def _coarse(counted: Mapping[str, float]) -> Iterator[str]:
    """Steps that were the shortest of their method and still not within the tolerance; (T3)."""
    coarse, steps, error = (counted[name] for name in ("coarse_steps", "steps", "largest_error"))
    if coarse > COARSE_STEPS * steps or error > LARGEST_ERROR:
        yield (
            f"{coarse:g} of {steps:g} steps have an error above the tolerance, up to {error:.2g} times it: they are not halved "
            "below a 32nd of time.step; shorten that, or take time.method = 'rodas4'"
        )


def _fastest(model: AssembledModel) -> tuple[str, float]:
    """The element with the largest stiffness over the mass between its ends, and the frequency of that [Hz]."""
    found = ("", 0.0)
    for element in model.case.vehicle.data.elements_in(model.case.vehicle.part):
        masses = [math.inf if body in model.fixed else model.masses[body] for body in element.between]
        inverse = sum(1.0 / mass for mass in masses)
        for direction, law in element.laws.items():
            if direction in ("x", "y", "z") and law.stiffness:
                frequency = math.sqrt(law.stiffness * inverse) / (2.0 * math.pi)
                found = max(found, (element.name, frequency), key=lambda one: one[1])
    return found
