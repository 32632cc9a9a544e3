"""Commands that make a study of one case: `rollerrig adhesion CASE --out DIR` and its like.

case, options of the study -> [study_command] -> command with the options that all of them share -> files, summary
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rollerrig.cli.command import (
    AllowCode,
    CaseName,
    Changes,
    Force,
    Out,
    Processes,
    RigCaseName,
    SpeedsKmh,
    carry_out,
    read_case,
)
from rollerrig.cli.ranges import check_finite, read_range, read_speeds

if TYPE_CHECKING:
    from rollerrig.config import Case
else:
    Case = Any  # the table of commands is made without reading what they need

CASE, RIG = CaseName, RigCaseName
LATERAL = Annotated[
    str,
    typer.Argument(
        metavar="CASE",
        help="Case on elastic rollers with [rig_control] and a lateral disturbance: adhesion_lateral, or a TOML file.",
    ),
]
TWO = Annotated[int, typer.Option(min=1, max=2, help="With 2, the two sweeps run at a time.")]


def study_command(
    case: Any, processes: int | None = 2, *, kind: Any = Processes, before: str = "change"
) -> Callable[[Callable[..., Any]], Callable[..., None]]:
    """A command from a function of the case and options of its own, which returns the study.

    Args:
        case: annotation of the case's argument.
        processes: default of `--processes`; None: the study has no such option.
        kind: its annotation.
        before: option before which it stands.
    """

    def decorate(make: Callable[..., Any]) -> Callable[..., None]:
        def parameter(name: str, annotation: Any, default: Any = inspect.Parameter.empty) -> inspect.Parameter:
            kind_of = inspect.Parameter.POSITIONAL_OR_KEYWORD
            return inspect.Parameter(name, kind_of, default=default, annotation=annotation)

        own = list(inspect.signature(make, eval_str=True).parameters.values())[1:]
        last = [parameter("change", Changes, None), parameter("allow_code", AllowCode, False)]
        found = [parameter("case", case), parameter("out", Out), *own, *last, parameter("force", Force, False)]
        if processes is not None:
            place = next(k for k, one in enumerate(found) if one.name == before)
            found.insert(place, parameter("processes", kind, processes))

        def command(**given: Any) -> None:
            chosen = read_case(given.pop("case"), allow_code=given.pop("allow_code"), changes=given.pop("change"))
            out, force, count = given.pop("out"), given.pop("force"), given.pop("processes", 1)
            carry_out(make(chosen, **given), out, count, force=force)

        command.__name__, command.__doc__ = make.__name__, make.__doc__
        command.__annotations__ = {one.name: one.annotation for one in found}
        command.__signature__ = inspect.Signature(found)  # type: ignore[attr-defined]
        return command

    return decorate


@study_command(CASE, None)
def run(case: Case) -> Any:
    """Simulate one case: run.nc (every signal), summary.json, tables as CSV, report.html, view.html (in motion)."""
    from rollerrig.study.run import RunStudy

    return RunStudy(case)


@study_command(CASE, 2, kind=TWO, before="contacts_kmh")
def stability(
    case: Case,
    speeds_kmh: SpeedsKmh = "60:300:20",
    limit_cycles: Annotated[
        bool, typer.Option(help="Also run at up to 20 of the speeds, stepped up and down, for limit cycles.")
    ] = True,
    disturbance_mm: Annotated[
        float,
        typer.Option(
            min=0.01, max=20.0, help="Lateral offset of the leading wheelset that starts the downward sweep [mm]."
        ),
    ] = 3.0,
    perturbation_mm: Annotated[
        float, typer.Option(min=0.001, max=20.0, help="The same for the upward sweep [mm].")
    ] = 0.1,
    longest: Annotated[
        float, typer.Option(min=2.0, max=600.0, help="A run that has not settled by then ends [s].")
    ] = 16.0,
    tolerance_kmh: Annotated[
        float, typer.Option(min=0.01, max=100.0, help="To which the critical speed by continuation is found [km/h].")
    ] = 1.0,
    contacts_kmh: Annotated[
        float | None,
        typer.Option(
            min=1.0,
            max=600.0,
            help="Also compare the contact models, on rig and track, with a run at this speed [km/h].",
        ),
    ] = None,
) -> Any:
    """Eigenvalues, damping, frequency and mode shapes over speed; limit cycles; critical speeds."""
    from rollerrig.analysis import LimitCycleSettings
    from rollerrig.study.stability import StabilityStudy

    settings = LimitCycleSettings(
        disturbance=1e-3 * disturbance_mm,
        perturbation=1e-3 * perturbation_mm,
        longest=longest,
        tolerance_kmh=tolerance_kmh,
    )
    return StabilityStudy(case, read_speeds(speeds_kmh), limit_cycles, settings, contacts_kmh)


@study_command(CASE, 1)
def response(
    case: Case,
    input: Annotated[list[str] | None, typer.Option(help="A command of the bench; again for more.")] = None,  # noqa: A002
    output: Annotated[list[str] | None, typer.Option(help="An output; again for more.")] = None,
    speeds_kmh: Annotated[
        str | None, typer.Option(help="Speeds [km/h] as start:stop:step, or a list; that of the case if absent.")
    ] = None,
    from_hz: Annotated[float, typer.Option(min=1e-4, max=1e4, help="Lowest frequency [Hz].")] = 0.1,
    to_hz: Annotated[float, typer.Option(min=1e-3, max=1e5, help="Highest frequency [Hz].")] = 100.0,
    points: Annotated[int, typer.Option(min=10, max=20000, help="Frequencies of the linear bench.")] = 400,
    measured: Annotated[
        int,
        typer.Option(min=0, max=200, help="Frequencies at which the nonlinear bench is driven with a sine; 0: none."),
    ] = 12,
    amplitude: Annotated[float, typer.Option(min=1e-9, max=1e9, help="Of that sine, in the command's unit.")] = 1000.0,
    brake_pressure: Annotated[
        float,
        typer.Option(min=0.0, max=100.0, help="In all brake cylinders [bar]; the rollers' drives hold the speed."),
    ] = 0.0,
) -> Any:
    """Frequency response from commands to outputs: Bode, Nyquist, poles and zeros, margins, and measured beside it."""
    from rollerrig.study.response import ResponseStudy

    speeds = (3.6 * case.motion.speed,) if speeds_kmh is None else read_speeds(speeds_kmh)
    frequencies, pressure = (from_hz, to_hz), 1e5 * brake_pressure
    names = tuple(input or ()), tuple(output or ())
    return ResponseStudy(case, *names, speeds, frequencies, points, measured, amplitude, pressure)


@study_command(CASE, None)
def curving(
    case: Case,
    radii_m: Annotated[
        str, typer.Option(help="Radii of the curves: a list, one number or start:stop:step [m].")
    ] = "150,200,250,300,400,500,700,1000",
    deficiencies_mm: Annotated[
        str, typer.Option(help="Cant deficiencies, which decide the speed, in the same forms; negative: excess [mm].")
    ] = "-60,0,60,100,150",
    cant_mm: Annotated[
        float | None,
        typer.Option(min=0.0, max=300.0, help="Cant [mm]; absent: that of the case's first curve, or 100."),
    ] = None,
) -> Any:
    """Steady curving: Y, Q, Y/Q, sum of Y, angle of attack and wear number over radius and cant deficiency, with their limits."""
    from rollerrig.study.curving import CurvingStudy

    radii, deficiencies = read_range(radii_m, "--radii-m"), read_range(deficiencies_mm, "--deficiencies-mm")
    cant = None if cant_mm is None else 1e-3 * cant_mm
    return CurvingStudy(case, tuple(radii), tuple(1e-3 * d for d in deficiencies), cant)


@study_command(RIG)
def adhesion(
    case: Case,
    error_budget: Annotated[
        bool,
        typer.Option(
            help="Also run the rig without one imperfection after the other, and the track with later protection."
        ),
    ] = True,
    quick: Annotated[
        bool, typer.Option("--quick", help="Two starts of each test: to see that everything works.")
    ] = False,
) -> Any:
    """A brake or traction test on degraded track and on the dry rig that reproduces it, side by side."""
    from rollerrig.study.adhesion import AdhesionStudy

    return AdhesionStudy(case, error_budget, quick)


@study_command(RIG)
def wsp(
    case: Case,
    programme: Annotated[
        str, typer.Option(help="Stops and limits: a name of the catalogue or a TOML file.")
    ] = "slide_protection_stops",
    starts: Annotated[
        int,
        typer.Option(
            min=0, max=100, help="Tests of each stop on each support; 0: as many as the programme needs for a decision."
        ),
    ] = 0,
    quick: Annotated[
        bool, typer.Option("--quick", help="Two starts of the first two stops: to see that everything works.")
    ] = False,
) -> Any:
    """A test programme for wheel slide protection: a series of stops on track and on the rig, judged by limits."""
    from rollerrig.config import load_programme
    from rollerrig.study.wsp import WspStudy

    return WspStudy(case, load_programme(programme), starts, quick)


@study_command(RIG)
def control(
    case: Case,
    duration: Annotated[
        float,
        typer.Option(min=1.0, max=600.0, help="Length of each run [s]: until adhesion has broken away and recovered."),
    ] = 10.0,
    families: Annotated[
        str | None, typer.Option(help="What is varied, by name with commas between; absent: everything.")
    ] = None,
    controller: Annotated[
        str | None, typer.Option(help="Your own controller to compare: 'file.py:Class' or 'module:Class'.")
    ] = None,
    loop: Annotated[
        bool, typer.Option(help="Also find the gains at which the loop becomes unstable, computed and measured.")
    ] = True,
    lags: Annotated[
        bool, typer.Option(help="Also compare ways to compensate the lags, in tests of the case's own length.")
    ] = True,
) -> Any:
    """Controllers of the roller drives: estimators, feedbacks, sample times, drives, wrong parameters; which fails first."""
    from rollerrig.study.control import ControlStudy, study_case

    names = tuple(name.strip() for name in families.split(",")) if families else ()
    length = case.time.duration if lags else 0.0
    return ControlStudy(study_case(case, duration), names, controller, loop, length)


@study_command(LATERAL)
def lateral(case: Case) -> Any:
    """Lateral motion during a slide: does hunting disturb the rig's control, and does the rig show what the track does?"""
    from rollerrig.study.lateral import LateralStudy

    return LateralStudy(case)


