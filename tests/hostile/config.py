"""Cases spoiled in one to six places, and texts that are none: refused in lines, or a case that can be written and checked."""

from __future__ import annotations

import copy
import random
import string
from typing import Any

import tomli_w

from hostile.bytes_of import spoiled
from python.config.schema_walk import whole_cases
from python.config.test_mutants import SMALL, Mutator, places
from rollerrig.cli.describe import describe_case
from rollerrig.config import ConfigError, case_from_toml
from rollerrig.simulation.starting_state import StartError

REFUSALS = (ConfigError, StartError)


def prepare() -> dict[str, Any]:
    return whole_cases()


def attack(cases: dict[str, Any], choose: random.Random) -> str:
    text = hostile_text(cases, choose)
    try:
        case = case_from_toml(text)
    except ConfigError as error:
        if not error.problems or any("\n" in str(mistake) for mistake in error.problems):
            return f"nonsense a mistake in several lines, or none: {error}"
        raise
    if case_from_toml(case.to_toml()) != case:
        return "nonsense another case when it is written and read"
    describe_case(case)
    return "ran"


def hostile_text(cases: dict[str, Any], choose: random.Random) -> str:
    mutator = Mutator(0)
    mutator.random = choose
    name = choose.choice([*sorted(cases), *sorted(SMALL) * 2])  # most inputs are cheap ones
    raw = copy.deepcopy(cases[name])
    whole = raw if name in SMALL else {key: value for key, value in raw.items() if key != "vehicle"}
    for _ in range(choose.choice([1, 2, 3, 6])):
        mutator.spoil(raw, list(places(whole)))
    try:
        text = tomli_w.dumps(raw)
    except (TypeError, ValueError, AttributeError):  # no TOML has that
        text = "[x]\ny = " + choose.choice(["[", "{a = ", "[[", '"']) * choose.choice([1, 50, 3000])
    match choose.choice(["", "", "", "bytes", "noise"]):
        case "bytes":
            return spoiled(text.encode(), choose).decode(errors="replace")
        case "noise":
            at = choose.randrange(len(text) + 1)
            return text[:at] + "".join(choose.choices(string.printable, k=choose.choice([1, 5, 50]))) + text[at:]
    return text
