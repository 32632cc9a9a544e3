"""How fast: the default rig in rollerrig, in NumPy + SciPy and in Numba + SciPy, side by side on this machine.

    python benchmarks/run.py [--json FILE] [--repeat N]

Model   bogie of Manchester Benchmark vehicle 1, four wheels on two roller pairs, full contact.
Study   traction: 60 km/h, rollers free, torque on each wheelset 0 until 1 s, then linear to 4 kN m at 5 s, constant to 10 s.
Error   largest difference to a tight reference, over the largest value of that signal; signals: absolute sliding, longitudinal
        and vertical force of every wheel, every 5 ms. A run counts only if it stays below 0.1 %.

The SciPy side, tests/validation/independent_model, is what somebody who knows SciPy well would do: Radau, with a difference
Jacobian of sensible steps. With solve_ivp's own Jacobian, or with RK45 or LSODA as they come, the same study takes tens of
times as many evaluations.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.integrate import solve_ivp
from threadpoolctl import threadpool_limits
from timing import best_time, states_along

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from validation.independent_model import bogie as numpy_bogie
from validation.independent_model.parameters import Parameters

DURATION = 10.0  # [s]
START_SPEED = 60 / 3.6  # [m/s]
OUTPUT_TIMES = np.linspace(0, DURATION, 2001)
ALLOWED_ERROR = 1e-3
SIGNALS = ("sliding", "fx", "fz")


@dataclass
class Measurement:
    """What was measured of one implementation; None where it has no such thing."""

    name: str
    rhs_us: float | None = None  # one right-hand side of the whole rig [us]
    study_s: float | None = None  # processor time of the traction study [s]
    study_method: str = ""
    evaluations: int | None = None
    error: float | None = None  # largest relative error of the plotted signals [-]

    @property
    def real_time_factor(self) -> float | None:
        """Simulated time over processor time."""
        return DURATION / self.study_s if self.study_s else None


# --------------------------------------------------------------------------------- NumPy, Numba through SciPy
def integrate(function, x0, relative, absolute):
    """Radau over the study, in the pieces between the corners of the torque; returns states (52, n) and evaluations."""
    counter = 0

    def counted(t, x):
        nonlocal counter
        counter += 1
        return function(t, x)

    columns, x = [], x0
    for begin, end in ((0.0, 1.0), (1.0, 5.0), (5.0, DURATION)):
        # a piece keeps its outputs but the last, which opens the next piece
        grid = OUTPUT_TIMES
        times = grid[(grid >= begin - 1e-9) & (grid <= end + 1e-9)]
        solution = solve_ivp(
            counted,
            (begin, end),
            x,
            method="Radau",
            rtol=relative,
            atol=absolute,
            t_eval=np.clip(times, begin, end),
            jac=lambda t, y: numpy_bogie.jacobian(counted, t, y),
        )
        if not solution.success:
            raise RuntimeError(f"solve_ivp stopped: {solution.message}")
        last = end == DURATION
        columns.append(solution.y if last else solution.y[:, :-1])
        x = solution.y[:, -1]
    return np.concatenate(columns, axis=1), counter


def plotted(states: np.ndarray, outputs: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Plotted signals of every wheel, shape (3 signals, 4 wheels, n times)."""
    return np.stack([outputs(np.ascontiguousarray(x)) for x in states.T], axis=-1)


def error_against(reference: np.ndarray, signals: np.ndarray) -> float:
    """Largest error over the largest value, per signal and wheel; the worst of them [-]."""
    return float((np.abs(signals - reference).max(axis=2) / np.abs(reference).max(axis=2)).max())


@threadpool_limits.wrap(limits=1, user_api="blas")  # as rollerrig does: faster for matrices of this size
def measure_scipy(p, x0, reference, repeat: int) -> Measurement:
    """The NumPy model."""
    study = lambda t, x: numpy_bogie.rhs(t, x, p)  # noqa: E731
    m = Measurement("NumPy + SciPy", study_method="Radau, rtol 1e-3")
    m.rhs_us = 1e6 * best_time(lambda: study(3.0, x0), repeat, 0.2)
    start = time.process_time()
    states, m.evaluations = integrate(study, x0, 1e-3, numpy_bogie.absolute_tolerances())
    m.study_s = time.process_time() - start

    def outputs(x):
        out = numpy_bogie.wheel_outputs(x, p)
        return np.stack([out[name] for name in SIGNALS])

    every = slice(None, None, 10)  # the outputs of 200 of the 2001 times: this model is slow
    m.error = error_against(reference[..., every], plotted(states[:, every], outputs))
    return m


