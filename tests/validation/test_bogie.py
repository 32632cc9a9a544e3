"""The whole bogie: limits, symmetries, conservation and derivatives that hold whatever the parameters are."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel
from validation.reference import Run, bogie, equilibrium, kmh, mm

LATERAL, ROLL, YAW = 1, 3, 5
BODIES = ("front_frame", "wheelset_1", "wheelset_2")


def displaced(model: AssembledModel, simulation: _core.Simulation, speed: float, lateral: float) -> np.ndarray:
    """Equilibrium with frame and wheelsets moved aside together [m]."""
    x = equilibrium(simulation, speed).copy()
    for name in BODIES:
        x[simulation.coordinate_index[model.body_index(name)][LATERAL]] += lateral
    return x


def released(
    support: str, speed: float, lateral: float, duration: float, **given: object
) -> tuple[AssembledModel, Run]:
    """A run of the bogie, let go beside the middle."""
    model = bogie(support, speed)
    simulation = _core.Simulation(model.core)
    return model, Run(simulation, displaced(model, simulation, speed, lateral), duration, **given)


def random_state(model: AssembledModel, simulation: _core.Simulation, speed: float, seed: int) -> np.ndarray:
    """Up to 0.02 mm and mrad, 1 mm/s and mrad/s off the equilibrium; every third seed 3 mm aside."""
    rng = np.random.default_rng(seed)
    x = displaced(model, simulation, speed, 3 * mm if seed % 3 == 2 else 0.0)
    coordinates = [i for body in simulation.coordinate_index for i in body if i >= 0]
    rates = [i for body in simulation.rate_index for i in body if i >= 0]
    x[coordinates] += 2e-5 * rng.uniform(-1, 1, len(coordinates))
    x[rates] += 1e-3 * rng.uniform(-1, 1, len(rates))
    return x


# ------------------------------------------------------------------------------------------- rollers grow into a track
def eigenvalues(support: str, speed: float, **changes: object) -> np.ndarray:
    """Of the bogie with rollers held in speed, at the equilibrium [1/s]."""
    model = bogie(support, speed, **changes)
    simulation = _core.Simulation(model.core)
    a = simulation.jacobian(0.0, equilibrium(simulation, speed))[0]
    spins = {simulation.rate_index[model.body_index(name)][4] for name in model.rollers}
    keep = [i for i in range(len(a)) if i not in spins]
    return np.linalg.eigvals(a[np.ix_(keep, keep)])


def largest_relative_difference(reference: np.ndarray, other: np.ndarray) -> float:
    distance = np.abs(reference[:, None] - other[None, :]) / np.abs(reference)[:, None]
    return float(distance[linear_sum_assignment(distance)].max())


def test_eigenvalues_on_large_rollers_converge_to_those_on_track_with_slope_one() -> None:
    speed = 100 * kmh
    track = eigenvalues("uic60_track", speed)
    radii = np.array([10.0, 100.0, 1e3, 1e4])
    difference = np.array(
        [
            largest_relative_difference(
                track, eigenvalues("full_scale_rig", speed, support__roller_radius=f"{radius} m")
            )
            for radius in radii
        ]
    )
    slopes = np.diff(np.log(difference)) / np.diff(np.log(radii))
    assert difference[-1] < 1e-3  # 6.1e-5
    assert slopes == pytest.approx(-1.0, abs=0.05)  # the first, between 10 and 100 m, still feels 1/R^2: -0.961
    assert slopes[1:] == pytest.approx(-1.0, abs=0.005)


# ---------------------------------------------------------------------------------------------------------- derivatives
def richardson(function, x: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Central differences extrapolated twice: error of order step^6."""
    columns = []
    for k, step in enumerate(steps):

        def central(h: float, k: int = k) -> np.ndarray:
            up, down = x.copy(), x.copy()
            up[k] += h
            down[k] -= h
            return (function(up) - function(down)) / (2 * h)

        d1, d2, d4 = central(step), central(step / 2), central(step / 4)
        r1, r2 = (4 * d2 - d1) / 3, (4 * d4 - d2) / 3
        columns.append((16 * r2 - r1) / 15)
    return np.stack(columns, axis=1)


