"""Tables of the configuration as structs and laws of the core: of the same name, with the same parameters.

    table, numbers that follow from the case -> [part_of] -> object of the core
    one direction of an element -> [force_laws] -> DirectionLaw of the core
    contact and adhesion of a case -> [core_laws] -> ContactLaws, AdhesionMap of the core

The core has no defaults: each stands once, in `rollerrig.config`.
"""

import math
from functools import lru_cache
from typing import Any, TypeAlias, TypeVar, cast

from rollerrig import _core
from rollerrig.assembly.creep_table import shipped_table
from rollerrig.config import Adhesion, AngularSupport, Condition, Contact, LinearSupport, Restraint
from rollerrig.config.schema.base import Table
from rollerrig.config.schema.brakes import Sanding
from rollerrig.config.schema.contact import Coefficients, CreepRoot
from rollerrig.config.schema.vehicle import AngularLaw, LinearLaw
from rollerrig.config.validate.messages import validate

S = TypeVar("S")


def part_of(struct: type[S], table: object, **given: Any) -> S:
    """An object of a class of the core, its parameters from a table or another struct that may have more, or given.

    Args:
        struct: the class; its attribute `fields` has the names.
        table: has an attribute for each parameter that is not given.
        given: parameters by name, in place of the table's.
    """
    names = cast("Any", struct).fields
    return struct(**{name: getattr(table, name) for name in names if name not in given}, **given)


def angular(frequency: float) -> float:
    """A frequency of the configuration [Hz] as the core takes it [rad/s]."""
    return 2.0 * math.pi * frequency


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


CoreLaw: TypeAlias = Any
"""A law of the core: an instance of a class of one of the registries."""
REGISTRIES = (_core.creep_laws, _core.normal_laws, _core.friction_laws)
"""Laws of the core, name -> class: creep, normal contact, friction."""


def core_law(law: Table) -> CoreLaw:
    """The law of the core that a table names.

    Args:
        law: a creep law, a law of normal contact or a friction law.

    Raises:
        CreepTableError: the table of the creep law `table` cannot be used.
    """
    parameters = law.model_dump()
    made = next(registry[parameters["kind"]] for registry in REGISTRIES if parameters["kind"] in registry)
    del parameters["kind"]
    if "table" in made.fields:
        parameters["table"] = shipped_table()
    return made(**parameters)


def creep_law(name: str, **parameters: Any) -> CoreLaw:
    """A creep law of the core by its name.

    Args:
        name: one of CREEP_LAWS.
        parameters: of the law, as in a case's `contact.creep`.

    Raises:
        ValueError: no such law, or a parameter is missing, unknown or outside its range.
        CreepTableError: the table of the law `table` cannot be used.
    """
    law, problems = validate(CreepRoot, {"kind": name, **parameters}, name)
    if law is None:
        raise ValueError("; ".join(map(str, problems)))
    return core_law(law.root)


def adhesion_map(adhesion: Adhesion, sanding: Sanding | None = None) -> _core.AdhesionMap:
    """Condition of the rail over distance or time, with its recovery and the sand on it."""
    recovered = _condition(adhesion.recovered)
    return _core.AdhesionMap(
        pieces=[
            _core.RailAdhesion(
                degraded=_condition(rail),
                recovered=recovered,
                recovery_constant=adhesion.recovery_constant,
                sanded=_condition(sanding.rail) if sanding else recovered,
                sand_constant=1.0 / sanding.saturation if sanding else 0.0,
            )
            for rail in (adhesion.rail, *(piece.rail for piece in adhesion.piece))
        ],
        borders=[float((p.time if adhesion.over_time else p.distance) or 0.0) for p in adhesion.piece],
        blend=adhesion.blend,
        over_time=adhesion.over_time,
    )


def friction(contact: Contact, adhesion: _core.AdhesionMap | None) -> _core.Friction:
    """That of each contact; `adhesion` takes the place of the law."""
    gauge_face = -1.0 if contact.gauge_face_friction is None else contact.gauge_face_friction
    return _core.Friction(law=core_law(contact.friction), map=adhesion, gauge_face=gauge_face)


def contact_laws(contact: Contact) -> _core.ContactLaws:
    """What the contacts of a case have in common.

    Raises:
        CreepTableError: the table of the creep law `table` cannot be used.
    """
    return _core.ContactLaws(
        material=part_of(_core.Material, contact.material),
        normal=core_law(contact.normal),
        damping=_core.NormalDamping(damping=contact.normal_damping, smoothing_speed=contact.damping_onset),
        creep=core_law(contact.creep),
        kalker_factor=contact.kalker_factor,
        creepage_regularisation_speed=contact.creepage_regularisation_speed,
        roller=_core.RollerEffects(**contact.roller_effects.model_dump()),
    )


def linear_coefficients(contact: Contact, a: float, b: float) -> tuple[float, ...]:
    """f11, f22 [N], f23 [N m], f33 [N m^2] of a patch with semi-axes a, b [m]: Kalker's, or as given."""
    own = contact.creep
    if isinstance(own, Coefficients):
        return own.f11, own.f22, own.f23, own.f33
    kalker = kalker_stiffness(contact, a, b)
    return kalker.f11, kalker.f22, kalker.f23, kalker.f33


def kalker_stiffness(contact: Contact, a: float, b: float) -> _core.KalkerStiffness:
    """That of a patch with semi-axes a, b [m] by the linear theory."""
    return _core.kalker_stiffness(a, b, contact.creep_shear_modulus, contact.material.poisson_ratio)


def _condition(rail: Condition) -> _core.RailCondition:
    return part_of(_core.RailCondition, rail, friction=core_law(rail.friction))
