"""The train that the rig reproduces against the same train on track."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from rollerrig import load_case, simulate
from rollerrig.assembly.model import assemble
from rollerrig.simulation.virtual_train import load_transfer, rail_patch
from rollerrig.study.runs.adhesion import track_case

RADIUS, SPIN_INERTIA, GRAVITY = 0.46, 112.0, 9.81  # vehicle 1
NO_BRAKE = {"brake.demand": [[0.0, 0.0], [1.0, 0.0]]}


def coasting(**train: float) -> tuple[xr.Dataset, xr.Dataset]:
    """A train that rolls on by itself, on the rig and on track."""
    changes = {f"train.{key}": value for key, value in train.items()}
    case = load_case("adhesion_brake").with_changes(
        {**NO_BRAKE, "motion.speed": "60 km/h", "time.duration": "5 s", **changes}
    )
    return simulate(case), simulate(track_case(case))


DAVIS = {"resistance_constant": 800.0, "resistance_linear": 30.0, "resistance_quadratic": 4.0}


@pytest.mark.parametrize("train", [{"gradient": 0.02}, {"gradient": -0.01, "mass": 40e3}, DAVIS])
def test_a_coasting_train_obeys_its_resistance_and_gradient(train: dict[str, float]) -> None:
    """(M + n J/r^2) v' = -A - B v - C v^2 - M g i, on the rig's virtual train and on track."""
    a, b, c = (train.get(key, 0.0) for key in DAVIS)

    def push(mass: float, v: float) -> float:
        return -a - b * v - c * v * v - mass * GRAVITY * train.get("gradient", 0.0)

    rig, track = coasting(**train)
    mass = train.get("mass", float(track["vertical_force"].isel(time=0).sum()) / GRAVITY)
    inertia = mass + 2 * SPIN_INERTIA / RADIUS**2
    speed, step = [60 / 3.6], 1e-3
    for _ in range(round(float(track["time"][-1]) / step)):
        middle = speed[-1] + 0.5 * step * push(mass, speed[-1]) / inertia
        speed.append(speed[-1] + step * push(mass, middle) / inertia)
    gained = speed[-1] - speed[0]
    assert abs(gained) > 0.3
    # The contacts have a rolling resistance of their own, of creep between the patches of a wheel: 7 N on track, 23 N on
    # rollers, where the estimator takes it for a brake torque. Without the wheelsets' inertia gained would be 5 % more.
    own = 30.0 * float(track["time"][-1]) / inertia
    for run in (rig, track):
        assert float(run["train_speed"][-1]) - speed[0] == pytest.approx(gained, abs=own)


def test_load_transfer_is_that_of_a_braking_train() -> None:
    """Against the loads of a 3-D run on track with constant brake torque, well below sliding."""
    case = load_case("adhesion_brake").with_changes(
        {"brake.demand": [[0.0, 0.0], [0.1, 0.0], [0.2, 1e5]], "adhesion.rail": "dry", "time.duration": "6 s"}
    )
    change = np.array(load_transfer(assemble(case)))
    run = simulate(track_case(case)).sel(time=slice(4.0, 6.0))
    loads = run["vertical_force"].to_numpy().reshape(-1, 2, 2).sum(axis=2)
    slope = (loads - loads.mean(axis=1, keepdims=True)).mean(axis=0) / float(run["train_acceleration"].mean())
    assert float(run["train_acceleration"].mean()) < -0.2
    assert change[0] < -4000.0  # the leading axle gains load while the train slows down
    assert change == pytest.approx(slope, rel=0.01)  # the train does not slow down quite steadily


def test_load_transfer_of_a_whole_vehicle_adds_up() -> None:
    """Loads only move; and the moment of the vehicle's inertia about the rails is what they balance."""
    case = load_case("adhesion_brake").with_changes({"vehicle.cut": "vehicle"})
    model = assemble(case)
    change = np.array(load_transfer(model))
    assert abs(change.sum()) < 1.0
    vehicle = model.case.vehicle.data
    moment = sum(model.masses[name] * vehicle.body_named(name).position[2] for name in model.lateral_bodies)
    moment += 4 * SPIN_INERTIA / RADIUS
    rods = 2 * (5e6 + 2 * 160e3)  # rods and secondary springs let the car body stay behind, and its weight with it
    moment += model.masses["car_body"] ** 2 * GRAVITY / rods
    places = np.array([model.positions[name][0] for name in model.wheelsets])
    # So do the frames on the primary springs, and pitching does the rest: 0.4 %.
    assert float(-(change * places).sum()) == pytest.approx(moment, rel=6e-3)


def test_load_transfer_by_hand_and_not_at_all() -> None:
    def of(chosen: object) -> list[float]:
        case = load_case("adhesion_brake").with_changes({"rig_control.load_transfer": chosen})
        return load_transfer(assemble(case))

    assert of("none") == [0.0, 0.0]
    assert of([-5000.0, "5 t"]) == [-5000.0, 5000.0]


def test_the_leading_axle_cleans_by_half_of_what_it_spends() -> None:
    """W = P / (2 v b), b the width of all patches: of the contact on track, of the virtual one on the rig."""
    case = load_case("adhesion_recovery").with_changes({"time.duration": "6 s"})
    width = rail_patch(assemble(case)).width
    rig, track = (simulate(c).sel(time=slice(4.5, 6.0)) for c in (case, track_case(case)))
    spent = 0.5 * track["creep_power"].sel(wheel="wheelset_1_left") / (track["train_speed"] * width)
    first = {"axle": "wheelset_1"}
    assert float(track["dissipated_energy_density"].sel(first).mean()) == pytest.approx(
        float(spent.mean()), rel=0.05
    )  # widths vary
    slip = RADIUS * rig["virtual_speed"].sel(first) - rig["train_speed"]
    spent = 0.25 * abs(rig["virtual_force"].sel(first) * slip) / (rig["train_speed"] * width)
    assert float(rig["dissipated_energy_density"].sel(first).mean()) == pytest.approx(float(spent.mean()), rel=0.01)
    assert float(spent.mean()) > 1e4  # it does slide
    # What it leaves, twice of that, is there for the axle behind.
    assert float(track["dissipated_energy_density"].sel(axle="wheelset_2").min()) > 1.5 * float(
        track["dissipated_energy_density"].sel(first).min()
    )
