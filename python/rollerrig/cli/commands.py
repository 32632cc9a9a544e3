"""What the commands of `rollerrig` do, as functions: the same names, from Python.

case -> [commands] -> Dataset with units, or Outcome of a study -> rollerrig.plot, Outcome.write(folder)

Every option is stated here alone, default in the signature and meaning in the docstring: the command line reads both
(`rollerrig.study.options`). A case is a `Case` or a name of the catalogue or file. An `Outcome` has `results` (Datasets),
`numbers` (those of summary.json), `summary` (the findings as text) and `write(folder)` (the files of the command). Modules are
loaded by the function that needs them: neither `import rollerrig` nor the help of a command costs anything.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rollerrig.study.options import SPEEDS_KMH, OneProcess, Option, Processes, SpeedsKmh, parameters

if TYPE_CHECKING:
    import xarray as xr

    from rollerrig.analysis.adhesion_reconstruction import StopLog
    from rollerrig.config import Case, Programme
    from rollerrig.simulation.run import Progress
    from rollerrig.study.frame import Outcome, Study


RUNNER: ContextVar[Callable[..., Any] | None] = ContextVar("RUNNER", default=None)
"""What the command line does with a study: it writes the outcome into a folder."""


def _outcome(
    study: Study[Any], processes: int = 1, progress: Progress | None = None, folder: str | Path | None = None
) -> Outcome[Any]:
    """The outcome of a study, without files; a KeyboardInterrupt where Ctrl-C left too little to report."""
    runner = RUNNER.get()
    found = runner(study, processes) if runner else study.run(folder=folder, processes=processes, progress=progress)
    if found is None:
        raise KeyboardInterrupt
    return found


def _case(case: Case | str) -> Case:
    from rollerrig.cases import as_case

    return as_case(case)


CURVES = (150.0, 200.0, 250.0, 300.0, 400.0, 500.0, 700.0, 1000.0)  # [m]
DEFICIENCIES = (-0.06, 0.0, 0.06, 0.1, 0.15)  # [m]

# What the command line says of arguments that it writes in another form.
_ROLLERS = "radius of rollers of this head, to be shown beside the rails."
_RADII = "radii of the curves: a list, one number or start:stop:step [m]."
_DEFICIENCIES = "cant deficiencies, which decide the speed, in the same forms; negative: excess [mm]."
_FREE = "what is sought: KEY=[LEAST,MOST], a key of [rig_control] and its range; again for more."
_FAMILIES = "what is varied, by name with commas between; absent: everything."
_TORQUES = (
    "torques on each axle [kN m], negative brakes: start:stop:step, or a list with commas. By default up to beyond what dry "
    "rollers carry, braking for a case with [brake]."
)
_ADHESIONS = "adhesions of the reproduced rail, in the same forms; 0.02 to 0.36 if absent."
_LOADS = "axle loads over the case's own, in the same forms; 0.6,1,1.4 if absent."
_SUPPORTS = "supports, with commas: rig, track, names of the catalogue or files."
_FIT_CHANGES = "another value for a key of the plan's case: KEY=VALUE, as in a TOML file; again for more."
_KEEP = "what the model does not scale: gravity, material, clock, drives, with commas; 'none': ideal similitude."
_CHANGES = "what the model has of its own, at its own scale: KEY=VALUE, as in a TOML file."


# ------------------------------------------------------------------------------------------------- one case, Datasets


def limit_cycle(
    case: Case | str,
    speeds_kmh: Sequence[float] = SPEEDS_KMH,
    *,
    linear_critical_kmh: float = math.nan,
    processes: int = 1,
    folder: str | Path | None = None,
    progress: Progress | None = None,
    **settings: float,
) -> xr.Dataset:
    """The limit-cycle diagram: what the vehicle ends in at each speed, stepped up and down.

    Args:
        case: the case; its rollers or rails are speed-controlled.
        speeds_kmh: speeds of the runs [km/h].
        linear_critical_kmh: linear critical speed, which decides how the bifurcation is called [km/h]; NaN: unknown.
        processes: with 2, the two sweeps run at a time; that asks a script for `if __name__ == "__main__":`.
        folder: where each finished run is kept: after Ctrl-C or a killed program the same call goes on; None: nowhere.
        progress: called with the fraction done and a short text.
        **settings: of `LimitCycleSettings`, such as disturbance [m] and tolerance_kmh.

    Returns:
        Dataset over `cycle_point`, see `limit_cycle_table`; attributes `critical_speed_by_continuation_kmh`, `bifurcation`.

    Raises:
        ConfigError: the folder has the runs of another case, or with other settings.
        OutputError: the folder takes no files.
        StartError: no state was found from which a run can start.
    """
    from rollerrig.analysis.limit_cycle_runs import LimitCycleSettings, limit_cycle_table
    from rollerrig.study.limit_cycles import limit_cycles

    chosen = LimitCycleSettings(**settings)
    found = limit_cycles(_case(case), speeds_kmh, linear_critical_kmh, chosen, processes=processes, folder=folder,
                         progress=progress)  # fmt: skip
    return limit_cycle_table(found)


def contact(
    case: Case | str, positions: Sequence[tuple[float, float]] | None = None, *, roll: float | None = None
) -> xr.Dataset:
    """Contact patches of the leading wheelset under its static axle load.

    Args:
        case: vehicle, support and contact; its motion does not matter.
        positions: lateral position [m] and yaw [rad] of the wheelset; by default from -8 to 8 mm without yaw.
        roll: roll angle to hold [rad]; None: free to roll.

    Returns:
        One entry per contact patch along dimension `row`, see `contact_table`.

    Example:
        >>> import rollerrig as rr
        >>> table = rr.contact("contact_benchmark_track", [(0.0, 0.0)])
        >>> round(float(table["normal"].sum()), -2)
        20000.0
    """
    import numpy as np

    from rollerrig.contact_analysis.static_contact import contact_table

    chosen = [(float(y), 0.0) for y in np.linspace(-8e-3, 8e-3, 33)] if positions is None else positions
    return contact_table(_case(case), chosen, roll=roll)


def creep(
    a_over_b: float = 1.0,
    laws: Annotated[
        Sequence[str],
        Option("law", meaning="a law that contact.creep knows; again for more. All without parameters if absent."),
    ] = ("kalker_saturated", "fastsim", "modified_fastsim", "table"),
    *,
    poisson_ratio: float = 0.28,
    demands: Annotated[
        Sequence[float],
        Option(meaning="sizes of the creepage, 1 asks for the friction limit: a list or start:stop:step."),
    ] = (0.05, 0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0),
    k_A: float | None = None,
    k_S: float | None = None,
    parameters: Mapping[str, Mapping[str, float]] | None = None,
) -> xr.Dataset:
    """Forces and spin moment of creep laws beside the exact theory, with their errors and cost.

    Args:
        a_over_b: semi-axis along the rolling direction over the one across it.
        laws: names that `contact.creep` knows, each once.
        poisson_ratio: Poisson's ratio.
        demands: sizes of the creepage; 1 demands the friction limit [-].
        k_A: polach's k_A; dry 1.0, wet 0.3.
        k_S: polach's k_S; dry 0.4, wet 0.1.
        parameters: law -> its parameters.

    Returns:
        Dataset over (law, direction, demand), see `compare_laws`.

    Raises:
        ValueError: a number outside its range, or no law.

    Example:
        >>> import rollerrig as rr
        >>> rr.creep(laws=["fastsim"], demands=(0.5, 2.0)).sizes["demand"]
        2
    """
    from rollerrig.study.creep import CreepStudy

    polach = {name: value for name, value in (("k_A", k_A), ("k_S", k_S)) if value is not None}
    if len(polach) == 1:
        raise ValueError("k_A and k_S belong together")
    if polach and "polach" not in laws:
        raise ValueError("k_A and k_S are for the law polach")
    chosen = {**(parameters or {}), **({"polach": polach} if polach else {})}
    results: xr.Dataset = _outcome(CreepStudy(a_over_b, tuple(laws), poisson_ratio, tuple(demands), chosen)).results
    return results


def conicity(
    wheel: str,
    rail: str,
    *,
    lengths: Annotated[
        Mapping[str, float] | None,
        Option("gauge", quantity=("Track", "gauge"), default="1435mm", meaning="distance between the gauge sides."),
        Option(
            "gauge_depth",
            quantity=("Track", "gauge_depth"),
            default="14mm",
            meaning="depth below the highest point where it is taken.",
        ),
        Option(
            "back_to_back",
            quantity=("Wheel", "back_to_back"),
            default="1360mm",
            meaning="distance between the flange backs.",
        ),
        Option("radius", quantity=("Wheel", "radius"), default="460mm", meaning="wheel radius at the tape circle."),
    ] = None,
    roller_radius: Annotated[float | None, Option(quantity=("Rig", "roller_radius"), meaning=_ROLLERS)] = None,
    amplitudes: Annotated[
        Sequence[float] | None,
        Option(
            "amplitudes_mm",
            "mm",
            default="0.5:7:0.1",
            meaning="amplitudes of the conicity: start:stop:step, a list or one number [mm].",
        ),
    ] = None,
    largest: Annotated[float, Option("shift_mm", "mm", 0.1, 50.0)] = 8e-3,
    step: Annotated[float, Option("step_mm", "mm", 0.005, 1.0)] = 1e-4,
    yaw: Annotated[float, Option("yaw_mrad", "mrad", -100.0, 100.0)] = 0.0,
    free_to_roll: Annotated[bool, Option("with_roll")] = False,
) -> xr.Dataset:
    """Rolling radius difference, contact angles and positions, and equivalent conicity of a pair of profiles.

    Args:
        wheel: wheel profile: a name of the catalogue or a file of points.
        rail: rail profile, also the generatrix of a roller: likewise.
        lengths: gauge, gauge_depth, back_to_back, radius of `pair_case` [m].
        roller_radius: radius of rollers of this head, to be shown beside the rails [m]; None: rails only.
        amplitudes: amplitudes of the conicity [m]; None: 0.5 to 7 mm.
        largest: lateral shift to both sides [m].
        step: distance of the rows [m].
        yaw: yaw angle of the wheelset [rad].
        free_to_roll: roll the wheelset until both wheels touch; neglected otherwise.

    Returns:
        Dataset over support, lateral shift, side and amplitude, see `shift_table` and `conicity_table`.

    Raises:
        ConfigError: a profile or a length cannot be used.
        ValueError: the wheels do not touch.

    Example:
        >>> import rollerrig as rr
        >>> found = rr.conicity("s1002", "en_60e1_1_40")
        >>> round(float(found["conicity"].sel(support="rail", amplitude=3e-3, method="nearest")), 3)
        0.174
    """
    from rollerrig.study.conicity import Characteristics, ConicityStudy

    usual = (round(1e-4 * k, 6) for k in range(5, 71))
    values = tuple(sorted(set(usual if amplitudes is None else amplitudes)))
    rows = (largest, min(step, largest), free_to_roll, yaw)
    results: Characteristics = _outcome(ConicityStudy(wheel, rail, values, roller_radius, *rows, lengths or {})).results
    return results.dataset()


# ------------------------------------------------------------------------------------------------------------ studies


def run(case: Case | str, *, progress: Progress | None = None) -> Outcome[Any]:
    """Simulate one case: run.nc (every signal), summary.json, tables as CSV, report.html, view.html (in motion).

    Args:
        case: case: a name of the catalogue or a TOML file.
        progress: called with the fraction done and a short text.
    """
    from rollerrig.study.run import RunStudy

    return _outcome(RunStudy(_case(case)), 1, progress)


def stability(
    case: Case | str,
    speeds_kmh: SpeedsKmh = SPEEDS_KMH,
    *,
    limit_cycles: bool = True,
    disturbance: Annotated[float, Option("disturbance_mm", "mm", 0.01, 20.0)] = 3e-3,
    perturbation: Annotated[float, Option("perturbation_mm", "mm", 0.001, 20.0)] = 1e-4,
    longest: Annotated[float, Option(least=2.0, most=600.0)] = 16.0,
    tolerance_kmh: Annotated[float, Option(least=0.01, most=100.0)] = 1.0,
    processes: Annotated[int, Option(least=1, most=2, default=2)] = 1,
    contacts_kmh: Annotated[float | None, Option(least=1.0, most=600.0)] = None,
    branch: Annotated[float | None, Option("branch_mm", "mm", 0.05, 50.0)] = None,
    sensitivity: bool = False,
    progress: Progress | None = None,
) -> Outcome[Any]:
    """Eigenvalues, damping, frequency and mode shapes over speed; limit cycles; critical speeds.

    Args:
        case: case: a name of the catalogue or a TOML file.
        speeds_kmh: speeds [km/h], rising.
        limit_cycles: also run at up to 20 of the speeds, stepped up and down, for limit cycles.
        disturbance: lateral offset of the leading wheelset that starts the downward sweep [m].
        perturbation: the same for the upward sweep [m].
        longest: a run that has not settled by then ends [s].
        tolerance_kmh: to which the critical speed by continuation is found [km/h].
        processes: with 2, the two sweeps run at a time.
        contacts_kmh: also compare the contact models, on rig and track, with a run at this speed [km/h].
        branch: also follow the limit cycles, stable and unstable, from the linear critical speed up to this amplitude [m].
        sensitivity: also draw how each stiffness and damping of the suspension moves the linear critical speed.
        progress: called with the fraction done and a short text.
    """
    from rollerrig.analysis.limit_cycle_runs import LimitCycleSettings
    from rollerrig.study.stability import StabilityStudy

    settings = LimitCycleSettings(disturbance, perturbation, longest=longest, tolerance_kmh=tolerance_kmh)
    study = StabilityStudy(_case(case), tuple(speeds_kmh), limit_cycles, settings, contacts_kmh, branch, sensitivity)
    return _outcome(study, processes, progress)


def curving(
    case: Case | str,
    radii: Annotated[Sequence[float], Option("radii_m", meaning=_RADII)] = CURVES,
    deficiencies: Annotated[Sequence[float], Option("deficiencies_mm", "mm", meaning=_DEFICIENCIES)] = DEFICIENCIES,
    cant: Annotated[float | None, Option("cant_mm", "mm", 0.0, 300.0)] = None,
    *,
    sensitivity: bool = False,
    progress: Progress | None = None,
) -> Outcome[Any]:
    """Steady curving: Y, Q, Y/Q, sum of Y, angle of attack and wear number over radius and cant deficiency, with their limits.

    Args:
        case: case: a name of the catalogue or a TOML file.
        radii: radii of the curves [m].
        deficiencies: cant deficiencies, which decide the speed; negative: excess [m].
        cant: cant [m]; absent: that of the case's first curve, or 100 mm.
        sensitivity: also draw how stiffnesses of the suspension and friction move Y/Q, sum of Y and wear in the tightest curve.
        progress: called with the fraction done and a short text.
    """
    from rollerrig.study.curving import CurvingStudy

    study = CurvingStudy(_case(case), tuple(radii), tuple(deficiencies), cant, sensitivity)
    return _outcome(study, 1, progress)


def adhesion(
    case: Case | str,
    *,
    error_budget: bool = True,
    quick: bool = False,
    processes: Processes = 1,
    progress: Progress | None = None,
) -> Outcome[Any]:
    """A brake or traction test on degraded track and on the dry rig that reproduces it, side by side.

    Args:
        case: case on rollers with [rig_control]: a name of the catalogue or a TOML file.
        error_budget: also run the rig without one imperfection after the other, and the track with later protection.
        quick: two starts of each test: to see that everything works.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case is no such test.
        StartError: a case finds no equilibrium to start from.
    """
    from rollerrig.study.adhesion import AdhesionStudy

    return _outcome(AdhesionStudy(_case(case), error_budget, quick), processes, progress)


def wsp(
    case: Case | str,
    programme: Programme | str = "slide_protection_stops",
    *,
    against: Case | str | None = None,
    starts: Annotated[int, Option(least=0, most=100)] = 0,
    quick: bool = False,
    processes: Processes = 1,
    progress: Progress | None = None,
) -> Outcome[Any]:
    """A test programme for wheel slide protection: a series of stops on track and on the rig, assessed by limits.

    Args:
        case: case on rollers with [rig_control]: a name of the catalogue or a TOML file.
        programme: stops and limits: a name of the catalogue or a TOML file.
        against: another case, whose system is compared with this one: the same stops with the same draws, what differs with
            intervals, effect sizes and the number of tests that would decide it; limits then assess nothing.
        starts: tests of each stop on each support; 0: as many as the programme needs for a decision.
        quick: two starts of the first two stops: to see that everything works.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: a case has nothing to test, or cannot do a stop; two cases are the same, or have different samples.
        StartError: a case finds no equilibrium to start from.
    """
    from rollerrig.config import Programme, load_programme
    from rollerrig.study.protection_comparison import ProtectionComparison
    from rollerrig.study.wsp import WspStudy

    found = programme if isinstance(programme, Programme) else load_programme(programme)
    if against is None:
        return _outcome(WspStudy(_case(case), found, starts, quick), processes, progress)
    return _outcome(ProtectionComparison(_case(case), _case(against), found, starts, quick), processes, progress)


def reconstruct(
    case: Case | str,
    log: StopLog | str,
    *,
    piece_m: Annotated[float, Option(least=0.5, most=1000.0)] = 10.0,
    progress: Progress | None = None,
) -> Outcome[Any]:
    """A measured stop on degraded rails: the rail's friction over distance, and the case on that rail beside the measurement.

    Args:
        case: with [brake] and [adhesion]: a name of the catalogue or a TOML file.
        log: speeds and brake pressures of the stop, .csv, .mat, .nc or .parquet: time [s], train_speed [m/s] and of each
            wheelset NAME.axle_speed [rad/s] and NAME.cylinder_pressure [Pa], or in other units.
        piece_m: length of a piece of the way with one friction [m].
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case lacks a brake or a rail's condition, or has other brakes beside.
        ResultsError: the log lacks a column or a unit, its times do not rise, or no axle slid.
        StartError: the case finds no equilibrium to start from.
    """
    from rollerrig.analysis.adhesion_reconstruction import read_stop
    from rollerrig.study.reconstruction import ReconstructionStudy

    whole = _case(case)
    stop = read_stop(log, whole) if isinstance(log, str) else log
    return _outcome(ReconstructionStudy(whole, stop, piece_m), progress=progress)


def replay(case: Case | str, log: xr.Dataset | str, *, progress: Progress | None = None) -> Outcome[Any]:
    """The rig's estimators and virtual train on the log of a rig: estimated forces with their errors, where they are wrong.

    Args:
        case: with [rig_control]: a name of the catalogue or a TOML file.
        log: speeds and torques of the rig, .csv, .mat, .nc, .parquet or .npz of `rollerrig serve`: time [s] and of each wheelset
            NAME.axle_speed [rad/s], NAME.roller_speed [rad/s], NAME.roller_torque [N m] and NAME.cylinder_pressure [Pa] or
            NAME.brake_torque [N m], or in other units.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case has no rig's controller of ours, or one that takes what no log has.
        ResultsError: the log lacks a column or a unit, its times do not rise, or its speeds or torques contradict each other.
        StartError: the case finds no equilibrium to start from.
    """
    from xarray import Dataset

    from rollerrig.analysis.rig_log import read_rig_log
    from rollerrig.study.replay import ReplayStudy

    whole = _case(case)
    measured = log if isinstance(log, Dataset) else read_rig_log(log, whole)
    return _outcome(ReplayStudy(whole, measured), progress=progress)


def control(
    case: Case | str,
    *,
    duration: Annotated[float, Option(least=1.0, most=600.0)] = 10.0,
    families: Annotated[Sequence[str], Option(commas=True, meaning=_FAMILIES)] = (),
    controller: str | None = None,
    loop: bool = True,
    processes: Processes = 1,
    progress: Progress | None = None,
) -> Outcome[Any]:
    """Controllers of the roller drives: estimators, feedbacks, sample times, drives, wrong parameters; which fails first.

    Args:
        case: case on rollers with [rig_control]: a name of the catalogue or a TOML file.
        duration: length of each run [s]: until adhesion has broken away and recovered.
        families: what is varied, by name; none: everything.
        controller: your own controller to compare: 'file.py:Class' or 'module:Class'.
        loop: also find the gains at which the loop becomes unstable, computed and measured.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case has no controller to be compared, or a name is unknown.
    """
    from rollerrig.study.control import ControlStudy, study_case

    study = ControlStudy(study_case(_case(case), duration), tuple(families), controller, loop)
    return _outcome(study, processes, progress)


def tune(
    case: Case | str,
    free: Annotated[Mapping[str, object] | None, Option(meaning=_FREE)] = None,
    *,
    duration: Annotated[float, Option(least=1.0, most=600.0)] = 4.0,
    draws: Annotated[int, Option(least=2, most=100)] = 3,
    candidates: Annotated[int, Option(least=2, most=10000)] = 24,
    gain_margin: Annotated[float, Option(least=1.0, most=100.0)] = 2.0,
    phase_margin_deg: Annotated[float, Option(least=0.0, most=180.0)] = 45.0,
    seed: Annotated[int, Option(least=0)] = 1,
    processes: Processes = 1,
    progress: Progress | None = None,
) -> Outcome[Any]:
    """Gains and filters of the rig's controller: tracking error against torque ripple, with margins of the loop.

    Args:
        case: case on rollers with [rig_control]: a name of the catalogue or a TOML file.
        free: what is sought, dotted key of [rig_control] -> least and most; None: bandwidths of feedback and estimator.
        duration: length of each run [s].
        draws: tests of each candidate, drawn by [ensemble] alike for all.
        candidates: half of them fill the ranges, the others lie about the front found so far.
        gain_margin: least factor on the gains at which the loop with the vehicle becomes unstable.
        phase_margin_deg: least phase margin of one axle's feedback [deg].
        seed: of the candidates.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case has no controller with a linear loop, or a key or range does not fit.
        StartError: no rolling equilibrium was found.
    """
    from rollerrig.study.tune import FREE, TuneStudy

    wanted = FREE if free is None else free
    study = TuneStudy(_case(case), wanted, duration, draws, candidates, gain_margin, phase_margin_deg, seed)
    return _outcome(study, processes, progress)


def response(
    case: Case | str,
    inputs: Annotated[Sequence[str], Option("input", default=(), meaning="a command of the bench; again for more.")],
    outputs: Annotated[Sequence[str], Option("output", default=(), meaning="an output; again for more.")],
    speeds_kmh: Annotated[
        Sequence[float],
        Option(meaning="speeds [km/h] as start:stop:step, or a list; that of the case if absent."),
    ] = (),
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
) -> Outcome[Any]:
    """Frequency response from commands to outputs: Bode, Nyquist, poles and zeros, margins, and measured beside it.

    Args:
        case: case: a name of the catalogue or a TOML file.
        inputs: commands of the bench, as `linearize` takes them.
        outputs: outputs of the bench.
        speeds_kmh: speeds [km/h]; none: that of the case.
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
    from rollerrig.study.response import ResponseStudy

    whole, names = _case(case), (tuple(inputs), tuple(outputs))
    speeds = tuple(speeds_kmh) or (3.6 * whole.motion.speed,)
    study = ResponseStudy(whole, *names, speeds, frequencies, points, measured, amplitude, brake_pressure)
    return _outcome(study, processes, progress)