@pytest.mark.parametrize("support", ["full_scale_rig", "uic60_track"])
@pytest.mark.parametrize("seed", range(3))
def test_jacobian_against_extrapolated_differences(support: str, seed: int) -> None:
    speed = 100 * kmh
    model = bogie(support, speed)
    simulation = _core.Simulation(model.core)
    x = random_state(model, simulation, speed, seed)
    # The normal damper is rounded over 0.1 mm/s: rates need steps well below that.
    steps = np.full(len(x), 2e-7)
    steps[[i for body in simulation.rate_index for i in body if i >= 0]] = 2e-5

    a, g, _, _ = simulation.jacobian(0.0, x)
    exact = np.vstack([a, g])
    # Relative to the largest acceleration of the column, and to the largest power of the row (plus 1 kW per unit).
    scale = np.vstack(
        [np.broadcast_to(np.abs(a).max(axis=0), a.shape), 1e3 + np.abs(g).max(axis=1, keepdims=True) + 0 * g]
    )

    def error(steps: np.ndarray) -> np.ndarray:
        difference = richardson(lambda y: np.concatenate(simulation.derivative(0.0, y)), x, steps)
        return (np.abs(exact - difference) / scale).max(axis=0)

    # A knot of a profile, where its third derivative jumps, is a kink of the force; shorter steps stay clear of it.
    errors = np.min([error(steps / shorter) for shorter in (1, 16, 64, 256)], axis=0)
    assert errors.max() < 1e-6


# -------------------------------------------------------------------------------------------------------------- energy
def turned_over(run: Run) -> float:
    """The largest energy that any account moved [J]."""
    names = [name.removeprefix("energy_") for name, unit, _ in _core.run_fields if unit == "J"]
    return max(float(np.abs(run.energy(name) - run.energy(name)[0]).max()) for name in names)


def energy_share(support: str, speed: float, lateral: float) -> tuple[float, float]:
    """Energy put in is stored or turned into heat: what the accounts moved [J], and what is missing of it."""
    _, run = released(support, speed, lateral, 0.5, tolerance=1e-8)
    assert run.status == 0
    share = float(np.abs(run.energy_residual()).max()) / turned_over(run)
    assert share < 1e-6  # 7e-9 to 2e-8
    return turned_over(run), share


@pytest.mark.slow
def test_energy_put_in_is_stored_or_turned_into_heat() -> None:
    """Creeping forward; at speed, on the flange, on track and at rest: test_page.py."""
    energy_share("full_scale_rig", 0.5, 3 * mm)


@pytest.mark.slow
def test_the_energy_residual_falls_with_the_tolerance() -> None:
    residuals = [
        float(np.abs(released("full_scale_rig", 150 * kmh, 3 * mm, 0.3, tolerance=tol)[1].energy_residual()).max())
        for tol in (1e-6, 1e-8)
    ]
    assert (
        residuals[1] < 0.05 * residuals[0]
    )  # the quadratures go with the tolerance: a factor of 100, here with margin


@pytest.mark.slow
def test_heat_is_never_negative() -> None:
    _, run = released("full_scale_rig", 150 * kmh, 6.5 * mm, 0.3, output_step=1e-3)
    for where in ("elements", "normal", "creep"):
        heat = run.energy(f"dissipated_{where}")
        assert np.all(np.diff(heat) >= -1e-6 * heat[-1]), where  # the outputs' interpolation across an impact