@threadpool_limits.wrap(limits=1, user_api="blas")  # as rollerrig does: faster for matrices of this size
def measure_numba(p, x0, repeat: int) -> tuple[Measurement, np.ndarray]:
    """The Numba model, and the tight reference computed with it."""
    import numba_model

    packed = numba_model.pack(p)
    study = lambda t, x: numba_model.rhs(t, x, packed)  # noqa: E731
    outputs = lambda x: numba_model.wheel_outputs(x, packed)[:3]  # noqa: E731
    m = Measurement("Numba + SciPy", study_method="Radau, rtol 1e-3")
    m.rhs_us = 1e6 * best_time(lambda: study(3.0, x0), repeat, 0.2)

    reference = plotted(integrate(study, x0, 1e-8, 1e-3 * numpy_bogie.absolute_tolerances())[0], outputs)
    start = time.process_time()
    states, m.evaluations = integrate(study, x0, 1e-3, numpy_bogie.absolute_tolerances())
    m.study_s = time.process_time() - start
    m.error = error_against(reference, plotted(states, outputs))
    return m, reference


# --------------------------------------------------------------------------------------------- rollerrig
def measure_growth(repeat: int) -> list[tuple[str, str, float]]:
    """How rollerrig's cost grows: right-hand side over wheelsets [us], run over simulated time [ms of processor time]."""
    from rollerrig import _core, load_case
    from rollerrig.assembly.model import assemble
    from rollerrig.simulation.run import begin
    from rollerrig.simulation.starting_state import starting_state

    fast = {"motion.speed": "200 km/h", "time.method": "rk4", "time.step": "0.25 ms"}
    hunting = load_case("bogie_rollers_constant").with_changes(fast)
    whole = load_case("vehicle_rollers").with_changes(fast)  # with the coupler rod that holds it
    alone = hunting.with_changes({"vehicle.cut": "leading_wheelset"})
    rows = []
    for case, wheelsets in ((alone, 1), (hunting, 2), (whole, 4)):
        model, states = states_along(case, case.time.step, 2000)
        simulation = _core.Simulation(model.core)
        time_us = 1e6 / len(states) * best_time(lambda: simulation.derivatives(0.0, states), repeat, 0.2)  # noqa: B023
        rows.append((f"right-hand side, {wheelsets} wheelset{'s' * (wheelsets > 1)} on rollers", "us", time_us))
    for duration in (5, 10, 20):
        case = hunting.with_changes({"time.duration": f"{duration} s", "time.output_step": "10 ms"})
        model = assemble(case)
        simulation = _core.Simulation(model.core)
        begin(simulation, model, starting_state(model))
        times, results = np.empty(100 * duration + 1), np.empty((100 * duration + 1, simulation.width))
        begun = time.process_time()
        simulation.advance(duration, times, results, 0)
        rows.append((f"hunting bogie, {duration} s simulated, rk4 0.25 ms", "ms", 1e3 * (time.process_time() - begun)))
    return rows


