"""Messages of validation: file, key, value, what is allowed.

raw table -> [validate] -> (object, no problems) or (None, one problem per mistake)
"""

import types
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, NamedTuple, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, RootModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from rollerrig.config.errors import MANY, ConfigProblem, join_key, nearest, one_of, show_value
from rollerrig.config.schema.base import INSTEAD_OF, quantities_in
from rollerrig.config.schema.units import KEY_SUFFIXES

_RENAMED: Mapping[str, tuple[str, ...]] = {
    "anti_skid": ("slide_protection",),
    "anti_slip": ("wheel_slip_control",),
    "believed": ("assumed",),
    "cleaned": ("recovered",),
    "cleaning": ("recovery_constant",),
    "decay": ("B", "beta", "friction"),
    "extends": ("base",),
    "friction_fall": ("friction",),
    "held": ("fixed", "speed_controlled"),
    "ideal_rolling": ("pure_rolling",),
    "inherits": ("base",),
    "initial": ("k_0",),
    "luenberger": ("observer",),
    "merge_barrier": ("merging_criterion", "normal.merging_criterion"),
    "parent": ("base",),
    "polach": ("creep",),
    "ratio": ("A",),
    "remaining": ("A", "friction"),
    "saturate_spin_moment": ("creep.saturate_spin_moment",),
    "slip_reduction": ("k_S",),
    "standstill_speed": ("creepage_regularisation_speed", "friction_regularisation_speed"),
    "start": ("mu_0", "friction"),
    "stick_reduction": ("k_A",),
    "stiffness_reduction": ("creep",),
    "ultimate": ("k_inf",),
    "wsp": ("slide_protection",),
}
"""Former key or word, or one of other programs -> what it is called now; a dotted one is in a table of that name."""


def meant(word: object, choices: Sequence[str]) -> str:
    """The present name of a renamed key or word, or the nearest of those allowed; "" if nothing is near."""
    present = (new for new in _RENAMED.get(str(word).lower(), ()) if new.split(".")[0] in choices)
    return next(present, "") or nearest(word, choices)


M = TypeVar("M", bound=BaseModel)

NAMING_KEYS = ("name", "wheelset", "body")
_KINDS = {
    "string_type": "allowed: a text",
    "bool_type": "allowed: true or false",
    "int_type": "allowed: a whole number",
    "tuple_type": "allowed: a list",
    "dict_type": "allowed: a table",
    "string_pattern_mismatch": "allowed: a name of at most 60 letters, digits, _ and -",
    "string_too_short": "allowed: a text that is not empty",
}


class _Place(NamedTuple):
    """Where an error sits: what the user wrote there and what the schema says about it."""

    key: str
    model: type[BaseModel] | None  # the table that owns the last key
    field: FieldInfo | None
    annotation: Any  # what may stand here
    raw: Any

    @property
    def choices(self) -> Sequence[type[BaseModel]]:
        """Tables that may stand here."""
        return tables_in(self.annotation)


def validate(model: type[M], raw: object, file: str, prefix: str = "") -> tuple[M | None, list[ConfigProblem]]:
    """Build ``model`` from raw TOML values; on mistakes the object is None and each is listed."""
    try:
        return model.model_validate(raw), []
    except ValidationError as error:
        errors = error.errors(include_url=False)[:MANY]
        found = [_problem(model, raw, item, file) for item in errors if not _follows(item, errors)]
        problems = list(dict.fromkeys(problem.within(prefix) for problem in found if problem))
        if more := error.error_count() - len(errors):
            problems.append(ConfigProblem(file, prefix, f"{more} more mistakes", "mend those above first"))
        return None, problems


def item_labels(items: Sequence[object]) -> list[str]:
    """Labels of the items of a list: ``.name`` where it is unique, else ``[index]``."""

    def name(item: object) -> str:
        if isinstance(item, Mapping):
            return next((item[key] for key in NAMING_KEYS if isinstance(item.get(key), str)), "")
        return ""

    names = [name(item) for item in items] if len(items) <= MANY else [""] * len(items)
    count = Counter(names)
    plain = [own.replace("_", "").replace("-", "").isalnum() and count[own] == 1 for own in names]
    return [own if plain[index] else f"[{index}]" for index, own in enumerate(names)]


