"""Runs with phonic wheels: the vehicle's own for its slide protection, the rig's for its controller."""

from __future__ import annotations

import numpy as np
import pytest

from rollerrig import ConfigError, load_case, simulate
from rollerrig.simulation.controllers import MEASUREMENTS
from rollerrig.study.runs.adhesion import track_case

PULSES = {"kind": "pulse_period", "teeth": 100.0}


def test_slide_protection_works_with_the_pulses_of_100_teeth() -> None:
    """From 120 km/h on low adhesion: as many slides are caught, and no wheel locks, as with exact speeds."""
    case = load_case("adhesion_brake").with_changes({"time.duration": "8 s"})
    exact, pulsed = simulate(case), simulate(case.with_changes({"sensors.vehicle": PULSES}))
    for run in (exact, pulsed):
        assert float(run["dump_cycles"].isel(time=-1).sum()) >= 8
        assert float(run["axle_speed"].min()) * 0.46 > 10.0
    assert float(pulsed["train_distance"][-1]) == pytest.approx(float(exact["train_distance"][-1]), rel=2e-3)
    error = pulsed["vehicle_axle_speed"] - pulsed["axle_speed"]
    assert 0.0 < float(abs(error).max()) < 6.0, "an age of some 10 ms at 400 rad/s^2"
    assert float(np.sqrt((error**2).mean())) < 0.3
    assert (pulsed["measured_axle_speed"] != pulsed["vehicle_axle_speed"]).any(), "the rig has sensors of its own"


def test_without_its_own_sensors_the_vehicle_sees_those_of_the_rig() -> None:
    run = simulate(load_case("adhesion_brake").with_changes({"sensors.axles": PULSES, "time.duration": "2 s"}))
    assert (run["measured_axle_speed"] == run["vehicle_axle_speed"]).all()


@pytest.mark.parametrize("speed", [1.0, 83.0])
def test_the_whole_range_of_speeds_reads_right_on_a_rolling_train(speed: float) -> None:
    changes = {
        "motion.speed": f"{speed} m/s",
        "motion.stop_speed": 0.1,
        "brake.demand": [[0.0, 0.0], [10.0, 0.0]],
        "time.duration": "2 s",
        "sensors.vehicle": PULSES,
    }
    run = simulate(track_case(load_case("adhesion_brake")).with_changes(changes)).sel(time=slice(0.5, None))
    ratio = run["vehicle_axle_speed"] / run["axle_speed"]
    assert float(abs(ratio - 1.0).max()) < 2e-3


def test_a_controller_of_the_user_sees_the_sensors_of_its_side() -> None:
    class Watching:
        sample_time = 5e-3

        def __init__(self) -> None:
            self.seen: list[np.ndarray] = []

        def step(self, measurements: dict[str, np.ndarray]) -> dict[str, list[float]]:
            self.seen.append(measurements["axle_speed"].copy())
            return {"valve": [0.0, 0.0]}

    watching = Watching()
    changes = {"sensors.vehicle": {"kind": "pulse_frequency", "gate_time": "50 ms"}, "time.duration": "1.2 s"}
    run = simulate(load_case("adhesion_brake").with_changes(changes), controllers={"slide_protection": watching})
    seen = np.array(watching.seen)[::2][: run.sizes["time"]]
    assert "axle_speed" in MEASUREMENTS
    own = run["vehicle_axle_speed"].transpose("time", "axle").to_numpy()[1 : len(seen)]
    assert abs(seen[1:] - own).max() < 1e-4, "single precision of results"
    assert len(np.unique(seen)) < 30, "in steps of one edge per gate"


@pytest.mark.parametrize(
    ("sensors", "message"),
    [
        ({"vehicle": {"kind": "pulse_period", "teeth": 0}}, "sensors.vehicle.teeth: 0; allowed: a number, from 1 to"),
        ({"axles": {"kind": "pulse_frequency", "teeth": -80}}, "sensors.axles.teeth: -80"),
        ({"rollers": {"kind": "pulse_period", "timeout": 0}}, "sensors.rollers.timeout: 0"),
        ({"vehicle": {"kind": "radar"}}, "sensors.vehicle.kind: 'radar'; allowed: "),
    ],
)
def test_what_no_sensor_has_is_refused_by_name(sensors: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        load_case("adhesion_brake").with_changes({f"sensors.{key}": value for key, value in sensors.items()})
    assert message in str(caught.value)
