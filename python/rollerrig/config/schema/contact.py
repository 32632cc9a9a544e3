"""Tables of materials and of the laws of the contact.

    name, number, or table with `kind` and parameters -> [contact_law] -> one of the tables below

A new law is a class here, a member of its union and, in the core, a header: docs/how_to/contact_law.md.
"""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, get_args

from pydantic import BeforeValidator, Discriminator, RootModel, StrictBool, model_validator

from rollerrig.config.schema.base import Mistakes, OrShort, Sourced, Table, by_kind, needed, optional, refused
from rollerrig.config.schema.units import Quantity

_MODULUS = Quantity("Pa", 1e5, 1e14)
_POISSON = Quantity("1", 0.0, 0.5)
_MODULI = ("young_modulus", "shear_modulus")


class Material(Sourced):
    """An isotropic elastic material; one of the two moduli may be left out and follows from E = 2 G (1 + nu)."""

    poisson_ratio: Annotated[float, _POISSON] = needed("Poisson's ratio nu")
    young_modulus: Annotated[float, _MODULUS] = needed("Young's modulus E", instead_of="shear_modulus")
    shear_modulus: Annotated[float, _MODULUS] = needed("shear modulus G", instead_of="young_modulus")

    @model_validator(mode="before")
    @classmethod
    def _other_modulus(cls, data: Any) -> Any:
        if not isinstance(data, dict) or ("young_modulus" in data) == ("shear_modulus" in data):
            return data
        given, other = _MODULI if "young_modulus" in data else _MODULI[::-1]
        try:
            factor = 2 * (1 + _POISSON.parse(data.get("poisson_ratio")))
            value = _MODULUS.parse(data[given])
        except (ValueError, ZeroDivisionError):  # the fields themselves will say what is wrong
            return data
        follows = value / factor if given == "young_modulus" else value * factor
        if not _MODULUS.least <= follows <= _MODULUS.most:
            raise refused(given, f"allowed: such that {other}, here {follows:g} Pa, is {_MODULUS.bounds}")
        return {**data, other: follows}

    def _mistakes(self) -> Mistakes:
        expected = 2 * self.shear_modulus * (1 + self.poisson_ratio)
        if abs(self.young_modulus - expected) > 1e-3 * expected:
            yield "young_modulus", f"allowed: 2 G (1 + nu) = {expected:g} Pa, or leave out one of the two moduli"


Share = Annotated[float, Quantity("1", 1e-6, 1.0)]
Fraction = Annotated[float, Quantity("1", 0.0, 1.0)]
Friction = Annotated[float, Quantity("1", 0.0, 1.5)]


def kinds(laws: Any) -> tuple[str, ...]:
    """Names of the laws of a union, in its order."""
    union = get_args(laws)[0]
    return tuple(get_args(law.model_fields["kind"].annotation)[0] for law in get_args(union))


# ------------------------------------------------------------------------------------------------------------- creep
class Law(Table):
    """What is common to all laws of the contact.

    Attributes:
        limitation: what the law leaves out, a sentence for the reports.
        sources: keys of its publications in `catalog/sources.bib`.
    """

    limitation: ClassVar[str] = ""
    sources: ClassVar[tuple[str, ...]] = ()


class KalkerSaturated(Law):
    """The paper's creep law: Kalker's linear theory, saturated by friction with the cubic of Johnson and Vermeulen."""

    limitation = "The creep force follows Kalker's linear theory, saturated by friction with a heuristic law."
    sources = ("kalker1990", "vermeulen1964")
    kind: Literal["kalker_saturated"] = needed("the paper's law, (20), (23), (24)")
    saturate_spin_moment: StrictBool = optional(False, "scale the spin moment like the force; the paper does not")


class KalkerLinear(Law):
    """Kalker's linear theory: no limit of adhesion."""

    limitation = (
        "The creep force follows Kalker's linear theory without a friction limit: it is valid for small creepage."
    )
    sources = ("kalker1990",)
    kind: Literal["kalker_linear"] = needed("Kalker's linear theory, (20)")


class Coefficients(Law):
    """Kalker's linear theory with coefficients of each patch as given, as textbooks state them."""

    limitation = (
        "The creep force has coefficients as given, whatever the load and the size of the patch; friction, if at all, limits it "
        "by a heuristic law."
    )
    sources = ("kalker1990", "vermeulen1964")
    kind: Literal["coefficients"] = needed("coefficients as given, of one wheel")
    f11: Annotated[float, Quantity("N", 0.0, 1e12)] = needed("longitudinal coefficient")
    f22: Annotated[float, Quantity("N", 0.0, 1e12)] = needed("lateral coefficient")
    f23: Annotated[float, Quantity("N m", 0.0, 1e9)] = optional(0.0, "coefficient of lateral creepage and spin")
    f33: Annotated[float, Quantity("N m^2", 0.0, 1e9)] = optional(0.0, "spin coefficient")
    saturation: StrictBool = optional(
        True, "limit of friction by the cubic of Johnson and Vermeulen, (23), forces and moment alike; false: none"
    )


