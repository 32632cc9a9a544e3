"""`rollerrig play`: a simulation whose sliders move it, behind a server that only this machine's own page reaches."""

from __future__ import annotations

import http.client
import json
import socket
import threading
import urllib.request
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import rollerrig as rr
from browser import Opened
from rollerrig import _core
from rollerrig.config import ConfigError
from rollerrig.interfaces.plant import assembled_model
from rollerrig.viewer.exhibition import Exhibition
from rollerrig.viewer.live import FRAME, GAINS, LiveRun, gains
from rollerrig.viewer.play import Theatre, server


def column(run: LiveRun, name: str) -> float:
    value = run.frame()["values"][run.scene["live"]["columns"].index(name)]
    assert value is not None
    return float(value)


def largest(run: LiveRun, name: str, seconds: float) -> float:
    found = 0.0
    for _ in range(round(seconds / FRAME)):
        run.advance(FRAME)
        found = max(found, abs(column(run, name)))
    return found


@pytest.fixture
def run() -> LiveRun:
    return LiveRun(rr.load_case("bogie_rollers_constant"))


def test_it_is_the_run_of_the_case(run: LiveRun) -> None:
    case = rr.load_case("bogie_rollers_constant").with_changes({"time.duration": "0.5 s"})
    expected = rr.simulate(case)["lateral"].sel(body="wheelset_1")
    number = [body["name"] for body in run.scene["bodies"]].index("wheelset_1")
    for _ in range(12):
        run.advance(FRAME)
        lateral = float(expected.interp(time=run.time))
        assert column(run, f"b{number}.lateral") == pytest.approx(lateral, abs=2e-5)  # linear between samples of 2 ms


def test_a_faster_train_hunts_and_a_slower_one_calms_down(run: LiveRun) -> None:
    run.set("speed", 300.0)
    run.push()
    assert largest(run, "b2.lateral", 2.0) > 4e-3
    before = column(run, "b2.lateral")
    run.set("speed", 100.0)
    assert column(run, "b2.lateral") == pytest.approx(before, abs=1e-4)  # goes on from where it was
    largest(run, "b2.lateral", 3.0)
    assert largest(run, "b2.lateral", 0.5) < 0.3e-3


def test_friction_acts_at_once_and_a_torque_turns_into_creep_force(run: LiveRun) -> None:
    run.set("torque", 6.0)
    largest(run, "b2.lateral", 1.0)
    forces = [column(run, f"w{k}.longitudinal_force") for k in range(4)]
    assert sum(forces) == pytest.approx(2 * 6e3 / 0.46, rel=0.03)
    run.set("friction", 0.1)
    largest(run, "b2.lateral", 0.1)
    load = sum(column(run, f"w{k}.vertical_force") for k in range(4))
    assert sum(column(run, f"w{k}.longitudinal_force") for k in range(4)) < 0.1 * 0.3 * load * 1.02


def test_gains_of_the_rig_and_of_slide_protection_act_as_it_goes() -> None:
    run = LiveRun(rr.load_case("adhesion_brake"))
    names = {"slide_protection.vent_slip", "rig_control.estimator.bandwidth", "rig_control.feedback.bandwidth"}
    assert names <= set(run.sliders) <= {"speed", "radius", "friction", "stiffness", "brake"} | set(GAINS)
    estimator = run.sliders["rig_control.estimator.bandwidth"]
    case = rr.load_case("adhesion_brake").rig_control
    assert case is not None
    assert (estimator.unit, estimator.value) == ("Hz", pytest.approx(case.estimator.bandwidth))
    version, time = run.version, run.time
    run.set(estimator.name, 8.0)
    run.set("slide_protection.vent_slip", 0.3)
    assert (run.version, run.time) == (version, time)  # the same run goes on
    acts = {name: run.plant.get(run.plant.find(name)) for name in names}
    assert acts[estimator.name] == pytest.approx(2 * np.pi * 8.0)
    assert acts["slide_protection.vent_slip"] == 0.3
    run.again()
    assert run.plant.get(run.plant.find("slide_protection.vent_slip")) == 0.12


