"""Can a proportional controller of my own hold the wheels of the rig to those of the virtual train?"""

import numpy as np

import rollerrig as rr


class Proportional:
    """The torque of pure rolling, and a correction in proportion to the error of the wheel's speed."""

    sample_time = 1e-3  # s

    def __init__(self, gain: float) -> None:
        self.gain = gain  # N m s/rad

    def step(self, measurements: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        error = measurements["virtual_speed"] - measurements["axle_speed"]
        return {"roller_torque": measurements["feed_forward"] + self.gain * error}


case = rr.load_case("adhesion_brake").with_changes({"time.duration": "8 s"})
for gain in (0.0, 1000.0, 4000.0):
    run = rr.simulate(case, controllers={"rig_control": Proportional(gain)})
    radius = rr.RunInfo.of(run).wheel_radius
    error = radius * (run["axle_speed"] - run["virtual_speed"]) / run["train_speed"]
    print(f"gain {gain:g} N m s/rad: tracking error {100 * float(np.sqrt((error**2).mean())):.3f} % of the speed, RMS")
