"""Reported quantities: one registry per study, from which summary.json, tables, CSV files and the reference page follow.

numbers by key -> [Quantities] -> checked and finite -> summary.json, tables of the report, rows of CSV files, documentation
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from rollerrig.results.quantities import Quantity as Quantity
from rollerrig.results.quantities import registered
from rollerrig.study.report import Table

Numbers = Mapping[str, Any]


COMMON = (
    Quantity("quick", "there and true: few and short runs, whose numbers only show that everything works"),
    Quantity("interrupted", "whether Ctrl-C ended the study early; what is missing was not computed"),
    Quantity("rollerrig_version", "version of this program"),
    Quantity("keys.**", "key of this file -> meaning and unit; `*` stands for a name"),
)


class Quantities:
    """The registry of a study."""

    def __init__(self, *quantities: str | Quantity | Iterable[Quantity]) -> None:
        """Collect quantities, groups of them, or all that are registered for a command, in the order of the reference."""
        self._all: list[Quantity] = []
        for one in quantities:
            self._all += [one] if isinstance(one, Quantity) else registered(one) if isinstance(one, str) else one

    def __iter__(self) -> Iterator[Quantity]:
        """The quantities in order."""
        return iter(self._all)

    def __getitem__(self, key: str) -> Quantity:
        """The quantity of a key, or the first whose last name it is; else a KeyError."""
        for found in (*(q for q in self._all if q.key == key), *(q for q in self._all if q.name == key)):
            return found
        raise KeyError(key)

    def below(self, prefix: str) -> list[Quantity]:
        """Those whose key begins with this and a dot."""
        return [quantity for quantity in self._all if quantity.key.startswith(f"{prefix}.")]

    def described(self) -> dict[str, str]:
        """Key -> meaning and unit, for summary.json and the reference page."""
        return {quantity.key: quantity.description for quantity in (*self._all, *COMMON)}

    def table(
        self,
        entries: Mapping[str, Numbers] | Sequence[Numbers],
        names: Sequence[str] | str,
        caption: str = "",
        head: str = "",
    ) -> Table:
        """A row per entry, a column per quantity.

        Args:
            entries: numbers by name, or by key where several have one name; label of the row -> numbers where rows have one.
            names: of the quantities shown, or the prefix of all that some entry has; what an entry lacks is a dash.
            caption: of the table.
            head: of the column of labels.
        """
        given = list(entries.values() if isinstance(entries, Mapping) else entries)
        columns = self._chosen(names, given)
        header: Sequence[str] = [quantity.heading for quantity in columns]
        rows = [[quantity.cell(_value(one, quantity)) for quantity in columns] for one in given]
        if isinstance(entries, Mapping):
            header = (head, *header)
            rows = [[label.replace("_", " "), *row] for label, row in zip(entries, rows, strict=True)]
        return Table(header, rows, caption)

    def list_table(self, entries: Mapping[str, Numbers], names: Sequence[str] | str, caption: str = "") -> Table:
        """A row per quantity, a column per entry; arguments as `table`."""
        chosen = self._chosen(names, entries.values())
        rows = [[q.heading, *(q.cell(_value(values, q)) for values in entries.values())] for q in chosen]
        return Table(("", *(label.replace("_", " ") for label in entries)), rows, caption)

    def said(self, entry: Numbers, names: Sequence[str] | str) -> str:
        """Values in a sentence, 'distance 312.4 m, slip 2.1 %'; arguments as `table`, what an entry lacks is left out."""
        known = [(q, value) for q in self._chosen(names, [entry]) if (value := _value(entry, q)) is not None]
        cells = [f"{q.label or q.in_words} {q.cell(value)} {q.shown_unit}" for q, value in known]
        return ", ".join(cell.removesuffix(" 1").rstrip() for cell in cells)

    def csv(self, rows: Iterable[Numbers], names: Sequence[str] | str) -> list[list[object]]:
        """Rows of a CSV file, header first; every name must be registered."""
        chosen = self.below(names) if isinstance(names, str) else [self[name] for name in names]
        header: list[object] = [quantity.name for quantity in chosen]
        return [header, *([row.get(str(name)) for name in header] for row in rows)]

    def _chosen(self, names: Sequence[str] | str, entries: Iterable[Numbers]) -> list[Quantity]:
        if not isinstance(names, str):
            return [self[name] for name in names]
        known = set().union(*entries)
        return [quantity for quantity in self.below(names) if not known.isdisjoint((quantity.key, quantity.name))]


def _value(entry: Numbers, quantity: Quantity) -> Any:
    """Value by whole key, or by last name; of the mean of an ensemble with its interval."""
    of_ensemble = quantity.key.removesuffix(".mean").rpartition(".")[2]
    if quantity.name == "mean" and of_ensemble in entry:
        return entry[of_ensemble]
    return entry.get(quantity.key, entry.get(quantity.name))


def finite(value: Any) -> Any:
    """A summary as JSON takes it: None for what is no finite number, plain Python numbers and lists."""
    if isinstance(value, Mapping):
        return {str(key): finite(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [finite(inner) for inner in value]
    if isinstance(value, np.ndarray | np.generic):
        return finite(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value
