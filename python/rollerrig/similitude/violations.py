"""What a real model of a rig violates: what should be how large, how large it is, and what that does to results.

    full-scale case, its model -> [requirements] -> Requirement, met or not

The numbers follow from the factors alone, docs/theory/similitude.md (M2)-(M5).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from rollerrig.config import Case
from rollerrig.config.schema.contact import FallingFriction
from rollerrig.similitude.factors import Similitude
from rollerrig.similitude.scale_case import factors_of

_MET = 1e-9
"""A deviation below this is round-off [-]."""


@dataclass(frozen=True)
class Requirement:
    """One requirement of similitude."""

    name: str  # what must be alike
    quantity: str  # of the model, that decides
    unit: str  # of `required` and `actual`
    required: float  # value that reproduces full scale
    actual: float  # value of the model
    effect: str = ""  # what the deviation does to results mapped back, "" if there is none

    @property
    def deviation(self) -> float:
        """Actual over required, less 1 [-]."""
        return self.actual / self.required - 1.0 if self.required else math.inf

    @property
    def met(self) -> bool:
        """Whether results do not feel it."""
        return abs(self.deviation) < _MET


def distortion(full: Case, model: Case) -> tuple[float, float]:
    """Factors by which weight and modulus of the material of the model are wrong, 1 if right [-]."""
    factors = factors_of(model)
    weight = model.gravity * factors.factor("m/s^2") / full.gravity
    modulus = model.contact.material.young_modulus * factors.factor("Pa") / full.contact.material.young_modulus
    return weight, modulus


def requirements(full: Case, model: Case) -> list[Requirement]:
    """All requirements of similitude between a full-scale case and its model, met or not.

    Args:
        full: the case that was scaled.
        model: made of it by `scale_case`.

    Raises:
        ConfigError: the model has no table [similitude].
    """
    return [*_of_contact(full, model), *_of_actuators(full, model, factors_of(model))]


def _of_contact(full: Case, model: Case) -> Iterator[Requirement]:
    factors, (weight, modulus) = factors_of(model), distortion(full, model)
    patch = (weight / modulus) ** (1.0 / 3.0)  # (M3): semi-axes over the wheel's radius; (M5): creepage at saturation
    creep = modulus ** (1.0 / 3.0) * weight ** (2.0 / 3.0)  # (M4): Kalker's coefficients times G a b
    there, here = full.contact, model.contact
    yield Requirement(
        "weight against inertia (Froude)", "acceleration of gravity", "m/s^2",
        full.gravity / factors.factor("m/s^2"), model.gravity,
        f"wheel loads and friction limits are {weight:.3g} times what they should be",
    )  # fmt: skip
    yield Requirement(
        "elasticity of the contact (Hertz)", "Young's modulus", "Pa",
        there.material.young_modulus / factors.factor("Pa"), here.material.young_modulus,
        f"patches are {patch:.3g} times their size, contact springs and pressures are wrong with them",
    )  # fmt: skip
    yield Requirement(
        "creep stiffness (Kalker)", "creep coefficients mapped back over those at full scale", "1", 1.0, creep,
        f"stability and small sliding are those of wheels that creep {1.0 / creep:.3g} times as much",
    )  # fmt: skip
    yield Requirement(
        "creepage at which friction is used up", "of the model over full scale", "1", 1.0, patch,
        "the knee of the creep curve lies elsewhere",
    )  # fmt: skip
    of = "coefficient of friction of wheel on roller"
    yield Requirement("friction", of, "1", there.friction.mu_0, here.friction.mu_0)
    if isinstance(there.friction, FallingFriction) and isinstance(here.friction, FallingFriction) and there.friction.B:
        needed, effect = there.friction.B * factors.factor("m/s"), "friction falls at another slip velocity"
        yield Requirement("friction over slip velocity", "B", "s/m", needed, here.friction.B, effect)


def _of_actuators(full: Case, model: Case, factors: Similitude) -> Iterator[Requirement]:
    for key, name in (
        ("slide_protection", "slide protection"),
        ("wheel_slip_control", "wheel-slip control"),
        ("brake_unit", "brake unit"),
        ("rig_control", "controller of the rollers"),
    ):
        own, there = getattr(model, key), getattr(full, key)
        if own is not None and there is not None:
            needed, actual = there.sample_time / factors.time, own.sample_time
            effect = f"the {name} is asked {needed / actual:.3g} times as often as needed"
            yield Requirement(f"clock of the {name}", "sample time", "s", needed, actual, effect)
    for key, name in (("traction", "traction motors"), ("rig_control", "drives of the rollers")):
        own, there = getattr(model, key), getattr(full, key)
        if own is not None and there is not None:
            needed, actual = there.motor.bandwidth * factors.time, own.motor.bandwidth
            effect = f"the {name} are {actual / needed:.3g} times as quick as they should be"
            yield Requirement(f"lag of the {name}", "bandwidth", "Hz", needed, actual, effect)
    stand_in = full.brake is not None and model.brake is not None and model.brake.by_traction_motors
    if stand_in and full.traction is None and model.traction is not None:
        lag, of = (
            1.0 / (2.0 * math.pi * model.traction.motor.bandwidth),
            "time constant of the motors that replace the brakes",
        )
        late = 1e3 * factors.time * lag
        effect = f"the brake acts {late:.3g} ms late at full scale, and within the motors' envelope"
        yield Requirement("brake torque at once", of, "s", 0.0, lag, effect)
