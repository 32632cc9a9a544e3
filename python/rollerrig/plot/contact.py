"""Figures of the contact alone: where wheels touch and how hard, characteristics of a pair, creep laws, a profile."""

from collections.abc import Mapping
from textwrap import fill

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rollerrig.plot.style import (
    COLOURS,
    GREY,
    MARKERS,
    colour,
    headline,
    house_style,
    into_axes,
    legend_above,
    legend_below,
    logarithmic,
    look,
    new_figure,
    new_grid,
)


@into_axes
def contact_figure(table: xr.Dataset) -> Figure:
    """Position on the wheel, normal force, size of the patches and pose of the wheelset.

    Args:
        table: what `contact` returns; one entry per patch along `row`.
    """
    figure, (place, force, size, pose) = new_figure(4, height=9.0, sharex=True)
    lateral = 1e3 * table["lateral"]
    for number, side in enumerate(("left", "right")):
        here = (table["side"] == side).to_numpy()
        for axes, factor, name, marker, label in (
            (place, 1e3, "wheel_abscissa", MARKERS[number], side),
            (force, 1e-3, "normal", MARKERS[number], side),
            (size, 1e3, "a", MARKERS[number], f"{side}, a along the rolling direction"),
            (size, 1e3, "b", "x+"[number], f"{side}, b across it"),
        ):
            values = factor * table[name][here]
            axes.plot(lateral[here], values, marker, markersize=4, color=COLOURS[number], label=label)
    pose.plot(lateral, 1e3 * table["height"], ".", color="black", label="height [mm]")
    pose.plot(lateral, 1e3 * table["roll"], "x", markersize=4, color=COLOURS[2], label="roll [mrad]")
    place.set_ylabel("on the wheel S [mm]")
    force.set_ylabel("normal force [kN]")
    size.set_ylabel("semi-axes [mm]")
    pose.set(ylabel="pose of the wheelset", xlabel="lateral position of the wheelset [mm], positive to the left")
    place.set_title(_pressed(table), loc="left")
    for axes in (place, size, pose):
        axes.legend(loc="best")
    return figure


COMPARED = {
    "centre": (1e3, "centre on the\nwheel S [mm]"),
    "width": (1e3, "width [mm]"),
    "approach": (1e6, "approach [µm]"),
    "peak_pressure": (1e-6, "peak pressure\n[MPa]"),
    "patches": (1.0, "patches"),
}
"""Variable -> factor from SI, ordinate."""


@into_axes
def comparison_figure(comparison: xr.Dataset, side: str = "left") -> Figure:
    """Normal contacts side by side over the lateral position, one wheel.

    Args:
        comparison: what `compare_contacts` returns.
        side: wheel to show.
    """
    figure, panels = new_figure(len(COMPARED), height=8.5, sharex=True)
    shown = comparison.sel(side=side)
    for axes, (name, (factor, label)) in zip(panels, COMPARED.items(), strict=True):
        for number, model in enumerate(shown["model"].to_numpy()):
            axes.plot(1e3 * shown["lateral"], factor * shown[name].sel(model=model), marker=MARKERS[number],
                      markersize=3, linewidth=1.0, label=str(model), **look(number))  # fmt: skip
        axes.set_ylabel(label)
    panels[-1].yaxis.set_major_locator(MaxNLocator(integer=True))
    panels[-1].set_xlabel("lateral position of the wheelset [mm], positive to the left")
    panels[0].set_title(f"{_pressed(comparison)}, {side} wheel", loc="left")
    legend_above(figure, panels[0])
    return figure


def _pressed(table: xr.Dataset) -> str:
    return f"{table.attrs['case']}: {table.attrs['wheelset']} under {1e-3 * table.attrs['load_n']:.4g} kN"


