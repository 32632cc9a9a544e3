"""How far does the train run with a brake policy of my own?"""

import numpy as np

import rollerrig as rr
from rollerrig.interfaces.gym import BenchEnv

case = rr.load_case("adhesion_brake").with_changes({"time.duration": "6 s", "rig_control.protection.time": "10 s"})
env = BenchEnv(case, "slide_protection")
speeds = [k for k, name in enumerate(env.observation_names) if name.endswith(".axle_speed")]
radius = case.vehicle.data.wheel.radius


def run(name: str, limit: float) -> None:
    """Vent where an axle slips more than the limit; fill else."""
    observation, info = env.reset(seed=1)
    total, largest, ended = 0.0, 0.0, False
    while not ended:
        slip = 1.0 - radius * observation[speeds] / info["train_speed"]
        largest = max(largest, float(slip.max()))
        observation, reward, terminated, truncated, info = env.step(np.where(slip > limit, 2, 0))
        total, ended = total + reward, terminated or truncated
    print(
        f"{name}: {3.6 * info['train_speed']:.1f} km/h after {info['time']:.1f} s, slip {100 * largest:.0f} %, return {total:.2f}"
    )


run("always filled", 2.0)
run("vent above 20 %", 0.2)
