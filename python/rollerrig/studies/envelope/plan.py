"""What is run for an envelope map: axle torques, adhesions of the virtual rail and axle loads, and the test at each of them.

Case of a rig with [rig_control] -> [plan] -> one case per point

At each point the torque is put on within RISE and stays; slide protection or wheel-slip control, the case's or else one with
default settings, lets the wheels slide and regain speed. The case's own cylinders and motors would be slower: here the torque is
what is asked for, so that the map speaks of the rig.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from rollerrig.config import Brake, Case, ConfigError, ConfigProblem, Rig, Traction
from rollerrig.studies.envelope.lines import rig_numbers
from rollerrig.studies.envelope.virtual_rail import rail_shape

BEGIN, RISE = 0.1, 0.2
"""The torque begins to act, and takes so long to its full value [s]."""

FOLLOW = 200.0
"""Rate of the test's control valve and cylinder [1/s]: the torque follows the ramp within a few ms."""

ADHESIONS = (0.02, 0.04, 0.06, 0.08, 0.12, 0.16, 0.20, 0.25, 0.30, 0.36)
LOADS = (0.6, 1.0, 1.4)
TORQUES = 12
"""Torques of a default map."""

MOST_RUNS = 100_000
MOST_REFINED = 4


def torque_text(torque: float) -> str:
    """A torque [N m] for people; the blanks do not break."""
    scaled, unit = (1e-3 * torque, "kN\u00a0m") if abs(torque) >= 500.0 else (torque, "N\u00a0m")
    return f"{scaled:.4g}\u00a0{unit}"


class Point(NamedTuple):
    """A place on the map: axle load over the case's own [-], torque on each axle, positive forward [N m], adhesion [-]."""

    load: float
    torque: float
    adhesion: float

    @property
    def label(self) -> str:
        """For people."""
        return f"{torque_text(self.torque)}, adhesion\u00a0{self.adhesion:.3g}, load\u00a0{self.load:.3g}"


