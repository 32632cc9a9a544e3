"""Wheel slide protection: dump valves by slip and acceleration, after published principles; not certified."""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, model_validator

from rollerrig.config.schema.actuators import Controller, Deceleration, Pause, Phase, PositiveSpeed, Ratio
from rollerrig.config.schema.base import by_kind, refused
from rollerrig.config.schema.units import Quantity

Entry = Literal["fill", "hold", "vent", "vent_in_steps"]


class ReferencedProtection(Controller):
    """What every law of slide protection has: reference speed, stepwise filling, watchdog."""

    reference_deceleration: Deceleration = Field(
        default=1.6, description="the reference speed falls at most this fast: no train brakes harder"
    )
    release_interval: Pause = Field(
        default=3.0, description="while all axles slide one is released this often for the reference speed; 0: never"
    )
    shortest_release: Pause = Field(
        default=0.3, description="shortest duration of such a release: valve and cylinder need some time"
    )
    longest_release: Phase = Field(default=1.2, description="longest duration of such a release")
    least_deceleration: Deceleration = Field(
        default=0.2,
        description="least deceleration of the reference speed between releases: a braked train slows at least so",
    )
    regained_after: Phase = Field(default=2.0, description="an axle without slip for so long counts as gripping")
    filter_time: Phase = Field(default=0.04, description="filter time of the axles' deceleration")
    recovery_acceleration: Deceleration = Field(
        default=0.5, description="an axle that gains speed faster is left alone"
    )
    pulse_time: Phase = Field(default=0.06, description="after a slide filling is stepwise: open for so long ...")
    pulse_pause: Phase = Field(default=0.14, description="... closed for so long")
    longest_vent: Phase = Field(default=5.0, description="after this the watchdog fills")
    least_speed: PositiveSpeed = Field(default=5.0 / 3.6, description="below it all valves fill")


class SlideProtection(ReferencedProtection):
    """Our law: two slips, a deceleration, written after EN 15595's principles."""

    kind: Literal["slip_and_deceleration"] = Field(
        default="slip_and_deceleration", description="two slips and a deceleration; written after EN 15595's principles"
    )
    vent_slip: Ratio = Field(default=0.12, description="relative slip above which a cylinder is vented")
    vent_slip_speed: PositiveSpeed = Field(default=1.0, description="lower limit of that slip as a speed")
    vent_deceleration: Deceleration = Field(default=4.0, description="a slipping axle that slows faster is vented")
    fill_slip: Ratio = Field(default=0.06, description="relative slip below which a cylinder is filled")
    fill_slip_speed: PositiveSpeed = Field(default=0.5, description="lower limit of that slip as a speed")


class TableSlideProtection(ReferencedProtection):
    """Bands of slip and acceleration, an entry for each: the phases of an anti-lock cycle (Kiencke and Nielsen); numbers ours."""

    kind: Literal["threshold_table"] = Field(
        description="a table over bands of slip and acceleration: the phases of an anti-lock cycle"
    )
    least_slip_reference: PositiveSpeed = Field(
        default=30.0 / 3.6, description="below this reference speed slip is over it, not over the reference"
    )
    slip_thresholds: tuple[Ratio, ...] = Field(
        default=(0.05, 0.1, 0.2), description="relative slips between the rows of `entries`, ascending"
    )
    acceleration_thresholds: tuple[Annotated[float, Quantity("m/s^2", -1e3, 1e3)], ...] = Field(
        default=(-4.0, -1.5, 0.5),
        description="limits of the axle's acceleration, between the columns of `entries`, ascending",
    )
    entries: tuple[tuple[Entry, ...], ...] = Field(
        default=(
            ("hold", "fill", "fill", "fill"),
            ("vent", "hold", "hold", "hold"),
            ("vent", "vent_in_steps", "vent_in_steps", "hold"),
            ("vent", "vent", "vent", "hold"),
        ),
        description="what an axle's valve does: a row for each band of slip, least first, with an entry for each band of "
        "acceleration, strongest deceleration first; after a slide filling is stepwise",
    )

    @property
    def fill_slip(self) -> float:
        """Relative slip below which an axle counts as gripping."""
        return self.slip_thresholds[0] if self.slip_thresholds else 1.0

    @property
    def vent_slip(self) -> float:
        """Relative slip above which a cylinder is vented that does not regain speed."""
        return self.slip_thresholds[-1] if self.slip_thresholds else 1.0

    @model_validator(mode="after")
    def _an_entry_for_each_band(self) -> "TableSlideProtection":
        for key in ("slip_thresholds", "acceleration_thresholds"):
            values = getattr(self, key)
            if list(values) != sorted(set(values)):
                raise refused(key, "allowed: ascending thresholds, each once")
        rows, columns = len(self.slip_thresholds) + 1, len(self.acceleration_thresholds) + 1
        if len(self.entries) != rows or any(len(row) != columns for row in self.entries):
            allowed = (
                f"allowed: {rows} rows of {columns} entries, one for each band between slip_thresholds and between "
            )
            raise refused("entries", f"{allowed}acceleration_thresholds")
        return self


AnySlideProtection = Annotated[
    SlideProtection | TableSlideProtection, Discriminator("kind"), by_kind("slip_and_deceleration")
]


def entry_numbers(table: TableSlideProtection) -> list[int]:
    """Entries row by row, as the core counts them."""
    order: tuple[Any, ...] = ("fill", "hold", "vent", "vent_in_steps")
    return [order.index(entry) for row in table.entries for entry in row]
