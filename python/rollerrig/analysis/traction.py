"""What theory says about a bogie under traction on free rollers, beside what a run gave.

    run of the traction case -> [closed forms] -> sliding, longitudinal force and load transfer, computed and expected

Rolling:        C = J_w a + F r  and  F R = J_R a r / R  for each axle     =>  F = C / r * m_R / (m_R + m_w),  m = J / r^2
Sliding:        F = -K (e - e_0), K the slope of the creep law at the start  =>  sliding = V (e_0 - F / K)
Load transfer:  moments of the whole bogie about the middle of its crown line; frame and wheelsets shift and pitch on their
                springs, and a wheelset off the crown by x feels its load along x: Q x / (R + r).
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.analysis.signals import Fit, fit
from rollerrig.assembly.laws import core_law
from rollerrig.common.arrays import Array
from rollerrig.config import Case, Rig
from rollerrig.results import variable

ITERATIONS = 60
"""Iterations of the fixed point for the shifts; each gains about a digit."""


@dataclass(frozen=True)
class Bogie:
    """What the balance of moments needs, from the case."""

    half_base: float  # half the wheelbase [m]
    wheel_radius: float  # [m]
    roller_radius: float  # [m]
    wheelset_inertia: float  # spin inertia of one wheelset [kg m^2]
    roller_inertia: float  # spin inertia of one roller pair [kg m^2]
    wheelset_mass: float  # of one wheelset [kg]
    frame_mass: float  # [kg]
    frame_height: float  # of the frame's centre of mass [m]
    frame_load: float  # load that the secondary springs put on the frame [N]
    # height [m] and longitudinal stiffness [N/m] of each element between frame and car body
    restraints: tuple[tuple[float, float], ...]
    secondary_height: float  # at which that load acts on the frame [m]
    # share of that load on springs clamped at both ends, which lean by half of the frame's pitch and shift
    clamped: float
    pitch_stiffness: float  # of the elements between frame and car body [N m/rad]
    gravity: float  # its acceleration [m/s^2]
    primary: tuple[float, float]  # longitudinal and vertical stiffness of one axle's suspension [N/m]
    primary_height: float  # of its springs [m]

    @property
    def share_to_roller(self) -> float:
        """Part of C / r that reaches the roller; the rest spins up the wheelset."""
        roller = self.roller_inertia / self.roller_radius**2
        return roller / (roller + self.wheelset_inertia / self.wheel_radius**2)


def bogie_of(case: Case, axle_load: float) -> Bogie:
    """Gather the numbers from a case with one frame and two wheelsets on a rig.

    Args:
        case: the traction case.
        axle_load: static load of one axle [N].

    Raises:
        ValueError: the case is no bogie on a rig.
    """
    support, vehicle = case.support.data, case.vehicle.data
    bodies = vehicle.bodies_in(case.vehicle.part)
    wheelsets = [b for b in bodies if b.kind == "wheelset"]
    frames = [b for b in bodies if b.kind == "rigid" and b.name not in case.vehicle.part.fixed]
    if not isinstance(support, Rig) or len(wheelsets) != 2 or len(frames) != 1:
        raise ValueError(f"{case.name}: the traction study needs one frame on two wheelsets, on a rig")
    frame = frames[0]
    restraints, pitch, kx, kz, primary_height = [], 0.0, 0.0, 0.0, wheelsets[0].position[2]
    heights, clamped = [], []
    for element in vehicle.elements_in(case.vehicle.part):
        laws = element.laws
        x_stiffness = laws["x"].stiffness or 0.0 if "x" in laws else 0.0
        if wheelsets[0].name in element.between:
            kx += x_stiffness
            kz += (laws["z"].stiffness or 0.0) if "z" in laws else 0.0
            primary_height = element.end_b[2]
        elif frame.name in element.between and wheelsets[1].name not in element.between:
            end = element.end_b if element.between[1] == frame.name else element.end_a
            restraints.append((end[2], x_stiffness))
            pitch += (laws["pitch"].stiffness or 0.0) if "pitch" in laws else 0.0
            if element.carries_load:
                heights.append(end[2])
                clamped.append(element.clamped)
    frame_load = 2 * axle_load - (2 * wheelsets[0].mass + frame.mass) * case.gravity
    return Bogie(
        half_base=0.5 * abs(wheelsets[0].position[0] - wheelsets[1].position[0]),
        wheel_radius=vehicle.wheel.radius,
        roller_radius=support.roller_radius,
        wheelset_inertia=wheelsets[0].inertia[1],
        roller_inertia=support.roller_inertia[1],
        wheelset_mass=wheelsets[0].mass,
        frame_mass=frame.mass,
        frame_height=frame.position[2],
        frame_load=frame_load,
        restraints=tuple(restraints),
        secondary_height=float(np.mean(heights)) if heights else frame.position[2],
        clamped=float(np.mean(clamped)) if clamped else 0.0,
        pitch_stiffness=pitch,
        gravity=case.gravity,
        primary=(kx, kz),
        primary_height=primary_height,
    )


@dataclass(frozen=True)
class Balance:
    """Closed forms over time; one axle each [N]."""

    creep_force: Array  # tangential force on one wheelset
    # force along x on front and rear wheelset; more than the creep force, since both left the crown
    longitudinal: tuple[Array, Array]
    vertical: tuple[Array, Array]  # force on front and rear wheelset
    shift: tuple[Array, Array]  # of front and rear wheelset from the crown [m]


def balance(bogie: Bogie, torque: Array, axle_load: float) -> Balance:
    """Quasi-static balance of the bogie under equal torques on both wheelsets that react on the frame.

    Args:
        bogie: from `bogie_of`.
        torque: on each wheelset [N m].
        axle_load: static load of one axle [N].
    """
    r, big_r, base = bogie.wheel_radius, bogie.roller_radius, bogie.half_base
    creep = bogie.share_to_roller * torque / r
    spin_up = 2 * (torque - creep * r)  # rate of both wheelsets' angular momentum
    lean = 0.5 * bogie.clamped * bogie.frame_load
    k = np.array([stiffness for _, stiffness in bogie.restraints])
    z = np.array([height for height, _ in bogie.restraints]) - bogie.frame_height
    frame_x, pitch, transfer = (np.zeros_like(torque) for _ in range(3))
    front, rear = np.zeros_like(torque), np.zeros_like(torque)
    for _ in range(ITERATIONS):
        pull = [
            creep + load * x / (big_r + r) for load, x in ((axle_load - transfer, front), (axle_load + transfer, rear))
        ]
        frame_x = (pull[0] + pull[1] - pitch * (float(k @ z) + lean)) / k.sum()
        springs = frame_x + pitch * (bogie.primary_height - bogie.frame_height)
        front, rear = (springs + force / bogie.primary[0] for force in pull)
        shift = 0.5 * (front + rear)
        moment = spin_up + bogie.pitch_stiffness * pitch + shift * big_r / (big_r + r) * 2 * axle_load
        for height, stiffness in zip(z, k, strict=True):
            moment = moment + (height + bogie.frame_height) * stiffness * (frame_x + pitch * height)
        load_x = frame_x + pitch * (bogie.secondary_height - bogie.frame_height)
        moment = moment - bogie.gravity * (2 * bogie.wheelset_mass * shift + bogie.frame_mass * frame_x)
        moment_of_load = (bogie.frame_load - lean) * load_x - lean * bogie.secondary_height * pitch
        transfer = (moment - moment_of_load) / (2 * base)
        pitch = -transfer / (bogie.primary[1] * base)
    vertical = (axle_load - transfer, axle_load + transfer)
    return Balance(creep, (pull[0], pull[1]), vertical, (front, rear))


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
    forces = balance(bogie_of(case, axle_load), torque, axle_load)
    names = [str(w) for w in run["wheel"].to_numpy()]
    first = names[0].rsplit("_", 1)[0]
    speed = run["speed"].to_numpy()
    sliding, along, up = (np.zeros((len(time), len(names))) for _ in range(3))
    creep = np.repeat(0.5 * forces.creep_force[:, None], len(names), axis=1)
    for k, name in enumerate(names):
        axle = 0 if name.startswith(first) else 1
        start = run.sel(wheel=name).isel(time=0)
        free = float(start["longitudinal_sliding"]) / float(start["speed"])
        sliding[:, k] = np.abs(speed * (free - 0.5 * forces.creep_force / creep_slope(run, case, name)))
        along[:, k], up[:, k] = 0.5 * forces.longitudinal[axle], 0.5 * forces.vertical[axle]
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
