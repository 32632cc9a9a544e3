"""Read a file of any kind, known by its keys.

name or path -> [load_any] -> what kind it is, and what it describes
"""

from collections.abc import Callable
from pathlib import Path

from rollerrig.config.load import case
from rollerrig.config.load.fit import load_fit
from rollerrig.config.load.plan import load_plan
from rollerrig.config.read import CatalogKind
from rollerrig.config.schema.base import Table

LOADERS: dict[CatalogKind, Callable[[str | Path], Table]] = {
    "vehicle": case.load_vehicle,
    "support": case.load_support,
    "material": case.load_material,
    "profile": case.load_profile,
    "programme": case.load_programme,
}


def load_any(source: str | Path, *, allow_code: bool = False) -> tuple[CatalogKind, Table]:
    """Read a catalogue entry or file of any kind and say which it is by its keys.

    Args:
        source: name in the catalogue, or path of a TOML file.
        allow_code: whether controllers that a case names may lie outside its own folder; none is run here.

    Raises:
        ConfigError: all mistakes found.
    """
    kind, document = case.read_known(source)
    if kind in LOADERS:
        return kind, LOADERS[kind](source)
    if kind == "plan":
        return kind, load_plan(document, allow_code=allow_code).plan
    if kind == "fit":
        return kind, load_fit(document, allow_code=allow_code).plan
    return kind, case.build_case(document, own_folder=document.folder, allow_code=allow_code)
