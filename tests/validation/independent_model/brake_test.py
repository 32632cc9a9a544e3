"""A brake test on degraded rail in one dimension, after the rules of docs/theory: train, axles, brake, slide protection, creep.

Numbers of the test -> [BrakeTest] -> distance, ventings, air of many tests at once (lanes: starts, dead times, rigs)

docs/theory/adhesion.md (A1), (A4) to (A7), docs/theory/creep_laws.md and rig_control.md (D3) to (D5), (D9), (D20). The axles are
points on the rail: no bogie, no lateral motion, one ellipse per wheel; on a rig they roll on their rollers without sliding, and
their torque is known. Every array has one value per lane, or shape (axle, lane).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CRITICAL_RATIO = 0.4  # b of psi in (A5)


@dataclass(frozen=True)
class Rail:
    """Friction (A1), stiffness of the creep curve (A4), the law that makes them a force; per wheel.

    Attributes:
        mu_0, ratio, decay: of (A1): mu_0, A, B [-, -, s/m].
        k_a, k_s: what is left of the stiffness [-].
        f11: of one wheel under its static load [N].
        law: 'saturated', the paper's (20), (23), (24), or 'polach' without spin.
        slow: V_s in the rolling speed [m/s].
    """

    mu_0: float
    ratio: float
    decay: float
    k_a: float
    k_s: float
    f11: float
    law: str
    slow: float

    def force(self, slip: Array, speed: Array, load: Array, static: float) -> Array:
        """Of both wheels on an axle, forward [N]; slip = wheel less train [m/s], loads of the axle [N]."""
        rolling = np.hypot(speed + 0.5 * slip, self.slow)
        creepage = np.abs(slip) / rolling
        mu = self.mu_0 * ((1.0 - self.ratio) * np.exp(-self.decay * np.abs(slip)) + self.ratio)
        available = mu * 0.5 * load
        linear = self.f11 * (load / static) ** (2.0 / 3.0) * creepage  # Hertz: f11 grows as the area
        if self.law == "polach":
            e = 0.25 * np.pi * linear / available
            stick = self.k_a * e
            size = 2.0 / np.pi * available * (stick / (1.0 + stick**2) + np.arctan(self.k_s * e))
        else:
            tau = 0.5 * (self.k_a + self.k_s) * linear / available  # (A4), demanded over available
            size = available * np.where(tau < 3.0, tau - tau**2 / 3.0 + tau**3 / 27.0, 1.0)
        return 2.0 * np.sign(slip) * size


@dataclass(frozen=True)
class Brake:
    """Control valve, cylinder (A5) and friction (A6); names as the keys of [brake]."""

    demand: Array
    application_rate: float
    follow_rate: float
    fill_rate: float
    vent_rate: float
    ambient: float
    volume: float
    piston_area: float
    spring_force: float
    friction: Array
    radius: float
    faces: float
    slow: float

    def torque(self, pressure: Array, turning: Array) -> Array:
        """On the axle, against its turning [N m]."""
        sliding = self.radius * turning
        speed = np.hypot(sliding, self.slow)
        mu = np.interp(speed, self.friction[:, 0], self.friction[:, 1])
        pressed = np.maximum(0.0, self.piston_area * pressure - self.spring_force)
        return -self.faces * self.radius * mu * pressed * sliding / speed

    def step(self, control: float, pressure: Array, valve: Array, time: float, h: float) -> tuple[float, Array, Array]:
        """Control valve, cylinders and what they took [Pa, Pa, m^3 at the ambient] after a step; valve 0 fill, 1 hold, 2 vent."""
        wanted = float(np.interp(time, self.demand[:, 0], self.demand[:, 1]))
        after = control + h * min(self.application_rate, self.follow_rate * (wanted - control))
        supply = 0.5 * (control + after) + self.ambient
        half = pressure
        for part in (0.5, 1.0):  # midpoint
            middle = half
            cylinder = middle + self.ambient
            rate = np.where(valve == 0, self.fill_rate * supply * _psi(cylinder / supply), 0.0)
            rate = np.where(valve == 2, -self.vent_rate * cylinder * _psi(self.ambient / cylinder), rate)
            half = pressure + part * h * rate
        found = np.maximum(0.0, np.where(valve == 0, np.minimum(half, np.maximum(after, pressure)), half))
        return after, found, self.volume / self.ambient * np.maximum(0.0, found - pressure)


def _psi(ratio: Array) -> Array:
    """Flow of an orifice after ISO 6358 over that of choked flow."""
    part = np.clip((ratio - CRITICAL_RATIO) / (1.0 - CRITICAL_RATIO), 0.0, 1.0)
    return np.sqrt(1.0 - part**2)


@dataclass
class SlideProtection:
    """Rules of docs/theory/adhesion.md; `keys` are those of [slide_protection]. All states have shape (axle, lane)."""

    keys: dict[str, float]
    radius: float
    speed: Array  # of the axles' circumference when last sampled
    state: dict[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        axle, lane = np.zeros_like(self.speed), np.zeros(self.speed.shape[1])
        self.state = {name: axle.copy() for name in ("acceleration", "vents", "pulse", "grips", "slid")}
        self.reference, self.known, self.since = self.speed[0].copy(), self.speed[0].copy(), lane.copy()
        self.slope, self.released, self.last = lane.copy(), lane - 1.0, lane - 1.0
        self.released_for = lane.copy()

    def sample(self, turning: Array) -> Array:
        """Valves, 0 fill, 1 hold, 2 vent, from the axles' angular speeds [rad/s]."""
        k, s, h = self.keys, self.state, self.keys["sample_time"]
        speed = self.radius * turning
        s["acceleration"] += h / (k["filter_time"] + h) * ((speed - self.speed) / h - s["acceleration"])
        self.speed = speed
        self._follow(h)
        reference = self.reference
        slip = reference - speed
        fill_below = np.maximum(k["fill_slip"] * reference, k["fill_slip_speed"])
        vent_above = np.maximum(k["vent_slip"] * reference, k["vent_slip_speed"])
        s["grips"] = np.where(slip < fill_below, s["grips"] + h, 0.0)
        s["slid"] = np.where(s["grips"] > k["regained_after"], 0.0, s["slid"])
        locks = (s["acceleration"] < -k["vent_deceleration"]) & (slip > 0.5 * k["fill_slip_speed"])
        recovers = s["acceleration"] > k["recovery_acceleration"]
        released = np.arange(len(speed))[:, None] == self.released
        forced = (reference < k["least_speed"]) | (s["vents"] > k["longest_vent"])
        s["slid"] = np.where(forced, 0.0, s["slid"])
        vents = ~forced & (released | (((slip > vent_above) | locks) & ~recovers))
        grips = ~forced & ~vents & (slip < fill_below)
        pulsed = grips & (s["slid"] > 0.0)
        period = k["pulse_time"] + k["pulse_pause"]
        clock = np.where(pulsed, s["pulse"] + h, s["pulse"])
        s["pulse"] = np.where(vents | (pulsed & (clock > period)), 0.0, clock)
        fills = forced | (grips & ~pulsed) | (pulsed & (s["pulse"] <= k["pulse_time"]))
        s["vents"] = np.where(vents, s["vents"] + h, 0.0)
        s["slid"] = np.where(vents, 1.0, s["slid"])
        return np.where(vents, 2, np.where(fills, 0, 1))

    def _follow(self, h: float) -> None:
        """Reference speed, (A7)."""
        k, s = self.keys, self.state
        nearest = self.speed.max(axis=0)
        self.reference = np.maximum(nearest, self.reference - h * self.slope)
        self.since = self.since + h
        known = (s["slid"] == 0.0).any(axis=0) | (self.reference < k["least_speed"])
        searching = ~known & (self.released >= 0.0)
        begins = ~known & (self.released < 0.0) & (self.since > k["release_interval"]) & (k["release_interval"] > 0.0)
        self.released_for = np.where(searching, self.released_for + h, self.released_for)
        still = np.take_along_axis(s["acceleration"], np.maximum(self.released, 0.0).astype(int)[None], axis=0)[0]
        early = (self.released_for < k["shortest_release"]) | (still > k["recovery_acceleration"])
        ends = searching & ~((self.released_for < k["longest_release"]) & early)
        slope = np.clip((self.known - nearest) / self.since, k["least_deceleration"], k["reference_deceleration"])
        self.slope = np.where(known, k["reference_deceleration"], np.where(ends, slope, self.slope))
        self.reference = np.where(ends, nearest, self.reference)
        learnt = known | ends
        self.known, self.since = np.where(learnt, self.reference, self.known), np.where(learnt, 0.0, self.since)
        self.last = np.where(begins, (self.last + 1.0) % len(self.speed), self.last)
        self.released = np.where(begins, self.last, np.where(learnt, -1.0, self.released))
        self.released_for = np.where(begins, 0.0, self.released_for)


