"""Cost of the normal contacts: per wheel and evaluation, and of the traction study.

    python benchmarks/normal_contact.py [--traction]

Single thread. Per wheel: search and normal contact, mean over shifts of -5 to 5 mm of the Manchester contact benchmark and of
the bogie's axle load; process time, the smallest of five rounds. Traction: `bogie_rollers_traction` with its own method, wall
time over simulated time.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from rollerrig import load_case, simulate
from rollerrig.config.schema.contact_law import NORMAL_LAWS
from rollerrig.contact_analysis.comparison import compare_contacts


def per_wheel() -> None:
    """Print microseconds per wheel for each normal contact."""
    positions = [(1e-3 * y, 0.0) for y in np.arange(-5.0, 5.1, 1.0)]
    for name in ("contact_benchmark_track", "bogie_rollers_constant"):
        rounds = [compare_contacts(load_case(name), positions)["cost"].to_numpy() for _ in range(5)]
        for model, cost in zip(NORMAL_LAWS, np.min(rounds, axis=0), strict=True):
            print(f"{name:24s} {model:8s} {1e6 * cost:6.2f} us per wheel")


def traction() -> None:
    """Print how many times faster than real time the traction study runs with each normal contact and creep law."""
    for normal in NORMAL_LAWS:
        for creep in ("kalker_saturated", "table"):
            case = load_case("bogie_rollers_traction").with_changes({"contact.normal": normal, "contact.creep": creep})
            best = np.inf
            for _ in range(3):
                start = time.process_time()
                run = simulate(case)
                best = min(best, time.process_time() - start)
            print(f"traction {normal:8s} {creep:18s} {float(run['time'][-1]) / best:6.1f} x real time")


if __name__ == "__main__":
    traction() if "--traction" in sys.argv else per_wheel()
