"""The bogie of tests/validation/independent_model as a user of Numba would write it: the same right-hand side in scalar
loops, compiled.

State and conventions: bogie.py there. `pack(parameters)` gives what the compiled functions take.
"""

from __future__ import annotations

import math
from collections import namedtuple
from dataclasses import fields

import numpy as np
from numba import njit

from validation.independent_model.parameters import GRAVITY, Parameters, kalker_spline

Packed = namedtuple(
    "Packed",
    """wheel_start wheel_step wheel rail_start rail_step rail hertz_start hertz_step hertz
    kalker_knots kalker bumpstop number""",
)

_SCALARS = [f.name for f in fields(Parameters) if f.type in ("float", "bool")] + ["shear_modulus"]
_TUPLES = [f.name for f in fields(Parameters) if f.type.startswith("tuple")]
Numbers = namedtuple("Numbers", _SCALARS + _TUPLES)


def pack(p: Parameters) -> Packed:
    """Parameters as nested tuples of floats and arrays, which Numba takes."""
    knots, coefficients = kalker_spline(p.poisson)
    number = Numbers(
        *[float(getattr(p, name)) for name in _SCALARS],
        *[tuple(float(v) for v in getattr(p, name)) for name in _TUPLES],
    )
    return Packed(
        p.wheel.start,
        p.wheel.step,
        p.wheel.coefficients,
        p.rail.start,
        p.rail.step,
        p.rail.coefficients,
        p.hertz.start,
        p.hertz.step,
        p.hertz.coefficients,
        knots,
        coefficients,
        p.bumpstop,
        number,
    )


@njit(cache=True, error_model="numpy", inline="always")
def spline(start, step, c, y):
    """Value, first, second derivative of a uniform cubic spline."""
    i = min(max(int((y - start) / step), 0), c.shape[0] - 1)
    t = y - (start + i * step)
    return (
        c[i, 0] + t * (c[i, 1] + t * (c[i, 2] + t * c[i, 3])),
        c[i, 1] + t * (2 * c[i, 2] + 3 * t * c[i, 3]),
        2 * c[i, 2] + 6 * t * c[i, 3],
    )


@njit(cache=True, error_model="numpy")
def gap_and_mismatch(s, side, o, m, P, newton, g):
    """Reduced contact problem (see contact.py). o centre, m axes of the wheelset (3, 3); fills g, returns gap and mismatch."""
    n = P.number
    z, dz, ddz = spline(P.wheel_start, P.wheel_step, P.wheel, s)
    r, dr = n.wheel_radius + z, side * dz
    y_r = side * (n.tape_circle + s)
    c = y_r + r * dr
    a_x, a_z = o[0] + m[0, 1] * c, o[2] + m[2, 1] * c
    w1 = m[0, 0] * a_z - m[2, 0] * a_x
    w2 = m[0, 1] * a_z - m[2, 1] * a_x
    w3 = m[0, 2] * a_z - m[2, 2] * a_x
    k = w2 * dr
    square = w1 * w1 + w3 * w3
    q = math.sqrt(square - k * k)
    sa, ca = (w1 * k + w3 * q) / square, (w1 * q - w3 * k) / square
    px = o[0] + m[0, 0] * r * sa + m[0, 1] * y_r - m[0, 2] * r * ca
    py = o[1] + m[1, 0] * r * sa + m[1, 1] * y_r - m[1, 2] * r * ca
    pz = o[2] + m[2, 0] * r * sa + m[2, 1] * y_r - m[2, 2] * r * ca
    nx = m[0, 0] * sa - m[0, 1] * dr - m[0, 2] * ca
    ny = m[1, 0] * sa - m[1, 1] * dr - m[1, 2] * ca
    nz = m[2, 0] * sa - m[2, 1] * dr - m[2, 2] * ca
    slope = ny / math.sqrt(nx * nx + nz * nz)
    rho = math.sqrt(px * px + pz * pz)
    y_b = py
    for _ in range(newton):
        h, dh, ddh = spline(P.rail_start, P.rail_step, P.rail, side * y_b - n.rail_origin)
        y_b -= (y_b - py - slope * (rho - n.roller_radius - h)) / (1 + slope * side * dh)
    h, dh, ddh = spline(P.rail_start, P.rail_step, P.rail, side * y_b - n.rail_origin)
    b, db = n.roller_radius + h, side * dh
    g[0], g[1], g[2], g[3], g[4], g[5], g[6], g[7], g[8] = r, dr, ddz, b, db, ddh, y_b, px / rho, pz / rho
    return (rho - b) * math.sqrt(1 + slope * slope), side * (db - slope)


