"""Writes data/bent_creep.csv: exact creep forces of bent patches (validation/bent_creep.py). Five minutes.

python tests/validation/write_bent_creep.py
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "tests")]

from validation.bent_creep import COLUMNS, FILE, exact_rows, poses  # noqa: E402
from validation.reference import DATA  # noqa: E402


def main() -> None:
    """Solve and write."""
    with (DATA / FILE).open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for pose in poses():
            try:
                lines = exact_rows(*pose)
            except ValueError as error:
                print(pose[0], error)
                continue
            for line in lines:
                writer.writerow([f"{number:.7g}" for number in line])
            file.flush()


if __name__ == "__main__":
    main()
