"""`rollerrig conicity WHEEL RAIL --roller-radius 725mm --out DIR`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from rollerrig.cli.command import Force, Out, carry_out
from rollerrig.cli.ranges import read_range
from rollerrig.cli.termination import stop

if TYPE_CHECKING:
    from pydantic import BaseModel


def command(
    wheel: Annotated[str, typer.Argument(help="Wheel profile: a name of the catalogue or a file of points.")],
    rail: Annotated[str, typer.Argument(help="Rail profile, also the generatrix of a roller: likewise.")],
    out: Out,
    gauge: Annotated[str, typer.Option(help="Distance between the gauge sides.")] = "1435mm",
    gauge_depth: Annotated[str, typer.Option(help="Depth below the highest point where it is taken.")] = "14mm",
    back_to_back: Annotated[str, typer.Option(help="Distance between the flange backs.")] = "1360mm",
    radius: Annotated[str, typer.Option(help="Wheel radius at the tape circle.")] = "460mm",
    roller_radius: Annotated[
        str | None, typer.Option(help="Radius of rollers of this head, to be shown beside the rails.")
    ] = None,
    amplitudes_mm: Annotated[
        str, typer.Option(help="Amplitudes of the conicity: start:stop:step, a list or one number [mm].")
    ] = "0.5:7:0.1",
    shift_mm: Annotated[float, typer.Option(min=0.1, max=50.0, help="Lateral shift to both sides [mm].")] = 8.0,
    step_mm: Annotated[float, typer.Option(min=0.005, max=1.0, help="Distance of the rows [mm].")] = 0.1,
    yaw_mrad: Annotated[float, typer.Option(min=-100.0, max=100.0, help="Yaw angle of the wheelset [mrad].")] = 0.0,
    with_roll: Annotated[
        bool, typer.Option("--with-roll", help="Roll the wheelset until both wheels touch; neglected otherwise.")
    ] = False,
    force: Force = False,
) -> None:
    """Rolling radius difference, contact angles and positions, and equivalent conicity of a pair of profiles."""
    from rollerrig.config import Rig, Track, Wheel
    from rollerrig.study.conicity import ConicityStudy

    lengths = {
        "gauge": _length(gauge, "--gauge", Track, "gauge"),
        "gauge_depth": _length(gauge_depth, "--gauge-depth", Track, "gauge_depth"),
        "back_to_back": _length(back_to_back, "--back-to-back", Wheel, "back_to_back"),
        "radius": _length(radius, "--radius", Wheel, "radius"),
    }
    roller = None if roller_radius is None else _length(roller_radius, "--roller-radius", Rig, "roller_radius")
    amplitudes = read_range(amplitudes_mm, "--amplitudes-mm")
    if min(amplitudes) <= 0 or max(amplitudes) > shift_mm:
        allowed = f"amplitudes must lie above 0 and up to --shift-mm, {shift_mm:g}"
        raise typer.BadParameter(f"'{amplitudes_mm}': {allowed}", param_hint="--amplitudes-mm")
    try:
        study = ConicityStudy(
            wheel,
            rail,
            tuple(1e-3 * a for a in sorted(set(amplitudes))),
            roller,
            1e-3 * shift_mm,
            1e-3 * min(step_mm, shift_mm),
            with_roll,
            1e-3 * yaw_mrad,
            lengths,
        )
    except ValueError as error:
        stop(f"{wheel} on {rail}: {error}")
    carry_out(study, out, refused=(ValueError,), force=force)


def _length(text: str, option: str, table: type[BaseModel], key: str) -> float:
    """A length with its unit, in metres, in the range of a key of the configuration."""
    from rollerrig.config.schema.base import quantity_of

    field = table.model_fields[key]
    quantity = quantity_of(field.annotation, field.metadata)
    assert quantity is not None
    try:
        return quantity.parse(text)
    except ValueError:
        needed = f"write it with its unit, like 460mm, from {quantity.least:g} to {quantity.most:g} m"
        raise typer.BadParameter(f"'{text}': {needed}", param_hint=option) from None
