"""Would a table over the pose pay beside the strips? Its grid and memory for a given error.

    python benchmarks/pose_table.py

The table holds the strips' answers over lateral shift, penetration below first touch, roll, yaw and, on rollers, longitudinal
offset, and is read by cubic Hermite pieces: C1. For each coordinate: the widest spacing of nodes at which the force has the
error asked for and its slope the same part of that slope's root mean square, in 90 % of random places of a wheel (seeded).
The size follows from the ranges: value and mixed slopes of eight outputs at every node. A read combines those of the 2^n
corners of a cell.
"""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from rollerrig import load_case
from rollerrig.assembly.model import assemble
from rollerrig.contact_analysis.static_contact import leading_wheelset

Array = NDArray[np.float64]

#: Coordinate: range of the table [m, rad], widest spacing tried; halved until the error is met.
RANGES = {
    "shift": (-8e-3, 8e-3, 1e-3),
    "penetration": (2e-6, 120e-6, 59e-6),
    "roll": (-5e-3, 5e-3, 5e-3),
    "yaw": (-0.02, 0.02, 0.02),
    "offset": (-0.02, 0.02, 0.02),
}
CASES = {"rail": ("contact_benchmark_track", 4), "roller": ("bogie_rollers_constant", 5)}
OUTPUTS = 8  # force, its two angles, place on the wheel and along it, two semi-axes, weight
PLACES, SHARE, HALVINGS = 60, 0.9, 9


class Wheel:
    """Force^(2/3) of the left wheel, nearly linear in the penetration, at a pose."""

    def __init__(self, case: str) -> None:
        self.contact = leading_wheelset(assemble(load_case(case).with_changes({"contact.normal": "strips"}))).contact

    def __call__(self, pose: Array) -> float:
        y, penetration, roll, yaw, x = pose
        z = self.contact.touch_height(x, y, yaw, roll, False) - penetration
        return float(sum(patch.normal for patch in self.contact.patches(x, y, z, yaw, roll, False)) ** (2 / 3))

    def slope(self, pose: Array, axis: int) -> float:
        step = np.zeros(5)
        step[axis] = 1e-7 if axis in (0, 2, 3, 4) else 1e-8
        return (self(pose + step) - self(pose - step)) / (2 * step[axis])


def errors(wheel: Wheel, pose: Array, axis: int, spacing: float) -> tuple[float, float]:
    """Of the force (relative) and of its slope, at the middle of a piece: the Hermite polynomial against the strips."""
    step = np.zeros(5)
    step[axis] = 0.5 * spacing
    low, high = wheel(pose - step), wheel(pose + step)
    d_low, d_high = wheel.slope(pose - step, axis), wheel.slope(pose + step, axis)
    value = 0.5 * (low + high) + spacing / 8 * (d_low - d_high)
    slope = 1.5 * (high - low) / spacing - 0.25 * (d_low + d_high)
    return abs(value / wheel(pose) - 1) * 1.5, abs(slope - wheel.slope(pose, axis))


def widest_spacing(wheel: Wheel, places: Array, axis: int, error: float) -> tuple[float, float]:
    """Spacing, and the share of the places that is good with it: below SHARE where no spacing tried is enough."""
    scale = np.sqrt(np.mean([wheel.slope(place, axis) ** 2 for place in places]))
    spacing = list(RANGES.values())[axis][2]
    for halving in range(HALVINGS):
        size = spacing / 2**halving
        good = [f < error and d < error * scale for f, d in (errors(wheel, place, axis, size) for place in places)]
        if np.mean(good) >= SHARE:
            break
    return size, float(np.mean(good))


def places_of(dimensions: int) -> Array:
    """Half of them where wheels run mostly: near the middle, with little yaw."""
    low, high = (np.array([r[k] for r in RANGES.values()]) for k in (0, 1))
    unit = np.random.default_rng(7).uniform(-1, 1, (PLACES, 5)) * np.where(np.arange(PLACES) % 2, 1.0, 0.4)[:, None]
    places = 0.5 * (low + high) + 0.45 * (high - low) * unit
    places[:, dimensions:] = 0.0
    return np.asarray(places)


def size_of_table(name: str, error: float) -> None:
    """Print the spacings, the memory, the numbers a read combines and the time to fill the table."""
    case, dimensions = CASES[name]
    wheel, places, nodes = Wheel(case), places_of(dimensions), 1.0
    for axis, coordinate in enumerate(list(RANGES)[:dimensions]):
        spacing, share = widest_spacing(wheel, places, axis, error)
        low, high, _ = RANGES[coordinate]
        count = (high - low) / spacing + 1
        nodes *= count
        print(f"  {coordinate:12s} every {spacing:8.2e}: {count:5.0f} nodes; {100 * share:.0f} % of the places within")
    start = time.process_time()
    for place in places:
        wheel(place)
    evaluation = (time.process_time() - start) / len(places)
    numbers = OUTPUTS * 2**dimensions
    print(
        f"  {nodes:.1e} nodes, {8 * numbers * nodes / 1e9:.3g} GB, a read combines {numbers * 2**dimensions} numbers,",
        end=" ",
    )
    print(f"{evaluation * nodes / 3600:.2g} h to fill")


def main() -> None:
    """Both supports, two errors."""
    for name in CASES:
        for error in (1e-3, 1e-2):
            print(f"{name}, {100 * error:g} %")
            size_of_table(name, error)


if __name__ == "__main__":
    main()
