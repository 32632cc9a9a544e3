"""`rollerrig response`: the linear bench beside a sine on the nonlinear one, its files and its messages."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
import scipy.io

import rollerrig as rr
from called import called
from reported import unexplained
from rollerrig.analysis.linear_bench import LinearBench
from rollerrig.analysis.measured_response import measured_response
from rollerrig.study.frame import Outcome
from rollerrig.study.response import ResponseStudy

COMMAND = "wheelset_1.roller_torque_command"
OUTPUTS = ("wheelset_1.axle_speed", "wheelset_1_left.longitudinal_force")


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    """Low, middle, and 25 Hz, which is half the bandwidth of the drives."""
    return rr.response(
        "adhesion_brake", [COMMAND], OUTPUTS, (80.0, 120.0), frequencies=(2.0, 25.0), points=40, measured=3
    )


@pytest.fixture(scope="module")
def folder(outcome: Outcome, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("response")
    outcome.write(path)
    return path


@pytest.mark.slow
def test_measured_and_linear_agree_up_to_half_the_bandwidth_of_the_drives(outcome: Outcome) -> None:
    """1 dB is asked for; at 100 N m all is linear: what is left is the torque's straight line over a step."""
    errors = [one["measured_error_db"] for channel in outcome.numbers["channels"].values() for one in channel.values()]
    assert len(errors) == 4
    assert max(errors) < 0.1
    drive = outcome.study.case.rig_control.motor.bandwidth
    assert outcome.results["120 km/h"].measured[COMMAND].frequencies[-1] == pytest.approx(0.5 * drive)


def test_measured_and_linear_agree_where_nothing_is_sampled() -> None:
    """Torque on an axle of a speed-controlled rig, continuous in time: the hold of the sine is taken out."""
    case, source, outputs = rr.load_case("wheelset_rollers"), "wheelset_1.axle_torque", OUTPUTS[1:]
    found = measured_response(LinearBench(case), source, outputs, [10.0], 1000.0)
    assert found is not None
    linear = LinearBench(case).system([source], outputs).response(found.frequencies)[:, :, 0]
    np.testing.assert_allclose(found.values, linear, rtol=0.01)


def test_a_large_sine_is_not_linear() -> None:
    """10 kN m is more than wheels on 2 % of friction pass on: the wheels slide, or the rig's protection ends the run."""
    case = rr.load_case("adhesion_brake").with_changes({"contact.friction": 0.02})
    found = measured_response(LinearBench(case), COMMAND, OUTPUTS[1:], [20.0], 10e3)
    assert found is not None
    linear = LinearBench(case).system([COMMAND], OUTPUTS[1:], discrete=True).response(found.frequencies)[:, :, 0]
    assert found.ended or abs(found.values / linear) < 0.9


def test_a_wrong_name_leaves_no_folder(tmp_path: Path) -> None:
    words = [
        "response",
        "adhesion_brake",
        "--input",
        COMMAND,
        "--output",
        "wheelset_1.axl",
        "--out",
        str(tmp_path / "out"),
    ]
    done = called(*words)
    assert done.exit_code != 0
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_files(outcome: Outcome, folder: Path) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    assert unexplained(ResponseStudy.quantities, summary) == []
    with (folder / "response.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2 * 2 * (40 + 3)
    matlab = scipy.io.loadmat(folder / "linear_120_kmh.mat")
    np.testing.assert_array_equal(matlab["A"], outcome.results["120 km/h"].system.a)
    with (folder / "poles.csv").open() as file:
        kinds = {row["kind"] for row in csv.DictReader(file)}
    assert kinds == {"pole", *(f"zero of {COMMAND} to {output}" for output in OUTPUTS)}
    assert {path.stem for path in (folder / "figures").iterdir()} == {
        f"{kind}_{number}" for kind in ("bode", "nyquist", "poles") for number in (1, 2)
    }


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--input", "wheelset_1.roler_torque_command", "--output", "wheelset_1.lateral"], "did you mean"),
        (["--input", COMMAND], "outputs: none; allowed:"),
        (["--input", COMMAND, "--output", "wheelset_1.lateral", "--speeds-kmh", "900"], "allowed: up to 720 km/h"),
        (
            ["--input", COMMAND, "--output", "wheelset_1.lateral", "--to-hz", "600"],
            "half the sampling frequency being 500 Hz",
        ),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(options: list[str], message: str, tmp_path: Path) -> None:
    done = called("response", "adhesion_brake", "--out", tmp_path / "out", *options)
    assert done.exit_code == 2
    assert message in " ".join(done.stderr.split())
    assert not list((tmp_path / "out").glob("*")) if (tmp_path / "out").exists() else True
