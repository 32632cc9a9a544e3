"""Functions of the distance that are cubics between breakpoints and constant beyond the first and the last."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PiecewiseCubic:
    """A piecewise cubic over the distance.

    On the piece `k`, from s_k to s_(k+1), and with t = s - s_k,

        value(s) = c_k0 + c_k1 t + c_k2 t^2 + c_k3 t^3 ;

    the last row is a constant: it holds from there on, as the value at s_0 holds before.

    Attributes:
        rows: (n, 5), one row [s_k, c_k0, c_k1, c_k2, c_k3] per piece, s_k [m] ascending, read-only.
    """

    rows: FloatArray

    def __post_init__(self) -> None:
        """Freeze the rows in the layout that the compiled core reads."""
        rows = np.array(self.rows, dtype=np.float64, order="C").reshape(-1, 5)
        rows.flags.writeable = False
        object.__setattr__(self, "rows", rows)

    def evaluate(self, s: ArrayLike, derivative: int = 0) -> FloatArray:
        """Value (0), slope (1) or second derivative (2) at distances s [m], any shape."""
        s = np.asarray(s, dtype=np.float64)
        first = self.rows[0, 0]
        k = np.clip(np.searchsorted(self.rows[:, 0], s, side="right") - 1, 0, None)
        t = np.maximum(s, first) - self.rows[k, 0]
        c0, c1, c2, c3 = np.moveaxis(self.rows[k, 1:], -1, 0)
        match derivative:
            case 0:
                return np.asarray(c0 + t * (c1 + t * (c2 + t * c3)))
            case 1:
                return np.where(s < first, 0.0, c1 + t * (2 * c2 + t * 3 * c3))
            case 2:
                return np.where(s < first, 0.0, 2 * c2 + t * 6 * c3)
        raise ValueError(f"derivative: {derivative} is not one of 0, 1, 2")

    def integral(self, s: ArrayLike) -> FloatArray:
        """Integral from 0 to s [m], exact for the cubics; any shape."""
        s = np.asarray(s, dtype=np.float64)
        return self._primitive(s) - self._primitive(np.zeros(()))

    def _primitive(self, s: FloatArray) -> FloatArray:
        start = self.rows[:, 0]
        width = np.diff(start)
        c = self.rows[:, 1:]
        whole = width * (c[:-1, 0] + width * (c[:-1, 1] / 2 + width * (c[:-1, 2] / 3 + width * c[:-1, 3] / 4)))
        before = np.concatenate(([0.0], np.cumsum(whole)))
        k = np.clip(np.searchsorted(start, s, side="right") - 1, 0, None)
        t = s - start[k]
        inside = np.maximum(t, 0.0)
        c0, c1, c2, c3 = np.moveaxis(c[k], -1, 0)
        part = inside * (c0 + inside * (c1 / 2 + inside * (c2 / 3 + inside * c3 / 4)))
        return np.asarray(before[k] + part + np.minimum(t, 0.0) * c[0, 0])
