"""What to cite."""

from __future__ import annotations

import re

import pytest
import xarray as xr

import rollerrig as rr
from rollerrig.config.schema.contact_law import CREEP_LAWS, NORMAL_LAWS
from rollerrig.results.citation import _LAWS, entries


def keys(text: str) -> list[str]:
    return re.findall(r"^@[a-z]+\{([a-z0-9]+),$", text, re.MULTILINE)


def test_every_law_has_its_sources() -> None:
    assert set(_LAWS) == {*CREEP_LAWS, *NORMAL_LAWS}
    assert {key for sources in _LAWS.values() for key in sources} <= set(entries())


def test_the_program_and_the_paper_are_always_cited() -> None:
    assert keys(rr.cite()) == ["rollerrig", "malvezzi2010"]
    assert f"version = {{{rr.__version__}}}" in rr.cite()


def test_a_case_and_its_run_cite_their_models() -> None:
    case = rr.load_case("wheelset_rollers").with_changes(
        {"time.duration": "0.02 s", "contact.creep": "kalker_saturated"}
    )
    text = rr.cite(case)
    assert keys(text)[2:] == ["johnson1985", "piotrowski2008", "kalker1990", "vermeulen1964", "iwnicki1999"]
    assert rr.cite(rr.simulate(case)) == text
    assert "polach2005" in keys(rr.cite("adhesion_brake"))
    assert text.count("{") == text.count("}")


def test_what_is_no_run_is_refused() -> None:
    with pytest.raises(ValueError, match="do not say which case"):
        rr.cite(xr.Dataset())
