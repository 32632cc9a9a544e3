"""What to cite: the program, the paper, and the sources of the models and data in a run or a case, as BibTeX.

run, case or nothing, catalog/sources.bib -> [cite] -> BibTeX, an entry per source
Case -> [sources_of] -> what -> publication in words, for runs and reports
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from unicodedata import normalize

import xarray as xr

from rollerrig import __version__
from rollerrig.cases import as_case
from rollerrig.config import Case, case_from_toml
from rollerrig.config.read import CATALOG_FOLDER

ALWAYS = ("rollerrig", "malvezzi2010")
"""Cited whatever was computed."""

_LAWS = {
    "hertz": ("hertz1882",),
    "strips": ("johnson1985", "piotrowski2008"),
    "kalker_linear": ("kalker1990",),
    "kalker_saturated": ("kalker1990", "vermeulen1964"),
    "fastsim": ("kalker1982",),
    "modified_fastsim": ("kalker1982", "spiryagin2013"),
    "polach": ("polach1999", "polach2005"),
    "table": ("kalker1990",),
    "strip_theory": ("kalker1990", "sichani2016"),
}
"""Law of the contact -> its sources."""


def cite(what: xr.Dataset | Case | str | Path | None = None) -> str:
    """BibTeX of the program and the paper, and of the models and data in a run or a case.

    Args:
        what: results of `simulate`, a case, or its name or file; None: only the program and the paper.

    Raises:
        ConfigError: there is no such case.
        ValueError: the Dataset is no run.

    Example:
        >>> print(cite()[:20])
        @software{rollerrig,
    """
    case = _case_of(what)
    keys = dict.fromkeys((*ALWAYS, *(sources(case) if case else ())))
    return "\n\n".join(entries()[key] for key in keys) + "\n"


def _case_of(what: xr.Dataset | Case | str | Path | None) -> Case | None:
    if what is None:
        return None
    if not isinstance(what, xr.Dataset):
        return as_case(what)
    if "config_toml" not in what.attrs:
        raise ValueError(
            "these results do not say which case they are of; needed: a run, as simulate and load_run give it"
        )
    return case_from_toml(what.attrs["config_toml"], allow_code=True)


def sources(case: Case) -> Iterator[str]:
    """Keys of the entries behind a case."""
    for keys in _keys(case).values():
        yield from keys
    if "Iwnicki" in case.vehicle.data.source:
        yield "iwnicki1999"


def _keys(case: Case) -> dict[str, tuple[str, ...]]:
    """Model of the contact in a case -> keys of its entries."""
    contact = case.contact
    kinds = {"normal contact": contact.normal.kind, "creep law": contact.creep.kind}
    found = {f"{what}, {kind.replace('_', ' ')}": _LAWS[kind] for what, kind in kinds.items()}
    falling = case.adhesion or contact.friction.kind == "falling"
    return found | ({"friction falling with sliding": ("polach2005",)} if falling else {})


def sources_of(case: Case) -> dict[str, str]:
    """What -> publication: of the model, the laws of its contact, the vehicle and the support."""
    laws = {what: "; ".join(map(in_words, keys)) for what, keys in _keys(case).items()}
    data = {"vehicle": case.vehicle.data.source, "support": case.support.data.source}
    return {"model": in_words(ALWAYS[1]), **laws, **data}


def in_words(key: str) -> str:
    """An entry as a report shows it: 'O. Polach (2005), Creep forces in ...'."""
    fields = dict(re.findall(r"^  (\w+) = \{(.*)\},$", entries()[key], re.MULTILINE))
    people = [one.partition(", ") for one in (fields.get("author") or fields["editor"]).split(" and ")]
    names = (" ".join([*(f"{name[0]}." for name in first.split()), last]) for last, _, first in people)
    text = f"{', '.join(names)} ({fields['year']}), {fields['title']}".replace("\\&", "&")
    text = re.sub(r'\{\\"(\w)\}', lambda found: normalize("NFC", f"{found[1]}\u0308"), text)
    return text.replace("{", "").replace("}", "")


@cache
def entries() -> dict[str, str]:
    """BibTeX of every source by its key."""
    text = (CATALOG_FOLDER / "sources.bib").read_text(encoding="utf-8").replace("{VERSION}", f"{{{__version__}}}")
    return {entry.partition("{")[2].partition(",")[0]: entry.strip() for entry in text.split("\n\n")}
