"""The study of a scaled rig: full scale and model in one report, violations told, motors limited."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import rollerrig as rr
from rollerrig.cli.app import build_app
from rollerrig.config.write.toml import to_short_toml
from rollerrig.similitude import scale_case, similitude
from rollerrig.studies.scaled import compare_scaled, numbers, plan_scaled, verdict, write_scaled
from rollerrig.studies.scaled.compute import KEYS, axle_torque

BRAKE = rr.load_case("adhesion_brake").with_changes({"time.duration": "6 s"})
WEAK = {  # a motor of 10 N m, 3.1 kN m at full scale; the brake asks for more before its wheels slide
    "brake.motors_stand_in": True,
    "traction.motor.bandwidth": "100 Hz",
    "traction.motor.envelope": [[0, 10], [200, 10]],
}


@pytest.fixture(scope="module")
def brake():
    plan = plan_scaled(BRAKE, similitude("dlr"), strategy="dlr", keep=("gravity", "material"), changes=WEAK)
    assert list(plan.causes) == ["ideal", "material", "own"]  # the DLR type meets gravity
    return compare_scaled(plan, processes=1)


def test_motors_that_stand_in_give_the_brakes_torque_as_far_as_they_can(brake) -> None:
    limit = 10 * similitude("dlr").factor("N m")
    asked, given = np.abs(brake.mapped["brake_torque"]), np.abs(axle_torque(brake.mapped))
    assert float(asked.max()) > 1.2 * limit
    assert float(given.max()) == pytest.approx(limit, rel=1e-3)  # the motor's lag comes within it by then
    found = numbers(brake)
    assert 0.1 < found["motor_limited_share"] < 1.0
    strong = brake.causes["material"]  # friction brakes, as at full scale
    assert float(np.abs(axle_torque(strong)).max()) > 1.2 * limit


def test_what_each_violation_costs_is_told(brake) -> None:
    found = numbers(brake)
    assert found["causes"]["ideal"]["wheel_speed_rms"] < 1e-6  # before round-off decides a switching of the valves
    assert found["causes"]["own"]["wheel_speed_rms"] > 1e-4
    assert found["causes"]["ideal"]["critical_speed_relative"] == pytest.approx(0.0, abs=1e-6)
    assert found["causes"]["own"]["critical_speed_relative"] == pytest.approx(0.0, abs=1e-6)
    harder = BRAKE.with_changes({"contact.material.young_modulus": 2.5 * 210e9})
    alike = compare_scaled(plan_scaled(harder, similitude("dlr"), strategy="dlr", keep=(), causes=False), processes=1)
    assert alike is not None
    # steel in a 1:5 model is a material 2.5 times as hard at full scale
    assert found["causes"]["material"]["critical_speed_relative"] == pytest.approx(
        alike.critical["full"] / brake.critical["full"] - 1.0, abs=1e-6
    )


def test_the_files_and_the_report(brake, tmp_path: Path) -> None:
    files = write_scaled(brake, tmp_path)
    assert [file.name for file in files] == ["full.nc", "model.nc", "summary.json", "axles.csv", "report.html"]
    summary = json.loads((tmp_path / "summary.json").read_text())
    documented = " ".join(KEYS)
    for key in summary["full"]:
        assert f"*.{key}" in documented, key
    for key in summary["fidelity"]:
        assert key in KEYS["fidelity.*"], key
    page = (tmp_path / "report.html").read_text()
    for heading in ("Similitude", "Contact at rest", "Speeds", "Torque and contact", "What each violation costs"):
        assert f">{heading}</h2>" in page
    assert "Lateral motion" not in page  # nothing but round-off
    assert page.count("data:image/png") == 3
    rows = (tmp_path / "axles.csv").read_text().splitlines()
    assert rows[0].startswith("time_s,train_speed_full_mps,train_speed_model_mps,axle_speed_wheelset_1_full_rad_per_s")
    assert "violated: elasticity of the contact (Hertz) (+150 %)" in verdict(brake)


def test_a_run_without_machines_shows_lateral_motion(tmp_path: Path) -> None:
    changes = {"time.duration": "0.5 s", "motion.speed": "120 km/h"}
    case = rr.load_case("bogie_rollers_constant").with_changes(changes)
    plan = plan_scaled(case, similitude("inrets"), strategy="inrets", keep=("material",))
    results = compare_scaled(plan, processes=1)
    assert results is not None
    found = numbers(results)
    assert found["fidelity"]["lateral_rms_m"] < 1e-9  # INRETS with its weight put right: all requirements met
    assert "All requirements of similitude are met." in verdict(results)
    write_scaled(results, tmp_path)
    assert ">Lateral motion</h2>" in (tmp_path / "report.html").read_text()
    assert not (tmp_path / "axles.csv").exists()


def test_the_shipped_model_is_what_its_heading_says() -> None:
    text = Path(rr.__file__).with_name("catalog").joinpath("cases", "scaled_brake.toml").read_text()
    shipped = rr.load_case("scaled_brake")
    changes = {
        "name": "scaled_brake",
        "description": shipped.description,
        "brake.motors_stand_in": True,
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
    runner = CliRunner()
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
    done = runner.invoke(build_app(), [*arguments, "--set", "bench.standstill=0.5"])
    assert done.exit_code == 0, done.output
    assert "a 1:8 model of adhesion_brake, INRETS type" in done.output
    assert "All requirements of similitude are met." in done.output
    model = rr.load_case(tmp_path / "case.toml")
    assert model.bench.standstill == 0.5
    assert model.vehicle.data.wheel.radius == pytest.approx(0.46 / 8)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--strategy", "inret"], "did you mean 'inrets'?"),
        (["--strategy", "dlr", "--length", "0"], "similitude: length: 0.0; allowed: a factor"),
        (["--strategy", "dlr", "--set", "bench.step"], "allowed: KEY=VALUE"),
        (["--strategy", "dlr", "--set", "bench.step=1 m s"], "allowed: KEY=VALUE"),
        (["--strategy", "dlr", "--set", "bench.stp=1"], "bench.stp"),
    ],
)
def test_bad_input_ends_with_code_2(arguments: list[str], message: str, tmp_path: Path) -> None:
    done = CliRunner().invoke(build_app(), ["scale", "adhesion_brake", "--out", str(tmp_path / "out"), *arguments])
    assert done.exit_code == 2
    assert message in re.sub(r"[\s│]+", " ", done.output)
    assert not (tmp_path / "out").exists()
