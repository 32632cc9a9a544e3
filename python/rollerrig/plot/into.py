"""Figures drawn into axes of the caller's own.

a function that draws results into a new figure -> [into_axes] -> the same with `axes=`

A figure of several panels takes as many axes as are given, from the top; the other panels are not drawn.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Sequence
from contextvars import ContextVar
from typing import Any, Protocol, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

_GIVEN: ContextVar[tuple[Axes, ...]] = ContextVar("axes of the caller's own", default=())


class Draw(Protocol):
    """A function that draws results into a new figure, or into axes."""

    def __call__(self, *results: Any, axes: Axes | Sequence[Axes] | None = None, **options: Any) -> Any:
        """The new figure, or the axes."""


def into_axes(draw: Callable[..., Figure]) -> Draw:
    """The function with a last argument `axes`: what it is given is drawn into, and returned in place of a figure."""

    @functools.wraps(draw)
    def drawn(*results: Any, axes: Axes | Sequence[Axes] | None = None, **options: Any) -> Any:
        if axes is None:
            return draw(*results, **options)
        given = (axes,) if isinstance(axes, Axes) else tuple(np.ravel(np.asarray(axes, dtype=object)))
        token = _GIVEN.set(given)
        try:
            draw(*results, **options)
        finally:
            _GIVEN.reset(token)
        return axes

    own = inspect.signature(draw)
    extra = inspect.Parameter(
        "axes", inspect.Parameter.KEYWORD_ONLY, default=None, annotation="Axes | Sequence[Axes] | None"
    )
    drawn.__signature__ = own.replace(parameters=[*own.parameters.values(), extra])  # type: ignore[attr-defined]
    return cast(Draw, drawn)


def given() -> tuple[Axes, ...]:
    """Axes of the caller's own that are drawn into now; none: a new figure is made."""
    return _GIVEN.get()


def given_grid(rows: int, columns: int, own: Callable[[], Figure]) -> tuple[Figure, Any] | None:
    """The given axes as a grid, filled up with axes that nobody will see; None where none were given."""
    axes = given()
    if not axes:
        return None
    missing = rows * columns - len(axes)
    spare = own().subplots(1, missing, squeeze=False)[0] if missing > 0 else []
    grid = np.empty(rows * columns, dtype=object)
    grid[:] = [*axes, *spare][: rows * columns]
    return cast(Figure, axes[0].get_figure(root=True)), grid.reshape(rows, columns)
