"""The limit-cycle diagram: what the vehicle ends in at each speed, as the speed is stepped up from below and down from above.

    Case, speeds -> [run until settled; its last state starts the next speed] -> amplitude over speed, hysteresis, critical speeds

On the **upward** sweep each speed starts from the steady state with a perturbation, as small as track irregularities are,
until a limit cycle is reached, from which the next run starts. On the **downward** sweep it starts from the limit cycle of the
speed above, and where that has decayed, from a large disturbance. Between the lowest limit cycle and the rest below it the
interval of speed is halved to a tolerance: this is the critical speed by continuation. Where the two sweeps differ, two
attractors exist side by side, and the size of a disturbance decides.

Equations: docs/theory/equilibrium_and_linearisation.md, section Limit cycles.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeVar

import numpy as np

from rollerrig.analysis.signals import final_motion
from rollerrig.common.arrays import Array

State = TypeVar("State")

LEAST_AMPLITUDE = 2e-5  # an oscillation below 0.02 mm is rest [m]
WAVES, POINTS = 3, 96  # waves in a window of a signal, and points at which its spline is read there
ALIKE = 0.1  # two amplitudes that differ by less than this part of the larger one are of one branch [1]


@dataclass(frozen=True)
class CyclePoint:
    """What a run at one speed ends in."""

    speed: float  # running speed [m/s]
    amplitude: float  # half the range of the lateral displacement of that wheelset which moves most [m]; 0 at rest
    peak: float = 0.0  # largest lateral displacement of any wheelset [m]; 0 at rest
    frequency: float = math.nan  # of the oscillation [Hz]; NaN at rest
    guiding_force: float = math.nan  # largest |Y| of any wheel, unfiltered [N]
    rate: float = math.nan  # growth rate of the amplitude at the end [1/s]
    duration: float = 0.0  # simulated time [s]
    # 'ok'; 'not_decided', where the amplitude had neither come to stay nor decayed before the longest time was over; or why the
    # run ended early: such a run is neither a limit cycle nor rest
    status: str = "ok"
    message: str = ""  # the same as a sentence, with time, wheel and remedy; '' if it came to its end

    @property
    def valid(self) -> bool:
        """Whether the run came to its end and to a decision."""
        return self.status == "ok"

    @property
    def persists(self) -> bool:
        """Whether the run came to its end in a limit cycle."""
        return self.valid and self.amplitude > 0.0

    @property
    def decays(self) -> bool:
        """Whether the run came to rest, or was coming to rest."""
        return self.valid and self.amplitude == 0.0


Settle = Callable[[float, State | None], tuple[CyclePoint, State | None]]
"""A run at a speed [m/s] until it has settled, from a limit cycle or, None, from the steady state, disturbed: what it ends in,
and the state there, None at rest or where the run did not come to its end. NotMadeError: it has not been made."""


class NotMadeError(Exception):
    """A run is not there, or not yet: the sweep ends before it."""


@dataclass
class Branch:
    """Points of a sweep in the order in which they were computed, those of the halving last."""

    points: list[CyclePoint] = field(default_factory=list)
    interrupted: bool = False  # whether a run that belongs to it was not made


def trace(
    settle: Settle[State], sweep: Literal["up", "down"], speeds: Sequence[float], *, tolerance: float | None = None
) -> Branch:
    """Step through speeds [m/s], given in any order, and carry the state over.

    With a tolerance [m/s], the speed at which the limit cycle ends is found to it.
    """
    branch = Branch()
    state: State | None = None
    lowest: tuple[float, State] | None = None  # the limit cycle at the lowest speed so far
    try:
        for speed in sorted(speeds, reverse=sweep == "down"):
            point, state = settle(speed, state)
            branch.points.append(point)
            if state is not None and (lowest is None or speed < lowest[0]):
                lowest = speed, state
        if tolerance is not None and lowest is not None:
            below = max((p.speed for p in branch.points if p.decays and p.speed < lowest[0]), default=math.nan)
            _halve(settle, branch, below, lowest[0], lowest[1], tolerance)
    except NotMadeError:
        branch.interrupted = True
    return branch


def _halve(settle: Settle[State], branch: Branch, low: float, high: float, state: State, tolerance: float) -> None:
    while high - low > tolerance:  # not where low is NaN: there is a limit cycle at the lowest speed
        middle = 0.5 * (low + high)
        point, found = settle(middle, state)
        branch.points.append(point)
        if point.decays:
            low = middle
            continue
        if found is None:  # the run did not come to its end: it does not say on which side the limit cycle ends
            break
        high, state = middle, found


Kind = Literal["none", "subcritical", "supercritical", "detached", "unstable throughout", "open"]

KIND_SENTENCES: dict[Kind, str] = {
    "none": "No limit cycle: every disturbance decays.",
    "subcritical": "Subcritical: limit cycles persist below the linear critical speed, where a small disturbance still decays.",
    "supercritical": "Supercritical: limit cycles begin at the linear critical speed.",
    "detached": "Limit cycles beside a steady state that is stable in the whole range: only a large disturbance leads there.",
    "unstable throughout": "Limit cycles at all speeds of the range: their beginning lies below it.",
    "open": "Where limit cycles begin is left open by runs that did not come to their end or to a decision.",
}


@dataclass(frozen=True)
class Diagram:
    """The limit-cycle diagram."""

    up: list[CyclePoint]  # points of the upward sweep, by speed
    down: list[CyclePoint]  # points of the downward sweep and of the halving, by speed
    linear: float  # linear critical speed [m/s]; NaN if there is none in the range
    tolerance: float  # of the critical speed by continuation [m/s]
    interrupted: bool = False  # whether Ctrl-C came before the end

    @property
    def lowest_cycle(self) -> float:
        """Critical speed by continuation [m/s]: the lowest with a limit cycle that persists; NaN if there is none."""
        return min((p.speed for p in [*self.down, *self.up] if p.persists), default=math.nan)

    @property
    def decays(self) -> float:
        """Highest speed below it at which everything comes to rest [m/s]; NaN if there is none."""
        return max((p.speed for p in self.down if p.decays and p.speed < self.lowest_cycle), default=math.nan)

    @property
    def ended_early(self) -> list[CyclePoint]:
        """Runs that did not come to their end: neither limit cycle nor rest."""
        return [p for p in (*self.up, *self.down) if not p.valid]

    @property
    def jumps(self) -> float:
        """Lowest speed at which the perturbation of the upward sweep grows into a limit cycle [m/s]; NaN if none does."""
        return min((p.speed for p in self.up if p.persists), default=math.nan)

    @property
    def hysteresis(self) -> tuple[float, float] | None:
        """Lowest and highest speed at which the two sweeps end differently [m/s]; None if they never do."""
        down = {p.speed: p for p in self.down}
        both = [(p, down[p.speed]) for p in self.up if p.speed in down and p.valid and down[p.speed].valid]
        apart = [one.speed for one, other in both if not _alike(one, other)]
        return (min(apart), max(apart)) if apart else None

    @property
    def kind(self) -> Kind:
        """What the amplitudes say about the bifurcation at the linear critical speed."""
        low, high = self.decays, self.lowest_cycle
        # NaN compares as false: no such limit. At the onset itself nothing ever settles: a run there leaves nothing open.
        if any(not (v < low or v > high or high - v <= self.tolerance) for v in (p.speed for p in self.ended_early)):
            return "open"
        if not math.isfinite(high):
            return "none"
        if math.isfinite(self.linear):
            return "subcritical" if high < self.linear - self.tolerance else "supercritical"
        if self.hysteresis is not None:
            return "detached"
        return "unstable throughout" if not math.isfinite(low) else "supercritical"


def _alike(one: CyclePoint, other: CyclePoint) -> bool:
    apart = abs(one.amplitude - other.amplitude) - LEAST_AMPLITUDE
    return one.persists == other.persists and apart <= ALIKE * max(one.amplitude, other.amplitude)


def diagram(up: Branch | None, down: Branch | None, linear: float, tolerance: float) -> Diagram:
    """Put the two sweeps together, with the linear critical speed (NaN: none) and the tolerance of the halving [m/s]."""
    rising, falling = (sorted(branch.points, key=lambda p: p.speed) if branch else [] for branch in (up, down))
    stopped = any(branch is None or branch.interrupted for branch in (up, down))
    return Diagram(rising, falling, linear, tolerance, stopped)


Decision = Literal["persists", "decays", "open"]

SETTLED, WINDOWS = 0.01, 3
"""Amplitudes that differ by less than this part of the largest have come to stay, in so many windows in a row."""
SETTLED_EARLY = 1e-3  # the same before a run's least length is over, when a motion may still linger beside a cycle
LEVEL = 5e-4  # fall from window to window that says nothing; larger ones that do not slow down are not those of a limit cycle
IRREGULAR, TREND = 8, 0.02  # windows in which amplitudes that scatter may have no trend above this growth rate [1/s]
FALLEN, NOT_SLOWING = 0.1, 0.9
"""Part by which amplitudes of four windows must fall to decay (of three, where there are no more), and least part of the first
fall that the last one must have."""


def decide(amplitudes: Sequence[float], window: float, *, ended: bool = False, early: bool = False) -> Decision:
    """Whether an oscillation persists or decays, by its amplitudes [m], one per window [s]: the one rule, of every study.

    It persists where its amplitudes have come to stay. It decays where they are below LEAST_AMPLITUDE and fall, or where they
    fall without slowing down: a motion that falls ever more slowly may come to a limit cycle or linger beside the place of
    one before it decays, and is open. A motion that grows is open until its time is over (`ended`), then it persists.
    Before its least length is over (`early`) a motion is open unless its amplitudes differ by SETTLED_EARLY at most.
    """
    last = np.asarray(amplitudes[-4:])
    if not len(last):
        return "open"
    if early:
        return "persists" if last[-1] >= LEAST_AMPLITUDE and _are_alike(last[-WINDOWS:], SETTLED_EARLY, 0.0) else "open"
    changes = np.diff(np.log(np.maximum(last, 1e-300)))
    if last[-1] < LEAST_AMPLITUDE:
        tiny = len(changes) > 0 and last[-1] < 0.05 * LEAST_AMPLITUDE
        falls = len(changes) > 1 and bool((changes[-2:] < 0.0).all())
        return "decays" if ended or tiny or falls or is_settled(amplitudes, window) else "open"
    if is_settled(amplitudes, window):
        return "persists"
    if len(changes) > (1 if ended else 2) and (changes < 0.0).all():
        goes_on = changes.sum() < math.log1p(-FALLEN) and changes[-1] <= NOT_SLOWING * changes[0]
        return "decays" if goes_on else "open"
    return "persists" if ended and len(changes) > 1 and (changes > 0.0).all() else "open"


def _are_alike(last: Array, part: float, level: float = LEVEL) -> bool:
    """Whether the last WINDOWS amplitudes [m] differ by this part of the largest at most, and do not linger.

    A motion lingers that falls by more than the level without slowing down, but for round-off: as beside an unstable cycle,
    which it then leaves, or in a slow decay.
    """
    if len(last) < WINDOWS or float(np.ptp(last)) > part * float(last.max()):
        return False
    falls = -np.diff(np.log(np.maximum(last, 1e-300)))
    return not ((falls > level).all() and float(falls[-1]) >= (1.0 - SETTLED) * float(falls[0]))


def is_settled(amplitudes: Sequence[float], window: float) -> bool:
    """Whether the positive amplitudes of successive windows of time [m], [s] have come to stay."""
    if _are_alike(np.asarray(amplitudes[-WINDOWS:]), SETTLED):
        return True
    many = np.asarray(amplitudes[-IRREGULAR:])
    if len(many) < IRREGULAR or not many.min() > 0.0:
        return False
    slope = float(np.polyfit(window * np.arange(len(many)), np.log(many), 1)[0])
    scatter = float(np.std(np.log(many)))
    # a trend must be small, and be lost in the scatter: else a slow growth would pass for an irregular motion
    return abs(slope) < TREND and abs(slope) * window * len(many) < scatter


def decide_motion(time: Array, signal: Array, *, ended: bool = False, early: bool = False) -> Decision:
    """The same of a lateral displacement [m] over rising times [s], in windows of WAVES waves from its end on.

    An amplitude is half the range of the signal's spline in its window.
    """
    from scipy.interpolate import CubicSpline  # slow to load, and seldom needed

    final = final_motion(time, signal)
    if early and not final.amplitude:
        return "open"
    if not final.amplitude:  # less than a wave in the last third, or nothing at all
        tail = signal[time >= time[-1] - (time[-1] - time[0]) / 3] if len(time) else signal
        return "decays" if len(tail) > 3 and 0.5 * float(np.ptp(tail)) < LEAST_AMPLITUDE else "open"
    window = WAVES / final.frequency
    count = min(int((time[-1] - time[0]) / window * (1 + 1e-9)), IRREGULAR)
    grid = np.linspace(time[-1] - count * window, time[-1], count * POINTS + 1)
    values = CubicSpline(time, signal)(grid)
    ranges = [0.5 * float(np.ptp(values[k * POINTS : (k + 1) * POINTS + 1])) for k in range(count)]
    return decide(ranges, window, ended=ended, early=early)
