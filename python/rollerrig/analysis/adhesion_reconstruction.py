"""The rail under a measured stop: from speeds of train and wheels and brake pressures to friction over distance.

Log of a stop, Case -> [StopLog] -> train speed, axle speeds, brake pressures
    -> [reconstruct] -> adhesion used per axle, friction of the rail per piece of the way
    -> [with_map] -> Case whose rail has that friction

The brake's torque and the wheelset's inertia give the force that the rail took (A22); the case's creep law, turned round, the
friction at no slip with which it takes that force at the measured slip (A23). Only axles that slide say so: on the steep branch
of the creep curve the force hardly depends on friction. docs/theory/adhesion.md
"""

from dataclasses import dataclass, replace
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig.analysis.slide_statistics import LEAST_SPEED, rms
from rollerrig.assembly.actuators import friction_brake
from rollerrig.assembly.laws import core_law
from rollerrig.assembly.model import assemble
from rollerrig.cases import wheelsets
from rollerrig.common.arrays import Array
from rollerrig.config import Case, ConfigError
from rollerrig.config.load.adhesion_file import rail_of_points
from rollerrig.config.write.toml import plain
from rollerrig.contact_analysis.traction_curve import LoadedWheel, traction_coefficient
from rollerrig.results import RunInfo, variable
from rollerrig.results.logs import log_quantity, read_log, time_problem
from rollerrig.results.run_info import ResultsError
from rollerrig.simulation.starting_state import equilibrium_dataset

LEAST_ELASTICITY = 0.5
"""Per cent by which the force grows where friction grows by one: below it an axle says nothing of friction [-]."""

LEAST_SLIP = 0.03
"""Slip from which an axle counts as sliding [-]: at less it may as well adhere to a good rail as slide on a bad one, and the
swing of its bogie and the errors of measured speeds are no small part of it."""

LEAST_SAMPLES = 3  # samples of a sliding axle that a piece of the way needs
UNBRAKED = 1e4  # pressure up to which no pad presses yet [Pa]

RADIUS_ERROR = 0.01
"""Largest part by which axles may turn faster or slower than the train before they are braked [-]: their slip is wrong by it."""

MOST_MOVED = 1.0
"""Change of an axle's load over its braking force, at most [-]: the force acts lower than the axles are apart."""

FRICTIONS = np.geomspace(0.01, 0.9, 12)
"""Friction at no slip at which the creep curve is computed [-]; in between its logarithm is interpolated."""

BESIDE = ("brake.electrodynamic", "track_brake", "sanding", "traction")


@dataclass(frozen=True)
class StopLog:
    """A measured stop, evenly enough sampled to be differentiated over a piece of the way."""

    file: str  # as messages name it
    time: Array  # rising [s], shape (time,)
    train_speed: Array  # [m/s], shape (time,)
    axles: tuple[str, ...]  # names of the wheelsets of the case
    axle_speed: Array  # [rad/s], shape (time, axle)
    pressure: Array  # of the brake cylinders over the ambient [Pa], shape (time, axle)

    @property
    def signals(self) -> xr.Dataset:
        """The same over `time` since the first row, and `axle`."""
        of_axles = {"axle_speed": self.axle_speed, "cylinder_pressure": self.pressure}
        signals = {name: (("time", "axle"), values) for name, values in of_axles.items()}
        coordinates = {"time": self.time - self.time[0], "axle": list(self.axles)}
        return xr.Dataset({**signals, "train_speed": ("time", self.train_speed)}, coordinates)

    @property
    def distance(self) -> Array:
        """Way of the train from the first row [m]."""
        mean = 0.5 * (self.train_speed[1:] + self.train_speed[:-1])
        return np.concatenate(([0.0], np.cumsum(mean * np.diff(self.time))))


