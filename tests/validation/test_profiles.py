"""S1002 and UIC60 against the same profiles written a second time (independent_model), and against files of their points."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from catalogued import profile_table
from rollerrig.profiles import gauge_point, profile_from_spec
from rollerrig.profiles.analytic import SEGMENTS
from validation.independent_model.conicity import rail_position
from validation.independent_model.parameters import EN_60E1, UIC60_BENCHMARK, s1002, uic60
from validation.reference import mm

HEADS = {
    "uic60_benchmark_1_40": (1 / 40, UIC60_BENCHMARK),
    "uic60_benchmark_1_20": (1 / 20, UIC60_BENCHMARK),
    "en_60e1_1_40": (1 / 40, EN_60E1),
    "en_60e1_1_20": (1 / 20, EN_60E1),
}


def test_s1002_is_its_polynomials_and_arcs() -> None:
    s = np.linspace(-60, 60, 24001)
    error = profile_table("s1002", "wheel").evaluate(s * mm) / mm - s1002(s)
    # The printed polynomial between -35 and -26 mm leaves gaps of 1.2e-4 mm, which the table closes.
    assert np.max(np.abs(error)) < 1.3e-4
    elsewhere = (s < -39.5) | (s > -25.9)
    assert np.median(np.abs(error[elsewhere])) < 1e-7


@pytest.mark.parametrize("name", HEADS)
def test_a_rail_head_is_its_three_arcs(name: str) -> None:
    y = np.linspace(-42, 24, 24001)
    exact = uic60(y, *HEADS[name])
    inside = exact > -8.0  # steeper below, where a table of 0.1 mm follows an arc of 13 mm less closely
    error = profile_table(name, "rail").evaluate(y * mm) / mm - exact
    assert np.max(np.abs(error[inside])) < 5e-5
    assert np.median(np.abs(error[inside])) < 1e-7


@pytest.mark.parametrize("name", HEADS)
@pytest.mark.parametrize("depth", [4.0, 10.0])
def test_the_gauge_point_lies_where_the_arcs_have_its_depth(name: str, depth: float) -> None:
    position = rail_position(lambda u: uic60(u, *HEADS[name]), depth)
    found = gauge_point(profile_table(name, "rail"), depth * mm) / mm
    assert 1435 / 2 - found == pytest.approx(position, abs=1e-4)


def even_points(profile: Callable[[np.ndarray], np.ndarray], start: float, end: float) -> np.ndarray:
    """Points every 0.3 mm along the curve."""
    y = np.linspace(start, end, 40001)
    z = profile(y)
    length = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(y), np.diff(z)))))
    y = np.interp(np.arange(0.0, length[-1], 0.3), length, y)
    return np.column_stack([y, profile(y)])


def simpack(path: Path, points: np.ndarray, kind: int) -> None:
    """A .prw or .prr file: mm, eight decimals, the points mirrored and in the order of falling abscissae."""
    rows = "\n".join(f"  {y:+.8f} {z:+.8f}" for y, z in points * [-1.0, 1.0])
    path.write_text(
        f"header.begin\n version = 1\n type = {kind}\nheader.end\nspline.begin\n mirror.y = 1\n inversion = 1\n"
        f" units.len.f = +1.0e+03\n point.begin\n{rows}\n point.end\nspline.end\n"
    )


@pytest.mark.parametrize(
    ("name", "kind", "junctions"),
    [
        ("s1002", "wheel", [start for start, _ in SEGMENTS]),
        ("uic60_benchmark_1_40", "rail", [-33.421, -17.990, 3.004, 18.539]),
    ],
)
def test_points_read_as_measured_become_the_profile_of_the_definition(
    name: str, kind: str, junctions: list[float], tmp_path: Path
) -> None:
    path = tmp_path / ("wheel.prw" if kind == "wheel" else "rail.prr")
    if kind == "wheel":
        simpack(path, even_points(s1002, -69.9, 60.0), 1)
    else:
        simpack(path, even_points(uic60, -43.1, 28.8) * [1.0, -1.0], 0)
    measured = profile_from_spec({"kind": "file", "path": str(path)}, kind)
    exact = profile_table(name, kind)
    low, high = np.maximum(measured.domain[0], exact.domain[0]), np.minimum(measured.domain[1], exact.domain[1])
    assert high - low > 60 * mm
    y = np.linspace(low + mm, high - mm, 6001)
    y = y[np.abs(exact.evaluate(y, 1)) < 3]
    # Points every 0.3 mm: the smoothing rounds curvature jumps of 50 to 77 1/m off over about that length.
    assert np.max(np.abs(measured.evaluate(y) - exact.evaluate(y))) < 1e-3 * mm
    calm = np.min(np.abs(np.subtract.outer(y / mm, junctions)), axis=1) > 1.5
    angle = np.arctan(measured.evaluate(y, 1)) - np.arctan(exact.evaluate(y, 1))
    assert np.max(np.abs(angle[calm])) < 3e-5
    assert np.max(np.abs(measured.curvature(y) - exact.curvature(y))[calm]) < 0.5
