"""What to cite: the program, the paper, and the sources of the models and data in a run or a case, as BibTeX.

run, case or nothing, catalog/sources.bib -> [cite] -> BibTeX, an entry per source
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path

import xarray as xr

from rollerrig import __version__
from rollerrig.cases import as_case
from rollerrig.config import Case, case_from_toml
from rollerrig.config.read.library import CATALOG_FOLDER

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
    contact = case.contact
    for law in (contact.normal.kind, contact.creep.kind):
        yield from _LAWS[law]
    if case.adhesion or contact.friction.kind == "falling":
        yield "polach2005"
    if "Iwnicki" in case.vehicle.data.source:
        yield "iwnicki1999"


@cache
def entries() -> dict[str, str]:
    """BibTeX of every source by its key."""
    text = (CATALOG_FOLDER / "sources.bib").read_text(encoding="utf-8").replace("{VERSION}", f"{{{__version__}}}")
    return {entry.partition("{")[2].partition(",")[0]: entry.strip() for entry in text.split("\n\n")}