def read_stop(path: str | Path, case: Case) -> StopLog:
    """Read the log of a stop.

    Its columns are `time [s]`, `train_speed [m/s]` and, of each braked axle, `NAME.axle_speed [rad/s]` and
    `NAME.cylinder_pressure [Pa]`, in these units or others; speeds of wheels also as those of their circumference [m/s].

    Raises:
        FileNotFoundError: no such file.
        ResultsError: a column is missing, has no or another unit, or holds no numbers; times do not rise, or have a gap; an axle
            never turns, or its pressure is negative by more than a sensor's noise.
    """
    log, radius = read_log(path), case.vehicle.data.wheel.radius
    axles = tuple(body.name for body in wheelsets(case))
    time = log_quantity(log, "time", {"s": 1.0})
    if problem := time_problem(time):
        raise ResultsError(f"{log.file}: time: {problem}")
    turning = [log_quantity(log, f"{axle}.axle_speed", {"rad/s": 1.0, "m/s": 1.0 / radius}) for axle in axles]
    pressure = [log_quantity(log, f"{axle}.cylinder_pressure", {"Pa": 1.0}) for axle in axles]
    for axle, speed, own in zip(axles, turning, pressure, strict=True):
        if not speed.any():
            raise ResultsError(f"{log.file}: {axle}.axle_speed: 0 in all rows; needed: the speed of an axle that turns")
        if own.min() < -UNBRAKED:
            low = f"{1e-5 * own.min():.3g} bar at {time[own.argmin()]:g} s"
            raise ResultsError(
                f"{log.file}: {axle}.cylinder_pressure: {low}; allowed: at least {-1e-5 * UNBRAKED:g} bar"
            )
    train = log_quantity(log, "train_speed", {"m/s": 1.0})
    return StopLog(log.file, time, train, axles, np.column_stack(turning), np.column_stack(pressure))


def check_case(case: Case) -> None:
    """Refuse with a ConfigError a case whose axles are not braked by pads or blocks alone, or whose rail has no friction."""
    for name in ("brake", "adhesion"):
        if getattr(case, name) is None:
            needed = f"needed: [{name}], of which a stop's pressures and slips are read"
            raise ConfigError.of(case.name, name, "missing", needed)
    for what in BESIDE:
        if attrgetter(what)(case) is not None:
            allowed = "allowed: none; what it does to an axle does not show in its brake pressure"
            raise ConfigError.of(case.name, what, "there", allowed)


def reconstruct(case: Case, log: StopLog, piece: float) -> xr.Dataset:
    """Adhesion used by each axle and friction of the rail at no slip, over the way.

    Args:
        case: on track or on a rig, with the brake, the creep law and the condition of the rail but its friction.
        log: of the stop.
        piece: length of a piece of the way [m].

    Returns:
        Over `distance`, the middles of pieces from the first to the last in which an axle slid [m]: `friction` [-], of all axles
        that slid there, between such pieces linear; `friction_of_axle` (distance, axle) and `used_adhesion` (distance, axle), NaN
        where an axle did not slide; `measured`, 1 where one did. Its `axles_apart` says by how much the frictions that the axles
        find at the same place differ, over their mean, RMS of all places where each slid [-]; NaN where there is none.

    Raises:
        ResultsError: no axle slid long enough; before the brake acts an axle does not roll with the train.
    """
    _check_radius(case, log)
    rest = equilibrium_dataset(assemble(case)).isel(time=0)
    inertia = {body.name: body.inertia[1] for body in wheelsets(case)}
    ahead = {body.name: body.position[0] for body in RunInfo.of(rest).wheelsets}  # of the origin of distances
    found, used = [], []
    edges = np.arange(0.0, log.distance[-1] + max(ahead.values()) + piece, piece)
    for k, axle in enumerate(log.axles):
        wheel = _wheel(case, rest, axle)
        own = _used(case, log, k, inertia[axle], wheel)
        at = np.digitize(own["way"] + ahead[axle], edges) - 1
        of_piece = [_friction(case, wheel, own, np.flatnonzero(at == i)) for i in range(len(edges))]
        found.append([one[0] for one in of_piece])
        used.append([one[1] for one in of_piece])
    frictions, adhesion, middles = np.array(found).T, np.array(used).T, edges + 0.5 * piece
    slid = np.isfinite(frictions).any(axis=1)
    if not slid.any():
        raise ResultsError(
            f"{log.file}: no axle slid: the stop says only that the rail gave as much as the brakes asked"
        )
    first, last = np.flatnonzero(slid)[[0, -1]]
    kept, loaded = slice(first, last + 1), frictions / _loads(frictions, adhesion)
    mean = np.interp(middles, middles[slid], np.nanmean(loaded[slid], axis=1))
    all_slid = loaded[np.isfinite(loaded).all(axis=1)]
    apart = rms(np.ptp(all_slid, axis=1) / all_slid.mean(axis=1)) if len(all_slid) else np.nan
    return xr.Dataset(
        {
            "friction": variable(("distance",), mean[kept], "1", "friction of the rail at no slip"),
            "friction_of_axle": variable(("distance", "axle"), frictions[kept], "1", "the same from one axle alone"),
            "used_adhesion": variable(("distance", "axle"), adhesion[kept], "1", "creep force over axle load"),
            "measured": variable(("distance",), slid[kept].astype(float), "1", "1: an axle slid there"),
        },
        coords={"distance": middles[kept], "axle": list(log.axles)},
        attrs={"piece_m": piece, "axles_apart": apart},
    )


