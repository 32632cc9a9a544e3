"""Cases made from cases: another support, another part of the vehicle, a constant speed, no actuators.

    Case -> [cases] -> Case -> assemble, simulate, stability

Each transformation is defined here and nowhere else. All return a new case, checked like a file: what is not allowed
raises ConfigError.
"""

from pathlib import Path

from rollerrig.config import Body, Case, ConfigError, Rig, Track, load_case, load_support
from rollerrig.config.schema.case import ACTUATORS
from rollerrig.config.schema.contact import Polach
from rollerrig.config.schema.rig_control import RigControl
from rollerrig.config.write.toml import plain

_NO_ACTUATORS: dict[str, object] = {**dict.fromkeys(ACTUATORS), "fault": None, "contact.pure_rolling": False}

CATALOG_TRACK, CATALOG_RIG = "uic60_track", "full_scale_rig"
"""Supports on which a case is put; they get the head and gauge of its own."""


def as_case(case: Case | str | Path) -> Case:
    """The case itself, or the one of that name in the catalogue or in that TOML file."""
    return case if isinstance(case, Case) else load_case(case)


# ---------------------------------------------------------------------------------------------------- the vehicle


def wheelsets(case: Case) -> tuple[Body, ...]:
    """Wheelsets of the part that is run, in the order of the vehicle."""
    return case.vehicle.wheelsets


def leading_wheelset(case: Case) -> Body:
    """The foremost wheelset of the part that is run."""
    return max(wheelsets(case), key=lambda body: body.position[0])


def part_of(case: Case, cut: str) -> Case:
    """Another part of the same vehicle, restrained along the track; one with a fixed body needs no coupler rod."""
    held = [body for body in case.vehicle.bodies if "x" in body.locked]
    changes: dict[str, object] = {
        f"vehicle.body.{body.name}.locked": [d for d in body.locked if d != "x"] for body in held
    }
    support = case.support.data
    if isinstance(support, Rig) and support.restraint is not None and case.vehicle.data.cut_named(cut).fixed:
        changes["support.restraint"] = None
    return restrained_along_track(case.with_changes({**changes, "vehicle.cut": cut}))


def rig_of(case: Case) -> tuple[Rig, RigControl]:
    """The rig of a case that reproduces a track, and its controller; a ConfigError where it has none."""
    if not isinstance(case.support.data, Rig) or case.rig_control is None:
        needed = (
            "needed: a case on rollers with [rig_control], which reproduces a track; see adhesion_* of the catalogue"
        )
        raise ConfigError.of(case.name, "rig_control", "missing", needed)
    return case.support.data, case.rig_control


def restrained_along_track(case: Case) -> Case:
    """The case with a longitudinal restraint, such as a rig's anchorage or a locomotive.

    Two patches of one wheel brake each other a little, and nothing else balances that. A case with a fixed body, one locked in x
    or a rig with a coupler rod stays as it is; else x is locked of the heaviest body that is no wheelset, or of the first
    wheelset.
    """
    part, bodies, support = case.vehicle.part, case.vehicle.bodies, case.support.data
    rod = isinstance(support, Rig) and support.restraint is not None
    if rod or part.fixed or any("x" in body.locked for body in bodies):
        return case
    body = case.vehicle.data.heaviest_in(part) or bodies[0]
    return case.with_changes({f"vehicle.body.{body.name}.locked": [*body.locked, "x"]})


# ---------------------------------------------------------------------------------------------------- the support


def with_head_of(support: Rig | Track, other: Rig | Track) -> Rig | Track:
    """A support with the rail heads and gauge of another."""
    kept = ("profile", "right_profile", "gauge", "gauge_depth", "contact_distance")
    return support.model_copy(update={key: getattr(other, key) for key in kept})


def on_track(case: Case) -> Case:
    """The same case on straight, rigid track with the head and gauge of its support.

    The vehicle runs at its speed; the controller of a rig and the assumption of pure rolling on rollers are left out.
    """
    changes: dict[str, object] = {"motion.drive": "speed_controlled", "motion.torque_table": None, "rig_control": None}
    if case.adhesion is not None and isinstance(case.contact.creep, Polach):  # there those of the rail hold
        changes |= {"contact.creep.k_A": 1.0, "contact.creep.k_S": 1.0}
    return _on(case, CATALOG_TRACK, {**changes, "contact.pure_rolling": False})


def on_rig(case: Case, radius: float | None = None) -> Case:
    """The same case on rollers.

    Args:
        case: on a rig, whose rollers are then kept, or on track, whose head the rollers of the catalogue's rig get.
        radius: of the rollers at the crown [m]; None: the rig's own.
    """
    rig = case if isinstance(case.support.data, Rig) else _on(case, CATALOG_RIG, {})
    return rig if radius is None else rig.with_changes({"support.roller_radius": f"{radius} m"})


def _on(case: Case, support: str, changes: dict[str, object]) -> Case:
    data = plain(with_head_of(load_support(support), case.support.data))
    return case.with_changes({"support": {"data": data}, **changes})


# ------------------------------------------------------------------------------------------- drive and disturbance


def without_actuators(case: Case) -> Case:
    """The vehicle without brakes, traction, degraded adhesion and controllers; the drive of the rollers stays."""
    return case.with_changes(_NO_ACTUATORS) if case.sampled else case


def at_speed(case: Case, speed: float | None = None) -> Case:
    """The vehicle without actuators at a constant speed on smooth rollers or rails.

    A track continues without end as it begins, straight or curved.

    Args:
        case: the case; rollers are speed-controlled, whatever its drive.
        speed: running speed [m/s]; None: the starting speed of the case.
    """
    changes: dict[str, object] = {
        **(_NO_ACTUATORS if case.sampled else {}),
        "motion.drive": "speed_controlled",
        "motion.speed_table": None,
        "motion.torque_table": None,
        "motion.speed": f"{case.motion.speed if speed is None else speed} m/s",
    }
    support = case.support.data
    if support.irregularity is not None:
        changes["support.irregularity"] = None
    if isinstance(support, Track) and len(support.segment) > 1:
        changes["support.segment"] = [support.segment[0].model_dump()]
    return case.with_changes(changes)


def displaced(case: Case, lateral: float) -> Case:
    """The case started with a lateral offset of its leading wheelset [m], without other disturbances and torques."""
    disturbance = {"body": leading_wheelset(case).name, "lateral": lateral}
    return case.with_changes({"disturbance": [disturbance], "axle_torque": []})
