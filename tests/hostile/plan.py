"""Plans of sweeps and fits, and programmes of brake tests, spoiled in one to three places: refused in lines, or described."""

from __future__ import annotations

import copy
import random
import tempfile
import tomllib
from pathlib import Path
from typing import Any

import tomli_w

from python.config.test_mutants import Mutator, places
from rollerrig.config import ConfigError, load_plan
from rollerrig.config.load.case import load_programme
from rollerrig.config.load.fit import load_fit
from rollerrig.config.read import CATALOG_FOLDER
from rollerrig.simulation.starting_state import StartError
from rollerrig.study.sweep import SweepStudy

REFUSALS = (ConfigError, StartError)
READERS = {
    "plans": lambda path: SweepStudy(load_plan(path), many=True).described(),
    "fits": load_fit,
    "programmes": load_programme,
}
PATTERNS = ("*", "*.*", "**", "", ".", "motion", "vehicle.body.*.mass", "disturbance.0.lateral", "vehicle.body[9].mass")
"""Keys and patterns of keys for what a plan changes."""


def prepare() -> tuple[Path, list[tuple[str, dict[str, Any]]]]:
    found = [
        (folder, tomllib.loads(path.read_text(encoding="utf-8")))
        for folder in READERS
        for path in sorted((CATALOG_FOLDER / folder).glob("*.toml"))
    ]
    return Path(tempfile.mkdtemp()) / "spoiled.toml", found


def attack(prepared: tuple[Path, list[tuple[str, dict[str, Any]]]], choose: random.Random) -> str:
    path, plans = prepared
    folder, raw = choose.choice(plans)
    raw, mutator = copy.deepcopy(raw), Mutator(0)
    mutator.random = choose
    for _ in range(choose.choice([1, 1, 2, 3])):
        mutator.spoil(raw, list(places(raw)))
    keys = [(holder, key) for holder, key in places(raw) if key == "key"]
    if keys and choose.random() < 0.3:
        holder, key = choose.choice(keys)
        holder[key] = choose.choice(PATTERNS)
    try:
        path.write_text(tomli_w.dumps(raw), encoding="utf-8")
    except (TypeError, ValueError, AttributeError):  # no TOML has that
        return "refused"
    READERS[folder](path)
    return "ran"
