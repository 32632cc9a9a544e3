"""Adhesion of a rail from a file over distance: pieces in place of `file`.

    [adhesion] file = "map.csv", rail -> rows -> [adhesion] rail, piece, blend

A row has `distance [m]`, or `distance_m`, and `friction` or `condition`. Friction, at no slip, is that of points evenly apart,
as `rollerrig reconstruct` writes `adhesion_map.csv`: it passes smoothly from one to the next, all else is that of `rail`.
A condition, by name, begins at its row; before the first one the rail is `rail`.
"""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rollerrig.common.input_files import LARGEST_TEXT, read_input
from rollerrig.config.errors import ConfigProblem, nearest, show_value
from rollerrig.config.schema.adhesion import CONDITIONS

_DISTANCES = ("distance [m]", "distance_m")
_EVEN = 1e-6
"""Round-off of distances that a file states, over their spacing."""
_MOST_ROWS = 10_000


def read_adhesion_file(raw: Mapping[str, Any], file: str, folder: Path) -> tuple[dict[str, Any], list[ConfigProblem]]:
    """Table [adhesion] of a case with the rows of its `file` in place of that key; with what is wrong with them."""
    table = dict(raw)
    name, key = table.pop("file"), "adhesion.file"
    if not isinstance(name, str) or not name or "\0" in name:
        return table, [ConfigProblem(file, key, show_value(name), "allowed: a CSV file, relative to this one")]
    if table.get("piece"):
        return table, [ConfigProblem(file, "adhesion.piece", "given", "allowed without adhesion.file")]
    try:
        return {**table, **_pieces(table, _rows(folder / name))}, []
    except OSError as error:
        return table, [ConfigProblem(file, key, show_value(name), f"not read: {error.strerror}")]
    except ValueError as error:
        return table, [ConfigProblem(file, key, show_value(name), str(error))]


def rail_of_points(
    rail: Mapping[str, Any], places: Sequence[float], values: Sequence[float], spacing: float
) -> dict[str, Any]:
    """Rail, pieces and blend of [adhesion] whose friction at no slip passes smoothly from point to point.

    Args:
        rail: condition that has all but this friction, as a table.
        places: of the points, evenly apart [m]; before the first and behind the last friction stays.
        values: friction at no slip there.
        spacing: of the points [m].
    """

    def condition(mu: float) -> dict[str, Any]:
        return {**rail, "friction": {**rail["friction"], "mu_0": float(mu)}}

    pieces = [{"distance": float(s), "rail": condition(mu)} for s, mu in zip(places[:-1], values[1:], strict=True)]
    return {"rail": condition(values[0]), "piece": pieces, "blend": spacing}


def _rows(path: Path) -> list[dict[str, str]]:
    try:
        text = read_input(path, LARGEST_TEXT).decode("utf-8-sig")
        lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
        head, *rows = csv.reader(lines)
    except (csv.Error, ValueError):
        raise ValueError("no table: needed is a heading and a row for each place, separated by commas") from None
    names = [name.strip() for name in head]
    if len(names) == 1 and ";" in names[0]:
        raise ValueError("cells are separated by ';'; needed: commas between cells, and points in numbers")
    for number, row in enumerate(rows, 1):
        if len(row) != len(names):
            raise ValueError(f"row {number}: {len(row)} cells; needed: {len(names)}, as in the heading")
    if not 2 <= len(rows) <= _MOST_ROWS:
        raise ValueError(f"{len(rows)} rows; allowed: 2 to {_MOST_ROWS}")
    return [dict(zip(names, map(str.strip, row), strict=True)) for row in rows]


def _pieces(table: Mapping[str, Any], rows: list[dict[str, str]]) -> dict[str, Any]:
    """Keys of [adhesion] that say what the rows say."""
    at = next((name for name in _DISTANCES if name in rows[0]), None)
    kinds = [name for name in ("friction", "condition") if name in rows[0]]
    if at is None or len(kinds) != 1:
        raise ValueError(f"columns {', '.join(rows[0])}; needed: '{_DISTANCES[0]}', and 'friction' or 'condition'")
    places = _numbers(rows, at)
    for number, (a, b) in enumerate(zip(places, places[1:], strict=False), 2):
        if not b > a:
            raise ValueError(f"row {number}: {b:g} m follows {a:g} m; allowed: distances that rise")
    if kinds == ["condition"]:
        return _conditions(places, [row["condition"] for row in rows])
    step = places[1] - places[0]
    for number, (a, b) in enumerate(zip(places, places[1:], strict=False), 2):
        if abs(b - a - step) > _EVEN * max(step, abs(b)):
            raise ValueError(f"row {number}: {b:g} m follows {a:g} m, a gap; allowed: rows {step:g} m apart")
    friction = _numbers(rows, "friction")
    for number, mu in enumerate(friction, 1):
        if not 0.0 <= mu <= 1.0:
            raise ValueError(f"row {number}: friction {mu:g}; allowed: 0 to 1")
    return rail_of_points(_template(table), places, friction, step)


def _template(table: Mapping[str, Any]) -> Mapping[str, Any]:
    """The condition of [adhesion] rail as a table: a name stands for one, a number for constant friction."""
    rail = table.get("rail")
    found = CONDITIONS.get(rail) if isinstance(rail, str) else rail
    friction = found.get("friction") if isinstance(found, Mapping) else None
    if isinstance(found, Mapping) and isinstance(friction, int | float):
        return {**found, "friction": {"kind": "constant", "mu_0": friction}}
    if not isinstance(found, Mapping) or not isinstance(friction, Mapping):
        raise ValueError("needs adhesion.rail, the condition whose friction at no slip the file gives")
    return found


def _conditions(places: Sequence[float], names: Sequence[str]) -> dict[str, Any]:
    for number, name in enumerate(names, 1):
        if name not in CONDITIONS:
            guess = nearest(name, tuple(CONDITIONS))
            hint = f"; did you mean '{guess}'?" if guess else ""
            raise ValueError(f"row {number}: '{name}'; allowed: {', '.join(CONDITIONS)}{hint}")
    return {"piece": [{"distance": s, "rail": name} for s, name in zip(places, names, strict=True)]}


def _numbers(rows: Sequence[Mapping[str, str]], name: str) -> list[float]:
    found = []
    for number, row in enumerate(rows, 1):
        try:
            found.append(float(row[name]))
        except ValueError:
            raise ValueError(f"row {number}, column '{name}': '{row[name]}' is no number") from None
    return found
