"""Laws of the configuration as laws of the core: of the same name, with the same parameters.

contact and adhesion of a case -> [core_laws] -> ContactLaws, AdhesionMap of the core
"""

from __future__ import annotations

from typing import Any, TypeAlias

from rollerrig import _core
from rollerrig.assembly.creep_table import shipped_table
from rollerrig.config import Adhesion, Condition, Contact
from rollerrig.config.schema.base import Table
from rollerrig.config.schema.contact_law import CreepRoot
from rollerrig.config.schema.sanding import Sanding
from rollerrig.config.validate.messages import validate

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


def contact_laws(contact: Contact) -> _core.ContactLaws:
    """What the contacts of a case are made of, on a rail in good condition.

    Raises:
        CreepTableError: the table of the creep law `table` cannot be used.
    """
    material = contact.material
    return _core.ContactLaws(
        material=_core.Material(shear_modulus=material.shear_modulus, poisson_ratio=material.poisson_ratio),
        normal=core_law(contact.normal),
        damping=_core.NormalDamping(damping=contact.normal_damping, smoothing_speed=contact.damping_onset),
        creep=core_law(contact.creep),
        friction=_core.Friction(
            law=core_law(contact.friction),
            map=None,
            gauge_face=-1.0 if contact.gauge_face_friction is None else contact.gauge_face_friction,
        ),
        creepage_regularisation_speed=contact.creepage_regularisation_speed,
        roller=_core.RollerEffects(**contact.roller_effects.model_dump()),
    )


def _condition(rail: Condition) -> _core.RailCondition:
    return _core.RailCondition(friction=core_law(rail.friction), k_A=rail.k_A, k_S=rail.k_S)
