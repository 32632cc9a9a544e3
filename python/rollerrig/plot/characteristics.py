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
    with house_style():
        figure = Figure(figsize=(8.4, 8.6), layout="constrained")
        FigureCanvasAgg(figure)
        radii, cone, on_wheel, on_rail, angle, wave = figure.subplots(3, 2).flat
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
        shift, size = "lateral shift to the left [mm]", "amplitude [mm]"
        _finish(radii, shift, "rolling radius difference [mm]", "left less right; on rollers with their own radii")
        _finish(cone, size, "equivalent conicity [-]", "EN 15302, integration of the kinematic motion")
        _finish(on_wheel, shift, "contact on the wheel S [mm]", "flange is negative")
        _finish(on_rail, shift, "contact on the rail head [mm]", "gauge side is negative")
        _finish(angle, shift, "contact angle [rad]", "positive as at the flange")
        _finish(wave, size, "wavelength [m]", "free wheelset, pure rolling")
        cone.set_ylim(bottom=min(0.0, cone.get_ylim()[0]))
        first = next(iter(shifts.values()))
        gauge, back = 1e3 * first.attrs["gauge_m"], 1e3 * first.attrs["back_to_back_m"]
        figure.suptitle(f"{first.attrs['title']}: gauge {gauge:g} mm, back-to-back {back:g} mm", fontsize=10)
    return figure


def _finish(axes: Axes, along: str, up: str, note: str) -> None:
    axes.set_xlabel(along)
    axes.set_ylabel(up)
    axes.set_title(note, loc="left", fontsize=8)
    axes.legend(fontsize=7.5)
