"""Contact characteristics against EN 15302's reference profiles: rail A with the wheels A, B, H, I.

    pytest tests/validation/third_party --shared FOLDER      FOLDER/reference/en15302: the files of the standard

Rolling radius difference over lateral shift and equivalent conicity over amplitude with tolerance bands, roll neglected.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from rollerrig.contact_analysis import equivalent_conicity, pair_case, shift_table
from validation.reference import mm

#: The file's point (0, 0), 0.4918 mm below the highest point of rail A, belongs at 750 mm: the gauge point lies 14 mm below it.
GAUGE_DEPTH_A = 14.4918 * mm

#: By so much may a reference curve be displaced: it is listed every 0.1 mm, its jumps lie somewhere between.
DISPLACED = 0.1 * mm


@dataclass(frozen=True)
class Comparison:
    """A wheel of the standard on rail A: our table, and the published curves [m, -]."""

    lateral: np.ndarray
    difference: np.ndarray
    listed_lateral: np.ndarray
    listed_difference: np.ndarray
    bands: np.ndarray


@pytest.fixture(scope="module", params=["A", "B", "H", "I"])
def comparison(request: pytest.FixtureRequest, shared: Path) -> Comparison:
    folder = shared / "reference" / "en15302"
    number = "ABHI".index(request.param) + 1
    case = pair_case(
        str(folder / f"RUIC519{request.param}.dat"), str(folder / "SUIC519A.dat"), gauge_depth=GAUGE_DEPTH_A
    )
    listed = np.loadtxt(folder / f"dr_ce_E{number}.dat") * mm
    table = shift_table(case, 7.6 * mm)
    return Comparison(
        table["lateral"].to_numpy(),
        table["rolling_radius_difference"].to_numpy(),
        (np.arange(len(listed)) - len(listed) // 2) * 0.1 * mm,
        listed,
        np.loadtxt(folder / f"ben_E{number}.dat"),
    )


def test_rolling_radius_difference_of_the_standard(comparison: Comparison) -> None:
    inside = np.abs(comparison.listed_lateral) < 7.4 * mm
    y, listed = comparison.listed_lateral[inside], comparison.listed_difference[inside]
    ours = np.array(
        [
            np.interp(y + way, comparison.lateral, comparison.difference)
            for way in np.linspace(-DISPLACED, DISPLACED, 201)
        ]
    )
    beyond = np.maximum(ours.min(axis=0) - listed, listed - ours.max(axis=0))
    # The points of wheels A and I are printed to 1e-5 mm; on conformal stretches our contact walks from bump to bump.
    assert beyond.max() < 0.05 * mm
    assert np.median(np.abs(np.interp(y, comparison.lateral, comparison.difference) - listed)) < 0.03 * mm


def test_equivalent_conicity_of_the_standard(comparison: Comparison) -> None:
    amplitude, nominal, high, low, widest, lowest = comparison.bands.T
    ours = equivalent_conicity(comparison.lateral, comparison.difference, mm * amplitude)
    assert np.all((ours <= widest) & (ours >= lowest))
    # The narrow band holds but for one amplitude next to a jump of the contact, B at 3.0 and H at 2.6 mm.
    inside = (ours <= high) & (ours >= low)
    assert np.count_nonzero(~inside) <= 1
    assert np.max(np.abs(ours - nominal)) < 0.05


def test_the_integration_alone_on_the_published_difference(comparison: Comparison) -> None:
    # Both are rounded to 1e-3; the listed curve has its jumps 0.1 mm wide.
    reachable = mm * comparison.bands[:, 0] <= comparison.listed_lateral[-1]
    amplitude, nominal = comparison.bands[reachable, 0], comparison.bands[reachable, 1]
    ours = equivalent_conicity(comparison.listed_lateral, comparison.listed_difference, mm * amplitude)
    assert ours == pytest.approx(nominal, abs=1e-3)
