"""Vehicles, rigs, tracks, materials, profiles, cases, test programmes and plans of sweeps that ship.

Each is a TOML file; all but cases and plans say where their data come from.

Every entry can be copied to a file and edited: what it refers to by name is found in the catalogue from there too.
"""

import tomllib
from typing import get_args

from rollerrig.config.read import CatalogKind, catalog_file, catalog_names, schema_uri

KINDS: tuple[CatalogKind, ...] = get_args(CatalogKind)


def catalog_entries() -> list[tuple[CatalogKind, str, str]]:
    """All entries as (kind, name, one-line description).

    Example:
        >>> sorted({kind for kind, _, _ in catalog_entries()})
        ['case', 'fit', 'material', 'plan', 'profile', 'programme', 'support', 'vehicle']
    """
    names = [(kind, name) for kind in KINDS for name in catalog_names(kind)]
    tables = (tomllib.loads(catalog_file(*one).read_text("utf-8")) for one in names)
    return [(*one, str(table["description"])) for one, table in zip(names, tables, strict=True)]


def catalog_text(name: str) -> str:
    """The TOML text of an entry, to copy and edit; its first line leads editors to the JSON Schema of this installation.

    Raises:
        KeyError: no such entry.

    Example:
        >>> catalog_text("cone_1_20").splitlines()[-1]
        'conicity = "1:20"'
    """
    for kind in KINDS:
        if name in catalog_names(kind):
            return catalog_file(kind, name).read_text("utf-8").replace(f"../schema/{kind}.json", schema_uri(kind), 1)
    raise KeyError(f"nothing named '{name}' in the catalogue")


__all__ = ["KINDS", "CatalogKind", "catalog_entries", "catalog_file", "catalog_names", "catalog_text"]
