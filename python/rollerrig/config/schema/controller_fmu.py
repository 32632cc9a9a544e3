"""A controller that is a Functional Mock-up Unit: its file, what its variables are called, its parameters."""

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, StrictBool, StrictFloat, StrictInt, StrictStr

from rollerrig.config.schema.base import Table


class ControllerFmu(Table):
    """An FMU for co-simulation, version 2.0 or 3.0, in place of our own controller."""

    file: Annotated[str, Field(min_length=1)] = Field(description="FMU file, relative to the file that names it")
    names: dict[str, str | tuple[str, ...]] = Field(
        default={},
        description="measured quantity or command -> variable of the FMU: a name in which `{axle}` stands for the axle's name "
        "and `{number}` for 1, 2, ..., or a list with a name for each axle; absent: `{axle}.axle_speed`, and so on, as "
        "`rollerrig export-fmu --part` writes them",
    )
    parameters: dict[str, StrictBool | StrictInt | StrictFloat | StrictStr] = Field(
        default={}, description="parameter of the FMU -> value, in the FMU's unit"
    )


def _from_file(value: Any) -> Any:
    """A file alone is a table with that file."""
    return {"file": value} if isinstance(value, str) else dict(value) if isinstance(value, Mapping) else value


AnyControllerFmu = Annotated[ControllerFmu, BeforeValidator(_from_file)]
