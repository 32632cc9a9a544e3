"""Ensembles of a test: how far apart what nobody knows may lie from one test to the next."""

from typing import Annotated, Literal

from rollerrig.config.schema.base import Table, optional
from rollerrig.config.schema.units import Quantity

Spread = Annotated[float, Quantity("1", 0.0, 1.0)]


class Ensemble(Table):
    """What differs between the tests of an ensemble; track and rig draw the same.

    The defaults are ours, of the size of what remains between tests of one series: a prepared rail, pads that are bedded in, a
    weighed vehicle, a driver with a speedometer. From day to day adhesion differs by several times as much (Polach 2005 needs
    other parameters for each series of measurements).
    """

    distribution: Literal["uniform", "normal"] = optional(
        "uniform",
        "distribution of each of them within plus and minus its spread; normal: the spread is two standard "
        "deviations, beyond which nothing is drawn",
    )
    adhesion: Spread = optional(0.02, "relative spread of the friction of every rail of [adhesion]")
    pad_friction: Spread = optional(0.02, "relative spread of the friction of the brake pads")
    load: Spread = optional(0.01, "relative spread of the mass of the heaviest body, that of the load")
    speed: Spread = optional(0.005, "relative spread of the speed at the start")
    demand_time: Annotated[float, Quantity("s", 0.0, 100.0)] = optional(
        0.02, "longest delay of the demand for braking or traction: it comes later by 0 to this"
    )
