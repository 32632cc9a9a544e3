"""Figures of the contact alone: where wheels touch and how hard, characteristics of a pair, creep laws, a profile."""

from collections.abc import Mapping
from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rollerrig.plot.style import (
    COLOURS,
    GREY,
    MARKERS,
    STYLES,
    colour,
    headline,
    house_style,
    into_axes,
    legend_above,
    legend_below,
    logarithmic,
    new_figure,
    new_grid,
)


@into_axes
def contact_figure(table: xr.Dataset) -> Figure:
    """Position on the wheel, normal force, size of the patches and pose of the wheelset.

    Args:
        table: what `contact_table` returns; one entry per patch along `row`.
    """
    figure, (place, force, size, pose) = new_figure(4, height=9.0, sharex=True)
    lateral = 1e3 * table["lateral"]
    for number, side in enumerate(("left", "right")):
        here = (table["side"] == side).to_numpy()
        y = lateral[here]
        look: dict[str, Any] = {"linestyle": "none", "markersize": 4, "color": COLOURS[number]}
        place.plot(y, 1e3 * table["wheel_abscissa"][here], MARKERS[number], label=side, **look)
        force.plot(y, 1e-3 * table["normal"][here], MARKERS[number], label=side, **look)
        size.plot(y, 1e3 * table["a"][here], MARKERS[number], label=f"{side}, a along the rolling direction", **look)
        size.plot(y, 1e3 * table["b"][here], "x+"[number], label=f"{side}, b across it", **look)
    pose.plot(lateral, 1e3 * table["height"], ".", color="black", label="height [mm]")
    pose.plot(lateral, 1e3 * table["roll"], "x", markersize=4, color=COLOURS[2], label="roll [mrad]")
    place.set_ylabel("on the wheel S [mm]")
    force.set_ylabel("normal force [kN]")
    size.set_ylabel("semi-axes [mm]")
    pose.set(ylabel="pose of the wheelset", xlabel="lateral position of the wheelset [mm], positive to the left")
    title = f"{table.attrs['case']}: {table.attrs['wheelset']} under {1e-3 * table.attrs['load_n']:.4g} kN"
    place.set_title(title, loc="left")
    for axes in (place, size, pose):
        axes.legend(loc="best")
    return figure


COMPARED = {
    "centre": ("centre on the\nwheel S [mm]", 1e3),
    "width": ("width [mm]", 1e3),
    "approach": ("approach [µm]", 1e6),
    "peak_pressure": ("peak pressure\n[MPa]", 1e-6),
    "patches": ("patches", 1.0),
}


@into_axes
def comparison_figure(comparison: xr.Dataset, side: str = "left") -> Figure:
    """Normal contacts side by side over the lateral position, one wheel.

    Args:
        comparison: what `compare_contacts` returns.
        side: wheel to show.
    """
    figure, panels = new_figure(len(COMPARED), height=8.5, sharex=True)
    shown = comparison.sel(side=side)
    lateral = 1e3 * shown["lateral"]
    for axes, (name, (label, factor)) in zip(panels, COMPARED.items(), strict=True):
        for number, model in enumerate(shown["model"].to_numpy()):
            look: dict[str, Any] = {"markersize": 3, "linewidth": 1.0, "color": COLOURS[number], "label": str(model)}
            axes.plot(lateral, factor * shown[name].sel(model=model), MARKERS[number] + STYLES[number], **look)
        axes.set_ylabel(label)
        if name == "patches":
            axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    panels[-1].set_xlabel("lateral position of the wheelset [mm], positive to the left")
    load = 1e-3 * comparison.attrs["load_n"]
    what = f"{comparison.attrs['case']}: {comparison.attrs['wheelset']} under {load:.4g} kN, {side} wheel"
    panels[0].set_title(what, loc="left")
    legend_above(figure, panels[0])
    return figure


