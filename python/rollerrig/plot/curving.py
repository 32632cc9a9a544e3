"""Steady curving over the radius of the curve, a line per cant deficiency."""

from __future__ import annotations

from collections.abc import Mapping

import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.into import into_axes
from rollerrig.plot.style import GREY, MARKERS, headline, house_style, legend_below, look, new_grid

PANELS = {
    "guiding_force": ("guiding force Y [kN]", 1e-3),
    "wheel_load": ("wheel load Q [kN]", 1e-3),
    "derailment_quotient": ("Y/Q [-]", 1.0),
    "guiding_force_sum": ("sum of guiding forces |ΣY| [kN]", 1e-3),
    "wear_number": ("wear number Tγ [N]", 1.0),
    "angle_of_attack": ("angle of attack [mrad]", 1e3),
}
"""Variable -> label and factor of its panel."""


@into_axes
def curving_over_radius(results: xr.Dataset, limits: Mapping[str, float] | None = None) -> Figure:
    """A panel per quantity of `rollerrig.curving`: its largest magnitude of all wheels or wheelsets; limits by variable."""
    with house_style():
        figure, grid = new_grid(3, 2, 7.2, 7.6, sharex=True)
        for axes, (name, (label, factor)) in zip(grid.ravel(), PANELS.items(), strict=True):
            values = factor * abs(results[name]).max(results[name].dims[2:])
            for number, deficiency in enumerate(results["cant_deficiency"].to_numpy()):
                line = values.sel(cant_deficiency=deficiency)
                axes.plot(results["radius"], line, marker=MARKERS[number % len(MARKERS)], markersize=3.0,
                          label=f"{1e3 * deficiency:g} mm", **look(number))  # fmt: skip
            if limits and name in limits:
                axes.axhline(factor * limits[name], color=GREY, linestyle=(0, (4, 2)), linewidth=1.0)
            axes.set_ylabel(label)
        for axes in grid[-1]:
            axes.set_xlabel("radius of the curve [m]")
        legend_below(figure, grid[0][0])
        headline(figure, f"{results.attrs['title']}, by cant deficiency; cant {1e3 * results.attrs['cant_m']:g} mm")
    return figure
