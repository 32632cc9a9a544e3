"""The bogie on the roller rig as a user of NumPy and SciPy would write it: right-hand side for solve_ivp.

State x, 52 numbers (displacements from the design position, their rates, damper states):

    x[0:6]    frame x, y, z [m], roll phi, pitch theta, yaw psi [rad]
    x[6:12]   their rates
    x[12:17]  leading wheelset x, y, z [m], phi, psi [rad]
    x[17:23]  rates of x, y, z, phi, psi and spin theta_dot [rad/s] (+V/r when running forward)
    x[23:34]  trailing wheelset, the same
    x[34:36]  spin rates of the roller pairs under them [rad/s] (-V/R when running forward)
    x[36:48]  Maxwell dampers of the primary suspension: spring side of the damper [m];
              boxes leading left, leading right, trailing left, trailing right; x, y, z in each
    x[48:52]  Maxwell dampers of the secondary suspension: left vertical, left lateral, right vertical, right lateral

Orientation R = Rz(psi) Rx(phi) Ry(theta). Force elements: axes of body a, deflection d = R_a^T (P_b - P_a) less its design
value, force on both bodies at P_b; a is the car body (secondary) or the frame (primary).
Contact: contact.py.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .contact import SIDE, WHEELSET_OF, cross, patches, rotation_y, rotation_zx
from .parameters import GRAVITY, Parameters

STATES = 52
SECONDARY_SIDE = np.array([1.0, -1.0])


# ----------------------------------------------------------------------------------------------- bodies
def contact_of(x: np.ndarray, p: Parameters) -> dict[str, np.ndarray]:
    """Patches in the state x."""
    o, rot, v, omega = wheelset_motion(x)
    lift = np.array([0.0, 0.0, p.roller_radius + p.wheel_radius])
    return patches(o + lift, rot, v, omega, x[34:36], p)


def wheelset_motion(x: np.ndarray):
    """Displacement (2, 3), axes (2, 3, 3), velocity (2, 3) and angular velocity (2, 3) of the wheelsets."""
    q = np.stack([x[12:23], x[23:34]])
    rot = np.stack([rotation_zx(q[0, 3], q[0, 4]), rotation_zx(q[1, 3], q[1, 4])])
    phi_d, psi_d, theta_d = q[:, 8], q[:, 9], q[:, 10]
    omega = phi_d[:, None] * rot[:, :, 0] + theta_d[:, None] * rot[:, :, 1]
    omega[:, 2] += psi_d  # phi about Rz e_x, which is the first column; psi about e_z
    return q[:, :3], rot, q[:, 5:8], omega


def rhs(t: float, x: np.ndarray, p: Parameters) -> np.ndarray:
    """x_dot of the whole model; see the module's text for the state."""
    x_dot = np.empty(STATES)
    x_dot[0:6], x_dot[12:17], x_dot[23:28] = x[6:12], x[17:22], x[28:33]

    # frame
    o_f, v_f = x[0:3] + [0.0, 0.0, p.frame_height], x[6:9]
    phi, theta = x[3], x[4]
    rot_f0, rot_y = rotation_zx(x[3], x[5]), rotation_y(theta)
    rot_f = rot_f0 @ rot_y
    rates = x[9:12]
    cf, sf, ct, st = np.cos(phi), np.sin(phi), np.cos(theta), np.sin(theta)
    jac = np.array([[ct, 0.0, -st * cf], [0.0, 1.0, sf], [st, 0.0, ct * cf]])  # body rates from roll, pitch, yaw rates
    omega_body = jac @ rates
    omega_f = rot_f @ omega_body
    force_f = np.array([0.0, 0.0, -p.frame_mass * GRAVITY])
    moment_f = np.zeros(3)

    # secondary suspension: car body (held) to frame; element axes are the rig's
    def end_on_frame(local):
        arm = local @ rot_f.T
        return arm, arm - local + x[0:3], v_f + cross(omega_f, arm)

    up = p.frame_height
    # coil springs clamped at both ends: half of the force along the rig's axes at the frame's point, half along the frame's
    # at the car body's, both at mid-height
    middle = 0.5 * (p.secondary_top + p.secondary_bottom)
    springs = np.array([[0.0, y * p.secondary_y, middle - up] for y in SECONDARY_SIDE])
    arm, stretch, _ = end_on_frame(springs)
    force = -0.5 * (stretch + stretch @ rot_f) * p.secondary_stiffness
    force[:, 2] -= p.secondary_preload
    turned = force @ rot_f.T
    force_f += 0.5 * (force + turned).sum(axis=0)
    moment_f += 0.5 * (cross(arm, force) + cross(arm - stretch, turned)).sum(axis=0)

    ends = np.array(
        [
            [0.0, y * yy, zz - up]
            for y in SECONDARY_SIDE
            for yy, zz in ((p.vertical_damper_y, p.vertical_damper_ends[1]), (p.lateral_damper_y, p.lateral_damper_z))
        ]
    )
    arm, d, _ = end_on_frame(ends)
    axis = np.array([2, 1, 2, 1])
    damping = np.array([p.vertical_damper[0], p.lateral_damper[0]] * 2)
    series = np.array([p.vertical_damper[1], p.lateral_damper[1]] * 2)
    pull = series * (d[np.arange(4), axis] - x[48:52])
    x_dot[48:52] = pull / damping
    force = np.zeros((4, 3))
    force[np.arange(4), axis] = -pull
    force_f += force.sum(axis=0)
    moment_f += cross(arm, force).sum(axis=0)

    arm, d, d_dot = end_on_frame(np.array([[0.0, 0.0, p.rod_z - up], [0.0, 0.0, p.bumpstop_z - up]]))
    y_stop, knots, table = d[1, 1], p.bumpstop[0], p.bumpstop[1]
    last = (table[-1] - table[-2]) / (knots[-1] - knots[-2])
    stop = np.interp(abs(y_stop), knots, table) + last * max(abs(y_stop) - knots[-1], 0.0)
    force = np.zeros((2, 3))
    force[0, 0] = -p.rod[0] * d[0, 0] - p.rod[1] * d_dot[0, 0]
    force[1, 1] = -np.sign(y_stop) * stop
    force_f += force.sum(axis=0)
    moment_f += cross(arm, force).sum(axis=0)

    # rotational springs act along roll, pitch, yaw of frame relative to car body: m . omega = f . rates
    generalised = np.array([-(2 * p.secondary_bending + p.anti_roll) * x[3], -2 * p.secondary_bending * x[4], 0.0])
    moment_f += rot_f @ np.linalg.solve(jac.T, generalised)

    # primary suspension: frame to the ends of the axles
    disp, rot_w, v_w, omega_w = wheelset_motion(x)
    base = np.array([[p.semi_wheelbase, 0.0, p.wheel_radius], [-p.semi_wheelbase, 0.0, p.wheel_radius]])
    o_w = base + disp
    ends_w = rot_w[WHEELSET_OF, :, 1] * (SIDE * p.primary_y)[:, None]
    p_box = o_w[WHEELSET_OF] + ends_w
    local = base[WHEELSET_OF] + np.outer(SIDE, [0.0, p.primary_y, 0.0]) - [0.0, 0.0, p.frame_height]
    local[:, 2] += p.primary_z - p.wheel_radius
    d = (p_box - o_f) @ rot_f - local
    pull = np.array(p.primary_series) * (d - x[36:48].reshape(4, 3))
    x_dot[36:48] = (pull / p.primary_damping).ravel()
    force = -(d * p.primary_stiffness + pull)
    force[:, 2] -= p.primary_preload
    force = force @ rot_f.T  # on the wheelset
    force_f -= force.sum(axis=0)
    moment_f -= cross(p_box - o_f, force).sum(axis=0)
    force_w = np.array([[0.0, 0.0, -p.wheelset_mass * GRAVITY]] * 2)
    moment_w = np.zeros((2, 3))
    np.add.at(force_w, WHEELSET_OF, force)
    np.add.at(moment_w, WHEELSET_OF, cross(ends_w, force))

    # torque on the wheelsets, reacting on the frame
    torque = p.torque_at(t) * rot_w[:, :, 1]
    moment_w += torque
    moment_f -= torque.sum(axis=0)

    # contact
    lift = np.array([0.0, 0.0, p.roller_radius + p.wheel_radius])
    c = patches(disp + lift, rot_w, v_w, omega_w, x[34:36], p)
    ws = WHEELSET_OF[c["wheel"]]
    np.add.at(force_w, ws, c["force"])
    np.add.at(moment_w, ws, cross(c["point"] - (disp + lift)[ws], c["force"]) + c["moment"])
    roller = np.zeros(2)
    np.add.at(roller, ws, -(cross(c["point"], c["force"]) + c["moment"])[:, 1])
    x_dot[34:36] = 0.0 if p.hold_rollers else roller / p.roller_inertia

    # Newton and Euler
    x_dot[6:9] = force_f / p.frame_mass
    phi_d, theta_d, psi_d = rates
    jac_dot_rates = psi_d * np.array(
        [-ct * cf * theta_d + st * sf * phi_d, cf * phi_d, -st * cf * theta_d - ct * sf * phi_d]
    )
    jac_dot_rates += phi_d * theta_d * np.array([-st, 0.0, ct])
    inertia = np.array(p.frame_inertia)
    omega_dot = (rot_f.T @ moment_f - cross(omega_body, inertia * omega_body)) / inertia
    x_dot[9:12] = np.linalg.solve(jac, omega_dot - jac_dot_rates)
    across, spin = p.wheelset_inertia
    for k, at in ((0, 12), (1, 23)):
        m = rot_w[k].T @ moment_w[k]
        phi = x[at + 3]
        phi_d, psi_d, theta_d = x[at + 8 : at + 11]
        sf, cf = np.sin(phi), np.cos(phi)
        l2 = spin * (theta_d + psi_d * sf)
        l3 = across * psi_d * cf
        x_dot[at + 5 : at + 8] = force_w[k] / p.wheelset_mass
        x_dot[at + 8] = (m[0] - psi_d * sf * l3 + psi_d * cf * l2) / across
        x_dot[at + 9] = ((m[2] - phi_d * l2 + psi_d * sf * across * phi_d) / across + psi_d * phi_d * sf) / cf
        x_dot[at + 10] = m[1] / spin - x_dot[at + 9] * sf - psi_d * phi_d * cf
    return x_dot


