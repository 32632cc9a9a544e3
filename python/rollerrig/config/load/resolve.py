"""What a file names, read: vehicles, supports, materials, profiles; and tables that stand for several.

    raw vehicle, support, material, profile + the folder they were read from -> (object | None, problems)
    one [[element]] with `at` and `both_sides` -> [placed] -> an [[element]] per place and side

`at.1 = {...}` of an element `primary` is `primary_1`, with the keys of that table in place of its own. `both_sides = true` makes
of it `primary_1_left`, as written, and `primary_1_right`, mirrored at the middle of the vehicle: y of its ends, and what its laws
along y, about x and about z do in one direction only.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel

from rollerrig.config.errors import ConfigError, ConfigProblem, Mistake, join_key, nearest, problems_of, show_value
from rollerrig.config.read import NO_SUCH_FILE, CatalogKind, Document, catalog_names, read_document
from rollerrig.config.schema.contact import Material
from rollerrig.config.schema.programme import Programme
from rollerrig.config.schema.support import Rig, SupportRoot
from rollerrig.config.schema.track import Track
from rollerrig.config.schema.vehicle import Vehicle
from rollerrig.config.validate.check_case import check_programme
from rollerrig.config.validate.check_track import check_support
from rollerrig.config.validate.check_vehicle import check_vehicle, check_vehicle_names
from rollerrig.config.validate.messages import validate

AT, BOTH_SIDES = "at", "both_sides"
Raw = dict[str, Any]
Problems = list[ConfigProblem]
M = TypeVar("M", bound=BaseModel)

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


HEADS = ("profile", "right_profile")
_POINT_FILES = (".txt", ".dat", ".csv", ".prw", ".prr", ".prf", ".xy")


def resolve_vehicle(document: Document) -> tuple[Vehicle | None, Problems]:
    """A vehicle from its raw tables."""
    file = document.file
    raw, problems = placed(document.raw, file)
    problems += [ConfigProblem(file, *mistake) for mistake in check_vehicle_names(raw)]
    if isinstance(raw.get("wheel"), Mapping):
        raw["wheel"] = _with_profiles(raw["wheel"], document, problems, "wheel.", ("profile",))
    return _checked(Vehicle, raw, file, check_vehicle, problems)


def resolve_support(document: Document) -> tuple[Rig | Track | None, Problems]:
    """A rig or track from its raw tables."""
    problems: Problems = []
    raw = _with_profiles(document.raw, document, problems)
    if isinstance(raw.get("spot"), Mapping):
        raw["spot"] = _with_profiles(raw["spot"], document, problems, "spot.", ("profile",))
    if isinstance(raw.get("segment"), list):
        raw["segment"] = [
            _with_profiles(one, document, problems, f"segment[{i}].") if isinstance(one, Mapping) else one
            for i, one in enumerate(raw["segment"])
        ]
    if isinstance(raw.get("irregularity"), Mapping):
        raw["irregularity"] = _absolute(raw["irregularity"], document.folder)
    root, problems = _checked(SupportRoot, raw, document.file, lambda root: check_support(root.root), problems)
    return (root.root if root else None), problems


def resolve_material(document: Document) -> tuple[Material | None, Problems]:
    """A material from its raw tables."""
    return validate(Material, document.raw, document.file)


def resolve_programme(document: Document) -> tuple[Programme | None, Problems]:
    """A test programme from its raw tables."""
    return _checked(Programme, document.raw, document.file, check_programme, [])


def _checked(
    model: type[M], raw: Mapping[str, Any], file: str, check: Callable[[M], Iterable[Mistake]], known: Problems
) -> tuple[M | None, Problems]:
    """The object that raw tables describe, with what is wrong beside the mistakes that are known."""
    found, mistakes = validate(model, raw, file)
    said = {(problem.file, problem.key) for problem in known}
    problems = [*known, *(mistake for mistake in mistakes if (mistake.file, mistake.key) not in said)]
    if found is not None and not problems:
        problems += problems_of(file, check(found))
    return (None if problems else found), problems


def refer(kind: CatalogKind, name: str, document: Document, key: str) -> tuple[Document | None, Problems]:
    """The document that ``key`` of another one names."""
    try:
        return read_document(kind, name, document.folder), []
    except ConfigError as error:
        first, *_ = error.problems
        if first.value != NO_SUCH_FILE:
            return None, list(error.problems)
        allowed = f"{NO_SUCH_FILE}; {first.allowed}"
        return None, [ConfigProblem(document.file, key, show_value(name), allowed, first.hint)]


def resolve_profile(name: str, document: Document, key: str) -> tuple[dict[str, Any] | None, Problems]:
    """Raw tables of the profile that ``name`` stands for: a catalogue entry, a TOML file, or a file of points."""
    if Path(name).suffix.lower() in _POINT_FILES:
        return _absolute({"kind": "file", "path": name}, document.folder), []
    if name in catalog_names("profile") or name.endswith(".toml"):
        found, problems = refer("profile", name, document, key)
        return (_absolute(found.raw, found.folder) if found else None), problems
    names = catalog_names("profile")
    allowed = f"allowed: a table with kind, a file of points, a TOML file, or one of {', '.join(names)}"
    return None, [ConfigProblem(document.file, key, show_value(name), allowed, nearest(name, names))]


def _with_profiles(
    table: Mapping[str, Any], document: Document, problems: Problems, at: str = "", keys: Iterable[str] = HEADS
) -> dict[str, Any]:
    """A table with its profiles read; what is wrong with them goes to the problems."""
    resolved = dict(table)
    for key in keys:
        written = table.get(key)
        if isinstance(written, str):
            spec, mistakes = resolve_profile(written, document, f"{at}{key}")
            resolved[key] = written if spec is None else spec
            problems += mistakes
        elif isinstance(written, Mapping):
            resolved[key] = _absolute(written, document.folder)
    return resolved


def _absolute(spec: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    path = spec.get("path")
    if not isinstance(path, str) or not path or "\0" in path:
        return dict(spec)
    return {**spec, "path": str((folder / path).absolute())}


def relative_to(folder: Path, key: str, value: object) -> object:
    """A new value as the file in ``folder`` means it: a file of a profile or of code that it names stands relative to it."""
    if isinstance(value, Mapping):
        return {name: relative_to(folder, str(name), inner) for name, inner in value.items()}
    last = key.rpartition(".")[2]
    if not isinstance(value, str) or not value or "\0" in value:
        return value
    names_a_file = last in HEADS and Path(value).suffix.lower() in (*_POINT_FILES, ".toml")
    names_a_file |= last in ("path", "fmu", "file") or (last == "user" and ".py:" in value)
    return str((folder / value).absolute()) if names_a_file else value
