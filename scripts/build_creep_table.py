"""Computes the table that the creep law `table` reads: about 15 minutes on one core, resumable.

    python scripts/build_creep_table.py [--cache build/creep_table] [--out python/rollerrig/catalog/tables/creep_table.npz]

samples of q in the unit ball, per a/b -> [RollingReference] -> forces -> [least squares] -> B-spline coefficients -> file

Equations: docs/theory/creep_laws.md, (C13)-(C15). The samples are quasi-random, so none of them is a knot of the splines.
"""

from __future__ import annotations

import argparse
import io
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import spsolve
from scipy.stats import qmc

from rollerrig import _core
from rollerrig.assembly.creep_table import checksum
from rollerrig.results import write_bytes

Array = NDArray[np.float64]

POISSON_RATIO = 0.28
LOG_ASPECT_END = float(np.log(10.0))
ASPECTS = 16
"""Intervals of ln(a/b): 17 sets of samples."""
CELLS = (8, 12, 12)
RHO_0 = 1.5
FINENESS = 0.75
"""Of the solver's grid; the fit smooths what is left of its grain."""
BATCHES = ((1400, 200, 0), (1300, 300, 50))
"""Samples inside the ball and on its surface (full sliding), and the seed, per a/b."""
SMOOTHING = 1e-4
"""Weight of squared third differences of the coefficients beside squared errors."""


def coefficients(log_aspect: float) -> tuple[float, float, float, float]:
    """Kalker's C11, C22, C23, C33."""
    return tuple(_core.kalker_coefficients(float(np.exp(log_aspect)), POISSON_RATIO))  # type: ignore[return-value]


def units(log_aspect: float) -> Array:
    """V = units * (xi, eta, chi): each unit of v demands about mu N."""
    c11, c22, c23, c33 = coefficients(log_aspect)
    friction_moment = 3 * np.pi / 16 * np.sqrt(np.cosh(log_aspect))
    return np.array([c11, c22, np.hypot(c23, c33 / friction_moment)])


def reduced_creepage(q: Array, log_aspect: float) -> Array:
    """From the ball to reduced creepages; the surface becomes 10 000 times the demand."""
    r = np.linalg.norm(q, axis=1, keepdims=True)
    return q / r * RHO_0 * r / np.maximum(1 - r, 1e-4) / units(log_aspect)


def samples(inside: int, surface: int, seed: int) -> Array:
    """Points of the quarter of the ball that mirror images leave, each near the one before."""
    q = qmc.Sobol(3, seed=seed).random(8 * inside) * [1, 2, 1] - [0, 1, 0]
    q = q[np.linalg.norm(q, axis=1) < 1][:inside]
    t = qmc.Sobol(2, seed=seed + 1).random(4 * surface)[:surface]
    height, angle = 2 * t[:, 0] - 1, t[:, 1] * np.pi / 2
    ring = np.sqrt(1 - height**2)
    q = np.concatenate([q, np.stack([ring * np.sin(angle), height, ring * np.cos(angle)], axis=1)])
    order, left = [int(np.argmax(np.linalg.norm(q, axis=1)))], set(range(len(q)))
    left.remove(order[0])
    while left:
        rest = np.fromiter(left, dtype=int)
        order.append(int(rest[np.argmin(((q[rest] - q[order[-1]]) ** 2).sum(axis=1))]))
        left.remove(order[-1])
    return q[order]


def solutions(log_aspect: float, creepage: Array, fineness: float) -> Array:
    """Forces and moment over mu N and mu N c; a case that does not converge is begun anew.

    Raises:
        RuntimeError: it does not converge then either.
    """
    ratio, result = float(np.exp(log_aspect)), np.zeros((len(creepage), 3))
    reference = _core.RollingReference(ratio, POISSON_RATIO, fineness)
    for i, row in enumerate(creepage):
        answer = reference.solve(row[None])[0]
        if not answer[5]:
            reference = _core.RollingReference(ratio, POISSON_RATIO, fineness)
            answer = reference.solve(row[None])[0]
            if not answer[5]:
                raise RuntimeError(f"no solution at a/b = {ratio:g}, reduced creepages {row}")
        result[i] = answer[:3]
    return result


