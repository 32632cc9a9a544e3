"""Figures of a report as charts: what becomes one, that no extreme is lost, and how a browser zooms them."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from browser import Opened, chromium
from rollerrig.plot import hunting_over_time
from rollerrig.plot.style import figure_bytes, watermark
from rollerrig.study.charts import chart_of, extremes
from rollerrig.study.report import Mark, Page, Picture, Section, Table, render
from rollerrig.viewer.columns import WHOLE

TIME = np.linspace(0.0, 10.0, 20001)


def oscillation(last: float) -> Figure:
    """50 waves in 10 s; from 5 s on the amplitude falls to its last share."""
    figure = Figure()
    axes = figure.subplots()
    axes.plot(TIME, np.interp(TIME, [0.0, 5.0, 10.0], [1.0, 1.0, last]) * np.sin(10.0 * np.pi * TIME))
    axes.set_xlabel("time [s]")
    return figure


def history(*, peak: float = 0.0) -> Figure:
    """Two panels over time: two curves and a limit, and one with a gap."""
    figure = Figure()
    upper, lower = figure.subplots(2, 1, sharex=True)
    values = np.sin(TIME)
    values[7777] += peak
    upper.plot(TIME, values, color="#0b5394", label="first")
    upper.plot(TIME, 0.5 * np.cos(TIME), "--", color="#c0392b", label="second")
    upper.axhline(0.8, color="black")
    upper.set_ylabel("force\n[kN]")
    upper.set_title("first case", loc="right")
    figure.supylabel("signals")
    lower.plot(TIME, np.where((TIME > 4.0) & (TIME < 5.0), np.nan, TIME), color="#2e7d32")
    lower.set_ylabel("speed [m/s]")
    lower.set_xlabel("time [s]")
    return figure


def column(chart: Any, name: str) -> np.ndarray:
    raw = gzip.decompress(base64.b64decode(chart.numbers))
    start, count, kind, factor, offset = chart.head["columns"][name]
    values = np.frombuffer(raw, "<f4" if kind == "f" else "<i2", count, start).astype(float)
    return np.where(values == -WHOLE - 1, np.nan, factor * values + offset) if kind == "h" else values


def test_a_history_becomes_a_chart_with_all_that_is_drawn() -> None:
    chart = chart_of(history(), "forces", "QUICK")
    assert chart is not None
    assert (chart.head["id"], chart.head["x"], chart.head["mark"]) == ("figure-forces", "time [s]", "QUICK")
    upper, lower = chart.head["panels"]
    assert (upper["label"], lower["label"]) == ("signals force [kN], first case", "signals speed [m/s]")
    assert [(c["label"], c["colour"], bool(c["dash"])) for c in upper["curves"]] == [
        ("first", "#0b5394", False),
        ("second", "#c0392b", True),
    ]
    assert upper["levels"] == [0.8]
    for curve, exact in zip(upper["curves"], (np.sin, lambda t: 0.5 * np.cos(t)), strict=True):
        np.testing.assert_allclose(column(chart, curve["y"]), exact(column(chart, curve["x"])), atol=1e-4)
    gap = column(chart, lower["curves"][0]["y"])
    along = column(chart, lower["curves"][0]["x"])
    assert np.isnan(gap[(along > 4.01) & (along < 4.99)]).all()
    assert np.isfinite(gap[(along < 3.99) | (along > 5.01)]).all()


def test_runs_of_different_length_are_drawn_over_the_time_of_the_longest() -> None:
    runs = [
        (
            100.0,
            xr.Dataset({"lateral": (("time", "body"), np.cos(time)[:, None])}, {"time": time, "body": ["front_frame"]}),
        )
        for time in (TIME, TIME[:5001])
    ]
    figure = hunting_over_time(runs, "front_frame")
    assert [axes.get_xlim() for axes in figure.axes] == [(0.0, 10.0)] * 2
    chart = chart_of(figure, "hunting")
    assert chart is not None
    assert [column(chart, f"x{panel}.0")[-1] for panel in (0, 1)] == [10.0, 10.0]
    assert np.isnan(column(chart, "y1.0.0")[-1])


def test_the_only_sample_of_a_peak_is_kept() -> None:
    chart = chart_of(history(peak=5.0), "forces")
    assert chart is not None
    first = chart.head["panels"][0]["curves"][0]
    values = column(chart, first["y"])
    assert 1000 < len(values) <= 4000
    assert column(chart, first["x"])[values.argmax()] == pytest.approx(TIME[7777])
    assert values.max() == pytest.approx(np.sin(TIME[7777]) + 5.0, abs=1e-4)


@pytest.mark.parametrize("count", [1, 2, 3999, 4000, 4001, 50000])
def test_kept_samples_hold_both_ends_and_every_extreme(count: int) -> None:
    rng = np.random.default_rng(1)
    values = rng.normal(size=(count, 3))
    kept = extremes(values)
    assert len(kept) <= 4000
    assert (kept[0], kept[-1]) == (0, count - 1)
    np.testing.assert_array_equal(values[kept].max(axis=0), values.max(axis=0))
    np.testing.assert_array_equal(values[kept].min(axis=0), values.min(axis=0))


def test_what_a_chart_cannot_show_stays_a_picture() -> None:
    def figure(draw: Any) -> Figure:
        made = Figure()
        axes = made.subplots()
        axes.plot(TIME, TIME)
        axes.set_xlabel("time [s]")
        draw(axes)
        return made

    assert chart_of(figure(lambda axes: axes.axhline(1.0)), "a") is not None
    for draw in (
        lambda axes: axes.plot(TIME, TIME, "o"),
        lambda axes: axes.plot(TIME[::-1], TIME),
        lambda axes: axes.fill_between(TIME, 0.0, TIME),
        lambda axes: axes.text(0.0, 0.0, "a word"),
        lambda axes: axes.axvline(3.0),
        lambda axes: axes.set_xscale("log"),
        lambda axes: axes.set_xlabel(""),
    ):
        assert chart_of(figure(draw), "a") is None


# ------------------------------------------------------------------------------------------------------ in a browser


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as started:
        yield started


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A marked report with a history, a picture that is none, and a wide table."""
    plain = Figure()
    plain.subplots().plot([0.0, 1.0], [1.0, 0.0], "o-")
    pictures = []
    for name, figure in (("forces", history()), ("points", plain)):
        chart = chart_of(figure, name, "QUICK")
        watermark(figure, "QUICK")
        pictures.append(Picture(name, figure, f"caption of {name}", figure_bytes(figure, "png"), chart))
    table = Table([f"a long heading {k} [kN]" for k in range(14)], [list(range(14))], "wide")
    page = Page("Report", "an answer", [Section("Figures", [*pictures, table])], mark=Mark("quick", "few runs"))
    path = tmp_path_factory.mktemp("report") / "report.html"
    path.write_text(render(page))
    return path


