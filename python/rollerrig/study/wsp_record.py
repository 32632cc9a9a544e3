"""One test of a programme: run, and what is kept of it.

Case of a stop -> [stop_record] -> StopRecord: its TestRecord with measures of the programme, signals, processor time
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig import _core
from rollerrig.analysis.slide_statistics import SLIP_EDGES, TestRecord, axle_load, test_record
from rollerrig.analysis.tracking import LEAST_SPEED, under_test, wheel_radius
from rollerrig.analysis.wheel_flat import longest_flat
from rollerrig.config import Case
from rollerrig.config.schema.programme import FlatWear
from rollerrig.contact_laws import adhesion_map
from rollerrig.results.contact_loss import contact_losses
from rollerrig.results.run_info import RunInfo
from rollerrig.study.jobs import Progress, whole_run

Array = NDArray[np.float64]

LARGE_SLIP = 0.30
"""Beyond it slip is large [-]."""

SIGNAL_STEP = 0.05
"""Of the signals that are kept [s]."""


@dataclass(frozen=True)
class StopRecord:
    """What is kept of a test.

    Attributes:
        test: its record.
        signals: name with unit -> values over time; empty but for first tests.
        seconds: processor time [s].
    """

    test: TestRecord
    signals: Mapping[str, Array]
    seconds: float


def stop_record(case: Case, flat: FlatWear, keep: bool, progress: Progress | None = None) -> StopRecord:
    """Run a test and keep its record: a job.

    Args:
        case: of a stop.
        flat: numbers of the estimate of wheel flats.
        keep: also its signals.
        progress: called with the fraction done and a short text.

    Raises:
        KeyboardInterrupt: Ctrl-C cut it short.
    """
    begun = time.process_time()
    run = whole_run(case, progress=progress)
    record = test_record(run, case)
    own = {
        "large_slip_share": float(record.slip_shares[np.flatnonzero(SLIP_EDGES[:-1] > LARGE_SLIP - 1e-9)].sum()),
        "adhesion_utilisation": adhesion_utilisation(run, case),
        "flat_length_m": longest_flat(under_test(run), flat.wear, flat.width),
        "contact_lost_s": max((loss.longest_s for loss in contact_losses(run)), default=0.0),
    }
    test = replace(record, measures={**record.measures, **own})
    return StopRecord(test, signals(run) if keep else {}, time.process_time() - begun)


def adhesion_utilisation(run: xr.Dataset, case: Case) -> float:
    """Sum of the creep forces over what friction at no slip would give, of all braked axles that are bodies, and instants [-].

    Friction is that of the rail under each axle, which nothing has cleaned yet: where sliding cleans it, the value may pass 1.
    NaN where no axle is braked.
    """
    if case.adhesion is None:
        return float("nan")
    rail = adhesion_map(case.adhesion)
    places = {body.name: body.position[0] for body in RunInfo.of(run).wheelsets}
    way, clock = run["train_distance"].to_numpy(), run["time"].to_numpy()
    used = offered = 0.0
    for axle, place in places.items():
        one = run[["brake_torque", "creep_force"]].sel(axle=axle)
        at = clock if rail.over_time else way + place
        braked = (abs(one["brake_torque"]).to_numpy() > 1.0) & (run["train_speed"].to_numpy() > LEAST_SPEED)
        used += float(np.abs(one["creep_force"].to_numpy()[braked]).sum())
        offered += float(_core.rail_friction(rail, np.ascontiguousarray(at[braked])).sum()) * axle_load(run)
    return used / offered if offered > 0.0 else float("nan")


def signals(run: xr.Dataset) -> dict[str, Array]:
    """Speeds and cylinder pressures over time, every SIGNAL_STEP."""
    clock = run["time"].to_numpy()
    every = max(1, round(SIGNAL_STEP / (clock[1] - clock[0]))) if clock.size > 1 else 1
    kept = slice(None, None, every)
    found = {"time_s": clock[kept], "train_speed_kmh": 3.6 * run["train_speed"].to_numpy()[kept]}
    for axle in run["axle"].to_numpy():
        one = run[["axle_speed", "cylinder_pressure"]].sel(axle=axle)
        found[f"{axle}_speed_kmh"] = 3.6 * wheel_radius(run) * one["axle_speed"].to_numpy()[kept]
        found[f"{axle}_pressure_bar"] = 1e-5 * one["cylinder_pressure"].to_numpy()[kept]
    return found
