"""Cost of the normal contacts: per wheel and evaluation, and of the traction study.

    python benchmarks/normal_contact.py [--traction]

Single thread. Per wheel: search, where the law needs one, and normal contact, of one wheel and of batches of 4 and 8; mean over
shifts of -4 to 4 mm of the Manchester contact benchmark and of the bogie's axle load; process
time, the smallest of five rounds. Traction: `bogie_rollers_traction` with its own method, wall time over simulated time.
"""

from __future__ import annotations

import sys

import numpy as np
from timing import best_time

from rollerrig import load_case, simulate
from rollerrig.assembly.model import assemble
from rollerrig.config.schema.contact import NORMAL_LAWS
from rollerrig.contact_analysis.static_contact import contact, leading_wheelset

POSITIONS = [(1e-3 * y, 0.0) for y in np.arange(-4.0, 4.1, 1.0)]  # lateral [m], yaw [rad]
BATCHES = (1, 4, 8)


def microseconds_per_wheel(case_name: str, law: str) -> list[float]:
    """Search and normal contact of a wheel: alone, and in each of BATCHES."""
    chosen = load_case(case_name).with_changes({"contact.normal": law})
    table = contact(chosen, POSITIONS)
    _, _, static, unloaded = leading_wheelset(assemble(chosen))
    costs = []
    for wheels in BATCHES:
        rounds = []
        for _ in range(5):
            times = []
            for lateral, yaw in POSITIONS:
                rows = table.isel(row=((table["lateral"] == lateral) & (table["side"] == "left")).to_numpy())
                z, roll = float(rows["height"][0]) + unloaded, float(rows["roll"][0])
                times.append(static.seconds_per_contact(0.0, lateral, z, yaw, roll, False, wheels, 4000 // wheels))
            rounds.append(np.mean(times))
        costs.append(1e6 * min(rounds))
    return costs


def per_wheel() -> None:
    """Print microseconds per wheel for each normal contact, of one wheel and of batches."""
    for name in ("contact_benchmark_track", "bogie_rollers_constant"):
        for law in NORMAL_LAWS:
            costs = microseconds_per_wheel(name, law)
            row = ", ".join(f"{cost:.2f} of {wheels}" for wheels, cost in zip(BATCHES, costs, strict=True))
            print(f"{name:24s} {law:8s} us per wheel: {row}")


def traction() -> None:
    """Print how many times faster than real time the traction study runs with each normal contact and creep law."""
    for normal in NORMAL_LAWS:
        for creep in ("kalker_saturated", "table"):
            case = load_case("bogie_rollers_traction").with_changes({"contact.normal": normal, "contact.creep": creep})
            speed = case.time.duration / best_time(lambda: simulate(case), 3)  # noqa: B023
            print(f"traction {normal:8s} {creep:18s} {speed:6.1f} x real time")


if __name__ == "__main__":
    traction() if "--traction" in sys.argv else per_wheel()
