"""What a study of frequency responses finds at a speed, as rows of its files.

system, measured response -> [rows] -> response.csv, poles.csv; error of the measured magnitude
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollerrig.analysis.linear_system import LinearSystem
from rollerrig.analysis.measured_response import MeasuredResponse

Rows = list[list[object]]


@dataclass(frozen=True)
class AtSpeed:
    """What is found at one speed.

    Attributes:
        system: the linear bench.
        measured: per input what was measured, if anything.
        drives: bandwidth of the drives that follow inputs [Hz].
    """

    system: LinearSystem
    measured: Mapping[str, MeasuredResponse]
    drives: Mapping[str, float]


def measured_error(found: AtSpeed, output: int, source: int) -> float:
    """Largest difference of measured and linear magnitude up to half the bandwidth of the command's drive [dB].

    Returns:
        The difference; NaN where nothing was measured.
    """
    name = found.system.inputs[source]
    measured = found.measured.get(name)
    if measured is None:
        return math.nan
    inside = measured.frequencies <= 0.5 * found.drives.get(name, math.inf) * (1.0 + 1e-9)
    inside &= np.isfinite(measured.values[:, output])
    if not inside.any():
        return math.nan
    linear = found.system.response(measured.frequencies[inside])[:, output, source]
    return float(np.abs(20 * np.log10(np.abs(measured.values[inside, output] / linear))).max())


def response_rows(results: Mapping[str, AtSpeed], frequencies: NDArray[np.float64]) -> Rows:
    """Every response, linear and measured, header first."""
    rows: Rows = [["speed_kmh", "input", "output", "frequency_hz", "real", "imaginary", "measured"]]
    for found in results.values():
        system = found.system
        response = system.response(frequencies)
        for k, source in enumerate(system.inputs):
            for i, output in enumerate(system.outputs):
                curves = [(frequencies, response[:, i, k], 0)]
                if source in found.measured:
                    curves.append((found.measured[source].frequencies, found.measured[source].values[:, i], 1))
                for at, values, kind in curves:
                    head = [3.6 * system.speed, source, output]
                    rows += [
                        [*head, float(f), float(value.real), float(value.imag), kind]
                        for f, value in zip(at, values, strict=True)
                    ]
    return rows


def pole_rows(results: Mapping[str, AtSpeed]) -> Rows:
    """Poles and zeros of every channel, header first."""
    rows: Rows = [["at", "kind", "growth_rate_per_s", "frequency_hz"]]
    for label, found in results.items():
        kinds = {"pole": found.system.poles()}
        for k, source in enumerate(found.system.inputs):
            for i, output in enumerate(found.system.outputs):
                kinds[f"zero of {source} to {output}"] = found.system.zeros(i, k)
        for kind, values in kinds.items():
            rows += [[label, kind, float(one.real), float(one.imag) / (2 * math.pi)] for one in values]
    return rows
