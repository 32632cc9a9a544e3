"""Names and parameters of the creep laws."""

from typing import Annotated, Literal

from pydantic import Field

from rollerrig.config.schema.base import Table
from rollerrig.config.schema.units import Quantity

CreepLawName = Literal["kalker_linear", "kalker_saturated", "fastsim", "modified_fastsim", "polach", "table"]
CREEP_LAWS: tuple[str, ...] = ("kalker_linear", "kalker_saturated", "fastsim", "modified_fastsim", "polach", "table")

Share = Annotated[float, Quantity("1", gt=0, le=1)]


class PolachReduction(Table):
    """How contamination weakens Polach's law: dry 1.0 and 0.4, wet 0.3 and 0.1 (Polach 2005); 1 and 1: clean."""

    k_A: Share = Field(description="k_A, on the area of adhesion")
    k_S: Share = Field(description="k_S, on the area of slip; at most k_A")


class StiffnessReduction(Table):
    """Stiffness of a contaminated surface: initial (ultimate + (1 - ultimate)/(1 + decay tau)) times Kalker's."""

    initial: Share = Field(default=1.0, description="share of Kalker's stiffness at small creepage")
    ultimate: Share = Field(default=1.0, description="share of the initial one that is left at large creepage")
    decay: Annotated[float, Quantity("1", ge=0)] = Field(
        default=0.0, description="how fast it falls with tau, the force of linear theory over the friction limit"
    )


class FrictionFall(Table):
    """Friction that falls with slip velocity w: friction ((1 - A) exp(-B w) + A)."""

    A: Share = Field(default=1.0, description="what is left at high slip velocity")
    B: Annotated[float, Quantity("s/m", ge=0)] = Field(default=0.0, description="how fast it falls")
