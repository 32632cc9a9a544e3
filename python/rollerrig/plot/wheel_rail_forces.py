"""Figures of wheel-rail forces and running safety: forces, quotients against their limits, wear, accelerations.

wheel-rail forces, accelerations, axis along the run -> [plot] -> Figure
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rollerrig.analysis.wheel_rail_forces import curved, irregular
from rollerrig.plot.style import COLOURS, GREY, STYLES, calm, into_axes, legend_above, line, panels, wheel_lines

LIMIT_IN_SIGHT = 2.5
"""A limit up to this many times the largest value is drawn; a further one is only named, and the values fill the axes."""

LEAST_RANGE = {"force": 2.0, "quotient": 0.05, "wear": 1.0, "acceleration": 0.02}
"""Least range of an ordinate [kN, -, N, m/s^2]: less is not worth a closer look, and would be drawn as if it were."""


@into_axes
def wheel_forces_over_time(forces: xr.Dataset, along: xr.DataArray | None = None) -> Figure:
    """Wheel load Q and guiding force Y of every wheel.

    Args:
        forces: what `analysis.wheel_forces` or `filtered` returns.
        along: time or distance, with the attributes long_name and units; over `time`. None: time.
    """
    labels = ("wheel load Q [kN]", "guiding force Y,\noutwards [kN]")
    with _along(labels, forces, along, 5.2) as (figure, axes, along):
        for panel, name in zip(axes, ("wheel_load", "guiding_force"), strict=True):
            wheel_lines(panel, along, 1e-3 * forces[name])
            calm(panel, LEAST_RANGE["force"])
            _note(panel, _filter_of(forces[name]))
        return figure


@into_axes
def quotient(forces: xr.Dataset, along: xr.DataArray | None = None, limits: dict[str, float] | None = None) -> Figure:
    """Y/Q of every wheel against its limits.

    Args:
        forces: as in `wheel_forces_over_time`.
        along: as there.
        limits: what it is -> largest Y/Q [-]; NaN: there is none. None: Nadal's.
    """
    with _along(["Y/Q [-]"], forces, along, 3.4) as (figure, (axes,), along):
        wheel_lines(axes, along, forces["derailment_quotient"])
        chosen = {"Nadal": float(forces["nadal_limit"])} if limits is None else limits
        _limits(axes, forces["derailment_quotient"], chosen, "", both=False)
        calm(axes, LEAST_RANGE["quotient"])
        _note(axes, _filter_of(forces["derailment_quotient"]))
        return figure


@into_axes
def track_shifting(forces: xr.Dataset, along: xr.DataArray | None = None) -> Figure:
    """Sum of guiding forces of every wheelset against Prud'homme's limit; arguments as in `wheel_forces_over_time`."""
    with _along(["sum of guiding forces ΣY,\nto the left [kN]"], forces, along, 3.4) as (figure, (axes,), along):
        for number, wheelset in enumerate(_names(forces["wheelset"])):
            force = 1e-3 * forces["guiding_force_sum"].sel(wheelset=wheelset)
            line(axes, along, force, number, STYLES[number % len(STYLES)], wheelset)
        limit = float(forces["guiding_force_sum_limit"].min())
        factor = forces.attrs["prudhomme_factor"]
        name = "Prud'homme, " + (f"{factor:g} " if factor != 1.0 else "") + "(10 kN + 2 Q0/3)"
        _limits(axes, 1e-3 * forces["guiding_force_sum"], {name: 1e-3 * limit}, " kN", both=True)
        calm(axes, LEAST_RANGE["force"])
        _note(axes, _filter_of(forces["guiding_force_sum"]))
        return figure


@into_axes
def wear(forces: xr.Dataset, along: xr.DataArray | None = None) -> Figure:
    """Wear number of every wheel; arguments as in `wheel_forces_over_time`."""
    with _along(["wear number Tγ [N]"], forces, along, 3.2) as (figure, (axes,), along):
        wheel_lines(axes, along, forces["wear_number"])
        axes.set_ylim(0.0, max(axes.get_ylim()[1], LEAST_RANGE["wear"]))
        _note(axes, _filter_of(forces["wear_number"]))
        return figure


@into_axes
def accelerations_along(points: xr.Dataset, along: xr.DataArray | None = None) -> Figure:
    """Lateral and vertical acceleration at the points of one or more bodies.

    Args:
        points: what `accelerations` or `ride` returns, cut down to the points of interest.
        along: as in `wheel_forces_over_time`.
    """
    directions = ("lateral", "vertical")
    with _along([f"{direction} [m/s²]" for direction in directions], points, along, 4.8) as (figure, axes, along):
        for panel, direction in zip(axes, directions, strict=True):
            for number, point in enumerate(_names(points["point"])):
                values = points["acceleration"].sel(point=point, direction=direction)
                line(panel, along, values, number, STYLES[number % len(STYLES)], point)
            calm(panel, LEAST_RANGE["acceleration"])
        bands = sorted(set(map(str, points["filter"].to_numpy()))) if "filter" in points.coords else []
        _note(axes[0], " and ".join(bands) if bands else "unfiltered")
        return figure


@into_axes
def line_and_response(run: xr.Dataset, along: xr.DataArray | None = None) -> Figure:
    """Curvature and cant of the line, the irregularity under the foremost wheelset, and how the wheelsets follow.

    Args:
        run: results of `simulate`; what does not change along the run is left out.
        along: as in `wheel_forces_over_time`.
    """
    drawn = [draw for draw, worth in ((_layout, curved(run)), (_irregularity, irregular(run))) if worth]
    labels = [*[""] * len(drawn), "wheelsets,\nto the left [mm]"]
    with _along(labels, run, along, 1.2 + 1.7 * len(labels), legend=-1) as (figure, axes, along):
        for panel, draw in zip(axes, drawn, strict=False):
            draw(panel, run, along)
        for number, body in enumerate(_wheelsets(run)):
            line(axes[-1], along, 1e3 * run["lateral"].sel(body=body), number, STYLES[number % len(STYLES)], body)
        return figure


def _layout(axes: Axes, run: xr.Dataset, along: xr.DataArray) -> None:
    line(axes, along, 1e3 * run["curvature"])
    axes.set_ylabel("curvature,\nto the left [1/km]", color=COLOURS[0])
    other = axes.twinx()
    line(other, along, 1e3 * run["cant"], 1, "--")
    other.set_ylabel("cant,\nright rail up [mm]", color=COLOURS[1])
    other.grid(visible=False)
    other.margins(y=0.3)  # in proportion to each other, as usual, the two would lie on one line


def _irregularity(axes: Axes, run: xr.Dataset, along: xr.DataArray) -> None:
    wheels = [wheel for wheel in _names(run["wheel"]) if wheel.startswith(f"{_wheelsets(run)[0]}_")]
    for number, wheel in enumerate(wheels):
        for word, style in (("lateral", "-"), ("vertical", "--")):
            label = f"{word}, {'left' if wheel.endswith('left') else 'right'}"
            line(axes, along, 1e3 * run[f"rail_{word}"].sel(wheel=wheel), number, style, label)
    axes.set_ylabel("irregularity\nof the rails [mm]")
    _note(axes, f"under {_wheelsets(run)[0].replace('_', ' ')}")
    axes.legend(loc="upper right", ncols=4, fontsize=7)


def _wheelsets(run: xr.Dataset) -> list[str]:
    return list(dict.fromkeys(wheel.rpartition("_")[0] for wheel in _names(run["wheel"])))


def _limits(axes: Axes, values: xr.DataArray, limits: dict[str, float], unit: str, *, both: bool) -> None:
    """Lines at the limits that are in sight, on both sides of zero or above; the others are named."""
    largest = float(np.nanmax(np.abs(values.to_numpy()), initial=0.0))
    beyond = []
    for number, (name, limit) in enumerate(sorted(limits.items(), key=lambda item: item[1])):
        if not np.isfinite(limit):
            continue
        if limit > LIMIT_IN_SIGHT * largest:
            beyond.append(f"{name}: {limit:.3g}{unit}")
            continue
        for sign in (1.0, -1.0) if both else (1.0,):
            axes.axhline(sign * limit, color="black", linestyle=STYLES[1 + number % 3], linewidth=1.1)
        axes.lines[-1].set_label(f"{name}: {limit:.3g}{unit}")
    if beyond:
        text = "limits beyond these axes: " + "; ".join(beyond)
        axes.set_title(text, loc="right", fontsize=7.5, color="#444444")


def _note(axes: Axes, text: str) -> None:
    axes.set_title(text, loc="left", fontsize=7.5, color="#444444")


def _filter_of(values: xr.DataArray) -> str:
    return str(values.attrs.get("filter", "unfiltered"))


@contextmanager
def _along(
    labels: Sequence[str], results: xr.Dataset, along: xr.DataArray | None, height: float, legend: int = 0
) -> Iterator[tuple[Figure, list[Axes], xr.DataArray]]:
    """Panels along the run, by default over time, with a line at zero, and the legend of one of them above all."""
    chosen = results["time"].assign_attrs(long_name="time", units="s") if along is None else along
    xlabel = f"{chosen.attrs['long_name']} [{chosen.attrs['units']}]"
    with panels(labels, xlabel, height, legend=False) as (figure, axes):
        yield figure, axes, chosen
        for panel in axes:
            low, high = panel.get_ylim()
            if low < 0.0 < high:
                panel.axhline(0.0, color=GREY, linewidth=0.5, zorder=0.5)
            panel.margins(x=0.01)
        legend_above(figure, axes[legend])


def _names(coordinate: xr.DataArray) -> list[str]:
    return [str(name) for name in coordinate.to_numpy()]
