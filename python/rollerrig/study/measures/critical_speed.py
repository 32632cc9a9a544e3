"""Linear critical speed of a case."""

from __future__ import annotations

import math

from rollerrig.analysis.critical_speed import onset_from
from rollerrig.config import Case
from rollerrig.config.schema.plan import CriticalSpeedMeasure
from rollerrig.study.jobs import Progress

QUANTITIES = {
    "linear_critical_speed": (
        "km/h",
        "lowest speed at which an oscillatory mode begins to grow; NaN: none up to 600 km/h",
    ),
}


def measure(case: Case, options: CriticalSpeedMeasure, progress: Progress | None = None) -> dict[str, float]:
    """The linear critical speed, looked for between two speeds and above them.

    Raises:
        KeyboardInterrupt: Ctrl-C came before the end.
        StartError: no rolling equilibrium at one of the speeds.
    """
    speeds = [3.6 * options.slowest, 3.6 * options.fastest]
    onset, _ = onset_from(case, speeds, progress)
    return {"linear_critical_speed": math.nan if onset is None else 3.6 * onset.speed}