def unbraked(log: StopLog) -> NDArray[np.intp]:
    """Rows at the beginning in which no axle is braked."""
    return np.flatnonzero(np.cumsum((log.pressure > UNBRAKED).any(axis=1) | (log.train_speed < LEAST_SPEED)) == 0)


def _check_radius(case: Case, log: StopLog) -> None:
    """Refuse a log in which an unbraked axle does not run with the train: a wrong radius would be taken for a slide."""
    rows, radius = unbraked(log), case.vehicle.data.wheel.radius
    if len(rows) < LEAST_SAMPLES:
        return
    for axle, speed in zip(log.axles, log.axle_speed[rows].T, strict=True):
        slower = 1.0 - float(np.median(radius * speed / log.train_speed[rows]))
        if abs(slower) > RADIUS_ERROR:
            own = f"it is {radius / (1.0 - slower):.4g} m" if slower < 1.0 else "the axle does not turn"
            raise ResultsError(
                f"{log.file}: {axle}: before the brake acts its circumference runs {100 * abs(slower):.2g} % "
                f"{'slower' if slower > 0 else 'faster'} than the train, at most {100 * RADIUS_ERROR:g} % is allowed; "
                f"vehicle.wheel.radius is {radius:g} m, by the log {own}"
            )


def _loads(frictions: Array, adhesion: Array) -> Array:
    """Load of each axle over its static one, shape (piece, axle): braking moves it in proportion to what all axles use.

    By how much, is what the axles find apart from each other where all of them slide.
    """
    braking = np.mean(adhesion, axis=1, keepdims=True)
    whole = np.isfinite(frictions).all(axis=1)
    apart = frictions[whole] / frictions[whole].mean(axis=1, keepdims=True) - 1.0
    moved = np.sum(braking[whole] * apart, axis=0) / max(float(np.sum(braking[whole] ** 2)), 1e-12)
    return np.asarray(1.0 + np.nan_to_num(braking) * np.clip(moved, -MOST_MOVED, MOST_MOVED))


def _wheel(case: Case, rest: xr.Dataset, axle: str) -> LoadedWheel:
    """A wheel of an axle under half of its static load."""
    left = rest.sel(wheel=f"{axle}_left")
    load = 0.5 * float(sum(rest["vertical_force"].sel(wheel=f"{axle}_{side}") for side in ("left", "right")))
    patch = left.isel(patch=int(np.nanargmax(left["patch_normal"].to_numpy())))
    return LoadedWheel(
        radius=float(left["rolling_radius"]),
        load=load,
        speed=case.motion.speed,
        a_over_b=float(patch["patch_a"] / patch["patch_b"]),
        shear_modulus=case.contact.material.shear_modulus,
        poisson_ratio=case.contact.material.poisson_ratio,
    )


