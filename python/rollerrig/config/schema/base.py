"""The model all configuration tables derive from, and the tables of numbers inside them."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Annotated, Any, Self, TypeVar, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    JsonValue,
    model_validator,
)
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from rollerrig.config.schema.units import KEY_SUFFIXES, Position, Quantity, RunningSpeed, Time, Torque

INSTEAD_OF = "x-instead-of"


def optional(default: Any, description: str, **limits: Any) -> Any:
    """A key that a file may leave out: its default, what it means, and limits of pydantic's."""
    return Field(default=default, description=description, **limits)


def needed(description: str, *, instead_of: str = "", **limits: Any) -> Any:
    """A key that a file must give; but for that of ``instead_of``, with which it has a value once the file is read."""
    extra: dict[str, JsonValue] | None = {INSTEAD_OF: instead_of} if instead_of else None
    return Field(description=description, json_schema_extra=extra, **limits)


def quantities_in(annotation: object, metadata: Iterable[object] = ()) -> Iterator[Quantity]:
    """The quantities of a field that is one number, or of the numbers of a list."""
    for item in (*metadata, *getattr(annotation, "__metadata__", ()), *get_args(annotation)):
        if isinstance(item, Quantity):
            yield item
        else:
            yield from quantities_in(item)


def quantity_of(annotation: object, metadata: Iterable[object] = ()) -> Quantity | None:
    """The first of them; None if there is none."""
    return next(quantities_in(annotation, metadata), None)


def refused(key: str, allowed: str) -> PydanticCustomError:
    """A mistake at a key of the table that raises it; `allowed` says what may stand there."""
    return PydanticCustomError("at_key", "{allowed}", {"allowed": allowed, "key": key})


Mistakes = Iterator[tuple[str, str]]
"""Keys of a table, and what may stand there."""


USUAL_KIND = "x-usual-kind"


class OrShort:
    """Mark of a table in place of which a file may write something shorter: in words, and for the JSON Schema."""

    def __init__(self, *alternatives: dict[str, Any], words: str) -> None:
        self.alternatives, self.words = alternatives, words

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """The alternatives beside the table."""
        return {"anyOf": [*self.alternatives, handler(schema)]}


class by_kind:  # noqa: N801 (stands among the annotations of pydantic)
    """A name alone asks for that kind with its defaults, a table without `kind` for the usual one; "": none is usual."""

    words = "the name of a kind"

    def __init__(self, usual: str = "") -> None:
        self.usual = usual

    def completed(self, value: Any) -> Any:
        """The table that was meant."""
        if isinstance(value, str):
            return {"kind": value}
        return {"kind": self.usual, **value} if self.usual and isinstance(value, Mapping) else value

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Before the validation of the union, of which `kind` names the table."""
        union = handler.generate_schema(Annotated[source, Discriminator("kind")])
        return core_schema.no_info_before_validator_function(self.completed, union)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """The names of the kinds beside their tables."""
        union = handler(schema)
        return {"anyOf": [{"enum": list(union["discriminator"]["mapping"])}, {**union, USUAL_KIND: self.usual}]}


class Table(BaseModel):
    """A TOML table: unknown keys are mistakes, and nothing changes once it is read."""

    model_config = ConfigDict(extra="forbid", frozen=True, hide_input_in_errors=True)

    def _mistakes(self) -> Mistakes:
        """What only a look across its keys can tell; the first one is reported."""
        yield from ()

    @model_validator(mode="after")
    def _first_mistake(self) -> Self:
        for key, allowed in self._mistakes():
            raise refused(key, allowed)
        return self

    @model_validator(mode="before")
    @classmethod
    def _unit_in_key(cls, data: Any) -> Any:
        """``speed_kmh = 100`` becomes ``speed = "100 km/h"``."""
        if not isinstance(data, dict):
            return data
        translated = dict(data)
        for key, value in data.items():
            name, _, suffix = key.rpartition("_") if isinstance(key, str) else ("", "", "")
            if key in cls.model_fields or name not in cls.model_fields or suffix not in KEY_SUFFIXES:
                continue
            field = cls.model_fields[name]
            is_number = quantity_of(field.annotation, field.metadata) and not isinstance(value, list | tuple | dict)
            if not is_number or name in data:  # left as an unknown key: the message lists what is allowed
                continue
            number = value if isinstance(value, int | float) and not isinstance(value, bool) else None
            translated[name] = f"{number!r} {KEY_SUFFIXES[suffix]}" if number is not None else value
            del translated[key]
        return translated


Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9_\-]{1,60}$")]


class Named(Table):
    """A table that stands for itself: a file of its own, or a part of one."""

    name: Name = needed("name, in results and messages")
    description: str = optional("", "description in one line")


class Sourced(Named):
    """A table of data that somebody else published or measured."""

    source: str = optional("", "origin of the data")


def in_order(rows: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """Rows of a function of their first column: at least two, in ascending order."""
    if len(rows) < 2:
        raise ValueError("allowed: at least two rows [argument, value]")
    for (before, _), (after, _) in zip(rows, rows[1:], strict=False):
        if not after > before:
            allowed = f"allowed: rows in ascending order of their first column, each once; {after:g} follows {before:g}"
            raise ValueError(allowed)
    return rows


X = TypeVar("X")
Y = TypeVar("Y")
Rows = Annotated[tuple[tuple[X, Y], ...], AfterValidator(in_order)]
"""A function of its first column."""
SpeedTable = Rows[Time, RunningSpeed]
TorqueTable = Rows[Time, Torque]
Vector = tuple[Position, Position, Position]
