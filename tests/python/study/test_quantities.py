"""The registry of reported quantities: what is not in it is found, and tables and files show what it says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from reported import unexplained, unreported
from rollerrig.study import studies
from rollerrig.study.quantities import Quantities, Quantity, finite

REGISTRY = Quantities(
    Quantity("case", "name"),
    [Quantity("*.error_rms", "error", "1", "error, RMS", 2, ("%", 100.0)), Quantity("*.force_n", "force", "N")],
    Quantity("solver.**", "counts"),
    Quantity("points.*.speed", "of a point", "km/h"),
)


def test_every_place_is_explained_or_named() -> None:
    numbers = {
        "case": "a",
        "rig": {"error_rms": 0.1, "force_n": 2.0, "new": 1.0},
        "solver": {"steps": 3, "more": {"deep": 1}},
        "points": [{"speed": 1.0}, {"speed": 2.0, "colour": "red"}],
        "interrupted": False,
    }
    assert unexplained(REGISTRY, numbers) == ["rig.new", "points.1.colour"]


def test_a_quantity_that_is_never_reported_is_named() -> None:
    assert unreported(REGISTRY, {"case": "a", "solver": {"steps": 3}}) == ["*.error_rms", "*.force_n", "points.*.speed"]


def test_a_star_stands_for_one_name_alone() -> None:
    assert unexplained(REGISTRY, {"rig": {"deep": {"force_n": 1.0}}, "force_n": 1.0}) == ["rig.deep.force_n", "force_n"]


def test_a_table_shows_other_units_than_the_file() -> None:
    table = REGISTRY.table({"rig": {"error_rms": 0.01234, "force_n": None}}, ["error_rms", "force_n"], head="on")
    assert table.header == ("on", "error, RMS [%]", "force [N]")
    assert table.rows == [["rig", "1.2", "–"]]
    columns = REGISTRY.list_table({"a": {"force_n": 1.5}, "b": {"force_n": math.nan}}, ["force_n"])
    assert columns.rows == [["force [N]", "1.5", "–"]]


@pytest.mark.parametrize(
    ("key", "unit", "heading"),
    [
        ("real_sliding_rms_mps", "m/s", "real sliding RMS [m/s]"),
        ("axle_torque_nm", "N m", "axle torque [N m]"),
        ("rolling_ns_per_m", "N s/m", "rolling [N s/m]"),
        ("approach_um", "µm", "approach [µm]"),
        ("rate_per_s", "1/s", "rate [1/s]"),
        ("speed_kmh", "km/h", "speed [km/h]"),
        ("tracking_rms", "1", "tracking RMS [-]"),
    ],
)
def test_the_unit_at_the_end_of_a_key_is_not_said_twice(key: str, unit: str, heading: str) -> None:
    assert Quantity(key, "", unit).heading == heading


def test_headings_are_words_and_no_keys() -> None:
    spelled = {"mps", "mmps", "kmh", "nm", "kn", "hz", "um"}
    found = {q.heading for study in studies() for q in study.quantities if "*" not in q.heading}
    assert [heading for heading in found if spelled & set(heading.partition(" [")[0].split())] == []


def test_round_off_is_shown_as_zero() -> None:
    small = Quantity("amplitude_mm", "", "mm", least=1e-6)
    assert [small.cell(value) for value in (1e-10, -1e-10, 2e-6)] == ["0", "0", "2·10⁻⁶"]


def test_a_csv_file_has_registered_columns_only() -> None:
    rows = REGISTRY.csv([{"force_n": 1.0, "error_rms": 0.5}], ["error_rms", "force_n"])
    assert rows == [["error_rms", "force_n"], [0.5, 1.0]]
    with pytest.raises(KeyError, match="colour"):
        REGISTRY.csv([], ["colour"])


def test_descriptions_end_with_their_unit() -> None:
    described = REGISTRY.described()
    assert described["*.error_rms"] == "error [-]"
    assert described["*.force_n"] == "force [N]"
    assert described["case"] == "name"


def test_json_has_no_word_for_what_is_not_finite() -> None:
    assert finite({"a": (np.float64(1.5), math.inf), "b": np.array([1, 2]), "c": math.nan}) == {
        "a": [1.5, None],
        "b": [1, 2],
        "c": None,
    }