@dataclass(frozen=True)
class Plan:
    """The points of a map.

    Attributes:
        case: of a rig with [rig_control].
        torques: on each axle, ascending; negative brakes [N m].
        adhesions: of the virtual rail at no slip, ascending [-].
        loads: axle loads over the case's own, ascending [-].
        duration: of each run [s].
        refine: how many times cells between different regions are halved.
    """

    case: Case
    torques: tuple[float, ...]
    adhesions: tuple[float, ...] = ADHESIONS
    loads: tuple[float, ...] = LOADS
    duration: float = 3.0
    refine: int = 1

    def __post_init__(self) -> None:
        """Refuse what cannot be run.

        Raises:
            ConfigError: all mistakes found.
        """
        problems = list(_problems(self))
        if problems:
            raise ConfigError(problems)

    @cached_property
    def lattice(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Torques and adhesions with all that refining may add."""
        parts: int = 2**self.refine
        return _between(self.torques, parts), _between(self.adhesions, parts)

    def test(self) -> dict[str, Any]:
        """What, beside the case, the result of a run depends on."""
        return {"duration_s": self.duration, "begin_s": BEGIN, "rise_s": RISE}


def make_plan(
    case: Case,
    *,
    torques: Sequence[float] | None = None,
    adhesions: Sequence[float] | None = None,
    loads: Sequence[float] | None = None,
    duration: float = 3.0,
    refine: int = 1,
) -> Plan:
    """The plan of a map; what is not given follows from the case.

    Raises:
        ConfigError: all mistakes found.
    """
    check_case(case)
    return Plan(
        case,
        tuple(map(float, default_torques(case) if torques is None else torques)),
        tuple(map(float, ADHESIONS if adhesions is None else adhesions)),
        tuple(map(float, LOADS if loads is None else loads)),
        duration,
        refine,
    )


def check_case(case: Case) -> None:
    """Refuse a case that reproduces nothing.

    Raises:
        ConfigError: it is not that of a rig with [rig_control].
    """
    if not isinstance(case.support.data, Rig) or case.rig_control is None:
        needed = (
            "needed: a case on rollers with [rig_control], which reproduces a track; rollerrig catalog lists adhesion_*"
        )
        raise ConfigError([ConfigProblem(case.name, "rig_control", "missing", needed)])


def default_torques(case: Case) -> list[float]:
    """Beyond what rollers or their drives carry, in round steps; brakes for a case with [brake], otherwise traction."""
    rig = rig_numbers(case)
    raw = 1.3 * max(min(rig.contact(), rig.drive_grip()), 1e-6) / TORQUES
    power = 10.0 ** math.floor(math.log10(raw))
    step = min((1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0), key=lambda s: abs(s * power - raw)) * power
    rising = [float(f"{step * k:.9g}") for k in range(1, TORQUES + 1)]
    return [-torque for torque in reversed(rising)] if case.brake is not None else rising


def vehicle_torque(case: Case, brakes: bool) -> float | None:
    """Largest torque that the vehicle itself exerts on an axle at the start [N m]; None: no limit is known.

    Of its brake at the demand's largest pressure, (A6), or of its motor's envelope.
    """
    axle_speed = case.motion.speed / case.vehicle.data.wheel.radius
    if brakes and case.brake is not None:
        brake = case.brake
        speeds, friction = np.array(brake.friction).T
        pressure = max(row[1] for row in brake.demand)
        grip = float(np.interp(brake.friction_radius * axle_speed, speeds, friction))
        clamped = max(0.0, brake.piston_area * pressure - brake.spring_force)
        return brake.faces * brake.friction_radius * grip * clamped
    envelope = case.traction.motor.envelope if case.traction is not None else None
    return None if brakes or envelope is None else float(np.interp(axle_speed, *np.array(envelope).T))


# ---------------------------------------------------------------------------------------------- the case of a point


def point_case(plan: Plan, point: Point) -> Case:
    """The test at one point of the map."""
    case = plan.case
    changes: dict[str, object] = {
        "time.duration": plan.duration,
        "time.output_step": 5.0 * case.bench.step,
        "adhesion": {"rail": _rail(case, point.adhesion)},
        **_load_changes(case, point.load),
        **(_braking(case, -point.torque) if point.torque < 0.0 else _pulling(case, point.torque)),
    }
    return case.with_changes(changes)


def _rail(case: Case, adhesion: float) -> dict[str, Any]:
    """The case's condition of the rail with another friction at no slip."""
    return {**_plain(rail_shape(case)), "mu_0": adhesion}


def _load_changes(case: Case, load: float) -> dict[str, object]:
    if load == 1.0:
        return {}
    body = max((b for b in case.vehicle.data.body if b.kind != "wheelset"), key=lambda b: b.mass)
    mass = _loaded_mass(case, load)
    inertia = [mass / body.mass * value for value in body.inertia]
    return {f"vehicle.body.{body.name}.mass": mass, f"vehicle.body.{body.name}.inertia": inertia}


def _loaded_mass(case: Case, load: float) -> float:
    """Mass of the heaviest body where all axle loads are multiplied; not positive where the rest is too heavy already."""
    bodies = case.vehicle.data.body
    heaviest = max((b.mass for b in bodies if b.kind != "wheelset"), default=0.0)
    return float(heaviest + (load - 1.0) * sum(b.mass for b in bodies)) if heaviest else 0.0


def _braking(case: Case, torque: float) -> dict[str, object]:
    brake = case.brake or Brake(demand=((0.0, 0.0), (1.0, 0.0)))
    friction = 0.35
    pressure = (torque / (brake.faces * brake.friction_radius * friction) + brake.spring_force) / brake.piston_area
    quick = {
        "demand": [[0.0, 0.0], [BEGIN, 0.0], [BEGIN + RISE, pressure]],
        "friction": [[0.0, friction], [50.0, friction]],
        "application_rate": 100.0 * pressure / RISE,
        "release_rate": 100.0 * pressure / RISE,
        "follow_rate": FOLLOW,
        "fill_rate": FOLLOW,
        "motors_stand_in": False,
    }
    protection: object = {} if case.slide_protection is None else case.slide_protection
    return {
        "brake": {**_plain(brake), **quick},
        "slide_protection": protection,
        "traction": None,
        "wheel_slip_control": None,
    }


def _pulling(case: Case, torque: float) -> dict[str, object]:
    traction = case.traction or Traction()
    motor = traction.motor.model_copy(update={"envelope": None})
    demand = [[0.0, 0.0], [BEGIN, 0.0], [BEGIN + RISE, torque]]
    return {
        "traction": {**_plain(traction), "demand": demand, "motor": _plain(motor)},
        "wheel_slip_control": {} if case.wheel_slip_control is None else case.wheel_slip_control,
        "brake": None,
        "slide_protection": None,
    }


def _plain(table: Any) -> dict[str, Any]:
    values: dict[str, Any] = table.model_dump(exclude_none=True)
    return values


# -------------------------------------------------------------------------------------------------------- checks


def _problems(plan: Plan) -> Iterator[ConfigProblem]:
    name = plan.case.name

    def refused(key: str, value: object, allowed: str) -> ConfigProblem:
        return ConfigProblem(name, f"envelope: {key}", str(value), f"allowed: {allowed}")

    for key, values, least in (
        ("torques", plan.torques, 2),
        ("adhesions", plan.adhesions, 2),
        ("loads", plan.loads, 1),
    ):
        rising = all(a < b for a, b in itertools.pairwise(values))
        if len(values) < least or not rising or not all(map(math.isfinite, values)):
            yield refused(key, _few(values), f"at least {least} finite numbers in ascending order")
            return
    if not plan.adhesions[0] > 0.0 or not plan.adhesions[-1] <= 1.0:
        yield refused("adhesions", _few(plan.adhesions), "above 0 and up to 1")
    for load in plan.loads:
        if not _loaded_mass(plan.case, load) > 0.0:
            bodies = plan.case.vehicle.data.body
            total = sum(b.mass for b in bodies)
            heaviest = max((b.mass for b in bodies if b.kind != "wheelset"), default=0.0)
            allowed = f"above {1.0 - heaviest / total:.2g}, where nothing is left of the heaviest body, which carries the load"
            yield refused("loads", f"{load:g}", allowed if heaviest else "1: there is no body but wheelsets to load")
    if not 2.0 * (BEGIN + RISE) <= plan.duration <= 60.0:
        yield refused("duration", f"{plan.duration:g} s", f"{2 * (BEGIN + RISE):g} s to 60 s")
    if not 0 <= plan.refine <= MOST_REFINED:
        yield refused("refine", plan.refine, f"0 to {MOST_REFINED}")
        return
    count = len(plan.loads) * len(plan.lattice[0]) * len(plan.lattice[1])
    if count > MOST_RUNS:
        yield refused("torques, adhesions, loads", f"{count} points", f"at most {MOST_RUNS}")


def _few(values: Sequence[float]) -> str:
    shown = ", ".join(f"{value:g}" for value in values[:6])
    return (shown or "none") + (", ..." if len(values) > 6 else "")


def _between(values: tuple[float, ...], parts: int) -> tuple[float, ...]:
    found = [a + (b - a) * k / parts for a, b in itertools.pairwise(values) for k in range(parts)]
    return (*(float(f"{value:.9g}") for value in found), values[-1])
