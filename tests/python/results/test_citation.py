"""What to cite."""

from __future__ import annotations

import json
import re

import pytest
import xarray as xr

import rollerrig as rr
from rollerrig.config.schema.contact import Law
from rollerrig.results.run_info import entries, sources_of


def keys(text: str) -> list[str]:
    return re.findall(r"^@[a-z]+\{([a-z0-9]+),$", text, re.MULTILINE)


def test_every_law_has_its_sources() -> None:
    """But for Coulomb's friction; and it says what it leaves out."""
    assert all(law.limitation for law in Law.__subclasses__())
    assert [law.__name__ for law in Law.__subclasses__() if not law.sources] == ["ConstantFriction"]
    assert {key for law in Law.__subclasses__() for key in law.sources} <= set(entries())


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


def test_a_run_names_the_laws_that_it_was_made_with() -> None:
    """What a run and a report say is from the list that BibTeX is made of."""
    case = rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.02 s"})
    found = json.loads(rr.simulate(case).attrs["sources"])
    assert found == sources_of(case)
    assert found.keys() == {"model", "normal contact, strips", "creep law, table", "vehicle", "support"}
    assert found["model"].startswith("M. Malvezzi, E. Meli, L. Pugi (2010), Simulation of degraded wheel/rail adhesion")
    assert found["normal contact, strips"].startswith("K. L. Johnson (1985), Contact Mechanics; J. Piotrowski, W. Kik")
    assert "Hertz (1882)" not in str(found)
    paper = case.with_changes({"contact.normal": "hertz", "contact.creep": "kalker_saturated"})
    assert sources_of(paper)["normal contact, hertz"] == "H. Hertz (1882), Über die Berührung fester elastischer Körper"
    assert "Polach" in sources_of(rr.load_case("adhesion_brake"))["friction falling with sliding"]


def test_what_is_no_run_is_refused() -> None:
    with pytest.raises(ValueError, match="do not say which case"):
        rr.cite(xr.Dataset())
