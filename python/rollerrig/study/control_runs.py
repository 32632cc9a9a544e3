"""One run of a comparison of controllers: what is reported of it, and the registry of all that the study reports.

Case of a variant -> [run_variant] -> numbers by name of RUN, and its course over time where wanted
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis.torque_ripple import RIPPLE_ABOVE, torque_ripple
from rollerrig.analysis.tracking import largest, rms, slip, tracking, under_test
from rollerrig.config import Case
from rollerrig.study.control_compensation import COMPENSATION
from rollerrig.study.control_held import HELD_QUANTITIES
from rollerrig.study.control_stability import LOOP_QUANTITIES
from rollerrig.study.jobs import Progress, whole_run
from rollerrig.study.quantities import Quantities, Quantity

OUTPUT_STEP = 2e-3
"""Of the runs compared [s]; ripple is seen up to its Nyquist frequency, 250 Hz."""

KEPT = ["axle_speed", "virtual_speed", "train_speed", "train_distance", "real_sliding", "roller_torque", "valve"]
PERCENT = ("%", 100.0)

RUN = (
    Quantity("*.*.status", "how the run ended"),
    Quantity("*.*.ended_s", "when", "s"),
    Quantity("*.*.tracking_rms", "wheel less virtual wheel over train speed, RMS", "1", "tracking RMS", 3, PERCENT),
    Quantity("*.*.tracking_largest", "largest of the same", "1", "largest", 3, PERCENT),
    Quantity("*.*.largest_slip", "of the wheels against the virtual train, over its speed", "1"),
    Quantity("*.*.real_sliding_rms_mps", "wheel against roller", "m/s"),
    Quantity("*.*.real_sliding_largest_mps", "largest of the same", "m/s", "real sliding", 3, ("mm/s", 1e3)),
    Quantity("*.*.roller_torque_largest_nm", "of a roller drive", "N m", "roller torque", 3, ("kN m", 1e-3)),
    Quantity("*.*.distance_m", "run by the virtual train", "m"),
    Quantity("*.*.distance_relative", "over that of the case as shipped, less 1", "1", "distance, less shipped", 3, PERCENT),
    Quantity("*.*.dump_cycles", "of the slide protection, all axles under test", "", "dump cycles"),
    Quantity("*.*.air_litres", "taken by the cylinders, at ambient pressure", "l", "air", 3),
    Quantity("*.*.ripple_nm", f"persistent roller torque above {RIPPLE_ABOVE:g} Hz, RMS, median of 0.25 s", "N m", "ripple", 3),
    Quantity("*.*.ripple_hz", "where that ripple has most power", "Hz"),
)  # fmt: skip
QUANTITIES = Quantities(
    Quantity("case", "name of the case"),
    Quantity("duration_s", "of each run", "s"),
    RUN,  # before the limits of the same names: a table asks for the first one
    Quantity("limits.tracking_rms", "tracking RMS from which on a variant fails", "1"),
    Quantity("limits.ripple_nm", "torque ripple from which on a variant fails", "N m"),
    Quantity("results.*.family", "what is varied"),
    Quantity("results.*.curve", "under which fixed change"),
    Quantity("results.*.value", "on the family's axis"),
    Quantity("results.*.cause", "of the failure: tracking, ripple, or the status of a run that ended early"),
    Quantity("ranking.*.**", "every curve, the worst first; failures: parts of the axis in which every value fails of one cause; "
             "begin and end: where the limit is passed, interpolated, or the first and last value that fails; null: to the end "
             "of the values tried; the largest error and where"),
    LOOP_QUANTITIES,
    COMPENSATION,
    HELD_QUANTITIES,
)  # fmt: skip
REFERENCE_COLUMNS = ("status", "tracking_rms", "tracking_largest", "real_sliding_largest_mps", "roller_torque_largest_nm",
                     "ripple_nm", "distance_relative", "dump_cycles", "air_litres")  # fmt: skip


def run_variant(case: Case, with_course: bool, progress: Progress | None = None) -> dict[str, Any]:
    """One run: its `numbers`, and where wanted its `course` over time."""
    run = whole_run(case, progress)
    return {"numbers": run_numbers(run), "course": run[KEPT].load() if with_course else None}


def run_numbers(run: xr.Dataset) -> dict[str, Any]:
    """The numbers of one run by name of RUN, of the axles under test.

    As `distance_relative`, time and distance of the last instant compared.
    """
    run = under_test(run)
    error, largest_error = tracking(run)
    ripple, frequency = torque_ripple(run["time"].to_numpy(), run["roller_torque"].to_numpy())
    last, compared = run.isel(time=-1), run.isel(time=slice(None, None, 50)).isel(time=-1)
    return {
        "status": run.attrs["status"],
        "ended_s": float(run.attrs["stopped_at_s"]),
        "tracking_rms": error,
        "tracking_largest": largest_error,
        "largest_slip": largest(slip(run)),
        "real_sliding_rms_mps": rms(run["real_sliding"]),
        "real_sliding_largest_mps": float(np.abs(run["real_sliding"]).max()),
        "roller_torque_largest_nm": float(np.abs(run["roller_torque"]).max()),
        "distance_m": float(last["train_distance"]),
        "distance_relative": [float(compared["time"]), float(compared["train_distance"])],
        "dump_cycles": int(last["dump_cycles"].sum()),
        "air_litres": 1e3 * float(last["air"].sum()),
        "ripple_nm": ripple,
        "ripple_hz": frequency,
    }


def against(numbers: Mapping[str, Any], base: xr.Dataset) -> dict[str, Any]:
    """With the distance over that of the base at the same time, less 1."""
    time, distance = numbers["distance_relative"]
    shipped = float(np.interp(time, base["time"], base["train_distance"]))
    return {**numbers, "distance_relative": distance / shipped - 1.0 if shipped > 0.0 else None}
