"""Pictures of the page that `rollerrig view` writes, for the documentation: docs/images/view_*.png.

    python scripts/write_view_pictures.py        needs chromium and playwright

The runs are those of the catalogue; the page is opened as a visitor opens it.
"""

from __future__ import annotations

import sys
import tempfile
import threading
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

import rollerrig as rr  # noqa: E402
from browser import Opened, chromium  # noqa: E402
from rollerrig.viewer.play import Theatre, server  # noqa: E402

PICTURES = {
    "view_rig_and_track": (("bogie_rollers_constant", "bogie_track"), "260 km/h", 1.52, "free", "light"),
    "view_brake": (("adhesion_brake",), None, 7.6, "wheelset", "light"),
    "view_contact": (("vehicle_curve",), None, 8.0, "contact", "dark"),
}
"""Name -> cases, another speed, time [s], camera, theme."""

LIVE = {
    "view_live": ("bogie_rollers_constant", {"radius": 0.45, "speed": 280.0}, 6.0),
    "view_live_brake": ("adhesion_brake", {}, 9.0),
}
"""Name -> case, sliders and their values, how long after them [s]."""


def main() -> None:
    """Write all pictures, or those named on the command line."""
    with chromium() as browser, tempfile.TemporaryDirectory() as folder:
        for name, (cases, speed, time, camera, theme) in PICTURES.items():
            if len(sys.argv) > 1 and name not in sys.argv[1:]:
                continue
            chosen = [rr.load_case(case) for case in cases]
            runs = [
                rr.simulate(case.with_changes({"motion.speed": speed, "time.duration": "3 s"}) if speed else case)
                for case in chosen
            ]
            page = Opened(browser, rr.view(*runs, path=Path(folder) / f"{name}.html"), 1280, 720, color_scheme=theme)
            page.page.select_option("#wheel", "1" if camera == "contact" else "0")
            page.ask(f"(r.clock.set({time}), r.look('{camera}'))")
            page.page.wait_for_timeout(300)
            page.page.screenshot(path=ROOT / "docs" / "images" / f"{name}.png")
            page.close()
        for name, given in LIVE.items():
            if len(sys.argv) == 1 or name in sys.argv[1:]:
                live(browser, name, *given)


def live(browser: Any, name: str, case: str, moved: dict[str, float], seconds: float) -> None:
    """A simulation moved by sliders and pushed, after so many seconds."""
    theatre = Theatre(rr.load_case(case))
    listening = server(theatre)
    for work in (listening.serve_forever, theatre.play):
        threading.Thread(target=work, daemon=True).start()
    page = Opened(browser, f"http://127.0.0.1:{listening.server_address[1]}/", 1280, 720)
    for slider, value in moved.items():
        page.page.locator(f"#live-{slider}").evaluate(
            "(e, v) => { e.value = v; e.dispatchEvent(new Event('input')); }", value
        )
        page.page.wait_for_timeout(500)
    page.page.click("#push")
    page.page.wait_for_timeout(1e3 * seconds)
    page.page.evaluate("(rollerrig.keepUp = () => {}, rollerrig.stage.setSharpness(1))")
    page.page.wait_for_timeout(1500)
    page.page.screenshot(path=ROOT / "docs" / "images" / f"{name}.png")
    page.close()
    theatre.ended = True
    listening.shutdown()


if __name__ == "__main__":
    main()
