"""Bodies and force elements that are written once and placed several times.

    one [[element]] with `at` and `both_sides` -> [placed] -> an [[element]] per place and side

`at.1 = {...}` of an element `primary` is `primary_1`, with the keys of that table in place of its own. `both_sides = true` makes
of it `primary_1_left`, as written, and `primary_1_right`, mirrored at the middle of the vehicle: y of its ends, and what its laws
along y, about x and about z do in one direction only.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from rollerrig.config.errors import ConfigProblem, join_key, show_value

AT, BOTH_SIDES = "at", "both_sides"
Raw = dict[str, Any]
Problems = list[ConfigProblem]

_ONE_SIDED = ("y", "roll", "yaw")
"""Directions that a mirror at the plane y = 0 turns round."""


def placed(raw: Mapping[str, Any], file: str) -> tuple[Raw, Problems]:
    """Tables of a vehicle in which every body and element has one place."""
    found, problems = dict(raw), Problems()
    for kind in ("body", "element"):
        items = raw.get(kind)
        if isinstance(items, list) and any(
            isinstance(item, Mapping) and item.keys() & {AT, BOTH_SIDES} for item in items
        ):
            found[kind] = []
            for item in items:
                mistakes = list(_mistakes(item, kind, file)) if isinstance(item, Mapping) else []
                problems += mistakes
                found[kind] += [item] if mistakes or not isinstance(item, Mapping) else _places(item)
    return found, problems


def _mistakes(item: Mapping[str, Any], kind: str, file: str) -> Iterator[ConfigProblem]:
    key = join_key(kind, str(item.get("name", "")))
    at, both = item.get(AT, {}), item.get(BOTH_SIDES, False)
    if (
        not isinstance(at, Mapping)
        or not all(isinstance(place, Mapping) for place in at.values())
        or (AT in item and not at)
    ):
        allowed = "allowed: a table of places by name, like at.front = { point = [9.5, 1.0, 0.8] }"
        yield ConfigProblem(file, f"{key}.{AT}", show_value(at), allowed)
    elif not isinstance(both, bool) or (both and kind == "body"):
        allowed = "allowed: true or false" if kind == "element" else "allowed: of elements only"
        yield ConfigProblem(file, f"{key}.{BOTH_SIDES}", show_value(both), allowed)
    elif both:
        for place, one in _at_places(item):
            ends = [one["point"]] if isinstance(one.get("point"), list) else one.get("points")
            listed = ends if isinstance(ends, list) else []  # what else it is, validation says
            sides = [end[1] for end in listed if isinstance(end, list) and len(end) == 3]
            if sides and all(_mirrored(y) == y for y in sides):
                allowed = "allowed with both_sides = true: a point with y other than 0"
                yield ConfigProblem(file, f"{join_key(key, place)}.point", show_value(ends), allowed)


def _at_places(item: Mapping[str, Any]) -> Iterator[tuple[str, Raw]]:
    """Each place's own table; an item without `at` is one place of no name."""
    once = {key: value for key, value in item.items() if key not in (AT, BOTH_SIDES)}
    for place, own in (item.get(AT) or {"": {}}).items():
        name = f"{item.get('name', '')}_{place}" if place else item.get("name")
        yield (f"{AT}.{place}" if place else ""), {**once, **({} if name is None else {"name": name}), **own}


def _places(item: Mapping[str, Any]) -> Iterator[Raw]:
    for _, one in _at_places(item):
        if item.get(BOTH_SIDES):
            yield {**one, "name": f"{one.get('name', '')}_left"}
            yield _on_the_right(one)
        else:
            yield one


def _on_the_right(one: Raw) -> Raw:
    """The element mirrored at the plane y = 0."""
    right = {**one, "name": f"{one.get('name', '')}_right"}
    if "point" in right:
        right["point"] = _mirrored_point(right["point"])
    if isinstance(right.get("points"), list):
        right["points"] = [_mirrored_point(point) for point in right["points"]]
    for direction in _ONE_SIDED:
        law = right.get(direction)
        if isinstance(law, Mapping):
            right[direction] = {key: _mirrored_law(key, value) for key, value in law.items()}
    return right


def _mirrored_law(key: str, value: Any) -> Any:
    """A preload turned round; a table read from its other end."""
    if key == "preload" or key.startswith("preload_"):
        return _mirrored(value)
    if key in ("table", "damping_table") and isinstance(value, list) and all(isinstance(row, list) for row in value):
        return [[_mirrored(number) for number in row] for row in reversed(value)]
    return value


def _mirrored_point(point: Any) -> Any:
    return [point[0], _mirrored(point[1]), point[2]] if isinstance(point, list) and len(point) == 3 else point


def _mirrored(value: Any) -> Any:
    """The opposite of a number or of a text with a unit; of 0 it is 0."""
    if isinstance(value, str):
        text = value.strip()
        return text[1:].strip() if text.startswith("-") else f"-{text.removeprefix('+').strip()}"
    return 0.0 - value if isinstance(value, int | float) and not isinstance(value, bool) else value
