"""What is thrown at the core: every argument replaced by what it should not be, one at a time.

valid calls -> [abuses] -> cases with a name each, to be run one after another
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from examples import Call, Examples, described, fields, run_fully
from recipes import Recipe

from rollerrig import _core

Case = tuple[str, Callable[[], Any]]


def label(value: Any) -> str:
    """A short name of an abuse."""
    if isinstance(value, np.ndarray):
        return f"array{list(value.shape)} {value.dtype}" + ("" if value.flags.c_contiguous else ", strided")
    text = (
        repr(value) if not hasattr(type(value), "__init__") or not described(value) else f"{type(value).__name__}(...)"
    )
    return text if len(text) < 60 else f"{text[:50]}... ({len(text)})"


def numbers(value: float) -> list[float]:
    """In place of a floating-point number."""
    spoiled = [math.nan, math.inf, -math.inf, 0.0, -value, -1.0, 1e300, -1e300, 1e-300, 1e30, 1e9, 1e-12]
    return [v for v in spoiled if v != value]


def integers(value: int) -> list[int]:
    """In place of an index or a count."""
    return [v for v in (-1, -2, 0, value + 1, value + 1000, 2**31 - 1, -(2**31), 2**31, 2**70) if v != value]


def arrays(value: np.ndarray) -> Iterator[tuple[str, Any]]:
    """In place of an array."""
    yield " empty", value[:0]
    yield " one short", value[:-1]
    yield " one long", np.concatenate([value, value[-1:]])
    yield " of another dimension", value[None]
    yield " of integers", value.astype(np.int64)
    yield " of another precision", value.astype(np.float64 if value.dtype == np.float32 else np.float32)
    yield " of objects", value.astype(object)
    yield " of complex numbers", value.astype(complex)
    yield " with gaps", np.repeat(value, 2, axis=0)[::2]
    if value.ndim > 1:
        yield " a column short", np.ascontiguousarray(value[:, :-1])
        yield " column by column", np.asfortranarray(value)
    frozen = value.copy()
    frozen.flags.writeable = False
    yield " read-only", frozen
    for number in (math.nan, math.inf, 1e300, -1e300, 1e30, 1e9, 0.0):
        spoiled = value.copy()
        spoiled.flat[-1:] = number
        yield f" ending in {number}", spoiled
        yield f" full of {number}", np.full_like(value, number)


def sequences(value: Any) -> Iterator[Any]:
    """In place of a list or tuple of numbers, rows or objects."""
    yield ()
    yield value[:-1]
    yield [*value, *value[-1:]]
    yield [*value, None]
    yield list(value)[::-1]
    if len(value) > 1:
        yield [value[0]] * len(value)


class _NotAnObject:
    """Of a class that the core has never seen."""


def anything(value: Any) -> list[Any]:
    """Of the wrong type altogether, whatever the argument."""
    spoiled: list[Any] = [None, "nonsense", b"\0", _NotAnObject(), {}, 1j]
    if type(value).__module__ == _core.__name__:
        spoiled.append(type(value).__new__(type(value)))  # never initialised
        spoiled.append(_core.NoneFeedback())
    return spoiled


def replacements(value: Any) -> Iterator[tuple[str, Any]]:
    """Everything that an argument is replaced by, with where in it; an object is made anew around its spoiled part."""
    for spoiled in anything(value):
        yield "", spoiled
    yield from spoiled_parts(value)


def spoiled_parts(value: Any) -> Iterator[tuple[str, Any]]:
    """Values of the right type and the wrong content. An object whose class refuses its spoiled part is left out."""
    if isinstance(value, bool):
        return
    if isinstance(value, int):
        yield from (("", v) for v in integers(value))
    elif isinstance(value, float):
        yield from (("", v) for v in numbers(value))
    elif isinstance(value, str):
        yield from (("", v) for v in ("", "nonsense", "a\0b", value + " ", "x" * 10000))
    elif isinstance(value, np.ndarray):
        yield from arrays(value)
    elif isinstance(value, list | tuple):
        yield from (("", v) for v in sequences(value))
        for i in sorted({0, len(value) - 1} if value else ()):
            for where, spoiled in spoiled_parts(value[i]):
                yield f"[{i}]{where}", [*value[:i], spoiled, *value[i + 1 :]]
    elif described(value):
        own = fields(value)
        for name, part in own.items():
            for where, spoiled in spoiled_parts(part):
                yield f".{name}{where}", Lazily(type(value), own | {name: spoiled})


class Lazily:
    """An object that is made when it is needed, so that what its constructor does counts as part of the abuse."""

    def __init__(self, make: Any, arguments: dict[str, Any]) -> None:
        self.make, self.arguments = make, arguments

    def __repr__(self) -> str:
        return f"{self.make.__name__}(...)"


def made(value: Any) -> Any:
    """The value with everything in it made."""
    if isinstance(value, Lazily):
        return value.make(**{name: made(part) for name, part in value.arguments.items()})
    if isinstance(value, list):
        return [made(item) for item in value]
    return value


def innermost(value: Any) -> Any:
    """The spoiled part itself, for the label."""
    while isinstance(value, Lazily):
        value = next((v for v in value.arguments.values() if isinstance(v, Lazily)), list(value.arguments.values())[-1])
    return value


# ---------------------------------------------------------------------------------------------------- cases


def calls_spoiled(calls: dict[str, Call]) -> Iterator[Case]:
    """Each argument of each call spoiled in turn, or left out."""
    for name, call in calls.items():
        yield f"{name}: as it should be", lambda call=call: call.function(**call.arguments)
        for argument, value in call.arguments.items():
            rest = {k: v for k, v in call.arguments.items() if k != argument}
            yield f"{name}: no {argument}", lambda call=call, rest=rest: call.function(**rest)
            for number, (where, spoiled) in enumerate(replacements(value)):
                shown = f"{name}: {argument}{where} = {label(spoiled)} #{number}"
                yield shown, lambda call=call, a=argument, s=spoiled: call.function(**(call.arguments | {a: made(s)}))


def model_spoiled(recipe: Recipe) -> Iterator[Case]:
    """Each number in a model's description spoiled in turn, the model built, and everything done with it."""
    own, seen = fields(recipe.parts), set()
    for name, value in own.items():
        several = isinstance(value, list) and any(map(described, value))
        for i, item in enumerate(value if several else [value]):
            for number, (where, spoiled) in enumerate(spoiled_parts(item)):
                place = f"{name}{where} #{number}"
                if place in seen:
                    continue  # of another body, another contact
                seen.add(place)
                changed = [*value[:i], spoiled, *value[i + 1 :]] if several else spoiled
                parts = Lazily(_core.ModelParts, own | {name: changed})
                yield (
                    f"{recipe.name}, {place} = {label(spoiled)}",
                    lambda parts=parts: exercise(recipe, parts, recipe.setup),
                )
        for number, spoiled in enumerate(sequences(value) if several else ()):
            parts = Lazily(_core.ModelParts, own | {name: spoiled})
            yield (f"{recipe.name}, {name} #{number} of all", lambda parts=parts: exercise(recipe, parts, recipe.setup))
    for number, (where, spoiled) in enumerate(spoiled_parts(recipe.setup)):
        yield (
            f"{recipe.name}, setup{where} #{number}",
            lambda spoiled=spoiled: exercise(recipe, recipe.parts, spoiled),
        )


def exercise(recipe: Recipe, parts: Any, setup: Any) -> None:
    """Build the model and do everything with it that a program does."""
    model = _core.model_of(made(parts))
    simulation = _core.Simulation(model, made(setup))
    x = recipe.state
    if simulation.state_count != len(x):
        x = np.zeros(simulation.state_count)
    z = np.zeros(simulation.quadrature_count)
    plain = _core.Simulation(model)
    plain.derivative(0.0, x)
    plain.jacobian(0.0, x)
    plain.record(0.0, x, z)
    run_fully(plain, x, method="exponential_rk4", step=1e-3)
    run_fully(simulation, x, method="rk4", step=1e-3)
    run_fully(simulation, x, method="rodas4")
    plain.equilibrium(30.0, 0.0, [])
    _core.StaticWheelsetContact(model, 0, 1).touch_height(0.0, 1e-3, 0.0, 0.0, False)


def all_cases(*, models: bool) -> list[Case]:
    """The cases in a fixed order; with `models` also every number of whole models."""
    examples = Examples()
    found = list(calls_spoiled(examples.calls()))
    if models:
        for recipe in examples.recipes.values():
            found += model_spoiled(recipe)
    return found