@into_axes
def creep_comparison_figure(comparison: xr.Dataset, side: str = "left") -> Figure:
    """Creep laws side by side over the lateral position, one wheel: a column per normal contact; points: exact solver.

    Args:
        comparison: what `compare_creep` returns.
        side: wheel to show.
    """
    normals = [str(name) for name in comparison["normal"].to_numpy()]
    figure, grid = new_grid(2, len(normals), 8.4, 6.2, sharex=True, sharey="row")
    lateral = 1e3 * comparison["lateral"].to_numpy()
    for column, normal in enumerate(normals):
        shown = comparison.sel(normal=normal, side=side)
        for axes, name in zip(grid[:, column], ("x", "y"), strict=True):
            for number, law in enumerate(shown["law"].to_numpy()):
                axes.plot(lateral, 100 * shown[f"force_{name}"].sel(law=law), STYLES[number % len(STYLES)],
                          color=COLOURS[number], label=str(law))  # fmt: skip
            axes.plot(lateral, 100 * shown[f"exact_{name}"], "o", color="black", ms=3.5, label="exact solver", zorder=5)
            axes.set_ylim(-115.0, 115.0)  # a law without saturation leaves the picture
        grid[0][column].set_title(f"contact.normal = {normal}")
        grid[1][column].set_xlabel("lateral position [mm], positive to the left")
    grid[0][0].set_ylabel("longitudinal force\non the wheel [% of μN]")
    grid[1][0].set_ylabel("lateral force\non the wheel [% of μN]")
    yaw = 1e3 * comparison["yaw"].to_numpy()
    turned = f"yaw {yaw[0]:g} mrad" if np.all(yaw == yaw[0]) else f"yaw {yaw.min():g} to {yaw.max():g} mrad"
    load = 1e-3 * comparison.attrs["load_n"]
    friction = f"friction {comparison.attrs['friction']:g}"
    headline(figure, f"{comparison.attrs['case']}: {load:.4g} kN, {turned}, {friction}, {side} wheel")
    legend_below(figure, grid[0][0])
    return figure


@house_style()
def characteristics_figure(shifts: Mapping[str, xr.Dataset], conicity: Mapping[str, xr.Dataset]) -> Figure:
    """Rolling radius difference, conicity, contact positions, angles and wavelength; each support in its own style.

    By label what `shift_table` and `conicity_table` return; the first is drawn full, further ones dashed over it.
    """
    first = next(iter(shifts.values()))
    rolls, yawed = first.attrs["roll"] == "free", first.attrs["yaw_rad"] != 0.0
    rows = 4 if rolls or yawed else 3
    figure, grid = new_grid(rows, 2, 8.4, 2.9 * rows)
    radii, cone, on_wheel, on_rail, angle, wave, *further = grid.flat
    roll, ahead = further.pop(0) if rolls else None, further.pop(0) if yawed else None
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
            if ahead is not None:
                ahead.plot(lateral, 1e3 * here["longitudinal"], style, color=side_colour, label=name)
        if roll is not None:
            roll.plot(lateral, 1e3 * table["roll"], style, color=colour, label=label)
        amplitude = 1e3 * conicity[label]["amplitude"]
        cone.plot(amplitude, conicity[label]["conicity"], style, color=colour, label=label)
        wave.plot(amplitude, conicity[label]["wavelength"], style, color=colour, label=label)
        if table.attrs["support"] != "track":
            cone.plot(amplitude, conicity[label]["of_rollers"], ":", color=colour, label="part of the rollers' radii")
    shift, size = "lateral shift to the left [mm]", "amplitude [mm]"
    _finish(radii, shift, "rolling radius difference [mm]", "left less right; on rollers with their own radii")
    _finish(cone, size, "equivalent conicity [-]", "EN 15302, integration of the kinematic motion")
    _finish(on_wheel, shift, "contact on the wheel S [mm]", "flange is negative")
    _finish(on_rail, shift, "contact on the rail head [mm]", "gauge side is negative")
    _finish(angle, shift, "contact angle [rad]", "positive as at the flange")
    _finish(wave, size, "wavelength [m]", "free wheelset, pure rolling")
    cone.set_ylim(bottom=min(0.0, cone.get_ylim()[0]))
    if roll is not None:
        _finish(roll, shift, "roll angle [mrad]", "both wheels touch")
    if ahead is not None:
        _finish(ahead, shift, "contact ahead of the axle [mm]", "a yawed wheelset")
    for empty in further:
        empty.remove()
    gauge, back = 1e3 * first.attrs["gauge_m"], 1e3 * first.attrs["back_to_back_m"]
    yaw = f", yaw {1e3 * first.attrs['yaw_rad']:g} mrad" if yawed else ""
    figure.suptitle(f"{first.attrs['title']}: gauge {gauge:g} mm, back-to-back {back:g} mm{yaw}", fontsize=10)
    return figure


def _finish(axes: Axes, along: str, up: str, note: str) -> None:
    axes.set(xlabel=along, ylabel=up)
    axes.set_title(note, loc="left", fontsize=8)
    axes.legend(fontsize=7.5)