# ------------------------------------------------------------------------------------------------------------ symmetry
def mirror(simulation: _core.Simulation, x: np.ndarray) -> np.ndarray:
    """The state seen in a mirror in the plane y = 0: left and right change places."""
    out = x.copy()
    for index in (*simulation.coordinate_index, *simulation.rate_index):
        for direction in (LATERAL, ROLL, YAW):
            if index[direction] >= 0:
                out[index[direction]] = -x[index[direction]]
    nodes = x[-16:]
    primary = nodes[:12].reshape(2, 2, 3)[:, ::-1, :] * [1.0, -1.0, 1.0]
    vertical, lateral = nodes[12:14][::-1], -nodes[14:16][::-1]
    out[-16:] = np.concatenate([primary.ravel(), vertical, lateral])
    return out


@pytest.mark.parametrize("support", ["full_scale_rig", "uic60_track"])
@pytest.mark.parametrize("seed", range(3))
def test_a_mirrored_state_has_mirrored_derivatives(support: str, seed: int) -> None:
    speed = 150 * kmh
    model = bogie(support, speed)
    simulation = _core.Simulation(model.core)
    x = random_state(model, simulation, speed, seed)
    x[-16:] += 1e-6 * np.random.default_rng(seed).uniform(-1, 1, 16)
    f = simulation.derivative(0.0, x)[0]
    g = simulation.derivative(0.0, mirror(simulation, x))[0]
    # Roots are known to 1e-14 m and curvatures change by 1e5 per metre there: 1e-11 of the contact force of 5e4 N on
    # 1.8 t. Evaluating the same state twice differs as much.
    assert mirror(simulation, g) == pytest.approx(f, rel=0, abs=3e-10)


def test_a_mirrored_run_is_the_mirror_image() -> None:
    fixed: dict = {"method": "rk4", "step": 5e-5}  # a chosen step would hang on the last digit of an error estimate
    _, run = released("full_scale_rig", 150 * kmh, 3 * mm, 0.3, **fixed)
    _, mirrored = released("full_scale_rig", 150 * kmh, -3 * mm, 0.3, **fixed)
    for body in range(1, 4):
        for field, sign in (("longitudinal", 1), ("lateral", -1), ("vertical", 1), ("roll", -1), ("yaw", -1)):
            difference = mirrored.body(body, field) - sign * run.body(body, field)
            # Round-off of the contact roots over 24000 evaluations, millimetres of motion.
            assert np.abs(difference).max() < 1e-12, (body, field)


# ---------------------------------------------------------------------------------------------------------- equilibrium
@pytest.mark.parametrize("support", ["full_scale_rig", "uic60_track"])
@pytest.mark.parametrize("speed_kmh", [0.0, 0.36, 60.0, 250.0])
def test_static_wheel_loads_sum_to_the_weight(support: str, speed_kmh: float) -> None:
    speed = speed_kmh * kmh
    model = bogie(support, speed)
    simulation = _core.Simulation(model.core)
    x = equilibrium(simulation, speed)
    fields = [name for name, _, _ in _core.wheel_fields]
    row = simulation.record(0.0, x, np.zeros(simulation.quadrature_count))
    start = len(model.bodies) * len(_core.body_fields)
    wheels = row[start : start + 4 * len(fields)].reshape(4, len(fields))
    vertical = wheels[:, fields.index("vertical_force")]
    weight = (32000 / 2 + 2615 + 2 * 1813) * 9.81
    # The bogie settles by 0.19 mm into its springs and contacts; the secondary springs then carry less.
    settled = x[simulation.coordinate_index[model.body_index("front_frame")][2]]
    assert vertical.sum() == pytest.approx(weight + 2 * 430e3 * settled, rel=1e-9)  # residual of the equilibrium
    assert vertical == pytest.approx(
        vertical.mean(), rel=1e-3
    )  # rolling resistance moves some newtons from wheel to wheel
    assert model.axle_loads == {name: pytest.approx(2 * 54.55e3, rel=2e-4) for name in model.wheelsets}


