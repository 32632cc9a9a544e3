"""Calls of the compiled core with several arguments spoiled at once, and whole models with several numbers spoiled.

What is spoiled, and by what, is that of tests/python/core/border, which spoils one thing at a time.
"""

from __future__ import annotations

import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "python" / "core" / "border"))

from abuses import Lazily, exercise, made, replacements, spoiled_parts
from examples import Call, Examples, described, fields
from recipes import Recipe

from rollerrig import _core

REFUSALS = (ValueError, TypeError)
_MODELS = 0.05
"""Part of the inputs that are whole models: each is linearised and run three times."""


def prepare() -> tuple[list[Call], list[Recipe]]:
    examples = Examples()
    return list(examples.calls().values()), list(examples.recipes.values())


def attack(prepared: tuple[list[Call], list[Recipe]], choose: random.Random) -> str:
    calls, recipes = prepared
    if choose.random() < _MODELS:
        spoil_model(choose.choice(recipes), choose)
    else:
        spoil_call(choose.choice(calls), choose)
    return "ran"


def spoil_call(call: Call, choose: random.Random) -> None:
    arguments = dict(call.arguments)
    for name in choose.sample(list(arguments), min(len(arguments), choose.choice([1, 2, 2, 3]))):
        options = list(replacements(arguments[name]) if choose.random() < 0.2 else spoiled_parts(arguments[name]))
        if options:
            arguments[name] = made(choose.choice(options)[1])
    call.function(**arguments)


def spoil_model(recipe: Recipe, choose: random.Random) -> None:
    parts = {name: list(value) if isinstance(value, list) else value for name, value in fields(recipe.parts).items()}
    places = [
        (name, i)
        for name, value in parts.items()
        for i in (range(len(value)) if isinstance(value, list) and any(map(described, value)) else [None])
    ]
    for name, i in choose.sample(places, choose.choice([1, 2, 3, 5])):
        options = list(spoiled_parts(parts[name] if i is None else parts[name][i]))
        if options:
            spoiled = choose.choice(options)[1]
            parts |= {name: spoiled if i is None else [*parts[name][:i], spoiled, *parts[name][i + 1 :]]}
    exercise(recipe, Lazily(_core.ModelParts, parts), recipe.setup)
