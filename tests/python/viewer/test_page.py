"""The page in a browser: asks for nothing, complains of nothing, moves what moved in the run, fits a narrow screen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from browser import Opened
from rollerrig.viewer.columns import interpolated


@pytest.mark.slow
def test_it_asks_for_nothing_and_complains_of_nothing(opened: Opened, both: Path) -> None:
    opened.ask("r.clock.set(0.2)")
    assert opened.requests == [both.as_uri()]
    assert opened.complaints == []


def test_it_holds_no_address(both: Path) -> None:
    text = both.read_text()
    assert "default-src 'none'" in text
    assert not [word for word in ('src="http', "src='http", 'href="http', "import(") if word in text]


def test_the_slider_moves_bodies_as_in_the_run_and_the_picture(opened: Opened, on_rig: xr.Dataset) -> None:
    wheelset = list(on_rig["body"].to_numpy()).index("wheelset_1")
    shots = []
    for time in (0.0, 0.1, 0.22):
        opened.page.evaluate(
            "t => { const s = document.getElementById('time'); s.value = t; s.dispatchEvent(new Event('input')); }",
            time,
        )
        _, y, z = opened.ask(f"(r.tick(performance.now()), r.worlds[0].bodies[{wheelset}].node.position.toArray())")
        lateral = float(on_rig["lateral"].sel(body="wheelset_1").interp(time=time))
        assert y == pytest.approx(lateral, abs=0.05e-3)
        assert z == pytest.approx(0.46, abs=1e-3)
        shots.append(opened.page.locator("#canvas").screenshot())
    assert len(set(shots)) == 3


def test_it_draws_the_curve_whose_error_it_states(opened: Opened) -> None:
    times, column = opened.ask(
        "[Array.from(r.worlds[0].numbers.times), Array.from(r.worlds[0].numbers.columns.get('b2.lateral'))]"
    )
    at = np.linspace(0.0, times[-1], 37)
    drawn = opened.ask(
        f"{at.tolist()}.map((t) => {{ const n = r.worlds[0].numbers; n.seek(t); return n.at('b2.lateral'); }})"
    )
    expected = interpolated(np.array(times), np.array(column)[:, None], at)[:, 0]
    np.testing.assert_allclose(drawn, expected, atol=2e-9)  # times are of 32 bits there


def test_two_runs_go_in_step_and_the_shorter_one_waits(opened: Opened) -> None:
    for time in (0.05, 0.2, 0.4):
        of_world = "(w) => { const n = w.numbers, t = n.times, k = n.frame; return t[k] + n.part * (t[k + 1] - t[k]); }"
        frames = opened.ask(f"(r.clock.set({time}), r.tick(performance.now()), r.worlds.map({of_world}))")
        assert frames == [pytest.approx(time, abs=1e-5), pytest.approx(min(time, 0.3), abs=1e-5)]


def test_a_click_on_a_curve_goes_there_and_a_drag_repeats_that_range(opened: Opened) -> None:
    over = opened.page.locator(".u-over").first
    box = over.bounding_box()
    over.click(position={"x": box["width"] / 2, "y": box["height"] / 2})
    assert opened.ask("r.clock.time") == pytest.approx(0.2, abs=0.01)
    mouse, y = opened.page.mouse, box["y"] + box["height"] / 2
    mouse.move(box["x"] + 0.25 * box["width"], y)
    mouse.down()
    mouse.move(box["x"] + 0.4 * box["width"], y)
    mouse.move(box["x"] + 0.5 * box["width"], y)
    mouse.up()
    assert opened.ask("r.clock.range") == [pytest.approx(0.1, abs=0.01), pytest.approx(0.2, abs=0.01)]
    opened.ask("r.clock.set(0.19), r.clock.toggle(), r.clock.advance(0.02), r.clock.toggle()")
    assert 0.1 <= opened.ask("r.clock.time") < 0.2
    opened.ask("r.clock.repeat(null)")


def test_a_long_oscillation_is_shown_page_by_page(opened: Opened) -> None:
    chart = "r.charts[0]"
    opened.ask(f"({chart}.length = 0.15, 0)")
    for time, page in ((0.05, [0.0, 0.15]), (0.2, [0.15, 0.3]), (0.39, [0.25, 0.4])):
        scale = f"{chart}.plot.scales.x"
        opened.ask(f"(r.clock.set({time}), 0)")
        assert opened.ask(f"[{scale}.min, {scale}.max]") == pytest.approx(page)
    opened.ask(f"({chart}.build(), r.clock.set(0))")  # these runs are short: the whole again
    assert opened.ask(f"{chart}.plot.scales.x.max") == pytest.approx(0.4)


def test_keys(opened: Opened) -> None:
    keyboard = opened.page.keyboard
    opened.ask("(document.activeElement.blur(), r.clock.set(0))")
    keyboard.press("Shift+ArrowRight")
    assert opened.ask("r.clock.time") == pytest.approx(10 * opened.ask("r.clock.step"))
    keyboard.press("4")
    assert opened.ask("r.stage.mode") == "contact"
    assert opened.page.locator(".section").first.is_visible()
    keyboard.press("e")
    opened.ask("0")
    assert "displacements ×" in (opened.page.locator("#note").text_content() or "")
    keyboard.press("1")
    opened.page.locator("#displacement").evaluate("e => { e.value = 0; e.dispatchEvent(new Event('input')); }")
    opened.ask("0")
    assert "displacements" not in (opened.page.locator("#note").text_content() or "")


def test_displacements_are_exaggerated_and_spin_is_not(opened: Opened) -> None:
    body = "r.worlds[0].bodies[2]"
    state = f"(r.clock.set(0.1), r.tick(performance.now()), [{body}.offset.y, {body}.spin.quaternion.y])"
    plain = opened.ask(state)
    larger = opened.ask(f"(r.options.displacement = 10, {state})")
    opened.ask("r.options.displacement = 1")
    assert larger == [pytest.approx(10 * plain[0]), pytest.approx(plain[1])]


def test_what_it_leaves_out_is_said(opened: Opened) -> None:
    text = opened.page.locator(".panel").text_content() or ""
    assert "of 201 samples" in text
    assert "mm" in text
    assert "schematic" in text


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_a_narrow_screen_in_dark_and_light(browser: Any, tmp_path: Path, in_curve: xr.Dataset, scheme: str) -> None:
    page = Opened(
        browser, rr.view(in_curve, path=tmp_path / "curve.html"), 375, 667, color_scheme=scheme, has_touch=True
    )
    try:
        width = page.ask("[document.documentElement.scrollWidth, innerWidth]")
        assert width[0] <= width[1] == 375
        for box in (
            one.bounding_box() for one in page.page.locator("button:visible, select:visible, input:visible").all()
        ):
            assert box["x"] >= 0
            assert box["x"] + box["width"] <= 375
            assert box["height"] >= 24
        canvas = page.page.locator("#canvas").bounding_box()
        assert canvas["width"] > 300
        assert canvas["height"] > 180
        page.page.locator("#look-contact").tap()
        page.page.locator("#play").tap()
        assert page.ask("r.clock.playing") is True
        background = page.ask("getComputedStyle(document.body).backgroundColor")
        assert (background == "rgb(255, 255, 255)") == (scheme == "light")
        assert page.complaints == []
    finally:
        page.close()


def test_two_runs_have_room_on_a_narrow_screen(browser: Any, both: Path) -> None:
    page = Opened(browser, both, 375, 667, has_touch=True)
    try:
        cameras = [one.bounding_box() for one in page.page.locator(".modes button").all()]
        assert len({box["y"] for box in cameras}) == 1  # in one row
        header = page.page.locator("header").bounding_box()
        assert header["height"] < 110
        legend = page.page.locator(".legend")
        assert legend.get_attribute("open") is None  # opened by the reader
        legend.locator("summary").tap()
        assert legend.locator(".scale").first.is_visible()
        top = legend.bounding_box()["y"]
        for name in page.page.locator(".name").all():
            box = name.bounding_box()
            assert box["y"] + box["height"] <= top
    finally:
        page.close()


def test_by_software_light_is_computed_at_the_vertices(opened: Opened) -> None:
    kinds = opened.ask(
        "(() => { const found = new Set(); for (const w of r.worlds)"
        " w.root.traverse((o) => { if (o.isMesh) found.add(o.material.type); }); return [...found].sort(); })()"
    )
    assert kinds == ["MeshBasicMaterial", "ShaderMaterial"]  # the browser of the tests has no graphics processor
    assert opened.ask("r.worlds.every((w) => w.materials.frame.color.getHexString() === '3f5d7d')")
    opened.ask("r.setTheme('dark')")
    assert opened.ask("r.worlds.every((w) => w.materials.frame.color.getHexString() === '4f7399')")
    opened.ask("(r.look('contact'), r.worlds[0].materials.steel.opacity)")
    assert opened.ask("r.worlds[0].materials.steel.opacity") == 0.35
    opened.ask("(r.look('free'), r.setTheme('light'))")
    assert opened.ask("r.worlds[0].materials.steel.opacity") == 1


@pytest.mark.slow
def test_a_brake_test_begins_with_speeds_and_pressures(
    browser: Any, tmp_path: Path, opened: Opened, on_track: xr.Dataset
) -> None:
    braked = rr.simulate(rr.load_case("adhesion_brake").with_changes({"time.duration": "0.2 s"}))
    chosen = "r.charts.map((one) => one.groups[Number(one.choice.value)].title)"
    page = Opened(browser, rr.view(braked, path=tmp_path / "braked.html"))
    try:
        assert page.ask(chosen) == ["Speed, at nominal radii", "Brake cylinder pressure"]
    finally:
        page.close()
    assert opened.ask(chosen) == ["Lateral displacement", "Guiding force Y"]
    page = Opened(browser, rr.view(on_track, braked, path=tmp_path / "both.html"))
    try:  # the rig has curves that the track has not
        keys = page.page.locator(".chart").first.locator(".keys span").all_inner_texts()
        assert [key.strip() for key in keys][:5] == ["train", "wheelset 1", "wheelset 2", "roller 1", "roller 2"]
    finally:
        page.close()


def test_modes_move_by_the_same_page(browser: Any, tmp_path: Path) -> None:
    modes = rr.stability("wheelset_rollers", [60.0, 120.0])
    page = Opened(browser, rr.view(modes, path=tmp_path / "modes.html"))
    try:
        shots = []
        for time in (0.0, 0.03):
            page.ask(f"(r.clock.set({time}), r.tick(performance.now()))")
            shots.append(page.page.locator("#canvas").screenshot())
        assert shots[0] != shots[1]
        assert page.page.locator("#mode option").count() == modes.sizes["mode"]
        before = page.ask("r.clock.end")
        page.page.select_option("#mode", str(modes.sizes["mode"] - 1))
        assert page.ask("r.clock.end") == pytest.approx(4 / float(modes["frequency"][-1, -1]), rel=1e-3)
        assert page.ask("r.clock.end") != before
        assert "no size of its own" in (page.page.locator("#note").text_content() or "")
        assert page.complaints == []
    finally:
        page.close()


ON_THE_WHEEL = """
r.worlds.map((world) => {
  const { shapes } = world.head;
  r.worlds.forEach((w) => w.root.updateMatrixWorld(true));
  return world.contacts.wheels.map((wheel) => {
    const at = wheel.body.node.worldToLocal(wheel.patches.at(-1).node.visible
      ? wheel.patches.at(-1).node.getWorldPosition(wheel.place.clone())
      : wheel.patches[0].node.getWorldPosition(wheel.place.clone()));
    const s = wheel.table.side * at.y - shapes.tape_circle, list = shapes.wheel;
    const k = list.findIndex(([next]) => next > s), [[s0, u0], [s1, u1]] = [list[k - 1], list[k]];
    return Math.hypot(at.x, at.z) - (shapes.wheel_radius + u0 + ((s - s0) / (s1 - s0)) * (u1 - u0));
  });
})
"""
"""Of each wheel how far a drawn patch lies off the drawn profile [m]."""


def test_patches_are_drawn_on_the_wheels(opened: Opened) -> None:
    for time in (0.05, 0.2):
        opened.ask(f"(r.clock.set({time}), r.tick(performance.now()))")
        off = np.array([list(wheels) for wheels in opened.ask(ON_THE_WHEEL)])
        assert off.shape == (2, 4)
        assert np.abs(off).max() < 0.4e-3  # the approach of the surfaces is 0.1 to 0.2 mm


@pytest.mark.slow
def test_patches_are_drawn_on_the_wheels_in_a_canted_curve(browser: Any, tmp_path: Path, in_curve: xr.Dataset) -> None:
    page = Opened(browser, rr.view(in_curve, path=tmp_path / "curve.html"))
    try:
        page.ask("(r.clock.set(3.9), r.tick(performance.now()))")
        assert page.ask("r.worlds[0].line.value('cant', r.worlds[0].numbers.at('distance'))") > 0.02
        assert np.abs(page.ask(ON_THE_WHEEL)[0]).max() < 1e-3  # steep flanks: off across them is less
        ground = page.ask("r.worlds[0].bodies[3].line.position.toArray()")
        assert abs(ground[1]) > 1e-3  # a wheelset far from the middle stands beside the tangent there
    finally:
        page.close()


def test_a_body_is_a_few_meshes(browser: Any, tmp_path: Path, on_rig: xr.Dataset) -> None:
    """What a picture costs without a graphics processor is the number of things that are drawn one by one."""
    import rollerrig as rr

    opened = Opened(browser, rr.view(on_rig, path=tmp_path / "one.html"))
    try:
        for kind, most in (("wheelset", 8), ("roller", 5), ("frame", 1)):
            count = f"""(() => {{ let n = 0; for (const b of r.worlds[0].bodies) if (b.table.kind === {kind!r}) {{
                let own = 0; b.node.traverse(m => {{ own += m.isMesh ? 1 : 0; }}); n = Math.max(n, own); }} return n; }})()"""
            assert 0 < opened.ask(count) <= most, kind
        assert opened.ask("(r.stage.render(), r.stage.renderer.info.render.calls)") < 90
    finally:
        opened.close()
