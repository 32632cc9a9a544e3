"""Time until the first picture of a page and pictures per second, in headless Chromium that draws by software at 1280 x 720.

python benchmarks/viewer.py        needs chromium and playwright; about 20 s on a quiet machine
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

import rollerrig as rr
from browser import Opened, chromium


def main() -> None:
    """Print both for a brake test, which lasts 53 s, and for 60 s of a vehicle on irregular track."""
    with chromium() as browser, tempfile.TemporaryDirectory() as folder:
        for name, changes in (("adhesion_brake", {}), ("vehicle_track_irregular", {"time.duration": "60 s"})):
            file = rr.view(rr.simulate(rr.load_case(name).with_changes(changes)), path=Path(folder) / f"{name}.html")
            start = time.perf_counter()
            page = Opened(browser, file, 1280, 720, reduced_motion="no-preference")
            first = time.perf_counter() - start
            page.page.wait_for_timeout(2000)
            before = page.page.evaluate("[rollerrig.frames, performance.now()]")
            page.page.wait_for_timeout(5000)
            after = page.page.evaluate("[rollerrig.frames, performance.now()]")
            rate = (after[0] - before[0]) / (after[1] - before[1]) * 1e3
            size, sharpness = file.stat().st_size / 1e6, page.page.evaluate("rollerrig.stage.sharpness")
            moving = f"{rate:.0f} pictures/s with {sharpness:.2f} of the pixels each way"
            print(f"{name}: {size:.2f} MB, first picture after {first:.2f} s, {moving}")
            page.close()


if __name__ == "__main__":
    main()
