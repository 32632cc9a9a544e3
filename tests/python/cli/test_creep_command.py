"""`rollerrig creep` as a user meets it."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import Result

from called import called
from reported import unexplained
from rollerrig.assembly.laws import creep_law
from rollerrig.contact_analysis.creep_laws import REFERENCE, compare_laws, error_table
from rollerrig.study.creep import CreepStudy

FILES = {
    "rollerrig.json",
    "creep.csv",
    "figures/creep.svg",
    "figures/creep.png",
    "summary.json",
    "timing.json",
    "report.html",
}


def creep(*arguments: object) -> Result:
    return called("creep", *arguments)


@pytest.fixture(scope="module")
def output(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("creep")
    options = ("--law", "table", "--law", "polach", "--k-a", 1, "--k-s", 1, "--demands", "0.5,8")
    done = creep("--a-over-b", 1, *options, "--out", folder)
    assert done.exit_code == 0, done.output
    assert "table: force at most" in done.stderr
    return folder


@pytest.mark.slow
def test_all_files_are_written_and_say_the_same(output: Path) -> None:
    assert {path.relative_to(output).as_posix() for path in output.rglob("*.*")} == FILES
    laws = json.loads((output / "summary.json").read_text())["laws"]
    assert laws["table"]["spin"]["force_worst"] < 3.0 < laws["polach"]["spin"]["force_worst"]
    with (output / "creep.csv").open() as lines:
        rows = list(csv.DictReader(lines))
    assert len(rows) == 3 * 7 * 2
    exact = [row for row in rows if row["law"] == REFERENCE and row["direction"] == "longitudinal"]
    assert float(exact[1]["force_x_over_mu_n"]) == pytest.approx(-1.0, abs=1e-3)  # slides
    assert float(exact[1]["adhesion"]) == 0.0


@pytest.mark.slow
def test_every_key_of_the_summary_is_explained(output: Path) -> None:
    assert unexplained(CreepStudy.quantities, json.loads((output / "summary.json").read_text())) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--law", "coulomb"), "kind: 'coulomb'; allowed: kalker_saturated, kalker_linear"),
        (("--law", "polach"), "polach: k_A: missing; needed: a number, from 1e-06 to 1"),
        (("--law", "table", "--law", "table"), "asked for more than once"),
        (("--a-over-b", "20"), "tabulated from 0.1 to 10"),
        (("--a-over-b", "nan"), "not a finite number"),
        (("--poisson-ratio", "0.7"), "allowed are 0 to 0.5"),
        (("--demands", "0,1"), "demands must be positive"),
        (("--k-a", "1"), "belong together"),
        (
            ("--law", "polach", "--k-a", "2", "--k-s", "1"),
            "polach: k_A: 2.0; allowed: a number, from 1e-06 to 1",
        ),
    ],
)
def test_bad_input_is_named(arguments: tuple[str, ...], message: str, tmp_path: Path) -> None:
    done = creep(*arguments, "--out", tmp_path)
    assert done.exit_code == 2
    assert message in " ".join(done.output.split())


def test_errors_are_those_of_the_forces() -> None:
    comparison = compare_laws(2.0, {"linear": creep_law("kalker_linear")}, demands=(1.0,), fineness=0.5)
    rows = error_table(comparison)
    assert [row[:2] for row in rows] == [("linear", "no spin"), ("linear", "spin")]
    by_hand = comparison.sel(law="linear") - comparison.sel(law=REFERENCE)
    assert max(row[4] for row in rows) == pytest.approx(
        100 * float(np.hypot(by_hand["force_x"], by_hand["force_y"]).max()), rel=1e-9
    )
    with pytest.raises(ValueError, match="no law"):
        compare_laws(2.0, {})
