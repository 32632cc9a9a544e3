"""Frequency response measured as on a bench: a sine on one command of the nonlinear plant, frequency by frequency.

Case, speed, command, frequencies -> [plant under a stepped sine] -> complex amplitudes of the outputs over that of the command
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from rollerrig import _core
from rollerrig.analysis.linear_bench import LinearBench
from rollerrig.common.arrays import Array, Complex
from rollerrig.common.linear_algebra import one_blas_thread
from rollerrig.interfaces.plant import assembled_model
from rollerrig.simulation.controllers import BRAKE_UNIT, roles_of

POINTS = 32  # points of the held sine in a period, where the plant has no samples of its own
READINGS = 4  # readings of the outputs between two of them: the steps of the held sine are then not taken for the sine
SETTLING = 3.0  # time from the first period to those that are evaluated [s]
LEAST_SETTLED, PERIODS = 4, 4  # least periods of each
LEAST_EVALUATED = 1.0  # so long the evaluated periods last at least [s]

FILLED, MOST_FILLING = 0.9999, 30_000
"""Part of the pressure from which the cylinders count as filled, and the most sampling steps that takes."""


@dataclass(frozen=True)
class MeasuredResponse:
    """What a sine on one input gives."""

    frequencies: Array  # those asked for, rounded to whole samples in a period [Hz]
    # amplitude and phase over those of the input, shape (frequency, output); NaN where the run ended early
    values: Complex
    ended: str  # how a run ended early, a sentence; "" where none did


def measured_response(
    bench: LinearBench,
    source: str,
    outputs: Sequence[str],
    frequencies: Sequence[float],
    amplitude: float,
    progress: Callable[[float, str], None] | None = None,
) -> MeasuredResponse | None:
    """Drive a command of the nonlinear bench with a sine about steady rolling.

    The controllers of the case are outside and give nothing, but what holds the speed of a braked bench. Where the plant has
    samples, the response is that from sample to sample, the command held between; else that of the continuous plant.

    Args:
        bench: the case in steady rolling, with the pressure of its brakes.
        source: name of the command.
        outputs: names of outputs.
        frequencies: [Hz].
        amplitude: of the sine, in the command's unit.
        progress: called with the fraction done and a short text.

    Returns:
        The response; None where the plant has no such command or output, or nothing to hold a braked bench with.
    """
    pressure, steady = bench.brake_pressure, bench.case
    if pressure:
        steady = steady.with_changes({"brake.demand": [[0.0, pressure], [1.0, pressure]]})
    external = [role for role in roles_of(steady) if role != BRAKE_UNIT]
    plant = _core.Plant(assembled_model(steady, external=external, allow_unrestrained=True))
    index, indices = plant.find(source), [plant.find(name) for name in outputs]
    hold = {plant.find(name): torque for name, torque in bench.holding.items()}
    if min(index, *indices, *hold) < 0 or (pressure and not hold):
        return None
    own = plant.sampling_step
    counts = [max(4, round(1.0 / (f * own))) if own else POINTS for f in frequencies]
    steps = [own or 1.0 / (f * POINTS) for f in frequencies]
    found, ended = [], ""
    for k, (count, step) in enumerate(zip(counts, steps, strict=True)):
        if progress is not None:
            progress(k / len(counts), f"{source}: {1.0 / (count * step):.3g} Hz")
        row, status = _one_sine(plant, index, indices, count, step, amplitude, bench)
        if status:
            ended = f"{1.0 / (count * step):.3g} Hz: {status}"
        held = 1.0 if own else np.sinc(1.0 / count) * np.exp(-1j * math.pi / count)
        found.append(row / held)
    actual = np.array([1.0 / (count * step) for count, step in zip(counts, steps, strict=True)])
    return MeasuredResponse(actual, np.array(found), ended)


@one_blas_thread()
def _one_sine(
    plant: _core.Plant, index: int, indices: list[int], count: int, step: float, amplitude: float, bench: LinearBench
) -> tuple[Complex, str]:
    """Response at one frequency, `count` samples in a period; and how the run ended where it did so early."""
    period, readings = count * step, 1 if plant.sampling_step else READINGS
    settled = count * max(LEAST_SETTLED, math.ceil(SETTLING / period))
    total = settled + count * max(PERIODS, math.ceil(LEAST_EVALUATED / period))
    times, rows = [], []
    code = plant.start()
    begin, base = _apply_brakes(plant, bench), plant.get(index)
    for k in range(total):
        if k >= settled and readings == 1:
            times.append(k * step)
            rows.append(plant.values(indices))
        plant.set_input(index, base + amplitude * math.sin(2.0 * math.pi * (k % count) / count))
        for i in range(readings if k >= settled and readings > 1 else 0):
            times.append((k + (i + 0.5) / readings) * step)
            plant.advance(begin + times[-1])
            rows.append(plant.values(indices))
        code = plant.advance(begin + (k + 1) * step)
        if code != _core.status_codes["ok"]:
            return np.full(len(indices), complex(math.nan, math.nan)), _core.status_sentence(code)
    phase = 2.0 * np.pi / period * np.array(times)
    basis = np.stack([np.ones_like(phase), phase, np.sin(phase), np.cos(phase)], axis=1)  # a free bench drifts
    _, _, sine, cosine = np.linalg.lstsq(basis, np.array(rows), rcond=None)[0]
    return (sine + 1j * cosine) / amplitude, ""


def _apply_brakes(plant: _core.Plant, bench: LinearBench) -> float:
    """Let the cylinders fill while the rollers' drives take up what holds the speed; the time at which that is done [s]."""
    if not bench.holding:
        return 0.0
    drives = [plant.find(name) for name in bench.holding]
    cylinders = [plant.find(name.replace("roller_torque_command", "cylinder_pressure")) for name in bench.holding]
    steps = 0
    while (filled := plant.values(cylinders) / bench.brake_pressure).min() < FILLED and steps < MOST_FILLING:
        for index, torque, part in zip(drives, bench.holding.values(), filled, strict=True):
            plant.set_input(index, torque * part)
        steps += 1
        plant.advance(steps * plant.sampling_step)
    for index, torque in zip(drives, bench.holding.values(), strict=True):
        plant.set_input(index, torque)
    return steps * plant.sampling_step
