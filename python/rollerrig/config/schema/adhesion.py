"""How much adhesion the rail has, where or when: degraded track, and what the rig reproduces."""

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from rollerrig.config.errors import nearest, show_value
from rollerrig.config.schema.base import Table
from rollerrig.config.schema.units import Quantity

CONDITIONS: Mapping[str, Mapping[str, float]] = {
    "dry": {"mu_0": 0.55, "A": 0.40, "B": 0.60, "k_A": 1.0, "k_S": 0.4},
    "wet": {"mu_0": 0.30, "A": 0.40, "B": 0.20, "k_A": 0.3, "k_S": 0.1},
    "low": {"mu_0": 0.08, "A": 0.40, "B": 0.20, "k_A": 0.3, "k_S": 0.1},
    "very_low": {"mu_0": 0.04, "A": 0.40, "B": 0.20, "k_A": 0.3, "k_S": 0.1},
}
"""Named conditions; dry and wet after Polach (2005), low and very low engineering values with the shape of wet."""

Fraction = Annotated[float, Quantity("1", ge=0, le=1)]
Share = Annotated[float, Quantity("1", gt=0, le=1)]


class Condition(Table):
    """Friction of a rail that falls with slip velocity w: mu_0 ((1 - A) exp(-B w) + A)."""

    mu_0: Fraction = Field(description="friction at no slip")
    A: Fraction = Field(default=1.0, description="friction at large slip over that at none; 1: Coulomb's law")
    B: Annotated[float, Quantity("s/m", ge=0)] = Field(default=0.0, description="how fast it falls with slip")
    k_A: Share = Field(
        default=1.0,
        description="k_A: of the creep curve's stiffness where the patch sticks, in place of [contact]'s own",
    )
    k_S: Share = Field(
        default=1.0, description="k_S: where it slides, at most k_A; laws without k_A and k_S take their mean"
    )

    @model_validator(mode="after")
    def _no_stiffer_in_slip(self) -> "Condition":
        if self.k_S > self.k_A:
            allowed = f"allowed: at most k_A, {self.k_A:g}"
            raise PydanticCustomError("at_key", "{allowed}", {"allowed": allowed, "key": "k_S"})
        return self


def _by_name(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    if value in CONDITIONS:
        return dict(CONDITIONS[value])
    guess = nearest(value, tuple(CONDITIONS))
    allowed = f"allowed: {', '.join(CONDITIONS)}, or a table with mu_0, A, B, k_A, k_S"
    allowed += f"; did you mean {show_value(guess)}?" if guess else ""
    raise PydanticCustomError("condition", "{allowed}", {"allowed": allowed})


AnyCondition = Annotated[Condition, BeforeValidator(_by_name)]


class Piece(Table):
    """From where, or from when, the rail is another one."""

    distance: Annotated[float, Quantity("m", ge=0)] | None = Field(
        default=None, description="of the wheel from the vehicle's place at the start, where the piece begins"
    )
    time: Annotated[float, Quantity("s", gt=0)] | None = Field(default=None, description="when it begins, in its place")
    rail: AnyCondition = Field(description="dry, wet, low, very_low, or a table")


class Adhesion(Table):
    """Adhesion of the rail: on track of the rail itself, on a rig of the virtual rail that the rollers reproduce."""

    rail: AnyCondition = Field(description="condition at the start: dry, wet, low, very_low, or a table")
    piece: tuple[Piece, ...] = Field(default=(), description="where or when it changes, in ascending order")
    blend: Annotated[float, Quantity("m", ge=0)] = Field(
        default=0.0,
        description="length over which one condition passes into the next, like '10 m'; where pieces begin at a time the "
        "time, like '0.1 s'; 0: a jump",
    )
    recovery_constant: Annotated[float, Quantity("m^2/J", ge=0)] = Field(
        default=0.0,
        description="tau: how fast energy spent per area cleans the rail, lambda = 1 - exp(-tau W); 0: nothing is cleaned",
    )
    cell_length: Annotated[float, Quantity("m", gt=0)] = Field(
        default=0.05, description="energy spent is kept along the rail in cells of this length"
    )
    recovered: AnyCondition = Field(
        default=Condition(mu_0=0.70, A=0.40, B=0.60), description="condition of the rail once clean"
    )

    @property
    def over_time(self) -> bool:
        """Whether pieces begin at times."""
        return bool(self.piece) and self.piece[0].time is not None

    @field_validator("blend", mode="before")
    @classmethod
    def _as_the_pieces(cls, value: Any, info: ValidationInfo) -> Any:
        """A length, or a time, whichever the pieces have."""
        over_time = any(piece.time is not None for piece in info.data.get("piece", ()))
        quantity = Quantity("s" if over_time else "m", ge=0)
        try:
            return quantity.parse(value)
        except ValueError:
            allowed = f"{quantity.allowed}, as the pieces begin at a {'time' if over_time else 'distance'}"
            raise PydanticCustomError("blend", "{allowed}", {"allowed": allowed}) from None

    @model_validator(mode="after")
    def _pieces_in_order(self) -> "Adhesion":
        last = -1.0
        for number, piece in enumerate(self.piece):
            place = piece.time if self.over_time else piece.distance
            if place is None or (piece.time is None) == (piece.distance is None):
                allowed = "allowed: each piece with `distance`, or each with `time`"
                raise PydanticCustomError("at_key", "{allowed}", {"allowed": allowed, "key": "piece"})
            if not place > last:
                allowed = f"allowed: pieces in ascending order; piece[{number}] begins at {place:g} after {last:g}"
                raise PydanticCustomError("at_key", "{allowed}", {"allowed": allowed, "key": "piece"})
            last = place
        return self
