"""A linear system with names and units: responses, poles, zeros, margins; as an xarray.Dataset, for python-control, for MATLAB.

A, B, C, D and names -> [LinearSystem] -> frequency response, poles, zeros, Margins -> Dataset, control.StateSpace, .mat
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import block_diag, expm
from scipy.linalg import eigvals as generalised_eigenvalues

from rollerrig.common.arrays import Array, Complex
from rollerrig.common.linear_algebra import one_blas_thread
from rollerrig.results import mat_bytes

if TYPE_CHECKING:
    import control


@dataclass(frozen=True)
class Margins:
    """Margins of an open loop L that is closed with negative feedback, L read from one response; NaN where there is none."""

    gain: float  # factor on L at which the loop is at its limit [-]
    gain_frequency: float  # at which that is [Hz]
    phase: float  # by which L may lag more [rad]
    phase_frequency: float  # at which |L| is 1 [Hz]


@dataclass(frozen=True)
class LinearSystem:
    """x' = A x + B u, y = C x + D u, or from one sample to the next."""

    name: str  # of the case
    speed: float  # running speed [m/s]
    step: float  # sample time [s]; 0: continuous
    # a, b, c, d: the matrices
    a: Array
    b: Array
    c: Array
    d: Array
    # states, inputs, outputs: names
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    # input_units, output_units: units
    input_units: tuple[str, ...]
    output_units: tuple[str, ...]

    @one_blas_thread()
    def response(self, frequencies: ArrayLike) -> Complex:
        """Transfer from inputs to outputs.

        Args:
            frequencies: [Hz].

        Returns:
            Complex amplitudes, shape (frequency, output, input).
        """
        s = 2j * math.pi * np.asarray(frequencies, dtype=float)
        points = np.exp(s * self.step) if self.step else s
        unit = np.eye(len(self.a))
        return np.stack([self.c @ np.linalg.solve(point * unit - self.a, self.b) + self.d for point in points])

    @one_blas_thread()
    def poles(self) -> Complex:
        """Eigenvalues [1/s], of a sampled system as ln(z)/step; motions that never move (z = 0) are left out."""
        return self._continuous(np.linalg.eigvals(self.a))

    @one_blas_thread()
    def zeros(self, output: int = 0, input: int = 0) -> Complex:  # noqa: A002
        """Invariant zeros between one input and one output [1/s]."""
        n = len(self.a)
        pencil = np.block([[self.a, self.b[:, [input]]], [self.c[[output]], self.d[[output]][:, [input]]]])
        found = generalised_eigenvalues(pencil, block_diag(np.eye(n), np.zeros((1, 1))))
        scale = max(1.0, float(np.abs(self.a).max()))
        return self._continuous(found[np.isfinite(found) & (np.abs(found) < 1e6 * scale)])

    def _continuous(self, roots: NDArray[Any]) -> Complex:
        values: Complex = np.asarray(roots, dtype=complex)
        if self.step:
            values = np.log(values[np.abs(values) > 1e-9].astype(complex)) / self.step
        return values[np.lexsort((values.imag, values.real))]

    @one_blas_thread()
    def sampled(self, step: float) -> LinearSystem:
        """The system under inputs that are constant from one sample to the next.

        Args:
            step: sample time [s].
        """
        n, m = self.b.shape
        block = np.zeros((n + m, n + m))
        block[:n, :n], block[:n, n:] = step * self.a, step * self.b
        exact = expm(block)
        return replace(self, step=step, a=exact[:n, :n], b=exact[:n, n:])

    def delayed(self, steps: Sequence[int]) -> LinearSystem:
        """A sampled system whose inputs come some steps late, each by its own number; what waits is among the states."""
        assert self.step
        waiting, ends = sum(steps), np.cumsum(steps)
        first, last = np.zeros((waiting, len(steps))), np.zeros((len(steps), waiting))
        for k, count in enumerate(steps):
            if count:
                first[ends[k] - count, k] = last[k, ends[k] - 1] = 1.0
        at_once = np.diag([float(count == 0) for count in steps])
        chains = block_diag(*(np.eye(count, k=-1) for count in steps))  # newest first
        names = (
            f"{name}.waiting_{i + 1}" for name, count in zip(self.inputs, steps, strict=True) for i in range(count)
        )
        return replace(
            self,
            a=np.block([[self.a, self.b @ last], [np.zeros((waiting, len(self.a))), chains]]),
            b=np.vstack([self.b @ at_once, first]),
            c=np.hstack([self.c, self.d @ last]),
            d=self.d @ at_once,
            states=(*self.states, *names),
        )

    def to_dataset(self) -> xr.Dataset:
        """A, B, C, D over `state`, `state_` (columns of A), `input`, `output`, with names and units."""
        return xr.Dataset(
            {
                "A": (("state", "state_"), self.a),
                "B": (("state", "input"), self.b),
                "C": (("output", "state_"), self.c),
                "D": (("output", "input"), self.d),
            },
            coords={
                "state": list(self.states),
                "state_": list(self.states),
                "input": list(self.inputs),
                "output": list(self.outputs),
                "input_unit": ("input", list(self.input_units)),
                "output_unit": ("output", list(self.output_units)),
            },
            attrs={"case": self.name, "speed": self.speed, "sample_time": self.step},
        )

    def to_control(self) -> control.StateSpace:
        """State space for python-control, which allows no dots in names: wheelset_1/left/Q.

        Raises:
            ImportError: it is not installed.
        """
        import control

        signals = {"inputs": self.inputs, "outputs": self.outputs, "states": self.states}
        names: dict[str, Any] = {kind: [name.replace(".", "/") for name in words] for kind, words in signals.items()}
        label = "".join(c if c.isalnum() else "_" for c in f"{self.name} at {3.6 * self.speed:g} km/h")
        return control.ss(self.a, self.b, self.c, self.d, self.step, name=label, **names)

    def mat_bytes(self) -> bytes:
        """A MATLAB file: A, B, C, D, Ts, cell arrays of names; `ss(A, B, C, D, Ts)` takes it."""

        def cells(names: Sequence[str]) -> NDArray[np.object_]:
            return np.array(names, dtype=object).reshape(1, -1)

        content: dict[str, Any] = dict(zip("ABCD", (self.a, self.b, self.c, self.d), strict=True))
        content |= {"Ts": self.step, "speed": self.speed, "name": self.name}
        names = {"StateName": self.states, "InputName": self.inputs, "OutputName": self.outputs}
        names |= {"InputUnit": self.input_units, "OutputUnit": self.output_units}
        return mat_bytes(content | {kind: cells(words) for kind, words in names.items()})


