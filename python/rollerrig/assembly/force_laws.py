"""Laws of a vehicle's elements and of supports, as laws of the core: of the same name, with the same parameters.

one direction of an element -> [force_laws] -> DirectionLaw of the core
"""

from __future__ import annotations

from functools import lru_cache

from rollerrig import _core
from rollerrig.config import AngularSupport, LinearSupport, Restraint
from rollerrig.config.schema.base import Table
from rollerrig.config.schema.vehicle import AngularLaw, LinearLaw

Support = LinearSupport | AngularSupport | Restraint
"""What stands between the ground and a body, in one direction."""


def direction_law(law: LinearLaw | AngularLaw | Support | None, preload: float) -> _core.DirectionLaw:
    """One direction of an element, as the core takes it: every key of a law of the core's registry that is given.

    A key holds the law's table, or its only parameter, which has the law's name; 0 is no law.

    Args:
        law: what acts in this direction; its own `preload` acts on body a's side, so that body b feels the opposite. None:
            nothing but the preload.
        preload: further force on body b along the positive axis at the design position [N].
    """
    if law is None:
        return _preloaded(preload)
    given = {name: value for name in _core.force_laws if (value := getattr(law, name, None))}
    return _core.DirectionLaw(
        preload=preload - getattr(law, "preload", 0.0),
        laws=[
            _core.force_laws[name](**(value.model_dump() if isinstance(value, Table) else {name: value}))
            for name, value in given.items()
        ],
    )


@lru_cache(maxsize=256)  # four of five directions of a vehicle's elements have no law
def _preloaded(preload: float) -> _core.DirectionLaw:
    return _core.DirectionLaw(preload=preload, laws=[])