@study_command(RIG)
def envelope(
    case: Case,
    torques_knm: Annotated[
        str | None,
        typer.Option(
            help="Torques on each axle [kN m], negative brakes: start:stop:step, or a list with commas. By default up to "
            "beyond what dry rollers carry, braking for a case with [brake]."
        ),
    ] = None,
    adhesions: Annotated[
        str | None, typer.Option(help="Adhesions of the reproduced rail, in the same forms; 0.02 to 0.36 if absent.")
    ] = None,
    loads: Annotated[
        str | None, typer.Option(help="Axle loads over the case's own, in the same forms; 0.6,1,1.4 if absent.")
    ] = None,
    speed_kmh: Annotated[float | None, typer.Option(help="Speed at the start [km/h]; the case's if absent.")] = None,
    duration: Annotated[float, typer.Option(help="Length of each run [s].")] = 3.0,
    refine: Annotated[
        int, typer.Option(min=0, max=4, help="How many times cells between different regions are halved.")
    ] = 1,
) -> Any:
    """Operating envelope: where the rig reproduces a degraded rail over torque, adhesion and axle load, and what limits it.

    Ctrl-C keeps all finished runs; the same command continues with the rest, and another grid takes over those it shares.
    """
    from rollerrig.study.envelope import EnvelopeStudy

    check_finite(speed_kmh, "--speed-kmh")
    check_finite(duration, "--duration")
    if speed_kmh is not None:
        case = case.with_changes({"motion.speed": f"{speed_kmh} km/h"})
    texts = {"torques-knm": (torques_knm, 1e3), "adhesions": (adhesions, 1.0), "loads": (loads, 1.0)}
    ranges = {
        name.removesuffix("-knm"): tuple(factor * value for value in sorted(read_range(text, f"--{name}")))
        for name, (text, factor) in texts.items()
        if text is not None
    }
    return EnvelopeStudy(case, duration=duration, refine=refine, **ranges)
