"""What one evaluation of the equations of motion costs, and where in it the time goes.

    python benchmarks/right_hand_side.py [--against PYTHON_PATH] [--parts] [--json FILE]

A hunting bogie on rollers at 200 km/h and a whole vehicle on irregular rails at 144 km/h, each with the pairs of contact laws
below, at 1000 states of its own run, 1 ms apart: a wheel at rest would flatter whatever starts from the last evaluation.
Processor time of one core, best of seven.

With --against, the folder that holds another build's package `rollerrig`, both are measured in turn in processes of their own
and the ratio is printed: on a busy machine a ratio is worth more than two times.

With --parts, Linux's `perf` samples the evaluations with strips and table and sorts them by what the program was at. It needs a
build whose functions have names and frame pointers:

    CXXFLAGS=-fno-omit-frame-pointer pip install --no-build-isolation -C cmake.build-type=RelWithDebInfo -e .
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from timing import best_time, elsewhere, states_along

CASES = {
    "bogie on rollers": ("bogie_rollers_constant", {"motion.speed": "200 km/h"}),
    "vehicle on irregular rails": ("vehicle_track_irregular", {}),
}
LAWS = {
    "strips, table": {"contact.normal": "strips", "contact.creep": "table"},
    "hertz, kalker_saturated": {"contact.normal": "hertz", "contact.creep": "kalker_saturated"},
}
STATES = 1000
PARTS = {
    "gap at the nodes": r"scan_gap|scan_minima",
    "normal contact": r"strip|find_regions|find_minima|hertz|contact_point|normal_patches|blending",
    "creep: table": r"read_creep_table",
    "creep: the rest": r"creep_force|patch_forces",
    "placement of the wheels": r"::placement|on_rail|on_roller|axes_along",
    "sums of the patches": r"apply_contact|find_patches",
    "force elements": r"apply_element|element_motion|direction_force",
    "track": r"place_track|Irregularity|travel_now",
    "motion of the bodies": r"update_motion|unpack",
    "actuators and couplings": r"apply_(axle|roller|brake|resist|coup|reaction)",
    "Newton, Euler": r"accelerat|gyroscopic|apply_inertia|apply_weight",
    "the rest": r"",
}
"""What a function's name says of the part it belongs to; the first that fits any caller within the evaluation."""


def states_of(case_name: str, laws: str):
    """The model and its states after each millisecond, shape (STATES, n)."""
    from rollerrig import load_case

    name, changes = CASES[case_name]
    return states_along(load_case(name).with_changes({**changes, **LAWS[laws]}), 1e-3, STATES)


def measure(case_name: str, laws: str) -> float:
    """Microseconds of processor time of one evaluation."""
    from rollerrig import _core

    model, states = states_of(case_name, laws)
    simulation = _core.Simulation(model.core)
    return 1e6 * best_time(lambda: simulation.derivatives(0.0, states), 7) / len(states)


def evaluate_for(seconds: float, case_name: str) -> None:
    """What `perf` looks at."""
    from rollerrig import _core

    model, states = states_of(case_name, "strips, table")
    simulation = _core.Simulation(model.core)
    begun = time.process_time()
    while time.process_time() - begun < seconds:
        simulation.derivatives(0.0, states)


def parts(case_name: str) -> dict[str, float]:
    """Share of each part in an evaluation [-]."""
    with tempfile.NamedTemporaryFile(suffix=".perf") as file:
        record = ["perf", "record", "-q", "-g", "-F", "2000", "-o", file.name]
        subprocess.run([*record, sys.executable, __file__, "--run", case_name], check=True, capture_output=True)
        script = subprocess.run(["perf", "script", "-i", file.name, "-F", "ip,sym"], check=True, capture_output=True)
    found: Counter[str] = Counter()
    for sample in script.stdout.decode().split("\n\n"):
        names = [line.split(None, 1)[1] for line in sample.splitlines() if len(line.split(None, 1)) == 2]
        inside = [i for i, name in enumerate(names) if re.search(r"Dynamics::(derivative|evaluate)", name)]
        # The runs that made the states call it too, from an integrator.
        if not inside or any("advance" in name for name in names):
            continue
        within = names[: inside[0] + 1]
        found[next(part for part, fits in PARTS.items() if any(re.search(fits, name) for name in within))] += 1
    if not found:
        raise SystemExit("perf saw no evaluation: build with names and frame pointers, see --help")
    total = sum(found.values())
    return {part: found[part] / total for part in PARTS}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", default=None, metavar="PYTHON_PATH", help="folder with another build's package")
    parser.add_argument("--parts", action="store_true", help="sort samples of `perf` by part")
    parser.add_argument("--json", type=Path, default=None, metavar="FILE", help="also write the numbers to FILE")
    parser.add_argument("--only", nargs=2, default=None, help=argparse.SUPPRESS)
    parser.add_argument("--run", default=None, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.run:
        evaluate_for(5.0, options.run)
        return
    if options.only:
        print(measure(*options.only))
        return
    results = {}
    for case_name in CASES:
        for laws in LAWS:
            own = elsewhere(__file__, ["--only", case_name, laws], os.environ.get("PYTHONPATH", ""))
            line = f"{case_name:28} {laws:26} {own:7.2f} us"
            results[f"{case_name}, {laws}"] = {"us": own}
            if options.against:
                other = elsewhere(__file__, ["--only", case_name, laws], options.against)
                results[f"{case_name}, {laws}"]["us_against"] = other
                line += f"   {other / own:5.2f} times as fast as {options.against}: {other:.2f} us"
            print(line, flush=True)
        if options.parts:
            share = parts(case_name)
            own = results[f"{case_name}, strips, table"]["us"]
            results[f"{case_name}, parts"] = share
            for part, of in share.items():
                print(f"    {part:28} {100 * of:5.1f} %  {own * of:6.2f} us")
    if options.json:
        options.json.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
