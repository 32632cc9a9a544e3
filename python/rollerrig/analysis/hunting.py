"""Runs from a lateral disturbance at constant speed: does it decay, or end in a limit cycle?

    Case, speeds -> [run until decided] -> amplitude, frequency and growth rate over speed -> critical speed by disturbance
    run -> [lateral_rest] -> the body that moves most at the end, amplitude, frequency, growth rate -> report

The critical speed by disturbance is the lowest at which a disturbance of a given size ends in a persistent oscillation. It
depends on that size, and it can lie below the linear one.

What is left of the sideways motion is asked only where nothing but the start disturbs the vehicle: straight and smooth, without
actuators, at constant speed.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from rollerrig import _core
from rollerrig.analysis.limit_cycle import LEAST_AMPLITUDE, Decision, decide_motion
from rollerrig.analysis.mode_names import roles
from rollerrig.analysis.signals import FinalMotion, final_motion, half_waves
from rollerrig.analysis.wheel_rail_forces import curved, irregular
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.cases import at_speed, displaced
from rollerrig.common.arrays import Array
from rollerrig.config import Case
from rollerrig.results import RunInfo, variable
from rollerrig.results.dataset import add_energy_audit, run_draft
from rollerrig.simulation.run import Progress, begin, march, outcome
from rollerrig.simulation.starting_state import starting_state

NOT_DECIDED = "not_decided"  # status of a run that came to its end, but to no decision
PIECE = 2.0  # length by which a run is prolonged until it is decided [s]
EARLY_LOOKS = 12  # times within the least length at which a run ends whose amplitude has come to stay

STEP = 2e-3
"""Longest step of `exponential_adams`, at full scale [s]. A step evaluates the contacts twice, one of `rodas4` some thirty times,
most of them for its Jacobian, and through the flange root that is hardly longer: `benchmarks/hunting.py`."""

LATERAL = [name for name, _, _ in _core.body_fields].index("lateral")


@dataclass(frozen=True)
class HuntingSettings:
    """How the runs of a hunting study are done."""

    disturbance: float = 3e-3  # lateral offset of the leading wheelset at the start [m]
    # least length of each run [s], unless its amplitude has come to stay before: of shorter ones some linger beside a cycle
    # that they leave later
    duration: float = 6.0
    output_step: float = 5e-3  # interval of the samples [s]
    relative_tolerance: float = 1e-4  # of the integrator
    absolute_tolerance: float = 1e-7  # of the integrator, for displacements [m]
    longest: float = 30.0  # to which a run is prolonged while it is open whether its motion persists [s]


@dataclass(frozen=True)
class HuntingRun:
    """One run."""

    speed: float  # running speed [m/s]
    body: str  # whose lateral motion decides
    motion: xr.Dataset  # Dataset over time and body, with the run's attributes
    final: FinalMotion  # the motion at the end of the run
    decision: Decision  # whether it persists or decays

    @property
    def valid(self) -> bool:
        """Whether the run came to its end and to a decision; else it says neither that the motion persists nor that it decays."""
        return str(self.motion.attrs["status"]) == "ok"

    @property
    def persists(self) -> bool:
        """Whether the run ended in an oscillation that persists."""
        return self.valid and self.decision == "persists"

    @property
    def decays(self) -> bool:
        """Whether the disturbance had decayed or was decaying."""
        return self.valid and self.decision == "decays"


def hunting_case(case: Case, speed: float, settings: HuntingSettings) -> Case:
    """The case at one speed [m/s], disturbed and integrated as the settings say."""
    jumps = case.contact.normal.kind == "hertz"  # from one ellipse to another: no method of several steps passes that
    names = ("duration", "output_step", "relative_tolerance", "absolute_tolerance")
    changes: dict[str, object] = {f"time.{name}": getattr(settings, name) for name in names}
    changes["time.method"] = "rodas4" if jumps else "exponential_adams"
    changes["time.step"] = None if jumps else longest_step(case)
    return displaced(at_speed(case, speed), settings.disturbance).with_changes(changes)


def longest_step(case: Case) -> str:
    """STEP at the scale of the case, as configuration."""
    return f"{STEP / (case.similitude.time if case.similitude else 1.0)} s"


def observed_body(case: Case) -> str:
    """The body whose lateral motion stands for the vehicle: the first bogie frame, else the leading wheelset."""
    who = roles(case)
    return (who.frames or who.wheelsets)[0]


def hunting_run(job: tuple[Case, float, HuntingSettings], progress: Progress | None = None) -> HuntingRun:
    """One run from a disturbance at constant speed, until it is decided whether the motion persists.

    Args:
        job: case, running speed [m/s], settings.
        progress: called with the fraction done and a short text.

    Raises:
        StartError: no state was found from which the run can start.
    """
    case, speed, settings = job
    longest = max(settings.duration, settings.longest)
    model = assemble(hunting_case(case, speed, replace(settings, duration=longest)))
    simulation = _core.Simulation(model.core)
    body = model.body_index(observed := observed_body(case))
    room = math.ceil(longest / settings.output_step) + 2
    times, rows = np.empty(room), np.empty((room, simulation.width))
    begin(simulation, model, starting_state(model))
    code, filled, at = _core.status_codes["ok"], 0, 0.0
    decision: Decision = "open"

    def report(at: float, _filled: int) -> None:
        if progress is not None:
            progress(at / longest, f"{3.6 * speed:.0f} km/h, t = {at:.1f} s")  # Ctrl-C arrives here

    looks = np.linspace(0.0, settings.duration, EARLY_LOOKS + 1)[1:].tolist()
    for until in (*looks, *np.arange(settings.duration + PIECE, longest, PIECE).tolist(), longest):
        room_left = times[filled:], rows[filled:]
        code, more = march(simulation, until, *room_left, slice_length=settings.output_step, begin_at=at, report=report)
        at, filled = until, filled + more
        lateral = rows[:filled, body * len(_core.body_fields) + LATERAL]
        decision = decide_motion(times[:filled], lateral, ended=at >= longest, early=at < settings.duration)
        if code != _core.status_codes["ok"] or decision != "open" or at >= longest:
            break
    _, motion = audited(simulation, model, times[:filled], rows[:filled], code, ("lateral", "yaw"))
    time, lateral = motion["time"].to_numpy(), motion["lateral"].sel(body=observed).to_numpy()
    final = final_motion(time, lateral, PIECE / at if at > settings.duration else 1 / 3)
    if motion.attrs["status"] == "ok" and decision == "open":
        motion.attrs |= {"status": NOT_DECIDED, "status_message": not_decided(at, final.amplitude, final.rate)}
    return HuntingRun(speed, observed, motion, final, decision)


def audited(
    simulation: _core.Simulation, model: AssembledModel, times: Array, rows: Array, code: int, signals: Sequence[str]
) -> tuple[xr.Dataset, xr.Dataset]:
    """A run with its energy audit, and the signals of its moving bodies alone."""
    draft = run_draft(model, times, rows, outcome(simulation, model, code))
    add_energy_audit(draft)
    run = draft.dataset()
    return run, run[list(signals)].sel(body=RunInfo.of(run).moving).copy(deep=True)


def not_decided(time: float, amplitude: float, rate: float) -> str:
    """What an open run says: its time [s], its amplitude [m] and growth rate [1/s] at the end."""
    open_after = f"after {time:g} s it was not decided whether the motion persists"
    if math.isnan(rate):
        return f"{open_after}: too few waves to tell"
    return f"{open_after}: an amplitude of {1e3 * amplitude:.3g} mm that changes by {100.0 * rate:+.2g} %/s"


DECAY_SHARE = 0.1
"""Half-waves of a decaying oscillation count for its frequency down to this share of the largest one [1]."""


def decay_frequency(run: HuntingRun) -> float:
    """Frequency of an oscillation while it decays [Hz]; NaN if it does not, or within less than two half-waves."""
    if not run.decays:
        return math.nan
    time, lateral = run.motion["time"].to_numpy(), run.motion["lateral"].sel(body=run.body).to_numpy()
    waves = half_waves(time, lateral, LEAST_AMPLITUDE)
    if len(waves.amplitude) < 2:
        return math.nan
    small = np.flatnonzero(waves.amplitude < DECAY_SHARE * waves.amplitude.max())
    counted = waves.duration[: small[0] if small.size else None]
    return 0.5 * len(counted) / float(counted.sum()) if len(counted) >= 2 else math.nan


def hunting_table(runs: Sequence[HuntingRun], disturbance: float) -> xr.Dataset:
    """Runs as a Dataset over speed: amplitude, frequency, growth rate at the end; whether it persists or decays.

    A run that did not come to its end or to a decision does neither; amplitude, frequency and growth rate are NaN.
    """
    ordered = sorted(runs, key=lambda run: run.speed)
    unknown, body = FinalMotion(math.nan, math.nan, math.nan), ordered[0].body if ordered else ""
    ended = [run.final if run.valid else unknown for run in ordered]
    columns: dict[str, tuple[list[float], str, str]] = {
        "amplitude": ([one.amplitude for one in ended], "m", f"lateral amplitude of {body} at the end"),
        "oscillation_frequency": ([one.frequency for one in ended], "Hz", "frequency at the end"),
        "decay_frequency": ([decay_frequency(run) for run in ordered], "Hz", "frequency while it decays"),
        "rate_at_end": ([one.rate for one in ended], "1/s", "growth rate at the end"),
        "persists": ([run.persists for run in ordered], "1", "1: the run ends in an oscillation that persists"),
        "decays": ([run.decays for run in ordered], "1", "1: the oscillation decays; neither: the run was not decided"),
    }
    variables = {
        name: variable("speed", np.array(values, dtype=np.int8 if name in ("persists", "decays") else float), *said)
        for name, (values, *said) in columns.items()
    }
    speeds = variable("speed", np.array([3.6 * run.speed for run in ordered]), "km/h", "running speed")
    return xr.Dataset(variables, {"speed": speeds}, {"disturbance_mm": 1e3 * disturbance, "body": body})


CONSTANT = 0.01  # share of the speed: a run whose speed varies by less is one at constant speed [1]


@dataclass(frozen=True)
class LateralRest:
    """Sideways motion in the last third of a run."""

    body: str  # that moves most there
    largest: float  # distance from its place in the whole run, either side [m]
    final: FinalMotion  # what is left of its motion [m]
    decision: Decision  # whether it persists or decays; 'open' where the run is too short to tell


def lateral_rest(run: xr.Dataset) -> LateralRest | None:
    """What is left of the sideways motion of a run; None where that is not to be said.

    It did not come to its end, something else than the start disturbs the vehicle, it was at rest all the time, or it ended
    within two half-waves or a turn of the wheels.
    """
    info, speed = RunInfo.of(run), run["speed"].to_numpy()
    if run.attrs["status"] != "ok" or len(speed) < 4 or info.actuators or curved(run) or irregular(run):
        return None
    if float(np.ptp(speed)) > CONSTANT * float(np.abs(speed).max()):
        return None
    if float(np.ptp(run["distance"].to_numpy())) < 2.0 * math.pi * info.wheel_radius:
        return None
    bodies = info.moving
    lateral = run["lateral"].sel(body=bodies).transpose("body", "time").to_numpy()
    time = run["time"].to_numpy()
    tail = lateral[:, time >= time[-1] - (time[-1] - time[0]) / 3]
    ranges, largest = 0.5 * np.ptp(tail, axis=1), np.abs(lateral).max(axis=1)
    at = int(ranges.argmax() if ranges.max() >= LEAST_AMPLITUDE else largest.argmax())
    final = final_motion(time, lateral[at])
    if largest[at] < LEAST_AMPLITUDE or (ranges[at] >= LEAST_AMPLITUDE and final.amplitude == 0.0):
        return None
    return LateralRest(bodies[at], float(largest[at]), final, decide_motion(time, lateral[at], ended=True))
