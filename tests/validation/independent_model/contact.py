"""Wheel-roller contact of the independent model: every patch of four wheels and its forces, in NumPy.

    poses and velocities of two wheelsets  ->  contact_points: geometry  ->  patches: Hertz, Kalker, saturation

Malvezzi, Meli, Pugi (2010), eqs. (1)-(24), numbers at the margin. Frames and units: parameters.py.
"""

from __future__ import annotations

import numpy as np

from .parameters import Parameters, kalker_spline

SIDE = np.array([1.0, -1.0, 1.0, -1.0])  # +1 left, -1 right
WHEELSET_OF = np.array([0, 0, 1, 1])


# ------------------------------------------------------------------------------------------- kinematics
def rotation_zx(phi: float, psi: float) -> np.ndarray:
    """Rz(psi) Rx(phi)."""
    cf, sf, cp, sp = np.cos(phi), np.sin(phi), np.cos(psi), np.sin(psi)
    return np.array([[cp, -sp * cf, sp * sf], [sp, cp * cf, -cp * sf], [0.0, sf, cf]])


def rotation_y(theta: float) -> np.ndarray:
    """Ry(theta)."""
    c, s = np.cos(theta), np.sin(theta)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cross product over the last axis (np.cross is several times slower on small arrays)."""
    a1, a2, a3, b1, b2, b3 = a[..., 0], a[..., 1], a[..., 2], b[..., 0], b[..., 1], b[..., 2]
    return np.stack([a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1], axis=-1)


# -------------------------------------------------------------------------------------------- contact
def gap_and_mismatch(s, side, o, rot, p: Parameters, newton: int = 3):
    """Reduced contact problem of one wheel abscissa per row: (7), (8) less the one equation that is left.

    The common normal meets both axes. The wheel's normals at abscissa s form a cone with its apex on the wheelset's axis; the
    normal that also meets the roller's axis gives x_r, its foot on the roller gives x_b and y_b.

    Args:
        s: wheel abscissae [m], shape (..., n).
        side: +1 left, -1 right, broadcastable to s.
        o: wheelset centre from the middle of the roller's axis [m], shape (..., 3) with a length-1 axis for n.
        rot: axes of the wheelset (without spin), shape (..., 3, 3), likewise.

    Returns:
        p_n signed gap along the normal [m], negative: overlap; mismatch of slopes, falls through 0 at a minimum of the gap;
        dictionary of the points' geometry.
    """
    z, dz, ddz = p.wheel(s)
    r, dr = p.wheel_radius + z, side * dz
    y_r = side * (p.tape_circle + s)
    apex = o + rot[..., :, 1] * (y_r + r * dr)[..., None]
    a_x, a_z = apex[..., 0], apex[..., 2]
    w1 = rot[..., 0, 0] * a_z - rot[..., 2, 0] * a_x
    w2 = rot[..., 0, 1] * a_z - rot[..., 2, 1] * a_x
    w3 = rot[..., 0, 2] * a_z - rot[..., 2, 2] * a_x
    # normal of angle alpha through the roller's axis: w1 sin(alpha) - w3 cos(alpha) = w2 r', the solution that points down
    k = w2 * dr
    square = w1 * w1 + w3 * w3
    q = np.sqrt(square - k * k)
    sa, ca = (w1 * k + w3 * q) / square, (w1 * q - w3 * k) / square
    root = np.sqrt(1 + dr * dr)
    n_local = np.stack([sa, -dr, -ca], axis=-1) / root[..., None]  # (4)
    p_local = np.stack([r * sa, y_r, -r * ca], axis=-1)  # (1)
    p_r = o + (rot @ p_local[..., None])[..., 0]  # (2)
    n_r = (rot @ n_local[..., None])[..., 0]  # (5)
    slope = n_r[..., 1] / np.hypot(n_r[..., 0], n_r[..., 2])  # roller slope that is parallel to the wheel
    rho = np.hypot(p_r[..., 0], p_r[..., 2])
    y_b = p_r[..., 1]
    for _ in range(newton):  # foot of the normal on the roller
        h, dh, _ = p.rail(side * y_b - p.rail_origin)
        y_b = y_b - (y_b - p_r[..., 1] - slope * (rho - p.roller_radius - h)) / (1 + slope * side * dh)
    h, dh, ddh = p.rail(side * y_b - p.rail_origin)
    b, db = p.roller_radius + h, side * dh
    gap = (rho - b) * np.sqrt(1 + slope * slope)
    mismatch = side * (db - slope)
    return (
        gap,
        mismatch,
        {
            "r": r,
            "dr": dr,
            "ddr": ddz,
            "b": b,
            "db": db,
            "ddb": ddh,
            "y_b": y_b,
            "direction": p_r[..., [0, 2]] / rho[..., None],
        },
    )


def contact_points(o, rot, p: Parameters):
    """Every indented minimum of the gap of the four wheels: scan of the wheel abscissa, then polished roots.

    Args:
        o: wheelset centres from the middle of their roller's axis, shape (2, 3) [m].
        rot: wheelset axes, shape (2, 3, 3).

    Returns:
        wheel index (0..3) of each patch, its wheel abscissa [m], gap [m] and geometry as `gap_and_mismatch`.
    """
    s = np.arange(p.scan_start, p.scan_end + p.scan_step / 2, p.scan_step)
    s4, side4 = np.broadcast_to(s, (4, s.size)), SIDE[:, None]
    o4, rot4 = o[WHEELSET_OF][:, None], rot[WHEELSET_OF][:, None]
    with np.errstate(invalid="ignore"):
        gap, mismatch, at = gap_and_mismatch(s4, side4, o4, rot4, p, newton=2)
    u = side4 * at["y_b"] - p.rail_origin
    inside = (u > p.rail.start - p.scan_step) & (u < p.rail.end + p.scan_step) & (gap < 3e-4)
    bracket = inside[:, :-1] & inside[:, 1:] & (mismatch[:, :-1] >= 0) & (mismatch[:, 1:] < 0)
    wheel, k = np.nonzero(bracket)
    o_w, rot_w, side = o[WHEELSET_OF[wheel]], rot[WHEELSET_OF[wheel]], SIDE[wheel]
    # regula falsi, Illinois variant, on all brackets at once
    lo, hi = s[k], s[k + 1]
    f_lo, f_hi = mismatch[wheel, k], mismatch[wheel, k + 1]
    was_up = was_down = np.zeros(wheel.size, dtype=bool)
    x = lo
    for _ in range(50):
        x_last, x = x, lo - f_lo * (hi - lo) / (f_hi - f_lo)
        gap, f, at = gap_and_mismatch(x, side, o_w, rot_w, p)
        if np.all((np.abs(x - x_last) < 1e-13) | (f == 0)):
            break
        up = f >= 0
        f_hi = np.where(up, np.where(was_up, f_hi / 2, f_hi), f)
        f_lo = np.where(up, f, np.where(was_down, f_lo / 2, f_lo))
        lo, hi = np.where(up, x, lo), np.where(up, hi, x)
        was_up, was_down = up, ~up
    keep = gap < 0
    return wheel[keep], x[keep], gap[keep], {name: v[keep] for name, v in at.items()}


def patches(o, rot, v, omega, roller_spin, p: Parameters) -> dict[str, np.ndarray]:
    """Contact patches and their forces.

    Args:
        o, rot: as `contact_points`.
        v: velocities of the wheelset centres, shape (2, 3) [m/s].
        omega: angular velocities of the wheelsets with spin, shape (2, 3) [rad/s].
        roller_spin: of the two pairs [rad/s].

    Returns:
        One row per patch: wheel, s, gap, point (on the roller, from the middle of its axis), normal, force and moment of the
        roller on the wheel at that point, and what they follow from.
    """
    wheel, s, gap, at = contact_points(o, rot, p)
    ws = WHEELSET_OF[wheel]
    db, b = at["db"], at["b"]
    root_b = np.sqrt(1 + db * db)
    n = np.stack([at["direction"][:, 0], -db, at["direction"][:, 1]], axis=-1) / root_b[:, None]  # (6)
    point = np.stack([b * at["direction"][:, 0], at["y_b"], b * at["direction"][:, 1]], axis=-1)  # (3)
    t = cross(n, np.array([1.0, 0.0, 0.0]))
    t /= np.linalg.norm(t, axis=-1, keepdims=True)
    i = cross(t, n)

    v_wheel = v[ws] + cross(omega[ws], point - o[ws])
    omega_b = np.zeros_like(v_wheel)
    omega_b[:, 1] = roller_spin[ws]
    v_roller = cross(omega_b, point)
    v_rel = v_wheel - v_roller
    v_n = np.sum(v_rel * n, axis=-1)
    mean = 0.5 * (v_wheel + v_roller)
    speed = np.sqrt(np.sum(mean * mean, axis=-1) + p.creepage_regularisation_speed**2)

    root_r = np.sqrt(1 + at["dr"] ** 2)
    d1 = 0.5 * (1 / (at["r"] * root_r) + 1 / (b * root_b))  # (14), (15)
    d2_raw = 0.5 * (-at["ddr"] / root_r**3 - at["ddb"] / root_b**3)
    d2 = np.clip(d2_raw, d1 / 200, d1 * 200)
    log_ratio, shape, e_over_k = hertz(np.log(d1 / d2), p)
    q = (1 - p.poisson) / p.shear_modulus
    stiffness = 2 * np.pi / (3 * q) / np.sqrt(d1 + d2) * shape  # (13)
    closing = 0.5 * (np.sqrt(v_n**2 + p.damping_speed**2) - p.damping_speed - v_n)
    normal = np.maximum(stiffness * (-gap) ** 1.5 + p.normal_damping * closing, 0.0)  # (12)
    a = np.sqrt(-gap * e_over_k / (d1 + d2))  # (17)
    a_over_b = np.exp(log_ratio)
    ab = a * a / a_over_b

    c11, c22, c23, c33 = kalker(np.clip(log_ratio, np.log(0.1), np.log(10.0)), p)
    g = p.shear_modulus
    f11, f22, f23, f33 = ab * g * c11, ab * g * c22, ab**1.5 * g * c23, ab**2 * g * c33  # (22)
    eps_x = np.sum(v_rel * i, axis=-1) / speed  # (21), divided by the rolling speed
    eps_y = np.sum(v_rel * t, axis=-1) / speed
    eps_sp = np.sum((omega[ws] - omega_b) * n, axis=-1) / speed
    tx, ty, spin_moment = -f11 * eps_x, -f22 * eps_y - f23 * eps_sp, f23 * eps_y - f33 * eps_sp  # (20)
    demand, limit = np.sqrt(tx * tx + ty * ty) + 1e-10, p.friction * normal + 1e-10
    tau = demand / limit
    shrink = np.where(tau <= 3, 1 - tau / 3 + tau * tau / 27, 1 / tau)  # (23)
    tx, ty = shrink * tx, shrink * ty  # (24)

    force = normal[:, None] * n + tx[:, None] * i + ty[:, None] * t
    return {
        "wheel": wheel,
        "s": s,
        "gap": gap,
        "point": point,
        "normal": n,
        "force": force,
        "moment": spin_moment[:, None] * n,
        "n": normal,
        "tx": tx,
        "ty": ty,
        "d1": d1,
        "d2": d2_raw,
        "a": a,
        "b": a / a_over_b,
        "eps_x": eps_x,
        "eps_y": eps_y,
        "eps_sp": eps_sp,
        "shrink": shrink,
        "sliding": np.sum(v_rel * i, axis=-1),
    }


def hertz(lam, p: Parameters):
    """ln(a/b), sqrt(E)/(g K^1.5) and E/K over ln(D1/D2), each of lam's shape."""
    table = p.hertz
    k = np.clip(((lam - table.start) / table.step).astype(int), 0, len(table.coefficients) - 1)
    t = (lam - (table.start + k * table.step))[:, None]
    c = table.coefficients[k].reshape(-1, 3, 4)
    return (c[..., 0] + t * (c[..., 1] + t * (c[..., 2] + t * c[..., 3]))).T


def kalker(log_ratio, p: Parameters):
    """C11, C22, C23, C33 over ln(a/b), within the table."""
    knots, c = kalker_spline(p.poisson)
    k = np.clip(np.searchsorted(knots, log_ratio, side="right") - 1, 0, len(c) - 1)
    t = (log_ratio - knots[k])[:, None]
    c = c[k]
    return (c[..., 0] + t * (c[..., 1] + t * (c[..., 2] + t * c[..., 3]))).T
