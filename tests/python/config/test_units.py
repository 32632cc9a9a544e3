"""Quantities: what may be written, and that it becomes the nearest float in SI."""

from __future__ import annotations

import contextlib
import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollerrig.config.schema import units
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
    assert (
        Quantity(unit, -1e12, 1e12).parse(written) == si
    )  # exact: the decimal is converted as a fraction and rounded once


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
        Quantity("m", -1e3, 1e3).parse(written)


@given(st.text(max_size=30) | st.from_regex(r"[0-9.]{1,5} ?[a-zA-Z*/^() 0-9]{1,12}", fullmatch=True))
def test_any_text_is_a_number_or_a_value_error(written: str) -> None:
    with contextlib.suppress(ValueError):
        assert math.isfinite(Quantity("m/s", -1e300, 1e300).parse(written))


def test_bounds_are_told_in_the_unit() -> None:
    with pytest.raises(ValueError, match=r"from 0\.01 to 2 m"):
        Quantity("m", 0.01, 2.0).parse("0 mm")


@pytest.mark.parametrize(
    ("quantity", "written", "told"),
    [
        (Quantity("m/s", 0.0, 200.0, bare=70.0), 80, "did you mean '80 km/h' or '80 m/s'?"),
        (Quantity("m", 1e-3, 1e6, bare=10.0), 500, "did you mean '500 mm' or '500 m'?"),
        (Quantity("m", 0.01, 2.0), 460, "from 0.01 to 2 m; did you mean '460 mm'?"),
        (Quantity("m/s", 0.0, 200.0, bare=70.0), 250.0, "did you mean '250 km/h'?"),
        (Quantity("rad", -0.5, 0.5, bare=0.2), 2, "did you mean '2 deg'?"),
        (Quantity("Pa", 1e5, 1e14), 210, "did you mean '210 GPa'?"),
    ],
)
def test_a_number_that_was_meant_in_another_unit_is_asked_about(quantity: Quantity, written: float, told: str) -> None:
    with pytest.raises(ValueError, match=re.escape(told)):
        quantity.parse(written)
    assert quantity.least <= quantity.parse(told.rpartition("'")[0].rpartition("'")[2]) <= quantity.most


def test_an_example_fits_where_it_is_offered() -> None:
    assert "'3.8 bar'" in Quantity("Pa", 0.0, 1e8).allowed
    assert "'82 GPa'" in Quantity("Pa", 1e5, 1e14).allowed
    assert Quantity("Pa", 0.0, 1e8).parse("3.8 bar") == 3.8e5


@given(st.floats(-1e6, 1e6))
def test_a_quantity_reads_what_it_writes(value: float) -> None:
    quantity = Quantity("m", -1e6, 1e6, bare=10.0)
    assert quantity.parse(quantity.as_written(value)) == value


def test_every_key_suffix_is_a_unit() -> None:
    units = {"km/h": "m/s", "mm": "m", "deg": "rad", "mrad": "rad", "kN": "N", "kN m": "N m", "t": "kg", "ms": "s",
             "GPa": "Pa"}  # fmt: skip
    for unit in KEY_SUFFIXES.values():
        assert Quantity(units.get(unit, unit), 0.0, 1e12).parse(f"1 {unit}") > 0


@pytest.mark.parametrize(("unit", "si_unit"), units._KNOWN)
def test_a_unit_read_without_pint_is_that_of_pint(unit: str, si_unit: str) -> None:
    assert units._KNOWN[unit, si_unit] == units._factor_by_pint(unit, si_unit)


@pytest.mark.parametrize(
    ("quantity", "value", "text"),
    [
        (Quantity("m/s", 0.0, 200.0, bare=10.0), 100 / 3.6, "100 km/h"),
        (Quantity("m/s", 0.0, 200.0, bare=10.0), 60.0, "60 m/s"),
        (Quantity("m/s", 0.0, 200.0, bare=10.0), 41.2345678901234, "41.2345678901234 m/s"),
        (Quantity("m", 0.0, 1e6, bare=10.0), 500.0, "500 m"),
    ],
)
def test_a_number_that_needs_its_unit_is_written_in_the_shortest_text(
    quantity: Quantity, value: float, text: str
) -> None:
    assert quantity.as_written(value) == text
    assert quantity.parse(text) == value


@pytest.mark.parametrize("unit", ["rpm", "1/min", "rev/min", "U/min", "min^-1"])
def test_a_speed_of_turning_per_minute_is_one_of_turns(unit: str) -> None:
    assert float(units.unit_factor(unit, "rad/s")) == pytest.approx(math.pi / 30.0)
    assert units.unit_factor("Hz", "rad/s") is None  # turns or radians
    assert units.unit_factor("1/min", "1/s") == pytest.approx(1.0 / 60.0)
