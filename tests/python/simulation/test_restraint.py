"""A vehicle on rollers that nothing holds along the track: refused by name, and named where it has rolled off."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from called import called
from rollerrig import _core
from rollerrig.analysis.hunting import HuntingSettings, hunting_run
from rollerrig.analysis.limit_cycle_runs import LimitCycleSettings
from rollerrig.assembly.model import assemble
from rollerrig.cases import on_track
from rollerrig.catalog import catalog_names
from rollerrig.common.linear_algebra import eigenvalues
from rollerrig.config import Case, ConfigError, load_case
from rollerrig.simulation.run import simulate
from rollerrig.simulation.starting_state import drift, equilibrium
from rollerrig.study.limit_cycles import limit_cycles

WAGON = Path(__file__).parents[1] / "two_axle_wagon.toml"
CROWN = 0.725 + 0.46
"""Radii of roller and wheel together [m]."""


@pytest.fixture(scope="module")
def wagon() -> Case:
    return load_case(WAGON)


def held(case: Case, stiffness: float) -> Case:
    """The wagon with a car body that stands still above it, and one spring between the two along the track [N/m]."""
    anchor = {"name": "anchor", "mass": 1000.0, "inertia": [1e3, 1e3, 1e3], "position": [0.0, 0.0, 1.6]}
    spring = {
        "name": "coupler",
        "between": ["anchor", "car_body"],
        "point": [0.0, 0.0, 1.6],
        "x": {"stiffness": stiffness},
    }
    vehicle = case.vehicle.data
    raw = vehicle.model_dump(exclude_unset=True)
    return case.with_changes(
        {
            "vehicle.data.body": [*raw["body"], anchor],
            "vehicle.data.element": [*raw["element"], spring],
            "vehicle.data.cut": {"vehicle": {**raw["cut"]["vehicle"], "fixed": ["anchor"]}},
        }
    )


def found(case: Case):
    model = assemble(case)
    simulation = _core.Simulation(model.core)
    return drift(simulation, model, equilibrium(simulation, model))


@pytest.mark.slow
@pytest.mark.parametrize("command", ["check", "run", "stability"])
def test_commands_refuse_it_by_name(command: str, tmp_path) -> None:
    options = {
        "check": [],
        "run": ["--out", str(tmp_path)],
        "stability": ["--speeds-kmh", "80:80:1", "--out", str(tmp_path)],
    }
    result = called(command, WAGON, *options[command])
    assert result.exit_code == 2, result.output
    line = " ".join(result.output.split())
    assert "nothing holds the vehicle 'two_axle_wagon' along the track" in line
    assert "locked = ['x'] for car_body" in line


@pytest.mark.slow
def test_no_critical_speed_is_made_of_runs_that_roll_off(wagon) -> None:
    with pytest.raises(ConfigError, match="nothing holds the vehicle"):
        hunting_run((wagon, 80.0 / 3.6, HuntingSettings(duration=1.0)))
    for processes in (1, 2):  # also on its way back from another process
        with pytest.raises(ConfigError, match="nothing holds the vehicle") as error:
            limit_cycles(wagon, [80.0], np.nan, LimitCycleSettings(longest=1.6), processes=processes)
        assert len(error.value.problems) == 1


@pytest.mark.slow
def test_a_run_that_rolled_off_says_where_and_when(wagon) -> None:
    run = simulate(wagon, allow_unrestrained=True)
    # Far down the roller the contact has no answer at some steps, and which come first hangs on the last digit of the start.
    assert run.attrs["status"] in ("contact_lost", "not_finite")
    message = run.attrs["status_message"]
    assert f"t = {run.attrs['stopped_at_s']:.4g} s" in message
    assert "rolled off its rollers" in message
    assert "m behind their axis" in message or "m ahead of their axis" in message
    assert "reduce the speed" not in message


def test_the_drift_is_that_of_a_body_on_top_of_a_cylinder(wagon) -> None:
    """m x'' (1 + Θ / (m r²)) = m g x / (R + r): weight pushes it off, wheelsets turn as they roll."""
    one = found(wagon)
    assert one is not None
    assert one.body == "car_body"
    assert one.whole
    mass, turning = 20_000.0 + 2 * 1300.0, 2 * 100.0 / 0.46**2
    # a wheel that rolls along the track on a driven roller turns by dx (R + r) / (R r) less dx / R: by dx / r
    expected = np.sqrt(9.81 / CROWN * mass / (mass + turning))
    assert one.rate == pytest.approx(expected, rel=0.02)  # springs let the wheelsets lean a little


def test_only_a_restraint_stiffer_than_the_push_holds_it(wagon) -> None:
    """The push of the crowns is W / (R + r) per metre: 187 kN/m. A softer spring holds no better than none."""
    push = 22_600.0 * 9.81 / CROWN
    assert found(held(wagon, 1.1 * push)) is None
    assert found(held(wagon, 0.9 * push)) is not None


@pytest.mark.parametrize("height", [0.0, 1.05])
def test_a_coupler_rod_holds_what_its_stiffness_can(wagon, height: float) -> None:
    """An element of the rig; the springs between car body and wheelsets add 2 % to what it must bear."""
    push = 22_600.0 * 9.81 / CROWN

    def rod(stiffness: float) -> Case:
        return wagon.with_changes({"support.restraint": {"height": height, "stiffness": stiffness}})

    assert found(rod(1.15 * push)) is None
    assert found(rod(0.9 * push)) is not None


def test_the_rod_acts_at_its_height_with_stiffness_and_damping(wagon) -> None:
    """Car body moved by x and turned by theta at height h: F = -k (x + theta (h - z)) - c of its rate."""
    restraint = {"height": 1.05, "stiffness": 2e6, "damping": 3e4}
    case = wagon.with_changes(
        {"support.restraint": restraint, "disturbance": [{"body": "car_body", "longitudinal": "1 mm"}]}
    )
    run = simulate(case.with_changes({"time.duration": "0.2 s", "time.output_step": "1 ms"}))
    z = case.vehicle.data.body_named("car_body").position[2]
    body = run.sel(body="car_body")
    deflection = (body["longitudinal"] + (1.05 - z) * body["pitch"]).to_numpy()
    speed = np.gradient(deflection, 1e-3)
    force = run["element_force_x"].sel(element="restraint")
    assert float(np.abs(force).max()) > 500.0
    inside = slice(1, -1)  # of differences over 2 ms
    np.testing.assert_allclose(force[inside], (-2e6 * deflection - 3e4 * speed)[inside], atol=10.0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"support.restraint.body": "wheelset_1"}, "support.restraint.body: 'wheelset_1'"),
        ({"support.restraint.body": "car_bodi"}, "did you mean 'car_body'"),
        ({"vehicle.body.car_body.locked": ["x"]}, "nothing of this vehicle that it could hold is free in x"),
        ({"support.restraint.stiffness": 0.0}, "restraint.stiffness"),
    ],
)
def test_a_rod_that_can_hold_nothing_is_refused(wagon, changes: dict[str, object], message: str) -> None:
    held_by_rod = wagon.with_changes({"support.restraint": {"height": 1.0, "stiffness": 1e7}})
    with pytest.raises(ConfigError, match=message):
        held_by_rod.with_changes(changes)


@pytest.mark.slow
def test_a_coach_that_rolls_off_is_not_blamed_for_sliding() -> None:
    """The wheels of a braked coach that nothing holds roll along their rollers: r w - R W is not their sliding."""
    coach = load_case("adhesion_brake").with_changes({"vehicle.cut": "vehicle", "time.duration": "5 s"})
    with pytest.raises(ConfigError, match="nothing holds the vehicle"):
        simulate(coach)
    run = simulate(coach, allow_unrestrained=True)
    assert run.attrs["status"] in ("contact_lost", "rollers_protected")
    assert "rolled off its rollers" in run.attrs["status_message"]
    early = run.sel(time=2.0, method="nearest")  # 0.4 m off the crowns
    apparent = 0.46 * early["axle_speed"] - 0.725 * early["roller_speed"]
    assert float(abs(apparent).min()) > 1.0  # what the protection took for sliding
    assert float(abs(early["real_sliding"]).max()) < 0.15
    assert run.attrs["stopped_at_s"] > 2.2
    held_by_rod = coach.with_changes({"support.restraint": {"height": 1.05, "stiffness": 1e7, "damping": 1e5}})
    assert simulate(held_by_rod).attrs["status"] == "ok"


def test_a_wheelset_without_longitudinal_suspension_is_named_alone(wagon) -> None:
    springs = [e.name for e in wagon.vehicle.data.element if "wheelset_2" in e.between]
    changes: dict[str, object] = {f"vehicle.element.{name}.x": None for name in springs}
    one = found(wagon.with_changes({**changes, "vehicle.body.car_body.locked": ["x"]}))
    assert one is not None
    assert one.body == "wheelset_2"
    assert not one.whole


def test_on_track_nothing_needs_to_hold_it(wagon) -> None:
    assert found(on_track(wagon)) is None


@pytest.mark.parametrize("name", catalog_names("case"))
def test_every_case_of_the_catalogue_is_held(name: str) -> None:
    assert found(load_case(name)) is None


def test_eigenvalues_kept_are_those_of_the_matrix() -> None:
    matrix = np.array([[0.0, 1.0], [-4.0, -0.2]])
    first = eigenvalues(matrix)
    matrix[1, 0] = -9.0
    assert eigenvalues(matrix) is not first
    assert np.sort(np.abs(eigenvalues(matrix))) == pytest.approx([3.0, 3.0])
    assert eigenvalues(matrix) is eigenvalues(matrix.copy())
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 0.0
