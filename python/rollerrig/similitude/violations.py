"""What a real model of a rig violates: what should be how large, how large it is, and what that does to results.

    full-scale case, its model -> [requirements] -> Requirement, met or not

The numbers follow from the factors alone, docs/theory/similitude.md (M2)-(M5); the contact at rest is computed on both rigs.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rollerrig.assembly.model import assemble
from rollerrig.config import Case, Rig
from rollerrig.config.schema.contact import FallingFriction
from rollerrig.similitude.factors import Similitude
from rollerrig.similitude.scale_case import factors_of
from rollerrig.simulation.starting_state import equilibrium_dataset

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


@dataclass(frozen=True)
class Distortion:
    """Factors by which weight and modulus of the material of the model are wrong, 1 if right [-]."""

    weight: float
    modulus: float

    @property
    def creep_stiffness(self) -> float:
        """(M4): Kalker's coefficients times G a b."""
        return float(self.modulus ** (1.0 / 3.0) * self.weight ** (2.0 / 3.0))

    @property
    def creep_at_saturation(self) -> float:
        """(M5): creepage at which friction is used up."""
        return float((self.weight / self.modulus) ** (1.0 / 3.0))

    @property
    def patch_size(self) -> float:
        """(M3): semi-axes over the wheel's radius."""
        return float((self.weight / self.modulus) ** (1.0 / 3.0))


def distortion(full: Case, model: Case) -> Distortion:
    """What the model's gravity and material make of the contact."""
    factors = factors_of(model)
    modulus = model.contact.material.young_modulus * factors.pressure / full.contact.material.young_modulus
    return Distortion(model.gravity * factors.acceleration / full.gravity, modulus)


def requirements(full: Case, model: Case) -> list[Requirement]:
    """All requirements of similitude between a full-scale case and its model, met or not.

    Args:
        full: the case that was scaled.
        model: made of it by `scale_case`.

    Raises:
        ConfigError: the model has no table [similitude].
    """
    factors, wrong = factors_of(model), distortion(full, model)
    return [*_of_contact(full, model, factors, wrong), *_of_actuators(full, model, factors)]


def _of_contact(full: Case, model: Case, factors: Similitude, wrong: Distortion) -> Iterator[Requirement]:
    g, material, own = full.gravity / factors.acceleration, full.contact.material, model.contact.material
    heavier, softer = "heavy" if wrong.weight > 1 else "light", "soft" if wrong.modulus < 1 else "hard"
    effect = (
        f"wheel loads and friction limits are {wrong.weight:.3g} times what they should be: the model is too {heavier}"
    )
    yield Requirement("weight against inertia (Froude)", "acceleration of gravity", "m/s^2", g, model.gravity, effect)
    what, moduli = "elasticity of the contact (Hertz)", (material.young_modulus / factors.pressure, own.young_modulus)
    effect = (
        f"the material is too {softer}: patches are {wrong.patch_size:.3g} times their size, contact springs and pressures "
        "are wrong with them"
    )
    yield Requirement(what, "Young's modulus", "Pa", *moduli, effect)
    what, of = "creep stiffness (Kalker)", "creep coefficients mapped back over those at full scale"
    effect = (
        f"stability and small sliding are those of wheels that creep {1.0 / wrong.creep_stiffness:.3g} times as much"
    )
    yield Requirement(what, of, "1", 1.0, wrong.creep_stiffness, effect)
    what, effect = "creepage at which friction is used up", "the knee of the creep curve lies elsewhere"
    yield Requirement(what, "of the model over full scale", "1", 1.0, wrong.creep_at_saturation, effect)
    there, here = full.contact.friction, model.contact.friction
    yield Requirement("friction", "coefficient of friction of wheel on roller", "1", there.mu_0, here.mu_0)
    if isinstance(there, FallingFriction) and isinstance(here, FallingFriction) and there.B:
        effect = "friction falls at another slip velocity"
        yield Requirement("friction over slip velocity", "B", "s/m", there.B * factors.speed, here.B, effect)


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
    drives = []
    if full.traction is not None and model.traction is not None:
        drives.append(("traction motors", full.traction.motor, model.traction.motor))
    if full.rig_control is not None and model.rig_control is not None:
        drives.append(("drives of the rollers", full.rig_control.motor, model.rig_control.motor))
    for name, there, own in drives:
        share = own.bandwidth / (there.bandwidth * factors.time)
        effect = f"the {name} are {share:.3g} times as quick as they should be"
        needed = there.bandwidth * factors.time
        yield Requirement(f"lag of the {name}", "bandwidth", "Hz", needed, own.bandwidth, effect)
    if full.brake is not None and model.brake is not None and model.brake.motors_stand_in and full.traction is None:
        motor = model.traction.motor if model.traction else None
        if motor is not None:
            lag, of = 1.0 / (2.0 * math.pi * motor.bandwidth), "time constant of the motors that replace the brakes"
            late = 1e3 * factors.time / (2.0 * math.pi * motor.bandwidth)
            effect = f"the brake acts {late:.3g} ms late at full scale, and within the motors' envelope"
            yield Requirement("brake torque at once", of, "s", 0.0, lag, effect)


@dataclass(frozen=True)
class ContactAtRest:
    """The contact of one wheel in steady running."""

    wheel_load: float  # [N]
    semi_axis: float  # sqrt(a b) of the largest patch [m]
    pressure: float  # largest of all patches [Pa]
    roller_share: float  # semi-axis over the roller's radius [-]


def contact_at_rest(case: Case) -> ContactAtRest:
    """Load and patch of the first wheel at the speed of the case.

    Raises:
        StartError: there is no equilibrium.
    """
    rest = equilibrium_dataset(assemble(case)).isel(time=0, wheel=0)
    load, a, b = (np.nan_to_num(rest[name].to_numpy()) for name in ("patch_normal", "patch_a", "patch_b"))
    there = load > 0.0
    support = case.support.data
    assert isinstance(support, Rig)
    axis = float(np.sqrt(a[there] * b[there]).max())
    return ContactAtRest(
        wheel_load=float(load.sum()),
        semi_axis=axis,
        pressure=float((1.5 * load[there] / (math.pi * a[there] * b[there])).max()),
        roller_share=axis / support.roller_radius,
    )
