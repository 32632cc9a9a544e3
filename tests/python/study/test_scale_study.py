"""The study of a scaled rig: full scale and model compared, violations."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import rollerrig as rr
from called import called
from reported import unexplained
from rollerrig.analysis.scaled_model import at_times_of, axle_torque
from rollerrig.config.write.toml import to_short_toml
from rollerrig.similitude import scale_case, similitude
from rollerrig.study.frame import Outcome, Study
from rollerrig.study.scale import Scaled, ScaleStudy, scale_study

BRAKE = rr.load_case("adhesion_brake").with_changes({"time.duration": "6 s"})
WEAK = {  # a motor of 10 N m, 3.1 kN m at full scale; the brake asks for more before its wheels slide
    "brake.by_traction_motors": True,
    "traction.motor.bandwidth": "100 Hz",
    "traction.motor.envelope": [[0, 10], [200, 10]],
}


def found(study: Study[Scaled]) -> Outcome[Scaled]:
    outcome = study.run()
    assert outcome is not None
    return outcome


@pytest.fixture(scope="module")
def brake() -> Outcome[Scaled]:
    study = scale_study(BRAKE, similitude("dlr"), strategy="dlr", keep=("gravity", "material"), changes=WEAK)
    assert list(study.variants) == ["full", "model", "ideal", "material", "own"]  # the DLR type meets gravity
    return found(study)


@pytest.mark.slow
def test_motors_that_stand_in_give_the_brakes_torque_as_far_as_they_can(brake: Outcome[Scaled]) -> None:
    limit = 10 * similitude("dlr").factor("N m")
    model = brake.results.mapped["model"]
    demanded, exerted = np.abs(model["brake_torque"]), np.abs(axle_torque(model))
    assert float(demanded.max()) > 1.2 * limit
    assert float(exerted.max()) == pytest.approx(limit, rel=1e-3)  # the motor's lag comes within it by then
    assert brake.numbers["motor_limited_share"] == pytest.approx(float((demanded > limit).mean()), abs=2e-3)
    strong = brake.results.mapped["material"]  # friction brakes, as at full scale
    assert float(np.abs(axle_torque(strong)).max()) > 1.2 * limit


@pytest.mark.slow
def test_the_error_budget_tells_the_violations_apart(brake: Outcome[Scaled]) -> None:
    budget = brake.numbers["error_budget"]
    assert list(budget) == ["ideal", "material", "own"]
    assert budget["ideal"]["wheel_speed_rms"] < 1e-6  # before round-off decides a switching of the valves
    assert budget["own"]["wheel_speed_rms"] > 1e-4
    for name in ("ideal", "own"):
        assert budget[name]["linear_critical_speed_relative"] == pytest.approx(0.0, abs=1e-6)
    harder = BRAKE.with_changes({"contact.material.young_modulus": 2.5 * 210e9, "time.duration": "0.5 s"})
    alike = found(scale_study(harder, similitude("dlr"), strategy="dlr", keep=(), error_budget=False))
    # steel in a 1:5 model is a material 2.5 times as hard at full scale
    assert budget["material"]["linear_critical_speed_relative"] == pytest.approx(
        alike.results.critical["full"] / brake.results.critical["full"] - 1.0, abs=1e-6
    )


@pytest.mark.slow
def test_fidelity_is_the_difference_at_the_same_time(brake: Outcome[Scaled]) -> None:
    """By hand from the two runs of the file that a user gets, interpolated linearly in the model's times."""
    full, model = brake.results.full, brake.results.mapped["model"]
    full = full.sel(time=slice(None, float(model["time"][-1]) * (1 + 1e-12)))
    times = np.minimum(full["time"], float(model["time"][-1]))
    speeds = np.stack([np.interp(times, model["time"], model["axle_speed"].isel(axle=k)) for k in (0, 1)], axis=1)
    away = 0.46 * (speeds - full["axle_speed"].to_numpy()) / float(full["train_speed"].max())
    assert brake.numbers["fidelity"]["wheel_speed_rms"] == pytest.approx(float(np.sqrt(np.mean(away**2))), rel=1e-6)
    assert at_times_of(full, model)["train_distance"][-1] / full["train_distance"][-1] - 1.0 == pytest.approx(
        brake.numbers["fidelity"]["distance_relative"]
    )


