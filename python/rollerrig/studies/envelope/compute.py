"""The map: runs over torque, adhesion and load, refined where regions meet, and the closed forms beside them.

Plan -> [runs, each kept on disk as soon as it is done] -> Dataset over load, adhesion and torque
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from rollerrig import __version__
from rollerrig.analysis.parallel import run_jobs
from rollerrig.assembly import assemble
from rollerrig.bench.virtual_train import load_transfer
from rollerrig.config import Case
from rollerrig.results import output_folder
from rollerrig.simulation import simulate
from rollerrig.starting_state import StartError
from rollerrig.studies.envelope.judge import REGIONS, Record, failed, judge
from rollerrig.studies.envelope.lines import held_slip, rig_numbers
from rollerrig.studies.envelope.plan import Plan, Point, make_plan, point_case, vehicle_torque
from rollerrig.studies.envelope.store import Store
from rollerrig.studies.envelope.virtual_rail import Patch, adhesion_at, creep_peak, grip_slip, patch_of

Progress = Callable[[float, str], None]

NUMBERS = {
    "tracking_rms": ("1", "wheel less virtual wheel over train speed, RMS over time and axles"),
    "tracking_largest": ("1", "the same, largest"),
    "slip_largest": ("1", "largest slip of a virtual wheel"),
    "friction_used": ("1", "creep force over friction times normal force between wheel and roller, largest"),
    "real_sliding_mps": ("m/s", "wheel surface speed less that of the roller, largest"),
    "roller_torque_nm": ("N m", "largest torque of a roller's drive"),
    "roller_power_w": ("W", "largest power of a roller's drive"),
}
"""Number of a run -> unit and meaning."""

LINES = {
    "line_grip": "the wheel on the degraded rail begins to slide, (V2)",
    "line_contact": "a wheel that grips on the rail slides on its roller, (V3)",
    "line_drive_grip": "the roller's drive carries no more of the rail's force, (V4)",
    "line_drive_slide": "the roller's drive follows no further into the slide, (V5)",
    "line_drive_recovery": "torque that must be left for the roller's drive to follow out of the slide, (V6)",
    "line_vehicle": "largest torque of the vehicle's own brake or motor",
}
"""Closed form -> meaning; magnitudes [N m]."""


def envelope(
    case: Case,
    *,
    torques: Sequence[float] | None = None,
    adhesions: Sequence[float] | None = None,
    loads: Sequence[float] | None = None,
    duration: float = 3.0,
    refine: int = 1,
    folder: str | Path | None = None,
    processes: int = 1,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Where a rig can reproduce a degraded rail: regions over axle torque, adhesion and axle load.

    Args:
        case: of a rig with [rig_control]; its speed, controllers, drives and rollers are those of every run.
        torques: on each axle, ascending, negative brakes [N m]; by default to beyond what dry rollers carry.
        adhesions: of the virtual rail at no slip, ascending [-].
        loads: axle loads over the case's own [-].
        duration: of each run [s].
        refine: how many times cells between different regions are halved.
        folder: where finished runs are kept and looked for; None: nowhere.
        processes: runs at a time.
        progress: called with the fraction done and a short text.

    Returns:
        Dataset over `load`, `adhesion`, `torque`: `region` ("" where refining saw no need for a run), the numbers of NUMBERS,
        the limits met as words, and the closed forms of LINES. Attribute `interrupted` says whether Ctrl-C left some undone.

    Raises:
        ConfigError: the case reproduces nothing, a range is unusable, or `folder` has the runs of another case.

    Example:
        >>> from rollerrig import envelope, load_case
        >>> case = load_case("adhesion_brake")
        >>> map = envelope(case, torques=[-4e3, -2e3], adhesions=[0.05, 0.3], loads=[1.0], duration=1.0, refine=0)
        >>> [str(region) for region in map["region"].sel(load=1.0, torque=-4e3)]
        ['slide', 'grip']
    """
    plan = make_plan(case, torques=torques, adhesions=adhesions, loads=loads, duration=duration, refine=refine)
    return run_plan(plan, folder=folder, processes=processes, progress=progress)


