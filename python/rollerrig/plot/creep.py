"""Creep laws over the size of the creepage: forces and spin moment beside the exact theory."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.into import into_axes
from rollerrig.plot.log_axis import logarithmic
from rollerrig.plot.style import COLOURS, STYLES, headline, house_style, legend_below, new_grid

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
    with house_style():
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
        _frame_columns(grid, comparison, names[0])
        legend_below(figure, grid[0][0])
        attributes = comparison.attrs
        headline(
            figure,
            f"Creep forces on an ellipse a/b = {attributes['a_over_b']:g}, ν = {attributes['poisson_ratio']:g}; "
            "demand 1: the linear theory asks for about μN",
        )
    return figure


def _frame_columns(grid: np.ndarray, comparison: xr.Dataset, exact: str) -> None:
    """Columns are as high as what saturates: a law without saturation leaves the picture."""
    for column, (name, _) in enumerate(COLUMNS):
        values = comparison[name].sel(law=exact).to_numpy()
        low, high = min(values.min(), -0.1), max(values.max(), 0.1)
        margin = 0.25 * (high - low)
        grid[0][column].set_ylim(low - margin, high + margin)
