"""A profile as the contact search sees it: the smooth curve, its slope and curvature, beside the points it came from.

name or file -> [profile] -> Dataset -> picture, CSV, Simpack file
"""

from pathlib import Path
from typing import Literal

import numpy as np
import xarray as xr

from rollerrig.config import load_profile
from rollerrig.profiles import SHAPES, ProfileKind, ProfileTable, profile_from_spec
from rollerrig.results import variable

COLUMNS = "abscissa_mm,height_mm,slope,curvature_per_m"
"""First line of the table."""

_FILE_SPACING = 0.2e-3
"""Spacing of the points of a Simpack file, along the profile [m]."""

_MOST_ROWS = 4000


def profile(
    source: str | Path, kind: Literal["wheel", "rail"] | None = None, smoothing: float | Literal["auto"] | None = None
) -> xr.Dataset:
    """The smooth curve of a profile with slope and curvature, and the measured points beside it.

    Args:
        source: name in the catalogue, TOML file, or file of points.
        kind: what it is for; None: by the ending of its name (.prw, .prr), else what it can be used for.
        smoothing: another cut-off wavelength of measured points [m], or "auto"; None: that of the file.

    Returns:
        Over `abscissa` [m]: `height` [m], `slope`, `curvature` [1/m]; over `point`: `point_abscissa`, `point_height` [m]. The
        abscissa grows outward; the height of a wheel is an increase of its radius, downward.

    Raises:
        ConfigError: there is no such profile, or it cannot be used so.
        ProfileError: likewise.

    Example:
        >>> float(profile("cone_1_20")["slope"].mean().round(6))
        -0.05
    """
    spec = load_profile(source)
    arguments = spec.arguments()
    by_name: dict[str, ProfileKind] = {".prw": "wheel", ".prr": "rail"}
    chosen = kind or by_name.get(Path(source).suffix.lower()) or SHAPES[str(arguments["kind"])][1][0]
    if smoothing is not None and arguments["kind"] == "file":
        arguments["smoothing"] = smoothing
    table = profile_from_spec(arguments, chosen)
    low, high = table.domain
    abscissa = np.linspace(low, high, min(_MOST_ROWS, int((high - low) / table.step) + 1))
    height = "increase of the radius" if chosen == "wheel" else "height, 0 at the top"
    bend = "curvature, positive where it is convex towards the other profile"
    variables = {
        "height": variable("abscissa", table.evaluate(abscissa), "m", height),
        "slope": variable("abscissa", table.evaluate(abscissa, 1), "1", "slope of the height"),
        "curvature": variable("abscissa", table.curvature(abscissa), "1/m", bend),
        "point_abscissa": variable("point", table.measured[:, 0], "m", "abscissa of a measured point"),
        "point_height": variable("point", table.measured[:, 1], "m", "height of a measured point"),
    }
    return xr.Dataset(
        variables,
        {"abscissa": variable("abscissa", abscissa, "m", "abscissa, outward")},
        {
            "name": spec.name or table.name,
            "kind": chosen,
            "source": table.source,
            "outline": _file_points(table).tolist(),
        },
    )


def _file_points(table: ProfileTable) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Points at one spacing along the whole shape, steep flanks included [m]."""
    outline = table.outline
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(outline, axis=0).T))])
    places = np.linspace(0.0, along[-1], max(2, int(along[-1] / _FILE_SPACING)))
    return np.column_stack([np.interp(places, along, outline[:, 0]), np.interp(places, along, outline[:, 1])])


def profile_csv(curve: xr.Dataset) -> str:
    """The curve as a table: abscissa and height [mm], slope, curvature [1/m]."""
    columns = (1e3 * curve["abscissa"], 1e3 * curve["height"], curve["slope"], curve["curvature"])
    rows = zip(*(column.to_numpy() for column in columns), strict=True)
    return "\n".join([COLUMNS, *(f"{y:.6f},{z:.6f},{slope:.6g},{bend:.6g}" for y, z, slope, bend in rows)]) + "\n"


FIRST_LINE = "header.begin ! written by rollerrig"
"""First line of a Simpack file."""


def simpack_text(curve: xr.Dataset) -> str:
    """The profile as Simpack's .prw or .prr text, in millimetres: abscissa outward, ordinate downward."""
    down = 1.0 if curve.attrs["kind"] == "wheel" else -1.0
    points = 1e3 * np.array(curve.attrs["outline"]) * [1.0, down]
    kind = 1 if curve.attrs["kind"] == "wheel" else 0
    header = [FIRST_LINE, "version = 1", f"type = {kind}", "header.end", "spline.begin", "approx.smooth = 0",
              f"comment = '{curve.attrs['name']}'", "units.len.f = 1000", "units.ang.f = 1", "point.begin"]  # fmt: skip
    rows = [f"{y:.6f} {z:.6f}" for y, z in points + 0.0]
    return "\n".join([*header, *rows, "point.end", "spline.end"]) + "\n"
