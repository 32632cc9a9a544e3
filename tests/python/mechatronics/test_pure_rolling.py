"""The rig without what the control law leaves out: ideal rolling, ideal drives, exact torque."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from rollerrig import ConfigError, load_case, simulate
from rollerrig.config import Case, Rig
from rollerrig.study.runs.adhesion import track_case

IDEAL = {
    "contact.pure_rolling": True,
    "rig_control.estimator.kind": "exact",
    "rig_control.feedback.kind": "none",
    "rig_control.motor.bandwidth": 1e6,
    "slide_protection": None,  # no switching: the two runs must be comparable to the last digits
    "time.duration": "3.4 s",
}


def ideal(step: float) -> Case:
    return load_case("adhesion_brake").with_changes(
        {**IDEAL, "time.sampling_step": step, "rig_control.sample_time": step}
    )


def numbers(case: Case) -> tuple[float, float, float, float]:
    """r, R, J_w, J_r."""
    vehicle, rig = case.vehicle.data, case.support.data
    assert isinstance(rig, Rig)
    wheelset = next(body for body in vehicle.body if body.kind == "wheelset")
    return vehicle.wheel.radius, rig.roller_radius, wheelset.inertia[1], rig.roller_inertia[1]


def error_of_the_law(case: Case, run: xr.Dataset) -> xr.DataArray:
    """Axle speed less the virtual one and less what the bogie's own motion along x does to it, (D14) [rad/s]."""
    r, big_r, j_w, j_r = numbers(case)
    share = (j_r / big_r) / (j_r * r / big_r + big_r * j_w / r)
    along = r * run["axle_speed"] - big_r * run["roller_speed"]
    return run["axle_speed"] - run["virtual_speed"] - share * along


def test_the_wheels_turn_as_the_virtual_ones_to_integration_tolerance() -> None:
    """What is left is the sampling: the virtual train holds a torque that changes over the step. It vanishes with it."""
    errors = []
    for step in (1e-3, 0.5e-3):
        case = ideal(step)
        run = simulate(case)
        errors.append(error_of_the_law(case, run))
        slip = 1.0 - numbers(case)[0] * run["virtual_speed"] / run["train_speed"]
        assert float(slip.max()) > 0.03  # they slide on the virtual rail
        assert run.attrs["energy_relative_residual"] < 1e-7
    coarse, fine = (float(np.abs(e).max()) for e in errors)
    assert coarse < 0.02  # 3e-4 of the speed: half a step late under a torque of some kN m
    assert coarse / fine == pytest.approx(2.0, rel=0.02)  # first order
    limit = 2.0 * errors[1] - errors[0]
    assert float(np.abs(limit).max()) < 1e-4  # of 72 rad/s; what is left is of second order


def test_ideal_rolling_is_free_of_slip() -> None:
    """r w - R W is then the motion of the wheelset along the track, which the springs bound."""
    case = load_case("adhesion_brake").with_changes({"contact.pure_rolling": True, "time.duration": "3 s"})
    r, big_r, *_ = numbers(case)
    run = simulate(case)
    free = simulate(case.with_changes({"contact.pure_rolling": False}))
    along = (r * run["axle_speed"] - big_r * run["roller_speed"]).integrate("time")
    assert float(np.abs(run["real_sliding"][0]).max()) < 1e-12
    assert float(np.abs(along).max()) < 5e-3  # the bogie is some millimetres off the crown, it does not drift
    assert float(free["energy_dissipated_creep"][-1]) > 100.0
    assert abs(float(run["energy_dissipated_creep"][-1])) < 0.1
    # The tie carries what creep carried. The bogie's place on the springs sets its share of the weight.
    late = {"time": slice(2.0, 3.0)}
    np.testing.assert_allclose(
        run["contact_force"].sel(late).mean("time"), free["contact_force"].sel(late).mean("time"), rtol=0.02
    )


def test_ideal_rolling_is_refused_where_it_means_nothing() -> None:
    case = load_case("adhesion_brake").with_changes({"contact.pure_rolling": True})
    assert not track_case(case).contact.pure_rolling
    with pytest.raises(ConfigError, match=r"contact\.pure_rolling: true; allowed with actuators"):
        load_case("bogie_rollers_constant").with_changes({"contact.pure_rolling": True})
