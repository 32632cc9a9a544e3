"""What the commands of `rollerrig` do, as functions: the same names, from Python.

case -> [commands] -> Dataset with units, or Outcome of a study -> rollerrig.plot, Outcome.write(folder)

A case is a `Case` or a name of the catalogue or file. An `Outcome` has `results` (Datasets), `numbers` (those of summary.json),
`summary` (the findings as text) and `write(folder)` (the files of the command). Modules are loaded by the function that needs
them: `import rollerrig` costs nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from rollerrig.analysis.crew import Progress
from rollerrig.analysis.mode_table import SPEEDS_KMH
from rollerrig.cases import as_case
from rollerrig.config import Case, Programme, load_programme

if TYPE_CHECKING:
    from rollerrig.study.frame import Outcome, Study


def _outcome(study: Study[Any], processes: int, progress: Progress | None) -> Outcome[Any]:
    found = study.run(processes=processes, progress=progress)
    if found is None:
        raise KeyboardInterrupt
    return found


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
        StartError: no state was found from which a run can start.
    """
    from rollerrig.analysis import LimitCycleSettings, limit_cycle_table
    from rollerrig.study.limit_cycles import limit_cycles

    chosen = LimitCycleSettings(**settings)
    found = limit_cycles(as_case(case), speeds_kmh, linear_critical_kmh, chosen, processes=processes, folder=folder,
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
    from rollerrig.contact_analysis.static_contact import contact_table

    chosen = [(float(y), 0.0) for y in np.linspace(-8e-3, 8e-3, 33)] if positions is None else positions
    return contact_table(as_case(case), chosen, roll=roll)


def creep(
    a_over_b: float = 1.0,
    laws: Sequence[str] = ("kalker_saturated", "fastsim", "modified_fastsim", "table"),
    **options: Any,
) -> xr.Dataset:
    """Forces and spin moment of creep laws beside the exact theory on one ellipse.

    Args:
        a_over_b: semi-axis along the rolling direction over the one across it, 0.1 to 10.
        laws: names that `contact.creep` knows.
        **options: of `CreepStudy`: poisson_ratio, demands, parameters of laws.

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

    results: xr.Dataset = _outcome(CreepStudy(a_over_b, tuple(laws), **options), 1, None).results
    return results


def conicity(
    wheel: str, rail: str, *, roller_radius: float | None = None, yaw: float = 0.0, **options: Any
) -> xr.Dataset:
    """Contact characteristics of a pair of profiles: rolling radii, angles, positions, equivalent conicity.

    Args:
        wheel: wheel profile: a name of the catalogue or a file.
        rail: rail profile, also the generatrix of a roller: likewise.
        roller_radius: of rollers of this head, beside the rails [m]; None: rails only.
        yaw: of the wheelset [rad].
        **options: of `ConicityStudy`: amplitudes, largest, step [m], free_to_roll, lengths.

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

    study = ConicityStudy(wheel, rail, roller_radius=roller_radius, yaw=yaw, **options)
    results: Characteristics = _outcome(study, 1, None).results
    return results.dataset()


# ------------------------------------------------------------------------------------------------------------ studies


def adhesion(
    case: Case | str,
    *,
    error_budget: bool = True,
    quick: bool = False,
    processes: int = 1,
    progress: Progress | None = None,
) -> Outcome[Any]:
    """A brake or traction test on degraded track and on the dry rig that reproduces it.

    Args:
        case: on rollers with [rig_control].
        error_budget: also run the rig without one imperfection after the other, and the track with later protection.
        quick: two starts of each test, to see that everything works.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case is no such test.
        StartError: a case finds no equilibrium to start from.
    """
    from rollerrig.study.adhesion import AdhesionStudy

    return _outcome(AdhesionStudy(as_case(case), error_budget, quick), processes, progress)


def wsp(
    case: Case | str,
    programme: Programme | str = "slide_protection_stops",
    *,
    starts: int = 0,
    quick: bool = False,
    processes: int = 1,
    progress: Progress | None = None,
) -> Outcome[Any]:
    """A test programme for wheel slide protection: a series of stops on track and on the rig, judged by limits.

    Args:
        case: on rollers with [brake], [slide_protection] and [rig_control].
        programme: stops and limits, or its name in the catalogue or file.
        starts: tests of each stop on each support; 0: as many as the programme needs for a decision.
        quick: two starts of the first two stops, to see that everything works.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case has nothing to test, or cannot do a stop.
        StartError: a case finds no equilibrium to start from.
    """
    from rollerrig.study.wsp import WspStudy

    found = programme if isinstance(programme, Programme) else load_programme(programme)
    return _outcome(WspStudy(as_case(case), found, starts, quick), processes, progress)


def control(
    case: Case | str,
    *,
    duration: float = 10.0,
    families: Sequence[str] = (),
    controller: str | None = None,
    loop: bool = True,
    lags: bool = True,
    processes: int = 1,
    progress: Progress | None = None,
) -> Outcome[Any]:
    """Controllers of the roller drives compared: which limit each of them reaches first.

    Args:
        case: on rollers with [rig_control].
        duration: of each run [s].
        families: what is varied, by name; none: everything.
        controller: 'file.py:Class' of a controller of your own, compared with the built-in ones.
        loop: also find where the loop becomes unstable, computed and measured.
        lags: also compare ways to compensate the lags, in runs of the case's own duration.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case has no controller to be compared, or a name is unknown.
    """
    from rollerrig.study.control import ControlStudy, study_case

    whole = as_case(case)
    length = whole.time.duration if lags else 0.0
    study = ControlStudy(study_case(whole, duration), tuple(families), controller, loop, length)
    return _outcome(study, processes, progress)


def response(
    case: Case | str,
    inputs: Sequence[str],
    outputs: Sequence[str],
    speeds_kmh: Sequence[float] = (),
    *,
    processes: int = 1,
    progress: Progress | None = None,
    **options: Any,
) -> Outcome[Any]:
    """Frequency responses of the bench from commands to outputs, linear and measured on the nonlinear one.

    Args:
        case: the case.
        inputs: names of commands, as `linearize` takes them.
        outputs: names of outputs.
        speeds_kmh: [km/h]; none: that of the case.
        processes: speeds at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.
        **options: of `ResponseStudy`: frequencies [Hz], points, measured, amplitude, brake_pressure [Pa].

    Raises:
        ConfigError: an unknown name, or a speed that the case does not allow.
        StartError: no rolling equilibrium was found.
    """
    from rollerrig.study.response import ResponseStudy

    whole = as_case(case)
    speeds = tuple(speeds_kmh) or (3.6 * whole.motion.speed,)
    return _outcome(ResponseStudy(whole, tuple(inputs), tuple(outputs), speeds, **options), processes, progress)


def lateral(case: Case | str, *, processes: int = 1, progress: Progress | None = None) -> Outcome[Any]:
    """Lateral motion during a slide, on the rig and on the track.

    Args:
        case: on elastic rollers with [rig_control] and a lateral disturbance.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case says nothing about lateral motion in a slide.
    """
    from rollerrig.study.lateral import LateralStudy

    return _outcome(LateralStudy(as_case(case)), processes, progress)


def scale(
    case: Case | str,
    strategy: str,
    *,
    length: float | None = None,
    time: float | None = None,
    density: float | None = None,
    keep: Sequence[str] = ("gravity", "material"),
    changes: Mapping[str, object] | None = None,
    error_budget: bool = True,
    processes: int = 1,
    progress: Progress | None = None,
) -> Outcome[Any]:
    """The same test on a full-scale rig and on its scaled model, mapped back; `outcome.study.model` is the model's case.

    Args:
        case: full-scale case on rollers.
        strategy: 'mmu' keeps time, 'dlr' gravity, 'inrets' speed and elastic contact.
        length: at full scale over that of the model [-]; None: that of the strategy. Likewise:
        time: [-].
        density: [-].
        keep: what the model does not scale: gravity, material, clock, drives.
        changes: what the model has of its own, dotted keys of its case.
        error_budget: also the ideal model, and each violation alone.
        processes: runs at a time.
        progress: called with the fraction done and a short text.

    Raises:
        ConfigError: the case cannot be scaled so.
        StartError: a case finds no equilibrium to start from.
    """
    from rollerrig.similitude import similitude
    from rollerrig.study.scale import scale_study

    factors = similitude(strategy, length, time, density)
    study = scale_study(
        as_case(case), factors, strategy=strategy, keep=tuple(keep), changes=changes, error_budget=error_budget
    )
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
    from rollerrig.analysis.cluster import cluster
    from rollerrig.study.sweep import sweep_study

    study = sweep_study(as_case(case), vary, measure, design, many=many)
    if dask is None:
        found = study.run(folder=folder, processes=workers, progress=progress)
    else:
        with cluster(dask) as executor:
            found = study.run(folder=folder, progress=progress, executor=executor)
    if found is None or found.interrupted:
        raise KeyboardInterrupt
    return found.results.data


def compare(
    vehicle: str,
    on: Sequence[str] = ("rig", "track"),
    *,
    speeds_kmh: Sequence[float] = SPEEDS_KMH,
    cut: str | None = None,
    radii: Sequence[float] | None = None,
    processes: int = 1,
    progress: Progress | None = None,
    **hunting: float,
) -> Outcome[Any]:
    """One vehicle on several supports side by side.

    Args:
        vehicle: vehicle or case, of the catalogue or a TOML file.
        on: supports: 'rig', 'track', names of the catalogue or files.
        speeds_kmh: of the modes [km/h].
        cut: part of the vehicle; None: all of it, or what the case has.
        radii: of the rollers in the table of critical speeds [m].
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.
        **hunting: of `HuntingSettings`, such as disturbance [m] and duration [s] of the runs.

    Raises:
        ConfigError: a vehicle or support is unknown or cannot be used.
    """
    from rollerrig.analysis import HuntingSettings
    from rollerrig.analysis.critical_speed import RADII
    from rollerrig.study.compare import CompareStudy
    from rollerrig.study.runs.compare import compared_cases

    cases = compared_cases(vehicle, on, cut)
    parts = tuple(next(iter(cases.values())).vehicle.data.cut_names()[::-1])
    chosen = tuple(sorted(set(radii or RADII)))
    study = CompareStudy(cases, tuple(speeds_kmh), parts, chosen, hunting=HuntingSettings(**hunting))
    return _outcome(study, processes, progress)


def paper(*, quick: bool = False, processes: int = 1, progress: Progress | None = None) -> Outcome[Any]:
    """The paper's two studies: figures 7 and 8, checks against theory.

    Args:
        quick: few and short runs, to see that everything works.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.
    """
    from rollerrig.study.paper import PaperStudy
    from rollerrig.study.runs.paper import FULL, QUICK

    return _outcome(PaperStudy(QUICK if quick else FULL), processes, progress)
