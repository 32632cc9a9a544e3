"""Whatever a file holds, reading it gives a case or a ConfigError."""

from __future__ import annotations

import copy
import datetime as dt
import tomllib
from typing import Any

import tomli_w
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from rollerrig.config import Case, ConfigError, case_from_toml, load_case

KEYS = st.sampled_from(
    [*Case.model_fields, "use", "data", "cut", "body", "element", "kind", "profile", "wheel", "between"]
) | st.text(max_size=5)
SCALARS = (
    st.none().map(lambda _: "460 mm")
    | st.booleans()
    | st.integers(-(2**70), 2**70)
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["s1002", "steel", "wheelset_1", "rig", "track", "100 km/h", "x.toml", "a\0b", "a\nb"])
    | st.dates()
    | st.just(dt.time(1, 2))
)
VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=3), max_leaves=8
)
QUICK = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
SMALL = tomllib.loads(load_case("contact_benchmark_rollers").to_toml())


def read(text: str) -> None:
    try:
        case = case_from_toml(text)
    except ConfigError as error:
        mistakes = error.problems
    else:
        assert case_from_toml(case.to_toml()) == case
        return
    assert mistakes
    assert all("\n" not in str(mistake) for mistake in mistakes)


@QUICK
@given(st.text(max_size=60))
@example("a = " + "[" * 5000)
@example("a = " + "9" * 5000)
@example("[contact]\nfriction = 0x" + "f" * 5000)
def test_any_text(text: str) -> None:
    read(text)


@QUICK
@given(st.dictionaries(KEYS, VALUES, max_size=6))
def test_any_tables(tables: dict[str, Any]) -> None:
    read(tomli_w.dumps(tables))


def places(value: Any) -> list[tuple[Any, Any]]:
    """Every (container, key) below a value."""
    keys = value.keys() if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    return [place for key in keys for place in ((value, key), *places(value[key]))]


@QUICK
@given(st.data(), VALUES, st.sampled_from(["replace", "remove", "add"]))
def test_any_value_anywhere_in_a_good_case(data: st.DataObject, value: Any, deed: str) -> None:
    tables = copy.deepcopy(SMALL)
    holder, key = data.draw(st.sampled_from(places(tables)))
    if deed == "replace":
        holder[key] = value
    elif deed == "remove":
        del holder[key]
    elif isinstance(holder, dict):
        holder[data.draw(KEYS)] = value
    else:
        holder.append(value)
    read(tomli_w.dumps(tables))
