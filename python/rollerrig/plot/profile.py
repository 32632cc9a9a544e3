"""A profile: its points and the smooth curve, slope and curvature."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from rollerrig.plot.into import into_axes
from rollerrig.plot.style import GREY, colour, house_style, new_figure


@into_axes
def profile_figure(curve: xr.Dataset) -> Figure:
    """A profile as mounted, the measured points beside the smooth curve, its slope and its curvature.

    Args:
        curve: Dataset of `rollerrig.profile`.
    """
    wheel = curve.attrs["kind"] == "wheel"
    sign = -1.0 if wheel else 1.0  # the radius of a wheel grows downward
    along = 1e3 * curve["abscissa"]
    with house_style():
        figure, (shape, slope, curvature) = new_figure(
            3, height=6.6, sharex=True, gridspec_kw={"height_ratios": (2.2, 1, 1)}
        )
        if curve.sizes["point"]:
            low, high = float(along.min()), float(along.max())
            near = curve.where(
                (1e3 * curve["point_abscissa"] > low) & (1e3 * curve["point_abscissa"] < high), drop=True
            )
            shape.plot(1e3 * near["point_abscissa"], sign * 1e3 * near["point_height"], ".", color=GREY, markersize=3,
                       label=f"{curve.sizes['point']} measured points")  # fmt: skip
        shape.plot(along, sign * 1e3 * curve["height"], color=colour(0), label=str(curve.attrs["source"]))
        shape.set_title(
            f"{curve.attrs['name']}: left {curve.attrs['kind']} as mounted, outward to the right", loc="left"
        )
        shape.set_ylabel("up [mm]")
        shape.legend(loc="lower right" if wheel else "lower center")
        slope.plot(along, sign * curve["slope"], color=colour(0))
        slope.set_ylabel("slope [-]")
        curvature.plot(along, curve["curvature"], color=colour(0))
        curvature.set_ylabel("curvature [1/m]\nconvex > 0")
        limit = float(abs(curve["curvature"]).quantile(0.97))
        curvature.set_ylim(-1.2 * limit, 1.2 * limit)
        curvature.set_xlabel("abscissa, outward from the " + ("tape circle" if wheel else "highest point") + " [mm]")
        return figure