def test_gains_that_are_given_take_the_place_of_bandwidth_and_damping() -> None:
    given = {"rig_control.feedback.proportional": 3e3, "rig_control.feedback.integral": 2e3}
    plant = _core.Plant(assembled_model(rr.load_case("adhesion_step").with_changes(given)))
    ranges = {one.name: (one.least, one.most) for one in gains(plant.variables)}
    assert ranges["rig_control.feedback.proportional"] == pytest.approx((300.0, 12e3))
    assert "rig_control.feedback.integral" in ranges
    assert not {"rig_control.feedback.bandwidth", "rig_control.feedback.damping_ratio"} & set(ranges)


def test_it_is_played_from_python_until_it_is_interrupted() -> None:
    told = []

    def tell(address: str) -> None:
        told.append(address)
        assert b"begin again" in urllib.request.urlopen(address, timeout=5).read()
        raise KeyboardInterrupt

    rr.play("wheelset_rollers", browser=False, tell=tell)
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(told[0], timeout=5)


def test_on_a_narrow_screen_sliders_leave_room_for_the_picture(browser: Any, address: tuple[str, int]) -> None:
    page = Opened(browser, f"http://127.0.0.1:{address[1]}/", 375, 740)
    try:
        assert page.page.evaluate("document.documentElement.scrollWidth") <= 375
        heights = page.page.evaluate("['.view', '.plots', '.clock'].map(n => document.querySelector(n).clientHeight)")
        assert min(heights) > 110
        assert heights[0] > 200
        edges = page.page.evaluate(
            "[...document.querySelectorAll('.desk output')].map(n => n.getBoundingClientRect().right)"
        )
        assert max(edges) <= 375
    finally:
        page.close()


def captions(shown: Exhibition, seconds: float) -> list[str]:
    found = [""]
    for _ in range(round(seconds / FRAME)):
        shown.advance(FRAME)
        found += [shown.caption] if shown.caption != found[-1] else []
    return found[1:]


