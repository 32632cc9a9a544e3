"""The energy audit of a run: what should vanish, and against what it is measured.

Dataset with the core's accounts -> [energy] -> Dataset with `energy_residual` and two attributes

Source: docs/theory/energy.md, (E1).
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from rollerrig.results.dataset import variable

WORK_IN = ("energy_work_of_drive", "energy_work_of_torque")
"""Accounts of work put in since the start [J]."""

STORED = ("energy_kinetic", "energy_gravity", "energy_elements", "energy_stored_contacts")
"""Accounts of stored energy; only their change counts [J]."""

DISSIPATED = (
    "energy_dissipated_elements",
    "energy_dissipated_normal",
    "energy_dissipated_creep",
    "energy_dissipated_brakes",
)
"""Accounts of heat since the start [J]."""


def add_energy_audit(run: xr.Dataset) -> xr.Dataset:
    """The run with its energy balance.

    `energy_residual` = work in - change of what is stored - heat [J]. The energy turned over is half the sum of the
    total variations of all accounts between the output times: each joule that moves leaves one account and enters
    another. `energy_relative_residual` is the largest residual over that.

    Args:
        run: Dataset with the accounts.

    Returns:
        The same, with the variable `energy_residual` and the attributes `energy_turned_over_j` and
        `energy_relative_residual`.
    """
    residual = np.zeros(run.sizes["time"])
    turned_over = 0.0
    for names, sign in ((WORK_IN, 1.0), (STORED, -1.0), (DISSIPATED, -1.0)):
        for name in names:
            account = run[name].to_numpy()
            residual += sign * (account - account[:1])
            turned_over += 0.5 * float(np.abs(np.diff(account)).sum())
    meaning = "work in minus change of kinetic, potential and stored energy minus heat; 0 but for integration errors"
    largest = float(np.abs(residual).max(initial=0.0))
    audited = run.assign(energy_residual=variable("time", residual, "J", meaning))
    return audited.assign_attrs(
        energy_turned_over_j=turned_over, energy_relative_residual=largest / turned_over if turned_over > 0 else 0.0
    )
