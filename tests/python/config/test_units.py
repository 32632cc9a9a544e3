"""Quantities: what may be written, and that it becomes the nearest float in SI."""

from __future__ import annotations

import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollerrig.config.schema.units import KEY_SUFFIXES, Quantity


@pytest.mark.parametrize(
    ("unit", "written", "si"),
    [
        ("m", 0.46, 0.46),
        ("m", 1, 1.0),
        ("m", "0.46 m", 0.46),
        ("m", "460 mm", 0.46),
        ("m", "460mm", 0.46),
        ("m", "1435 mm", 1.435),
        ("m/s", "90 km/h", 25.0),
        ("m/s", "90 kmh", 25.0),
        ("N", "54.55 kN", 54550.0),
        ("kg", "32 t", 32000.0),
        ("N s/m", "15 kN s/m", 15000.0),
        ("N s/m", "15 kNs/m", 15000.0),
        ("N m/rad", "940 kNm/rad", 940e3),
        ("N m/rad", "940 kN*m/rad", 940e3),
        ("N/m", "31.391 MN/m", 31.391e6),
        ("kg m^2", "1120 kg m²", 1120.0),
        ("kg m^2", "1120 kg*m^2", 1120.0),
        ("Pa", "82 GPa", 82e9),
        ("rad", "2.4 mrad", 0.0024),
        ("rad", "180 deg", math.pi),
        ("1", "1:40", 0.025),
        ("1", "5 %", 0.05),
        ("1", 0.3, 0.3),
    ],
)
def test_a_quantity_becomes_the_nearest_float_in_si(unit: str, written: object, si: float) -> None:
    assert Quantity(unit).parse(written) == si  # exact: the decimal is converted as a fraction and rounded once


@pytest.mark.parametrize(
    "written",
    [
        "2 N", "460", "mm", "460 mmm", "460 mm mm", "", " ", "1:40", "4,6 m", "1e400 m", "nan m", "inf m",
        "1 m^9^9^9", "1 m**99", "1 (m", "1 m;import os", "1 " + "m" * 100, "0x10 m", "1:0",
        math.nan, math.inf, -math.inf, True, False, None, [], {}, 10**400,
    ],
)  # fmt: skip
def test_what_is_no_length_is_refused(written: object) -> None:
    with pytest.raises(ValueError, match=r"allowed: a number in m or a text with a unit like '460 mm'"):
        Quantity("m").parse(written)


@given(st.text(max_size=30) | st.from_regex(r"[0-9.]{1,5} ?[a-zA-Z*/^() 0-9]{1,12}", fullmatch=True))
def test_any_text_is_a_number_or_a_value_error(written: str) -> None:
    with contextlib.suppress(ValueError):
        assert math.isfinite(Quantity("m/s").parse(written))


def test_bounds_are_told_in_the_unit() -> None:
    with pytest.raises(ValueError, match="greater than 0 m and at most 2 m"):
        Quantity("m", gt=0, le=2).parse("0 mm")


def test_every_key_suffix_is_a_unit() -> None:
    units = {"km/h": "m/s", "mm": "m", "deg": "rad", "mrad": "rad", "kN": "N", "kN m": "N m", "t": "kg", "ms": "s",
             "GPa": "Pa"}  # fmt: skip
    for unit in KEY_SUFFIXES.values():
        assert Quantity(units.get(unit, unit)).parse(f"1 {unit}") > 0
