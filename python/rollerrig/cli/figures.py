"""Figures as files: the same figure gives the same bytes."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from rollerrig.results import write_bytes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NO_DATE: dict[str, dict[str, str | None]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None},
}
"""What to leave out of the file, by its ending."""


def check_picture(path: Path, option: str) -> None:
    """Refuse endings that are no pictures before any work is done."""
    if path.suffix.lower() not in _NO_DATE:
        raise typer.BadParameter(f"'{path}' must end in {', '.join(_NO_DATE)}", param_hint=option)


def save_figure(figure: Figure, path: Path) -> Path:
    """Write a figure in the format of its ending.

    Raises:
        OutputError: it could not be written.
    """
    import matplotlib as mpl

    ending = path.suffix.lower()
    buffer = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "rollerrig"}):
        figure.savefig(buffer, format=ending[1:], dpi=150, metadata=_NO_DATE[ending])
    return write_bytes(path, buffer.getbuffer())