class Fastsim(Law):
    """Kalker's algorithm FASTSIM."""

    limitation = "The creep force follows Kalker's simplified theory (FASTSIM) on an elliptical patch."
    sources = ("kalker1982",)
    kind: Literal["fastsim"] = needed("Kalker's simplified theory, three flexibilities")


class ModifiedFastsim(Law):
    """FASTSIM with flexibilities of its own for spin; k_0 (k_inf + (1 - k_inf)/(1 + beta eps)) of Kalker's stiffness is left."""

    limitation = "The creep force follows the modified FASTSIM, with an empirical reduction of the initial stiffness."
    sources = ("kalker1982", "spiryagin2013")
    kind: Literal["modified_fastsim"] = needed("FASTSIM for clean, wet and contaminated surfaces")
    k_0: Share = optional(1.0, "part of Kalker's stiffness that is left at small creepage")
    k_inf: Share = optional(1.0, "part of k_0 that is left at large creepage")
    beta: Annotated[float, Quantity("1", 0.0, 1e3)] = optional(
        0.0, "rate of its fall with eps, pi/4 of k_0 times the force of linear theory over mu N, as published"
    )


class Polach(Law):
    """Polach's creep law with spin: k_A, k_S are 1.0 and 0.4 on dry rails, 0.3 and 0.1 on wet ones (2005); 1 and 1: clean."""

    limitation = "The creep force follows Polach's law: an elliptical patch, and spin by an approximate closed form."
    sources = ("polach1999", "polach2005")
    kind: Literal["polach"] = needed("Polach's closed form")
    k_A: Share = needed("part of the stiffness that is left on the area of adhesion")
    k_S: Share = needed("part of the stiffness that is left on the area of slip; at most k_A")


class ExactTable(Law):
    """Kalker's exact theory of rolling contact, read from the table that rollerrig ships."""

    limitation = "The creep force is interpolated in a table of Kalker's exact theory for elliptical patches."
    sources = ("kalker1990",)
    kind: Literal["table"] = needed("the exact theory as a smooth function")


class StripTheory(Law):
    """Creep forces strip by strip, for patches that are bent: on a flat ellipse those of the table."""

    limitation = (
        "The creep force is that of strips with their own normals and spin, "
        "corrected by Kalker's exact theory of an ellipse."
    )
    sources = ("kalker1990", "sichani2016")
    kind: Literal["strip_theory"] = needed("each strip with its own normal, creepage and spin; with normal = 'strips'")


AnyCreep = Annotated[
    KalkerSaturated | KalkerLinear | Coefficients | Fastsim | ModifiedFastsim | Polach | ExactTable | StripTheory,
    by_kind(),
]
CREEP_LAWS = kinds(AnyCreep)


class CreepRoot(RootModel[AnyCreep]):
    """A creep law alone."""


# ------------------------------------------------------------------------------------------------------------ normal
class Hertz(Law):
    """The paper's normal contact: Hertz' ellipse at each indented minimum of the gap."""

    limitation = (
        "Each contact patch is a Hertzian ellipse, also where two patches of a wheel lie close together or the curvature "
        "changes within a patch."
    )
    sources = ("hertz1882",)
    kind: Literal["hertz"] = needed("one ellipse per indented minimum")
    merging_criterion: Annotated[float, Quantity("1", 0.0, 1.0)] = optional(
        0.01,
        "two patches merge smoothly once the rise between them is below this fraction of the approach; 0: the "
        "paper's bare rule, patches appear and vanish at full force",
    )


class Strips(Law):
    """Elastic strips over everything that overlaps: non-elliptical contact patches."""

    limitation = (
        "The normal contact is that of elastic strips: non-elliptical patches, whose pressures are approximate."
    )
    sources = ("johnson1985", "piotrowski2008")
    kind: Literal["strips"] = needed("non-elliptical contact patches")


AnyNormal = Annotated[Hertz | Strips, by_kind()]
NORMAL_LAWS = kinds(AnyNormal)


# ---------------------------------------------------------------------------------------------------------- friction
class ConstantFriction(Law):
    """Coulomb's friction."""

    limitation = "The coefficient of friction is constant."
    kind: Literal["constant"] = needed("one coefficient")
    mu_0: Friction = needed("coefficient of friction")


class FallingFriction(Law):
    """Friction that falls with slip velocity w: mu_0 ((1 - A) exp(-B w) + A)."""

    limitation = "Friction depends on the slip velocity alone, not on temperature or contamination."
    sources = ("polach2005",)
    kind: Literal["falling"] = needed("Polach's friction")
    mu_0: Friction = needed("coefficient of friction at no slip")
    A: Fraction = optional(1.0, "friction at large slip over mu_0; 1: Coulomb's law")
    B: Annotated[float, Quantity("s/m", 0.0, 1e4)] = optional(0.0, "rate of its fall with slip velocity")


def _friction(value: Any) -> Any:
    """A number alone is Coulomb's friction."""
    is_table = isinstance(value, Mapping | Table)
    return value if is_table else {"kind": "constant", "mu_0": value}


AnyFriction = Annotated[
    ConstantFriction | FallingFriction,
    Discriminator("kind"),
    BeforeValidator(_friction),
    OrShort({"type": ["number", "string"]}, words="a number"),
]