# ------------------------------------------------------------------------------------------------------------- methods
@pytest.fixture(scope="module")
def reference_run() -> Run:
    return released("full_scale_rig", 150 * kmh, 2 * mm, 0.3, tolerance=1e-10, output_step=1e-3)[1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("given", "tolerance"),
    [  # largest difference [m, rad]; measured with ellipses: 2e-11, 5e-10, 3e-9, 3e-9 (kinks cost order)
        ({"method": "rodas4", "tolerance": 1e-8}, 1e-9),
        ({"method": "dormand_prince", "tolerance": 1e-8}, 1e-8),
        ({"method": "rodas4", "tolerance": 1e-6}, 3e-8),
        ({"method": "rk4", "step": 2e-5}, 3e-7),  # measured 1e-7
    ],
)
def test_methods_agree(reference_run: Run, given: dict, tolerance: float) -> None:
    _, run = released("full_scale_rig", 150 * kmh, 2 * mm, 0.3, output_step=1e-3, **given)
    np.testing.assert_allclose(run.time, reference_run.time, rtol=0.0, atol=1e-12)
    for body in range(1, 4):
        for field in ("lateral", "yaw"):
            difference = run.body(body, field) - reference_run.body(body, field)
            assert np.abs(difference).max() < tolerance, (body, field)


# ------------------------------------------------------------------------------------------------ time and standstill
@pytest.mark.slow
def test_hours_of_running_change_nothing() -> None:
    """The wheels' angles are in no equation: a run that starts after ten hours is the run that starts now."""
    model = bogie("full_scale_rig", 150 * kmh)
    simulation = _core.Simulation(model.core)
    x0 = displaced(model, simulation, 150 * kmh, 2 * mm)
    now = Run(simulation, x0, 0.3, tolerance=1e-8)
    ten_hours = 36000.0
    arguments = {"t0": ten_hours, "final_time": ten_hours + 0.3}
    later = Run(_core.Simulation(model.core), x0, 0.3, t_stop=ten_hours + 0.3, tolerance=1e-8, **arguments)
    assert len(now.time) == len(later.time)
    for body in range(1, 4):
        # The clock resolves 7e-12 s there, 1e-11 m at the lateral speeds of this run; the tolerance's share is as large.
        assert later.body(body, "lateral") == pytest.approx(now.body(body, "lateral"), abs=1e-9)
    wheel_angle = now.body(model.body_index("wheelset_1"), "pitch")
    assert wheel_angle[-1] == pytest.approx(150 * kmh * 0.3 / 0.46, rel=1e-3)


@pytest.mark.parametrize("support", ["full_scale_rig", "uic60_track"])
def test_at_standstill_the_bogie_comes_to_rest(support: str) -> None:
    """Friction holds like a viscous damper below V_s = 0.1 m/s: the bogie creeps, nothing shakes."""
    model, run = released(support, 0.0, 1 * mm, 2.0, tolerance=1e-6)
    assert run.status == 0
    for name in BODIES:
        body = model.body_index(name)
        for field in ("lateral_velocity", "vertical_velocity", "yaw_rate"):
            assert abs(run.body(body, field)[-1]) < 1e-3
    assert run.statistics["steps"] < 5000


# ------------------------------------------------------------------------------------------ a function of the state
def test_right_hand_side_does_not_depend_on_what_was_evaluated_before() -> None:
    """The same bits forwards, backwards and of each state alone, on the flange and off the roller, too."""
    model = bogie("full_scale_rig", 250 * kmh)
    simulation = _core.Simulation(model.core)
    states = np.array([random_state(model, simulation, 250 * kmh, seed) for seed in range(12)])
    states[::4, simulation.coordinate_index[model.body_index(BODIES[0])][LATERAL]] += 6 * mm
    forwards = simulation.derivatives(0.0, states)
    backwards = simulation.derivatives(0.0, states[::-1].copy())[::-1]
    alone = [_core.Simulation(model.core).derivatives(0.0, state[None]).copy()[0] for state in states]
    assert np.array_equal(forwards, backwards)
    assert np.array_equal(forwards, alone)
