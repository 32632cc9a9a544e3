"""Accelerations at points of a body against difference quotients, weights against the tables of the standards."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig.analysis.ride import accelerations, ride, weight, weighted_rms

CASE = rr.load_case("bogie_track").with_changes({"vehicle.cut": "vehicle", "time.duration": "0.01 s"})
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
    attributes = {"config_toml": CASE.to_toml(), "case": "rolling", "title": "rolling"}
    attributes["vehicle_bodies"] = json.dumps(bodies)
    return xr.Dataset({n: (("time", "body"), v) for n, v in data.items()}, {"time": time, "body": bodies}, attributes)


def place(run: xr.Dataset, body: str, arm: tuple[float, float, float]) -> np.ndarray:
    """Where a point is, (time, 3), by the rotation of docs/conventions.md."""
    one = run.sel(body=body)
    rows = []
    for roll, pitch, yaw in zip(*(one[name].to_numpy() for name in ("roll", "pitch", "yaw")), strict=True):
        cx, sx, cy, sy, cz, sz = (f(a) for a in (roll, pitch, yaw) for f in (np.cos, np.sin))
        about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
        about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
        about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
        rows.append(about_z @ about_x @ about_y @ np.array(arm))
    centre = np.stack([one[name].to_numpy() for name in ("longitudinal", "lateral", "vertical")], axis=1)
    return centre + np.array(rows)


@pytest.mark.parametrize("point", POINTS)
def test_a_point_accelerates_as_its_path_says(point: str) -> None:
    run = rolling(duration=1.0)
    found = accelerations(run, floor_height=1.2)["acceleration"].sel(point=point).to_numpy()
    path = place(run, point.split(" over ")[0].split(",")[0], POINTS[point])
    step = float(run["time"][1])
    second = (path[2:] - 2 * path[1:-1] + path[:-2]) / step**2
    # Difference quotients of waves up to w = 14 1/s are short of w^2 step^2 / 12 = 2e-5, of products of two twice w 6e-5.
    assert found[1:-1] == pytest.approx(second[:, 1:], abs=6e-5 * np.abs(second).max())


def test_felt_accelerations_are_used_where_the_run_has_them() -> None:
    run = rolling(duration=1.0)
    felt = run["lateral_acceleration"] + 0.6
    known = run.assign(felt_lateral_acceleration=felt, felt_vertical_acceleration=run["vertical_acceleration"])
    difference = accelerations(known)["acceleration"] - accelerations(run)["acceleration"]
    assert difference.sel(direction="lateral").to_numpy() == pytest.approx(0.6, abs=1e-12)
    assert difference.sel(direction="vertical").to_numpy() == pytest.approx(0.0, abs=1e-12)


def test_a_held_car_body_has_no_points() -> None:
    case = rr.load_case("bogie_track").with_changes({"time.duration": "10 ms"})
    points = accelerations(rr.simulate(case))["point"].to_numpy().tolist()
    assert points == ["front_frame, centre", "front_frame over wheelset_1", "front_frame over wheelset_2"]
    alone = rr.load_case("wheelset_rollers").with_changes({"time.duration": "10 ms"})
    assert accelerations(rr.simulate(alone)).sizes["point"] == 0


def test_bands_belong_to_the_bodies() -> None:
    points = ride(accelerations(rolling(duration=20.0)))
    done = dict(zip(points["point"].to_numpy(), points["filter"].to_numpy(), strict=True))
    assert done["car_body, centre"] == "0.4 to 10 Hz"
    assert done["front_frame, centre"] == "10 Hz"


@pytest.mark.parametrize(
    ("direction", "frequency", "listed"),
    [
        # ISO 2631-1:1997, table 3, W_d.
        ("lateral", 0.5, 0.853),
        ("lateral", 1.0, 1.011),
        ("lateral", 2.0, 0.890),
        ("lateral", 8.0, 0.253),
        ("lateral", 31.5, 0.0632),
    ],
)
def test_weights_of_the_standard(direction: str, frequency: float, listed: float) -> None:
    assert float(weight(np.array([frequency]), direction)[0]) == pytest.approx(listed, rel=1e-3)  # three digits listed


def test_the_weight_of_vertical_motion() -> None:
    """Flat from 5 to 16 Hz and 0.4 of that below 2 Hz, as EN 12299's W_b is meant."""
    assert weight(np.array([1.0, 1.6]), "vertical") == pytest.approx(0.4, abs=0.025)
    assert weight(np.array([5.0, 8.0, 12.5]), "vertical") == pytest.approx(1.0, abs=0.06)


def test_weighted_rms_of_a_sine() -> None:
    run = rolling(duration=20.0)  # whole periods of every coordinate: 0.7 Hz + k 0.3 Hz, each times 20 s
    still = run[["roll", "pitch", "yaw"]].map(np.zeros_like)
    still = still.merge(run[[f"{n}_{kind}" for n in still for kind in ("rate", "acceleration")]].map(np.zeros_like))
    found = weighted_rms(accelerations(run.assign(still)))
    for direction, frequency, size in (("lateral", 1.0, 0.04), ("vertical", 1.3, 0.06)):
        exact = float(weight(np.array([frequency]), direction)[0]) * size * (2 * np.pi * frequency) ** 2 / np.sqrt(2)
        assert found.sel(direction=direction).to_numpy() == pytest.approx(exact, rel=1e-9)
