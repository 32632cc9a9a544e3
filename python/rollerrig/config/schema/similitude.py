"""The full-scale case of which a case is the model; written by `rollerrig scale`, read to map its results back."""

from typing import Annotated, Literal, get_args

from pydantic import Field

from rollerrig.config.schema.base import Table
from rollerrig.config.schema.units import Quantity
from rollerrig.config.schema.vehicle import Name

StrategyName = Literal["mmu", "dlr", "inrets"]
Kept = Literal["gravity", "material", "clock", "drives"]
KEPT: tuple[Kept, ...] = get_args(Kept)

Factor = Annotated[float, Quantity("1", 1e-4, 1e4)]


class ScaledFrom(Table):
    """What a scaled case is a model of. Its other tables are at the model's own scale: this one changes nothing in a run."""

    case: Name = Field(description="name of the full-scale case")
    strategy: StrategyName = Field(description="choice of the factors of time and density for a length")
    length: Factor = Field(description="a length at full scale over that of the model")
    time: Factor = Field(description="a time at full scale over that of the model")
    density: Factor = Field(description="a density at full scale over that of the model")
    keep: tuple[Kept, ...] = Field(
        default=(),
        description="what a real model cannot scale, or does not: gravity; material of wheels and rollers; clock, sample times "
        "and delays of the controllers; drives, bandwidth of the motors",
    )
