"""`rollerrig conicity` as a user meets it."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from typer.testing import Result

from called import called
from reported import unexplained, unreported
from rollerrig.study.conicity import ConicityStudy

FILES = {
    "rollerrig.json",
    "shift.csv",
    "conicity.csv",
    "figures/characteristics.svg",
    "figures/characteristics.png",
    "summary.json",
    "timing.json",
    "report.html",
}
QUICK = ("--shift-mm", "4", "--step-mm", "0.5", "--amplitudes-mm", "1:4:1")


def conicity(*arguments: object) -> Result:
    return called("conicity", *arguments)


@pytest.fixture(scope="module")
def outputs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The same command twice."""
    folders = [tmp_path_factory.mktemp(name) for name in ("first", "second")]
    for folder in folders:
        done = conicity("s1002", "en_60e1_1_40", "--roller-radius-mm", "500", "--out", folder, *QUICK)
        assert done.exit_code == 0, done.output
        assert "conicity" in done.stderr
    return folders


@pytest.mark.slow
def test_rail_and_roller_stand_side_by_side(outputs: list[Path]) -> None:
    files = {path.relative_to(outputs[0]).as_posix() for path in outputs[0].rglob("*") if path.is_file()}
    assert files == FILES
    supports = json.loads((outputs[0] / "summary.json").read_text())["supports"]
    rail, roller = supports["rail"], supports["roller R = 500 mm"]
    assert rail["conicity_3mm"] < roller["conicity_3mm"]
    with (outputs[0] / "conicity.csv").open() as lines:
        rows = list(csv.DictReader(lines))
    assert [(row["support"], row["amplitude_mm"]) for row in rows[::4]] == [("rail", "1"), ("roller R = 500 mm", "1")]


@pytest.mark.slow
def test_every_key_of_the_summary_is_explained_and_reported(outputs: list[Path]) -> None:
    summary = json.loads((outputs[0] / "summary.json").read_text())
    assert unexplained(ConicityStudy.quantities, summary) == []
    assert unreported(ConicityStudy.quantities, summary) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(FILES - {"timing.json"}))
def test_same_input_same_bytes(outputs: list[Path], name: str) -> None:
    assert (outputs[0] / name).read_bytes() == (outputs[1] / name).read_bytes()


def test_a_table_that_ends_early_is_kept_and_told(tmp_path: Path) -> None:
    done = conicity(
        "cone_1_20",
        "en_60e1_1_40",
        "--shift-mm",
        "50",
        "--step-mm",
        "1",
        "--back-to-back-mm",
        "1320",
        "--out",
        tmp_path,
    )
    assert done.exit_code == 3
    assert "no contact from" in done.stderr
    assert (tmp_path / "report.html").is_file()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("s102", "en_60e1_1_40"), "did you mean 's1002'"),
        (("en_60e1_1_40", "s1002"), "cannot be used as a wheel"),
        (("s1002", "en_60e1_1_40", "--gauge-mm", "1.435"), "'--gauge-mm': Input should be greater than or equal to 10"),
        (("s1002", "en_60e1_1_40", "--gauge-mm", "1600"), "the wheels miss the rails"),
        (("s1002", "en_60e1_1_40", "--amplitudes-mm", "0:4:1"), "above 0"),
        (("s1002", "en_60e1_1_40", "--amplitudes-mm", "9"), "above 0 and up to the largest shift, 8 mm"),
    ],
)
def test_bad_input_is_named(arguments: tuple[str, ...], message: str, tmp_path: Path) -> None:
    done = conicity(*arguments, "--out", tmp_path)
    assert done.exit_code == 2
    assert message in " ".join(done.stderr.replace("│", " ").split())


def test_roll_is_in_the_tables(tmp_path: Path) -> None:
    done = conicity("s1002", "en_60e1_1_40", "--with-roll", "--out", tmp_path, *QUICK)
    assert done.exit_code == 0, done.output
    assert json.loads((tmp_path / "summary.json").read_text())["roll"] == "free"
    with (tmp_path / "shift.csv").open() as lines:
        rows = list(csv.DictReader(lines))
    assert [abs(float(row["roll_mrad"])) > 0.1 for row in rows if abs(float(row["lateral_mm"])) in (0.0, 4.0)] == [
        True,
        False,
        True,
    ]
