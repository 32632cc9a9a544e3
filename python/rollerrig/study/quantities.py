"""Reported quantities: one registry per study, from which summary.json, tables, CSV files and the reference page follow.

numbers by key -> [Quantities] -> checked and finite -> summary.json, tables of the report, rows of CSV files, documentation
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rollerrig.study.report import Table
from rollerrig.wording import number

Numbers = Mapping[str, Any]


@dataclass(frozen=True)
class Quantity:
    """One reported quantity.

    Attributes:
        key: its place in summary.json, names joined by dots; `*` stands for one name, a final `**` for all below.
        meaning: a sentence fragment.
        unit: of the number in summary.json; "": text or a flag, "1": a ratio.
        label: in tables; absent: the last name of the key.
        digits: significant digits in tables.
        shown: unit and factor in tables where another unit reads better, e.g. ("%", 100.0).
        least: what is smaller is round-off, zero in tables; in `unit`.
    """

    key: str
    meaning: str
    unit: str = ""
    label: str = ""
    digits: int = 4
    shown: tuple[str, float] | None = None
    least: float = 0.0

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

    def cell(self, value: Any) -> object:
        """A value as tables show it; a dash where there is none."""
        if value is None:
            return "–"
        if isinstance(value, bool | np.bool_):
            return "yes" if value else "no"
        if isinstance(value, str):
            return value.replace("_", " ")
        if isinstance(value, int | np.integer) and self.shown is None:
            return number(int(value))
        size = 0.0 if abs(value) < self.least else float(value)
        return number((self.shown[1] if self.shown else 1.0) * size, self.digits)

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


COMMON = (
    Quantity("quick", "there and true: few and short runs, whose numbers only show that everything works"),
    Quantity("interrupted", "whether Ctrl-C ended the study early; what is missing was not computed"),
    Quantity("rollerrig_version", "version of this program"),
    Quantity("keys.**", "key of this file -> meaning and unit; `*` stands for a name"),
)


class Quantities:
    """The registry of a study."""

    def __init__(self, *quantities: Quantity | Iterable[Quantity]) -> None:
        """Collect quantities, or groups of them, in the order of the reference page."""
        self._all: list[Quantity] = []
        for one in quantities:
            self._all += [one] if isinstance(one, Quantity) else list(one)

    def __iter__(self) -> Iterator[Quantity]:
        """The quantities in order."""
        return iter(self._all)

    def __getitem__(self, key: str) -> Quantity:
        """The quantity of a key, or the first whose last name it is.

        Raises:
            KeyError: there is none.
        """
        for found in (*(q for q in self._all if q.key == key), *(q for q in self._all if q.name == key)):
            return found
        raise KeyError(key)

    def described(self) -> dict[str, str]:
        """Key -> meaning and unit, for summary.json and the reference page."""
        return {quantity.key: quantity.description for quantity in (*self._all, *COMMON)}

    def unexplained(self, numbers: Numbers) -> list[str]:
        """Keys of a summary that the registry does not explain."""
        known = (*self._all, *COMMON)
        return [".".join(path) for path in _leaves(numbers, ()) if not any(q.matches(path) for q in known)]

    def unreported(self, numbers: Numbers) -> list[str]:
        """Keys of the registry that a summary has nothing for."""
        places = list(_leaves(numbers, ()))
        return [quantity.key for quantity in self._all if not any(quantity.matches(path) for path in places)]

    # ------------------------------------------------------------------------------------------------ tables

    def table(
        self,
        entries: Mapping[str, Numbers] | Sequence[Numbers],
        names: Sequence[str],
        caption: str = "",
        head: str = "",
    ) -> Table:
        """A row per entry, a column per quantity.

        Args:
            entries: numbers by name, or by key where several have one name; label of the row -> numbers where rows have one.
            names: of the quantities shown; what an entry lacks is a dash.
            caption: of the table.
            head: of the column of labels.
        """
        columns = [self[name] for name in names]
        if not isinstance(entries, Mapping):
            return Table(
                [q.heading for q in columns], [[q.cell(_value(one, q)) for q in columns] for one in entries], caption
            )
        rows = [
            [label.replace("_", " "), *(q.cell(_value(values, q)) for q in columns)]
            for label, values in entries.items()
        ]
        return Table((head, *(q.heading for q in columns)), rows, caption)

    def list_table(self, entries: Mapping[str, Numbers], names: Sequence[str], caption: str = "") -> Table:
        """A row per quantity, a column per entry; arguments as `table`."""
        rows = [
            [self[name].heading, *(self[name].cell(_value(values, self[name])) for values in entries.values())]
            for name in names
        ]
        return Table(("", *(label.replace("_", " ") for label in entries)), rows, caption)

    def csv(self, rows: Iterable[Numbers], names: Sequence[str]) -> list[list[object]]:
        """Rows of a CSV file, header first; every name must be registered."""
        header: list[object] = [self[name].name for name in names]
        return [header, *([row.get(str(name)) for name in header] for row in rows)]


def _value(entry: Numbers, quantity: Quantity) -> Any:
    """By whole key, or by last name."""
    return entry.get(quantity.key, entry.get(quantity.name))


def _leaves(value: Any, path: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """Places of all that is no table; items of a list of tables are named by their number."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _leaves(inner, (*path, str(key)))
    elif isinstance(value, list) and any(isinstance(item, Mapping) for item in value):
        for k, item in enumerate(value):
            yield from _leaves(item, (*path, str(k)))
    else:
        yield path


def finite(value: Any) -> Any:
    """A summary as JSON takes it: None for what is no finite number, plain Python numbers and lists."""
    if isinstance(value, Mapping):
        return {str(key): finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [finite(inner) for inner in value]
    if isinstance(value, np.ndarray | np.generic):
        return finite(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value