def test_an_exhibition_moves_itself_says_what_one_sees_and_enlarges_it(
    run: LiveRun, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rollerrig.viewer.exhibition.ACT", 4.0)
    run.set("friction", 0.5)
    shown = Exhibition(run)
    assert captions(shown, 3.9)[-1] == "At 98 km/h the vehicle runs straight."
    assert (run.values["speed"], run.values["friction"]) == (98.0, 1.0)  # the last visitor's friction is gone
    assert shown.enlarged == 20
    hunts = captions(shown, 3.9)[-1]
    assert hunts.startswith("At 255 km/h the leading wheelset swings sideways by ±6 mm, 5.")
    assert hunts.endswith("it hunts.")
    assert shown.enlarged == 5  # 10 would be more than 60 mm
    shown.touched()
    captions(shown, 1.0)
    assert run.values["speed"] == 255.0  # a visitor has it for a minute
    assert shown.frame()["sliders"]["speed"] == 255.0


def test_an_exhibition_of_a_brake_test_speaks_of_sliding() -> None:
    shown = Exhibition(LiveRun(rr.load_case("adhesion_brake")))
    said = captions(shown, 5.0)
    assert said[1].endswith("the vehicle runs straight.")
    assert "% slower than the train runs: they slide." in said[-1]


def test_the_page_of_an_exhibition_has_the_caption_and_moves_its_sliders(browser: Any) -> None:
    theatre = Theatre(rr.load_case("wheelset_rollers"), exhibition=True)
    listening = server(theatre)
    threads = [threading.Thread(target=run, daemon=True) for run in (listening.serve_forever, theatre.play)]
    for thread in threads:
        thread.start()
    page = Opened(browser, f"http://127.0.0.1:{listening.server_address[1]}/", 375, 740)
    try:
        page.page.locator(".caption", has_text="At 98 km/h").wait_for()
        page.page.locator("#note", has_text="displacements ×").wait_for()
        assert page.page.locator("#live-speed").evaluate("e => e.nextSibling.textContent") == "98 km/h"
        assert page.page.evaluate("document.documentElement.scrollWidth") <= 375
        assert page.complaints == []
    finally:
        page.close()
        theatre.ended = True
        listening.shutdown()
        listening.server_close()


def test_another_radius_is_another_scene(run: LiveRun) -> None:
    version = run.version
    run.set("radius", 0.5)
    assert run.version > version
    assert run.scene["shapes"]["roller_radius"] == 0.5
    assert next(body for body in run.scene["bodies"] if body["kind"] == "roller")["at"][2] == -0.5


def test_patches_lie_where_the_wheels_stand(run: LiveRun) -> None:
    run.advance(FRAME)
    for wheel, side in ((0, 1.0), (1, -1.0)):
        assert column(run, f"w{wheel}.p0.y") == pytest.approx(side * 0.75, abs=0.02)
        assert column(run, f"w{wheel}.p0.normal") == pytest.approx(column(run, f"w{wheel}.vertical_force"), rel=0.05)


def test_what_cannot_be_is_refused_and_all_goes_on(run: LiveRun) -> None:
    with pytest.raises(ValueError, match=r"speed: 9000 is not between 10 and 360 km/h"):
        run.set("speed", 9000.0)
    with pytest.raises(KeyError):
        run.set("colour", 1.0)
    curve = LiveRun(rr.load_case("vehicle_curve"))
    with pytest.raises(ConfigError):
        curve.set("speed", 340.0)
    assert curve.values["speed"] == pytest.approx(100.0)
    curve.advance(FRAME)
    assert np.isfinite(column(curve, "b0.lateral"))


def test_a_run_that_ends_begins_again() -> None:
    run = LiveRun(
        rr.load_case("adhesion_brake").with_changes({"motion.speed": "12 km/h", "motion.stop_speed": "8 km/h"})
    )
    told = set()
    for _ in range(round(14 / FRAME)):
        run.advance(FRAME)
        told.add(run.told)
    assert told == {"", "this run has ended; it begins again"}


@pytest.fixture(scope="module")
def address() -> Iterator[tuple[str, int]]:
    theatre = Theatre(rr.load_case("wheelset_rollers"))
    listening = server(theatre)
    threads = [threading.Thread(target=work, daemon=True) for work in (listening.serve_forever, theatre.play)]
    for thread in threads:
        thread.start()
    yield "127.0.0.1", listening.server_address[1]
    theatre.ended = True
    listening.shutdown()
    listening.server_close()
    for thread in threads:
        thread.join(5.0)


def ask(address: tuple[str, int], method: str, path: str, body: Any = None, **headers: str) -> tuple[int, str]:
    connection = http.client.HTTPConnection(*address, timeout=5)
    connection.request(method, path, body if body is None or isinstance(body, str) else json.dumps(body), headers)
    answer = connection.getresponse()
    return answer.status, answer.read().decode()


def test_the_server_answers_its_own_page_alone(address: tuple[str, int]) -> None:
    assert ask(address, "GET", "/")[0] == 200
    assert ask(address, "GET", "/elsewhere")[0] == 404
    assert ask(address, "GET", "/", Host="example.org")[0] == 403
    assert ask(address, "POST", "/again", {}, Origin="http://example.org")[0] == 403
    assert ask(address, "POST", "/shutdown", {})[0] == 403
    assert ask(address, "POST", "/set", {"name": "speed", "value": 60})[0] == 200
    for wrong in (
        {"name": "speed", "value": 1e9},
        {"name": "none", "value": 1},
        {"value": 1},
        {},
        "[1]",
        "no",
        "x" * 2000,
        f'{{"name": "speed", "value": {"9" * 900}}}',
        "[" * 999,
    ):
        code, text = ask(address, "POST", "/set", wrong)
        assert (code, text.count("\n"), bool(text)) == (400, 0, True)


@pytest.mark.parametrize(
    ("headers", "filling"),
    [
        ("Host: {host}\r\nOrigin: http://example.org\r\nContent-Length: {size}", ""),
        ("Host: {host}\r\nContent-Length: {size}", " " * 1000),
        ("Host: {host}\r\nContent-Length: no number", ""),
        ("Host: example.org\r\nContent-Length: {size}", ""),
    ],
    ids=["another page", "too large", "no size", "another name"],
)
def test_the_body_of_a_refused_request_is_no_request(address: tuple[str, int], headers: str, filling: str) -> None:
    assert ask(address, "POST", "/set", {"name": "speed", "value": 60})[0] == 200
    body, host = '{"name": "speed", "value": 200}', f"127.0.0.1:{address[1]}"
    hidden = f"{filling}POST /set HTTP/1.1\r\nHost: {host}\r\nContent-Length: {len(body)}\r\n\r\n{body}"
    with socket.create_connection(address, timeout=10.0) as line:
        head = headers.format(host=host, size=len(hidden))
        line.sendall(f"POST /set HTTP/1.1\r\n{head}\r\n\r\n{hidden}".encode())
        answer = b"".join(iter(lambda: line.recv(65536), b""))
    assert answer.count(b"HTTP/1.") == 1
    sliders = {one["name"]: one["value"] for one in json.loads(ask(address, "GET", "/scene")[1])["live"]["sliders"]}
    assert sliders["speed"] == 60.0


def test_a_connection_that_says_nothing_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rollerrig.viewer.play._PATIENCE", 0.3)
    listening = server(Theatre(rr.load_case("wheelset_rollers")))
    threading.Thread(target=listening.serve_forever, daemon=True).start()
    try:
        with socket.create_connection(listening.server_address[:2], timeout=10.0) as half_open:
            half_open.sendall(b"POST /set HTTP/1.1\r\nHost: ")
            assert half_open.recv(100) == b""  # the end, and not a timeout
    finally:
        listening.shutdown()
        listening.server_close()


def test_no_frame_is_lost_to_one_who_looks_on() -> None:
    theatre = Theatre(rr.load_case("wheelset_rollers"))
    thread = threading.Thread(target=theatre.play, daemon=True)
    thread.start()
    number, times = 0, []
    while number < 20:
        number, _, texts = theatre.frames_after(number)
        times += [json.loads(text)["time"] for text in texts]
    theatre.ended = True
    thread.join(5.0)
    np.testing.assert_allclose(np.diff(times), FRAME, atol=2e-4)


def test_a_browser_moves_it(browser: Any, address: tuple[str, int]) -> None:
    page = Opened(browser, f"http://127.0.0.1:{address[1]}/")
    try:
        page.page.wait_for_timeout(300)
        before = page.page.evaluate("rollerrig.worlds[0].numbers.end")
        page.page.click("#push")
        page.page.locator("#live-speed").evaluate("e => { e.value = 150; e.dispatchEvent(new Event('input')); }")
        page.page.locator("#live-radius").evaluate("e => { e.value = 0.4; e.dispatchEvent(new Event('input')); }")
        for _ in range(100):
            page.page.wait_for_timeout(200)
            state = page.page.evaluate("rollerrig.worlds[0].head.shapes.roller_radius")
            if abs(state - 0.4) < 0.01:
                break
        assert state == pytest.approx(0.4, abs=0.01)
        assert page.page.evaluate("rollerrig.worlds[0].numbers.end") > before
        assert page.complaints == []
        hosts = {url.split("/")[2] for url in page.requests}
        assert hosts == {f"127.0.0.1:{address[1]}"}
    finally:
        page.close()
