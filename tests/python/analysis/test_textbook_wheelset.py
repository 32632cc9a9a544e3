"""A conical wheelset on track against the two-degree-of-freedom wheelset of the textbooks.

    m y'' = -2 f22 s ((s y' / V) - psi) - 2 f23 s psi' / V - W lambda y / l
    I psi'' = -2 f11 l (lambda y / r + l psi' / V) + 2 f23 ((s y' / V) - psi) - 2 f33 psi' / V + W lambda l psi

with the linear creep coefficients of Kalker, the conicity lambda, half the distance of the contacts l, the load W, and
s = 1 + r lambda / l: while the wheelset moves sideways it climbs and rolls, and its contacts move s times as far.
Source: A. H. Wickens, Fundamentals of Rail Vehicle Dynamics, 2003, chapter 2.
"""

from __future__ import annotations

import numpy as np
import pytest

from rollerrig import _core
from rollerrig.analysis.modes import Lineariser
from rollerrig.config import Case, load_case
from rollerrig.results import Outcome, run_dataset

CONICITY = 1 / 40
HALF_DISTANCE = 0.755
"""Where the rail has the slope of the cone [m]."""


@pytest.fixture(scope="module")
def case() -> Case:
    cone = {"kind": "cone", "conicity": CONICITY}
    paper = {"contact.normal": "hertz", "contact.creep": "kalker_saturated"}  # its coefficients are the textbook's
    return load_case("contact_benchmark_track").with_changes({"vehicle.wheel.profile": cone, **paper})


@pytest.fixture(scope="module")
def lineariser(case) -> Lineariser:
    return Lineariser(case)


def creep_coefficients(case: Case, lineariser: Lineariser) -> tuple[float, float, float, float]:
    """f11, f22, f23, f33 of one wheel in steady rolling, from the size of its patch."""
    simulation = lineariser.simulation_at(20.0)
    row = simulation.record(0.0, lineariser.at(20.0).equilibrium, np.zeros(simulation.quadrature_count))
    wheel = run_dataset(lineariser.model, np.zeros(1), row[None, :], Outcome("ok", "", 0.0, "", {}, {}))
    wheel = wheel.isel(time=0, wheel=0, patch=0)
    a, b, material = float(wheel["patch_a"]), float(wheel["patch_b"]), case.contact.material
    c11, c22, c23, c33 = _core.kalker_coefficients(a / b, material.poisson_ratio)
    area = material.shear_modulus * a * b
    return area * c11, area * c22, area * np.sqrt(a * b) * c23, area * a * b * c33


def textbook(case: Case, lineariser: Lineariser, speed: float) -> np.ndarray:
    """The four eigenvalues [1/s]."""
    f11, f22, f23, f33 = creep_coefficients(case, lineariser)
    (body,) = case.vehicle.data.body
    mass, yaw_inertia, radius = body.mass, body.inertia[2], case.vehicle.data.wheel.radius
    half, weight = HALF_DISTANCE, body.mass * 9.81
    s = 1 + radius * CONICITY / half
    stiffness = np.array(
        [
            [weight * CONICITY / half, -2 * f22 * s],
            [2 * f11 * half * CONICITY / radius, 2 * f23 - weight * CONICITY * half],
        ]
    )
    damping = np.array([[2 * f22 * s**2, 2 * f23 * s], [-2 * f23 * s, 2 * f11 * half**2 + 2 * f33]]) / speed
    inertia = np.diag([1 / mass, 1 / yaw_inertia])
    system = np.block([[np.zeros((2, 2)), np.eye(2)], [-inertia @ stiffness, -inertia @ damping]])
    return np.linalg.eigvals(system)


@pytest.mark.parametrize(("speed", "fast_too"), [(5.0, False), (20.0, True), (50.0, True), (100.0, True)])
def test_eigenvalues_are_those_of_the_textbook(case, lineariser, speed: float, fast_too: bool) -> None:
    values = np.linalg.eigvals(lineariser.at(speed).matrix)
    for expected in textbook(case, lineariser, speed):
        # at 5 m/s the two fast decays, 600 1/s, come near the wheelset's roll on its Hertz springs, 800 rad/s: no textbook's case
        if not fast_too and abs(expected) > 100.0:
            continue
        nearest = values[np.argmin(np.abs(values - expected))]
        # the textbook leaves out terms of the order of the conicity, 2.5 %, and the wheelset's inertia in roll
        assert abs(nearest - expected) < 0.05 * abs(expected), expected


def test_the_weaving_grows_faster_the_faster_it_runs(case, lineariser) -> None:
    """A free wheelset is unstable at any speed: its inertia, as V^2 against creep forces as 1/V, grows it as V^3."""
    rates = []
    for speed in (5.0, 10.0):
        values = np.linalg.eigvals(lineariser.at(speed).matrix)
        rates.append(max(values[np.abs(values.imag) > 0.5], key=lambda z: z.real).real)
    # What spin and gravity add at any speed goes with V: 2 % here.
    assert rates[1] == pytest.approx(8 * rates[0], rel=0.03)
