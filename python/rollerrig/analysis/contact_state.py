"""The contact of the wheels in steady rolling: how deep, how stiff, how conical.

Case -> equilibrium -> [contact_state] -> approach, creep stiffness, kinematic wavelength, equivalent conicity
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.analysis.linearise import Lineariser
from rollerrig.analysis.mode_names import HUNTING_SHARE, wheelset_lateral_share
from rollerrig.analysis.modes import eigensystem, energy_shares, oscillates
from rollerrig.cases import wheelsets
from rollerrig.config import Case
from rollerrig.simulation.starting_state import recorded_state

SLOW = 5 / 3.6
"""Speed at which the hunting mode is kinematic: inertia plays no part [m/s]."""

REFERENCE_SPEED = 100 / 3.6
"""Speed at which approach and creep stiffness are read; they hardly depend on it [m/s]."""


@dataclass(frozen=True)
class ContactState:
    """Numbers of one wheel of the leading wheelset, and of the kinematic motion.

    Attributes:
        patches: number of patches.
        approach: of the deepest patch [m].
        creep_stiffness: sum of f11 over its patches, Kalker's linear theory [N].
        wavelength: of slow hunting [m]; NaN if the motion does not oscillate.
        conicity: that a rigid bogie on track would need for this wavelength [1].
    """

    patches: int
    approach: float
    creep_stiffness: float
    wavelength: float
    conicity: float


@dataclass(frozen=True)
class RollingState:
    """Steady rolling of a case at one speed.

    Attributes:
        speed: [m/s].
        wheels: every recorded signal, as of a run, without time.
        creep_stiffness: per wheel the sum of f11 over its patches, Kalker's linear theory [N].
    """

    speed: float
    wheels: xr.Dataset
    creep_stiffness: dict[str, float]


def rolling_state(case: Case | Lineariser, speed: float) -> RollingState:
    """The equilibrium at a speed [m/s], recorded.

    Raises:
        StartError: no rolling equilibrium was found.
    """
    lineariser = case if isinstance(case, Lineariser) else Lineariser(case)
    linear = lineariser.at(speed)
    wheels = recorded_state(lineariser.simulation_at(speed), lineariser.model, linear.equilibrium).isel(time=0)
    material = lineariser.case.contact.material
    stiffness = {}
    for name in map(str, wheels["wheel"].to_numpy()):
        wheel, total = wheels.sel(wheel=name), 0.0
        for k in range(int(wheel["patch_count"])):
            a, b = float(wheel["patch_a"][k]), float(wheel["patch_b"][k])
            total += _core.kalker_stiffness(a, b, material.shear_modulus, material.poisson_ratio)[0]
        stiffness[name] = total
    return RollingState(speed, wheels, stiffness)


def contact_state(case: Case) -> ContactState:
    """The contact of the leading left wheel in steady rolling, and the wavelength of slow hunting.

    Raises:
        StartError: no rolling equilibrium was found.
    """
    lineariser = Lineariser(case)
    state = rolling_state(lineariser, REFERENCE_SPEED)
    wheel = state.wheels.isel(wheel=0)
    count, stiffness = int(wheel["patch_count"]), state.creep_stiffness[str(wheel["wheel"].item())]
    wavelength = slow_wavelength(lineariser)
    axles = wheelsets(case)
    half_base = 0.5 * abs(axles[0].position[0] - axles[min(1, len(axles) - 1)].position[0])
    half_gauge = lineariser.model.rail_origin_y
    ratio = 1 + (half_base / half_gauge) ** 2
    conicity = case.vehicle.data.wheel.radius * half_gauge * ratio * (2 * math.pi / wavelength) ** 2
    return ContactState(count, float(wheel["patch_approach"].max()), stiffness, wavelength, conicity)


def slow_wavelength(lineariser: Lineariser, speed: float = SLOW) -> float:
    """Wavelength of the least damped mode in which wheelsets weave, at low speed [m]; NaN if none oscillates.

    Klingel's for a lone wheelset, 2 pi sqrt(r l0 / conicity); times sqrt(1 + (half base / l0)^2) for a rigid bogie.
    """
    linear = lineariser.at(speed)
    system = eigensystem(linear.matrix)
    columns = np.flatnonzero(oscillates(system.values)).tolist()
    weave = wheelset_lateral_share(list(linear.rate_rows), energy_shares(linear, system, columns)) >= HUNTING_SHARE
    weaving = system.values[columns][weave]
    if not weaving.size:
        return math.nan
    return 2 * math.pi * speed / float(weaving[np.argmax(weaving.real)].imag)
