"""Critical speeds: brackets of runs, and one Dataset with a name for each definition."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from rollerrig import load_case
from rollerrig.analysis.critical_speed import HIGHEST_KMH, bracket
from rollerrig.analysis.hunting import HuntingRun, hunting_table
from rollerrig.analysis.modes import DIRECTIONS, Lineariser
from rollerrig.analysis.signals import FinalMotion
from rollerrig.simulation.starting_state import StartError
from rollerrig.study.compare import between
from rollerrig.study.critical_speeds import ended_early_sentence
from rollerrig.study.limit_cycles import critical_speed


def run(speed: float, persists: bool, status: str = "ok") -> HuntingRun:
    motion = xr.Dataset(attrs={"status": status, "status_message": f"at {speed:g} m/s: {status}"})
    final = FinalMotion(1e-3, 5.0, 0.0) if persists else FinalMotion(0.0, math.nan, math.nan)
    return HuntingRun(speed, "frame", motion, final, "persists" if persists else "decays")


def test_the_bracket_is_the_lowest_onset_whatever_the_order_of_the_runs() -> None:
    found = bracket([run(50.0, True), run(20.0, False), run(40.0, False), run(45.0, True)], 3e-3)
    assert (found.decays, found.persists) == (40.0, 45.0)


def test_further_runs_divide_the_bracket_in_thirds_until_it_is_narrow() -> None:
    found = bracket([run(40.0, False), run(46.0, True)], 3e-3)
    assert np.allclose(found.further_speeds(5.0), [42.0, 44.0])
    assert found.further_speeds(6.0) == []


@pytest.mark.parametrize("persists", [True, False])
def test_without_an_onset_in_the_range_there_is_no_critical_speed(persists: bool) -> None:
    found = bracket([run(40.0, persists), run(46.0, persists)], 3e-3)
    assert math.isnan(found.decays if persists else found.persists)
    assert found.further_speeds(0.1) == []


def test_a_run_that_did_not_come_to_its_end_neither_persists_nor_decays() -> None:
    lost = [run(speed, moving, "contact_lost") for speed in (30.0, 50.0) for moving in (True, False)]
    assert not any(one.persists or one.decays for one in lost)
    found = bracket(lost, 3e-3)
    assert math.isnan(found.persists)
    assert math.isnan(found.decays)
    assert between(found) == "not found: no run was decided"
    assert between(bracket([*lost, run(60.0, True)], 3e-3)) == (
        "at most 216.0 km/h, or not at all: runs below were not decided"
    )
    mixed = bracket([run(20.0, False), *lost, run(60.0, True)], 3e-3)
    assert between(mixed) == "72.0 … 216.0 km/h"
    assert (mixed.decays, mixed.persists) == (20.0, 60.0)
    assert len(mixed.ended_early) == 4
    assert ended_early_sentence(mixed) == (
        "4 of 6 runs, from 108 to 180 km/h, did not come to their end or to a decision and count neither as limit cycle "
        "nor as decay. The slowest ended so: at 30 m/s: contact_lost"
    )
    assert ended_early_sentence(bracket([run(20.0, False)], 3e-3)) == ""


def test_the_bracket_is_not_divided_for_ever_where_runs_end_early() -> None:
    between_them = [run(float(v), False, "derailed") for v in np.linspace(40.0, 46.0, 4)[1:-1]]
    assert bracket([run(40.0, False), run(46.0, True)], 3e-3).further_speeds(1.0) == [42.0, 44.0]
    assert bracket([run(40.0, False), run(46.0, True), *between_them], 3e-3).further_speeds(1.0) == []
    for slowest in range(60, 300, 10):  # km/h: thirds are the speeds of the first runs but for rounding
        low, *open_ones, high = (v / 3.6 for v in range(slowest, slowest + 61, 20))
        runs = [run(low, False), *(run(v, False, "not_decided") for v in open_ones), run(high, True)]
        assert bracket(runs, 3e-3).further_speeds(1.0) == []


def test_runs_that_ended_early_are_in_the_table_as_such() -> None:
    one = run(30.0, True, "contact_lost")
    one = replace(
        one, motion=one.motion.assign(lateral=(("time", "body"), np.zeros((5, 1)))).assign_coords(time=range(5))
    )
    table = hunting_table([one], 3e-3)
    assert (int(table["persists"][0]), int(table["decays"][0])) == (0, 0)
    assert math.isnan(float(table["amplitude"][0]))


def test_the_linear_critical_speed_is_looked_for_above_the_range() -> None:
    """The bogie on track begins to hunt at 263 km/h, above the speeds that are asked for here."""
    found = critical_speed("bogie_track", speeds_kmh=[220.0, 240.0])
    assert float(found["linear_critical_speed"]) == pytest.approx(266.4, abs=0.1)
    assert found.attrs["linear_searched_to_kmh"] == HIGHEST_KMH


def test_each_definition_has_its_own_name_and_unit() -> None:
    found = critical_speed("wheelset_rollers", methods=["linear", "disturbance"], speeds_kmh=[60.0, 90.0])
    assert set(found.data_vars) == {"linear_critical_speed", "critical_speed_by_disturbance"}
    assert math.isnan(found["linear_critical_speed"])  # a lone wheelset on springs does not hunt
    by = found["critical_speed_by_disturbance"]  # both ends are told, and no middle of them
    assert float(by.sel(end="decays")) == pytest.approx(90.0)
    assert math.isnan(by.sel(end="persists"))
    assert {value.attrs["units"] for value in found.data_vars.values()} == {"km/h"}


def test_without_an_equilibrium_no_run_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    torque = {"wheelset": "wheelset_1", "reacts_on": "none", "constant": 60_000.0}  # beyond friction
    case = load_case("wheelset_rollers").with_changes({"axle_torque": [torque]})
    monkeypatch.setattr("rollerrig.study.limit_cycles.disturbance_chains", lambda *_: pytest.fail("a run"))
    with pytest.raises(StartError, match="no rolling equilibrium"):
        critical_speed(case, methods=["linear", "disturbance"], speeds_kmh=[60.0, 90.0])


def test_an_unknown_definition_is_refused() -> None:
    with pytest.raises(ValueError, match="nonlinear; allowed: linear, disturbance, continuation"):
        critical_speed("wheelset_rollers", methods=["nonlinear"])


@pytest.mark.parametrize("speed_kmh", [10.0, 20.0])
def test_steady_rolling_is_found_where_a_steep_wheel_touches_far_from_its_nominal_radius(speed_kmh: float) -> None:
    """A cone of 1:5 on large rollers rolls on a radius 1 % larger: at v over the nominal one the friction would be used up."""
    case = load_case("bogie_rollers_constant").with_changes(
        {
            "vehicle.wheel.profile": {"kind": "cone", "conicity": 0.204},
            "support.roller_radius": "1.05 m",
            "vehicle.element.primary_*.x.stiffness": "60 MN/m",
        }
    )
    lineariser = Lineariser(case)
    found = lineariser.at(speed_kmh / 3.6)
    simulation = lineariser.simulation_at(speed_kmh / 3.6)
    wheelset = lineariser.model.body_index("wheelset_1")
    spin = found.equilibrium[simulation.rate_index[wheelset][DIRECTIONS.index("pitch")]]
    radius = case.vehicle.data.wheel.radius
    assert 0.985 < spin * radius / (speed_kmh / 3.6) < 0.995
