"""How far and how fast a run says it went: the integral of its own speed, on track and on rollers, whatever drives them."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr

QUICK = {"time.duration": "2 s"}


def integral_of_speed(run: xr.Dataset) -> np.ndarray:
    speed, time = run["speed"].to_numpy(), run["time"].to_numpy()
    return np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))))


@pytest.mark.parametrize("drive", ["free", "torque", "speed_controlled"])
def test_the_distance_on_a_rig_is_what_its_rollers_have_run(drive: str) -> None:
    changes: dict[str, object] = {**QUICK, "motion.drive": drive, "motion.speed": "20 km/h", "disturbance": []}
    if drive == "free":
        axle = {"reacts_on": "front_frame", "table": [[0.0, 4000.0], [2.0, 4000.0]]}
        changes["axle_torque"] = [{"wheelset": f"wheelset_{k}", **axle} for k in (1, 2)]
    if drive == "torque":
        changes["motion.torque_table"] = [[0.0, 3000.0], [2.0, 3000.0]]
    if drive == "speed_controlled":
        changes["motion.speed_table"] = [[0.0, "20 km/h"], [2.0, "40 km/h"]]
    run = rr.simulate(rr.load_case("bogie_rollers_constant").with_changes(changes))
    assert run.attrs["status"] == "ok"
    assert float(run["speed"][-1]) > 1.2 * float(run["speed"][0])  # it gains speed: V t would be too short
    # The trapezoidal rule over 2 ms misses (2 ms)^2 / 12 times the change of acceleration, far below 1e-6 m.
    np.testing.assert_allclose(run["distance"], integral_of_speed(run), rtol=0, atol=1e-5)
    assert run.attrs["stopped_at_m"] == float(run["distance"][-1])


def test_brakes_on_a_rig_without_a_virtual_train_slow_what_stands_for_the_train() -> None:
    case = rr.load_case("adhesion_brake").model_copy(update={"rig_control": None, "adhesion": None})
    run = rr.simulate(case.with_changes({"time.duration": "3 s"}))
    assert float(run["train_speed"][-1]) < 0.95 * float(run["train_speed"][0])
    np.testing.assert_allclose(run["train_speed"], run["speed"], rtol=1e-12)
    np.testing.assert_allclose(run["train_distance"], run["distance"], rtol=1e-12)
    np.testing.assert_allclose(run["distance"], integral_of_speed(run), rtol=0, atol=1e-3)


def test_the_running_speed_of_a_braked_train_on_track_is_the_trains() -> None:
    case = rr.cases.on_track(rr.load_case("adhesion_brake")).with_changes({"time.duration": "3 s"})
    run = rr.simulate(case)
    assert float(run["speed"][-1]) < 0.98 * float(run["speed"][0])
    np.testing.assert_allclose(run["speed"], run["train_speed"], rtol=1e-12)
    np.testing.assert_allclose(run["distance"], run["train_distance"], rtol=0, atol=1e-9)
