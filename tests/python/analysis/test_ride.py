"""Accelerations at points of a body against difference quotients, weights against the tables of the standards."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig.analysis.assessment import accelerations, assess, ride, table
from rollerrig.assembly.model import assemble
from rollerrig.results.run_info import describe

CASE = rr.load_case("bogie_track").with_changes({"vehicle.cut": "vehicle", "time.duration": "0.01 s"})
GRAVITY = 9.81
POINTS = {
    "car_body, centre": (0.0, 0.0, 0.0),
    "car_body over front_frame": (9.5, 0.0, 1.2 - 1.8),
    "car_body over rear_frame": (-9.5, 0.0, 1.2 - 1.8),
    "front_frame over wheelset_2": (8.22 - 9.5, 0.0, 0.0),
}


def rolling(step: float = 1e-3, duration: float = 4.0) -> xr.Dataset:
    """A vehicle whose every coordinate moves on a sine of its own, with exact rates and accelerations."""
    bodies = [body.name for body in CASE.vehicle.data.body]
    time = np.arange(0.0, duration, step)
    data = {}
    for k, name in enumerate(("longitudinal", "lateral", "vertical", "roll", "pitch", "yaw")):
        w, size = 2 * np.pi * (0.7 + 0.3 * k), 0.02 * (1 + k)
        phase = np.arange(len(bodies)) + k
        angle = w * time[:, None] + phase
        angular = name in ("roll", "pitch", "yaw")
        data[name] = size * np.sin(angle)
        data[f"{name}_rate" if angular else f"{name}_velocity"] = size * w * np.cos(angle)
        data[f"{name}_acceleration"] = -size * w * w * np.sin(angle)
    data |= gyroscopes(time, len(bodies))
    attributes = {"run_info": describe(assemble(CASE)).to_json(), "case": "rolling", "title": "rolling"}
    run = xr.Dataset({n: (("time", "body"), v) for n, v in data.items()}, {"time": time, "body": bodies}, attributes)
    for name in ("distance", "curvature", "speed"):
        run[name] = ("time", np.zeros_like(time))
    return with_felt(run)


def gyroscopes(time: np.ndarray, bodies: int) -> dict[str, np.ndarray]:
    """Angular velocity and acceleration along the bodies' axes, as the core records them: E(φ, θ) times the rates, and its rate.

    The acceleration is the imaginary part of the velocity at a complex time: exact to round-off.
    """
    tiny = 1e-20
    at = time[:, None] + 1j * tiny
    angles, rates = [], []
    for k in (3, 4, 5):
        w, size = 2 * np.pi * (0.7 + 0.3 * k), 0.02 * (1 + k)
        angle = w * at + np.arange(bodies) + k
        angles.append(size * np.sin(angle))
        rates.append(size * w * np.cos(angle))
    (roll, pitch, _), (roll_rate, pitch_rate, yaw_rate) = angles, rates
    cr, sr, cp, sp = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch)
    turning = (cp * roll_rate - sp * cr * yaw_rate, pitch_rate + sr * yaw_rate, sp * roll_rate + cp * cr * yaw_rate)
    found = {}
    for axis, about in zip(("roll", "pitch", "yaw"), turning, strict=True):
        found[f"inertial_{axis}_rate"], found[f"inertial_{axis}_acceleration"] = about.real, about.imag / tiny
    return found


def with_felt(run: xr.Dataset) -> xr.Dataset:
    """The run with what the core records of accelerometers at the centres: R^T (a + g e_z)."""
    for direction, column in (("lateral", 1), ("vertical", 2)):
        felt = [
            np.einsum(
                "tj,tj->t", rotations(run, body)[:, :, column], vector(run, body, "_acceleration") + [0, 0, GRAVITY]
            )
            for body in run["body"].to_numpy()
        ]
        run[f"{direction}_specific_force"] = (("time", "body"), np.stack(felt, axis=1))
    return run


def rotations(run: xr.Dataset, body: str) -> np.ndarray:
    """R_z R_x R_y of docs/conventions.md, (time, 3, 3)."""
    angles = [run.sel(body=body)[name].to_numpy() for name in ("roll", "pitch", "yaw")]
    (cx, sx), (cy, sy), (cz, sz) = ((np.cos(angle), np.sin(angle)) for angle in angles)
    none, one = np.zeros_like(cx), np.ones_like(cx)

    def matrix(rows: list[list[np.ndarray]]) -> np.ndarray:
        return np.moveaxis(np.array(rows), -1, 0)

    about_z = matrix([[cz, -sz, none], [sz, cz, none], [none, none, one]])
    about_x = matrix([[one, none, none], [none, cx, -sx], [none, sx, cx]])
    about_y = matrix([[cy, none, sy], [none, one, none], [-sy, none, cy]])
    return about_z @ about_x @ about_y


def vector(run: xr.Dataset, body: str, kind: str = "") -> np.ndarray:
    names = [f"{name}{kind}" for name in ("longitudinal", "lateral", "vertical")]
    return np.stack([run.sel(body=body)[name].to_numpy() for name in names], axis=1)


@pytest.mark.parametrize("point", POINTS)
def test_an_accelerometer_feels_what_its_path_says(point: str) -> None:
    run, body = rolling(duration=1.0), point.split(" over ")[0].split(",")[0]
    found = accelerations(run, floor_height=1.2)["acceleration"].sel(point=point).to_numpy()
    turned = rotations(run, body)
    path = vector(run, body) + turned @ np.array(POINTS[point])
    step = float(run["time"][1])
    second = (path[2:] - 2 * path[1:-1] + path[:-2]) / step**2 + [0.0, 0.0, GRAVITY]
    felt = np.einsum("tji,tj->ti", turned[1:-1], second) - [0.0, 0.0, GRAVITY]
    # Difference quotients of waves up to w = 14 1/s are short of w^2 step^2 / 12 = 2e-5, of products of two twice w 6e-5.
    assert found[1:-1] == pytest.approx(felt[:, 1:], abs=6e-5 * np.abs(felt).max())


def test_a_body_that_leans_feels_gravity() -> None:
    run = rolling(duration=1.0).map(np.zeros_like)
    run["roll"] = run["roll"] + 0.05
    with_felt(run)
    found = accelerations(run)["acceleration"].isel(time=0)
    assert found.sel(direction="lateral").to_numpy() == pytest.approx(GRAVITY * np.sin(0.05))
    assert found.sel(direction="vertical").to_numpy() == pytest.approx(GRAVITY * (np.cos(0.05) - 1))


def test_over_its_bogies_a_body_feels_a_transition_sooner_and_later() -> None:
    """On a clothoid a body that follows the track turns ever faster: its front is pushed inwards first."""
    speed, growth = 40.0, 2e-5  # 1/R = growth s [1/m^2]
    run = rolling(duration=2.0).map(np.zeros_like)
    way = speed * run["time"]
    run = run.assign(distance=way, curvature=growth * way)
    centre = np.broadcast_to((speed**2 * growth * way).to_numpy()[:, None], run["roll"].shape)
    run["lateral_specific_force"] = (("time", "body"), centre)
    run["speed"] = ("time", np.full(len(way), speed))
    run["inertial_yaw_rate"] = run["inertial_yaw_rate"] + speed * growth * way
    run["inertial_yaw_acceleration"] = run["inertial_yaw_acceleration"] + speed**2 * growth
    lateral = accelerations(run)["acceleration"].sel(direction="lateral").isel(time=1000)
    at = {str(point): float(lateral.sel(point=point)) for point in lateral["point"].to_numpy()}
    for point, ahead in (
        ("car_body over front_frame", 9.5),
        ("car_body, centre", 0.0),
        ("car_body over rear_frame", -9.5),
    ):
        # The acceleration of a point ahead is that of the curvature there.
        assert at[point] == pytest.approx(speed**2 * growth * (40.0 + ahead), rel=1e-9)


def test_a_fixed_car_body_has_no_points() -> None:
    case = rr.load_case("bogie_track").with_changes({"time.duration": "10 ms"})
    points = accelerations(rr.simulate(case))["point"].to_numpy().tolist()
    assert points == ["front_frame, centre", "front_frame over wheelset_1", "front_frame over wheelset_2"]
    alone = rr.load_case("wheelset_rollers").with_changes({"time.duration": "10 ms"})
    assert accelerations(rr.simulate(alone)).sizes["point"] == 0


def test_the_quasi_static_acceleration_is_that_before_the_band_pass() -> None:
    case = CASE.with_changes({"time.duration": "3 s", "time.output_step": "5 ms", "disturbance": []})
    run = rr.simulate(case)
    run["lateral_specific_force"] = run["lateral_specific_force"] + 0.65
    row = next(row for row in table(assess(run)) if row.place == "car_body, centre")
    assert row.filter == "0.4 to 10 Hz"
    assert row.statistics["quasi_static"] == pytest.approx(0.65, abs=1e-6)
    assert row.statistics["largest"] < 1e-3


def test_bands_belong_to_the_bodies() -> None:
    points = ride(accelerations(rolling(duration=20.0)))
    done = dict(zip(points["point"].to_numpy(), points["filter"].to_numpy(), strict=True))
    assert done["car_body, centre"] == "0.4 to 10 Hz"
    assert done["front_frame, centre"] == "10 Hz"
