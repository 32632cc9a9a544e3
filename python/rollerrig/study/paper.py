"""The paper's two studies: critical speed of a bogie on rollers (figure 7) and traction (figure 8).

plan -> [PaperStudy] -> modes, ramps, runs from a disturbance, traction -> numbers, figures, checks against theory, report
"""

import itertools
import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from rollerrig.analysis.ramp import end_of_hunting
from rollerrig.analysis.signals import fit
from rollerrig.analysis.traction import asymmetry, sliding_course
from rollerrig.common.formatting import number, percent
from rollerrig.config import Case
from rollerrig.plot import amplitude_over_speed, hunting_over_time, ramp_over_speed, traction_forces, traction_sliding
from rollerrig.plot.modes import hunting_frequencies
from rollerrig.study import critical_speeds as speeds
from rollerrig.study.assessment import check_table, counts_text
from rollerrig.study.frame import Outcome, Study, dataset_rows
from rollerrig.study.jobs import Chains, Done, Progress, Round
from rollerrig.study.options import Processes, command
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import VIEW, Block, Mark, Picture, Section, Table, Text
from rollerrig.study.runs import paper as computed
from rollerrig.study.runs.paper import EXACT, FRONT, FULL, MATERIALS, NAMES, OWN, QUICK, REAR, RIG, VEHICLE, Results

TEXT = tomllib.loads(files("rollerrig.study").joinpath("paper.toml").read_text(encoding="utf-8"))
CAPTIONS: Mapping[str, str] = TEXT["captions"]  # picture -> what it shows

PAPER: str = TEXT["paper"]
CRITICAL_KMH = 100.0  # speed above which the paper's figure 7a grows [km/h]


