"""Creep laws on the patches of a pressed wheelset: against closed forms, symmetry and the exact solver."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from rollerrig import load_case
from rollerrig.contact_analysis.comparison import (
    _FIELDS,
    EXACT_EVERY,
    LEAST_SOLUTIONS,
    _Rolling,
    compare_contacts,
    comparison_rows,
    comparison_text,
)
from rollerrig.contact_analysis.static_contact import contact
from rollerrig.plot.contact import creep_comparison_figure

PLACES = [*((1e-3 * y, 2e-3) for y in (-4.0, -2.0, 0.5, 2.0, 4.0)), (3e-3, 2e-3), (-3e-3, -2e-3)]


@pytest.fixture(scope="module")
def comparison() -> xr.Dataset:
    return compare_contacts(load_case("contact_benchmark_track"), PLACES, timed=False)


@pytest.mark.parametrize("name", ["contact_benchmark_track", "contact_benchmark_rollers"])
def test_creepages_are_those_of_one_body_that_rolls(name: str) -> None:
    case = load_case(name).with_changes({"contact.normal": "hertz"})  # a point of contact, for the closed forms
    pressed = contact(case, [(3e-3, 2e-3)])
    wheels = _Rolling(case).patches(3e-3, 2e-3, float(pressed["roll"][0]), float(pressed["height"][0]))
    patch = [dict(zip(_FIELDS, wheel[0], strict=True)) for wheel in wheels]
    assert [len(wheel) for wheel in wheels] == [1, 1]
    assert [p["normal"] for p in patch] == pytest.approx(pressed["normal"].to_numpy(), rel=1e-9)
    assert patch[0]["creepage_x"] == pytest.approx(-patch[1]["creepage_x"], rel=1e-6)
    left, right = pressed["rolling_radius"].to_numpy()
    angle = patch[0]["contact_angle"]
    if name.endswith(
        "track"
    ):  # over a rail, in closed form; 2 %: yaw times slope, and speed is a mean of both surfaces
        assert patch[0]["creepage_x"] == pytest.approx((right - left) / (left + right), rel=0.02)
        assert patch[0]["creepage_spin"] == pytest.approx(-np.sin(angle) / left, rel=0.02)
    assert patch[0]["creepage_y"] == pytest.approx(-2e-3, rel=0.02)


def test_laws_against_the_exact_solver(comparison: xr.Dataset) -> None:
    errors = comparison["error"]
    solved = errors.sel(law="table").notnull().any(["model", "side"]).to_numpy()
    assert list(np.flatnonzero(solved)) == list(range(0, len(PLACES), EXACT_EVERY))
    assert float(errors.sel(law="table").max()) < 0.02  # the table law's own bound
    assert float(errors.sel(law="fastsim").max()) < 0.10
    assert float(errors.sel(law="kalker_linear").max()) > 0.5  # it does not saturate
    size = np.hypot(comparison["force_x"], comparison["force_y"]).drop_sel(law="kalker_linear")
    assert float(size.max()) < 1.0 + 1e-6


def test_the_mirror_image_has_mirrored_forces(comparison: xr.Dataset) -> None:
    one, other = (comparison.drop_sel(law="exact").isel(position=at) for at in (-2, -1))
    for name, sign in (("force_x", 1.0), ("force_y", -1.0)):
        left, right = one[name].sel(side="left"), other[name].sel(side="right")
        np.testing.assert_allclose(left, sign * right, atol=1e-5)  # of the press, in mu N


def test_a_row_for_every_force_that_is_known(comparison: xr.Dataset) -> None:
    _, rows = comparison_rows(comparison)
    table = {(model, law, y, side): values for model, law, y, _, side, *values in rows[1:]}
    assert len(table) == len(rows) - 1 == 2 * (13 * len(PLACES) + 2 * 2)  # the exact solver at two positions
    for (model, law, y, side), found in table.items():
        at = {
            "model": model,
            "side": side,
            "position": [y for y, _ in PLACES].index(pytest.approx(1e-3 * y)),
            "law": law,
        }
        expected = [100 * float(comparison[name].sel(at)) for name in ("force_x", "force_y", "error")]
        assert found == pytest.approx(expected, nan_ok=True)
        assert law != "exact" or found[2] == 0.0
    told = {line.split()[0] for line in comparison_text(comparison).splitlines() if line}
    assert set(comparison["law"].to_numpy()) - {"exact"} <= told


def test_a_statistic_says_what_it_rests_on_and_is_not_given_from_too_few(comparison: xr.Dataset) -> None:
    text = comparison_text(comparison)
    assert f"exact solutions: hertz 4, strips 4; '-': fewer than {LEAST_SOLUTIONS}" in text  # two positions, two wheels
    assert all(line.split()[1:5] == ["-"] * 4 for line in text.splitlines() if line.startswith(("table", "fastsim")))
    more = comparison_text(comparison.isel(position=[0, 4, 0, 4]))
    assert "hertz 8, strips 8" in more
    assert "fewer" not in more
    assert all("-" not in line.split()[1:5] for line in more.splitlines() if line.startswith("table"))


def test_the_picture_shows_the_forces(comparison: xr.Dataset) -> None:
    axes = creep_comparison_figure(comparison, side="right").axes
    assert len(axes) == 4
    for (name, model), panel in zip(
        [(n, c) for n in ("force_x", "force_y") for c in ("hertz", "strips")], axes, strict=True
    ):
        shown = comparison.sel(model=model, side="right")
        lines = {line.get_label(): line for line in panel.get_lines()}
        lines["exact"] = lines.pop("exact solver")
        assert lines.keys() == {*comparison["law"].to_numpy()}
        for law in comparison["law"].to_numpy():
            np.testing.assert_array_equal(lines[law].get_ydata(), 100 * shown[name].sel(law=law))
        np.testing.assert_allclose(lines["exact"].get_xdata(), [1e3 * y for y, _ in PLACES])


def test_a_case_that_stands_still_is_refused() -> None:
    with pytest.raises(ValueError, match=r"motion\.speed"):
        compare_contacts(load_case("contact_benchmark_track").with_changes({"motion.speed": 0.0}), PLACES)
