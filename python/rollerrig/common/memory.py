"""How much memory there is, to refuse in time what would not fit."""

from __future__ import annotations

import math


def available_memory() -> float:
    """Memory that a process can still get [bytes]; infinite where the system does not say."""
    try:
        with open("/proc/meminfo", encoding="ascii") as file:  # noqa: PTH123
            fields = dict(line.split(":", 1) for line in file)
        return 1024.0 * float(fields["MemAvailable"].split()[0])
    except (OSError, KeyError, ValueError, IndexError):
        return math.inf