@pytest.mark.slow
def test_files_hold_both_runs_and_every_number_is_explained(brake: Outcome[Scaled], tmp_path: Path) -> None:
    files = {path.name for path in brake.write(tmp_path)}
    assert {
        "full.nc",
        "model.nc",
        "summary.json",
        "report.html",
        "speeds.png",
        "torques.png",
        "differences.png",
    } <= files
    assert "lateral.png" not in files  # nothing but round-off
    assert unexplained(brake.study.quantities, json.loads((tmp_path / "summary.json").read_text())) == []
    hertz = next(one for one in brake.numbers["violations"] if "Hertz" in one["name"])
    assert (hertz["met"], hertz["deviation"]) == (False, pytest.approx(1.5))


@pytest.mark.slow
def test_a_run_without_actuators_shows_lateral_motion(tmp_path: Path) -> None:
    changes = {"time.duration": "0.5 s", "motion.speed": "120 km/h"}
    case = rr.load_case("bogie_rollers_constant").with_changes(changes)
    outcome = found(scale_study(case, similitude("inrets"), strategy="inrets", keep=("material",)))
    assert outcome.numbers["fidelity"]["lateral_rms_m"] < 1e-9  # INRETS with its weight put right: all requirements met
    assert all(one["met"] for one in outcome.numbers["violations"])
    files = {path.name for path in outcome.write(tmp_path)}
    assert "lateral.png" in files
    assert unexplained(outcome.study.quantities, outcome.numbers) == []


def test_the_function_is_the_command() -> None:
    case = rr.load_case("bogie_rollers_constant").with_changes({"time.duration": "0.1 s"})
    outcome = rr.scale(case, "dlr", length=4.0, keep=["gravity"], changes={"motion.speed": 10.0}, error_budget=False)
    assert isinstance(outcome.study, ScaleStudy)
    assert (outcome.study.model.motion.speed, outcome.numbers["similitude"]["length"]) == (10.0, 4.0)
    assert set(outcome.results.mapped) == {"model"}


def test_the_shipped_model_is_what_its_heading_says() -> None:
    text = Path(rr.__file__).with_name("catalog").joinpath("cases", "scaled_brake.toml").read_text()
    shipped = rr.load_case("scaled_brake")
    changes = {
        "name": "scaled_brake",
        "description": shipped.description,
        "brake.by_traction_motors": True,
        "traction.motor.bandwidth": "100 Hz",
        "traction.motor.envelope": [[0, 18], [150, 18], [165, 16.4], [180, 15], [200, 13.5]],
    }
    made = scale_case(rr.load_case("adhesion_brake"), similitude("dlr"), strategy="dlr", changes=changes)
    assert made == shipped, "make it anew with the command in its heading"
    assert (
        to_short_toml(made)
        == "".join(line for line in text.splitlines(keepends=True) if not line.startswith("#")).lstrip()
    )


def test_the_command(tmp_path: Path) -> None:
    arguments = [
        "scale",
        "adhesion_brake",
        "--strategy",
        "inrets",
        "--length",
        "8",
        "--keep",
        "none",
        "--out",
        str(tmp_path),
    ]
    done = called(*arguments, "--set", "motion.stop_speed=0.5")
    assert done.exit_code == 0, done.output
    assert "a 1:8 model of adhesion_brake, INRETS type" in done.output
    assert "All requirements of similitude are met." in done.output
    model = rr.load_case(tmp_path / "case.toml")
    assert model.motion.stop_speed == 0.5
    assert model.vehicle.data.wheel.radius == pytest.approx(0.46 / 8)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--strategy", "inret"], "did you mean 'inrets'?"),
        (["--strategy", "dlr", "--length", "0"], "similitude: length: 0.0; allowed: a factor"),
        (["--strategy", "dlr", "--set", "time.sampling_step"], "allowed: KEY=VALUE"),
        (["--strategy", "dlr", "--set", "time.sampling_step=[1"], "allowed: KEY=VALUE"),
        (["--strategy", "dlr", "--set", "time.sampling_step=1 m s"], "time.sampling_step: '1 m s'"),
        (["--strategy", "dlr", "--set", "time.sampling_stp=1"], "time.sampling_stp"),
    ],
)
def test_bad_input_ends_with_code_2(arguments: list[str], message: str, tmp_path: Path) -> None:
    done = called("scale", "adhesion_brake", "--out", tmp_path / "out", *arguments)
    assert done.exit_code == 2
    assert message in re.sub(r"[\s│]+", " ", done.output)
    assert not (tmp_path / "out").exists()
