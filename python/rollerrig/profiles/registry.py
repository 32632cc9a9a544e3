"""Which function makes a profile that a configuration asks for.

To add a profile: write one file with a function that returns a ProfileTable, add one line to SHAPES, and its table of keys to
config/schema/profile.py, which checks them: the keys are the function's keyword arguments.
"""

import inspect
from collections.abc import Callable, Mapping
from functools import lru_cache
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


def profile_from_spec(spec: Mapping[str, Any], kind: ProfileKind) -> ProfileTable:
    """Build the profile that a configuration asks for; of a formula once, since tables are constant.

    Args:
        spec: the key `kind` (a name of SHAPES) and the arguments of that shape, SI units, and perhaps `length_scale`, a
            factor on all lengths of the finished curve; see `ProfileSpec.arguments`.
        kind: what the profile is for, "wheel" or "rail".

    Raises:
        ProfileError: it is not for this use, or a file cannot be used.
    """
    build = _built if spec["kind"] == "file" else _kept
    return build(tuple(spec.items()), kind)


def _built(spec: tuple[tuple[str, Any], ...], kind: ProfileKind) -> ProfileTable:
    arguments = dict(spec)
    shape, length_scale = arguments.pop("kind"), arguments.pop("length_scale", 1.0)
    build, uses = SHAPES[shape]
    if kind not in uses:
        raise ProfileError(f"profile: kind: {shape!r} is a {uses[0]} profile and cannot be used as a {kind}")
    if "kind" in inspect.signature(build).parameters:
        arguments["kind"] = kind
    table = build(**arguments)
    return table if length_scale == 1.0 else table.scaled(length_scale)


_kept = lru_cache(maxsize=64)(_built)