@dataclass(frozen=True)
class PaperStudy(Study[Results]):
    """Both studies of the paper."""

    chosen: computed.PaperPlan = FULL

    command = "paper"
    writes = ("data/*.nc", "data/*.csv", VIEW)
    formats = ("svg", "png")
    round_ends = (0.07, 1.0)
    assumes = (TEXT["limitation"],)

    heading = "Malvezzi, Meli and Pugi (2010): critical speed and traction of a bogie on a roller rig"

    @property
    def mark(self) -> Mark | None:
        return self.chosen.mark

    def cases(self) -> Mapping[str, Case]:
        return {"figure 7 (steel)": computed.rig_case("steel"), "figure 8": computed.traction_case()}

    def rounds(self, done: Done) -> Iterator[Round | Chains]:
        return computed.rounds(self.chosen)

    def collect(self, done: Done) -> Results | None:
        return computed.results_of(self.chosen, done)

    def sources(self, results: Results) -> Mapping[str, str]:
        return {"paper": PAPER.replace("Pugi, Sim", "Pugi: Sim").removesuffix(".")}

    def numbers(self, results: Results) -> dict[str, Any]:
        return computed.numbers_of(results)

    def summary(self, results: Results, numbers: Numbers) -> list[str]:
        lines = [
            TEXT["contact"].format(paper=CRITICAL_KMH, material=NAMES[m], own=_speeds(results, m, OWN),
                                   exact=_speeds(results, m, EXACT))
            for m in results.modes
        ]  # fmt: skip
        by = [one for variant in (RIG, VEHICLE) for one in results.runs_of(variant).values()]
        lines += [sentence for one in by if (sentence := speeds.ended_early_sentence(one))]
        end = numbers["traction"]
        if end is not None:
            front, rear = (end[wheel]["sliding_mmps"] for wheel in (FRONT, REAR))
            lines.append(TEXT["traction_end"].format(front=front, rear=rear, speed=end["speed_kmh"]))
        return [*lines, counts_text(results.checks)] if results.checks else lines

    def files(self, results: Results, numbers: Numbers) -> Mapping[str, Any]:
        found: dict[str, Any] = {}
        for m, variants in results.modes.items():
            found |= {f"data/modes_{m}_{variant.replace(' ', '_')}.nc": modes for variant, modes in variants.items()}
        found |= {f"data/ramp_{m}.nc": ramp for m, ramp in results.ramps.items()}
        for m, one in results.runs_of(RIG).items():
            found |= {f"data/run_{m}_{3.6 * run.speed:.2f}_kmh.nc": run.motion for run in one.runs}
        for variant, name in ((RIG, "figure_7_runs"), (VEHICLE, "figure_7b_vehicle_runs")):
            for m, one in results.runs_of(variant).items():
                found[f"data/{name}_{m}.csv"] = dataset_rows(one.table, computed.RUN_COLUMNS, "speed")
        if results.modes:
            found["data/figure_7b_linear.csv"] = computed.frequency_rows(results)
        if results.traction is not None and results.theory is not None:
            found["data/traction.nc"] = results.traction
            found["data/figure_8.nc"] = results.theory
        return found

    def shown(self, results: Results) -> Mapping[str, xr.Dataset]:
        run = results.traction
        return {} if run is None else {"the bogie on free rollers under traction, figure 8": run}

    def sections(self, results: Results, numbers: Numbers) -> list[Section]:
        drawn = {name: Picture(name, figure, CAPTIONS[name]) for name, figure in _figures(results).items()}

        def pictures(*names: str) -> list[Block]:
            return [drawn[name] for name in names if name in drawn] or [Text("Not computed.")]

        ramp = self.chosen.ramps[MATERIALS[0]]
        every, rate = (round(3.6 * value, 6) for value in (ramp.perturbation_every, ramp.acceleration))
        ends = {m: 3.6 * end_of_hunting(run, "front_frame") for m, run in results.ramps.items()}
        stability: list[Block] = [
            *self._critical_table(results),
            Text(TEXT["hysteresis"]),
            Text(TEXT["ramp"].format(every=every, perturbation=1e3 * ramp.perturbation, rate=rate)),
            *(Text(TEXT["ramp_end"].format(NAMES[m], end)) for m, end in ends.items() if math.isfinite(end)),
            *pictures("figure_7a_ramp"),
            Text(TEXT["constant_speed"]),
            *pictures("figure_7a_time_steel", "figure_7a_time_paper", "figure_7a_amplitude"),
            Text(TEXT["frequencies"]),
            *pictures("figure_7b_steel", "figure_7b_paper"),
        ]
        rig: list[Block] = [
            *(speeds.radius_table(one, TEXT["radii"].format(NAMES[m])) for m, one in results.over_radius.items()),
            *(speeds.effects_table(one, TEXT["effects"].format(NAMES[m])) for m, one in results.effects.items()),
        ]
        if results.contact:
            entries = {NAMES[m]: numbers["materials"][m]["contact"] for m in results.contact if m in results.modes}
            stability.append(self.quantities.table(entries, "materials.*.contact", TEXT["steady"], "material"))
        checks: list[Block] = [Text(counts_text(results.checks)), check_table(results.checks)]
        return [
            self._compared(results, numbers),
            Section("Figure 7: stability", stability),
            Section("What the rig changes", rig or [Text("Not computed.")]),
            Section("Figure 8: traction", [Text(TEXT["traction"]), *pictures("figure_8a", "figure_8b")]),
            Section("Checks", checks if results.checks else [Text("No checks.")]),
        ]

    def _compared(self, results: Results, numbers: Numbers) -> Section:
        """What the paper says, what is found here, and why they differ."""
        rows: list[Row] = []
        for m in results.modes:
            title = f"critical speed on the rig, {NAMES[m]} (figure 7a)"
            found = f"paper's contact: {_speeds(results, m, OWN)}; exact one: {_speeds(results, m, EXACT)}"
            rows.append((title, f"{CRITICAL_KMH:g} km/h", found, TEXT["nameless"]))
        rows += [*_rig_and_rails(results), *_figure_8_rows(results)]
        header = ("of", "paper", "here", "why they differ")
        table = Table(header, rows, "Statements of the paper beside what is computed here; nothing was tuned.")
        blocks: list[Block] = [table, Text(TEXT["not_read"])] if rows else [Text("Not computed.")]
        return Section("The paper and this computation", [Text(f"The paper: {PAPER}"), *blocks])

    def _critical_table(self, results: Results) -> list[Block]:
        """Critical speeds with the paper's own contact and with the exact one; nothing where none was computed."""
        called = {OWN: "the paper's: hertz, kalker saturated", EXACT: "exact: strips, table"}
        rows = []
        for m, variant, contact in itertools.product(results.modes, computed.VARIANTS, called):
            if (place := (contact, m, variant)) in results.linear:
                value, frequency = results.linear[place]
                shown = f"{number(frequency, 3)} Hz" if math.isfinite(frequency) else ""
                by = results.by_disturbance(m, variant, contact).text("km/h", 1) if place in results.runs else ""
                linear = f"{value:z.1f} km/h" if math.isfinite(value) else "none in the range"
                rows.append((NAMES[m], variant, called[contact], linear, shown, by))
        header = ("material", "vehicle and support", "contact", "linear critical speed", "its frequency",
                  "by disturbance: decays … persists")  # fmt: skip
        caption = TEXT["side_by_side"].format(offset=1e3 * self.chosen.hunting.disturbance)
        return [Table(header, rows, caption)] if rows else []


LABELS = {"steel": "Steel", "paper": "Paper's material, G = 10 GPa"}


