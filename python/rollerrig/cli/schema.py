"""`rollerrig schema`."""

from __future__ import annotations

import json
from typing import Annotated, Literal

import typer


def command(
    kind: Annotated[
        Literal["case", "vehicle", "support", "material", "profile", "programme", "plan"],
        typer.Argument(help="Kind of file.", metavar="KIND"),
    ] = "case",
) -> None:
    """Print the JSON Schema of a kind of file (case, vehicle, support, material, profile, programme, plan), for editors."""
    from rollerrig.config import json_schema

    typer.echo(json.dumps(json_schema(kind), indent=1, ensure_ascii=False))