def _used(case: Case, log: StopLog, k: int, inertia: float, wheel: LoadedWheel) -> dict[str, Array]:
    """Between two rows of the log: place of the train, its speed, slip of an axle and adhesion that it uses, (A22)."""
    brake = friction_brake(case.brake)  # type: ignore[arg-type]
    turning, step = log.axle_speed[:, k], np.diff(log.time)
    torque = np.array([-brake.torque(p, w) for p, w in zip(log.pressure[:, k], turning, strict=True)])
    middle = {name: 0.5 * (v[1:] + v[:-1]) for name, v in (("way", log.distance), ("speed", log.train_speed),
                                                           ("turning", turning), ("torque", torque))}  # fmt: skip
    force = (middle["torque"] + inertia * np.diff(turning) / step) / wheel.radius
    speed = middle["speed"]
    slip = (speed - wheel.radius * middle["turning"]) / np.maximum(speed, LEAST_SPEED)
    return {"way": middle["way"], "speed": speed, "slip": slip, "used": force / (2.0 * wheel.load)}


def _friction(case: Case, wheel: LoadedWheel, own: dict[str, Array], rows: NDArray[np.intp]) -> tuple[float, float]:
    """Friction at no slip with which the creep law gives what an axle uses while it slides, (A23), and its use in all rows."""
    rows = rows[own["speed"][rows] > LEAST_SPEED]
    in_all = float(own["used"][rows].mean()) if len(rows) else np.nan
    rows = rows[own["slip"][rows] > LEAST_SLIP]
    if len(rows) < LEAST_SAMPLES:
        return np.nan, in_all
    used = float(own["used"][rows].mean())
    curve = np.log(np.mean([_curve(case, wheel, own["speed"][i], own["slip"][i]) for i in rows], axis=0))
    if not np.exp(curve[0]) < used < np.exp(curve[-1]):
        return np.nan, in_all
    friction = float(np.exp(np.interp(np.log(used), curve, np.log(FRICTIONS))))
    k = int(np.clip(np.searchsorted(FRICTIONS, friction), 1, len(FRICTIONS) - 1))
    elasticity = (curve[k] - curve[k - 1]) / np.log(FRICTIONS[k] / FRICTIONS[k - 1])
    return (friction if elasticity > LEAST_ELASTICITY else np.nan), in_all


def _curve(case: Case, wheel: LoadedWheel, speed: float, slip: float) -> Array:
    """Traction coefficient at a slip with each of FRICTIONS."""
    rail = case.adhesion.rail  # type: ignore[union-attr]
    moving = replace(wheel, speed=speed)
    law = core_law(case.contact.creep)
    found = [
        traction_coefficient(
            moving, slip, core_law(rail.friction.model_copy(update={"mu_0": mu})), law, (rail.k_A, rail.k_S)
        )
        for mu in FRICTIONS
    ]
    return np.array(found)[:, 0]


def with_map(case: Case, found: xr.Dataset) -> Case:
    """The case on a rail with the reconstructed friction; what sliding cleaned is in that, and cleans nothing again.

    From the middle of one piece to that of the next friction passes smoothly; before the first and behind the last it stays.
    """
    rail: dict[str, Any] = plain(case.adhesion.rail.model_dump(exclude_none=True))  # type: ignore[union-attr]
    places, values = found["distance"].to_numpy(), found["friction"].to_numpy()
    blend = float(found.attrs["piece_m"])
    given = rail_of_points(rail, places.tolist(), values.tolist(), blend)
    given |= {"recovery_constant": 0.0, "wheel_memory": 0.0}
    changed = case.with_changes({f"adhesion.{key}": value for key, value in given.items()})
    return changed.model_copy(update={"name": f"{case.name}_measured"[:60]})