def margins_of(frequencies: Array, loop: Complex) -> Margins:
    """Margins of a loop given at ascending frequencies, by straight lines between them: the smallest of each kind.

    Args:
        frequencies: [Hz], shape (frequency,).
        loop: L there.
    """
    size, phase = np.log(np.abs(loop)), np.unwrap(np.angle(loop))
    gain, gain_frequency = math.nan, math.nan
    for k in range(math.floor(phase.min() / (2 * math.pi)) - 1, math.ceil(phase.max() / (2 * math.pi)) + 1):
        for at, part in _crossings(phase - math.pi * (2 * k + 1)):
            factor = math.exp(-_between(size, at, part))
            if math.isnan(gain) or abs(math.log(factor)) < abs(math.log(gain)):
                gain, gain_frequency = factor, _between(frequencies, at, part)
    least, least_frequency = math.nan, math.nan
    for at, part in _crossings(size):
        left = _between(phase, at, part)
        margin = math.remainder(left - math.pi, 2 * math.pi)
        if math.isnan(least) or abs(margin) < abs(least):
            least, least_frequency = margin, _between(frequencies, at, part)
    return Margins(gain, gain_frequency, least, least_frequency)


def _crossings(values: Array) -> list[tuple[int, float]]:
    """Where a sign changes: index before, and the part of the way to the next."""
    at = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0)
    return [(int(k), float(values[k] / (values[k] - values[k + 1]))) for k in at]


def _between(values: Array, at: int, part: float) -> float:
    return float(values[at] + part * (values[at + 1] - values[at]))
