"""Contact characteristics as one figure: what a wheelset's rolling radii, angles and contacts do over its shift."""

from __future__ import annotations

from collections.abc import Mapping

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rollerrig.plot.style import COLOURS, STYLES, house_style


def characteristics_figure(shifts: Mapping[str, xr.Dataset], conicity: Mapping[str, xr.Dataset]) -> Figure:
    """Rolling radius difference, conicity, contact positions, angles and wavelength; each support in its own style.

    Args:
        shifts: label -> what `shift_table` returns; the first is drawn full, further ones dashed over it.
        conicity: the same labels -> what `conicity_table` returns.
    """
    first = next(iter(shifts.values()))
    rolls, yawed = first.attrs["roll"] == "free", first.attrs["yaw_rad"] != 0.0
    with house_style():
        rows = 4 if rolls or yawed else 3
        figure = Figure(figsize=(8.4, 2.9 * rows), layout="constrained")
        FigureCanvasAgg(figure)
        radii, cone, on_wheel, on_rail, angle, wave, *further = figure.subplots(rows, 2).flat
        for number, (label, table) in enumerate(shifts.items()):
            style = STYLES[number % len(STYLES)]
            lateral = 1e3 * table["lateral"]
            colour = COLOURS[number % len(COLOURS)]
            radii.plot(lateral, 1e3 * table["effective_difference"], style, color=colour, label=label)
            for side, side_colour in zip(("left", "right"), COLOURS, strict=False):
                here = table.sel(side=side)
                name = side if number == 0 else None
                on_wheel.plot(lateral, 1e3 * here["wheel_abscissa"], style, color=side_colour, label=name)
                on_rail.plot(lateral, 1e3 * here["rail_abscissa"], style, color=side_colour, label=name)
                angle.plot(lateral, here["contact_angle"], style, color=side_colour, label=name)
            amplitude = 1e3 * conicity[label]["amplitude"]
            cone.plot(amplitude, conicity[label]["conicity"], style, color=colour, label=label)
            wave.plot(amplitude, conicity[label]["wavelength"], style, color=colour, label=label)
            if table.attrs["support"] != "track":
                cone.plot(
                    amplitude, conicity[label]["of_rollers"], ":", color=colour, label="part of the rollers' radii"
                )
        shift, size = "lateral shift to the left [mm]", "amplitude [mm]"
        _finish(radii, shift, "rolling radius difference [mm]", "left less right; on rollers with their own radii")
        _finish(cone, size, "equivalent conicity [-]", "EN 15302, integration of the kinematic motion")
        _finish(on_wheel, shift, "contact on the wheel S [mm]", "flange is negative")
        _finish(on_rail, shift, "contact on the rail head [mm]", "gauge side is negative")
        _finish(angle, shift, "contact angle [rad]", "positive as at the flange")
        _finish(wave, size, "wavelength [m]", "free wheelset, pure rolling")
        cone.set_ylim(bottom=min(0.0, cone.get_ylim()[0]))
        if rolls:
            _roll(further.pop(0), shifts)
        if yawed:
            _ahead(further.pop(0), shifts)
        for empty in further:
            empty.remove()
        gauge, back = 1e3 * first.attrs["gauge_m"], 1e3 * first.attrs["back_to_back_m"]
        yaw = f", yaw {1e3 * first.attrs['yaw_rad']:g} mrad" if yawed else ""
        figure.suptitle(f"{first.attrs['title']}: gauge {gauge:g} mm, back-to-back {back:g} mm{yaw}", fontsize=10)
    return figure


def _roll(axes: Axes, shifts: Mapping[str, xr.Dataset]) -> None:
    """Roll angle of a wheelset that touches on both sides."""
    for number, (label, table) in enumerate(shifts.items()):
        axes.plot(1e3 * table["lateral"], 1e3 * table["roll"], STYLES[number % 4], color=COLOURS[number], label=label)
    _finish(axes, "lateral shift to the left [mm]", "roll angle [mrad]", "both wheels touch")


def _ahead(axes: Axes, shifts: Mapping[str, xr.Dataset]) -> None:
    """Longitudinal position of the contacts of a yawed wheelset."""
    for number, table in enumerate(shifts.values()):
        for side, colour in zip(("left", "right"), COLOURS, strict=False):
            ahead = 1e3 * table["longitudinal"].sel(side=side)
            name = side if number == 0 else None
            axes.plot(1e3 * table["lateral"], ahead, STYLES[number % 4], color=colour, label=name)
    _finish(axes, "lateral shift to the left [mm]", "contact ahead of the axle [mm]", "a yawed wheelset")


def _finish(axes: Axes, along: str, up: str, note: str) -> None:
    axes.set_xlabel(along)
    axes.set_ylabel(up)
    axes.set_title(note, loc="left", fontsize=8)
    axes.legend(fontsize=7.5)
