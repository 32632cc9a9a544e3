"""How much adhesion the rail has, where or when: degraded track, and what the rig reproduces."""

from collections.abc import Mapping
from contextlib import suppress
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ValidationInfo, field_validator, model_validator

from rollerrig.config.errors import nearest, show_value
from rollerrig.config.schema.base import Mistakes, OrShort, Table, needed, optional
from rollerrig.config.schema.contact import AnyFriction, FallingFriction, Share
from rollerrig.config.schema.units import Quantity

CONDITIONS: Mapping[str, Mapping[str, Any]] = {
    name: {"friction": {"kind": "falling", "mu_0": mu_0, "A": a, "B": b}, "k_A": k_a, "k_S": k_s}
    for name, mu_0, a, b, k_a, k_s in (
        ("dry", 0.55, 0.40, 0.60, 1.0, 0.4),
        ("eurosprinter", 0.358, 0.40, 0.56, 1.0, 0.38),
        ("wet", 0.30, 0.40, 0.20, 0.3, 0.1),
        ("low", 0.08, 0.40, 0.20, 0.3, 0.1),
        ("very_low", 0.04, 0.40, 0.20, 0.3, 0.1),
    )
}
"""Named conditions: dry and wet after Polach (2005); eurosprinter fitted by us to the measured adhesion of that locomotive
(Engel, Beck, Alders 1998; docs/measured.md); low and very low engineering values with the shape of wet."""
ALLOWED = f"{', '.join(CONDITIONS)}, or a table"


class Condition(Table):
    """A rail's surface: friction, and what is left of the creep curve's stiffness."""

    friction: AnyFriction = needed("a number, or a law over slip velocity")
    k_A: Share = optional(
        1.0, "reduction factor of the creep curve's stiffness on the area of adhesion, in place of polach's own"
    )
    k_S: Share = optional(
        1.0,
        "part of the stiffness that is left on the area of slip, at most k_A; the stiffness of laws without k_A and k_S "
        "is times their mean, beside k_0 of modified_fastsim",
    )

    def _mistakes(self) -> Mistakes:
        if self.k_S > self.k_A:
            yield "k_S", f"allowed: at most k_A, {self.k_A:g}"


def _by_name(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    if value in CONDITIONS:
        return dict(CONDITIONS[value])
    guess = nearest(value, tuple(CONDITIONS))
    allowed = f"allowed: {ALLOWED} with friction, k_A, k_S"
    allowed += f"; did you mean {show_value(guess)}?" if guess else ""
    raise ValueError(allowed)


_RECOVERY = {"area": Quantity("m^2/J", 0.0, 1e6), "length": Quantity("m/J", 0.0, 1e6)}


AnyCondition = Annotated[
    Condition, BeforeValidator(_by_name), OrShort({"enum": list(CONDITIONS)}, words=", ".join(CONDITIONS))
]


class Piece(Table):
    """Section from a place, or from a time, on which the rail is another one."""

    distance: Annotated[float, Quantity("m", 0.0, 1e6)] | None = optional(
        None, "distance of the wheel from the vehicle's place at the start, where the piece begins"
    )
    time: Annotated[float, Quantity("s", 1e-6, 1e6)] | None = optional(
        None, "time at which it begins, in place of its position"
    )
    rail: AnyCondition = needed(ALLOWED)


class Adhesion(Table):
    """Adhesion of the rail: on track of the rail itself, on a rig of the virtual rail that the rollers reproduce."""

    rail: AnyCondition = needed(f"condition at the start: {ALLOWED}")
    piece: tuple[Piece, ...] = optional((), "changes over distance or time, ascending", max_length=10_000)
    file: str | None = optional(
        None,
        "CSV file in place of `piece`, relative to the file that names it: columns `distance [m]` and `friction`, of "
        "points evenly apart, between which friction at no slip passes smoothly (`blend` is their spacing), all else as "
        "in `rail`; or `condition`, a name that holds from there on",
    )
    blend: Annotated[float, Quantity("m", 0.0, 1e5)] = optional(
        0.0,
        "length over which one condition passes into the next, like '10 m'; where pieces begin at a time the "
        "time, like '0.1 s'; 0: a jump",
    )
    recovery_per: Literal["area", "length"] = optional(
        "area",
        "reference of the recovery constant: energy per area of the running surface, tau in m^2/J; or per metre "
        "run by a wheel, tau in m/J",
    )
    recovery_constant: Annotated[float, Quantity("m^2/J", 0.0, 1e6)] = optional(
        0.0,
        "tau of the recovery by dissipated energy W, lambda = 1 - exp(-tau W), like '5e-6 m^2/J' or '1.9e-4 m/J': "
        "a text's unit decides `recovery_per`; 0: no recovery",
    )
    wheel_memory: Annotated[float, Quantity("m", 0.0, 1e6)] = optional(
        0.0,
        "sliding cleans the wheel's tread too, and it takes up a film again as it rolls: length over which its "
        "cleaning fades; 0: only the rail is cleaned",
    )
    cell_length: Annotated[float, Quantity("m", 1e-4, 100.0)] = optional(
        0.05, "length of the cells along the rail in which dissipated energy is kept"
    )
    recovered: AnyCondition = optional(
        Condition(friction=FallingFriction(kind="falling", mu_0=0.70, A=0.40, B=0.60)),
        "condition of the rail once it has recovered",
    )

    @property
    def recovery_unit(self) -> str:
        """Unit of the recovery constant."""
        return _RECOVERY[self.recovery_per].unit

    @property
    def over_time(self) -> bool:
        """Whether pieces begin at times."""
        return bool(self.piece) and self.piece[0].time is not None

    @model_validator(mode="before")
    @classmethod
    def _per_area_or_length(cls, data: Any) -> Any:
        """The unit that is written beside the recovery constant says what it goes with."""
        text = data.get("recovery_constant") if isinstance(data, Mapping) else None
        for per, quantity in _RECOVERY.items() if isinstance(text, str) else ():
            with suppress(ValueError):
                return {**data, "recovery_per": per, "recovery_constant": quantity.parse(text)}
        return data  # a text that is neither is refused by the field itself

    @field_validator("blend", mode="before")
    @classmethod
    def _as_the_pieces(cls, value: Any, info: ValidationInfo) -> Any:
        """A length, or a time, whichever the pieces have."""
        over_time = any(piece.time is not None for piece in info.data.get("piece", ()))
        quantity = Quantity("s" if over_time else "m", 0.0, 1e5)
        try:
            return quantity.parse(value)
        except ValueError:
            allowed = f"{quantity.allowed}, as the pieces begin at a {'time' if over_time else 'distance'}"
            raise ValueError(allowed) from None

    @field_validator("file")
    @classmethod
    def _read_with_the_case(cls, value: str | None) -> None:
        if value is not None:
            raise ValueError("allowed in a case, with which it is read")

    def _mistakes(self) -> Mistakes:
        last = -1.0
        for number, piece in enumerate(self.piece):
            place = piece.time if self.over_time else piece.distance
            if place is None or (piece.time is None) == (piece.distance is None):
                yield "piece", "allowed: each piece with `distance`, or each with `time`"
                return
            if not place > last:
                yield "piece", f"allowed: pieces in ascending order; piece[{number}] begins at {place:g} after {last:g}"
            last = place
