"""Limit cycles: the stepping on a system whose diagram is known, then on real cases."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rollerrig.analysis.critical_speed import scan_linear
from rollerrig.analysis.hunting import HuntingSettings
from rollerrig.analysis.limit_cycle import (
    Branch,
    CyclePoint,
    NotMadeError,
    decide,
    decide_motion,
    diagram,
    is_settled,
    trace,
)
from rollerrig.analysis.limit_cycle_runs import LimitCycleSettings, limit_cycle_table
from rollerrig.config import Case, load_case
from rollerrig.study.critical_speeds import brackets, disturbance_chains
from rollerrig.study.jobs import run_rounds
from rollerrig.study.limit_cycles import continuation_sentences, critical_speed, limit_cycles

ONSET, WIDTH = 50.0, 20.0
"""Of the known system: linear critical speed and the speed that makes mu = 1 [m/s]."""


class NormalForm:
    """r' = mu r + a r^3 - r^5 with mu = (V - ONSET) / WIDTH, r in mm, time in 1/10 s: the radius of an oscillation.

    a = 1: the branch turns back and folds at mu = -1/4, r^2 = 1/2. a = -1: it begins at mu = 0 and only there.
    """

    def __init__(self, a: float, start: float) -> None:
        self.a, self.start = a, start
        self.calls = 0

    def __call__(self, speed: float, state: float | None) -> tuple[CyclePoint, float | None]:
        self.calls += 1
        mu = (speed - ONSET) / WIDTH
        r, amplitudes, time = self.start if state is None else state, [], 0.0
        while time < 40.0 and (found := decide([1e-3 * a for a in amplitudes], 1.0)) == "open":
            r = solve_ivp(lambda _t, r: 10 * r * (mu + self.a * r**2 - r**4), (0, 1), [r], rtol=1e-8, atol=1e-9).y[
                0, -1
            ]
            time += 1.0
            amplitudes.append(r)
        if found != "persists":
            status = "ok" if found == "decays" else "not_decided"
            return CyclePoint(speed, 0.0, status=status), None
        return CyclePoint(speed, 1e-3 * r, 1e-3 * r, 5.0), r

    def radius(self, speed: float) -> float:
        """Of the stable limit cycle; 0 where there is none."""
        mu = (speed - ONSET) / WIDTH
        inner = 1 + 4 * mu
        if inner < 0 or (self.a < 0 and mu <= 0):
            return 0.0
        return math.sqrt((self.a + math.sqrt(inner)) / 2)


def known(a: float, tolerance: float = 0.1):
    speeds = np.linspace(36.0, 66.0, 13)  # none at the onset itself, where nothing ever settles
    up = trace(NormalForm(a, 0.03), "up", speeds.tolist())
    down = trace(NormalForm(a, 3.0), "down", speeds.tolist(), tolerance=tolerance)
    return diagram(up, down, ONSET, tolerance), NormalForm(a, 0.0)


def test_a_fold_is_found_and_called_subcritical() -> None:
    found, exact = known(a=1.0)
    assert found.kind == "subcritical"
    fold = ONSET - WIDTH / 4
    # halved to 0.1; beside the fold the motion is slow, and 1 % per window passes for settled a little below it
    assert fold - 0.15 < found.lowest_cycle < fold + 0.1
    assert found.lowest_cycle - found.decays <= 0.1
    assert found.jumps == 51.0  # the first speed of the list at which rest is unstable
    assert found.hysteresis == (46.0, 48.5)
    for point in found.down:
        if point.speed > fold + 1.0:
            assert 1e3 * point.amplitude == pytest.approx(exact.radius(point.speed), rel=0.01)  # what "settled" allows
    assert [p.amplitude for p in found.up if p.speed < ONSET] == [0.0] * 6


def test_without_a_fold_up_and_down_are_one_and_called_supercritical() -> None:
    found, exact = known(a=-1.0)
    assert found.kind == "supercritical"
    assert found.hysteresis is None
    assert found.lowest_cycle == pytest.approx(ONSET, abs=0.3)  # near the onset decay takes longer than a run
    down = {p.speed: p for p in found.down}
    for point in found.up:
        assert point.amplitude == pytest.approx(down[point.speed].amplitude, rel=0.02)
        if point.speed > ONSET + 1.0:
            assert 1e3 * point.amplitude == pytest.approx(exact.radius(point.speed), rel=0.01)


def branch(amplitudes) -> Branch:
    return Branch([CyclePoint(10.0 * (k + 1), 1e-3 * a) for k, a in enumerate(amplitudes)])


@pytest.mark.parametrize(
    ("up", "down", "linear", "kind"),
    [
        ([0, 0, 0], [0, 0, 0], math.nan, "none"),
        ([0, 0, 3], [0, 2, 3], 25.0, "subcritical"),
        ([0, 0, 3], [0, 0, 3], 25.0, "supercritical"),
        ([0, 0, 0], [0, 2, 3], math.nan, "detached"),
        ([1, 2, 3], [1, 2, 3], math.nan, "unstable throughout"),
    ],
)
def test_kinds_of_diagram(up, down, linear: float, kind: str) -> None:
    assert diagram(branch(up), branch(down), linear, 1.0).kind == kind


def lost_at(low: float, high: float, a: float, start: float):
    """The known system, whose runs between two speeds do not come to their end."""
    form = NormalForm(a, start)

    def settle(speed: float, state: float | None) -> tuple[CyclePoint, float | None]:
        if low <= speed <= high:
            return CyclePoint(speed, math.nan, status="contact_lost", message=f"lost at {speed:g} m/s"), None
        return form(speed, state)

    return settle


def test_runs_that_ended_early_are_no_limit_cycles_and_no_rest() -> None:
    speeds = np.linspace(36.0, 66.0, 13).tolist()
    up, down = (trace(lost_at(0.0, 99.0, 1.0, 3.0), sweep, speeds, tolerance=0.1) for sweep in ("up", "down"))
    found = diagram(up, down, ONSET, 0.1)
    assert len(found.ended_early) == 26
    assert all(math.isnan(value) for value in (found.lowest_cycle, found.decays, found.jumps))
    assert found.hysteresis is None
    assert found.kind == "open"
    sentences = continuation_sentences(found)
    assert sentences[0] == "Critical speed by continuation: not found, no run was decided."
    assert sentences[1].endswith("ended so: lost at 36 m/s")
    assert "Critical speed by continuation: 129.6" not in " ".join(sentences)


def test_runs_lost_at_the_fold_leave_open_where_limit_cycles_begin() -> None:
    fold = ONSET - WIDTH / 4
    speeds = np.linspace(36.0, 66.0, 13).tolist()
    down = trace(lost_at(fold - 2.0, fold + 2.0, 1.0, 3.0), "down", speeds, tolerance=0.1)
    found = diagram(trace(NormalForm(1.0, 0.03), "up", speeds), down, ONSET, 0.1)
    assert found.kind == "open"
    assert found.decays < fold - 2.0
    assert found.lowest_cycle > fold + 2.0
    assert all(p.status == "contact_lost" for p in down.points[-1:])  # the halving ends where a run says nothing


def test_runs_lost_far_above_change_nothing_below() -> None:
    speeds = np.linspace(36.0, 66.0, 13).tolist()
    down = trace(lost_at(62.0, 99.0, 1.0, 3.0), "down", speeds, tolerance=0.1)
    found = diagram(trace(NormalForm(1.0, 0.03), "up", speeds), down, ONSET, 0.1)
    assert found.kind == "subcritical"
    assert found.lowest_cycle == pytest.approx(ONSET - WIDTH / 4, abs=0.15)
    assert len(found.ended_early) == 2


def test_a_sweep_ends_before_the_run_that_was_not_made() -> None:
    form = NormalForm(1.0, 3.0)

    def interrupted(speed: float, state: float | None) -> tuple[CyclePoint, float | None]:
        if form.calls == 2:
            raise NotMadeError
        return form(speed, state)

    found = trace(interrupted, "down", [60.0, 62.0, 64.0])
    assert found.interrupted
    assert [p.speed for p in found.points] == [64.0, 62.0]
    assert diagram(None, found, ONSET, 0.1).interrupted


def test_growth_is_not_taken_for_settled_and_scatter_is() -> None:
    time = np.arange(20.0)
    assert not is_settled(np.exp(0.03 * time), 1.0)
    assert is_settled(1 - np.exp(-2.0 * time) + 1e-9, 1.0)
    scattered = 1.0 + 0.1 * np.random.default_rng(1).standard_normal(20)
    assert is_settled(scattered, 1.0)
    assert not is_settled(scattered * np.exp(0.1 * time), 1.0)


@pytest.mark.parametrize(
    ("radius", "decision"),
    [
        (lambda t: 2.0 + 0.0 * t, "persists"),
        (lambda t: 2.0 + np.exp(-2.0 * t), "persists"),  # has come to the cycle
        (lambda t: 2.0 + np.exp(-0.3 * t), "open"),  # comes to it, ever more slowly
        (lambda t: 3.0 * np.exp(-0.5 * t), "decays"),
        (lambda t: 3.0 * np.exp(-5.0 * t), "decays"),
        (lambda t: 2.5 - 0.012 * np.exp(0.8 * t), "decays"),  # lingered beside the cycle's place, and falls ever faster
        (lambda t: 2.0 - 0.0002 * np.exp(0.8 * t), "open"),  # lingers there, within 1 %: it was taken for a limit cycle
        (lambda t: 2.0 - 0.008 * t, "open"),
        (lambda t: 2.6 - 0.1 * t, "open"),  # 6 s are not enough: it was taken for a limit cycle
        (lambda t: 0.1 * np.exp(0.2 * t), "open"),
    ],
)
def test_one_rule_says_whether_a_motion_persists(radius, decision: str) -> None:
    time = np.arange(0.0, 6.0, 5e-3)
    signal = 1e-3 * radius(time) * np.sin(2 * np.pi * 5.3 * time)
    assert decide_motion(time, signal) == decision
    at_the_end = {"open": ("open", "persists")}.get(decision, (decision,))
    assert decide_motion(time, signal, ended=True) in at_the_end


@pytest.mark.parametrize(
    ("radius", "decision"),
    [
        (lambda t: 2.0 + np.exp(-8.0 * t), "persists"),
        (lambda t: 2.0 + np.exp(-2.0 * t), "open"),  # within 1 %, and still comes nearer
        (lambda t: 2.0 - 0.0012 * np.exp(0.8 * t), "open"),  # lingers beside an unstable cycle, within 1 %
        (lambda t: 2.0 + 0.002 * t, "open"),
        (lambda t: 3.0 * np.exp(-5.0 * t), "open"),  # at rest: its time costs nothing
        (lambda t: 2.0 + 0.1 * np.sin(11.0 * t), "open"),  # irregular
    ],
)
def test_before_its_least_length_a_motion_persists_only_where_its_amplitude_stands_still(radius, decision: str) -> None:
    time = np.arange(0.0, 3.0, 5e-3)
    signal = 1e-3 * radius(time) * np.sin(2 * np.pi * 5.3 * time)
    assert decide_motion(time, signal, early=True) == decision


def test_a_motion_that_grows_persists_once_its_time_is_over() -> None:
    grows = 1e-3 * np.exp(0.2 * np.arange(6.0))
    assert (decide(grows, 1.0), decide(grows, 1.0, ended=True)) == ("open", "persists")
    assert decide(1e-2 * grows, 1.0) == "open"  # small, and not falling
    assert decide(0.5e-2 * grows[::-1], 1.0) == "decays"


@pytest.mark.parametrize("rate", np.linspace(-0.004, -0.001, 25))
def test_a_slow_decay_is_no_limit_cycle_whatever_the_round_off(rate: float) -> None:
    falls = 2e-3 * np.exp(rate * np.arange(6.0))  # within 1 %, each less than the one before by the same part
    assert decide(falls, 1.0) == decide(falls, 1.0, ended=True) == "open"


# ---------------------------------------------------------------------------------------------------- real cases

QUICK = LimitCycleSettings(tolerance_kmh=10.0)


@pytest.fixture(scope="module")
def bogie() -> Case:
    """With ellipses: between the fold and the linear critical speed lie 90 km/h, with strips hardly any."""
    paper = {"contact.normal": "hertz", "contact.creep": "kalker_saturated"}
    return load_case("bogie_rollers_constant").with_changes(paper)


@pytest.fixture(scope="module")
def found(bogie):
    return limit_cycles(bogie, [150.0, 180.0, 265.0], 253.4, QUICK, processes=1)


@pytest.mark.slow
def test_the_bogie_on_rollers_hunts_below_its_linear_critical_speed(found) -> None:
    assert found.kind == "subcritical"
    # at 1e-5, and with exponential_adams at 1e-6, it persists at 165 km/h and decays at 163; at 1e-3 it decayed at 165, too
    assert 3.6 * found.decays < 164 < 3.6 * found.lowest_cycle < 166
    assert 3.6 * found.jumps == pytest.approx(265.0)
    assert found.hysteresis == (pytest.approx(180 / 3.6), pytest.approx(180 / 3.6))


@pytest.mark.slow
def test_critical_speeds_by_the_three_definitions_are_in_order(bogie, found) -> None:
    """fold <= by disturbance <= linear, within the widths to which they were found."""
    width = QUICK.tolerance_kmh / 3.6
    runs = HuntingSettings(duration=4.0)
    chains = disturbance_chains({"": bogie}, {"": [150.0, 190.0]}, 10.0, runs)
    done, _ = run_rounds(lambda _done: iter([chains]), None, (1.0,), 1, None)
    by = brackets([""], runs, done)[""]
    linear = scan_linear(bogie, [200.0, 300.0]).onset
    assert linear is not None
    assert 0.0 < by.persists - by.decays <= 10 / 3.6
    assert found.lowest_cycle - found.decays <= width
    assert found.decays < by.persists  # no perturbation persists below the fold
    assert by.persists - found.decays < 2 * width  # 3 mm is large: near the fold it leads to the limit cycle
    assert by.persists < linear.speed - 10 * width / 3  # subcritical: the linear one lies far above


@pytest.mark.slow
def test_where_there_is_one_attractor_both_ways_end_in_it(found) -> None:
    up, down = (next(p for p in sweep if p.speed > 260 / 3.6) for sweep in (found.up, found.down))
    assert up.amplitude == pytest.approx(down.amplitude, rel=0.02)  # settled within 1 % each
    assert up.frequency == pytest.approx(down.frequency, rel=0.02)


@pytest.mark.slow
def test_the_same_diagram_twice_is_the_same_to_the_last_bit(bogie) -> None:
    short = LimitCycleSettings(longest=0.8)
    one, two = (limit_cycles(bogie, [170.0, 180.0], 253.4, short, processes=n) for n in (1, 2))
    assert limit_cycle_table(one).identical(limit_cycle_table(two))


def test_an_interrupted_diagram_has_the_runs_that_were_made() -> None:
    seen = set[str]()

    def progress(_fraction: float, text: str) -> None:
        seen.add(text)
        if len(seen) == 3:
            raise KeyboardInterrupt

    short = LimitCycleSettings(longest=1.6)
    found = limit_cycles(load_case("wheelset_rollers"), [100.0, 200.0], math.nan, short, progress=progress)
    assert found.interrupted
    assert (len(found.down), len(found.up)) == (2, 1)


def test_an_interrupted_critical_speed_is_none() -> None:
    def progress(_fraction: float, _text: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        critical_speed("wheelset_rollers", methods=("continuation",), speeds_kmh=[100.0, 200.0], progress=progress)


def test_a_stable_wheelset_has_no_limit_cycle() -> None:
    found = limit_cycles(load_case("wheelset_rollers"), [100.0, 200.0], math.nan, QUICK, processes=1)
    assert found.kind == "none"
    assert math.isnan(found.lowest_cycle)
