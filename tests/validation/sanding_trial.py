"""Stopping distances of a trial with sand on very low adhesion, beside the case sanding_trial.

    rate and number of sanders -> [distance] -> way from 55 mph to 1 m/s [m]

    python tests/validation/sanding_trial.py      runs all five stops and writes data/sanding_trial.csv (some minutes)

Source: RSSB research project T1107, as reported by Rail Engineer, 12 February 2018: class 387, step 3 (0.9 m/s2) from 55 mph on
an untreated friction of 0.02, sand throughout the stop.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

from rollerrig import load_case, simulate

FILE = Path(__file__).with_name("data") / "sanding_trial.csv"
FIXED, VARIABLE = 0.0333, 0.085
"""Flow of a sander [kg/s]: 2 kg/min; what gives the distance of one variable sander, whose rate was not at hand."""


@dataclass(frozen=True)
class Stop:
    """One arrangement of sanders.

    Attributes:
        name: as reported.
        sanders: how many.
        flow: of each [kg/s].
        measured: distance [m], as reported.
        at_least: whether the report only says that it was longer.
        fitted: the number of this program that was fitted to it; empty: a prediction.
    """

    name: str
    sanders: int
    flow: float
    measured: float
    at_least: bool = False
    fitted: str = ""


STOPS = (
    Stop("no sand", 0, FIXED, 1200.0, at_least=True),
    Stop("one sander, fixed rate", 1, FIXED, 800.0, fitted="`saturation`"),
    Stop("two sanders, fixed rate", 2, FIXED, 650.0),
    Stop("one sander, variable rate", 1, VARIABLE, 600.0, fitted="`flow`, 2.55 times the fixed rate"),
    Stop("two sanders, variable rate", 2, VARIABLE, 400.0),
)


def distance(stop: Stop) -> float:
    """Way to 1 m/s, or to the end of the run [m]."""
    changes: dict[str, object] = {"sanding": None}
    if stop.sanders:
        axles = ["wheelset_1", "wheelset_2"][: stop.sanders]
        changes = {"sanding.axles": axles, "sanding.flow": f"{stop.flow} kg/s"}
    run = simulate(load_case("sanding_trial").with_changes(changes))
    return float(run["train_distance"][-1])


def recorded() -> dict[str, float]:
    """Distances of all stops as they were computed last [m]."""
    with FILE.open(encoding="utf-8") as lines:
        return {row["stop"]: float(row["distance_m"]) for row in csv.DictReader(lines)}


def main() -> None:
    lines = ["stop,distance_m", *(f'"{stop.name}",{distance(stop):.1f}' for stop in STOPS)]
    FILE.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
