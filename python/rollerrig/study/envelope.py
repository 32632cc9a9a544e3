"""Operating envelope: up to which torque, on which rail and at which load the rig reproduces the track, and what limits it.

Case of a rig with [rig_control] -> runs over torque, adhesion and load, refined where regions meet -> [EnvelopeStudy]
-> map of the limits reached first, and the closed forms (V1) to (V6) beside it
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import xarray as xr

from rollerrig.analysis.envelope_borders import Border, borders, slides
from rollerrig.analysis.rig_limits import LEAST_DURATION, NUMBERS, REGIONS, REPRODUCED, TRACKING_LIMIT
from rollerrig.cases import as_case, rig_of
from rollerrig.common.formatting import number
from rollerrig.config import Case, ConfigError
from rollerrig.config.validate.check_actuators import simulated_axles
from rollerrig.plot import envelope as figures
from rollerrig.study.frame import Study, dataset_rows
from rollerrig.study.jobs import Done, Progress, Round, job
from rollerrig.study.options import Option, Processes, command
from rollerrig.study.quantities import Numbers, Quantities, Quantity
from rollerrig.study.report import Block, Picture, Section, Text
from rollerrig.study.runs import envelope as computed
from rollerrig.study.runs.envelope import BEGIN, RISE, Point


def run_rows(found: xr.Dataset) -> list[list[object]]:
    """envelope.csv: a row per run, header first."""
    same = ("adhesion", "region", "limits", "status", *NUMBERS)
    columns = {"load": "load", "axle_load_n": "axle_load", "torque_nm": "torque", **{name: name for name in same}}
    return [row for row in dataset_rows(found, columns, *computed.DIMENSIONS) if row[list(columns).index("region")]]


METHOD = (
    f"Each point is a run of the whole rig, {{duration:g}} s long, from {{speed:.4g}} km/h; its torque rises from {BEGIN:g} s to "
    f"{BEGIN + RISE:g} s. A region is named after the limit that is reached first for at least {1e3 * LEAST_DURATION:g} ms; "
    f"where none is, the tracking error decides: {100 * TRACKING_LIMIT:g} % of train speed, RMS. Colours between runs are those "
    "of the nearest one."
)
CLOSED_FORMS = (
    "Up to which torque every run reproduces the rail, and the limit of the next; then where wheels begin to slide, (V2). "
    "Closed forms are those of docs/theory/envelope.md, not fits. A border agrees if the predicted torque lies between the "
    "runs on either side, give or take one step of torque; at a border of recovery the torque left on the axles in these "
    "two runs lies above and below what (V6) asks for. All borders count."
)
LEFT_OUT = (
    "The torque comes at once, from ideal cylinders or motors: the vehicle's own would be slower and slide more gently. Runs are "
    "short: heat and wear of rollers and drives do not limit them. The rail does not change along the way."
)
QUANTITIES = Quantities(
    "envelope",
    (Quantity(f"regions.{name}", f"number of runs: {meaning}", "", meaning) for name, meaning in REGIONS.items()),
)


@dataclass(frozen=True)
class EnvelopeStudy(Study[xr.Dataset]):
    """The map of one rig; attributes as the arguments of `rollerrig.envelope`, all ranges ascending.

    Speed, controllers, drives and rollers are those of the case in every run.
    """

    case: Case
    torques: tuple[float, ...] = ()
    adhesions: tuple[float, ...] = computed.ADHESIONS
    loads: tuple[float, ...] = computed.LOADS
    duration: float = 3.0
    refine: int = 1

    command = "envelope"
    heading = "{case.name}: operating envelope of the rig"
    quantities = QUANTITIES
    writes = ("envelope.nc", "envelope.csv")
    keeps_jobs = True
    leaves_out = (LEFT_OUT,)
    irrelevant = ("description", "time.duration", "time.output_step", "torques", "adhesions", "loads", "refine")

    def __post_init__(self) -> None:
        """Fill in the torques, and refuse what cannot be run, with a ConfigError of all mistakes found."""
        rig_of(self.case)
        if others := simulated_axles(self.case, self.command):
            raise ConfigError(others)
        object.__setattr__(self, "torques", self.torques or tuple(computed.default_torques(self.case)))
        computed.check(self.case, self.torques, self.adhesions, self.loads, self.duration, self.refine)

    @cached_property
    def lattice(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Torques and adhesions with all that refining may add."""
        return computed.between(self.torques, 2**self.refine), computed.between(self.adhesions, 2**self.refine)

    def rounds(self, done: Done) -> Iterator[Round]:
        on_track: dict[tuple[float, bool], computed.OnTrack] = {}
        for stride in (2**level for level in range(self.refine, -1, -1)):
            points = [point for point in self._points_at(done, stride) if _name(point) not in done]
            for point in points:
                key = (point.load, point.torque < 0.0)
                on_track[key] = on_track.get(key) or computed.find_on_track(
                    computed.point_case(self.case, point, self.duration)
                )
            yield {
                _name(point): job(computed.run_point, computed.point_case(self.case, point, self.duration), point,
                                  on_track[point.load, point.torque < 0.0])
                for point in points
            }  # fmt: skip

    def _points_at(self, done: Done, stride: int) -> list[Point]:
        """The first grid, or what halving the cells of twice this stride adds where their corners differ."""
        torques, adhesions = self.lattice
        if stride == 2**self.refine:
            return [Point(*p) for p in itertools.product(self.loads, torques[::stride], adhesions[::stride])]
        found: dict[Point, None] = {}
        whole = 2 * stride
        cells = itertools.product(self.loads, range(0, len(torques) - 1, whole), range(0, len(adhesions) - 1, whole))
        for load, i, j in cells:
            names = [_name(Point(load, torques[a], adhesions[b])) for a in (i, i + whole) for b in (j, j + whole)]
            if any(name not in done for name in names) or len({done[name]["region"] for name in names}) == 1:
                continue
            for a, b in itertools.product((i, i + stride, i + whole), (j, j + stride, j + whole)):
                found[Point(load, torques[a], adhesions[b])] = None
        return list(found)

    def collect(self, done: Done) -> xr.Dataset | None:
        torques, adhesions = self.lattice
        points = map(Point._make, itertools.product(self.loads, torques, adhesions))
        records = {point: done[_name(point)] for point in points if _name(point) in done}
        found = computed.map_dataset(self.case, self.loads, adhesions, torques, records)
        return found.assign_attrs(duration_s=self.duration, refine=self.refine) if found.attrs["runs"] else None

    def numbers(self, results: xr.Dataset) -> dict[str, Any]:
        regions = results["region"].to_numpy()
        counts = {name: int((regions == name).sum()) for name in REGIONS}
        reach, begin = borders(results), slides(results)
        lines = results["line_vehicle"].isel(load=0, line_adhesion=0)
        own = {str(side): float(lines.sel(side=side)) for side in results["side"].to_numpy()}
        return {
            "case": self.case.name,
            "speed_kmh": results.attrs["speed_kmh"],
            "runs": results.attrs["runs"],
            "regions": counts,
            "reproduced": sum(counts[name] for name in REPRODUCED) / results.attrs["runs"],
            "vehicle_torque_nm": own,
            "vehicle_reproduced": {side: _vehicle_reproduced(results, side, torque) for side, torque in own.items()},
            "agreement": {"borders": _agreement(reach), "slides": _agreement(begin)},
            "borders": [{**vars(border), "agrees": border.agrees} for border in (*reach, *begin)],
        }

    def summary(self, results: xr.Dataset, numbers: Numbers) -> list[str]:
        counts = numbers["regions"]
        share, at = f"{100 * numbers['reproduced']:z.0f} %", f"{numbers['speed_kmh']:.4g} km/h"
        lines = [f"{numbers['runs']} runs at {at}: the rig reproduces the rail in {share} of them."]
        limits = sorted((n for n in REGIONS if counts[n] and n not in REPRODUCED), key=lambda n: -counts[n])
        if limits:
            listed = (f"{REGIONS[n]} ({counts[n]} run{'s' if counts[n] > 1 else ''})" for n in limits)
            lines.append(f"Limits reached first in the others: {'; '.join(listed)}.")
        for side, torque in numbers["vehicle_torque_nm"].items():
            if torque is not None:
                machine, most = "brake" if side == "brake" else "motor", f"{number(1e-3 * torque, 3)} kN m"
                assessment = {True: "reproduced on every rail and load", None: "below the map"}
                found = assessment.get(numbers["vehicle_reproduced"][side], "not reproduced everywhere, see the table")
                lines.append(f"Torque of the vehicle's own {machine}, up to {most} per axle: {found}.")
        names = {"borders": "borders of the limits", "slides": "borders of sliding"}
        agreement = {names[key]: one for key, one in numbers["agreement"].items() if one["of"]}
        told = [f"{one['agree']} of {one['of']} {what}" for what, one in agreement.items()]
        if told:
            lines.append(f"Closed forms and runs agree within a step of torque on {' and '.join(told)}.")
        return lines

    def files(self, results: xr.Dataset, numbers: Numbers) -> Mapping[str, Any]:
        return {"envelope.nc": results, "envelope.csv": run_rows(results)}

    def sections(self, results: xr.Dataset, numbers: Numbers) -> list[Section]:
        maps: list[Block] = [
            Picture(f"map_{load:g}", figures.region_map(results, float(load), REGIONS),
                    f"Regions at an axle load of {1e-3 * float(results['axle_load'].sel(load=load)):.4g} kN.")
            for load in results["load"].to_numpy()
        ]  # fmt: skip
        method = METHOD.format(duration=self.duration, speed=results.attrs["speed_kmh"])
        rows = [{**one, "limit": REGIONS.get(one["limit"], "the map ends")} for one in numbers["borders"]]
        return [
            Section("Map", [Text(method), *maps]),
            Section("Borders", [Text(CLOSED_FORMS), QUANTITIES.table(rows, "borders.*")]),
        ]


