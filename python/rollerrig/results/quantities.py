"""Reported quantities: the one registry that summaries, tables, CSV files, sweeps and the reference page name.

    quantities.toml -> [registered] -> Quantity: key, unit, meaning, label, digits

A table of the file belongs to a command, or is a group that others take in. An entry is the meaning with its unit in brackets at
the end, or a table: `is` (that text), `of` (an entry of another table, `group.key`, whose fields it takes), and fields of
Quantity. `group` takes a group in below the key; `each` the named entries of a group, each with the `ends` of an ensemble.
"""

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from rollerrig.common.formatting import number


@dataclass(frozen=True)
class Quantity:
    """One reported quantity."""

    key: str  # its place in summary.json, names joined by dots; `*` stands for one name, a final `**` for all below
    meaning: str  # a sentence fragment
    unit: str = ""  # of the number in summary.json; "": text or a flag, "1": a ratio
    label: str = ""  # in tables; absent: the last name of the key
    digits: int = 4  # significant digits in tables
    # unit and factor in tables where another unit reads better, e.g. ("%", 100.0)
    shown: tuple[str, float] | None = None
    least: float = 0.0  # what is smaller is round-off, zero in tables; in `unit`

    @property
    def name(self) -> str:
        """Last name of the key."""
        return self.key.rpartition(".")[2]

    @property
    def heading(self) -> str:
        """Label with the unit that tables show."""
        unit = {"": "", "1": " [-]"}.get(self.shown_unit, f" [{self.shown_unit}]").replace("^2", "²").replace("^3", "³")
        return (self.label or self.in_words) + unit

    @property
    def in_words(self) -> str:
        """Last name of the key without the unit that it ends in."""
        name = self.name.removesuffix(f"_{_in_a_key(self.unit)}") if self.unit not in ("", "1") else self.name
        return " ".join(_CAPITALS.get(word, word) for word in name.split("_"))

    @property
    def shown_unit(self) -> str:
        """Unit in tables."""
        return self.shown[0] if self.shown else self.unit

    @property
    def description(self) -> str:
        """Meaning with the unit of summary.json."""
        return f"{self.meaning} [{'-' if self.unit == '1' else self.unit}]" if self.unit else self.meaning

    def in_shown_unit(self, value: float) -> float:
        """A value in the unit that tables show; what is round-off is zero."""
        return (self.shown[1] if self.shown else 1.0) * (0.0 if abs(value) < self.least else float(value))

    def cell(self, value: Any) -> object:
        """A value, or a mean with its interval, as tables show it; a dash where there is none."""
        if value is None:
            return "–"
        if isinstance(value, Mapping):
            # of an ensemble: mean, and both ends of its interval where they are known and differ
            mean, low, high = (self.cell(value[end]) for end in ("mean", "low", "high"))
            return mean if "–" in (mean, low, high) or low == high else f"{mean} ({low} … {high})"
        if isinstance(value, bool | np.bool_):
            return "yes" if value else "no"
        if isinstance(value, str):
            return value.replace("_", " ")
        if isinstance(value, int | np.integer) and self.shown is None:
            return number(int(value))
        return number(self.in_shown_unit(value), self.digits)

    def told(self, value: Any) -> str:
        """The same with its unit, as sentences have it."""
        unit = "" if self.shown_unit == "1" else self.shown_unit.replace("^2", "²")
        return f"{self.cell(value)} {unit}".rstrip()

    def matches(self, path: Sequence[str]) -> bool:
        """Whether a place in summary.json is this quantity's."""
        pattern = self.key.split(".")
        if pattern[-1] == "**":
            pattern, path = pattern[:-1], path[: len(pattern) - 1]
        return len(pattern) == len(path) and all(p in ("*", name) for p, name in zip(pattern, path, strict=True))


_CAPITALS = {"rms": "RMS", "q": "Q", "y": "Y"}
_KEY_UNITS = {"°": "deg", "%": "percent", "l": "litres", "1/s": "per_s", "1/mm": "per_mm"}


def _in_a_key(unit: str) -> str:
    """A unit as keys spell it: 'N m' is nm, 'km/h' kmh, 'm/s' mps, 'rad/s' rad_per_s, 'N s/m' ns_per_m."""
    plain = _KEY_UNITS.get(unit, unit.replace("µ", "u").replace(" ", "").lower())
    if plain == "km/h":
        return "kmh"
    over = "p" if plain in ("m/s", "mm/s") else "_per_"
    return plain.replace("/", over)


def registered(table: str, prefix: str = "", note: str = "") -> Iterator[Quantity]:
    """The quantities of a table of quantities.toml, in its order; `note` stands for {note} in meanings."""
    for key, entry in _registry()[table].items():
        fields = {} if isinstance(entry, str) else entry
        if "group" in fields:
            yield from registered(entry["group"], f"{prefix}{key}", entry.get("note", ""))
        elif "each" in fields:
            for name in entry["names"]:
                yield from _ends(_quantity(name, _registry()[entry["each"]][name], ""), f"{prefix}{key}", entry["ends"])
        else:
            yield _quantity(f"{prefix}{key}", entry, note)


def _ends(one: Quantity, prefix: str, ends: Mapping[str, str]) -> Iterator[Quantity]:
    """A quantity of an ensemble: its mean, and what else is known of it."""
    for end, meaning in ends.items():
        whole = f"{one.meaning}; {meaning}" if end == "mean" else meaning
        yield Quantity(f"{prefix}{one.key}.{end}", whole, one.unit, one.label or one.in_words, one.digits, one.shown)


def _quantity(key: str, entry: str | Mapping[str, Any], note: str) -> Quantity:
    fields: dict[str, Any] = {"is": entry} if isinstance(entry, str) else dict(entry)
    if "of" in fields:
        group, _, name = fields.pop("of").partition(".")
        other = _registry()[group][name]
        fields = ({"is": other} if isinstance(other, str) else dict(other)) | fields
    text = fields.pop("is").replace("{note}", note)
    found = re.fullmatch(r"(.*) \[([^\[\]]+)\]", text, re.DOTALL)
    meaning, unit = found.groups() if found else (text, "")
    shown = fields.pop("shown", None)
    return Quantity(key, meaning, "1" if unit == "-" else unit, shown=(shown[0], shown[1]) if shown else None, **fields)


@cache
def _registry() -> dict[str, dict[str, Any]]:
    return tomllib.loads(files("rollerrig.results").joinpath("quantities.toml").read_text(encoding="utf-8"))
