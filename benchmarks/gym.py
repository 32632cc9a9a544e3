"""What a step of the Gymnasium environment costs: processor time of one, and steps per second of one per core.

python benchmarks/gym.py
"""

from __future__ import annotations

import time

import numpy as np

from rollerrig.interfaces.gym import BenchEnv, make_vector

STEPS = 2000


def main() -> None:
    """One environment, then one per core."""
    env = BenchEnv()
    env.reset(seed=1)
    begun = time.process_time()
    for _ in range(STEPS):
        env.step([0, 0])
    each = (time.process_time() - begun) / STEPS
    milliseconds = 1e3 * env.period
    print(
        f"one: {1e6 * each:.0f} us a step of {milliseconds:g} ms, {1e6 * each / milliseconds:.1f} us per ms of the bench"
    )
    vector = make_vector()
    vector.reset(seed=1)
    actions = np.zeros((vector.num_envs, 2), dtype=int)
    begun = time.perf_counter()
    for _ in range(STEPS // 4):
        vector.step(actions)
    rate = STEPS // 4 * vector.num_envs / (time.perf_counter() - begun)
    print(f"{vector.num_envs} processes: {rate:.0f} steps per second together")
    vector.close()


if __name__ == "__main__":
    main()
