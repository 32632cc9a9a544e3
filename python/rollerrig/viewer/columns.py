"""Numbers on their way into a page: fewer frames, sixteen bits each, with the error that this costs.

    samples over time -> [thinned] -> frames -> [Columns] -> bytes, and the place of each column in them

The page draws a cubic through neighbouring frames (Catmull and Rom); `interpolated` is the same curve here, so that the error
which the page states is measured on what the page draws.
"""

import base64
import gzip
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollerrig.common.arrays import Array

MOST_FRAMES = 4000
"""Largest number of frames of a page: more would make it slow to open; between them the page interpolates."""

MOST_POINTS = 4000
"""Largest number of points of one panel's curves; of longer ones the extremes of even parts are kept, where they lie."""

WHOLE = 32766
"""Steps of a column that is stored in sixteen bits, either way; one more stands for what does not exist."""


def interpolated(times: Array, values: Array, at: Array) -> Array:
    """The page's curve through frames at rising times [s]: a cubic whose slope is that from the frame before to the one after.

    Values (n, ...) at times (m,) between the first and the last become (m, ...).
    """
    slope = np.gradient(values, axis=0) if len(times) > 2 else np.repeat(np.diff(values, axis=0), 2, axis=0)
    k = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    u = ((at - times[k]) / (times[k + 1] - times[k])).reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray(
        (1 + u * u * (2 * u - 3)) * values[k]
        + u * u * (3 - 2 * u) * values[k + 1]
        + u * (1 - u) ** 2 * slope[k]
        - u * u * (1 - u) * slope[k + 1]
    )


def thinned(
    times: Array, drawn: Mapping[str, Array], allowed: Mapping[str, float], most: int = MOST_FRAMES
) -> tuple[NDArray[np.intp], dict[str, float]]:
    """The fewest evenly spaced samples whose curve stays within the allowed errors, at most `most`.

    Args:
        times: of all samples, two or more, rising (n,) [s].
        drawn: quantity -> its samples (n, columns); those that do not exist are left out of the errors.
        allowed: quantity -> largest error; a quantity without one is only measured.
        most: frames.

    Returns:
        Numbers of the samples, the last one too, and quantity -> largest error of the curve that the page draws.
    """
    count = len(times)
    least = max(1, -(-(count - 1) // max(1, most - 1)))
    steps = [least * 2**power for power in range(6, -1, -1) if least * 2**power * 8 < count] or [least]
    for step in steps:
        index = np.unique(np.append(np.arange(0, count, step), count - 1))
        errors = {name: _error(times, values, index) for name, values in drawn.items()}
        if step == steps[-1] or all(errors[name] <= limit for name, limit in allowed.items()):
            break
    return index, errors


def _error(times: Array, values: Array, index: NDArray[np.intp]) -> float:
    difference = np.abs(interpolated(times[index], values[index], times) - values)
    found = difference[np.isfinite(difference)]
    return float(found.max()) if found.size else 0.0


def extremes(values: Array, most: int = MOST_POINTS) -> NDArray[np.intp]:
    """Samples to keep of curves (n, curves): all, or of even parts those where a curve is least and greatest, and both ends."""
    count, curves = values.shape
    if count <= most:
        return np.arange(count)
    parts = np.array_split(np.arange(count), max(1, (most - 2) // (2 * curves)))
    kept = {0, count - 1}
    for part in parts:
        inside = values[part]
        kept.update(part[np.where(np.isnan(inside), np.inf, inside).argmin(axis=0)].tolist())
        kept.update(part[np.where(np.isnan(inside), -np.inf, inside).argmax(axis=0)].tolist())
    return np.array(sorted(kept), dtype=np.intp)


@dataclass
class Columns:
    """Columns of one number per frame, packed one behind the other."""

    # name -> where it begins in the bytes, how many numbers, their type, factor and offset
    places: dict[str, list[Any]] = field(default_factory=dict)
    _parts: list[bytes] = field(default_factory=list)
    _size: int = 0

    def add(self, name: str, values: Array, *, exact: bool = False) -> None:
        """A column; `exact`: with 32 bits, for angles and distances that only grow."""
        if exact:
            self._append(name, np.asarray(values, dtype="<f4"), "f", 1.0, 0.0)
            return
        finite = values[np.isfinite(values)]
        low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
        middle, half = (low + high) / 2, (high - low) / 2 or 1.0
        scaled = np.where(np.isfinite(values), np.round((values - middle) / half * WHOLE), -WHOLE - 1)
        self._append(name, scaled.astype("<i2"), "h", half / WHOLE, middle)

    def _append(self, name: str, packed: NDArray[Any], kind: str, factor: float, offset: float) -> None:
        self._parts.append(packed.tobytes() + bytes(-packed.nbytes % 4))
        self.places[name] = [self._size, len(packed), kind, factor, offset]
        self._size += len(self._parts[-1])

    def text(self) -> str:
        """All bytes, compressed, as base64; the same for the same numbers."""
        return base64.b64encode(gzip.compress(b"".join(self._parts), 6, mtime=0)).decode("ascii")
