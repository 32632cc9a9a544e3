"""Contact characteristics against EN 15302's reference profiles, other conicities, and the equations of motion.

Reference: en15302/, rail A with the wheels A, B, H, I: rolling radius difference over lateral shift and equivalent conicity
over amplitude with tolerance bands, roll neglected. rigid_equivalent_conicity.csv: an independent calculation, with roll.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from rollerrig import _core
from rollerrig.assembly import assemble
from rollerrig.characteristics import conicity_table, equivalent_conicity, pair_case, shift_table
from rollerrig.config import load_case
from validation.reference import FOLDER, equilibrium, mm, needs_reference, rows

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
def comparison(request: pytest.FixtureRequest) -> Comparison:
    folder = FOLDER / "en15302"
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


@needs_reference
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


@needs_reference
def test_equivalent_conicity_of_the_standard(comparison: Comparison) -> None:
    amplitude, nominal, high, low, widest, lowest = comparison.bands.T
    ours = equivalent_conicity(comparison.lateral, comparison.difference, mm * amplitude)
    assert np.all((ours <= widest) & (ours >= lowest))
    # The narrow band holds but for one amplitude next to a jump of the contact, B at 3.0 and H at 2.6 mm.
    inside = (ours <= high) & (ours >= low)
    assert np.count_nonzero(~inside) <= 1
    assert np.max(np.abs(ours - nominal)) < 0.05


@needs_reference
def test_the_integration_alone_on_the_published_difference(comparison: Comparison) -> None:
    # Both are rounded to 1e-3; the listed curve has its jumps 0.1 mm wide.
    reachable = mm * comparison.bands[:, 0] <= comparison.listed_lateral[-1]
    amplitude, nominal = comparison.bands[reachable, 0], comparison.bands[reachable, 1]
    ours = equivalent_conicity(comparison.listed_lateral, comparison.listed_difference, mm * amplitude)
    assert ours == pytest.approx(nominal, abs=1e-3)


@needs_reference
@pytest.mark.parametrize(
    ("listed", "rail"),
    [
        ("MBench_UIC60_v3(1:40)", "uic60_benchmark_1_40"),
        ("EN60E1_1:40", "en_60e1_1_40"),
        ("EN60E1_1:20", "en_60e1_1_20"),
    ],
)
def test_conicity_of_s1002_with_roll(listed: str, rail: str) -> None:
    found = [row for row in rows("rigid_equivalent_conicity.csv") if row["rail_variant"] == listed]
    amplitude = np.array([row["amplitude_mm"] for row in found], dtype=float) * mm
    reference = np.array([row["tan_gamma_e"] for row in found], dtype=float)
    table = shift_table(pair_case("s1002", rail), 6.2 * mm, 0.2 * mm, free_to_roll=True)
    y, difference = table["lateral"].to_numpy(), table["effective_difference"].to_numpy()
    around = np.array(
        [equivalent_conicity(y, difference, amplitude + way) for way in np.linspace(-0.05, 0.05, 21) * mm]
    )
    # Everywhere, with the jumps near 0.2 and 5 mm anywhere within a step of the reference's own table.
    assert np.all(reference > around.min(axis=0) - 5e-4)
    assert np.all(reference < around.max(axis=0) + 5e-4)
    # Between the jumps directly; the worst is 2.4e-3 of it at 1.5 mm, next to the first of them.
    smooth = (amplitude > 1.2 * mm) & (amplitude < 4.8 * mm)
    assert around[10][smooth] == pytest.approx(reference[smooth], rel=4e-3, abs=1e-4)


def arcs(radius: float) -> dict[str, object]:
    return {"kind": "arc", "radius": radius, "half_width": 20 * mm}


@pytest.mark.parametrize("roller_radius", [2.0, 0.725, 0.5])
def test_rollers_change_the_wavelength_as_the_equations_of_motion_say(roller_radius: float) -> None:
    """The effective difference counts the rollers' radii; the eigenvalue of a slow wheelset knows nothing of it.

    Crowned wheels on crowned heads, whose conicity is positive because the heads stand 7 mm further out.
    """
    speed = 2.0

    def wavelengths(radius: float | None) -> tuple[float, float]:
        case = load_case("contact_benchmark_track" if radius is None else "contact_benchmark_rollers")
        depth = 0.2 * mm
        changes = {
            "vehicle.wheel.profile": arcs(2.0),
            "support.profile": arcs(0.3),
            "support.gauge_depth": depth,
            "support.gauge": 2 * (0.757 - np.sqrt(0.3**2 - (0.3 - depth) ** 2)),
            "motion.speed": speed,
        }
        case = case.with_changes(changes | ({"support.roller_radius": radius} if radius else {}))
        kinematic = float(conicity_table(shift_table(case, 1 * mm), [0.5 * mm])["wavelength"][0])
        simulation = _core.Simulation(assemble(case).core)
        values = np.linalg.eigvals(simulation.jacobian(0.0, equilibrium(simulation, speed))[0])
        slowest = min(values[values.imag > 1e-3], key=abs)
        return kinematic, 2 * np.pi * speed / abs(slowest)

    rail, rollers = wavelengths(None), wavelengths(roller_radius)
    assert rail[0] == pytest.approx(rail[1], rel=0.01)  # e is nominal, spin creepage and gravity act
    # The ratio is free of most of that: 7.7 % at 0.5 m, met to 2e-4.
    assert rollers[0] / rail[0] == pytest.approx(rollers[1] / rail[1], rel=1e-3)
    assert rollers[0] > 1.01 * rail[0]