def solved(cache: Path, knot: int, log_aspect: float) -> tuple[Array, Array]:
    """Reduced creepages and forces of all samples at one a/b, from the cache where they are there."""
    parts = []
    for number, (inside, surface, seed) in enumerate(BATCHES):
        file = cache / f"samples_{knot:02d}_{number}.npz"
        if not file.exists():
            creepage = reduced_creepage(samples(inside, surface, 100 * knot + seed), log_aspect)
            force = solutions(log_aspect, creepage, FINENESS)
            np.savez(file.with_suffix(".part.npz"), creepage=creepage, force=force)
            file.with_suffix(".part.npz").rename(file)
            print(f"a/b = {np.exp(log_aspect):.3g}: {len(force)} solutions", flush=True)
        with np.load(file) as data:
            parts.append((data["creepage"], data["force"]))
    return np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])


def ball(creepage: Array, log_aspect: float) -> tuple[Array, Array]:
    """Q and rho."""
    v = creepage * units(log_aspect)
    rho = np.linalg.norm(v, axis=1)
    return v / (RHO_0 + rho[:, None]), rho


def faded_linear(creepage: Array, rho: Array, log_aspect: float) -> Array:
    """L rho_0 / (rho_0 + rho)."""
    c11, c22, c23, c33 = coefficients(log_aspect)
    xi, eta, chi = creepage.T
    return (
        -np.stack([c11 * xi, c22 * eta + c23 * chi, c33 * chi - c23 * eta], axis=1) * (RHO_0 / (RHO_0 + rho))[:, None]
    )


# -------------------------------------------------------------------------------------------------- splines in the ball
SIZE = (CELLS[0] + 2, 2 * CELLS[1] + 3, CELLS[2] + 2)
"""Coefficients that mirror images leave independent: 0 .. n+1, -(n+1) .. n+1, 0 .. n+1."""


def folded(i: Array, j: Array, k: Array, component: int) -> tuple[Array, Array]:
    """Position of a coefficient among the independent ones, and the sign it is taken with; 0: its own mirror image."""
    turned = (k < 0) | ((k == 0) & (j < 0))
    odd_in_spin = np.where(turned, -1.0, np.where((j == 0) & (k == 0), 0.0, 1.0))
    sign = np.sign(i) + 0.0 if component == 0 else odd_in_spin  # force along: odd in q_1; the others: in (q_2, q_3)
    j, k = np.where(turned, -j, j), np.abs(k)
    return (np.abs(i) * SIZE[1] + j + CELLS[1] + 1) * SIZE[2] + k, sign


def splines(u: Array) -> tuple[NDArray[np.int64], Array]:
    """Number of the first of the four splines that are not zero at u, less one, and their values."""
    cell = np.floor(u).astype(int)
    t = u - cell
    return cell - 1, np.stack(
        [(1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3], axis=1
    ) / 6


def design(q: Array, component: int) -> sp.csr_matrix:
    """Value of each spline at each point."""
    (i, wi), (j, wj), (k, wk) = (splines(q[:, axis] * CELLS[axis]) for axis in range(3))
    rows, columns, values = [], [], []
    for a, b, c in np.ndindex(4, 4, 4):
        column, sign = folded(i + a, j + b, k + c, component)
        rows.append(np.arange(len(q)))
        columns.append(column)
        values.append(sign * wi[:, a] * wj[:, b] * wk[:, c])
    shape = (len(q), int(np.prod(SIZE)))
    return sp.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape)


def all_indices() -> tuple[Array, Array, Array]:
    """Of every coefficient that the core stores."""
    ranges = (np.arange(-1, CELLS[0] + 2), np.arange(-CELLS[1] - 1, CELLS[1] + 2), np.arange(-1, CELLS[2] + 2))
    i, j, k = np.meshgrid(*ranges, indexing="ij")
    return i, j, k


