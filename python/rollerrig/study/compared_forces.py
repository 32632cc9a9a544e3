"""Wheel-rail forces of a vehicle on several supports: steady rolling, and after a lateral offset.

state of steady rolling, disturbed run -> [compared_forces] -> numbers per wheel and of the leading wheelset
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from rollerrig.analysis import HuntingSettings, filtered, wheel_forces
from rollerrig.analysis.contact_state import RollingState
from rollerrig.analysis.hunting import hunting_case
from rollerrig.cases import leading_wheelset
from rollerrig.config import Case
from rollerrig.study.jobs import Progress, whole_run
from rollerrig.study.quantities import Quantity

WHEELS = (
    Quantity("supports.*.wheels.*.vertical_force_kn", "Q in steady rolling at the lowest speed", "kN", "Q"),
    Quantity("supports.*.wheels.*.lateral_force_kn", "Y of the wheel on the rail there, outwards", "kN", "Y", 3),
    Quantity("supports.*.wheels.*.longitudinal_creep_force_n", "creep force there", "N", "longitudinal creep force", 3),
    Quantity("supports.*.wheels.*.patches", "number of its contact patches", "", "patches"),
    Quantity("supports.*.wheels.*.approach_um", "of the deepest patch", "µm", "deepest approach"),
    Quantity("supports.*.wheels.*.patch_ab_mm2", "largest product of a patch's semi-axes", "mm²", "largest a × b"),
    Quantity("supports.*.wheels.*.creep_stiffness_mn", "sum of f₁₁ over its patches", "MN", "Σ f₁₁"),
)
DISTURBED = {
    "guiding_force": (Quantity("supports.*.disturbed.guiding_force", "largest |Y|", "kN", digits=3), 1e-3),
    "guiding_force_sum": (Quantity("supports.*.disturbed.guiding_force_sum", "largest |ΣY|, 2 m mean", "kN", digits=3), 1e-3),
    "longitudinal_creep_force": (Quantity("supports.*.disturbed.longitudinal_creep_force", "unfiltered", "kN", digits=3), 1e-3),
    "wheel_unloading": (Quantity("supports.*.disturbed.wheel_unloading", "largest", "%", digits=3), 1e2),
    "derailment_quotient": (Quantity("supports.*.disturbed.derailment_quotient", "largest |Y/Q|, 2 m mean", "1", digits=3), 1.0),
    "wear_number": (Quantity("supports.*.disturbed.wear_number", "largest Tγ", "N", digits=3), 1.0),
}  # fmt: skip
"""Signal -> largest magnitude of the leading wheelset in the disturbed run, and factor to its unit."""


def disturbed(case: Case, speed: float, settings: HuntingSettings, progress: Progress | None = None) -> xr.Dataset:
    """Filtered wheel-rail forces after a lateral offset at a speed [m/s], with the motion of the leading wheelset."""
    run = whole_run(hunting_case(case, speed, settings), progress)
    leading = leading_wheelset(case).name
    motion, creep = run["lateral"].sel(body=leading, drop=True), run["longitudinal_creep_force"]
    return (
        filtered(wheel_forces(run))
        .assign(lateral=motion, longitudinal_creep_force=creep)
        .assign_attrs(status=run.attrs["status"], leading=leading, config_toml=run.attrs["config_toml"])
    )


def wheel_numbers(state: RollingState) -> dict[str, dict[str, float]]:
    """Per wheel the numbers of WHEELS."""
    found = {}
    for wheel in map(str, state.wheels["wheel"].to_numpy()):
        own = state.wheels.sel(wheel=wheel)
        outwards = -1.0 if wheel.endswith("left") else 1.0
        values = (
            1e-3 * float(own["vertical_force"]),
            outwards * 1e-3 * float(own["lateral_force"]),
            float(own["longitudinal_creep_force"]),
            int(own["patch_count"]),
            1e6 * float(own["patch_approach"].max()),
            1e6 * float((own["patch_a"] * own["patch_b"]).max()),
            1e-6 * state.creep_stiffness[wheel],
        )
        found[wheel] = {quantity.name: value for quantity, value in zip(WHEELS, values, strict=True)}
    return found


def disturbed_numbers(run: xr.Dataset) -> dict[str, float]:
    """Largest magnitudes of the leading wheelset, by the names of DISTURBED."""
    leading, found = str(run.attrs["leading"]), {}
    for name, (_, factor) in DISTURBED.items():
        values = run[name]
        if "wheel" in values.dims:
            values = values.sel(wheel=[f"{leading}_left", f"{leading}_right"])
        if "wheelset" in values.dims:
            values = values.sel(wheelset=leading)
        found[name] = factor * float(np.abs(values).max())
    return found
