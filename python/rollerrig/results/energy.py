"""The energy audit of a run: what should vanish, and against what it is measured.

results with the core's accounts -> [energy] -> the same with `energy_residual` and two attributes

Source: docs/theory/energy.md, (E1).
"""

from __future__ import annotations

import numpy as np

from rollerrig.results.dataset import Draft, variable

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

_SIGNS = ((WORK_IN, 1.0), (STORED, -1.0), (DISSIPATED, -1.0))


def add_energy_audit(draft: Draft) -> None:
    """Add the energy balance of a run: the variable `energy_residual` and two attributes.

    `energy_residual` = work in - change of what is stored - heat [J]. The energy turned over, `energy_turned_over_j`, is half
    the sum of the total variations of all accounts between the output times: each joule that moves leaves one account and
    enters another. `energy_relative_residual` is the largest residual over that.

    Args:
        draft: results with the accounts, which are changed.
    """
    accounts = np.stack([draft.values(name) for names, _ in _SIGNS for name in names])
    signs = np.array([[sign] for names, sign in _SIGNS for _ in names])
    residual = (signs * (accounts - accounts[:, :1])).sum(axis=0)
    turned_over = 0.5 * float(np.abs(np.diff(accounts)).sum(axis=1).sum())
    meaning = "work in minus change of kinetic, potential and stored energy minus heat; 0 but for integration errors"
    largest = float(np.abs(residual).max(initial=0.0))
    draft.variables["energy_residual"] = variable("time", residual, "J", meaning)
    draft.attributes["energy_turned_over_j"] = turned_over
    draft.attributes["energy_relative_residual"] = largest / turned_over if turned_over > 0 else 0.0
