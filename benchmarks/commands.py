"""What each command costs: the table behind `--help` and in docs/performance.md.

    python benchmarks/commands.py [COMMAND ...] [--out FOLDER] [--write]

Each command runs once, on an example, in one process; counted is its processor time. Without COMMAND all of them: more than an
hour of one core. --write puts what was measured into python/rollerrig/cli/costs.json and all into docs/performance.md.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from timing import ROOT, of_children, write_between

COSTS = ROOT / "python/rollerrig/cli/costs.json"
EXAMPLES = {
    "paper": "paper",
    "run": "run bogie_rollers_constant",
    "stability": "stability bogie_rollers_constant",
    "response": "response adhesion_brake --input wheelset_1.roller_torque_command --output wheelset_1.axle_speed",
    "compare": "compare manchester_vehicle_1",
    "curving": "curving vehicle_curve",
    "adhesion": "adhesion adhesion_brake --no-error-budget",
    "wsp": "wsp adhesion_coach_valves --quick",
    "reconstruct": "reconstruct adhesion_brake stop.csv",
    "replay": "replay adhesion_brake rig.csv",
    "control": "control adhesion_brake",
    "tune": "tune adhesion_brake",
    "lateral": "lateral adhesion_lateral",
    "scale": "scale adhesion_brake --strategy dlr --run",
    "envelope": "envelope adhesion_brake",
    "creep": "creep --a-over-b 1",
    "conicity": "conicity s1002 uic60_benchmark_1_40",
    "fit": "fit coast_down coast_down.csv",
}
IN_TURN = {"paper", "stability", "compare", "adhesion", "wsp", "control", "tune", "lateral", "scale", "envelope", "fit"}
"""Those that would take two processes."""


def write_logs(folder: Path) -> None:
    """The logs of `reconstruct`, `replay` and `fit`, from runs of the program's own."""
    from rollerrig import load_case, simulate
    from rollerrig.results import export
    from rollerrig.study.runs.adhesion import track_case

    export(simulate(track_case(load_case("adhesion_brake"))).isel(time=slice(None, None, 5)), folder / "stop.csv")
    rig = load_case("adhesion_brake").with_changes({"time.duration": "10 s", "time.output_step": "1 ms"})
    export(simulate(rig)[["axle_speed", "roller_speed", "roller_torque", "cylinder_pressure"]], folder / "rig.csv")
    torque = [[0.0, 0.0], [10.0, 0.0], [11.0, 300.0], [60.0, 300.0], [61.0, 0.0]]
    case = load_case("bogie_rollers_traction").with_changes({
        "vehicle.cut": "leading_wheelset",
        "axle_torque": [],
        "motion.drive": "torque",
        "motion.torque_table": torque,
        "support.losses": {"constant": "20 N m", "linear": "0.5 N m s/rad", "quadratic": "0.01 N m s^2/rad^2"},
        "time.duration": "420 s",
        "time.output_step": "1 s",
    })  # fmt: skip
    run = simulate(case)
    time = run["time"].to_numpy()
    columns = time, run["speed"].to_numpy(), np.interp(time, *np.transpose(torque))
    np.savetxt(
        folder / "coast_down.csv", np.column_stack(columns), delimiter=",", header="time,speed,torque", comments=""
    )


def measure(name: str, folder: Path, out: Path) -> float:
    """Processor time of a command [s]."""
    options = ["--out", str(out), *(("--processes", "1") if name in IN_TURN else ())]
    program = [sys.executable, "-c", "from rollerrig.cli import main; main()"]
    before = of_children()
    subprocess.run([*program, *EXAMPLES[name].split(), *options], cwd=folder, check=True)
    return of_children() - before


def table(costs: dict[str, dict[str, object]]) -> str:
    """The table of the page."""
    rows = [f"| `rollerrig {one['example']}` | {one['processor_s']:g} s |" for one in costs.values()]
    return "\n".join(["| command | processor time |", "|---|---|", *rows])


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("command", nargs="*", choices=[*EXAMPLES, []])
    parser.add_argument("--out", type=Path, help="keeps the results of the commands")
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    costs = json.loads(COSTS.read_text(encoding="utf-8")) if COSTS.exists() else {}
    with tempfile.TemporaryDirectory() as folder:
        write_logs(Path(folder))
        for name in given.command or EXAMPLES:
            seconds = measure(name, Path(folder), (given.out or Path(folder)).resolve() / name)
            costs[name] = {"example": EXAMPLES[name], "processor_s": float(f"{seconds:.2g}")}
            print(costs[name], flush=True)
    if given.write:
        costs = {name: costs[name] for name in EXAMPLES if name in costs}
        COSTS.write_text(json.dumps(costs, indent=1) + "\n", encoding="utf-8")
        write_between("commands", table(costs))


if __name__ == "__main__":
    main()
