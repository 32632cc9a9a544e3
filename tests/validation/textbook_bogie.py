"""Equations of the textbooks for a bogie of two wheelsets: y and yaw of the wheelsets, y, yaw and roll of the frame.

The published model of Cooperrider's bogie, written a second time from its equations, linear and with saturated creep forces and
flanges. What it leaves out of a rolling wheelset can be added: a wheelset that moves sideways rolls, since one wheel climbs.

    roll = rho y, rho = conicity / (l - r conicity); the contacts move s = 1 + r rho times as far as the centre
    equivalent conicity of a cone on an arc of radius R: (l + R conicity) rho

l: half the distance of the contacts, r: radius of the wheels. Roll compresses the vertical primary springs, and makes a
gyroscopic moment; W rho y pulls the wheelset of weight W back, and W l conicity turns it further.
Sources: C. Kaas-Petersen, Chaos in a railway bogie, Acta Mechanica 61 (1986); N. K. Cooperrider, J. Eng. Ind. 94 (1972);
A. H. Wickens, Fundamentals of Rail Vehicle Dynamics, 2003, chapter 2, for what is added.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

Array = NDArray[np.float64]
Y_1, YAW_1, Y_2, YAW_2, Y, YAW, ROLL = range(7)


@dataclass(frozen=True)
class Bogie:
    """SI units; springs and dampers on either side; names of Kaas-Petersen.

    Attributes:
        creep: G pi a b [N]. phi, psi: divide the longitudinal and the lateral creepage [1]. adhesion: mu N [N].
        roll_ratio: rho [rad/m]. spring_roll: the same where the vertical springs are concerned. spin_inertia: of a wheelset about
            its axle [kg m^2]. weight: of a wheelset on the rails [N]. All 0 in the textbook.
    """

    m_w: float = 1022.0
    I_wy: float = 678.0
    m_f: float = 2918.0
    I_fy: float = 6780.0
    I_fr: float = 6780.0
    k1: float = 1.823e6
    k2: float = 3.646e6
    k3: float = 3.646e6
    k4: float = 182.3e3
    k5: float = 333.3e3
    k6: float = 2.71e6
    D1: float = 20e3
    D2: float = 29.2e3
    h1: float = 0.0762
    h2: float = 0.6584
    d1: float = 0.620
    d2: float = 0.680
    a: float = 0.7163
    b: float = 1.074
    r0: float = 0.4572
    conicity: float = 0.05
    creep: float = 6.563e6
    phi: float = 0.60252
    psi: float = 0.54219
    adhesion: float = 10e3
    flange_stiffness: float = 14.6e6
    play: float = 9.1e-3
    roll_ratio: float = 0.0
    spring_roll: float = 0.0
    spin_inertia: float = 0.0
    weight: float = 0.0

    @property
    def lateral_ratio(self) -> float:
        """s."""
        return 1.0 + self.r0 * self.roll_ratio

    @lru_cache(maxsize=64)  # noqa: B019 (bogies are few)
    def matrices(self, speed: float) -> tuple[Array, Array, Array]:
        """Mass, damping and stiffness without creep at a speed [m/s]."""
        unit = np.eye(7)
        damping, stiffness = np.zeros((7, 7)), np.zeros((7, 7))
        for sign, y, yaw in ((1.0, Y_1, YAW_1), (-1.0, Y_2, YAW_2)):
            stretch = unit[y] - unit[Y] - sign * self.b * unit[YAW] - self.h1 * unit[ROLL]
            stiffness += 2 * self.k1 * np.outer(stretch, stretch)
            turn = unit[yaw] - unit[YAW]
            stiffness += 2 * self.k2 * self.d1**2 * np.outer(turn, turn)
            seat = unit[ROLL] - self.spring_roll * unit[y]
            stiffness += 2 * self.k3 * self.d1**2 * np.outer(seat, seat)
            stiffness[y, y] += self.weight * self.roll_ratio
            stiffness[yaw, yaw] -= self.weight * self.conicity * self.a
            gyroscopic = self.spin_inertia * speed / self.r0 * self.roll_ratio
            damping += gyroscopic * (np.outer(unit[yaw], unit[y]) - np.outer(unit[y], unit[yaw]))
        sideways = unit[Y] - self.h2 * unit[ROLL]
        stiffness += 2 * self.k4 * np.outer(sideways, sideways)
        damping += 2 * self.D2 * np.outer(sideways, sideways)
        stiffness[YAW, YAW] += self.k6
        stiffness[ROLL, ROLL] += 2 * self.k5 * self.d2**2
        damping[ROLL, ROLL] += 2 * self.D1 * self.d2**2
        mass = np.diag([self.m_w, self.I_wy, self.m_w, self.I_wy, self.m_f, self.I_fy, self.I_fr])
        return mass, damping, stiffness

    def creepages(self, q: Array, rate: Array, speed: float) -> tuple[Array, Array]:
        """Longitudinal creepage of the right wheels, minus that of the left ones, and lateral creepage."""
        y, yaw = [Y_1, Y_2], [YAW_1, YAW_2]
        along = self.conicity * q[y] / self.r0 + self.a * rate[yaw] / speed
        return along, self.lateral_ratio * rate[y] / speed - q[yaw]

    def creep_forces(self, along: Array, across: Array, *, saturated: bool = True) -> tuple[Array, Array]:
        """Of a wheel, against its creepages [N]."""
        fx, fy = self.creep * along / self.phi, self.creep * across / self.psi
        if not saturated:
            return fx, fy
        u = np.hypot(fx, fy) / self.adhesion + 1e-300
        share = np.where(u < 3.0, 1.0 - u / 3.0 + u * u / 27.0, 1.0 / u)
        return share * fx, share * fy

    def flange_force(self, y: Array) -> Array:
        return self.flange_stiffness * np.sign(y) * np.maximum(np.abs(y) - self.play, 0.0)

    def rates(self, state: Array, speed: float, *, linear: bool = False) -> Array:
        """Time derivative of coordinates and velocities."""
        mass, damping, stiffness = self.matrices(speed)
        q, rate = state[:7], state[7:]
        force = -stiffness @ q - damping @ rate
        fx, fy = self.creep_forces(*self.creepages(q, rate, speed), saturated=not linear)
        force[[YAW_1, YAW_2]] -= 2 * self.a * fx
        force[[Y_1, Y_2]] -= 2 * self.lateral_ratio * fy
        if not linear:
            force[[Y_1, Y_2]] -= self.flange_force(q[[Y_1, Y_2]])
        return np.concatenate([rate, force / np.diag(mass)])

    def eigenvalues(self, speed: float) -> Array:
        """Of the linear equations [1/s]."""
        matrix = np.column_stack([self.rates(column, speed, linear=True) for column in np.eye(14)])
        return np.asarray(np.linalg.eigvals(matrix))

    def critical_speed(self, low: float = 30.0, high: float = 200.0) -> tuple[float, float]:
        """Lowest speed at which an oscillation grows [m/s], its frequency [Hz]."""
        speeds = np.arange(low, high, 2.0)
        growth = [self.eigenvalues(v).real.max() for v in speeds]
        first = next(k for k, g in enumerate(growth) if g > 0)
        found = brentq(lambda v: self.eigenvalues(v).real.max(), speeds[first - 1], speeds[first], xtol=1e-4)
        values = self.eigenvalues(found)
        return float(found), float(abs(values[values.real.argmax()].imag) / (2 * np.pi))

    def run(self, speed: float, offset: float, duration: float = 10.0) -> tuple[Array, Array]:
        """Time [s] and y of wheelset 1 [m] after an offset of it [m]."""
        start = np.zeros(14)
        start[Y_1] = offset
        times = np.arange(0.0, duration, 2e-3)
        found = solve_ivp(lambda _, x: self.rates(x, speed), (0, duration), start, "RK45", times, rtol=1e-6, atol=1e-9)
        return found.t, found.y[Y_1]


def effects(bogie: Bogie, *, rail_radius: float, spin_inertia: float, weight: float) -> dict[str, Bogie]:
    """The bogie, and with one after the other of what its textbook leaves out; heads of the rails of a radius [m]."""
    rho = bogie.conicity / (bogie.a - bogie.r0 * bogie.conicity)
    added: dict[str, dict[str, float]] = {
        "seven equations, as published": {},
        "the row above, with the equivalent conicity of wheelsets that roll": {
            "conicity": (bogie.a + rail_radius * bogie.conicity) * rho
        },
        "the row above, with contacts that move s times as far, the weight": {"roll_ratio": rho, "weight": weight},
        "the row above, with vertical primary springs that the roll compresses": {"spring_roll": rho},
        "the row above, with the gyroscopic moment": {"spin_inertia": spin_inertia},
    }
    found: dict[str, Bogie] = {}
    for name, changes in added.items():
        bogie = found[name] = replace(bogie, **changes)
    return found