def run_plan(
    plan: Plan, *, folder: str | Path | None = None, processes: int = 1, progress: Progress | None = None
) -> xr.Dataset:
    """The map of a plan; see `envelope`."""
    report: Progress = progress or (lambda _fraction, _text: None)
    store = None if folder is None else Store(output_folder(folder), plan)
    done: dict[Point, Record] = {} if store is None else store.done
    kept = len(done)
    interrupted = False
    on_track = _OnTracks(plan)
    with store or nullcontext():
        for stride in (2**level for level in range(plan.refine, -1, -1)):
            wanted = [point for point in _points_at(plan, done, stride) if point not in done]
            if not wanted:
                continue
            begin, end = _share(plan.refine, stride)
            before = len(done)

            def keep(number: int, record: Record, wanted: list[Point] = wanted) -> None:
                if store is None:
                    done[wanted[number]] = record
                else:
                    store.add(wanted[number], record)

            def shown(
                fraction: float, _text: str, first: int = before, count: int = len(wanted), span: Any = (begin, end)
            ) -> None:
                report(span[0] + (span[1] - span[0]) * fraction, f"{len(done) - first} of {count} runs")

            jobs = [(plan, point, on_track[point.load, point.torque < 0.0]) for point in wanted]
            finished = run_jobs(_run_point, jobs, processes=processes, progress=shown, keep=keep)
            if finished.interrupted:
                interrupted = True
                break
    return _dataset(plan, done, interrupted, kept)


def _share(refine: int, stride: int) -> tuple[float, float]:
    """Part of the bar for a round: how much refining will ask for is not known, so it gets half of what is left."""
    level = refine - stride.bit_length() + 1
    end = 1.0 if stride == 1 else 1.0 - 0.5 ** (level + 1)
    return 1.0 - 0.5**level, end


@dataclass(frozen=True)
class _OnTrack:
    """What the virtual train takes from the vehicle on track: the same for all runs of a load; None: not to be had."""

    load_transfer: tuple[float, ...] | None = None
    patch: Patch | None = None


class _OnTracks(dict[tuple[float, bool], _OnTrack]):
    """By load and whether the train brakes; found when first asked for."""

    def __init__(self, plan: Plan) -> None:
        super().__init__()
        self._plan = plan

    def __missing__(self, key: tuple[float, bool]) -> _OnTrack:
        load, brakes = key
        model = assemble(point_case(self._plan, Point(load, -1.0 if brakes else 1.0, self._plan.adhesions[0])))
        try:
            self[key] = _OnTrack(tuple(load_transfer(model)), patch_of(model))
        except StartError:  # the runs themselves will say so
            self[key] = _OnTrack()
        return self[key]


def _run_point(job: tuple[Plan, Point, _OnTrack], progress: Progress) -> Record:
    plan, point, known = job
    begun = time.process_time()
    case = point_case(plan, point)
    if known.load_transfer is not None and case.rig_control is not None:
        control = case.rig_control.model_copy(update={"load_transfer": known.load_transfer})
        case = case.model_copy(update={"rig_control": control})
    try:
        run = simulate(case, progress=progress)
    except StartError as error:
        return failed("no_start", str(error))
    if run.attrs["status"] == "interrupted":
        raise KeyboardInterrupt
    assert known.patch is not None  # or the run would not have started
    record = judge(run, case, point.torque, grip_slip(case, known.patch, point.adhesion))
    record["processor_seconds"] = round(time.process_time() - begun, 4)
    return record


def _points_at(plan: Plan, done: dict[Point, Record], stride: int) -> Iterable[Point]:
    """The first grid, or what halving the cells of twice this stride adds where their corners differ."""
    torques, adhesions = plan.lattice
    if stride == 2**plan.refine:
        return itertools.starmap(Point, itertools.product(plan.loads, torques[::stride], adhesions[::stride]))
    found: dict[Point, None] = {}
    whole = 2 * stride
    for load, i, j in itertools.product(
        plan.loads, range(0, len(torques) - 1, whole), range(0, len(adhesions) - 1, whole)
    ):
        corners = [done.get(Point(load, torques[a], adhesions[b])) for a in (i, i + whole) for b in (j, j + whole)]
        if any(corner is None for corner in corners) or len({c["region"] for c in corners if c is not None}) == 1:
            continue
        for a, b in itertools.product((i, i + stride, i + whole), (j, j + stride, j + whole)):
            found[Point(load, torques[a], adhesions[b])] = None
    return found


# ------------------------------------------------------------------------------------------------------ the Dataset