# ------------------------------------------------------------------------ Jacobian, equilibrium, outputs
def difference_steps() -> np.ndarray:
    """Steps of central differences in each state.

    solve_ivp's own differences scale with |x| and atol; here displacements are micrometres next to rolling speeds of 1e2 rad/s,
    its Jacobian is mostly noise, and the implicit methods need 20 times the evaluations.
    """
    step = np.full(STATES, 1e-8)
    step[[*range(6, 12), *range(17, 23), *range(28, 36)]] = 1e-6
    return step


def absolute_tolerances() -> np.ndarray:
    """Sizes below which a state does not matter: 10 nm and nrad, 0.1 um/s, 1e-5 rad/s of spin."""
    size = np.full(STATES, 1e-8)
    size[[*range(6, 12), *range(17, 22), *range(28, 33)]] = 1e-7
    size[[22, 33, 34, 35]] = 1e-5
    return size


def jacobian(function, t: float, x: np.ndarray) -> np.ndarray:
    """Central differences of function(t, x), shape (52, 52)."""
    a = np.empty((STATES, STATES))
    x = x.copy()
    for k, h in enumerate(difference_steps()):
        x_k = x[k]
        x[k] = x_k + h
        a[:, k] = function(t, x)
        x[k] = x_k - h
        a[:, k] -= function(t, x)
        a[:, k] /= 2 * h
        x[k] = x_k
    return a