@njit(cache=True, error_model="numpy")
def find_contacts(side, o, m, P, found, geometry):
    """Every indented minimum of one wheel's gap: fills abscissa and gap (rows of found) and geometry; returns their number."""
    n = P.number
    count = 0
    steps = int((n.scan_end - n.scan_start) / n.scan_step + 0.5)
    rail_end = P.rail_start + P.rail_step * P.rail.shape[0]
    g = geometry[-1]
    last_f, last_ok = 0.0, False
    for k in range(steps + 1):
        s = n.scan_start + k * n.scan_step
        gap, f = gap_and_mismatch(s, side, o, m, P, 2, g)
        u = side * g[6] - n.rail_origin
        ok = gap < 3e-4 and u > P.rail_start - n.scan_step and u < rail_end + n.scan_step
        if ok and last_ok and last_f >= 0 and f < 0:
            lo, hi, f_lo, f_hi = s - n.scan_step, s, last_f, f
            x, was = lo, 0
            for _ in range(50):  # regula falsi, Illinois variant
                x_last, x = x, lo - f_lo * (hi - lo) / (f_hi - f_lo)
                gap_x, f_x = gap_and_mismatch(x, side, o, m, P, 3, g)
                if abs(x - x_last) < 1e-13 or f_x == 0:
                    break
                if f_x >= 0:
                    lo, f_lo = x, f_x
                    if was == 1:
                        f_hi *= 0.5
                    was = 1
                else:
                    hi, f_hi = x, f_x
                    if was == -1:
                        f_lo *= 0.5
                    was = -1
            if gap_x < 0 and count < found.shape[0]:
                found[count, 0], found[count, 1] = x, gap_x
                geometry[count, :9] = g[:9]
                count += 1
        last_f, last_ok = f, ok
    return count


@njit(cache=True, error_model="numpy")
def cross(a, b):
    return np.array((a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]))


@njit(cache=True, error_model="numpy")
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy")
def apply(m, a):
    """m a."""
    return np.array(
        (
            m[0, 0] * a[0] + m[0, 1] * a[1] + m[0, 2] * a[2],
            m[1, 0] * a[0] + m[1, 1] * a[1] + m[1, 2] * a[2],
            m[2, 0] * a[0] + m[2, 1] * a[1] + m[2, 2] * a[2],
        )
    )


@njit(cache=True, error_model="numpy")
def apply_transposed(m, a):
    """m^T a."""
    return np.array(
        (
            m[0, 0] * a[0] + m[1, 0] * a[1] + m[2, 0] * a[2],
            m[0, 1] * a[0] + m[1, 1] * a[1] + m[2, 1] * a[2],
            m[0, 2] * a[0] + m[1, 2] * a[1] + m[2, 2] * a[2],
        )
    )


@njit(cache=True, error_model="numpy")
def rotation_zx(phi, psi):
    cf, sf, cp, sp = math.cos(phi), math.sin(phi), math.cos(psi), math.sin(psi)
    return np.array(((cp, -sp * cf, sp * sf), (sp, cp * cf, -cp * sf), (0.0, sf, cf)))


