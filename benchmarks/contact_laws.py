"""What a call of each creep law costs, and a whole run with it, side by side on this machine.

    python benchmarks/contact_laws.py [--calls N]

Creepages are drawn at random from stick to full sliding, on an ellipse a/b = 1.25; the loop over the calls is compiled and its
share is counted. Best of seven. The last column is a run of the traction case (bogie on rollers, 10 s simulated) with that law.
"""

from __future__ import annotations

import argparse

import numpy as np
from rich.console import Console
from rich.table import Table
from timing import best_time

import rollerrig as rr
from rollerrig import _core
from rollerrig.assembly.laws import creep_law
from rollerrig.config.schema.contact import CREEP_LAWS

BUDGET = {"kalker_saturated": 0.1, "table": 0.5, "fastsim": 3.0, "modified_fastsim": 3.0}
"""What a call may cost [us]."""
PARAMETERS = {"polach": {"k_A": 1.0, "k_S": 0.4}}
CASE = "bogie_rollers_traction"


def per_call(name: str, calls: int) -> float:
    """Seconds of processor time."""
    law = creep_law(name, **PARAMETERS.get(name, {}))
    creepage = np.random.default_rng(1).normal(size=(calls, 3)) * [3e-3, 3e-3, 0.5]
    return best_time(lambda: _core.creep_forces(creepage, 5e-3, 4e-3, 8e4, 0.3, 82e9, 0.28, law), 7) / calls


def run_time(name: str) -> tuple[float, float]:
    """Seconds of processor time of the traction case, and simulated seconds."""
    case = rr.load_case(CASE).with_changes({"contact.creep": {"kind": name, **PARAMETERS.get(name, {})}})
    return best_time(lambda: rr.simulate(case), 3), case.time.duration


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--calls", type=int, default=20_000)
    calls = parser.parse_args().calls
    table = Table("law", "us per call", "budget us", "run of the traction case s", "times real time")
    for name in CREEP_LAWS:
        seconds, (run, simulated) = per_call(name, calls), run_time(name)
        budget = f"{BUDGET[name]:g}" if name in BUDGET else ""
        table.add_row(name, f"{1e6 * seconds:.3f}", budget, f"{run:.3f}", f"{simulated / run:.0f}")
    Console(width=110).print(table)


if __name__ == "__main__":
    main()