def named_items(items: Sequence[object]) -> dict[str, Any]:
    """The items of a list by their names, or else by their numbers."""
    return {label.strip("[]"): item for label, item in zip(item_labels(items), items, strict=True)}


def alternatives(annotation: Any) -> tuple[Any, ...]:
    """What an annotation allows, one by one: without Annotated and without None."""
    while get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    if get_origin(annotation) in (Union, types.UnionType):
        return tuple(a for member in get_args(annotation) if member is not type(None) for a in alternatives(member))
    return (annotation,)


def _bare(annotation: Any) -> Any:
    """Without Annotated and without None."""
    found = alternatives(annotation)
    while get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    return found[0] if len(found) == 1 else annotation


def tables_in(annotation: Any) -> tuple[type[BaseModel], ...]:
    """The models an annotation may hold directly: one, several of a union, or none."""
    return tuple(one for one in alternatives(annotation) if isinstance(one, type) and issubclass(one, BaseModel))


def tables_below(root: type[BaseModel]) -> tuple[type[BaseModel], ...]:
    """The model and all that it may contain, at any depth."""
    found: dict[type[BaseModel], None] = {}

    def visit(annotation: Any) -> None:
        if isinstance(annotation, type) and issubclass(annotation, BaseModel) and annotation not in found:
            found[annotation] = None
            for field in annotation.model_fields.values():
                visit(field.annotation)
        for part in get_args(annotation):
            visit(part)

    visit(root)
    return tuple(found)


def tag_of(table: type[BaseModel]) -> str:
    """The value of ``kind`` that selects this table in a union, or ""."""
    kind = table.model_fields.get("kind")
    choices = get_args(kind.annotation) if kind and get_origin(kind.annotation) is Literal else ()
    return str(choices[0]) if len(choices) == 1 else ""


def _locate(model: type[BaseModel], raw: Any, location: Sequence[int | str]) -> _Place:
    annotation: Any = model.model_fields["root"].annotation if issubclass(model, RootModel) else model
    place = _Place("", None, None, annotation, raw)
    for item in location:
        tables = place.choices
        if len(tables) > 1:  # the item is the tag of a union, which the user did not write
            place = place._replace(annotation=next(table for table in tables if tag_of(table) == item))
        else:
            place = _enter_table(place, tables[0], str(item)) if tables else _enter_list(place, item)
    return place


def _enter_table(place: _Place, table: type[BaseModel], item: str) -> _Place:
    raw, key = place.raw, item
    if isinstance(raw, BaseModel):
        raw = {name: getattr(raw, name) for name in type(raw).model_fields}
    if isinstance(raw, Mapping):
        spelled = [f"{item}_{suffix}" for suffix in KEY_SUFFIXES if f"{item}_{suffix}" in raw]
        key = spelled[0] if item not in raw and spelled else item
        raw = raw.get(key)
    field = table.model_fields.get(item)
    return _Place(join_key(place.key, key), table, field, field.annotation if field else None, raw)


def _enter_list(place: _Place, item: int | str) -> _Place:
    arguments, raw = get_args(_bare(place.annotation)), place.raw
    if isinstance(item, int):
        is_list = isinstance(raw, list | tuple)
        label = item_labels(raw)[item] if is_list and item < len(raw) <= MANY else f"[{item}]"
        many = len(arguments) == 2 and arguments[1] is Ellipsis
        inner = arguments[0] if many else dict(enumerate(arguments)).get(item)
        raw = raw[item] if is_list and item < len(raw) else None
    elif item == "[key]":  # pydantic's mark for "the key itself is wrong"
        return place
    else:
        label, inner = item, (arguments or (None,))[-1]
        raw = raw.get(item) if isinstance(raw, Mapping) else None
    return _Place(join_key(place.key, label), None, place.field, inner, raw)


def _follows(error: ErrorDetails, errors: Sequence[ErrorDetails]) -> bool:
    """Whether a list is called too short only because its entries have mistakes: pydantic counts those without."""
    place = error["loc"]
    below = (other["loc"] for other in errors if len(other["loc"]) > len(place))
    return error["type"] == "too_short" and any(other[: len(place)] == place for other in below)