def _name(point: Point) -> str:
    return f"load {point.load!r}, torque {point.torque!r} N m, adhesion {point.adhesion!r}"


def _vehicle_reproduced(found: xr.Dataset, side: str, torque: float) -> bool | None:
    """Whether all runs up to the vehicle's own torque reproduce the rail; None: that torque is not known, or below the map."""
    signed = (-1.0 if side == "brake" else 1.0) * found["torque"].to_numpy()
    regions = found["region"].to_numpy()[..., (signed > 0.0) & (signed <= torque)]
    run = regions[regions != ""]
    return bool(np.isin(run, REPRODUCED).all()) if run.size else None


def _agreement(rows: Sequence[Border]) -> dict[str, int]:
    compared = [row.agrees for row in rows if row.agrees is not None]
    return {"agree": sum(compared), "of": len(compared)}


@command
def envelope(
    case: Case | str,
    *,
    torques: Annotated[Sequence[float] | None, Option("torques_knm", "kN m", ordered=True)] = None,
    adhesions: Annotated[Sequence[float] | None, Option(ordered=True)] = None,
    loads: Annotated[Sequence[float] | None, Option(ordered=True)] = None,
    speed_kmh: float | None = None,
    duration: float = 3.0,
    refine: Annotated[int, Option(least=0, most=4)] = 1,
    folder: str | Path | None = None,
    processes: Processes = 1,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Operating envelope: where the rig reproduces a degraded rail over torque, adhesion and axle load, and what limits it.

    Ctrl-C keeps all finished runs; the same command continues with the rest, and another grid takes over those it shares.

    Args:
        case: case on rollers with [rig_control]: a name of the catalogue or a TOML file.
        torques: torques on each axle, ascending, negative brakes [N m]; None: up to beyond what dry rollers carry, braking
            for a case with [brake].
        adhesions: adhesions of the reproduced rail, ascending [-]; None: 0.02 to 0.36.
        loads: axle loads over the case's own, ascending [-]; None: 0.6, 1, 1.4.
        speed_kmh: speed at the start [km/h]; the case's if absent.
        duration: length of each run [s].
        refine: how many times cells between different regions are halved.
        folder: where finished runs are kept and looked for; None: nowhere.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Returns:
        Dataset over `load`, `adhesion`, `torque`: `region` ("" where refining needed no run), the numbers of NUMBERS, the limits
        reached as text, and the closed forms of LINES. Attribute `interrupted` says whether Ctrl-C left some undone,
        `jobs_taken_over` how many were finished before.

    Raises:
        ConfigError: the case reproduces nothing, a range is unusable, or `folder` has the runs of another case.

    Example:
        >>> from rollerrig import envelope, load_case
        >>> case = load_case("adhesion_brake")
        >>> map = envelope(case, torques=[-4e3, -2e3], adhesions=[0.05, 0.3], loads=[1.0], duration=1.0, refine=0)
        >>> map["region"].sel(load=1.0, torque=-4e3).to_numpy().tolist()
        ['slide', 'grip']
    """
    whole = as_case(case)
    if speed_kmh is not None:
        whole = whole.with_changes({"motion.speed": f"{speed_kmh} km/h"})
    ranges = {"torques": torques, "adhesions": adhesions, "loads": loads}
    chosen = {name: tuple(map(float, values)) for name, values in ranges.items() if values is not None}
    outcome = EnvelopeStudy(whole, duration=duration, refine=refine, **chosen).outcome(processes, progress, folder)
    return outcome.results.assign_attrs(interrupted=int(outcome.interrupted), jobs_taken_over=outcome.taken_over)
