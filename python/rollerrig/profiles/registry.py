"""Names of profiles, and how a configuration asks for one.

To add a profile: write one file with a function that returns a ProfileTable, and add one line to SHAPES.
Its keyword arguments become the keys of the configuration, which config/schema/profile.py lists with their units.
"""

import difflib
import inspect
import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from rollerrig.profiles.analytic import arc, cone, cylinder, s1002, uic60
from rollerrig.profiles.measured import profile_from_file
from rollerrig.profiles.table import ProfileError, ProfileKind, ProfileTable

#: kind in a configuration -> (function that builds it, what it may be used for)
SHAPES: dict[str, tuple[Callable[..., ProfileTable], tuple[ProfileKind, ...]]] = {
    "s1002": (s1002, ("wheel",)),
    "cone": (cone, ("wheel",)),
    "uic60": (uic60, ("rail",)),
    "cylinder": (cylinder, ("rail", "wheel")),
    "arc": (arc, ("rail", "wheel")),
    "file": (profile_from_file, ("wheel", "rail")),
}

#: Names that may stand for a whole specification.
CATALOGUE: dict[str, dict[str, Any]] = {
    "s1002": {"kind": "s1002"},
    "cone_1_40": {"kind": "cone", "conicity": 1 / 40},
    "cone_1_20": {"kind": "cone", "conicity": 1 / 20},
    "uic60_benchmark_1_40": {"kind": "uic60", "variant": "benchmark", "inclination": 1 / 40},
    "uic60_benchmark_1_20": {"kind": "uic60", "variant": "benchmark", "inclination": 1 / 20},
    "en_60e1_1_40": {"kind": "uic60", "variant": "en_13674", "inclination": 1 / 40},
    "en_60e1_1_20": {"kind": "uic60", "variant": "en_13674", "inclination": 1 / 20},
    "cylinder": {"kind": "cylinder"},
}


def profile_from_spec(
    spec: str | Mapping[str, Any], kind: ProfileKind, base_dir: Path | str | None = None
) -> ProfileTable:
    """Build the profile that a configuration asks for.

    Args:
        spec: a name of CATALOGUE, or a mapping with the key `kind` (a name of SHAPES) and the arguments of that
            shape, SI units, and perhaps `length_scale`, a factor on all lengths of the finished curve.
        kind: what the profile is for, "wheel" or "rail".
        base_dir: folder that relative paths start from; the current one by default.

    Returns:
        The table.

    Raises:
        ProfileError: for unknown names and keys, wrong types and shapes that cannot be used.
    """
    if isinstance(spec, str):
        if spec not in CATALOGUE:
            raise ProfileError(f"profile: {_unknown(spec, CATALOGUE)}")
        spec = CATALOGUE[spec]
    if spec.get("kind") == "file":
        return _built(dict(spec), kind, base_dir)
    try:
        return _kept(tuple((key, type(value), value) for key, value in spec.items()), kind)
    except TypeError:  # a value that cannot be a key of a dictionary: no number, and no text
        return _built(dict(spec), kind, base_dir)


@lru_cache(maxsize=64)
def _kept(spec: tuple[tuple[str, type, Any], ...], kind: ProfileKind) -> ProfileTable:
    """A profile that follows from its arguments alone: made once, since tables are constant."""
    return _built({key: value for key, _, value in spec}, kind, None)


def _built(arguments: dict[str, Any], kind: ProfileKind, base_dir: Path | str | None) -> ProfileTable:
    length_scale = arguments.pop("length_scale", 1.0)
    _check_type("profile: length_scale", length_scale, "float")
    shape = arguments.pop("kind", None)
    if not isinstance(shape, str) or shape not in SHAPES:
        raise ProfileError(f"profile: kind: {_unknown(shape, SHAPES)}")
    build, uses = SHAPES[shape]
    if kind not in uses:
        raise ProfileError(f"profile: kind: {shape!r} is a {uses[0]} profile and cannot be used as a {kind}")

    allowed = inspect.signature(build).parameters
    reserved = {"kind", "base_dir"} & allowed.keys()
    for key, value in arguments.items():
        if key not in allowed or key in reserved:
            raise ProfileError(f"profile: {shape}: key {_unknown(key, allowed.keys() - reserved)}")
        annotation = inspect.formatannotation(allowed[key].annotation).strip(
            "'"
        )  # also of a module that delays its own
        _check_type(f"profile: {shape}: {key}", value, annotation)
    for key, parameter in allowed.items():
        if parameter.default is parameter.empty and key not in arguments and key not in reserved:
            raise ProfileError(f"profile: {shape}: key {key!r} is missing")
    if "kind" in reserved:
        arguments["kind"] = kind
    if "base_dir" in reserved:
        arguments["base_dir"] = base_dir
    table = build(**arguments)
    return table if length_scale == 1.0 else table.scaled(length_scale)


def _check_type(where: str, value: object, annotation: str) -> None:
    """Refuse a value that its argument cannot take; literal strings are left to the function that knows them."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if annotation == "float" and not (number and math.isfinite(float(str(value)))):
        raise ProfileError(f"{where}: {value!r} is not a finite number (SI units)")
    if annotation == "bool" and not isinstance(value, bool):
        raise ProfileError(f"{where}: {value!r} is not true or false")
    if annotation not in ("float", "bool") and not (isinstance(value, str) or (number and "float" in annotation)):
        raise ProfileError(f"{where}: {value!r} is not a text{' or a number' if 'float' in annotation else ''}")


def _unknown(found: object, known: Mapping[str, Any] | set[str]) -> str:
    guess = difflib.get_close_matches(str(found), list(known), n=1)
    hint = f"; did you mean {guess[0]!r}?" if guess else ""
    return f"{found!r} is not one of {', '.join(sorted(known))}{hint}"
