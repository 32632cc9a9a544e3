"""Of a run: forces between wheel and rail as EN 14363 assesses them, motion of the wheelsets, energy."""

from __future__ import annotations

from rollerrig.analysis import filtered
from rollerrig.analysis.wheel_rail_forces import wheel_forces
from rollerrig.config import Case
from rollerrig.config.schema.plan import RunMeasure
from rollerrig.results import COMPLETED, RunInfo
from rollerrig.study.jobs import Progress, whole_run

QUANTITIES = {
    "guiding_force_largest": ("N", "largest |Y| of a wheel, 20 Hz: the force of flange and tread across the rail"),
    "guiding_force_mean": ("N", "largest mean |Y| of a wheel over the assessed time"),
    "guiding_force_sum_largest": ("N", "largest |sum of Y| of a wheelset, 20 Hz, mean over 2 m"),
    "derailment_quotient_largest": ("1", "largest |Y/Q| of a wheel, 20 Hz, mean over 2 m"),
    "wheel_load_least": ("N", "least wheel load Q, 20 Hz"),
    "wheel_load_largest": ("N", "largest wheel load Q, 20 Hz"),
    "wear_number_largest": ("N", "largest mean wear number of a wheel"),
    "lateral_largest": ("m", "largest |lateral displacement| of a wheelset"),
    "lateral_rms": ("m", "largest RMS of the lateral displacement of a wheelset about its mean"),
    "energy_relative_residual": ("1", "residual of the energy audit"),
}


def measure(case: Case, options: RunMeasure, progress: Progress | None = None) -> dict[str, float]:
    """Simulate a case and read off the numbers of QUANTITIES from `options.begin` on.

    Raises:
        RuntimeError: the run left the validity of its model.
        ValueError: nothing is left to be assessed.
    """
    run = whole_run(case, progress)
    if run.attrs["status"] not in COMPLETED:
        raise RuntimeError(run.attrs["status_message"])
    read = filtered(wheel_forces(run))
    late = {"time": slice(options.begin, None)}
    read, motion = read.sel(late), run.sel(late)
    if read.sizes["time"] < 2:
        raise ValueError(f"measure.begin: {options.begin:g} s is beyond the run, which ended at {run['time'][-1]:g} s")
    wheelsets = [body.name for body in RunInfo.of(run).wheelsets]
    lateral = motion["lateral"].sel(body=wheelsets)
    force = abs(read["guiding_force"])
    return {
        "guiding_force_largest": float(force.max()),
        "guiding_force_mean": float(force.mean("time").max()),
        "guiding_force_sum_largest": float(abs(read["guiding_force_sum"]).max()),
        "derailment_quotient_largest": float(abs(read["derailment_quotient"]).max()),
        "wheel_load_least": float(read["wheel_load"].min()),
        "wheel_load_largest": float(read["wheel_load"].max()),
        "wear_number_largest": float(read["wear_number"].mean("time").max()),
        "lateral_largest": float(abs(lateral).max()),
        "lateral_rms": float(lateral.std("time").max()),
        "energy_relative_residual": float(run.attrs["energy_relative_residual"]),
    }