def _problem(model: type[BaseModel], raw: object, error: ErrorDetails, file: str) -> ConfigProblem | None:
    place = _locate(model, raw, error["loc"])
    context: Mapping[str, Any] = error.get("ctx", {})
    match error["type"]:
        case "extra_forbidden":
            return _unknown_key(model, raw, error, file, place)
        case "missing":
            holder = _locate(model, raw, error["loc"][:-1]).raw
            if isinstance(holder, Mapping) and _instead(place.field) in holder:
                return None  # it follows from the other key, whose own mistake is reported
            return ConfigProblem(file, place.key, "missing", _needed(place))
        case "at_key":
            at = place.raw
            for part in str(context["key"]).split("."):
                at = at.get(part) if isinstance(at, Mapping) else getattr(at, part, None)
            key = join_key(place.key, str(context["key"]))
            return ConfigProblem(file, key, "missing" if at is None else show_value(at), str(context["allowed"]))
        case "union_tag_invalid" | "union_tag_not_found":
            tags = [tag_of(table) for table in place.choices]
            by_name = isinstance(place.raw, str)
            kind = place.raw if by_name else place.raw.get("kind") if isinstance(place.raw, Mapping) else None
            value = "missing" if kind is None else show_value(kind)
            key = place.key if by_name else join_key(place.key, "kind")
            return ConfigProblem(file, key, value, one_of(tags), meant(kind, tags))
        case "literal_error":
            choices = [str(choice) for choice in get_args(_literal(place))]
            written = error["input"]
            return ConfigProblem(file, place.key, show_value(written), one_of(choices), meant(written, choices))
    return ConfigProblem(file, place.key, show_value(error["input"]), _allowed(place, error, context))


def _unknown_key(model: type[BaseModel], raw: object, error: ErrorDetails, file: str, place: _Place) -> ConfigProblem:
    key = str(error["loc"][-1])
    keys = tuple(place.model.model_fields) if place.model else ()
    name, _, suffix = key.rpartition("_")
    if name in keys and suffix in KEY_SUFFIXES:
        holder = _locate(model, raw, error["loc"][:-1]).raw
        both = isinstance(holder, Mapping) and name in holder
        allowed = f"allowed: one of `{name}` and `{key}`" if both else f"allowed: `{name}`, with a unit in its values"
        return ConfigProblem(file, place.key, show_value(error["input"]), allowed)
    hint = meant(key, keys)
    hint = join_key(place.key.removesuffix(key).rstrip("."), hint) if "." in hint else hint
    value = f"unknown key (= {show_value(error['input'])})"
    return ConfigProblem(file, place.key, value, one_of(keys), hint)


def _literal(place: _Place) -> Any:
    annotation = _bare(place.field.annotation) if place.field else None
    while annotation is not None and get_origin(annotation) is not Literal:
        annotation = _bare(get_args(annotation)[0]) if get_args(annotation) else None
    return annotation


def _needed(place: _Place) -> str:
    other = f", or `{_instead(place.field)}` in its place" if _instead(place.field) else ""
    marks = place.field.metadata if place.field and place.model else ()
    numbers = () if place.choices else tuple(dict.fromkeys(quantities_in(place.annotation, marks)))
    if numbers and get_origin(_bare(place.annotation)) is not tuple:
        return numbers[0].allowed.replace("allowed", "needed", 1) + other
    units = ", ".join(dict.fromkeys("-" if one.unit == "1" else one.unit for one in numbers))
    said = place.field.description if place.field else ""
    return f"needed: {said}{f' [{units}]' if units else ''}{other}" if said else "needed"


def _instead(field: FieldInfo | None) -> str:
    """The key that a file may give in place of this one, or ""."""
    extra = field.json_schema_extra if field else None
    return str(extra.get(INSTEAD_OF, "")) if isinstance(extra, dict) else ""


def _allowed(place: _Place, error: ErrorDetails, context: Mapping[str, Any]) -> str:
    if error["type"] == "value_error":
        return str(context["error"])
    if error["type"] in ("model_type", "model_attributes_type"):
        keys = dict.fromkeys(key for table in place.choices for key in table.model_fields)
        return f"allowed: a table with {', '.join(keys)}"
    if error["type"] == "too_short":
        return f"allowed: at least {context.get('min_length')} entries"
    if error["type"] == "too_long":
        most = context.get("max_length")
        limited = place.field is not None and any(getattr(m, "max_length", None) == most for m in place.field.metadata)
        return f"allowed: {'at most' if limited else 'exactly'} {most} entries"
    return _KINDS.get(error["type"], f"allowed: {error['msg'][:1].lower()}{error['msg'][1:]}")
