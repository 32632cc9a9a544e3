"""The cases to be compared: what the user named, put on each support.

vehicle or case, supports by name -> [compared_cases] -> label -> Case
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rollerrig.config import Case, ConfigError, ConfigProblem, Rig, Track, Vehicle, load_any, load_support
from rollerrig.config.change import plain
from rollerrig.config.errors import nearest
from rollerrig.config.library import catalog_names
from rollerrig.config.load import build_case
from rollerrig.config.read import Document

SHORTHANDS = {"rig": "full_scale_rig", "track": "uic60_track"}
"""What `--on rig,track` means where VEHICLE is no case with a support of that kind."""

MATERIAL, FRICTION = "steel", 0.3
"""Contact of a vehicle that comes without a case."""


def compared_cases(vehicle: str, on: Sequence[str], cut: str | None = None) -> dict[str, Case]:
    """One case per support.

    Args:
        vehicle: a vehicle of the catalogue or a file; or a case, whose contact is then kept.
        on: supports: 'rig', 'track', names of the catalogue or files, each once.
        cut: part of the vehicle; of a case by default its own, of a vehicle all of it.

    Returns:
        Label (as the user named the support, without folder and ending) -> case at a constant speed, without torques and
        disturbances; the vehicle is held along the track.

    Raises:
        ConfigError: all mistakes found.
    """
    base = _base(vehicle)
    name = base.vehicle.data.name if isinstance(base, Case) else base.name
    cases = {}
    for support in on:
        label = Path(support).name.removesuffix(".toml")
        cases[label] = restrained(_case(base, f"{name}_on_{label}", _support(support, base), cut, vehicle))
    return cases


def _base(source: str) -> Case | Vehicle:
    names = (*catalog_names("vehicle"), *catalog_names("case"))
    needed = "needed: a vehicle or a case, of the catalogue or a TOML file"
    if not Path(source).exists() and not any(source in catalog_names(kind) for kind in _KINDS):
        allowed = f"{needed}; the catalogue has the vehicles {', '.join(catalog_names('vehicle'))} and the cases "
        allowed += ", ".join(catalog_names("case"))
        raise ConfigError([ConfigProblem(source, "", "no such file", allowed, nearest(source, names))])
    kind, found = load_any(source)
    if isinstance(found, Case | Vehicle):
        return found
    raise ConfigError([ConfigProblem(source, "", f"a {kind}, not a vehicle", needed)])


_KINDS = ("vehicle", "support", "profile", "material", "case")


def _support(name: str, base: Case | Vehicle) -> dict[str, Any]:
    """Raw tables of a support; 'rig' and 'track' are the case's own, or its counterpart with the same head."""
    own = base.support.data if isinstance(base, Case) else None
    if name not in SHORTHANDS:
        return _tables(load_support(name))
    if own is not None and own.kind == name:
        return _tables(own)
    found = load_support(SHORTHANDS[name])
    return _tables(found if own is None else with_head_of(found, own))


def with_head_of(support: Rig | Track, other: Rig | Track) -> Rig | Track:
    """A support with the rail head and gauge of another."""
    return support.model_copy(update={"profile": other.profile, "gauge": other.gauge, "gauge_depth": other.gauge_depth})


def track_below(case: Case) -> Case:
    """The same case on straight track with the head and gauge of its rig."""
    return _moved(case, with_head_of(load_support(SHORTHANDS["track"]), case.support.data), "track")


def rig_below(case: Case) -> Case:
    """The same case on the catalogue's rig with the head and gauge of its track."""
    return _moved(case, with_head_of(load_support(SHORTHANDS["rig"]), case.support.data), "rig")


def _moved(case: Case, support: Rig | Track, label: str) -> Case:
    raw = plain(case)
    raw["support"] = {"data": _tables(support)}
    return build_case(Document(raw, f"{case.name} on {label}", Path()))


def _tables(support: Rig | Track) -> dict[str, Any]:
    tables: dict[str, Any] = plain(support)
    return tables


def _case(base: Case | Vehicle, name: str, support: Mapping[str, Any], cut: str | None, source: str) -> Case:
    if isinstance(base, Case):
        raw = plain(base)
        chosen = cut or base.vehicle.cut
    else:
        contact = {"material": MATERIAL, "friction": FRICTION}
        raw = {"vehicle": {"data": plain(base)}, "contact": contact, "time": {"duration": 6.0}}
        chosen = cut or "vehicle"
    raw |= {
        "name": name,
        "description": name.partition("_on_")[0].replace("_", " "),
        "support": {"data": dict(support)},
    }
    raw["vehicle"]["cut"] = chosen
    raw["motion"] = {"speed": "100 km/h"}
    for key in ("axle_torque", "disturbance"):
        raw.pop(key, None)
    return build_case(Document(raw, source, Path()))


def restrained(case: Case) -> Case:
    """The case with something that holds it along the track, as a rig does and as what pulls a train does.

    Two patches of one wheel brake each other a little, and nothing else balances that. Where a body is held already nothing is
    changed; else x is locked of the heaviest body that is no wheelset, or of the first wheelset.
    """
    part = case.vehicle.part
    bodies = case.vehicle.data.bodies_in(part)
    if part.fixed or any("x" in body.locked for body in bodies):
        return case
    rigid = [body for body in bodies if body.kind != "wheelset"]
    body = max(rigid, key=lambda b: b.mass) if rigid else bodies[0]
    return case.with_changes({f"vehicle.body.{body.name}.locked": [*body.locked, "x"]})


def part_of(case: Case, cut: str) -> Case:
    """Another part of the same vehicle, held along the track."""
    freed = {
        f"vehicle.body.{body.name}.locked": [d for d in body.locked if d != "x"]
        for body in case.vehicle.data.bodies_in(case.vehicle.part)
        if "x" in body.locked
    }
    return restrained(case.with_changes({**freed, "vehicle.cut": cut}))
