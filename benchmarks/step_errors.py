"""One run's cost and its errors against a tight one, by kind of signal: what the tables of methods and steps are made of.

Cost: processor time in which the compiled core advances, outputs and readings of the case included, over the simulated time.
Error: largest difference over the largest value of that signal up to a time; of the signals of a kind the worst. Of a kind,
signals below a hundredth of its largest do not count. Forces of wheels are compared through the 20 Hz low-pass of EN 14363, as
they are read.
"""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

import rollerrig.simulation.run
from rollerrig import Case
from rollerrig.analysis.signals import low_pass

CUTOFF = 20.0
"""Of the low-pass for wheel forces [Hz]."""

LEAST = 0.01
"""Share of the largest signal of a kind from which one counts."""

SIZES = {"displacement": 1e-5, "Q": 10.0, "Y": 10.0}
"""A kind whose signals are all smaller is not compared [m, N]."""

TRACES = ("train_speed", "axle_speed", "roller_speed", "cylinder_pressure", "creep_force")
"""Of runs with sampled blocks, compared as they are."""

Signals = dict[str, xr.DataArray]


@dataclass(frozen=True)
class Measured:
    """One run: its results and cost."""

    run: xr.Dataset
    spent: float
    """Processor time of the advance [s]."""

    @property
    def simulated(self) -> float:
        """[s]"""
        return float(self.run["time"][-1])

    @property
    def real_time(self) -> float:
        """Simulated over processor time."""
        return self.simulated / self.spent

    @property
    def energy(self) -> float:
        """Relative residual of the energy audit."""
        return float(self.run.attrs["energy_relative_residual"])

    @property
    def evaluations(self) -> float:
        """Right-hand sides per simulated millisecond, Jacobians apart."""
        return float(self.statistics["derivative_calls"]) / (1e3 * self.simulated)

    @property
    def statistics(self) -> dict[str, Any]:
        """What the integrator counted."""
        return dict(json.loads(self.run.attrs["solver_statistics"]))


def measure(case: Case, repeat: int = 1) -> Measured:
    """Run a case; the least cost of `repeat` runs."""
    advance = rollerrig.simulation.run.march
    spent: list[float] = []

    def timed(*arguments: Any, **settings: Any) -> tuple[int, int]:
        begun = time.process_time()
        try:
            return advance(*arguments, **settings)
        finally:
            spent.append(time.process_time() - begun)

    rollerrig.simulation.run.march = timed
    try:
        runs = [rollerrig.simulation.run.simulate(case) for _ in range(repeat)]
    finally:
        rollerrig.simulation.run.march = advance
    return Measured(runs[-1], min(spent))


def signals(run: xr.Dataset) -> Signals:
    """What is compared, by kind; over time and one other dimension."""
    vehicle = [str(b) for b in run["body"].to_numpy() if not str(b).startswith(("rail", "roller"))]
    own = run.sel(body=vehicle)
    kinds = {"displacement": own["lateral"], "Q": low_pass(run["vertical_force"], CUTOFF)}
    kinds |= {"Y": low_pass(run["lateral_force"], CUTOFF)}
    kinds |= {name.replace("_", " "): run[name] for name in TRACES if name in run}
    return {name: value for name, value in kinds.items() if float(np.abs(value).max()) > SIZES.get(name, 0.0)}


def errors(found: Signals, reference: Signals, until: float) -> dict[str, float]:
    """Largest relative error of each kind up to a time [s]; infinite where the run does not reach it."""
    out = {}
    for kind, other in reference.items():
        b = other.sel(time=slice(0.0, until + 1e-9))
        a = found[kind].sel(time=slice(0.0, until + 1e-9)) if kind in found else b[:0]
        if a.sizes["time"] != b.sizes["time"]:
            out[kind] = float("inf")
            continue
        largest = np.abs(b).max("time")
        relative = np.abs(a.to_numpy() - b.to_numpy()).max(0) / np.where(largest > 0, largest, 1.0)
        out[kind] = float(np.where(largest >= LEAST * largest.max(), relative, 0.0).max())
    return out


def agree_until(one: Signals, other: Signals, share: float) -> float:
    """Time [s] up to which two runs agree within a share of the largest value of each kind so far."""
    ends = []
    for kind, value in one.items():
        n = min(value.sizes["time"], other[kind].sizes["time"])
        a, b = value.to_numpy()[:n].reshape(n, -1), other[kind].to_numpy()[:n].reshape(n, -1)
        apart = np.abs(a - b).max(1) > share * max(np.abs(a).max(), 1e-300)
        ends.append(float(value["time"][max(0, int(np.argmax(apart)) - 1) if apart.any() else n - 1]))
    return min(ends)
