"""Every kind of model the configuration can build: exact Jacobian, closed energy, the static load, the rigid limit."""

from __future__ import annotations

import numpy as np
import pytest

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.config import load_case
from validation.reference import Run, equilibrium
from validation.test_bogie import richardson, turned_over

MOUNTING = {
    "lateral": {"stiffness": 5e7, "damping": 5e4},
    "vertical": {"stiffness": 3e8, "damping": 1e5},
    "yaw": {"stiffness": 5e7, "damping": 5e4},
}
VARIANTS: dict[str, dict[str, object]] = {
    "elastic rollers": {"support.mounting": MOUNTING},
    "elastic rollers, left and right apart": {"support.mounting": MOUNTING, "support.coupling": "independent"},
    "left and right apart": {"support.coupling": "independent"},
    "free rollers": {"motion.drive": "free"},
    "torque on the rollers": {"motion.drive": "torque", "motion.torque_table": [[0.0, 0.0], [0.2, 500.0]]},
    "torque on the wheelsets": {
        "motion.drive": "free",
        "axle_torque": [
            {"wheelset": "wheelset_1", "reacts_on": "front_frame", "table": [[0.0, 0.0], [0.3, 2000.0]]},
            {"wheelset": "wheelset_2", "reacts_on": "none", "table": [[0.0, 0.0], [0.3, 2000.0]]},
        ],
    },
    "speed table": {"motion.speed_table": [[0.0, "20 m/s"], [1.0, "25 m/s"]], "motion.speed": "20 m/s"},
    "track, speed table": {
        "support.use": "uic60_track",
        "motion.speed_table": [[0.0, "20 m/s"], [1.0, "25 m/s"]],
        "motion.speed": "20 m/s",
    },
    "the paper's contact": {"contact.normal": "hertz", "contact.creep": "kalker_saturated"},
    "spin moment saturated": {"contact.creep": {"kind": "kalker_saturated", "saturate_spin_moment": True}},
    "whole vehicle": {"vehicle.cut": "vehicle"},
    "whole vehicle on track": {"vehicle.cut": "vehicle", "support.use": "uic60_track"},
    "one wheelset": {"vehicle.cut": "leading_wheelset"},
}
SPEED = 20.0  # [m/s]
TIME = 0.1  # [s], within all tables


def variant(name: str) -> tuple[AssembledModel, _core.Simulation, np.ndarray]:
    """Model, simulation and a state a little off its equilibrium at TIME."""
    changes = {"motion.speed": f"{SPEED} m/s", "disturbance": [], **VARIANTS[name]}
    model = assemble(load_case("bogie_rollers_constant").with_changes(changes))
    simulation = _core.Simulation(model.core)
    result = simulation.equilibrium(SPEED, 0.0, [])
    assert result["converged"], result
    return model, simulation, result["x"]


def disturbed(simulation: _core.Simulation, x: np.ndarray, seed: int = 4) -> np.ndarray:
    rng = np.random.default_rng(seed)
    out = x.copy()
    for index, size in ((simulation.coordinate_index, 1e-5), (simulation.rate_index, 1e-3)):
        places = [i for body in index for i in body if i >= 0]
        out[places] += size * rng.uniform(-1, 1, len(places))
    return out


@pytest.mark.parametrize("name", VARIANTS)
def test_the_jacobian_is_exact_in_every_variant(name: str) -> None:
    _, simulation, x = variant(name)
    x = disturbed(simulation, x)
    a, g, f_t, g_t = simulation.jacobian(TIME, x)
    n = len(x)
    steps = np.full(n, 2e-7)
    steps[[i for body in simulation.rate_index for i in body if i >= 0]] = 2e-5
    exact = np.vstack([a, g])
    scale = np.vstack(
        [np.broadcast_to(np.abs(a).max(axis=0), a.shape), 1e3 + np.abs(g).max(axis=1, keepdims=True) + 0 * g]
    )

    def both(y: np.ndarray, t: float = TIME) -> np.ndarray:
        return np.concatenate(simulation.derivative(t, y))

    def error(steps: np.ndarray) -> np.ndarray:
        return (np.abs(exact - richardson(both, x, steps)) / scale).max(axis=0)

    # Shorter steps stay clear of the knots of a profile that are near; differences are good to 1e-7.
    assert np.min([error(steps / shorter) for shorter in (1, 16, 64, 256)], axis=0).max() < 1e-6
    difference = (both(x, TIME + 1e-4) - both(x, TIME - 1e-4)) / 2e-4
    assert np.concatenate([f_t, g_t]) == pytest.approx(difference, rel=1e-6, abs=1e-4 * (1 + np.abs(difference).max()))


