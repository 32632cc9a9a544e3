"""Adhesion maps from files over distance: the rail that they give, and refusals by file and row."""

from __future__ import annotations

from pathlib import Path

import pytest

from rollerrig import ConfigError, load_case
from rollerrig.config import Case, case_from_toml

CASE = 'base = "adhesion_brake"\n[adhesion]\nrail = "low"\nfile = "map.csv"\n'


def case_on(folder: Path, rows: str, text: str = CASE) -> Case:
    (folder / "map.csv").write_text(rows)
    (folder / "case.toml").write_text(text)
    return load_case(folder / "case.toml")


def test_conditions_begin_at_their_rows(tmp_path: Path) -> None:
    case = case_on(tmp_path, "distance [m],condition\n40,wet\n90.5,dry\n")
    wanted = load_case("adhesion_brake").with_changes({
        "adhesion.rail": "low",
        "adhesion.piece": [{"distance": "40 m", "rail": "wet"}, {"distance": "90.5 m", "rail": "dry"}],
    })  # fmt: skip
    assert case.adhesion == wanted.adhesion
    assert case_from_toml(case.to_toml()) == case, "the file is in the case, and needed no more"


def test_friction_passes_from_point_to_point(tmp_path: Path) -> None:
    """As `rollerrig reconstruct` writes it, with columns beside."""
    case = case_on(tmp_path, "distance_m,friction,measured\n5,0.08,1\n15,0.1,1\n25,0.06,0\n")
    rail = case.adhesion
    assert rail is not None
    assert rail.blend == 10.0
    assert [(piece.distance, piece.rail.friction.mu_0) for piece in rail.piece] == [(5.0, 0.1), (15.0, 0.06)]
    assert (rail.rail.friction.mu_0, rail.rail.k_A) == (0.08, 0.3), "the rest is that of low"
    assert rail.piece[0].rail.friction.kind == "falling"


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("distance [m],friction\n0,0.1\n10,0.1\n30,0.1\n", "row 3: 30 m follows 10 m, a gap; allowed: rows 10 m apart"),
        ("distance [m],friction\n0,0.1\n10,\n", "row 2, column 'friction': '' is no number"),
        ("distance [m],friction\n10,0.1\n0,0.2\n", "row 2: 0 m follows 10 m; allowed: distances that rise"),
        ("distance [m],friction\n0,0.1\nnan,0.2\n", "row 2: nan m follows 0 m"),
        ("distance [m],friction\n0,0.1\n10,1.2\n", "row 2: friction 1.2; allowed: 0 to 1"),
        ("distance [m],friction\n0,0.1\n", "1 rows; allowed: 2 to 10000"),
        ("distance [m],friction\n0,0.1\n10\n", "row 2: 1 cells; needed: 2, as in the heading"),
        (
            "distance [m];friction\n0;0,1\n10;0,2\n",
            "cells are separated by ';'; needed: commas between cells, and points",
        ),
        ("distance [m],mu\n0,0.1\n10,0.1\n", "columns distance [m], mu; needed: 'distance [m]', and 'friction'"),
        ("place,friction\n0,0.1\n10,0.1\n", "columns place, friction; needed: 'distance [m]'"),
        ("distance [m],condition\n0,low\n10,wett\n", "row 2: 'wett'; allowed: dry, eurosprinter, wet, low, very_low"),
        ("", "no table: needed is a heading"),
    ],
)
def test_a_map_that_is_none_is_refused_by_file_and_row(tmp_path: Path, rows: str, message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        case_on(tmp_path, rows)
    assert "case.toml: adhesion.file: '" in str(caught.value)
    assert "map.csv'; " in str(caught.value)
    assert message in str(caught.value)
    assert len(caught.value.problems) == 1


def test_a_file_beside_pieces_and_one_that_is_not_there_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"adhesion\.piece: given; allowed without adhesion\.file"):
        case_on(tmp_path, "", CASE + '[[adhesion.piece]]\ndistance = "3 m"\nrail = "dry"\n')
    with pytest.raises(ConfigError, match=r"adhesion.file: .*; not read: No such file"):
        case_from_toml(CASE.replace("map.csv", "no.csv"), folder=tmp_path)
