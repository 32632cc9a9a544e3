"""What a short run costs beyond its steps, and what an import costs: for a hundred thousand runs of a tenth of a second.

    python benchmarks/short_runs.py [--case NAME] [--against PYTHON_PATH]

Processor time of one core, warm, best of many. "Beyond its steps" is the time of `simulate` without that in which the compiled
core advances: the model, the equilibrium to start from, room for the results, the Dataset with its audit. Each run has another
speed, so that nothing of the last one's start serves the next.

With --against, the folder that holds another build's package `rollerrig`, both are measured in turn in processes of their own
and the ratio is printed: on a busy machine a ratio is worth more than two times.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from timing import best_time, elsewhere, of_children

IMPORTS = {
    "import rollerrig": "import rollerrig",
    "rollerrig --help": "from rollerrig.cli import main; sys.argv = ['rollerrig', '--help']; main()",
    "from rollerrig import load_case, simulate": "from rollerrig import load_case, simulate",
}


def of_a_program(text: str) -> float:
    """Processor time of a Python program of its own, without that of one which does nothing [ms]."""

    def spent(code: str) -> float:
        before = of_children()
        subprocess.run([sys.executable, "-c", f"import sys; {code}"], check=True, stdout=subprocess.DEVNULL)
        return of_children() - before

    return 1e3 * (min(spent(text) for _ in range(5)) - min(spent("pass") for _ in range(5)))


def measure(name: str) -> dict[str, float]:
    """Times of the parts of a short run [ms]."""
    from rollerrig import load_case, save_run, simulate
    from rollerrig.assembly.model import assemble
    from rollerrig.simulation import run as simulation

    found = {what: of_a_program(text) for what, text in IMPORTS.items()}
    case = load_case(name).with_changes({"time.duration": "0.1 s"})
    found["load_case"] = 1e3 * best_time(lambda: load_case(name), 10)
    found["with_changes, the speed"] = 1e3 * best_time(lambda: case.with_changes({"motion.speed": "100 km/h"}), 20)
    found["assemble"] = 1e3 * best_time(lambda: assemble(case), 30)
    others = [case.with_changes({"motion.speed": f"{100 + 0.01 * k} km/h"}) for k in range(60)]
    models = iter([assemble(other) for other in others])
    found["prepare: equilibrium, checks"] = 1e3 * best_time(lambda: simulation.prepare(next(models)), 30)

    steps = [0.0]
    march = simulation.march

    def timed(*given: object, **named: object) -> object:
        begun = time.process_time()
        ended = march(*given, **named)
        steps[0] = time.process_time() - begun
        return ended

    simulation.march = timed
    beyond = taken = float("inf")
    for other in others:
        begun = time.process_time()
        run = simulate(other)
        whole = time.process_time() - begun
        beyond, taken = min(beyond, whole - steps[0]), min(taken, steps[0])
    simulation.march = march
    found["simulate beyond its steps, 0.1 s"] = 1e3 * beyond
    found["its steps"] = 1e3 * taken
    with tempfile.TemporaryDirectory() as folder:
        found["save_run"] = 1e3 * best_time(lambda: save_run(run, Path(folder) / "run.nc"), 5)
    return found


def in_turn(paths: list[str], name: str, rounds: int = 3) -> list[dict[str, float]]:
    """The same of several packages, each round in processes of their own; the least of each."""
    found: list[dict[str, float]] = [{} for _ in paths]
    for _ in range(rounds):
        for path, of in zip(paths, found, strict=True):
            for what, value in elsewhere(__file__, ["--json", "--case", name], path).items():
                of[what] = min(of.get(what, float("inf")), value)
    return found


def main() -> None:
    """Print a line per part."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", default="bogie_rollers_constant")
    parser.add_argument("--against", help="folder with another build's package")
    parser.add_argument("--json", action="store_true", help="one measurement, as JSON")
    given = parser.parse_args()
    if given.json or not given.against:
        found = measure(given.case)
        print(json.dumps(found) if given.json else "\n".join(f"{what:44}{ms:9.2f} ms" for what, ms in found.items()))
        return
    here = str(Path(__file__).parents[1] / "python")
    other, own = in_turn([given.against, here], given.case)
    print(f"{'':44}{'against':>9}{'here':>9}   ratio")
    for what, ms in own.items():
        print(f"{what:44}{other[what]:9.2f}{ms:9.2f}{other[what] / ms:8.1f}")


if __name__ == "__main__":
    main()
