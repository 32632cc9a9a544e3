"""How far the strips are from exact theory over all poses of the references, as shares of the poses: against CONTACT's tables
(108 poses; cells of 0.2 mm) and against an exact half-space on a grid fine enough for each patch (256 poses: CONTACT's, yaw up to
50 mrad, rollers of 500 and 1000 mm with a longitudinal offset, wheel loads of 50 and 100 kN)."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from validation import poses
from validation.comparison import FILES, Comparison, comparisons
from validation.half_space import Surfaces
from validation.reference import rows
from validation.write_half_space_poses import exact

Array = NDArray[np.float64]

#: What is asked for: largest error of 95 % of the poses; no pose may be beyond twice that.
TARGET = {"approach": 0.03, "pressure": 0.08, "centre": 0.15, "length": 1.0, "width": 1.0}
LENGTH_RATIO, LENGTH_MM = 0.08, 0.3  # one or the other


def of_length(ours: float, theirs: float) -> float:
    """Error of a length in units of what is asked for."""
    return min(abs(ours / theirs - 1) / LENGTH_RATIO, abs(ours - theirs) / LENGTH_MM)


def against_contact(c: Comparison) -> list[float]:
    row = c.reference
    ahead = 1e3 * sum(p.point[0] * p.normal for p in c.patches) / c.normal
    return [
        abs(c.approach / row["approach"] - 1),
        abs(c.pressure / row["pmax"] - 1),
        float(np.hypot(c.centre - c.pressure_centre, ahead - row["xpn_tr"])),
        of_length(c.length, row["patch_len_x"]),
        of_length(c.width, row["patch_len_s"]),
    ]


def against_half_space(exact: poses.ExactPose) -> list[float]:
    wheel, solution = poses.pressed(exact.pose), exact.solution
    return [
        abs(wheel.approach / solution.approach - 1),
        abs(wheel.pressure / solution.pressure - 1),
        float(np.linalg.norm(wheel.point - solution.centre)),
        of_length(wheel.length, solution.length),
        of_length(wheel.width, solution.width),
    ]


def contact_errors() -> Array:
    return np.array([against_contact(c) for file in FILES for c in comparisons(file, "strips")])


def half_space_errors() -> Array:
    return np.array([against_half_space(exact) for exact in poses.read()])


@pytest.fixture(scope="module")
def errors() -> dict[str, Array]:
    return {"CONTACT": contact_errors(), "half-space": half_space_errors()}


@pytest.mark.parametrize("reference", ["CONTACT", "half-space"])
@pytest.mark.parametrize("quantity", TARGET)
def test_strips_over_all_poses(errors: dict[str, Array], reference: str, quantity: str) -> None:
    error = errors[reference][:, list(TARGET).index(quantity)]
    assert np.mean(error <= TARGET[quantity]) >= 0.95, np.sort(error)[-12:]
    assert error.max() <= 2 * TARGET[quantity]


def test_the_half_space_repeats_contact_in_all_its_poses() -> None:
    """Medians of 0.05 to 0.1 % in approach; the largest differences are where two patches 13 mm apart lie at 7 and 18 degrees
    (5 mm) and each program has its own common plane for them. CONTACT's pressures on the roller scatter by 12 % from shift to
    shift; its grid rounds lengths to cells."""
    table = poses.read()
    for file in FILES:
        pairs = list(zip(rows(file), [one for one in table if f"{one.pose.group}.csv" == file], strict=True))
        approach = np.array([one.solution.approach / row["approach"] - 1 for row, one in pairs])
        pressure = np.array([one.solution.pressure / row["pmax"] - 1 for row, one in pairs])
        one_plane = np.array([row["y_ws"] != 5.0 for row, _ in pairs])
        assert np.median(np.abs(approach)) < 0.0015
        assert np.abs(approach[one_plane]).max() < 0.013
        assert np.abs(approach).max() < 0.035
        assert np.median(np.abs(pressure)) < (0.04 if "roller" in file else 0.001)
        assert np.abs(pressure).max() < (0.12 if "roller" in file else 0.03)
        for row, one in pairs:
            assert one.solution.length == pytest.approx(row["patch_len_x"], abs=0.4)
            assert one.solution.width == pytest.approx(row["patch_len_s"], abs=0.3)


@pytest.mark.parametrize("pose", [one for one in poses.read() if one.pose.group == "yawed"][17::40])
def test_the_table_is_what_the_half_space_says(pose: poses.ExactPose) -> None:
    """The strips say where its grid lies, and a cell is a hundredth of the patch."""
    height, solution = exact(Surfaces(), pose.pose)
    assert height == pytest.approx(pose.height, abs=5e-5)
    assert solution.pressure == pytest.approx(pose.solution.pressure, rel=5e-3)
    assert solution.approach == pytest.approx(pose.solution.approach, rel=2e-3)
    assert solution.centre == pytest.approx(pose.solution.centre, abs=5e-3)