def measure_rollerrig(repeat: int) -> Measurement | str:
    """rollerrig itself, or a sentence that says why it could not be measured.

    The right-hand side is timed along the states of a hunting run. The study's error is taken against rollerrig's own tight run.
    """
    try:
        from rollerrig import _core, load_case
        from rollerrig.assembly.model import assemble
        from rollerrig.simulation.run import begin
        from rollerrig.simulation.starting_state import starting_state
    except ImportError as error:
        return f"rollerrig is not installed here ({error}): its column is missing."

    hunting = load_case("bogie_rollers_constant").with_changes({"motion.speed": "200 km/h"})
    model, states = states_along(hunting, hunting.time.step, 4000)
    simulation = _core.Simulation(model.core)
    m = Measurement("rollerrig")
    m.rhs_us = 1e6 / len(states) * best_time(lambda: simulation.derivatives(0.0, states), repeat, 0.2)

    def study(tolerance, absolute):
        case = load_case("bogie_rollers_traction").with_changes(
            {
                "time.output_step": "5 ms",
                "time.relative_tolerance": tolerance,
                "time.absolute_tolerance": absolute,
            }
        )
        model = assemble(case)
        simulation = _core.Simulation(model.core)
        start = starting_state(model)
        times, rows = np.empty(len(OUTPUT_TIMES)), np.empty((len(OUTPUT_TIMES), simulation.width))
        begin(simulation, model, start)
        begun = time.process_time()
        simulation.advance(DURATION, times, rows, 0)
        elapsed = time.process_time() - begun
        names = [name for name, _, _ in _core.wheel_fields]
        first = len(model.bodies) * len(_core.body_fields)
        wheels = rows[:, first : first + len(model.wheels) * len(names)].reshape(
            len(rows), len(model.wheels), len(names)
        )
        fields = ("longitudinal_sliding", "longitudinal_force", "vertical_force")
        return elapsed, np.stack([wheels[:, :, names.index(f)].T for f in fields]), simulation.statistics()

    _, reference, _ = study(1e-9, 1e-12)
    times = []
    for _ in range(max(3, repeat)):
        elapsed, signals, statistics = study(1e-3, 1e-7)
        times.append(elapsed)
    m.study_s = min(times)
    m.study_method = "rodas4, rtol 1e-3"
    m.evaluations = statistics["derivative_calls"]
    m.error = error_against(reference, signals)
    return m


# ------------------------------------------------------------------------------------------------- report
def shown(value: float | None, digits: int = 3) -> str:
    """A number for the table, or a dash."""
    return "-" if value is None else f"{value:.{digits}g}"


def report(results: list[Measurement], console: Console) -> None:
    """Print the table and the ratios."""
    table = Table(title="Default rig: bogie, four wheels on rollers, full contact")
    table.add_column("")
    for r in results:
        table.add_column(r.name, justify="right")
    rows = [
        ("right-hand side [us]", lambda r: shown(r.rhs_us)),
        ("traction study of 10 s, processor time [s]", lambda r: shown(r.study_s)),
        ("  method", lambda r: r.study_method or "-"),
        ("  right-hand sides", lambda r: shown(r.evaluations, 6)),
        ("  error of the plotted signals", lambda r: "-" if r.error is None else f"{100 * r.error:.3g} %"),
        ("  real-time factor", lambda r: shown(r.real_time_factor)),
    ]
    for label, cell in rows:
        table.add_row(label, *[cell(r) for r in results])
    console.print(table)
    by_name = {r.name: r for r in results}
    ours = by_name.get("rollerrig")
    for other in results:
        if ours and other is not ours and other.study_s and ours.study_s:
            console.print(
                f"rollerrig against {other.name}: {other.rhs_us / ours.rhs_us:.3g} x per right-hand side, "
                f"{other.study_s / ours.study_s:.3g} x for the study"
            )
        if other.error is not None and other.error > ALLOWED_ERROR:
            console.print(
                f"{other.name}: error {100 * other.error:.3g} % is above {100 * ALLOWED_ERROR:.3g} %: does not count"
            )


def main() -> int:
    """Measure everything and print it; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the numbers to FILE")
    parser.add_argument(
        "--repeat", type=int, default=5, metavar="N", help="batches per timing, the best counts (default 5)"
    )
    arguments = parser.parse_args()
    console = Console()
    p = Parameters()

    with console.status("equilibrium"):
        x0 = numpy_bogie.equilibrium(START_SPEED, p)
    with console.status("Numba"):
        numba, reference = measure_numba(p, x0, arguments.repeat)
    with console.status("NumPy"):
        numpy = measure_scipy(p, x0, reference, arguments.repeat)
    with console.status("rollerrig"):
        ours = measure_rollerrig(arguments.repeat)
    results = [r for r in (ours, numba, numpy) if isinstance(r, Measurement)]
    console.print(
        f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, NumPy {np.__version__}; "
        "one core used, processor time"
    )
    report(results, console)
    if isinstance(ours, str):
        console.print(ours)
    growth = [] if isinstance(ours, str) else measure_growth(arguments.repeat)
    for label, unit, value in growth:
        console.print(f"rollerrig, {label}: {value:.3g} {unit}")
    if arguments.json:
        rows = [asdict(r) | {"real_time_factor": r.real_time_factor} for r in results]
        arguments.json.write_text(
            json.dumps({"duration_s": DURATION, "results": rows, "growth": growth}, indent=2) + "\n", encoding="utf-8"
        )
        console.print(f"written: {arguments.json}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
