"""What was measured on vehicles, beside the program; docs/measured.md.

A locomotive's adhesion: creep laws, condition `eurosprinter`, a bogie on track and rig; stopping distances with sand.

Bars: 12 of 13 means within 3 standard errors; r.m.s. of a bogie's means 0.010, a third of the scatter of single points.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rollerrig import load_case
from rollerrig.config.schema.adhesion import CONDITIONS
from validation import sanding_trial, write_measured
from validation.locomotive_adhesion import FREE, WHEEL, at, bins, bogie, coefficient, fit, rms, sets, traction, within
from validation.test_page import differences


@pytest.mark.parametrize("section", write_measured.SECTIONS, ids=lambda section: section.__name__)
def test_the_page_is_what_the_program_gives(section: Callable[[], str]) -> None:
    today = section()
    written = write_measured.section(write_measured.PAGE.read_text(encoding="utf-8"), today.splitlines()[0])
    assert differences(written, today) == []


def test_the_page_s_texts_are_those_of_its_script() -> None:
    page = write_measured.PAGE.read_text(encoding="utf-8")
    assert page.startswith(write_measured.INTRODUCTION)
    assert write_measured.ADHESION in page


@pytest.mark.parametrize("law", FREE)
def test_parameters_are_those_of_the_best_fit(law: str) -> None:
    """To three digits: the sum of squares is within 2 % of the least, and no number further off than half its error."""
    (own,) = (one for one in sets() if one.law == law and one.fitted)
    numbers, errors = fit(law)

    def squares(of: dict) -> float:
        return float(np.sum(((coefficient(law, of, bins().creepage) - bins().mean) / bins().error) ** 2))

    assert squares(dict(own.numbers)) < 1.02 * squares(numbers)
    for name, error in errors.items():
        assert own.numbers[name] == pytest.approx(numbers[name], abs=0.5 * error), name


def test_two_laws_reach_the_bar_and_three_do_not() -> None:
    """The paper's law, FASTSIM and the table soften by one constant factor: their peak comes at too little slip."""
    near = {one.law: within(one.curve(bins().creepage)) for one in sets() if one.fitted}
    assert near["polach"] == near["modified_fastsim"] == 13
    assert max(near[law] for law in ("table", "fastsim", "kalker_saturated")) == 11
    slip = np.geomspace(2e-3, 0.2, 300)
    peak = {one.law: slip[one.curve(slip).argmax()] for one in sets() if one.fitted}
    assert 0.012 < peak["table"] < 0.014
    assert 0.024 < peak["polach"] < 0.031


def test_published_parameters_are_not_fitted_here() -> None:
    published = {(one.law, one.condition): one.curve(bins().creepage) for one in sets() if not one.fitted}
    assert within(published["modified_fastsim", ""]) == 12
    assert rms(published["modified_fastsim", ""] - bins().mean) < 0.010
    measured = bins().mean
    assert np.all(published["polach", "dry"] > measured + 0.1)  # dry and wet lie on either side up to 6 %
    assert np.all(published["polach", "wet"][:10] < measured[:10] - 0.04)


@pytest.mark.parametrize("one", [one for one in sets() if one.condition], ids=lambda one: one.condition)
def test_the_condition_of_the_catalogue_has_these_numbers(one: write_measured.ParameterSet) -> None:
    condition = CONDITIONS[one.condition]
    assert {
        **{n: condition["friction"][n] for n in ("mu_0", "A", "B")},
        "k_A": condition["k_A"],
        "k_S": condition["k_S"],
    } == dict(one.numbers)


@pytest.mark.parametrize("on_rig", [False, True], ids=["track", "rig"])
def test_a_locomotive_s_bogie_pulls_as_measured(on_rig: bool) -> None:
    curve = bogie(bins().creepage, on_rig)
    assert rms(curve - bins().mean) < 0.010
    assert within(curve) >= 12
    readme = (write_measured.PAGE.parents[1] / "README.md").read_text(encoding="utf-8")
    assert f"within\n{rms(curve - bins().mean):.3f} of the load" in readme


def test_the_bogie_has_the_measured_wheel_and_its_load_counts() -> None:
    case, run = load_case("eurosprinter_traction"), traction()
    assert case.vehicle.data.wheel.radius == WHEEL.radius
    assert case.motion.speed == WHEEL.speed
    assert float(run["load"].isel(time=0).mean()) / 2 == pytest.approx(WHEEL.load, rel=2e-3)
    for axle in ("wheelset_1", "wheelset_2"):
        static = at(run, axle, bins().creepage, 2 * WHEEL.load) - bins().mean
        assert rms(static) > 0.015  # over the load at rest the bar is missed
        assert rms(at(run, axle, bins().creepage) - bins().mean) < 0.010


def test_the_ellipse_has_the_given_shape() -> None:
    a, b = WHEEL.semi_axes
    assert a / b == pytest.approx(0.5, rel=1e-9)
    assert (a, b) == pytest.approx((6.30e-3, 12.61e-3), rel=1e-3)  # test_creep_laws.py


def test_the_case_with_sand_is_calibrated_on_one_sander_of_fixed_rate() -> None:
    case, here = load_case("sanding_trial"), sanding_trial.recorded()
    assert case.sanding is not None
    assert case.sanding.flow == sanding_trial.FIXED
    assert here["one sander, fixed rate"] == pytest.approx(800.0, rel=0.01)
    for stop in sanding_trial.STOPS:
        error = here[stop.name] / stop.measured - 1
        assert error > 0 if stop.at_least else abs(error) < 0.15, stop


STOPS = [pytest.param(s, marks=pytest.mark.slow if s.sanders == 2 else pytest.mark.long) for s in sanding_trial.STOPS]


@pytest.mark.parametrize("stop", STOPS, ids=lambda stop: stop.name)
def test_recorded_stops_are_what_the_program_computes(stop: sanding_trial.Stop) -> None:
    """If not: python tests/validation/sanding_trial.py. Within 1 %: single dump cycles differ between processors."""
    assert sanding_trial.distance(stop) == pytest.approx(sanding_trial.recorded()[stop.name], rel=0.01)