@dataclass(frozen=True)
class Rig:
    """Lanes on a rig, with a controller that is sampled at the step of the test.

    Attributes:
        on_rig: which lanes are on it.
        inertia, radius: of a roller axle [kg m^2, m].
        drive_lag: of the first-order drives [s]; 0: ideal ones.
        lead: of (D20) [s].
        bandwidth, damping: of the feedback, (D6) [rad/s, -].
    """

    on_rig: NDArray[np.bool_]
    inertia: float
    radius: float
    drive_lag: Array
    lead: Array
    bandwidth: float = 2.0 * np.pi * 0.7
    damping: float = 0.7


@dataclass(frozen=True)
class BrakeTest:
    """The test.

    Attributes:
        mass: of the train [kg].
        load: static, of an axle [N].
        transfer: change of each axle's load per acceleration [kg].
        inertia, radius: of a wheelset [kg m^2, m].
        stop: speed at which the test ends [m/s].
        step: of everything, and the sample of a rig's controller [s].
    """

    mass: float
    load: float
    transfer: Array
    inertia: float
    radius: float
    stop: float
    rail: Rail
    brake: Brake
    protection: dict[str, float]
    step: float = 1e-3

    def run(self, speeds: Array, dead_times: Array, rig: Rig | None = None, longest: float = 80.0) -> dict[str, Array]:
        """Distance [m], ventings and air [l] of tests from `speeds` [m/s] with `dead_times` [s] from sample to valve.

        Without a rig all lanes are on track.
        """
        h = self.step
        controller = None if rig is None else _Controller(self, rig, speeds)
        turning = np.tile(speeds / self.radius, (2, 1))
        train, way, slowing = speeds.copy(), np.zeros_like(speeds), np.zeros_like(speeds)
        control, pressure, air = 0.0, np.zeros_like(turning), np.zeros_like(turning)
        unit = SlideProtection(self.protection, self.radius, self.radius * turning)
        late = np.rint(dead_times / h).astype(int)
        sent = np.zeros((int(late.max()) + 1, *turning.shape))  # ring of commands
        every, lanes = round(self.protection["sample_time"] / h), np.arange(len(speeds))
        valve, vented, command = np.zeros_like(turning), np.zeros_like(turning), np.zeros_like(turning)
        running = np.ones(len(speeds), bool)
        for k in range(round(longest / h)):
            if k % every == 0:
                command = unit.sample(turning).astype(float)
            sent[k % len(sent)] = command
            before, valve = valve, sent[(k - late) % len(sent), :, lanes].T if k > late.max() else 0.0 * valve
            vented += running * ((valve == 2.0) & (before != 2.0))
            known = self.brake.torque(pressure, turning)
            control, pressure, taken = self.brake.step(control, pressure, valve, k * h, h)
            air += running * taken
            load = self.load + self.transfer[:, None] * slowing
            torque = 0.5 * (known + self.brake.torque(pressure, turning))
            if controller is None:
                turning, force = self._axles(turning, train, load, torque)
            else:
                turning, force = controller.step(turning, train, load, torque, known)
            slowing = force.sum(axis=0) / self.mass
            way = way + running * h * (train + 0.5 * h * slowing)
            train = np.maximum(train + h * slowing, 0.1)
            running &= train > self.stop
            if not running.any():
                break
        return {"distance": way, "ventings": vented.sum(axis=0), "air": 1e3 * air.sum(axis=0)}

    def _axles(self, turning: Array, train: Array, load: Array, torque: Array) -> tuple[Array, Array]:
        """Angular speeds after a step, exact for a force linear in the slip, and the mean force of the rail in it [N]."""
        slip, small = self.radius * turning - train, 1e-6
        force = self.rail.force(slip, train, load, self.load)
        slope = (self.rail.force(slip + small, train, load, self.load) - force) / small
        rate = -(self.radius**2) * slope / self.inertia
        z = np.clip(self.step * rate, -50.0, 1.0)
        phi = np.where(np.abs(z) > 1e-6, np.expm1(z) / np.where(z == 0.0, 1.0, z), 1.0 + 0.5 * z)
        change = self.step * phi * (torque - self.radius * force) / self.inertia
        mean = (torque - self.inertia * change / self.step) / self.radius  # momentum over the step
        return np.maximum(turning + change, 0.0), mean