def _dataset(plan: Plan, done: dict[Point, Record], interrupted: bool, kept: int) -> xr.Dataset:
    torques, adhesions = plan.lattice
    shape = (len(plan.loads), len(adhesions), len(torques))
    dims = ("load", "adhesion", "torque")
    words = {name: np.full(shape, "", dtype=object) for name in ("region", "limits", "status")}
    numbers = {name: np.full(shape, np.nan) for name in NUMBERS}
    here = []
    for place in np.ndindex(*shape):
        record = done.get(Point(plan.loads[place[0]], torques[place[2]], adhesions[place[1]]))
        if record is None:
            continue
        here.append(record)
        words["region"][place] = record["region"]
        words["limits"][place] = ", ".join(f"{name} {since:.3g} s" for name, since in record["limits"].items())
        words["status"][place] = record["status"]
        for name, values in numbers.items():
            values[place] = np.nan if record[name] is None else record[name]
    variables: dict[str, Any] = {
        "region": (
            dims,
            words["region"].astype(str),
            {"long_name": "; ".join(f"{k}: {v}" for k, v in REGIONS.items())},
        ),
        "limits": (dims, words["limits"].astype(str), {"long_name": "limits met and when, the first one first"}),
        "status": (dims, words["status"].astype(str), {"long_name": "how the run ended"}),
    }
    for name, (unit, meaning) in NUMBERS.items():
        variables[name] = (dims, numbers[name], {"units": unit, "long_name": meaning})
    coordinates = {
        "load": ("load", list(plan.loads), {"units": "1", "long_name": "axle load over the case's own"}),
        "adhesion": ("adhesion", list(adhesions), {"units": "1", "long_name": "of the virtual rail at no slip"}),
        "torque": ("torque", list(torques), {"units": "N m", "long_name": "on each axle, negative brakes"}),
    }
    attributes = {
        "title": f"Where {plan.case.name} can reproduce a degraded rail",
        "case": plan.case.name,
        "config_toml": plan.case.to_toml(),
        "speed_kmh": 3.6 * plan.case.motion.speed,
        "duration_s": plan.duration,
        "refine": plan.refine,
        "runs": len(here),
        "runs_from_before": min(kept, len(here)),
        "processor_seconds": round(sum(record.get("processor_seconds", 0.0) for record in here), 2),
        "interrupted": int(interrupted),
        "rollerrig_version": __version__,
    }
    return _with_lines(xr.Dataset(variables, coordinates, attributes), plan)


def _with_lines(found: xr.Dataset, plan: Plan) -> xr.Dataset:
    """The map with its closed forms over `side` (brake, traction), load and adhesion."""
    adhesions = found["adhesion"].to_numpy()
    fine = np.linspace(adhesions[0], adhesions[-1], 91)
    sides = [side for side, there in (("brake", plan.torques[0] < 0), ("traction", plan.torques[-1] > 0)) if there]
    lines = {name: np.full((len(sides), len(plan.loads), len(fine)), np.nan) for name in LINES}
    loads_n, slippery = np.zeros(len(plan.loads)), np.zeros((len(sides), len(plan.loads)))
    for k, load in enumerate(plan.loads):
        for s, side in enumerate(sides):
            case = point_case(plan, Point(load, -1.0 if side == "brake" else 1.0, float(adhesions[0])))
            forms = closed_forms(case, fine)
            loads_n[k], slippery[s, k] = forms["axle_load"], forms["contact_adhesion"]
            for name in forms.keys() & lines.keys():
                lines[name][s, k] = forms[name]
            own = vehicle_torque(plan.case, side == "brake")
            lines["line_vehicle"][s, k] = np.nan if own is None else own
    variables: dict[str, Any] = {
        name: (("side", "load", "line_adhesion"), values, {"units": "N m", "long_name": LINES[name]})
        for name, values in lines.items()
    }
    variables["contact_adhesion"] = (
        ("side", "load"),
        slippery,
        {"units": "1", "long_name": "on rails with more than that a sliding wheel slides on its roller, (V3)"},
    )
    variables["axle_load"] = ("load", loads_n, {"units": "N", "long_name": "mean static load of an axle"})
    along = ("line_adhesion", fine, {"units": "1", "long_name": "adhesion along the closed forms"})
    return found.assign(variables).assign_coords(side=("side", sides), line_adhesion=along)


def closed_forms(case: Case, adhesion: np.ndarray[Any, np.dtype[np.float64]]) -> dict[str, Any]:
    """Closed forms of LINES by name where each of them applies, NaN elsewhere [N m], and `contact_adhesion` [-].

    Args:
        case: of a point with the load; brakes if it has [brake], otherwise pulls: sets the slip of a slide.
        adhesion: of the rail at no slip, ascending.
    """
    rig, patch = rig_numbers(case), patch_of(assemble(case))
    peak = np.array([creep_peak(case, patch, float(mu))[1] for mu in adhesion])
    grip, slide = rig.grip(peak), rig.drive_slide(adhesion_at(case, adhesion, held_slip(case)))
    recovery = rig.drive_recovery(peak)  # at the end of it, where adhesion is back
    contact, drive = rig.contact(), rig.drive_grip()
    return {
        "axle_load": rig.axle_load,
        "contact_adhesion": float(np.interp(rig.contact_adhesion(), peak, adhesion, right=np.nan)),
        "line_grip": grip,
        "line_contact": np.where(contact <= grip, contact, np.nan),
        "line_drive_grip": np.where(drive <= grip, drive, np.nan),
        "line_drive_slide": np.where(slide >= grip, slide, np.nan),
        "line_drive_recovery": np.where((recovery > 0.0) & (recovery < grip), recovery, np.nan),
    }
