"""Rolling radius difference and equivalent conicity of two profiles as EN 15302 defines them, roll neglected.

    heights of wheel and rail  ->  highest sum: first touch of each wheel  ->  difference  ->  wave of the wheelset

Separate from the simulator's way: profiles are functions that are sampled densely, not splines whose normals are matched,
and the equation of motion is integrated over the distance, not over its energy.

Frames  wheel abscissa s: 0 at the tape circle, negative towards the flange; rail abscissa u: 0 at the head's highest point,
        negative towards the gauge side. Shift of the wheelset positive to the left.
Units   mm.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

Profile = Callable[[np.ndarray], np.ndarray]
SAMPLES = np.arange(-48.0, 48.0, 0.05)


def rail_position(rail: Profile, depth: float, gauge: float = 1435.0) -> float:
    """Distance of the head's highest point from the track's middle, the gauge taken `depth` below it."""
    with np.errstate(invalid="ignore"):
        outermost = SAMPLES[np.isfinite(rail(SAMPLES))][0]
    return gauge / 2 - float(brentq(lambda u: float(rail(np.array(u))) + depth, outermost, -10.0, xtol=1e-12))


def touching_abscissa(wheel: Profile, rail: Profile, offset: float) -> float:
    """Where a wheel that is lowered straight down first touches: u = s + offset."""
    with np.errstate(invalid="ignore"):  # beyond the head's arcs
        height = wheel(SAMPLES) + rail(SAMPLES + offset)
    k = int(np.nanargmax(height))
    near = minimize_scalar(
        lambda s: -float(wheel(np.array(s)) + rail(np.array(s + offset))),
        bounds=(SAMPLES[k - 1], SAMPLES[k + 1]),
        method="bounded",
        options={"xatol": 1e-7},
    )
    return float(near.x)


def rolling_radius_difference(
    wheel: Profile, rail: Profile, lateral: np.ndarray, gauge_depth: float, tape_circle: float = 750.0
) -> np.ndarray:
    """Rolling radius left less right over the shift, both rails and both wheels alike."""
    gap = tape_circle - rail_position(rail, gauge_depth)

    def increase(shift: float) -> float:
        return float(wheel(np.array(touching_abscissa(wheel, rail, gap + shift))))

    return np.array([increase(y) - increase(-y) for y in lateral])


def equivalent_conicity(lateral: np.ndarray, difference: np.ndarray, amplitude: float) -> float:
    """tan gamma_e from the quarter wave of y'' = -difference(y), which starts at rest at the amplitude.

    The distance is counted in sqrt(e r0): tan gamma_e = 2 (pi / wave)^2 then. The wheelset is symmetric.
    """

    def crosses(_: float, state: np.ndarray) -> float:
        return float(state[0])

    crosses.terminal = True  # type: ignore[attr-defined]
    run = solve_ivp(
        lambda _, state: [state[1], -float(np.interp(state[0], lateral, difference))],
        (0.0, 1e3), [amplitude, 0.0], events=crosses, rtol=1e-9, atol=1e-12, max_step=0.02,
    )  # fmt: skip
    return float(2 * (np.pi / (4 * run.t_events[0][0])) ** 2)
