"""Eigenvalues of the rig's loop: the controller by differences of the code that runs, against its equations written again."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from rollerrig import load_case
from rollerrig.analysis.control_loop import Loop, creep_slope, loop_of, wheel_of
from rollerrig.analysis.loop_stability import ABOVE, Plant, gain_limit, growth, rolling_plant, vehicle_plant
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.assembly.train_axles import train_mass
from rollerrig.config import Case
from rollerrig.study.runs.control import loop_case
from validation.independent_loop import controller_matrix

FACTORS = (1.0, 8.0, 30.0)


@cache
def base(name: str) -> tuple[Case, float, Plant]:
    """Case, slope of its real creep, its vehicle."""
    step = {"time.sampling_step": 1e-3, "rig_control.sample_time": 1e-3, "time.output_step": 1e-3}
    case = loop_case(load_case(name).with_changes({**step, "slide_protection": None, "wheel_slip_control": None}))
    return case, creep_slope(case), vehicle_plant(case)


def drawn(rng: np.random.Generator, case: Case) -> Case:
    """A case with another controller, drive, sampling, speed and friction."""

    def between(low: float, high: float) -> float:
        return float(low * (high / low) ** rng.random())

    sample = float(rng.choice([1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2]))
    step, wheel = min(sample, 1e-3), wheel_of(case)
    wrong = {name: 1.0 + 0.05 * rng.uniform(-1.0, 1.0) for name in ("wheelset_inertia", "roller_inertia")}
    return case.with_changes(
        {
            "time.sampling_step": step,
            "rig_control.sample_time": sample,
            "rig_control.delay": step * int(rng.choice([0, 1, 2, 3, 20])),
            "rig_control.estimator.kind": str(rng.choice(["observer", "kalman", "filtered_derivative"])),
            "rig_control.estimator.bandwidth": between(2.0, 100.0),
            "rig_control.axle_torque.kind": str(rng.choice(["known", "estimated", "extrapolated"])),
            "rig_control.drive_command.kind": str(rng.choice(["lead", "direct", "torque_loop"])),
            "rig_control.motor.bandwidth": between(5.0, 200.0),
            "rig_control.motor.damping_ratio": float(rng.choice([0.0, 0.7])),
            "rig_control.feedback.bandwidth": between(0.2, 5.0),
            "rig_control.assumed.wheelset_inertia": wheel.wheelset_inertia * wrong["wheelset_inertia"],
            "rig_control.assumed.roller_inertia": wheel.roller_inertia * wrong["roller_inertia"],
            "motion.speed": f"{between(8.0, 250.0)} km/h",
            "rig_control.loads": str(rng.choice(["computed", "measured"])),
            "adhesion.rail.friction.mu_0": between(0.1, 0.6),
        }
    )


def by_equations(case: Case, loop: Loop, *, sliding: bool) -> Loop:
    """The same loop with the controller of the equations."""
    mass, changes = train_mass(assemble_with_actuators(case)), {}
    for name in ("proportional", "integral"):
        changes[f"rig_control.feedback.{name}"] = 0.0
    own, without = (controller_matrix(c, loop.axles, mass, sliding=sliding) for c in (case, case.with_changes(changes)))
    return replace(loop, controller=own, feedback=own - without)


def rates(loop: Loop, plant: Plant) -> np.ndarray:
    """Growth over FACTORS, of all motions and above ABOVE; what decays within milliseconds is as good as none."""
    found = [growth(loop.scaled(f), plant, above)[0] for f in FACTORS for above in (0.0, ABOVE)]
    return np.fmax(found, -500.0)


@pytest.mark.parametrize("name", ["adhesion_brake", "scaled_brake"])
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 3))])
def test_the_code_that_runs_has_the_eigenvalues_of_the_equations(seed: int, name: str) -> None:
    rng = np.random.default_rng(seed)
    original, creep, vehicle = base(name)
    for _ in range(25 if seed else 2):
        case = drawn(rng, original)
        for sliding in (False, True):
            loop = loop_of(case, creep, sliding=sliding)
            assert loop is not None
            other = by_equations(case, loop, sliding=sliding)
            for plant in (vehicle, rolling_plant(loop)):
                # Differences of the core's code have six digits, its slope of creep is taken over a small slip.
                np.testing.assert_allclose(rates(loop, plant), rates(other, plant), rtol=1e-3, atol=1e-3)
                expected = pytest.approx(gain_limit(other, plant, 1e3), rel=1e-4, nan_ok=True)
                assert gain_limit(loop, plant, 1e3) == expected
