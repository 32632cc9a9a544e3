"""Files of profile points, spoiled as points and as bytes: refused in one line, or a profile."""

from __future__ import annotations

import random
import tempfile
from pathlib import Path

import numpy as np

from hostile.bytes_of import NUMBERS, spoiled
from python.profiles.test_measured import rail_points, simpack, wheel_points
from rollerrig.config import ConfigError, load_profile

REFUSALS = (ConfigError,)


def prepare() -> tuple[Path, dict[str, np.ndarray]]:
    return Path(tempfile.mkdtemp(prefix="hostile")), {"wheel": wheel_points(0.5), "rail": rail_points(0.5)}


def attack(prepared: tuple[Path, dict[str, np.ndarray]], choose: random.Random) -> str:
    folder, shapes = prepared
    kind = choose.choice(list(shapes))
    points = shapes[kind].copy()
    for _ in range(choose.choice([0, 1, 1, 2, 4])):
        row = choose.randrange(len(points))
        match choose.choice(["number", "shift", "cut", "double", "turn", "scale"]):
            case "number":
                points[row, choose.randrange(2)] = choose.choice(NUMBERS)
            case "shift":
                points[row:] += [choose.gauss(0.0, 1.0), choose.gauss(0.0, 1.0)]
            case "cut":
                points = points[: row + 1] if choose.random() < 0.5 else points[row:]
            case "double":
                points = np.vstack([points, points[row:]])
            case "turn":
                points[row:] = points[row:][::-1]
            case "scale":
                points *= choose.choice([1e-3, 1e3, -1.0, 1e200, 0.0])
    if choose.random() < 0.3:
        ending = ".prw" if kind == "wheel" else ".prr"
        text = simpack(folder / f"whole{ending}", points).read_text()
    else:
        text, ending = "".join(f"{y!r} {z!r}\n" for y, z in points.tolist()), ".txt"
    content = text.encode()
    if choose.random() < 0.5:
        content = spoiled(content, choose) if content else b"\0"
    path = folder / f"points{ending}"
    path.write_bytes(content)
    try:
        found = load_profile(path, kind)
    except ConfigError as error:
        if any("\n" in str(mistake) for mistake in error.problems):
            return f"nonsense a mistake in several lines: {error}"
        raise
    if found is None:
        return "nonsense no profile"
    return "ran"
