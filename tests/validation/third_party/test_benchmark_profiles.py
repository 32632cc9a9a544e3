"""The point files of the Manchester contact benchmark against the same profiles from their definitions.

    pytest tests/validation/third_party --shared FOLDER      FOLDER/data/profiles: the files of the benchmark
"""

from pathlib import Path

import numpy as np
import pytest

from catalogued import profile_table
from rollerrig.profiles import gauge_point, profile_from_spec
from rollerrig.profiles.point_file import read_point_file
from rollerrig.profiles.analytic import SEGMENTS

mm = 1e-3
WHEEL, RAIL = "MBench_S1002_v3.prw", "MBench_UIC60_v3.prr"
#: The origin of the rail file lies this far on the gauge side of its highest point: so say the centres of circles
#: fitted to its arcs (residual below 1e-6 mm), which otherwise agree with the drawing.
RAIL_ORIGIN = 0.005957


@pytest.fixture(scope="module")
def folder(shared: Path) -> Path:
    return shared / "data" / "profiles"


def test_the_points_of_the_wheel_lie_on_s1002(folder):
    s, increase = read_point_file(folder / WHEEL).points.T
    inside = (s >= -60 * mm) & (s <= 60 * mm)
    error = increase[inside] - profile_table("s1002", "wheel").evaluate(s[inside])
    # The file keeps the gaps of the printed polynomial between -35 and -26 mm, 1.2e-4 mm, which ours closes.
    assert np.max(np.abs(error)) < 1.3e-4 * mm
    elsewhere = (s[inside] < -39.5 * mm) | (s[inside] > -25.9 * mm)
    assert np.median(np.abs(error[elsewhere])) < 1e-7 * mm  # eight digits of the file


def test_the_points_of_the_rail_lie_on_the_benchmark_variant(folder):
    y, down = read_point_file(folder / RAIL).points.T
    table = profile_table("uic60_benchmark_1_40", "rail")
    y = y - RAIL_ORIGIN * mm
    inside = (y > -42 * mm) & (y < 28 * mm) & (down < 20 * mm)
    error = -down[inside] - table.evaluate(y[inside])
    # Circles fitted to the file have the R13 corners 4.4e-5 mm lower than tangent arcs put them.
    assert np.max(np.abs(error)) < 7e-5 * mm


@pytest.mark.parametrize(
    ("file", "name", "kind", "junctions"),
    [
        (WHEEL, "s1002", "wheel", [start for start, _ in SEGMENTS]),
        (RAIL, "uic60_benchmark_1_40", "rail", [-33.421, -17.990, 3.004, 18.539]),
    ],
)
def test_a_file_read_as_measured_becomes_the_profile_of_the_definition(folder, file, name, kind, junctions):
    measured = profile_from_spec({"kind": "file", "path": str(folder / file)}, kind)
    exact = profile_table(name, kind)
    low, high = np.maximum(measured.domain[0], exact.domain[0]), np.minimum(measured.domain[1], exact.domain[1])
    y = np.linspace(low + mm, high - mm, 6001)
    y = y[np.abs(exact.evaluate(y, 1)) < 3]
    # Points every 0.3 to 0.4 mm: the smoothing rounds curvature jumps of 50 to 77 1/m off over about that length.
    assert np.max(np.abs(measured.evaluate(y) - exact.evaluate(y))) < 1e-3 * mm
    calm = np.min(np.abs(np.subtract.outer(y / mm, junctions)), axis=1) > 1.5
    angle = np.arctan(measured.evaluate(y, 1)) - np.arctan(exact.evaluate(y, 1))
    assert np.max(np.abs(angle[calm])) < 3e-5
    assert np.max(np.abs(measured.curvature(y) - exact.curvature(y))[calm]) < 0.5


def test_the_gauge_of_the_rail_file_is_that_of_the_definition(folder):
    measured = profile_from_spec({"kind": "file", "path": str(folder / RAIL)}, "rail")
    exact = profile_table("uic60_benchmark_1_40", "rail")
    # On the flank the file has points every millimetre, and the top of an R300 arc is known to 0.1 um / 300 um.
    assert gauge_point(measured) == pytest.approx(gauge_point(exact), abs=1e-3 * mm)
