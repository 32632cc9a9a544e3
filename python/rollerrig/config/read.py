"""Where the files are that ship, and TOML documents as raw tables.

name or path -> [read_document] -> raw tables + the file's label and folder, or ConfigError
"""

import tomllib
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Any, Literal

from rollerrig.common.input_files import LARGEST_TEXT, read_input
from rollerrig.config.errors import ConfigError, ConfigProblem, nearest

CatalogKind = Literal["vehicle", "support", "profile", "material", "case", "programme", "plan", "fit"]

CATALOG_FOLDER = Path(__file__).parents[1] / "catalog"


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


NO_SUCH_FILE = "no such file"
MOST_FILES = 1000
"""Largest number of files of a folder that are looked at for a name that is near."""


@dataclass(frozen=True)
class Document:
    """Raw tables and where they came from."""

    raw: dict[str, Any]  # the tables as TOML gives them
    file: str  # the file as messages name it
    folder: Path  # relative paths in the document start here


def read_document(kind: CatalogKind, name: str | Path, folder: Path | None = None) -> Document:
    """Read the catalogue entry or file ``name``.

    A text without a slash and without the suffix .toml is first looked up in the catalogue.

    Args:
        kind: which part of the catalogue is meant.
        name: catalogue name or path.
        folder: where a relative path starts; the current folder by default.

    Raises:
        ConfigError: there is no such file or entry, or it is not TOML.
    """
    text = str(name)
    is_name = isinstance(name, str) and "/" not in text and "\\" not in text and not text.endswith(".toml")
    if is_name and text in catalog_names(kind):
        path, label = catalog_file(kind, text), f"{text} (catalogue)"
    else:
        path, label = (folder or Path()) / text, text
    try:
        content = read_input(path, LARGEST_TEXT).decode("utf-8")
    except (FileNotFoundError, NotADirectoryError):
        raise ConfigError([_missing(path, label, kind)]) from None
    except UnicodeDecodeError as error:
        raise ConfigError.of(label, "", f"byte {error.start} is not UTF-8", "allowed: a text") from None
    except OSError as error:
        reason, allowed = error.strerror or str(error), "allowed: a TOML file that can be read"
        raise ConfigError.of(label, "", reason, allowed) from None
    return parse_document(content, label, path.parent)


def parse_document(text: str, file: str, folder: Path | None = None) -> Document:
    """The document in ``text``.

    Raises:
        ConfigError: it is not TOML.
    """
    try:
        return Document(tomllib.loads(text), file, folder or Path())
    except tomllib.TOMLDecodeError as error:
        raise ConfigError.of(file, "", "not TOML", str(error)) from None
    except (ValueError, RecursionError) as error:  # an integer of thousands of digits; brackets nested beyond reason
        raise ConfigError.of(file, "", "not TOML that can be read", str(error)) from None


def _missing(path: Path, label: str, kind: CatalogKind) -> ConfigProblem:
    """A file that does not exist, with the one beside it or in the catalogue that was probably meant."""
    names = catalog_names(kind)
    if path.suffix != ".toml" and path.name == label:  # meant as a name
        allowed = f"allowed: a TOML file, or a {kind} of the catalogue: {', '.join(names)}"
        return ConfigProblem(label, "", NO_SUCH_FILE, allowed, nearest(label, names))
    folder = path.parent
    if not folder.is_dir():
        return ConfigProblem(label, "", NO_SUCH_FILE, f"there is no folder '{folder}'")
    beside = {file.stem: str(Path(label).parent / file.name) for file in islice(folder.glob("*.toml"), MOST_FILES)}
    near = nearest(path.name.removesuffix(".toml"), tuple(beside))
    shown = beside[near] if near else nearest(path.name.removesuffix(".toml"), names)
    allowed = f"allowed: a TOML file that exists, or a {kind} that `rollerrig catalog` lists"
    return ConfigProblem(label, "", NO_SUCH_FILE, allowed, shown)