def lateral(case: Case | str, *, processes: Processes = 1, progress: Progress | None = None) -> Outcome[Any]:
    """Lateral motion during a slide: does hunting disturb the rig's control, and does the rig show what the track does?

    Args:
        case: case on elastic rollers with [rig_control] and a lateral disturbance: adhesion_lateral, or a TOML file.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case says nothing about lateral motion in a slide.
    """
    from rollerrig.study.lateral import LateralStudy

    return _outcome(LateralStudy(_case(case)), processes, progress)


def envelope(
    case: Case | str,
    *,
    torques: Annotated[Sequence[float] | None, Option("torques_knm", "kN m", ordered=True, meaning=_TORQUES)] = None,
    adhesions: Annotated[Sequence[float] | None, Option(ordered=True, meaning=_ADHESIONS)] = None,
    loads: Annotated[Sequence[float] | None, Option(ordered=True, meaning=_LOADS)] = None,
    speed_kmh: float | None = None,
    duration: float = 3.0,
    refine: Annotated[int, Option(least=0, most=4)] = 1,
    folder: str | Path | None = None,
    processes: Processes = 1,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Operating envelope: where the rig reproduces a degraded rail over torque, adhesion and axle load, and what limits it.

    Ctrl-C keeps all finished runs; the same command continues with the rest, and another grid takes over those it shares.

    Args:
        case: case on rollers with [rig_control]: a name of the catalogue or a TOML file.
        torques: torques on each axle, ascending, negative brakes [N m]; None: up to beyond what dry rollers carry, braking
            for a case with [brake].
        adhesions: adhesions of the reproduced rail, ascending [-]; None: 0.02 to 0.36.
        loads: axle loads over the case's own, ascending [-]; None: 0.6, 1, 1.4.
        speed_kmh: speed at the start [km/h]; the case's if absent.
        duration: length of each run [s].
        refine: how many times cells between different regions are halved.
        folder: where finished runs are kept and looked for; None: nowhere.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Returns:
        Dataset over `load`, `adhesion`, `torque`: `region` ("" where refining needed no run), the numbers of NUMBERS, the limits
        reached as text, and the closed forms of LINES. Attribute `interrupted` says whether Ctrl-C left some undone,
        `jobs_taken_over` how many were finished before.

    Raises:
        ConfigError: the case reproduces nothing, a range is unusable, or `folder` has the runs of another case.

    Example:
        >>> from rollerrig import envelope, load_case
        >>> case = load_case("adhesion_brake")
        >>> map = envelope(case, torques=[-4e3, -2e3], adhesions=[0.05, 0.3], loads=[1.0], duration=1.0, refine=0)
        >>> map["region"].sel(load=1.0, torque=-4e3).to_numpy().tolist()
        ['slide', 'grip']
    """
    from rollerrig.study.envelope import EnvelopeStudy

    whole = _case(case)
    if speed_kmh is not None:
        whole = whole.with_changes({"motion.speed": f"{speed_kmh} km/h"})
    ranges = {"torques": torques, "adhesions": adhesions, "loads": loads}
    chosen = {name: tuple(map(float, values)) for name, values in ranges.items() if values is not None}
    outcome = _outcome(EnvelopeStudy(whole, duration=duration, refine=refine, **chosen), processes, progress, folder)
    found: xr.Dataset = outcome.results.map
    return found.assign_attrs(interrupted=int(outcome.interrupted), jobs_taken_over=outcome.taken_over)


def scale(
    case: Case | str,
    strategy: Annotated[str, Option()],
    *,
    length: float | None = None,
    time: float | None = None,
    density: float | None = None,
    keep: Annotated[Sequence[str], Option(commas=True, meaning=_KEEP)] = ("gravity", "material"),
    changes: Annotated[Mapping[str, object] | None, Option("change", meaning=_CHANGES)] = None,
    error_budget: Annotated[bool, Option(meaning="with --run: also each violation alone.")] = True,
    processes: Processes = 1,
    progress: Progress | None = None,
) -> Outcome[Any]:
    """The same test on a full-scale rig and on its scaled model, mapped back; `outcome.study.model` is the model's case.

    Args:
        case: full-scale case on rollers: a name of the catalogue or a TOML file.
        strategy: 'mmu' keeps time, 'dlr' gravity, 'inrets' speed and elastic contact.
        length: length at full scale over that of the model; 5, 5, 4 by default.
        time: time at full scale over that of the model.
        density: density at full scale over that of the model.
        keep: what the model does not scale: gravity, material, clock, drives; none: ideal similitude.
        changes: what the model has of its own, at its own scale: dotted key of its case -> value.
        error_budget: also the ideal model, and each violation alone.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case cannot be scaled so.
        StartError: a case finds no equilibrium to start from.
    """
    from rollerrig.similitude import similitude
    from rollerrig.study.scale import scale_study

    factors, kept = similitude(strategy, length, time, density), tuple(name for name in keep if name != "none")
    study = scale_study(_case(case), factors, strategy=strategy, keep=kept, changes=changes, error_budget=error_budget)
    return _outcome(study, processes, progress)


def sweep(
    case: Case | str,
    vary: Mapping[str, Any],
    *,
    measure: str | Mapping[str, Any] | Sequence[str | Mapping[str, Any]] | Callable[[Case], Mapping[str, float]],
    design: str | Mapping[str, Any] = "grid",
    folder: str | Path | None = None,
    many: bool = False,
    workers: int = 1,
    dask: str | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Numbers of many cases that differ in a few keys.

    Args:
        case: the case that is varied.
        vary: dotted key -> list of values, or a table as in a plan, such as `{"least": "0.5 m", "most": "1 m", "count": 11}`.
        measure: what is computed: a kind such as 'critical_speed', a table or several of them as in a plan, or a function of
            your own from a case to numbers by name; for more than one worker it stands on the top level of a module.
        design: how cases are chosen, as in a plan: 'grid', or a table such as `{"kind": "sobol", "samples": 64}`.
        folder: where finished cases are kept and looked for; None: nowhere.
        many: whether more than 100 000 cases are meant.
        workers: cases at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        dask: address of the scheduler of a dask cluster that does the work instead.
        progress: called with the fraction done and a short text.

    Returns:
        Dataset: the varied keys as coordinates in SI, each number with its unit, `failed` with the reason of each failed case;
        over the keys for a grid, else over `sample`.

    Raises:
        ConfigError: an unknown key, a value that does not fit it, no cases or too many, or `folder` has the cases of another
            plan.
        ClusterError: `dask` leads to no usable cluster.
        KeyboardInterrupt: Ctrl-C; finished cases are in `folder`.

    Example:
        >>> import rollerrig as rr
        >>> radii = {"support.roller_radius": ["0.5 m", "1 m"]}
        >>> found = rr.sweep("bogie_rollers_constant", radii, measure="critical_speed")
        >>> found["linear_critical_speed"].round().to_numpy().tolist()
        [210.0, 234.0]
    """
    from rollerrig.study.cluster import cluster
    from rollerrig.study.sweep import sweep_study

    study = sweep_study(_case(case), vary, measure, design, many=many)
    if dask is None:
        found = study.run(folder=folder, processes=workers, progress=progress)
    else:
        with cluster(dask) as executor:
            found = study.run(folder=folder, progress=progress, executor=executor)
    if found is None or found.interrupted:
        raise KeyboardInterrupt
    data: xr.Dataset = found.results
    return data


def fit(
    plan: Mapping[str, Any] | str,
    logs: Sequence[str | Path | Mapping[str, Any]],
    *,
    changes: Annotated[Mapping[str, object] | None, Option("change", meaning=_FIT_CHANGES)] = None,
    allow_code: bool = False,
    processes: OneProcess = 1,
    progress: Progress | None = None,
) -> Outcome[Any]:
    """Numbers of a case from measured logs: estimates with intervals, what the logs do not determine, the fitted case.

    Args:
        plan: plan of a fit: a name of the catalogue or a TOML file.
        logs: files of measured signals (.csv, .mat, .nc, .parquet), one for each [[log]] of the plan.
        changes: of the plan's case: dotted key -> value.
        allow_code: also take controllers from outside the folder of the case that names them.
        processes: searches at a time.
        progress: called with the fraction done and a short text.

    From Python a plan may also be its tables, and a log its columns: heading -> values.

    Raises:
        ConfigError: all mistakes of plan and logs, found before the first run; a free key that changes nothing.
        FileNotFoundError: a log that is not there.
        ResultsError: a file that is no log.

    Example:
        >>> import rollerrig as rr
        >>> points = {"creepage [%]": [0.5, 1.1, 2.9, 6.0, 14.1], "traction_coefficient": [0.25, 0.288, 0.304, 0.297, 0.241]}
        >>> found = rr.fit("creep_curve", [{**points, "traction_error": [0.005] * 5}])
        >>> {name: round(one["value"], 1) for name, one in found.numbers["numbers"].items()}
        {'mu_0': 0.4, 'B': 0.5, 'k_S': 0.4}
    """
    from rollerrig.config.load.fit import load_fit
    from rollerrig.config.read import Document
    from rollerrig.results.logs import log_of
    from rollerrig.study.fit import FitStudy, records

    source = Document(dict(plan), "plan", Path()) if isinstance(plan, Mapping) else str(plan)
    whole = load_fit(source, allow_code=allow_code, changes=changes)
    given = [log_of(one, f"log {k + 1}") if isinstance(one, Mapping) else one for k, one in enumerate(logs)]
    return _outcome(FitStudy(whole, records(whole, given)), processes, progress)


def compare(
    vehicle: str,
    on: Annotated[Sequence[str], Option(commas=True, meaning=_SUPPORTS)] = ("rig", "track"),
    *,
    speeds_kmh: SpeedsKmh = SPEEDS_KMH,
    cut: str | None = None,
    radii: Annotated[Sequence[float], Option("radii_m", "", 0.05, 1e6)] = (0.46, 0.725, 1.0, 2.0, 5.0, 10.0),
    disturbance: Annotated[float, Option("disturbance_mm", "mm", 0.01, 20.0)] = 3e-3,
    duration: Annotated[float, Option(least=1.0, most=600.0)] = 6.0,
    processes: Processes = 1,
    allow_code: bool = False,
    progress: Progress | None = None,
    **hunting: float,
) -> Outcome[Any]:
    """One vehicle on several supports side by side: modes, critical speeds, limit cycles, forces, effects of the rollers.

    Args:
        vehicle: vehicle or case: a name of the catalogue or a TOML file.
        on: supports: 'rig', 'track', names of the catalogue or files.
        speeds_kmh: speeds [km/h], rising.
        cut: part of the vehicle; by default all of it, or what the case has.
        radii: radii of the rollers in the table of critical speeds [m].
        disturbance: lateral offset of the leading wheelset in the runs [m].
        duration: length of each of these runs [s], at least.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        allow_code: also take controllers from outside the folder of the case that names them.
        progress: called with the fraction done and a short text.
        **hunting: others of `HuntingSettings`.

    Raises:
        ConfigError: a vehicle or support is unknown or cannot be used.
    """
    from rollerrig.analysis.hunting import HuntingSettings
    from rollerrig.study.compare import CompareStudy, compared_cases

    cases = compared_cases(vehicle, on, cut, allow_code=allow_code)
    parts = tuple(next(iter(cases.values())).vehicle.data.cut_names()[::-1])
    settings = HuntingSettings(disturbance=disturbance, duration=duration, **hunting)
    study = CompareStudy(cases, tuple(speeds_kmh), parts, tuple(sorted(set(radii))), hunting=settings)
    return _outcome(study, processes, progress)


def paper(*, quick: bool = False, processes: Processes = 1, progress: Progress | None = None) -> Outcome[Any]:
    """Reproduce the paper's two studies: figures 7 and 8, checks against theory, one report.

    Args:
        quick: few and short runs: to see that everything works.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.
    """
    from rollerrig.study.paper import PaperStudy
    from rollerrig.study.runs.paper import FULL, QUICK

    return _outcome(PaperStudy(QUICK if quick else FULL), processes, progress)


_FUNCTIONS = (paper, run, stability, response, compare, curving, adhesion, wsp, reconstruct, replay, control, tune, lateral,
              scale, envelope, creep, conicity, fit)  # fmt: skip
STUDIES = {function.__name__: parameters(function) for function in _FUNCTIONS}
"""Function that is a command -> its arguments."""