def third_differences(component: int) -> sp.csr_matrix:
    """Of the coefficients along each axis."""
    index = [x.ravel() for x in all_indices()]
    blocks = []
    for axis in range(3):
        inside = index[axis] + 3 <= CELLS[axis] + 1
        rows, columns, values = [], [], []
        for step, weight in enumerate((1, -3, 3, -1)):
            moved = [x[inside] + step * (n == axis) for n, x in enumerate(index)]
            column, sign = folded(*moved, component)
            rows.append(np.arange(len(column)))
            columns.append(column)
            values.append(weight * sign)
        shape = (int(inside.sum()), int(np.prod(SIZE)))
        blocks.append(
            sp.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape)
        )
    return sp.vstack(blocks)


def fitted(creepage: Array, force: Array, log_aspect: float) -> Array:
    """Coefficients of D for one a/b, shape as the core stores them without the axis of a/b."""
    q, rho = ball(creepage, log_aspect)
    rest, radius = force - faded_linear(creepage, rho, log_aspect), np.linalg.norm(q, axis=1)
    out = []
    for component in range(3):
        a = sp.diags(radius) @ design(q, component)
        p = third_differences(component)
        matrix = a.T @ a + SMOOTHING * p.T @ p + 1e-12 * sp.eye(a.shape[1])
        independent = spsolve(matrix.tocsc(), a.T @ rest[:, component])
        column, sign = folded(*all_indices(), component)
        out.append(sign * independent[column])
    return np.stack(out, axis=-1)


def along_aspect(knots: Array) -> Array:
    """Spline coefficients from values at the knots: third derivative continuous at the second and last but one knot."""
    n = len(knots)
    matrix = np.zeros((n + 2, n + 2))
    for row in range(n):
        matrix[row, row : row + 3] = (1 / 6, 4 / 6, 1 / 6)
    matrix[n, :5] = matrix[n + 1, -5:] = (1, -4, 6, -4, 1)
    values = np.concatenate([knots.reshape(n, -1), np.zeros((2, knots[0].size))])
    return np.linalg.solve(matrix, values).reshape(n + 2, *knots.shape[1:])


def main() -> None:
    """Solve, fit, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    root = Path(__file__).resolve().parents[1]
    parser.add_argument("--cache", type=Path, default=root / "build" / "creep_table", help="folder of finished samples")
    target = root / "python" / "rollerrig" / "catalog" / "tables" / "creep_table.npz"
    parser.add_argument("--out", type=Path, default=target, help="the table")
    options = parser.parse_args()
    options.cache.mkdir(parents=True, exist_ok=True)
    knots = []
    for number, log_aspect in enumerate(np.linspace(-LOG_ASPECT_END, LOG_ASPECT_END, ASPECTS + 1)):
        creepage, force = solved(options.cache, number, float(log_aspect))
        knots.append(fitted(creepage, force, float(log_aspect)))
        print(f"a/b = {np.exp(log_aspect):.3g}: fitted", flush=True)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    table = np.ascontiguousarray(along_aspect(np.array(knots)), dtype=np.float32)
    content = io.BytesIO()
    np.savez_compressed(
        content,
        log_aspect_end=np.asarray(LOG_ASPECT_END),
        rho_0=np.asarray(RHO_0),
        aspects=np.asarray(ASPECTS),
        cells=np.asarray(CELLS),
        coefficients=table,
        sha256=np.asarray(checksum(table)),
        made_with_poisson_ratio=np.asarray(POISSON_RATIO),
        made_with_fineness=np.asarray(FINENESS),
        made_with_samples=np.asarray(len(force) * (ASPECTS + 1)),
    )
    write_bytes(options.out, content.getbuffer(), force=True)
    print(f"{options.out}: {options.out.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
