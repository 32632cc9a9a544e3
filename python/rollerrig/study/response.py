"""Frequency responses of the bench: linear at several speeds, and measured with a sine on the nonlinear bench.

Case, commands, outputs, speeds -> [ResponseStudy] -> Bode, Nyquist, poles and zeros, margins, MATLAB files, report
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from rollerrig.analysis.linear_bench import LinearBench
from rollerrig.analysis.linear_system import LinearSystem, margins_of
from rollerrig.analysis.measured_response import MeasuredResponse, measured_response
from rollerrig.cases import as_case
from rollerrig.common.arrays import Array, Complex
from rollerrig.config import Case, ConfigError
from rollerrig.plot.control import bode_figure, nyquist_figure, poles_and_zeros_figure
from rollerrig.study.frame import Outcome, Study
from rollerrig.study.jobs import Done, Progress, Round, job
from rollerrig.study.options import OneProcess, Option, command
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Block, Picture, Section, Table, Text

Rows = list[list[object]]


@dataclass(frozen=True)
class AtSpeed:
    """The linear bench at one speed, per input what was measured, and bandwidths of the drives that follow inputs [Hz]."""

    system: LinearSystem
    measured: Mapping[str, MeasuredResponse]
    drives: Mapping[str, float]


def measured_error(found: AtSpeed, output: int, source: int) -> float:
    """Largest difference of measured and linear magnitude up to half the bandwidth of the command's drive [dB], or NaN."""
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


Channel = tuple[str, int, int]  # name, index of output and input


def channels_of(inputs: Sequence[str], outputs: Sequence[str]) -> list[Channel]:
    """Channels from every input to every output."""
    return [(f"{source} to {output}", i, k) for k, source in enumerate(inputs) for i, output in enumerate(outputs)]


def response_rows(results: Mapping[str, AtSpeed], frequencies: Array) -> Rows:
    """Every response, linear and measured, header first."""
    rows: Rows = [["speed_kmh", "input", "output", "frequency_hz", "real", "imaginary", "measured"]]
    for found in results.values():
        system = found.system
        response = system.response(frequencies)
        for _, i, k in channels_of(system.inputs, system.outputs):
            curves = [(frequencies, response[:, i, k], 0)]
            if own := found.measured.get(system.inputs[k]):
                curves.append((own.frequencies, own.values[:, i], 1))
            head = [3.6 * system.speed, system.inputs[k], system.outputs[i]]
            for at, values, kind in curves:
                parts = np.stack([at, values.real, values.imag], axis=1).tolist()
                rows += [[*head, *part, kind] for part in parts]
    return rows


def pole_rows(results: Mapping[str, AtSpeed]) -> Rows:
    """Poles and zeros of every channel, header first."""
    rows: Rows = [["at", "kind", "growth_rate_per_s", "frequency_hz"]]
    for label, found in results.items():
        system = found.system
        kinds = {"pole": system.poles()}
        kinds |= {f"zero of {name}": system.zeros(i, k) for name, i, k in channels_of(system.inputs, system.outputs)}
        for kind, values in kinds.items():
            rows += [[label, kind, float(one.real), float(one.imag) / (2 * math.pi)] for one in values]
    return rows


