"""Figures of what engineers read off a run: wheel forces, quotients against their limits, wear, accelerations.

readings, accelerations, axis along the run -> [plot] -> Figure
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rollerrig.plot.style import COLOURS, GREY, STYLES, calm, house_style, legend_above, new_figure, wheel_lines

LIMIT_IN_SIGHT = 2.5
"""A limit up to this many times the largest value is drawn; a further one is only named, and the values fill the axes."""


def wheel_forces(read: xr.Dataset, along: xr.DataArray | None = None) -> Figure:
    """Wheel load Q and guiding force Y of every wheel.

    Args:
        read: what `wheel_forces` or `filtered` of the analysis returns.
        along: time or distance, with the attributes long_name and units; over `time`. None: time.
    """
    along = _over_time(read) if along is None else along
    with house_style():
        figure, (load, guiding) = new_figure(2, height=5.2, sharex=True)
        wheel_lines(load, along, 1e-3 * read["wheel_load"])
        wheel_lines(guiding, along, 1e-3 * read["guiding_force"])
        calm(load, 1e-1)
        calm(guiding, 1e-1)
        load.set_ylabel("wheel load Q [kN]")
        guiding.set_ylabel("guiding force Y,\noutwards [kN]")
        _say(load, _filter_of(read["wheel_load"]))
        return _finished(figure, along, load, guiding)


def quotient(read: xr.Dataset, along: xr.DataArray | None = None, limits: dict[str, float] | None = None) -> Figure:
    """Y/Q of every wheel against its limits.

    Args:
        read: as in `wheel_forces`.
        along: as there.
        limits: what it is -> largest Y/Q [-]; NaN: there is none. None: Nadal's.
    """
    along = _over_time(read) if along is None else along
    with house_style():
        figure, (axes,) = new_figure(1, height=3.4)
        wheel_lines(axes, along, read["derailment_quotient"])
        axes.set_ylabel("Y/Q [-]")
        chosen = {"Nadal": float(read["nadal_limit"])} if limits is None else limits
        _limits(axes, read["derailment_quotient"], chosen, "", both=False)
        _say(axes, _filter_of(read["derailment_quotient"]))
        return _finished(figure, along, axes)


def track_shifting(read: xr.Dataset, along: xr.DataArray | None = None) -> Figure:
    """Sum of guiding forces of every wheelset against Prud'homme's limit; arguments as in `wheel_forces`."""
    along = _over_time(read) if along is None else along
    with house_style():
        figure, (axes,) = new_figure(1, height=3.4)
        for number, wheelset in enumerate(_names(read["wheelset"])):
            force = 1e-3 * read["guiding_force_sum"].sel(wheelset=wheelset)
            style = STYLES[number % len(STYLES)]
            axes.plot(_values(along), _values(force), style, color=COLOURS[number % len(COLOURS)], **_LOOK)
            axes.lines[-1].set_label(_spoken(wheelset))
        axes.set_ylabel("sum of guiding forces ΣY,\nto the left [kN]")
        calm(axes, 1e-1)
        limit = float(read["guiding_force_sum_limit"].min())
        factor = read.attrs["prudhomme_factor"]
        name = "Prud'homme, " + (f"{factor:g} " if factor != 1.0 else "") + "(10 kN + 2 Q0/3)"
        _limits(axes, 1e-3 * read["guiding_force_sum"], {name: 1e-3 * limit}, " kN", both=True)
        _say(axes, _filter_of(read["guiding_force_sum"]))
        return _finished(figure, along, axes)


def wear(read: xr.Dataset, along: xr.DataArray | None = None) -> Figure:
    """Wear number of every wheel; arguments as in `wheel_forces`."""
    along = _over_time(read) if along is None else along
    with house_style():
        figure, (axes,) = new_figure(1, height=3.2)
        wheel_lines(axes, along, read["wear_number"])
        axes.set_ylabel("wear number Tγ [N]")
        axes.set_ylim(bottom=0.0)
        _say(axes, _filter_of(read["wear_number"]))
        return _finished(figure, along, axes)


def accelerations_along(points: xr.Dataset, along: xr.DataArray | None = None) -> Figure:
    """Lateral and vertical acceleration at the points of one or more bodies.

    Args:
        points: what `accelerations` or `ride` returns, cut down to the points of interest.
        along: as in `wheel_forces`.
    """
    along = _over_time(points) if along is None else along
    with house_style():
        figure, panels = new_figure(2, height=4.8, sharex=True)
        for axes, direction in zip(panels, ("lateral", "vertical"), strict=True):
            for number, point in enumerate(_names(points["point"])):
                values = points["acceleration"].sel(point=point, direction=direction)
                colour, style = COLOURS[number % len(COLOURS)], STYLES[number % len(STYLES)]
                axes.plot(_values(along), _values(values), style, color=colour, label=_spoken(point), **_LOOK)
            axes.set_ylabel(f"{direction} [m/s²]")
            calm(axes, 1e-3)
        bands = sorted(set(map(str, points["filter"].to_numpy()))) if "filter" in points.coords else []
        _say(panels[0], " and ".join(bands) if bands else "unfiltered")
        return _finished(figure, along, *panels)


def line_and_response(run: xr.Dataset, along: xr.DataArray | None = None) -> Figure:
    """Curvature and cant of the line, the irregularity under the foremost wheelset, and how the wheelsets follow.

    Args:
        run: results of `simulate`; what does not change along the run is left out.
        along: as in `wheel_forces`.
    """
    drawn = [draw for draw, worth in ((_layout, curved(run)), (_irregularity, irregular(run))) if worth]
    along = _over_time(run) if along is None else along
    with house_style():
        figure, panels = new_figure(len(drawn) + 1, height=1.2 + 1.7 * (len(drawn) + 1), sharex=True)
        for axes, draw in zip(panels, drawn, strict=False):
            draw(axes, run, along)
        for number, body in enumerate(_wheelsets(run)):
            style, colour = STYLES[number % len(STYLES)], COLOURS[number % len(COLOURS)]
            lateral = 1e3 * run["lateral"].sel(body=body)
            panels[-1].plot(_values(along), _values(lateral), style, color=colour, label=_spoken(body), **_LOOK)
        panels[-1].set_ylabel("wheelsets,\nto the left [mm]")
        return _finished(figure, along, panels[-1], above=panels[:-1])


def _over_time(results: xr.Dataset) -> xr.DataArray:
    return results["time"].assign_attrs(long_name="time", units="s")


def curved(run: xr.Dataset) -> bool:
    """Whether the run met a curve or cant."""
    return "curvature" in run and bool((run["curvature"] != 0.0).any() or (run["cant"] != 0.0).any())


def irregular(run: xr.Dataset) -> bool:
    """Whether rails or rollers were irregular."""
    return "rail_lateral" in run and bool((run["rail_lateral"] != 0.0).any() or (run["rail_vertical"] != 0.0).any())


def _layout(axes: Axes, run: xr.Dataset, along: xr.DataArray) -> None:
    axes.plot(_values(along), 1e3 * _values(run["curvature"]), color=COLOURS[0], **_LOOK)
    axes.set_ylabel("curvature,\nto the left [1/km]", color=COLOURS[0])
    other = axes.twinx()
    other.plot(_values(along), 1e3 * _values(run["cant"]), "--", color=COLOURS[1], **_LOOK)
    other.set_ylabel("cant,\nright rail up [mm]", color=COLOURS[1])
    other.grid(visible=False)
    other.margins(y=0.3)  # in proportion to each other, as usual, the two would lie on one line


def _irregularity(axes: Axes, run: xr.Dataset, along: xr.DataArray) -> None:
    wheels = [wheel for wheel in _names(run["wheel"]) if wheel.startswith(f"{_wheelsets(run)[0]}_")]
    looks = {"rail_lateral": ("lateral", "-"), "rail_vertical": ("vertical", "--")}
    for number, wheel in enumerate(wheels):
        for name, (word, style) in looks.items():
            label = f"{word}, {'left' if wheel.endswith('left') else 'right'}"
            values = 1e3 * _values(run[name].sel(wheel=wheel))
            axes.plot(_values(along), values, style, color=COLOURS[number], label=label, **_LOOK)
    axes.set_ylabel("irregularity\nof the rails [mm]")
    _say(axes, f"under {_spoken(_wheelsets(run)[0])}")
    axes.legend(loc="upper right", ncols=4, fontsize=7)


def _wheelsets(run: xr.Dataset) -> list[str]:
    return list(dict.fromkeys(wheel.rpartition("_")[0] for wheel in _names(run["wheel"])))


_LOOK: dict[str, Any] = {"linewidth": 0.9, "rasterized": True}


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


def _say(axes: Axes, text: str) -> None:
    axes.set_title(text, loc="left", fontsize=7.5, color="#444444")


def _filter_of(values: xr.DataArray) -> str:
    return str(values.attrs.get("filter", "unfiltered"))


def _finished(figure: Figure, along: xr.DataArray, *panels: Axes, above: Sequence[Axes] = ()) -> Figure:
    """Axis along the run below, one legend for all panels above."""
    panels[-1].set_xlabel(f"{along.attrs['long_name']} [{along.attrs['units']}]")
    for axes in (*above, *panels):
        low, high = axes.get_ylim()
        if low < 0.0 < high:
            axes.axhline(0.0, color=GREY, linewidth=0.5, zorder=0.5)
        axes.margins(x=0.01)
    legend_above(figure, panels[0])
    return figure


def _names(coordinate: xr.DataArray) -> list[str]:
    return [str(name) for name in coordinate.to_numpy()]


def _spoken(name: str) -> str:
    return name.replace("_", " ")


def _values(values: xr.DataArray) -> np.ndarray:
    return np.asarray(values.to_numpy())