def rolling_state(speed: float, p: Parameters) -> np.ndarray:
    """Design position, wheels and rollers turning at `speed` [m/s]."""
    x = np.zeros(STATES)
    x[[22, 33]] = speed / p.wheel_radius
    x[34:36] = -speed / p.roller_radius
    return x


def equilibrium(speed: float, p: Parameters, function=rhs) -> np.ndarray:
    """Steady running without torque, rollers held at `speed` [m/s]: Newton on positions, spins and damper states.

    Args:
        speed: of the rollers' surface [m/s].
        p: parameters.
        function: rhs(t, x, parameters) to bring to rest.
    """
    held = replace(p, hold_rollers=True, torque=0.0)
    x = rolling_state(speed, p)
    x[[2, 14, 25]] = -3e-4
    free = np.r_[0:6, 12:17, 22, 23:28, 33, 36:52]
    rates = np.r_[6:12, 17:22, 22, 28:33, 33, 36:52]
    position = ~np.isin(free, (22, 33))
    for _ in range(60):
        f = function(0.0, x, held)[rates]
        jac = jacobian(lambda t, y: function(t, y, held), 0.0, x)[np.ix_(rates, free)]
        dx = -np.linalg.solve(jac, f)
        dx *= min(1.0, 2e-4 / np.abs(dx[position]).max())
        x[free] += dx
        if np.abs(dx[position]).max() < 1e-12:
            break
    return x


def wheel_outputs(x: np.ndarray, p: Parameters) -> dict[str, np.ndarray]:
    """Absolute sliding (normal-force weighted, [m/s]), longitudinal and vertical force [N], per wheel (4,)."""
    c = contact_of(x, p)
    out = {name: np.zeros(4) for name in ("sliding", "fx", "fz", "n")}
    np.add.at(out["n"], c["wheel"], c["n"])
    np.add.at(out["sliding"], c["wheel"], c["n"] * c["sliding"])
    np.add.at(out["fx"], c["wheel"], c["force"][:, 0])
    np.add.at(out["fz"], c["wheel"], c["force"][:, 2])
    out["sliding"] = out["sliding"] / np.maximum(out["n"], 1e-9)
    return out
