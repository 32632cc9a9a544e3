"""What theory says about a bogie under traction on free rollers, beside what a run gave.

    run of the traction case -> [closed forms] -> sliding, longitudinal force and load transfer, computed and expected

Rolling:        C = J_w a + F r  and  F R = J_R a r / R  for each axle     =>  F = C / r * m_R / (m_R + m_w),  m = J / r^2
Sliding:        F = -K (e - e_0), K the slope of the creep law at the start  =>  sliding = V (e_0 - F / K)
Load transfer:  moments of the whole bogie about the middle of its crown line; frame and wheelsets shift and pitch on their
                springs, and a wheelset off the crown by x feels its load along x: Q x / (R + r).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.analysis.signals import Fit, fit
from rollerrig.assembly.laws import core_law
from rollerrig.common.arrays import Array
from rollerrig.config import Case, Rig
from rollerrig.config.schema.vehicle import Body
from rollerrig.results import variable

ITERATIONS = 60
"""Iterations of the fixed point for the shifts; each gains about a digit."""


class Springs(NamedTuple):
    """What holds the frame of a bogie, from the case."""

    # height [m] and longitudinal stiffness [N/m] of each element between frame and car body, shape (2, n)
    restraints: Array
    pitch: float  # stiffness of these elements in pitch [N m/rad]
    load_height: float  # at which the load of the secondary springs acts on the frame [m]
    # share of that load on springs clamped at both ends, which lean by half of the frame's pitch and shift
    clamped: float
    primary: tuple[float, float]  # longitudinal and vertical stiffness of one axle's suspension [N/m]
    primary_height: float  # of its springs [m]


def bogie_of(case: Case) -> tuple[Body, list[Body], Rig]:
    """Frame, both wheelsets and rig of a case.

    Raises:
        ValueError: the case is no bogie on a rig.
    """
    rig, part = case.support.data, case.vehicle.part
    bodies = [body for body in case.vehicle.data.bodies_in(part) if body.name not in part.fixed]
    wheelsets = [body for body in bodies if body.kind == "wheelset"]
    frames = [body for body in bodies if body.kind == "rigid"]
    if not isinstance(rig, Rig) or len(wheelsets) != 2 or len(frames) != 1:
        raise ValueError(f"{case.name}: the traction study needs one frame on two wheelsets, on a rig")
    return frames[0], wheelsets, rig


def springs_of(case: Case, frame: Body, wheelsets: Sequence[Body]) -> Springs:
    """Gather the elements of a case with one frame and two wheelsets."""
    restraints, loads, pitch, primary, primary_height = [], [], 0.0, np.zeros(2), wheelsets[0].position[2]
    for element in case.vehicle.data.elements_in(case.vehicle.part):
        x, z, turn = ((element.laws[d].stiffness or 0.0) if d in element.laws else 0.0 for d in ("x", "z", "pitch"))
        if wheelsets[0].name in element.between:
            primary += (x, z)
            primary_height = element.end_b[2]
        elif frame.name in element.between and wheelsets[1].name not in element.between:
            height = (element.end_b if element.between[1] == frame.name else element.end_a)[2]
            restraints.append((height, x))
            pitch += turn
            if element.carries_load:
                loads.append((height, element.clamped))
    height, clamped = np.mean(loads, axis=0).tolist() if loads else (frame.position[2], 0.0)
    kx, kz = primary.tolist()
    return Springs(np.transpose(restraints), pitch, height, clamped, (kx, kz), primary_height)


class Balance(NamedTuple):
    """Closed forms over time; of front and rear wheelset, shape (2, n), but for the first."""

    creep_force: Array  # tangential force on one wheelset [N], shape (n,)
    longitudinal: Array  # force along x [N]; more than the creep force, since the wheelset left the crown
    vertical: Array  # force [N]
    shift: Array  # from the crown [m]


def balance(case: Case, torque: Array, axle_load: float) -> Balance:
    """Quasi-static balance of the bogie under equal torques on both wheelsets that react on the frame.

    Args:
        case: the traction case.
        torque: on each wheelset [N m].
        axle_load: static load of one axle [N].

    Raises:
        ValueError: the case is no bogie on a rig.
    """
    frame, wheelsets, rig = bogie_of(case)
    springs = springs_of(case, frame, wheelsets)
    r, big_r, mass = case.vehicle.data.wheel.radius, rig.roller_radius, wheelsets[0].mass
    base = 0.5 * abs(wheelsets[0].position[0] - wheelsets[1].position[0])
    of_roller, of_wheelset = rig.roller_inertia[1] / big_r**2, wheelsets[0].inertia[1] / r**2
    creep = of_roller / (of_roller + of_wheelset) * torque / r  # the rest spins up the wheelset
    spin_up = 2 * (torque - creep * r)  # rate of both wheelsets' angular momentum
    frame_load = 2 * axle_load - (2 * mass + frame.mass) * case.gravity
    lean = 0.5 * springs.clamped * frame_load
    (height, k), middle = springs.restraints, frame.position[2]
    pitch, transfer, shift = np.zeros_like(torque), np.zeros_like(torque), np.zeros((2, len(torque)))
    load_of = np.array([[-1.0], [1.0]])  # what moves from the front to the rear
    for _ in range(ITERATIONS):
        pull = creep + (axle_load + load_of * transfer) * shift / (big_r + r)
        frame_x = (pull.sum(axis=0) - pitch * (float(k @ (height - middle)) + lean)) / k.sum()
        shift = frame_x + pitch * (springs.primary_height - middle) + pull / springs.primary[0]
        mean = shift.mean(axis=0)
        held = (height * k) @ (frame_x + np.outer(height - middle, pitch))
        moment = spin_up + springs.pitch * pitch + held + mean * big_r / (big_r + r) * 2 * axle_load
        moment -= case.gravity * (2 * mass * mean + frame.mass * frame_x)
        load_x = frame_x + pitch * (springs.load_height - middle)
        moment -= (frame_load - lean) * load_x - lean * springs.load_height * pitch
        transfer = moment / (2 * base)
        pitch = -transfer / (springs.primary[1] * base)
    return Balance(creep, pull, axle_load + load_of * transfer, shift)


def creep_slope(run: xr.Dataset, case: Case, wheel: str) -> float:
    """Slope -dT_x / d(creepage) of all patches of a wheel at the first output time, from the creep law [N]."""
    first = run.sel(wheel=wheel).isel(time=0)
    material, contact, step = case.contact.material, case.contact, 1e-7
    slope = 0.0
    for k in range(int(first["patch_count"])):
        patch = first.isel(patch=k)
        e = [float(patch[f"patch_creepage_{d}"]) for d in ("x", "y", "spin")]
        a, b, load = (float(patch[f"patch_{name}"]) for name in ("a", "b", "normal"))
        forces = _core.creep_forces(
            np.array([[e[0] - step, e[1], e[2]], [e[0] + step, e[1], e[2]]]),
            a,
            b,
            load,
            contact.friction.mu_0,
            material.shear_modulus,
            material.poisson_ratio,
            core_law(contact.creep),
        )
        slope -= float(forces[1, 0] - forces[0, 0]) / (2 * step)
    return slope


def torque_over_time(case: Case, time: Array) -> Array:
    """Torque on one wheelset [N m]; both must have the same."""
    torques = []
    for axle in case.axle_torque:
        table = axle.table if axle.table is not None else ((0.0, axle.constant or 0.0),)
        rows = np.array(table, dtype=np.float64)
        torques.append(np.interp(time, rows[:, 0], rows[:, 1]))
    if len(torques) != 2 or np.any(torques[0] != torques[1]):
        raise ValueError(f"{case.name}: the traction study needs the same torque on both wheelsets")
    return np.asarray(torques[0])


def with_theory(run: xr.Dataset, case: Case) -> xr.Dataset:
    """The run's wheels with what theory expects of them.

    Args:
        run: results of `simulate` for the traction case.
        case: the case.

    Returns:
        Over time and wheel: `sliding` [m/s]; `longitudinal_creep_force`; `longitudinal_force`, with the normal force's part
        off the crown; `vertical_force` [N]; each of them with the closed form as `..._theory`; over time: `torque` [N m],
        `speed` [m/s].
    """
    time = run["time"].to_numpy()
    torque = torque_over_time(case, time)
    # The car body is fixed: the frame settles on the contacts and carries a little less of its weight.
    axle_load = 0.5 * float(run["vertical_force"].isel(time=0).sum())
    forces = balance(case, torque, axle_load)
    names = [str(w) for w in run["wheel"].to_numpy()]
    first = names[0].rsplit("_", 1)[0]
    axles = [0 if name.startswith(first) else 1 for name in names]
    start = run.isel(time=0)
    free = (start["longitudinal_sliding"] / start["speed"]).to_numpy()
    slope = np.array([creep_slope(run, case, name) for name in names])
    creep = np.repeat(0.5 * forces.creep_force[:, None], len(names), axis=1)
    sliding = np.abs(run["speed"].to_numpy()[:, None] * (free - creep / slope))
    along, up = 0.5 * forces.longitudinal[axles].T, 0.5 * forces.vertical[axles].T
    dims = ("time", "wheel")
    both = {
        "sliding": variable(dims, np.abs(run["longitudinal_sliding"].to_numpy()), "m/s", "absolute sliding"),
        "sliding_theory": variable(dims, sliding, "m/s", "linearised creep theory"),
        "longitudinal_creep_force_theory": variable(dims, creep, "N", "closed form"),
        "longitudinal_force_theory": variable(dims, along, "N", "closed form"),
        "vertical_force_theory": variable(dims, up, "N", "closed form"),
        "torque": variable("time", torque, "N m", "torque on each wheelset"),
    }
    forces_of_run = ("longitudinal_creep_force", "longitudinal_force", "vertical_force")
    return run[[*forces_of_run, "longitudinal_sliding", "lateral_sliding", "speed"]].assign(both)


def asymmetry(run: xr.Dataset, variable: str) -> float:
    """Largest difference between left and right wheels over the largest value [1]."""
    values = run[variable]
    sides = ([values.sel(wheel=f"wheelset_{k}_{side}", drop=True) for side in ("left", "right")] for k in (1, 2))
    return max(float(abs(left - right).max()) for left, right in sides) / float(abs(values).max())


def spin_balance(run: xr.Dataset, study: xr.Dataset, case: Case, wheelset: str, roller: str) -> tuple[float, float]:
    """Largest imbalance about the axes of a wheelset and its roller pair, over the largest torque [1]."""
    torque = study["torque"].to_numpy()
    inertia = next(b.inertia[1] for b in case.vehicle.data.body if b.name == wheelset)
    rig = case.support.data
    assert isinstance(rig, Rig)
    on_wheel, on_roller = np.zeros_like(torque), np.zeros_like(torque)
    for wheel in (w for w in run["wheel"].to_numpy() if str(w).startswith(wheelset)):
        own = run.sel(wheel=wheel)
        force = own["patch_creep_force_x"].fillna(0.0).sum("patch").to_numpy()
        on_wheel -= force * own["rolling_radius"].to_numpy()
        on_roller -= force * rig.roller_radius
    spin = run["pitch_acceleration"]
    left = torque + on_wheel - inertia * spin.sel(body=wheelset).to_numpy()
    left_roller = on_roller - rig.roller_inertia[1] * spin.sel(body=roller).to_numpy()
    inside = slice(1, -1)  # at the very ends an acceleration may belong to the other side of a corner
    scale = float(torque.max())
    return float(np.abs(left[inside]).max()) / scale, float(np.abs(left_roller[inside]).max()) / scale


def carried_weight(run: xr.Dataset, case: Case) -> float:
    """Weight of frame and wheelsets and the load of the secondary suspension at the first output time [N]."""
    part, vehicle = case.vehicle.part, case.vehicle.data
    load = case.gravity * sum(b.mass for b in vehicle.bodies_in(part) if b.name not in part.fixed)
    for element in vehicle.elements_in(part):
        if element.between[0] in part.fixed:
            load -= float(run["element_force_z"].sel(element=element.name).isel(time=0))
    return float(load)


def sliding_course(own: xr.Dataset) -> tuple[Fit, Fit, Fit]:
    """The sliding of a wheel, fitted with the torque times the speed, over time while it rises, and at its final value."""
    torque, speed, sliding, time = (own[name].to_numpy() for name in ("torque", "speed", "sliding", "time"))
    final = torque >= torque.max() * (1 - 1e-12)
    rising, steady = (torque > 0) & ~final, final & (time > time[final][0] + 0.2)
    return (
        fit(sliding, speed, speed * torque),
        fit(sliding[rising], np.ones(int(rising.sum())), time[rising], time[rising] ** 2),
        fit(sliding[steady], np.ones(int(steady.sum())), time[steady]),
    )
