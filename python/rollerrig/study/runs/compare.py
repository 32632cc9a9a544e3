"""What a comparison of supports runs, and how it shows wheel-rail forces: cases that the user named, forces side by side.

vehicle or case, supports by name -> [compared_cases] -> label -> Case
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis import HuntingSettings, filtered, wheel_forces
from rollerrig.analysis.control_loop import RollingState
from rollerrig.analysis.hunting import hunting_case
from rollerrig.cases import CATALOG_RIG, CATALOG_TRACK, leading_wheelset, restrained_along_track, with_head_of
from rollerrig.config import Case, ConfigError, ConfigProblem, Rig, Track, Vehicle, load_any, load_support
from rollerrig.config.errors import nearest
from rollerrig.config.load.case import build_case
from rollerrig.config.read import Document, catalog_names
from rollerrig.config.write.toml import plain
from rollerrig.study.jobs import Progress, whole_run

SHORTHANDS = {"rig": CATALOG_RIG, "track": CATALOG_TRACK}
"""What `--on rig,track` means where VEHICLE is no case with a support of that kind."""

MATERIAL, FRICTION = "steel", 0.3
"""Contact of a vehicle that comes without a case."""


def compared_cases(
    vehicle: str, on: Sequence[str], cut: str | None = None, *, allow_code: bool = False
) -> dict[str, Case]:
    """One case per support: 'rig', 'track', names of the catalogue or files, each once; of a case its contact is kept.

    Args:
        vehicle: a vehicle of the catalogue or a file; or a case.
        on: supports.
        cut: part of the vehicle; of a case by default its own, of a vehicle all of it.
        allow_code: whether controllers that a case names may lie outside its own folder.

    Returns:
        Label (as the user named the support, without folder and suffix) -> case at a constant speed, without torques and
        disturbances; the vehicle is restrained along the track.

    Raises:
        ConfigError: all mistakes found.
    """
    base = _base(vehicle, allow_code)
    name = base.vehicle.data.name if isinstance(base, Case) else base.name
    cases = {}
    for support in on:
        label = Path(support).name.removesuffix(".toml")
        cases[label] = restrained_along_track(_case(base, f"{name}_on_{label}", _support(support, base), cut, vehicle))
    return cases


def _base(source: str, allow_code: bool) -> Case | Vehicle:
    names = (*catalog_names("vehicle"), *catalog_names("case"))
    needed = "needed: a vehicle or a case, of the catalogue or a TOML file"
    written_as_a_file = source.endswith(".toml") or "/" in source
    if (
        not written_as_a_file
        and not Path(source).exists()
        and not any(source in catalog_names(kind) for kind in _KINDS)
    ):
        allowed = f"{needed}; the catalogue has the vehicles {', '.join(catalog_names('vehicle'))} and the cases "
        allowed += ", ".join(catalog_names("case"))
        raise ConfigError([ConfigProblem(source, "", "no such file", allowed, nearest(source, names))])
    kind, found = load_any(source, allow_code=allow_code)
    if isinstance(found, Case | Vehicle):
        return found
    raise ConfigError([ConfigProblem(source, "", f"a {kind}, not a vehicle", needed)])


_KINDS = ("vehicle", "support", "profile", "material", "case", "programme")


def _support(name: str, base: Case | Vehicle) -> dict[str, Any]:
    """Raw tables of a support; 'rig' and 'track' are the case's own, or its counterpart with the same head."""
    own = base.support.data if isinstance(base, Case) else None
    if name not in SHORTHANDS:
        return _tables(load_support(name))
    if own is not None and own.kind == name:
        return _tables(own)
    found = load_support(SHORTHANDS[name])
    return _tables(found if own is None else with_head_of(found, own))


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
    raw |= {"name": name, "description": name.partition("_on_")[0].replace("_", " ")}
    raw["support"] = {"data": dict(support)}
    raw["vehicle"]["cut"] = chosen
    raw["motion"] = {"speed": "100 km/h"}
    for key in ("axle_torque", "disturbance"):
        raw.pop(key, None)
    return build_case(Document(raw, source, Path()), allow_code=True)  # that of the case was asked for when it was read


DISTURBED = {
    "guiding_force": 1e-3,
    "guiding_force_sum": 1e-3,
    "longitudinal_creep_force": 1e-3,
    "wheel_unloading": 1e2,
    "derailment_quotient": 1.0,
    "wear_number": 1.0,
}
"""Signal whose largest magnitude of the leading wheelset is reported of the disturbed run -> factor to its unit."""


def disturbed(case: Case, speed: float, settings: HuntingSettings, progress: Progress | None = None) -> xr.Dataset:
    """Filtered wheel-rail forces after a lateral offset at a speed [m/s], with the motion of the leading wheelset."""
    run = whole_run(hunting_case(case, speed, settings), progress)
    leading = leading_wheelset(case).name
    motion, creep = run["lateral"].sel(body=leading, drop=True), run["longitudinal_creep_force"]
    return (
        filtered(wheel_forces(run))
        .assign(lateral=motion, longitudinal_creep_force=creep)
        .assign_attrs(status=run.attrs["status"], leading=leading, config_toml=run.attrs["config_toml"])
    )


def wheel_numbers(state: RollingState) -> dict[str, dict[str, float]]:
    """Per wheel the numbers of `supports.*.wheels`."""
    found = {}
    for wheel in map(str, state.wheels["wheel"].to_numpy()):
        own = state.wheels.sel(wheel=wheel)
        outwards = -1.0 if wheel.endswith("left") else 1.0
        found[wheel] = {
            "vertical_force_kn": 1e-3 * float(own["vertical_force"]),
            "lateral_force_kn": outwards * 1e-3 * float(own["lateral_force"]),
            "longitudinal_creep_force_n": float(own["longitudinal_creep_force"]),
            "patches": int(own["patch_count"]),
            "approach_um": 1e6 * float(own["patch_approach"].max()),
            "patch_ab_mm2": 1e6 * float((own["patch_a"] * own["patch_b"]).max()),
            "creep_stiffness_mn": 1e-6 * state.creep_stiffness[wheel],
        }
    return found


def disturbed_numbers(run: xr.Dataset) -> dict[str, float]:
    """Largest magnitudes of the leading wheelset, by the names of DISTURBED."""
    leading, found = str(run.attrs["leading"]), {}
    for name, factor in DISTURBED.items():
        values = run[name]
        if "wheel" in values.dims:
            values = values.sel(wheel=[f"{leading}_left", f"{leading}_right"])
        if "wheelset" in values.dims:
            values = values.sel(wheelset=leading)
        found[name] = factor * float(np.abs(values).max())
    return found
