"""Numbers at logarithmic axes have room and are written plainly."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from rollerrig.plot.style import logarithmic, new_figure


@pytest.mark.slow
@pytest.mark.parametrize("low", [0.0123, 0.9, 4.0, 350.0])
@pytest.mark.parametrize("decades", [0.2, 0.5, 0.9, 1.6, 2.5, 4.0, 7.0])
@pytest.mark.parametrize("width", [2.6, 7.0])
def test_numbers_have_room(low: float, decades: float, width: float) -> None:
    figure, (axes,) = new_figure(width=width)
    axes.plot([low, low * 10**decades], [0.0, 1.0])
    logarithmic(axes)
    axes.set_xlim(low, low * 10**decades)
    figure.canvas.draw()
    seen = axes.get_xlim()
    shown = [
        label
        for label, place in zip(axes.get_xticklabels(), axes.get_xticks(), strict=True)
        if seen[0] <= place <= seen[1]
    ]
    assert not any(label.get_text() for label in axes.get_xticklabels(minor=True))
    assert len(shown) >= (2 if decades >= 0.5 else 1)
    assert not any("e" in label.get_text() or "$" in label.get_text() for label in shown)
    boxes = [label.get_window_extent() for label in shown]
    assert all(a.x1 < b.x0 for a, b in itertools.pairwise(boxes)), [label.get_text() for label in shown]


def test_an_ordinate_too() -> None:
    figure, (axes,) = new_figure()
    axes.plot([0.0, 1.0], np.array([0.2, 30.0]))
    logarithmic(axes, "y")
    figure.canvas.draw()
    assert axes.get_yscale() == "log"
    assert {"0.5", "1", "10"} <= {label.get_text() for label in axes.get_yticklabels()}