@njit(cache=True, error_model="numpy")
def patch_force(s_gap, g, o, v, omega, spin, P, record):
    """Force and moment of the roller on the wheel at one patch; fills record: point, force, moment, N, sliding, D1, D2."""
    n = P.number
    gap = s_gap[1]
    r, dr, ddr, b, db, ddb = g[0], g[1], g[2], g[3], g[4], g[5]
    root_b, root_r = math.sqrt(1 + db * db), math.sqrt(1 + dr * dr)
    normal = np.array((g[7] / root_b, -db / root_b, g[8] / root_b))
    point = np.array((b * g[7], g[6], b * g[8]))
    t = np.array((0.0, normal[2], -normal[1])) / math.sqrt(normal[1] ** 2 + normal[2] ** 2)
    i = cross(t, normal)
    v_wheel = v + cross(omega, point - o)
    v_roller = np.array((spin * point[2], 0.0, -spin * point[0]))
    v_rel = v_wheel - v_roller
    v_n = dot(v_rel, normal)
    mean = 0.5 * (v_wheel + v_roller)
    speed = math.sqrt(dot(mean, mean) + n.creepage_regularisation_speed**2)

    d1 = 0.5 * (1 / (r * root_r) + 1 / (b * root_b))
    d2_raw = 0.5 * (-ddr / root_r**3 - ddb / root_b**3)
    d2 = min(max(d2_raw, d1 / 200), d1 * 200)
    lam = math.log(d1 / d2)
    k = min(max(int((lam - P.hertz_start) / P.hertz_step), 0), P.hertz.shape[0] - 1)
    x = lam - (P.hertz_start + k * P.hertz_step)
    c = P.hertz[k]
    log_ratio = c[0] + x * (c[1] + x * (c[2] + x * c[3]))
    shape = c[4] + x * (c[5] + x * (c[6] + x * c[7]))
    e_over_k = c[8] + x * (c[9] + x * (c[10] + x * c[11]))
    q = (1 - n.poisson) / n.shear_modulus
    stiffness = 2 * math.pi / (3 * q) / math.sqrt(d1 + d2) * shape
    closing = 0.5 * (math.sqrt(v_n**2 + n.damping_speed**2) - n.damping_speed - v_n)
    load = max(stiffness * (-gap) * math.sqrt(-gap) + n.normal_damping * closing, 0.0)
    a = math.sqrt(-gap * e_over_k / (d1 + d2))
    ab = a * a / math.exp(log_ratio)

    log_ratio = min(max(log_ratio, P.kalker_knots[0]), P.kalker_knots[-1])
    k = 0
    while k < P.kalker.shape[0] - 1 and log_ratio >= P.kalker_knots[k + 1]:
        k += 1
    x = log_ratio - P.kalker_knots[k]
    c = P.kalker[k]
    c11 = c[0, 0] + x * (c[0, 1] + x * (c[0, 2] + x * c[0, 3]))
    c22 = c[1, 0] + x * (c[1, 1] + x * (c[1, 2] + x * c[1, 3]))
    c23 = c[2, 0] + x * (c[2, 1] + x * (c[2, 2] + x * c[2, 3]))
    c33 = c[3, 0] + x * (c[3, 1] + x * (c[3, 2] + x * c[3, 3]))
    modulus, root_ab = n.shear_modulus, math.sqrt(ab)
    f11, f22, f23, f33 = ab * modulus * c11, ab * modulus * c22, ab * root_ab * modulus * c23, ab * ab * modulus * c33
    sliding = dot(v_rel, i)
    eps_x, eps_y = sliding / speed, dot(v_rel, t) / speed
    eps_sp = (dot(omega, normal) - spin * normal[1]) / speed
    tx, ty, spin_moment = -f11 * eps_x, -f22 * eps_y - f23 * eps_sp, f23 * eps_y - f33 * eps_sp
    tau = (math.sqrt(tx * tx + ty * ty) + 1e-10) / (n.friction * load + 1e-10)
    shrink = 1 - tau / 3 + tau * tau / 27 if tau <= 3 else 1 / tau
    tx, ty = shrink * tx, shrink * ty
    for j in range(3):
        record[j] = point[j]
        record[3 + j] = load * normal[j] + tx * i[j] + ty * t[j]
        record[6 + j] = spin_moment * normal[j]
    record[9], record[10], record[11], record[12] = load, sliding, d1, d2_raw
    record[13] = s_gap[0]
    record[14] = gap