def _figures(results: Results) -> dict[str, Figure]:
    """All figures for which something was computed, by name."""
    found: dict[str, Figure] = {}
    body, stated = "front_frame", {"the paper": CRITICAL_KMH}  # the one number that the paper states of its figure 7
    runs = results.runs_of(RIG)
    if results.ramps:
        lines: dict[str, dict[str, float | tuple[float, float]]] = {}
        for m in results.ramps:
            by = results.by_disturbance(m)
            lines[LABELS[m]] = {**stated, "linear": results.linear_kmh(m), "by disturbance": (by.low, by.high)}
        found["figure_7a_ramp"] = ramp_over_speed({LABELS[m]: ramp for m, ramp in results.ramps.items()}, body, lines)
    for m, one in runs.items():
        chosen = [(3.6 * run.speed, run.motion) for run in computed.around_onset(one.runs, one.persists)]
        found[f"figure_7a_time_{m}"] = hunting_over_time(chosen, body, LABELS[m])
    if runs:
        tables = {LABELS[m]: one.table for m, one in runs.items()}
        tables |= {f"{LABELS[m]}, exact contact": one.table for m, one in results.runs_of(RIG, EXACT).items()}
        critical = {**stated, **{f"linear, {m}": results.linear_kmh(m) for m in runs}}
        found["figure_7a_amplitude"] = amplitude_over_speed(tables, critical)
    for m, modes in results.modes.items():
        points = {v: results.runs_of(v)[m].table for v in (RIG, VEHICLE) if m in results.runs_of(v)}
        found[f"figure_7b_{m}"] = hunting_frequencies(modes, points, LABELS[m])
    if results.theory is not None:
        wheels = {FRONT: "front right wheel", REAR: "rear right wheel"}
        found["figure_8a"] = traction_sliding(results.theory, wheels)
        found["figure_8b"] = traction_forces(results.theory, wheels)
    return found


Row = Sequence[str]


def _speeds(results: Results, material: str, contact: str) -> str:
    """The critical speed on the rig by both definitions."""
    linear, by = results.linear_kmh(material, RIG, contact), results.by_disturbance(material, RIG, contact)
    small = f"{linear:z.1f} km/h" if math.isfinite(linear) else "none in the range"
    return f"{small} for small motions and {by.text('km/h', 1) if by.known else 'not computed'} from the offset"


def _rig_and_rails(results: Results) -> Iterator[Row]:
    """Figure 7b: bogie on the rig against the whole vehicle on the rails."""
    for m in MATERIALS:
        if apart := results.frequency_differences(m):
            what = f"frequency of hunting, rig against rails, {NAMES[m]} (figure 7b)"
            yield what, "similar", f"differs by {100 * min(apart):+z.0f} to {100 * max(apart):+z.0f} %", TEXT["short"]
        rig, rails = results.by_disturbance(m), results.by_disturbance(m, VEHICLE)
        if rig.known and rails.known:
            here = f"{rig.text('km/h')} on the rig, {rails.text('km/h')} on the rails"
            yield f"critical speed, rig against rails, {NAMES[m]}", "similar", here, TEXT["short"]


def _figure_8_rows(results: Results) -> Iterator[Row]:
    """Figure 8: sliding and forces of the right wheels."""
    run, study = results.traction, results.theory
    if run is None or study is None:
        return
    wheels = [study.sel(wheel=wheel) for wheel in (FRONT, REAR)]
    first, last = ([1e3 * float(own["sliding"].isel(time=k)) for own in wheels] for k in (0, -1))
    curved, straight = (percent(max(sliding_course(own)[k].largest for own in wheels)) for k in (1, 2))
    torque = study["torque"].to_numpy()
    off = max(fit(own["longitudinal_creep_force"].to_numpy(), torque).largest for own in wheels)
    loads = [number(1e-3 * float(own["vertical_force"].isel(time=k)), 4) for k in (0, -1) for own in wheels]
    static = "agrees but for the static loads, which differ here"
    why = "agrees: the motors' reaction turns the frame" if loads[0] == loads[1] else static
    values = {"first": first, "last": last, "curved": curved, "straight": straight, "off": percent(off), "loads": loads}
    unlike = number(asymmetry(run, "longitudinal_sliding"), 1)
    for row in TEXT["rows"].values():
        yield [cell.format(**values, why=why, unlike=unlike) for cell in row]


@command
def paper(*, quick: bool = False, processes: Processes = 1, progress: Progress | None = None) -> Outcome[Results]:
    """Reproduce the paper's two studies: figures 7 and 8, checks against theory, one report.

    Args:
        quick: few and short runs: to see that everything works.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.
    """
    return PaperStudy(QUICK if quick else FULL).outcome(processes, progress)
