"""What kept the drives of the rollers from the torque that was asked of them.

times that the core counted -> [drive_limits] -> a warning
"""

from __future__ import annotations

import numpy as np

from rollerrig.results.dataset import Draft

LIMITS = {"torque": "drive_torque_limited", "power": "drive_power_limited", "speed": "drive_speed_limited"}
"""Limit of a roller's drive -> how long it has acted."""

_LEAST = 0.01
"""A drive that is held back for less is not worth a line [s]."""


def drive_warning(draft: Draft) -> str:
    """Which limits of the roller drives acted, for how long, and the power that was asked for; "" if none did."""
    if LIMITS["torque"] not in draft.variables or not len(draft.values("time")):
        return ""
    longest = {name: float(draft.values(key)[-1].max()) for name, key in LIMITS.items()}
    acted = [f"of {name} for {time:.3g} s" for name, time in longest.items() if time >= _LEAST]
    if not acted:
        return ""
    wanted = float(np.abs(draft.values("wanted_roller_power")).max())
    delivered = float(np.abs(draft.values("roller_power")).max())
    return (
        f"the roller drives met their limit {', '.join(acted)} (one axle, the longest); asked for up to {wanted / 1e3:.4g} kW, "
        f"they gave up to {delivered / 1e3:.4g} kW"
    )