@pytest.mark.slow
@pytest.mark.parametrize("name", VARIANTS)
def test_energy_closes_in_every_variant(name: str) -> None:
    model, simulation, x = variant(name)
    x = x.copy()
    for body in model.wheelsets:
        x[simulation.coordinate_index[model.body_index(body)][1]] += 1e-3
    run = Run(simulation, x, 0.2, tolerance=1e-8, breakpoints=list(model.breakpoints))
    assert run.status == 0
    assert np.abs(run.energy_residual()).max() < 1e-6 * turned_over(run)


@pytest.mark.parametrize(
    "name", [name for name in VARIANTS if "vehicle" not in name and "wheelset" not in name and "track" not in name]
)
def test_rollers_carry_the_bogie_in_every_variant(name: str) -> None:
    model, simulation, x = variant(name)
    row = simulation.record(0.0, x, np.zeros(simulation.quadrature_count))
    fields = [field for field, _, _ in _core.wheel_fields]
    start = len(model.bodies) * len(_core.body_fields)
    vertical = row[start : start + 4 * len(fields)].reshape(4, len(fields))[:, fields.index("vertical_force")]
    settled = x[simulation.coordinate_index[model.body_index("front_frame")][2]]
    weight = (32000 / 2 + 2615 + 2 * 1813) * 9.81
    assert vertical.sum() == pytest.approx(weight + 2 * 430e3 * settled, rel=1e-8)


def test_elastic_rollers_become_rigid_ones_as_their_bearings_stiffen() -> None:
    """Eigenvalues of the bogie's own modes; the difference falls with 1 / stiffness."""

    def slow_modes(changes: dict[str, object]) -> np.ndarray:
        case = load_case("bogie_rollers_constant").with_changes(
            {"motion.speed": f"{SPEED} m/s", "disturbance": [], **changes}
        )
        simulation = _core.Simulation(assemble(case).core)
        values = np.linalg.eigvals(simulation.jacobian(0.0, equilibrium(simulation, SPEED))[0])
        modes = values[(values.imag > 1.0) & (np.abs(values) < 60 * 2 * np.pi)]
        return modes[np.argsort(modes.imag)]

    rigid = slow_modes({})
    differences = []
    for factor in (1e2, 1e3, 1e4):
        mounting = {
            direction: {"stiffness": factor * spring["stiffness"], "damping": spring["damping"]}
            for direction, spring in MOUNTING.items()
        }
        elastic = slow_modes({"support.mounting": mounting})
        nearest = [elastic[np.argmin(np.abs(elastic - value))] for value in rigid]
        differences.append(np.max(np.abs(nearest - rigid) / np.abs(rigid)))
    assert differences[-1] < 1e-3
    assert differences[1] / differences[0] == pytest.approx(0.1, rel=0.2)
    assert differences[2] / differences[1] == pytest.approx(0.1, rel=0.2)


def test_one_wheelset_less_changes_nothing_but_its_size() -> None:
    """Cost and state grow linearly: the whole vehicle has the states of its parts."""
    sizes = {name: variant(name)[1].state_count for name in ("whole vehicle", "one wheelset")}
    per_wheelset = 11 + 6 + 1  # coordinates and rates, damper nodes of two boxes, roller
    assert sizes["one wheelset"] == per_wheelset
    assert sizes["whole vehicle"] == 4 * per_wheelset + 3 * 12 + 2 * 4


def test_standing_still_at_zero_speed_needs_no_force() -> None:
    _, simulation, _ = variant("one wheelset")
    x = equilibrium(simulation, 0.0)
    assert np.abs(simulation.derivative(0.0, x)[0]).max() < 1e-6
