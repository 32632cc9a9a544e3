"""Elastic constants of wheel and roller, which are of the same material."""

from typing import Annotated, Any

from pydantic import Field, model_validator

from rollerrig.config.schema.base import Table, instead_of, refused
from rollerrig.config.schema.units import Quantity
from rollerrig.config.schema.vehicle import Name

_MODULUS = Quantity("Pa", 1e5, 1e14)
_POISSON = Quantity("1", 0.0, 0.5)
_MODULI = ("young_modulus", "shear_modulus")


class Material(Table):
    """An isotropic elastic material; one of the two moduli may be left out and follows from E = 2 G (1 + nu)."""

    name: Name = Field(description="name of the material")
    description: str = Field(default="", description="one line about the material")
    source: str = Field(default="", description="where the data come from")
    poisson_ratio: Annotated[float, _POISSON] = Field(description="Poisson's ratio nu")
    young_modulus: Annotated[float, _MODULUS] = Field(
        description="Young's modulus E", json_schema_extra=instead_of("shear_modulus")
    )
    shear_modulus: Annotated[float, _MODULUS] = Field(
        description="shear modulus G", json_schema_extra=instead_of("young_modulus")
    )

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

    @model_validator(mode="after")
    def _consistent(self) -> "Material":
        expected = 2 * self.shear_modulus * (1 + self.poisson_ratio)
        if abs(self.young_modulus - expected) > 1e-3 * expected:
            raise refused(
                "young_modulus",
                f"allowed: 2 G (1 + nu) = {expected:g} Pa, or leave out one of young_modulus and shear_modulus",
            )
        return self
