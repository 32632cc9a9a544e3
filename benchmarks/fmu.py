"""What an FMU costs: co-simulation, which integrates by itself, beside model exchange with FMPy's CVODE.

    python benchmarks/fmu.py

Processor time of the second of two runs, which no longer compiles or unpacks anything for the first time.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import fmpy

from rollerrig import export_fmu

CASES = {"bogie_rollers_constant": 0.5, "adhesion_brake": 0.3}
"""Case -> length of the run [s]; the second one has samples every millisecond."""

TOLERANCES = (1e-5, 1e-8)


def seconds(file: Path, kind: str, end: float, tolerance: float | None) -> float:
    """Processor time of one run [s]."""
    for _ in range(2):
        begun = time.process_time()
        fmpy.simulate_fmu(str(file), fmi_type=kind, stop_time=end, output_interval=0.01, relative_tolerance=tolerance)
        taken = time.process_time() - begun
    return taken


def main() -> None:
    """Print a line for each case."""
    with tempfile.TemporaryDirectory() as folder:
        for case, end in CASES.items():
            file = export_fmu(case, Path(folder) / f"{case}.fmu", kind="both")
            own = seconds(file, "CoSimulation", end, None)
            others = [seconds(file, "ModelExchange", end, tolerance) for tolerance in TOLERANCES]
            ratios = ", ".join(f"{one / own:.1f} times at {t:g}" for one, t in zip(others, TOLERANCES, strict=True))
            print(f"{case}, {end} s: co-simulation {own:.2f} s; model exchange {ratios}")


if __name__ == "__main__":
    main()
