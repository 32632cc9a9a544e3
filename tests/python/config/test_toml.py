"""Text of configurations: what is written is what any reader of TOML reads."""

from __future__ import annotations

import tomllib
from typing import Any

import tomli_w
from hypothesis import given
from hypothesis import strategies as st

import rollerrig as rr
from rollerrig.config.write.toml import plain, text_of

KEYS = st.text(st.characters(codec="utf-8"), max_size=8)
NUMBERS = st.floats(allow_nan=False) | st.integers(-(2**62), 2**62)
VALUES = (
    st.text(st.characters(codec="utf-8")) | st.booleans() | NUMBERS | st.lists(NUMBERS) | st.lists(st.lists(NUMBERS))
)
TABLES = st.recursive(
    st.dictionaries(KEYS, VALUES, max_size=4),
    lambda inner: st.dictionaries(KEYS, VALUES | inner | st.lists(inner, min_size=1, max_size=3), max_size=4),
    max_leaves=12,
)


@given(TABLES)
def test_any_table_is_read_as_it_was_written(table: dict[str, Any]) -> None:
    assert tomllib.loads(text_of(table)) == table


def test_every_case_is_what_a_library_writes() -> None:
    for kind, name, _ in rr.catalog_entries():
        if kind == "case":
            case = rr.load_case(name)
            assert tomllib.loads(case.to_toml()) == tomllib.loads(tomli_w.dumps(plain(case)))


def test_a_table_of_tables_alone_has_no_head_and_an_innermost_list_is_one_line() -> None:
    text = text_of({"a": {"b": {"c": [[1.0, 2.0], [3.0, 4.0]]}}, "d": {}, "e": [{"f": "g"}, {}]})
    assert text == '[a.b]\nc = [\n    [1.0, 2.0],\n    [3.0, 4.0],\n]\n\n[d]\n\n[[e]]\nf = "g"\n\n[[e]]\n'


def test_cases_that_share_a_vehicle_are_written_like_those_that_do_not() -> None:
    case = rr.load_case("bogie_rollers_constant")
    before = case.to_toml()
    faster = case.with_changes({"motion.speed": "54 km/h"})
    heavier = case.with_changes({"vehicle.body.car_body.mass": "31 t", "support.roller_radius": 1.0})
    assert faster.vehicle.data is case.vehicle.data
    for changed in (faster, heavier):
        assert tomllib.loads(changed.to_toml()) == tomllib.loads(tomli_w.dumps(plain(changed)))
    assert case.to_toml() == before