@njit(cache=True, error_model="numpy")
def wheel_patches(x, wheel, P, records):
    """Patches of one wheel (0..3) in the state x: rows of records; returns their number."""
    n = P.number
    at = 12 + 11 * (wheel // 2)
    m = rotation_zx(x[at + 3], x[at + 4])
    o = np.array((x[at], x[at + 1], x[at + 2] + n.roller_radius + n.wheel_radius))
    omega = np.empty(3)
    for j in range(3):
        omega[j] = x[at + 8] * m[j, 0] + x[at + 10] * m[j, 1]
    omega[2] += x[at + 9]
    found, geometry = np.empty((6, 2)), np.empty((7, 9))
    count = find_contacts(1.0 - 2.0 * (wheel % 2), o, m, P, found, geometry)
    for k in range(count):
        patch_force(found[k], geometry[k], o, x[at + 5 : at + 8], omega, x[34 + wheel // 2], P, records[k])
    return count


@njit(cache=True, error_model="numpy")
def rhs(t, x, P):
    """x_dot of the whole model; state as in bogie.py."""
    n = P.number
    x_dot = np.empty(52)
    for j in range(6):
        x_dot[j] = x[6 + j]
    for j in range(5):
        x_dot[12 + j] = x[17 + j]
        x_dot[23 + j] = x[28 + j]
    phi, theta = x[3], x[4]
    cf, sf, ct, st = math.cos(phi), math.sin(phi), math.cos(theta), math.sin(theta)
    m0 = rotation_zx(phi, x[5])
    m_f = np.empty((3, 3))
    for j in range(3):
        m_f[j, 0], m_f[j, 1], m_f[j, 2] = m0[j, 0] * ct - m0[j, 2] * st, m0[j, 1], m0[j, 0] * st + m0[j, 2] * ct
    phi_d, theta_d, psi_d = x[9], x[10], x[11]
    omega_body = np.array((ct * phi_d - st * cf * psi_d, theta_d + sf * psi_d, st * phi_d + ct * cf * psi_d))
    omega_f = apply(m_f, omega_body)
    o_f = np.array((x[0], x[1], x[2] + n.frame_height))
    v_f = x[6:9].copy()
    force_f = np.array((0.0, 0.0, -n.frame_mass * GRAVITY))
    moment_f = np.zeros(3)

    # secondary suspension; the springs are clamped at both ends
    for k in range(2):
        side = 1.0 - 2.0 * k
        middle = 0.5 * (n.secondary_top + n.secondary_bottom)
        local = np.array((0.0, side * n.secondary_y, middle - n.frame_height))
        arm = apply(m_f, local)
        stretch = arm - local + x[:3]
        in_frame = apply_transposed(m_f, stretch)
        force = np.empty(3)
        for j in range(3):
            force[j] = -0.5 * n.secondary_stiffness[j] * (stretch[j] + in_frame[j])
        force[2] -= n.secondary_preload
        turned = apply(m_f, force)
        force_f += 0.5 * (force + turned)
        moment_f += 0.5 * (cross(arm, force) + cross(arm - stretch, turned))
        for damper in range(2):
            state = 48 + 2 * k + damper
            if damper == 0:
                local = np.array((0.0, side * n.vertical_damper_y, n.vertical_damper_ends[1] - n.frame_height))
                axis, damping, series = 2, n.vertical_damper[0], n.vertical_damper[1]
            else:
                local = np.array((0.0, side * n.lateral_damper_y, n.lateral_damper_z - n.frame_height))
                axis, damping, series = 1, n.lateral_damper[0], n.lateral_damper[1]
            arm = apply(m_f, local)
            pull = series * (arm[axis] - local[axis] + x[axis] - x[state])
            x_dot[state] = pull / damping
            force = np.zeros(3)
            force[axis] = -pull
            force_f += force
            moment_f += cross(arm, force)
    local = np.array((0.0, 0.0, n.rod_z - n.frame_height))
    arm = apply(m_f, local)
    speed = v_f + cross(omega_f, arm)
    force = np.array((-n.rod[0] * (arm[0] - local[0] + x[0]) - n.rod[1] * speed[0], 0.0, 0.0))
    force_f += force
    moment_f += cross(arm, force)
    local = np.array((0.0, 0.0, n.bumpstop_z - n.frame_height))
    arm = apply(m_f, local)
    y = arm[1] - local[1] + x[1]
    table = P.bumpstop
    k = 0
    while k < table.shape[1] - 2 and abs(y) >= table[0, k + 1]:
        k += 1
    stop = table[1, k] + (table[1, k + 1] - table[1, k]) / (table[0, k + 1] - table[0, k]) * (abs(y) - table[0, k])
    force = np.array((0.0, -math.copysign(stop, y), 0.0))
    force_f += force
    moment_f += cross(arm, force)
    # jac^T m = f with jac = [[ct, 0, -st cf], [0, 1, sf], [st, 0, ct cf]]
    f_roll, f_pitch = -(2 * n.secondary_bending + n.anti_roll) * phi, -2 * n.secondary_bending * theta
    along = -f_pitch * sf / cf
    moment_f += apply(m_f, np.array((ct * f_roll - st * along, f_pitch, st * f_roll + ct * along)))

    torque = n.torque * min(max((t - n.torque_start) / (n.torque_full - n.torque_start), 0.0), 1.0)
    records = np.empty((6, 15))
    for ws in range(2):
        at = 12 + 11 * ws
        m = rotation_zx(x[at + 3], x[at + 4])
        axle = m[:, 1].copy()
        base_x = n.semi_wheelbase * (1.0 - 2.0 * ws)
        o_w = np.array((base_x + x[at], x[at + 1], x[at + 2] + n.wheel_radius))
        force_w = np.array((0.0, 0.0, -n.wheelset_mass * GRAVITY))
        moment_w = torque * axle
        moment_f -= moment_w
        # primary suspension
        for k in range(2):
            side = 1.0 - 2.0 * k
            arm = axle * (side * n.primary_y)
            box = o_w + arm - o_f
            d = apply_transposed(m_f, box)
            d[0] -= base_x
            d[1] -= side * n.primary_y
            d[2] -= n.primary_z - n.frame_height
            force = np.empty(3)
            for j in range(3):
                state = 36 + 6 * ws + 3 * k + j
                pull = n.primary_series[j] * (d[j] - x[state])
                x_dot[state] = pull / n.primary_damping[j]
                force[j] = -n.primary_stiffness[j] * d[j] - pull
            force[2] -= n.primary_preload
            force = apply(m_f, force)
            force_w += force
            moment_w = moment_w + cross(arm, force)
            force_f -= force
            moment_f -= cross(box, force)
        # contact
        centre = np.array((x[at], x[at + 1], x[at + 2] + n.roller_radius + n.wheel_radius))
        on_roller = 0.0
        for k in range(2):
            count = wheel_patches(x, 2 * ws + k, P, records)
            for j in range(count):
                point, force, moment = records[j, 0:3], records[j, 3:6], records[j, 6:9]
                force_w += force
                moment_w = moment_w + cross(point - centre, force) + moment
                on_roller -= point[2] * force[0] - point[0] * force[2] + moment[1]
        x_dot[34 + ws] = 0.0 if n.hold_rollers > 0 else on_roller / n.roller_inertia
        # Newton, Euler of the wheelset
        across, inertia = n.wheelset_inertia
        local = apply_transposed(m, moment_w)
        sin, cos = math.sin(x[at + 3]), math.cos(x[at + 3])
        p_d, y_d, t_d = x[at + 8], x[at + 9], x[at + 10]
        l2, l3 = inertia * (t_d + y_d * sin), across * y_d * cos
        for j in range(3):
            x_dot[at + 5 + j] = force_w[j] / n.wheelset_mass
        x_dot[at + 8] = (local[0] - y_d * sin * l3 + y_d * cos * l2) / across
        x_dot[at + 9] = ((local[2] - p_d * l2 + y_d * sin * across * p_d) / across + y_d * p_d * sin) / cos
        x_dot[at + 10] = local[1] / inertia - x_dot[at + 9] * sin - y_d * p_d * cos

    # Newton, Euler of the frame
    i1, i2, i3 = n.frame_inertia
    local = apply_transposed(m_f, moment_f)
    w1, w2, w3 = omega_body
    e1 = (local[0] - (i3 - i2) * w2 * w3) / i1 - psi_d * (-ct * cf * theta_d + st * sf * phi_d) + phi_d * theta_d * st
    e2 = (local[1] - (i1 - i3) * w3 * w1) / i2 - psi_d * cf * phi_d
    e3 = (local[2] - (i2 - i1) * w1 * w2) / i3 + psi_d * (st * cf * theta_d + ct * sf * phi_d) - phi_d * theta_d * ct
    x_dot[9] = ct * e1 + st * e3
    x_dot[11] = (ct * e3 - st * e1) / cf
    x_dot[10] = e2 - sf * x_dot[11]
    for j in range(3):
        x_dot[6 + j] = force_f[j] / n.frame_mass
    return x_dot


@njit(cache=True, error_model="numpy")
def wheel_outputs(x, P):
    """Absolute sliding [m/s], Fx, Fz and N [N] of the four wheels, shape (4, 4)."""
    out = np.zeros((4, 4))
    records = np.empty((6, 15))
    for wheel in range(4):
        for j in range(wheel_patches(x, wheel, P, records)):
            r = records[j]
            out[0, wheel] += r[9] * r[10]
            out[1, wheel] += r[3]
            out[2, wheel] += r[5]
            out[3, wheel] += r[9]
        out[0, wheel] /= max(out[3, wheel], 1e-9)
    return out
