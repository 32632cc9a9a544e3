"""The train of which the axles under test brake or pull their part."""

from typing import Annotated

from pydantic import Field

from rollerrig.config.schema.base import Table
from rollerrig.config.schema.units import Mass, Quantity


class Train(Table):
    """The train of which the axles under test brake or pull their part: it runs on a track, on a rig it is reproduced."""

    mass: Mass | None = Field(default=None, description="that these axles brake or pull; absent: what they carry")
    resistance_constant: Annotated[float, Quantity("N", 0.0, 1e8)] = Field(
        default=0.0,
        description="A in the part of the running resistance that these axles overcome, R = A + B v + C v^2",
    )
    resistance_linear: Annotated[float, Quantity("N s/m", 0.0, 1e6)] = Field(default=0.0, description="B")
    resistance_quadratic: Annotated[float, Quantity("N s^2/m^2", 0.0, 1e6)] = Field(default=0.0, description="C")
    gradient: Annotated[float, Quantity("1", -0.1, 0.1)] = Field(default=0.0, description="positive uphill")
