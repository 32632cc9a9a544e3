"""A controller that is a Functional Mock-up Unit: its file, what its variables are called, its parameters."""

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from rollerrig.config.schema.base import OrShort, Table

_LARGEST = 1e18
"""Largest value of a parameter: any unit has room below it."""


def _parameter(value: Any) -> Any:
    """A number, true or false, or a text; its type and limits are those of the FMU, and checked with it."""
    fits = isinstance(value, bool | str) or (isinstance(value, int | float) and -_LARGEST <= value <= _LARGEST)
    if not fits:
        allowed = "allowed: a number, true, false or a text"
        raise PydanticCustomError("parameter", "{allowed}", {"allowed": allowed})
    return value


Parameter = Annotated[
    Any, PlainValidator(_parameter), WithJsonSchema({"type": ["number", "boolean", "string"]}, mode="validation")
]


class ControllerFmu(Table):
    """An FMU for co-simulation, version 2.0 or 3.0, in place of our own controller."""

    file: Annotated[str, Field(min_length=1)] = Field(description="FMU file, relative to the file that names it")
    names: dict[str, str | tuple[str, ...]] = Field(
        default={},
        description="measured quantity or command -> variable of the FMU: a name in which `{axle}` stands for the axle's name "
        "and `{number}` for 1, 2, ..., or a list with a name for each axle; absent: `{axle}.axle_speed`, and so on, as "
        "`rollerrig export-fmu --part` writes them",
    )
    parameters: dict[str, Parameter] = Field(default={}, description="parameter of the FMU -> value, in the FMU's unit")


def _from_file(value: Any) -> Any:
    """A file alone is a table with that file."""
    return {"file": value} if isinstance(value, str) else dict(value) if isinstance(value, Mapping) else value


AnyControllerFmu = Annotated[ControllerFmu, BeforeValidator(_from_file), OrShort({"type": "string"})]
