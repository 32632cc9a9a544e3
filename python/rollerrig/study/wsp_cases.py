"""The cases of a test programme: one per stop, and the dry stops beside which they are held.

Case of a rig with brake and slide protection, Programme -> [wsp_cases] -> Case of each stop and of its dry reference, on the rig;
`track_case` puts them on track
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from rollerrig.cases import wheelsets
from rollerrig.config import Case, ConfigError, ConfigProblem, Piece, Programme
from rollerrig.config.schema.programme import BrakedRun, PatchStop
from rollerrig.config.write.toml import plain
from rollerrig.study.adhesion_variants import track_case

RISE = 0.1
"""In which the demand rises; the brake is slower anyhow [s]."""


def check_case(case: Case, programme: Programme) -> None:
    """Refuse a case that has nothing to test, and stops that this vehicle cannot do.

    Raises:
        ConfigError: it has.
    """
    track_case(case)
    for name in ("brake", "slide_protection"):
        if getattr(case, name) is None:
            needed = f"needed: [{name}]; a programme for wheel slide protection tests what it does to a braked axle"
            raise ConfigError([ConfigProblem(case.name, name, "missing", needed)])
    train = case.train.axles
    along = train.positions if train else sorted(body.position[0] for body in wheelsets(case))
    least = min((b - a for a, b in zip(along, along[1:], strict=False)), default=0.0)
    for stop in programme.stop:
        if not stop.speed > case.motion.stop_speed:
            allowed = f"allowed: more than motion.stop_speed of {case.name}, {3.6 * case.motion.stop_speed:g} km/h"
            problem = ConfigProblem(programme.name, f"stop.{stop.name}.speed", f"{3.6 * stop.speed:g} km/h", allowed)
            raise ConfigError([problem])
        if isinstance(stop, PatchStop) and not stop.length < least:
            allowed = f"allowed: less than the least spacing of the axles, {least:g} m, so that one axle at a time is on a patch"
            raise ConfigError([ConfigProblem(programme.name, f"stop.{stop.name}.length", f"{stop.length:g}", allowed)])


def stop_case(case: Case, programme: Programme, stop: BrakedRun) -> Case:
    """A stop of the programme on the rig: the case with this speed, rail and demand, all else its own.

    The demand begins at the start: the distance run is that since the demand.

    Raises:
        ConfigError: the case cannot be run so.
    """
    rail = _plain(stop.rail)
    pieces = [_plain(piece) for piece in stop.pieces()]
    return _changed(case, programme, stop, f"{case.name}_{stop.name}", rail, pieces)


def dry_case(case: Case, programme: Programme, stop: BrakedRun) -> Case:
    """The same stop on a dry rail.

    Raises:
        ConfigError: the case cannot be run so.
    """
    return _changed(case, programme, stop, f"{case.name}_{stop.name}_dry", "dry", [])


def dry_name(case: Case, stop: BrakedRun) -> str:
    """The dry stops of one speed and demand are one."""
    return f"dry {3.6 * stop.speed:.6g} at {1e-5 * _demanded(case, stop):.6g} bar"


def _demanded(case: Case, stop: BrakedRun) -> float:
    """Cylinder pressure over the ambient [Pa]."""
    assert case.brake is not None
    return stop.pressure if stop.pressure is not None else max(pressure for _, pressure in case.brake.demand)


def _changed(
    case: Case, programme: Programme, stop: BrakedRun, name: str, rail: Any, pieces: Sequence[Mapping[str, Any]]
) -> Case:
    blend = getattr(stop, "blend", 0.0) if pieces else 0.0
    changes: dict[str, object] = {
        "motion.speed": f"{stop.speed!r} m/s",
        "brake.demand": [[0.0, 0.0], [RISE, _demanded(case, stop)]],
        "train.gradient": stop.falls,
        "time.duration": stop.duration,
    }
    if case.adhesion is None:
        changes["adhesion"] = {"rail": rail, "piece": list(pieces), "blend": blend}
    else:
        changes |= {"adhesion.piece": list(pieces), "adhesion.rail": rail, "adhesion.blend": blend}
    try:
        changed = case.with_changes(changes)
    except ConfigError as error:
        raise ConfigError(
            replace(problem, file=programme.name, key=f"stop.{stop.name}: {problem.key}") for problem in error.problems
        ) from None
    return changed.model_copy(update={"name": name[:60]})


def _plain(table: Any) -> Any:
    """As a file would give it."""
    found = plain(table.model_dump(exclude_none=True))
    if isinstance(table, Piece):
        found["rail"] = _plain(table.rail)
    return found
