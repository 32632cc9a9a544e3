"""Where the data files that ship lie; `rollerrig.catalog` shows them to the user."""

from functools import lru_cache
from pathlib import Path
from typing import Literal

CatalogKind = Literal["vehicle", "support", "profile", "material", "case", "programme", "plan"]

CATALOG_FOLDER = Path(__file__).parents[2] / "catalog"


@lru_cache(maxsize=8)
def catalog_names(kind: CatalogKind) -> tuple[str, ...]:
    """Names of one kind, in alphabetical order."""
    return tuple(sorted(path.stem for path in (CATALOG_FOLDER / f"{kind}s").glob("*.toml")))


def catalog_file(kind: CatalogKind, name: str) -> Path:
    """The file of an entry.

    Raises:
        KeyError: no such entry.
    """
    if name not in catalog_names(kind):
        raise KeyError(f"no {kind} '{name}' in the catalogue; it has {', '.join(catalog_names(kind))}")
    return CATALOG_FOLDER / f"{kind}s" / f"{name}.toml"


def schema_file(kind: CatalogKind) -> Path:
    """JSON Schema of one kind of file, for editors; written by scripts/write_schemas.py."""
    return CATALOG_FOLDER / "schema" / f"{kind}.json"


def schema_uri(kind: CatalogKind) -> str:
    """Where editors find it on this machine."""
    return schema_file(kind).as_uri()