RANGES = "figures[0].plots.map(p => [p.scales.x.min, p.scales.x.max])"


def drag(page: Any, panel: int, part_from: float, part_to: float) -> None:
    box = page.locator(".u-over").nth(panel).bounding_box()
    page.mouse.move(box["x"] + part_from * box["width"], box["y"] + 40)
    page.mouse.down()
    page.mouse.move(box["x"] + part_to * box["width"], box["y"] + 45, steps=3)
    page.mouse.up()


@pytest.mark.slow
def test_a_drag_zooms_all_panels_and_a_double_click_shows_all(browser: Any, report: Path) -> None:
    opened = Opened(browser, report)
    page = opened.page
    try:
        page.locator("figure.live").scroll_into_view_if_needed()
        assert page.evaluate(RANGES) == [[0, 10], [0, 10]]
        drag(page, 0, 0.2, 0.5)
        for low, high in page.evaluate(RANGES):
            assert (low, high) == (pytest.approx(2.0, abs=0.05), pytest.approx(5.0, abs=0.05))
        low, high = page.evaluate("[figures[0].plots[1].scales.y.min, figures[0].plots[1].scales.y.max]")
        assert (low, high) == (pytest.approx(1.9, abs=0.1), pytest.approx(4.1, abs=0.1))  # what is there until the gap
        page.locator(".u-over").nth(1).dblclick()
        assert page.evaluate(RANGES) == [[0, 10], [0, 10]]
        assert opened.complaints == []
        assert opened.requests == [report.as_uri()]
    finally:
        opened.close()


