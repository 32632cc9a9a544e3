"""Valid cases, spoiled in one to three places: each is refused in words, or it is a case that can be written and checked.

`Mutator` draws from a seed: every run sees the same mutants. Change SEEDS to see others.
"""

from __future__ import annotations

import contextlib
import copy
import random
from collections.abc import Iterator
from typing import Any

import pytest

from rollerrig.cli.describe import describe_case
from rollerrig.config import Case, ConfigError, case_from_toml
from rollerrig.config.validate.messages import tables_below
from rollerrig.simulation.starting_state import StartError

from .schema_walk import Raw, build, whole_cases

SEEDS = range(4)
EACH = 150
SMALL = ("small", "arcs", "flat")
"""Cases of one wheelset; of the others the whole vehicle is left alone."""
KEYS = sorted({name for table in tables_below(Case) for name in table.model_fields})
WORDS = ["", "x", "auto", "none", "rig", "track", "kalman", "sliding_mode", "polach", "hertz", "1:40", "80 km/h", "460 mm",
         "1e300 m", "nan", "-1 s", "5 %", "wheelset_1", "../x.toml", "a\0b", "s1002", "uic60", "curve", "RK4", "dry"]  # fmt: skip
NUMBERS = [0, 1, -1, 2, 0.5, -0.0, 1e-300, 1e300, 10**400, 2**63, float("nan"), float("inf"), 1e-6, 1e-3, 1e3, 1e6]


class Mutator:
    """Spoils raw cases."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)

    def value(self, old: Any) -> Any:
        """Something else: another size, another type, a word, a number that is none."""
        choose = self.random
        sized = isinstance(old, float | int) and not isinstance(old, bool) and abs(old) < 1e300
        if sized and choose.random() < 0.5:
            return old * choose.choice([-1.0, 0.0, 1e-3, 0.1, 0.9, 1.1, 10.0, 1e3, 1e9])
        new = choose.choice(
            [choose.choice(WORDS), choose.choice(NUMBERS), [], {}, True, [old, old], {"kind": old}, [1, 2, 3], None]
        )
        return copy.deepcopy(new) if new is not None else "absent"

    def spoil(self, raw: Raw, places: list[tuple[Any, Any]]) -> None:
        """One deed."""
        holder, key = self.random.choice(places)
        with contextlib.suppress(KeyError, IndexError):  # an earlier deed took it away
            match self.random.choice(["change", "change", "change", "remove", "add", "double", "exchange"]):
                case "change":
                    holder[key] = self.value(holder[key])
                case "remove":
                    del holder[key]
                case "add" if isinstance(holder, dict):
                    holder[self.random.choice(KEYS)] = self.value(1.0)
                case "double" if isinstance(holder, list):
                    holder.append(copy.deepcopy(holder[key]))
                case "exchange":
                    other, there = self.random.choice(places)
                    holder[key], other[there] = copy.deepcopy(other[there]), copy.deepcopy(holder[key])


def places(value: Any, path: str = "") -> Iterator[tuple[Any, Any]]:
    """Every (holder, key) that may be spoiled."""
    keys = value.keys() if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    for key in keys:
        yield value, key
        yield from places(value[key], f"{path}.{key}")


def mutants(seed: int, count: int) -> Iterator[Raw]:
    mutator = Mutator(seed)
    names = sorted(whole_cases())
    for _ in range(count):
        name = mutator.random.choice(names)
        raw = copy.deepcopy(whole_cases()[name])
        whole = raw if name in SMALL else {key: value for key, value in raw.items() if key != "vehicle"}
        for _ in range(mutator.random.choice([1, 1, 2, 3])):
            mutator.spoil(raw, list(places(whole)))
        yield raw


def assess(raw: Raw, look: bool) -> bool:
    """Whether a mutant is a valid case; a mistake that is not told in words is an exception of another kind."""
    try:
        case = build(raw)
    except ConfigError as error:
        mistakes = error.problems
    else:
        assert case_from_toml(case.to_toml()) == case
        if look:
            with contextlib.suppress(ConfigError, StartError):
                describe_case(case)
        return True
    assert mistakes
    assert all("\n" not in str(mistake) and mistake.file for mistake in mistakes)
    return False


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_a_spoiled_case_is_refused_in_words_or_can_be_checked(seed: int) -> None:
    valid = [assess(raw, look=number % 10 == 0) for number, raw in enumerate(mutants(seed, EACH))]
    assert 0.02 < sum(valid) / EACH < 0.6  # neither is the mutator blunt nor are the checks asleep