@dataclass(frozen=True)
class ResponseStudy(Study[dict[str, AtSpeed]]):
    """Responses from some commands to some outputs at some speeds; attributes as the arguments of `rollerrig.response`."""

    case: Case
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    speeds_kmh: tuple[float, ...]
    frequencies: tuple[float, float]
    points: int
    measured: int
    amplitude: float
    brake_pressure: float

    command = "response"
    assumes = (
        "The linear bench is exact for small motions about steady rolling: no limits of drives, no full sliding, no flange.",
        "The controllers are outside; a delay of their commands is in the response of a case with samples.",
    )
    heading = "Frequency response: {case.name}"
    writes = ("response.csv", "poles.csv", "linear_*_kmh.mat")
    formats = ("svg",)
    resumable = False

    def __post_init__(self) -> None:
        """Refuse with a ConfigError frequencies that are none, or beyond half the sampling frequency."""
        low, high = self.frequencies
        most = 0.5 / self.case.time.sampling_step if self.case.sampled else math.inf
        if not 0.0 < low < high or high > most:
            half = f", half the sampling frequency being {most:g} Hz" if self.case.sampled else ""
            allowed = f"allowed: from low to high, both positive{half}"
            raise ConfigError.of(self.case.name, "frequencies", f"{low:g} to {high:g} Hz", allowed)
        if not (math.isfinite(self.amplitude) and self.amplitude > 0.0):
            raise ConfigError.of(self.case.name, "amplitude", f"{self.amplitude:g}", "allowed: positive")

    def rounds(self, done: Done) -> Iterator[Round]:
        yield {f"{speed:g} km/h": job(at_speed, self, speed) for speed in self.speeds_kmh}

    def collect(self, done: Done) -> dict[str, AtSpeed] | None:
        return dict(done) or None

    @property
    def _grid(self) -> Array:
        return np.geomspace(*self.frequencies, self.points)

    @property
    def _channels(self) -> list[Channel]:
        return channels_of(self.inputs, self.outputs)

    def numbers(self, results: dict[str, AtSpeed]) -> dict[str, Any]:
        responses = {label: found.system.response(self._grid) for label, found in results.items()}
        channels = {
            name: {label: self._channel(found, responses[label], i, k) for label, found in results.items()}
            for name, i, k in self._channels
        }
        growing = {label: int(np.sum(found.system.poles().real > 1e-6)) for label, found in results.items()}
        step = next(iter(results.values())).system.step
        return {
            "case": self.case.name,
            "speeds_kmh": list(self.speeds_kmh),
            "sampling_step_ms": 1e3 * step if step else None,
            "amplitude": self.amplitude,
            "brake_pressure_bar": self.brake_pressure / 1e5,
            "growing_poles": growing,
            "channels": channels,
        }

    def _channel(self, found: AtSpeed, response: Complex, output: int, source: int) -> dict[str, float]:
        values = response[:, output, source]
        size = 20 * np.log10(np.abs(values))
        below = np.flatnonzero(size < size[0] - 3.0)
        margins = margins_of(self._grid, values)
        return {
            "bandwidth_hz": float(self._grid[below[0]]) if below.size else math.nan,
            "gain_margin_db": 20 * math.log10(margins.gain) if math.isfinite(margins.gain) else math.nan,
            "gain_margin_frequency_hz": margins.gain_frequency,
            "phase_margin_deg": math.degrees(margins.phase),
            "phase_margin_frequency_hz": margins.phase_frequency,
            "measured_error_db": measured_error(found, output, source),
        }

    def summary(self, results: dict[str, AtSpeed], numbers: Numbers) -> list[str]:
        sentences = [
            f"{name}, {at}: {self.quantities.said(one, ('bandwidth_hz', 'measured_error_db')) or 'no bandwidth in this range'}."
            for name, by_speed in numbers["channels"].items()
            for at, one in by_speed.items()
        ]
        measured = [(at, one) for at, found in results.items() for one in found.measured.values()]
        return sentences + [f"A measurement ended early at {at}: {one.ended}" for at, one in measured if one.ended]

    def files(self, results: dict[str, AtSpeed], numbers: Numbers) -> Mapping[str, Any]:
        return {
            "response.csv": response_rows(results, self._grid),
            "poles.csv": pole_rows(results),
            **{f"linear_{at.removesuffix(' km/h')}_kmh.mat": one.system.mat_bytes() for at, one in results.items()},
        }

    def sections(self, results: dict[str, AtSpeed], numbers: Numbers) -> list[Section]:
        sections, systems = [], {label: found.system for label, found in results.items()}
        responses = {label: system.response(self._grid) for label, system in systems.items()}
        first = next(iter(systems.values()))
        poles = {label: system.poles() for label, system in systems.items()}
        for number, (name, i, k) in enumerate(self._channels, 1):
            unit = f"{first.output_units[i]} per {first.input_units[k]}"
            lines = {label: (self._grid, response[:, i, k]) for label, response in responses.items()}
            measured = {label: found.measured.get(self.inputs[k]) for label, found in results.items()}
            points = {label: (one.frequencies, one.values[:, i]) for label, one in measured.items() if one}
            places = poles_and_zeros_figure(poles, {label: system.zeros(i, k) for label, system in systems.items()})
            blocks: list[Block] = [
                Picture(f"bode_{number}", bode_figure(lines, points, unit), f"{name}: magnitude and phase."),
                self.quantities.table(numbers["channels"][name], "channels.*.*", "Bandwidth and margins.", "at"),
                Picture(f"nyquist_{number}", nyquist_figure(lines, unit), f"{name} in the complex plane."),
                Picture(f"poles_{number}", places, f"{name}: poles (crosses) and zeros (circles)."),
            ]
            sections.append(Section(name, blocks))
        note = "Of a case with samples, poles are ln(z) over the sampling step. Those of all motions are in poles.csv."
        growing = list(numbers["growing_poles"].items())
        slow = Table(("at", "growing poles"), growing, "Motions that grow by themselves.")
        return [*sections, Section("Poles", [slow, Text(note)])]


