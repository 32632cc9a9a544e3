"""How long a stability map and a limit-cycle diagram take.

    python benchmarks/stability.py [--no-diagram]

Map: eigenvalues, shapes, names and critical speeds of the whole vehicle at 50 speeds from 60 to 400 km/h, on rollers and on
track, one process. Diagram: the bogie on rollers at 20 speeds up and down from 100 to 290 km/h and the halving to 1 km/h, two
processes.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from rollerrig import load_case
from rollerrig.analysis.limit_cycle_runs import LimitCycleSettings
from rollerrig.analysis.mode_table import stability
from rollerrig.study.limit_cycles import limit_cycles

SPEEDS = np.linspace(60.0, 400.0, 50)


def main() -> None:
    """Print the times, wall clock and processor."""
    for name, label in (("bogie_rollers_constant", "rollers"), ("bogie_track", "track")):
        case = load_case(name).with_changes({"vehicle.cut": "vehicle", "vehicle.body.car_body.locked": ["x"]})
        stability(case, [100.0])  # what is loaded once is not counted
        wall, processor = time.perf_counter(), time.process_time()
        modes = stability(case, SPEEDS.tolist())
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
        critical = modes.attrs["linear_critical_speed_kmh"]
        print(
            f"map, vehicle on {label}, 50 speeds: {wall:.2f} s ({processor:.2f} s of processor); critical {critical:.1f} km/h"
        )
    if "--no-diagram" in sys.argv:
        return
    wall = time.perf_counter()
    speeds = np.linspace(100.0, 290.0, 20).tolist()
    found = limit_cycles(load_case("bogie_rollers_constant"), speeds, 253.0, LimitCycleSettings())
    wall = time.perf_counter() - wall
    simulated = sum(p.duration for p in [*found.up, *found.down])
    runs = len(found.up) + len(found.down)
    print(
        f"limit cycles, bogie on rollers: {wall:.1f} s for {runs} runs of {simulated:.0f} s together; "
        f"{found.kind}, nonlinear critical {3.6 * found.lowest_cycle:.1f} km/h"
    )


if __name__ == "__main__":
    main()
