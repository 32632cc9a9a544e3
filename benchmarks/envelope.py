"""How long an envelope map takes.

    python benchmarks/envelope.py [--refine N]

The map of `adhesion_brake` with default settings on two processes: 360 runs of 3 s of the bogie on rollers, and those that
halving cells once adds (--refine 0: none). Then the same again from a folder in which 100 of its runs are missing.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from rollerrig import envelope, load_case


def main() -> None:
    """Print the times, wall clock and processor."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--refine", type=int, default=1)
    refine = parser.parse_args().refine
    case = load_case("adhesion_brake")
    with tempfile.TemporaryDirectory() as name:
        runs = Path(name) / "runs.jsonl"
        for what in ("all", "with 100 runs missing"):
            wall = time.perf_counter()
            found = envelope(case, refine=refine, folder=name, processes=2)
            wall = time.perf_counter() - wall
            count, before = found.attrs["runs"], found.attrs["runs_from_before"]
            each = found.attrs["processor_seconds"] / count
            print(
                f"map, {what}: {wall:.1f} s for {count - before} of {count} runs; {each:.3f} s of processor for a run"
            )
            runs.write_bytes(b"".join(runs.read_bytes().splitlines(keepends=True)[:-100]))


if __name__ == "__main__":
    main()