def at_speed(study: ResponseStudy, speed_kmh: float, progress: Progress | None = None) -> AtSpeed:
    """The linear bench at one speed, and what is measured there.

    Raises:
        ConfigError: an unknown name, or a speed that the case does not allow.
        StartError: no rolling equilibrium was found.
    """
    case, speed = study.case, speed_kmh / 3.6
    bench = LinearBench(case, speed, study.brake_pressure)
    system = bench.system(study.inputs, study.outputs, discrete=case.sampled)
    drives = {name: bench.commands[name].bandwidth / (2.0 * math.pi) for name in study.inputs if name in bench.commands}
    measured = {}
    for source in study.inputs if study.measured else ():
        low, high = study.frequencies
        frequencies = np.geomspace(low, high if not system.step else min(high, 0.25 / system.step), study.measured)
        found = measured_response(bench, source, study.outputs, frequencies.tolist(), study.amplitude, progress)
        if found is not None:
            measured[source] = found
    return AtSpeed(system, measured, drives)


@command
def response(
    case: Case | str,
    inputs: Annotated[Sequence[str], Option("input", default=())],
    outputs: Annotated[Sequence[str], Option("output", default=())],
    speeds_kmh: Sequence[float] = (),
    *,
    frequencies: Annotated[
        tuple[float, float],
        Option("from_hz", least=1e-4, most=1e4, meaning="lowest frequency [Hz]."),
        Option("to_hz", least=1e-3, most=1e5, meaning="highest frequency [Hz]."),
    ] = (0.1, 100.0),
    points: Annotated[int, Option(least=10, most=20000)] = 400,
    measured: Annotated[int, Option(least=0, most=200, default=12)] = 0,
    amplitude: Annotated[float, Option(least=1e-9, most=1e9)] = 1000.0,
    brake_pressure: Annotated[float, Option("", "bar", 0.0, 100.0)] = 0.0,
    processes: OneProcess = 1,
    progress: Progress | None = None,
) -> Outcome[dict[str, AtSpeed]]:
    """Frequency response from commands to outputs: Bode, Nyquist, poles and zeros, margins, and measured beside it.

    Args:
        case: case: a name of the catalogue or a TOML file.
        inputs: commands of the bench, as `linearize` takes them.
        outputs: outputs of the bench.
        speeds_kmh: speeds [km/h]; that of the case if absent.
        frequencies: lowest and highest [Hz].
        points: frequencies of the linear bench.
        measured: frequencies at which the nonlinear bench is driven with a sine; 0: none.
        amplitude: of that sine, in the command's unit.
        brake_pressure: in all brake cylinders [Pa]; the rollers' drives hold the speed.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: an unknown name, or a speed that the case does not allow.
        StartError: no rolling equilibrium was found.
    """
    whole, names = as_case(case), (tuple(inputs), tuple(outputs))
    speeds = tuple(speeds_kmh) or (3.6 * whole.motion.speed,)
    study = ResponseStudy(whole, *names, speeds, frequencies, points, measured, amplitude, brake_pressure)
    return study.outcome(processes, progress)