@pytest.mark.slow
def test_the_picture_stands_on_paper_and_the_chart_on_a_screen(browser: Any, report: Path) -> None:
    opened = Opened(browser, report)
    shown = "['#figure-forces img', '#figure-forces .charts'].map(s => document.querySelector(s).offsetHeight > 0)"
    try:
        assert opened.page.evaluate(shown) == [False, True]
        mark = opened.page.evaluate("getComputedStyle(document.querySelector('.charts'), '::after').content")
        assert mark == '"QUICK"'
        opened.page.emulate_media(media="print")
        assert opened.page.evaluate(shown) == [True, False]
    finally:
        opened.close()


@pytest.mark.slow
def test_other_pictures_are_enlarged_in_a_window(browser: Any, report: Path) -> None:
    opened = Opened(browser, report)
    page = opened.page
    try:
        page.locator("figure:not(.live) img").click()
        size = "document.querySelector('dialog img').clientWidth"
        before = page.evaluate(size)
        page.keyboard.press("+")
        page.locator("dialog button").first.click()
        assert page.evaluate(size) == pytest.approx(2.25 * before, rel=0.01)
        page.keyboard.press("Escape")
        page.wait_for_selector("dialog", state="detached")
        assert opened.complaints == []
    finally:
        opened.close()


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_is_legible_on_a_phone(browser: Any, report: Path, scheme: str) -> None:
    opened = Opened(browser, report, 375, 740, color_scheme=scheme, has_touch=True)
    page = opened.page
    try:
        assert page.evaluate("document.documentElement.scrollWidth") <= 375
        assert page.evaluate("figures[0].plots[0].width") > 330
        picture = "document.querySelector('figure:not(.live) img')"
        assert 330 < page.evaluate(f"{picture}.clientWidth") <= 375  # whole; a tap enlarges it
        assert ("invert" in page.evaluate(f"getComputedStyle({picture}).filter")) == (scheme == "dark")  # no white page
        back, text = page.evaluate(
            "[getComputedStyle(document.body).backgroundColor, figures[0].plots[0].axes[0].stroke()]"
        )
        assert (back == "rgb(18, 24, 31)") == (scheme == "dark")
        assert text == ("#dfe6ee" if scheme == "dark" else "#1c1c1c")
        pinch = """(() => { const over = document.querySelector('.u-over'), box = over.getBoundingClientRect();
            const place = x => ({clientX: box.left + x * box.width, clientY: box.top + 30});
            const finger = (x, k) => new Touch({identifier: k, target: over, ...place(x)});
            const at = (kind, parts) => over.dispatchEvent(new TouchEvent(kind, {cancelable: true, touches: parts.map(finger)}));
            at('touchstart', [0.4, 0.6]); at('touchmove', [0.2, 0.8]); })()"""
        page.evaluate(pinch)
        for low, high in page.evaluate(RANGES):
            assert (low, high) == (pytest.approx(10 / 3, abs=0.1), pytest.approx(20 / 3, abs=0.1))
        assert opened.complaints == []
    finally:
        opened.close()


@pytest.mark.slow
def test_many_waves_on_a_narrow_screen_begin_with_the_last_ones(browser: Any, tmp_path: Path) -> None:
    """A run that hunts would be a block of colour; what has not settled is shown whole."""
    pictures = []
    for name, figure in (("hunts", oscillation(1.0)), ("decays", oscillation(0.0)), ("history", history())):
        pictures.append(Picture(name, figure, "", figure_bytes(figure, "png"), chart_of(figure, name)))
    path = tmp_path / "report.html"
    path.write_text(
        render(Page("Report", "", [Section("All numbers of the wheels, and how they were computed", [*pictures])]))
    )
    for width, shown in ((375, 2.5), (960, 10.0)):
        opened = Opened(browser, path, width, 740)
        try:
            assert opened.page.evaluate("document.documentElement.scrollWidth") <= width  # a long name in its contents
            ranges = opened.page.evaluate("figures.map(f => f.plots[0].scales.x.max - f.plots[0].scales.x.min)")
            assert ranges == [pytest.approx(shown, rel=0.2), 10, 10]
            hints = opened.page.locator("#figure-hunts .hint").all_inner_texts()
            assert any("Shown first" in hint and "of 10 s" in hint for hint in hints) == (width == 375)
            opened.page.evaluate("figures[0].zoom()")
            assert opened.page.evaluate("figures[0].plots[0].scales.x.min") == 0
        finally:
            opened.close()
