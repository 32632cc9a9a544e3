"""Figures drawn into axes of one's own."""

from __future__ import annotations

import inspect

import pytest
from matplotlib.figure import Figure

import rollerrig as rr
from rollerrig.plot import style

OWN = [name for name in rr.plot.__all__ if name not in ("figure_bytes", "shape_speed", "vehicle")]


@pytest.fixture(scope="module")
def run():
    return rr.simulate(
        rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.2 s", "time.output_step": "5 ms"})
    )


def lines(axes) -> int:
    return len(axes.lines) + len(axes.collections)


@pytest.mark.parametrize("name", OWN)
def test_every_figure_takes_axes(name: str) -> None:
    assert inspect.signature(getattr(rr.plot, name)).parameters["axes"].default is None


def test_a_figure_is_drawn_into_axes_and_they_are_returned(run) -> None:
    figure = Figure()
    axes = figure.subplots(2, 1)
    top = rr.plot.motion_over_time(run, axes=axes[0])  # the first panel alone
    assert top is axes[0]
    assert (top.get_ylabel(), top.get_xlabel()) == ("lateral [mm]", "time [s]")
    assert (lines(axes[0]), lines(axes[1])) == (1, 0)  # the only body that moves
    assert figure.axes == list(axes)
    alone = rr.plot.motion_over_time(run)
    assert [text.get_text() for text in top.get_legend().get_texts()] == [
        t.get_text() for t in alone.legends[0].get_texts()
    ]


def test_panels_take_several_axes(run) -> None:
    axes = Figure().subplots(1, 2)
    assert rr.plot.energy_over_time(run, axes=axes) is axes
    assert [one.get_ylabel() for one in axes] == ["change since the start [kJ]", "residual [J]"]
    assert rr.plot.quotient(rr.wheel_forces(run), axes=axes[0]) is axes[0]


@pytest.mark.slow
def test_figures_of_grids_and_colour_bars_take_axes() -> None:
    modes = rr.stability("wheelset_rollers", [100.0, 150.0])
    for draw in (rr.plot.damping_map, rr.plot.root_locus):
        axes = Figure().subplots()
        assert draw(modes, axes=axes) is axes
        assert lines(axes) > 0
    axes = Figure().subplots()
    rr.plot.creep_figure(rr.creep(laws=["fastsim"], demands=(0.5, 2.0)), axes=axes)
    assert lines(axes) > 0


def test_afterwards_figures_are_new_again(run) -> None:
    axes = Figure().subplots()
    with pytest.raises(TypeError):
        rr.plot.motion_over_time(None, axes=axes)
    assert style.given() == ()
    assert isinstance(rr.plot.motion_over_time(run), Figure)