@into_axes
def creep_comparison_figure(comparison: xr.Dataset, side: str = "left") -> Figure:
    """Creep laws side by side over the lateral position, one wheel: a column per normal contact; points: exact solver.

    Args:
        comparison: what `compare_contacts` returns.
        side: wheel to show.
    """
    models = [str(name) for name in comparison["model"].to_numpy()]
    figure, grid = new_grid(2, len(models), 8.4, 6.2, sharex=True, sharey="row")
    lateral = 1e3 * comparison["lateral"].to_numpy()
    for column, model in enumerate(models):
        shown = 100 * comparison.sel(model=model, side=side)
        for axes, name in zip(grid[:, column], ("force_x", "force_y"), strict=True):
            exact, *laws = shown[name].transpose("law", ...)
            for number, force in enumerate(laws):
                axes.plot(lateral, force, label=str(force["law"].item()), **look(number))
            axes.plot(lateral, exact, "o", color="black", ms=3.5, label="exact solver", zorder=5)
            axes.set_ylim(-115.0, 115.0)  # a law without saturation leaves the picture
        grid[0][column].set_title(f"contact.normal = {model}")
        grid[1][column].set_xlabel("lateral position [mm], positive to the left")
    grid[0][0].set_ylabel("longitudinal force\non the wheel [% of μN]")
    grid[1][0].set_ylabel("lateral force\non the wheel [% of μN]")
    yaw = " to ".join(dict.fromkeys(f"{end:g}" for end in (1e3 * comparison["yaw"].quantile([0.0, 1.0])).to_numpy()))
    headline(figure, f"{_pressed(comparison)}, yaw {yaw} mrad, friction {comparison.attrs['friction']:g}, {side} wheel")
    legend_below(figure, grid[0][0])
    return figure


CHARACTERISTICS = {
    "effective_difference": (1e3, "rolling radius difference [mm]", "left less right; on rollers with their own radii"),
    "conicity": (1.0, "equivalent conicity [-]", "EN 15302, integration of the kinematic motion"),
    "wheel_abscissa": (1e3, "contact on the wheel S [mm]", "flange is negative"),
    "rail_abscissa": (1e3, "contact on the rail head [mm]", "gauge side is negative"),
    "contact_angle": (1.0, "contact angle [rad]", "positive as at the flange"),
    "wavelength": (1.0, "wavelength [m]", "free wheelset, pure rolling"),
    "roll": (1e3, "roll angle [mrad]", "both wheels touch"),
}
"""Variable -> factor from SI, ordinate, note."""


@house_style()
def characteristics_figure(shifts: Mapping[str, xr.Dataset], conicity: Mapping[str, xr.Dataset]) -> Figure:
    """Rolling radius difference, conicity, contact positions, angles and wavelength; each support in its own style.

    By label what `shift_table` and `conicity_table` return; the first is drawn full, further ones dashed over it.
    """
    first = next(iter(shifts.values()))
    drawn = [name for name in CHARACTERISTICS if name != "roll" or first.attrs["roll"] == "free"]
    rows = (len(drawn) + 1) // 2
    figure, grid = new_grid(rows, 2, 8.4, 2.9 * rows)
    for axes, name in zip(grid.flat, drawn, strict=False):
        factor, ordinate, note = CHARACTERISTICS[name]
        for number, label in enumerate(shifts):
            of_shift = name in shifts[label]
            values = factor * (shifts if of_shift else conicity)[label][name]
            along = 1e3 * values["lateral" if of_shift else "amplitude"]
            if "side" in values.dims:
                for side_colour, side in enumerate(("left", "right")):
                    own = {"color": colour(side_colour), "label": None if number else side}
                    axes.plot(along, values.sel(side=side), **{**look(number), **own})
            else:
                axes.plot(along, values, label=label, **look(number))
        axes.set(xlabel="lateral shift to the left [mm]" if of_shift else "amplitude [mm]", ylabel=ordinate)
        axes.set_title(note, loc="left", fontsize=8)
        axes.legend(fontsize=7.5)
        if name == "conicity":
            axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    for empty in grid.flat[len(drawn) :]:
        empty.remove()
    gauge, back = 1e3 * first.attrs["gauge_m"], 1e3 * first.attrs["back_to_back_m"]
    figure.suptitle(f"{first.attrs['title']}: gauge {gauge:g} mm, back-to-back {back:g} mm", fontsize=10)
    return figure


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
                axes.plot(demand, values.sel(law=law), label=law, **look(number))
            axes.errorbar(demand, values.sel(law=names[0]), yerr=error, fmt="o", ms=3, color="black", capsize=2,
                          lw=0.8, label="exact theory", zorder=5)  # fmt: skip
            logarithmic(axes)
            if column == 0:
                axes.set_ylabel(fill(direction, 14))
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
