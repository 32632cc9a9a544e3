"""The one registry of reported quantities: what stands in its file is what studies get."""

from __future__ import annotations

import tomllib
from importlib.resources import files

import pytest

from rollerrig.results.quantities import registered
from rollerrig.study import studies
from rollerrig.study.measures import MEASURES

TABLES = tomllib.loads(files("rollerrig.results").joinpath("quantities.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("table", TABLES)
def test_every_table_is_read_and_has_each_key_once(table: str) -> None:
    found = list(registered(table))
    keys = [quantity.key for quantity in found]
    assert len(keys) == len(set(keys)) > 0
    assert all(quantity.meaning and "{" not in quantity.meaning and quantity.unit != "-" for quantity in found)


def test_no_table_is_left_that_nobody_names() -> None:
    named = {study.command for study in studies()} | {"test", "running_safety"}
    named |= {f"measure.{kind}" for kind in MEASURES}
    taken_in = {
        one["group"] for table in TABLES.values() for one in table.values() if isinstance(one, dict) and "group" in one
    }
    assert TABLES.keys() <= named | taken_in


def test_an_entry_takes_what_it_does_not_say_from_another() -> None:
    own = {quantity.key: quantity for quantity in registered("control")}["*.*.tracking_rms"]
    shared = {quantity.key: quantity for quantity in registered("test")}["tracking_rms"]
    assert (own.meaning, own.unit, own.shown) == (shared.meaning, "1", ("%", 100.0))
    assert (own.label, own.digits) == ("tracking RMS", 3)


def test_groups_and_ends_of_ensembles_stand_below_their_key() -> None:
    paper = {quantity.key: quantity for quantity in registered("paper")}
    both = [paper[f"{prefix}materials.*.by_disturbance.decays_kmh"] for prefix in ("", "exact_contact.")]
    assert both[0].meaning == both[1].meaning
    assert ", with the exact contact," in paper["exact_contact.traction.speed_kmh"].meaning
    wsp = {quantity.key: quantity for quantity in registered("wsp")}
    mean, high = (wsp[f"stops.*.*.flat_length_m.{end}"] for end in ("mean", "high"))
    assert mean.meaning.endswith("; mean of all starts")
    assert high.meaning == "upper end"
    assert mean.heading == high.heading == "flat length, estimated [mm]"
    assert mean.in_shown_unit(0.02) == pytest.approx(20.0)