COLUMNS = (
    ("force_x", "longitudinal $T_x$ / μN"),
    ("force_y", "lateral $T_y$ / μN"),
    ("spin_moment", "spin moment $M$ / μNc"),
)


@into_axes
def creep_figure(comparison: xr.Dataset) -> Figure:
    """A row per direction of creepage, a column per component; the exact theory as points, each law as a line.

    Args:
        comparison: what `compare_laws` returns; its first law is the exact theory.
    """
    names = [str(name) for name in comparison["law"].to_numpy()]
    directions = [str(name) for name in comparison["direction"].to_numpy()]
    demand = comparison["demand"].to_numpy()
    size = (7.4, 1.55 * len(directions) + 1.0)
    figure, grid = new_grid(len(directions), len(COLUMNS), *size, sharex=True, sharey="col")
    for column, (name, label) in enumerate(COLUMNS):
        grid[0][column].set_title(label, fontsize=10)
        grid[-1][column].set_xlabel("demand [-]")
        for row, direction in enumerate(directions):
            axes = grid[row][column]
            values = comparison[name].sel(direction=direction)
            error = comparison["grid_error"].sel(direction=direction).isel(component=column).to_numpy()
            for number, law in enumerate(names[1:]):
                axes.plot(demand, values.sel(law=law), STYLES[number % len(STYLES)], color=COLOURS[number % len(COLOURS)],
                          label=law)  # fmt: skip
            axes.errorbar(demand, values.sel(law=names[0]), yerr=error, fmt="o", ms=3, color="black", capsize=2,
                          lw=0.8, label="exact theory", zorder=5)  # fmt: skip
            logarithmic(axes)
            if column == 0:
                axes.set_ylabel(direction.replace(" and ", "\nand ").replace(" with ", "\nwith ")
                                .replace(" against ", "\nagainst "))  # fmt: skip
        saturated = comparison[name].sel(law=names[0]).to_numpy()  # a law without saturation leaves the picture
        low, high = min(saturated.min(), -0.1), max(saturated.max(), 0.1)
        grid[0][column].set_ylim(low - 0.25 * (high - low), high + 0.25 * (high - low))
    legend_below(figure, grid[0][0])
    ellipse = f"a/b = {comparison.attrs['a_over_b']:g}, ν = {comparison.attrs['poisson_ratio']:g}"
    headline(figure, f"Creep forces on an ellipse {ellipse}; demand 1: the linear theory asks for about μN")
    return figure


@into_axes
def profile_figure(curve: xr.Dataset) -> Figure:
    """A profile as mounted, the measured points beside the smooth curve, its slope and its curvature.

    Args:
        curve: Dataset of `rollerrig.profile`.
    """
    wheel = curve.attrs["kind"] == "wheel"
    sign = -1.0 if wheel else 1.0  # the radius of a wheel grows downward
    along = 1e3 * curve["abscissa"]
    figure, (shape, slope, curvature) = new_figure(3, height=6.6, sharex=True, height_ratios=(2.2, 1, 1))
    if curve.sizes["point"]:
        low, high = float(along.min()), float(along.max())
        near = curve.where((1e3 * curve["point_abscissa"] > low) & (1e3 * curve["point_abscissa"] < high), drop=True)
        shape.plot(1e3 * near["point_abscissa"], sign * 1e3 * near["point_height"], ".", color=GREY, markersize=3,
                   label=f"{curve.sizes['point']} measured points")  # fmt: skip
    shape.plot(along, sign * 1e3 * curve["height"], color=colour(0), label=fill(str(curve.attrs["source"]), 80))
    shape.set_title(f"{curve.attrs['name']}: left {curve.attrs['kind']} as mounted, outward to the right", loc="left")
    shape.set_ylabel("up [mm]")
    legend_above(figure, shape)
    slope.plot(along, sign * curve["slope"], color=colour(0))
    slope.set_ylabel("slope [-]")
    curvature.plot(along, curve["curvature"], color=colour(0))
    curvature.set_ylabel("curvature [1/m]\nconvex > 0")
    limit = float(abs(curve["curvature"]).quantile(0.97))
    origin = "tape circle" if wheel else "highest point"
    curvature.set(ylim=(-1.2 * limit, 1.2 * limit), xlabel=f"abscissa, outward from the {origin} [mm]")
    return figure
