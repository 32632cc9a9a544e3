"""The right-hand side against the same bogie written independently in NumPy (independent_model).

Both models get the same profiles, Kalker's table by the same spline and the same suspension points; the rest, from the
geometry of the contact to the Euler equations, is separate code. Two conventions differ and are kept out of the
comparison: we smooth the spin force and the rolling speed near standstill by different factors (the speed V_s is set to
nearly zero), and our rolling speed is that past a contact point that travels with the wheelset (its x velocity is zero).
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from rollerrig import _core
from rollerrig.profiles import ProfileTable
from validation.independent_model.bogie import contact_of, rhs
from validation.independent_model.kalker_table import AXIS_RATIO, COEFFICIENTS, POISSON
from validation.independent_model.parameters import Parameters, Table
from validation.reference import bogie, equilibrium

REGULARISATION_SPEED = 1e-6  # [m/s]
SPEED = 60.0  # [m/s]

#: For each state of the NumPy model ours. Theirs: positions and rates body by body, dampers side by side.
OURS_OF_THEIRS = np.r_[
    0:6, 16:22, 6:11, [22, 23, 24, 25, 27, 26], 11:16, [28, 29, 30, 31, 33, 32], 34, 35, 36:48, 48, 50, 49, 51
]
COORDINATES, RATES, NODES = np.r_[0:16], np.r_[16:34], np.r_[36:52]
LONGITUDINAL_RATES, LATERAL = [22, 28], [7, 12]  # of the wheelsets


def test_kalkers_table_is_the_same_number_by_number() -> None:
    for row, ratio in zip(COEFFICIENTS, AXIS_RATIO, strict=True):
        for printed, nu in zip(row.T, POISSON, strict=True):
            assert _core.kalker_coefficients(ratio, nu) == pytest.approx(printed, rel=1e-12), (ratio, nu)


@pytest.fixture(scope="module")
def models() -> SimpleNamespace:
    ours = bogie(
        contact__normal={"kind": "hertz", "merging_criterion": 0.0},
        contact__creep="kalker_saturated",
        contact__creepage_regularisation_speed=REGULARISATION_SPEED,
    )
    simulation = _core.Simulation(ours.core)

    def table(profile: ProfileTable) -> Table:
        return Table(profile.start, profile.step, np.asarray(profile.coefficients))

    parameters = Parameters(
        hold_rollers=True,
        torque=0.0,
        wheel=table(ours.wheel_profile),
        rail=table(ours.rail_profile),
        rail_origin=ours.rail_origin_y,
        secondary_top=0.8275,
        secondary_bottom=0.8275,
        lateral_damper_y=0.2,
        creepage_regularisation_speed=REGULARISATION_SPEED,
    )
    return SimpleNamespace(
        simulation=simulation,
        theirs=lambda x: rhs(0.0, x, parameters),
        patches=lambda x: len(contact_of(x, parameters)["s"]),
        start=equilibrium(simulation, SPEED),
    )


def random_state(start: np.ndarray, seed: int) -> np.ndarray:
    """Around the equilibrium: up to 0.1 mm and mrad, 3 mm/s and mrad/s; odd seeds up to 6.5 mm aside, on the flange."""
    rng = np.random.default_rng(seed)
    x = start.copy()
    size = 10 ** rng.uniform(-5, -4)
    x[COORDINATES] += size * rng.uniform(-1, 1, COORDINATES.size)
    x[NODES] += size * rng.uniform(-1, 1, NODES.size)
    x[RATES] += 30 * size * rng.uniform(-1, 1, RATES.size)
    x[LONGITUDINAL_RATES] = 0.0
    if seed % 2:
        x[LATERAL] += rng.uniform(-6.5e-3, 6.5e-3, 2)
    return x


@pytest.mark.parametrize("seed", range(12))
def test_right_hand_sides_agree(models: SimpleNamespace, seed: int) -> None:
    x = random_state(models.start, seed)
    ours = models.simulation.derivative(0.0, x)[0][OURS_OF_THEIRS]
    theirs = models.theirs(x[OURS_OF_THEIRS])
    # Contact forces of 5e4 N shift by 1e-6 of themselves where a root of the scan is off by 1e-13 m, and where the Hertz
    # functions are tables (1e-9); without contact the two agree to 1e-11.
    assert np.abs(ours - theirs) == pytest.approx(0.0, abs=1e-6 * max(1.0, np.abs(theirs[17:34]).max()))


def test_the_states_that_are_compared_have_many_contacts(models: SimpleNamespace) -> None:
    counts = [models.patches(random_state(models.start, seed)[OURS_OF_THEIRS]) for seed in range(12)]
    assert sum(counts) > 30


def test_equilibria_agree(models: SimpleNamespace) -> None:
    assert np.abs(models.theirs(models.start[OURS_OF_THEIRS])).max() < 1e-6  # [m/s^2], [rad/s^2]; ours leaves 1e-9 N