class _Controller:
    """Virtual axles from the torque at the sample, (D5) with feedback and lead, drives, and wheels that roll on their rollers."""

    def __init__(self, test: BrakeTest, rig: Rig, speeds: Array) -> None:
        self.test, self.rig = test, rig
        self.virtual = np.tile(speeds / test.radius, (2, 1))
        self.last, self.drive, self.integral = (np.zeros_like(self.virtual) for _ in range(3))
        self.decay = np.where(rig.drive_lag > 0.0, np.exp(-test.step / np.maximum(rig.drive_lag, 1e-9)), 0.0)

    def step(self, turning: Array, train: Array, load: Array, torque: Array, known: Array) -> tuple[Array, Array]:
        """Wheels after a step and the mean force of the rail in it; lanes on track as `_axles` has them."""
        test, rig, h = self.test, self.rig, self.test.step
        ratio = test.radius / rig.radius
        together = test.inertia + rig.inertia * ratio**2
        axle = np.where(rig.on_rig, self.virtual, turning)
        after, force = test._axles(axle, train, load, np.where(rig.on_rig, known, torque))
        wanted = rig.inertia * ratio * (after - axle) / h - rig.radius * force
        error = after - turning
        self.integral = self.integral + h * rig.bandwidth**2 * together / ratio * error
        feedback = 2.0 * rig.damping * rig.bandwidth * together / ratio * error + self.integral
        command = wanted + feedback + rig.lead * (wanted - self.last) / h
        before, self.last = self.drive, wanted
        self.drive = command + (before - command) * self.decay
        mean = np.where(self.decay > 0.0, 0.5 * (before + self.drive), command)
        rolled = np.maximum(turning + h * (torque + ratio * mean) / together, 0.0)
        self.virtual = after
        return np.where(rig.on_rig, rolled, after), force
