"""The same test on a full-scale rig and on its scaled model, mapped back, and the effect of each violated similitude.

Full-scale case, its model -> [ModelStudy] -> case.toml, requirements of similitude
                          -> [ScaleStudy] -> both runs at full scale, runs with one violation each, linear critical speeds

Beside the model as it is, the model is run with everything scaled, and with one violation at a time: the error budget of the
difference. The ideal model is full scale again but for round-off; once a slide protection switches valves, round-off decides
some of the switchings, and what the ideal model differs by is the repeatability of the test.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import xarray as xr

from rollerrig import similitude
from rollerrig.analysis import scaled_model
from rollerrig.analysis.slide_statistics import wheel_radius
from rollerrig.cases import as_case
from rollerrig.common.formatting import number, percent
from rollerrig.config import Case
from rollerrig.config.schema.case import ScaledFrom
from rollerrig.config.write.toml import to_short_toml
from rollerrig.plot.adhesion import Signal, axles_over_time, leading_axle, per_axle
from rollerrig.results import COMPLETED
from rollerrig.similitude import Requirement, Similitude, factors_of
from rollerrig.simulation.run import simulate
from rollerrig.study.frame import Outcome, Study
from rollerrig.study.jobs import Done, Progress, Round, job
from rollerrig.study.options import Option, Processes, command
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Picture, Section, Table


def deviation(value: float) -> str:
    """A deviation with its sign; what full scale does not have is new."""
    return percent(value, 3, signed=True) if math.isfinite(value) else "new"


LABELS = {
    "full": "full scale",
    "model": "the model as it is",
    "ideal": "ideal: everything scaled",
    "gravity": "gravity alone not scaled",
    "material": "material alone not scaled",
    "clock": "controllers' clock alone not scaled",
    "drives": "bandwidth of the drives alone not scaled",
    "own": "the model's own actuators alone",
}

LEFT_OUT = (
    "The suspension of the model is built to scale: elements, bearings and play of a real model have friction and tolerances of "
    "their own. Where the weight is to be right although gravity is not scaled, a model needs vertical forces beside its own "
    "weight; leave `gravity` out of --keep for such a one. What is computed beside the model, virtual train and rail, pneumatic "
    "brake, slide protection, runs at the model's time."
)
CASE_FILE = "case.toml"  # the scaled rig, to be run like any other
MICROMETRE = 1e-6  # lateral motion below it is round-off [m]


@dataclass(frozen=True)
class Scaled:
    """Results at full scale."""

    full: xr.Dataset  # run of the full-scale case
    mapped: Mapping[str, xr.Dataset]  # runs of the models by name of LABELS, mapped back; 'model' first
    critical: Mapping[str, float]  # linear critical speed by name [m/s], mapped back; NaN: none
    violations: Sequence[Requirement]  # all requirements, met or not


@dataclass(frozen=True)
class ModelStudy(Study[Any]):
    """A full-scale case and its model, 'full' and 'model' of the variants; its results are the requirements of similitude."""

    variants: Mapping[str, Case]

    command = "scale"
    writes = (CASE_FILE, "full.nc", "model.nc")
    leaves_out = (LEFT_OUT,)

    @property
    def full(self) -> Case:
        """The full-scale case."""
        return self.variants["full"]

    @property
    def model(self) -> Case:
        """The model as it is, at its own scale."""
        return self.variants["model"]

    @property
    def record(self) -> ScaledFrom:
        """What the model's case says of its scaling."""
        assert self.model.similitude is not None
        return self.model.similitude

    @property
    def title(self) -> str:
        return f"A 1:{self.record.length:g} model of {self.full.name}"

    def cases(self) -> Mapping[str, Case]:
        return {"the model's case, at its own scale": self.model}

    def rounds(self, done: Done) -> Iterator[Round]:
        yield {self.command: job(similitude.requirements, self.full, self.model)}

    def numbers(self, results: Any) -> dict[str, Any]:
        keys = [q.name for q in self.quantities.below("violations.*")]
        return {
            "case": self.full.name,
            "model": self.model.name,
            "similitude": self.record.model_dump(exclude={"case"}),
            "violations": [
                {key: "" if key == "effect" and one.met else getattr(one, key) for key in keys} for one in results
            ],
        }

    def summary(self, results: Any, numbers: Numbers) -> list[str]:
        record, violated = self.record, [one for one in results if not one.met]
        strategy = similitude.STRATEGIES[record.strategy]
        kept = ", ".join(record.keep) or "nothing: ideal similitude"
        return [
            f"{self.model.name}: a 1:{record.length:g} model of {record.case}, {strategy.title} (keeps {strategy.keeps}); "
            f"speeds 1:{record.length / record.time:.4g}, times 1:{record.time:.4g}. Not scaled: {kept}.",
            *(f"violated: {one.name} ({deviation(one.deviation)}): {one.effect}" for one in violated),
            *(["All requirements of similitude are met."] if not violated else []),
        ]

    def files(self, results: Any, numbers: Numbers) -> Mapping[str, Any]:
        return {CASE_FILE: to_short_toml(self.model)}

    def sections(self, results: Any, numbers: Numbers) -> list[Section]:
        violations = self.quantities.table(numbers["violations"], "violations.*", "requirements, met or violated")
        factors = factors_of(self.model)
        scaled = [[name, number(factors.factor(unit)), unit] for name, unit in similitude.FACTORS]
        title = similitude.STRATEGIES[self.record.strategy].title
        scaling = Table(("quantity", "full scale over model", "unit"), scaled, title)
        return [Section("Similitude", [scaling, violations])]


@dataclass(frozen=True)
class ScaleStudy(ModelStudy):
    """The test at full scale and on models of it: by name of LABELS 'full', 'model', and those of the error budget."""

    round_ends = (0.8, 1.0)

    @property
    def title(self) -> str:
        return f"{self.full.name} at full scale, and by a 1:{self.record.length:g} model"

    def rounds(self, done: Done) -> Iterator[Round]:
        yield {LABELS[name]: job(simulate, case) for name, case in self.variants.items()}
        speed = scaled_model.linear_critical_speed_at_full_scale
        yield {_speed_of(name): job(speed, case) for name, case in self.variants.items()}

    def collect(self, done: Done) -> Scaled | None:
        runs = {name: done[LABELS[name]] for name in self.variants if LABELS[name] in done}
        if "full" not in runs or "model" not in runs:
            return None
        full = runs.pop("full")
        return Scaled(
            full,
            {name: similitude.map_back(run) for name, run in runs.items()},
            {name: done[_speed_of(name)] for name in self.variants if _speed_of(name) in done},
            similitude.requirements(self.full, self.model),
        )

    def statuses(self, results: Scaled) -> Sequence[str]:
        return [run.attrs["status"] for run in (results.full, results.mapped["model"])]

    def numbers(self, results: Scaled) -> dict[str, Any]:
        compared = {name: scaled_model.fidelity(results.full, run) for name, run in results.mapped.items()}
        for name, one in compared.items():
            one["linear_critical_speed_relative"] = scaled_model.relative(results.critical, name)
        full, model = (
            {**scaled_model.run_numbers(run), "linear_critical_speed_kmh": 3.6 * results.critical.get(name, math.nan)}
            for name, run in (("full", results.full), ("model", results.mapped["model"]))
        )
        return {
            **super().numbers(results.violations),
            "full": full,
            "model_mapped_back": model,
            "fidelity": compared.pop("model"),
            "error_budget": compared,
            "motor_limited_share": scaled_model.motor_limited(self.model, results.mapped["model"]),
        }

    def summary(self, results: Scaled, numbers: Numbers) -> list[str]:
        ended = {"full scale": results.full, "model": results.mapped["model"]}
        ideal = numbers["error_budget"].get("ideal", {})
        early = {label: run for label, run in ended.items() if run.attrs["status"] not in COMPLETED}
        found = super().summary(results.violations, numbers)
        for name, of in {"mapped back": numbers["fidelity"], "ideal, the repeatability of the test": ideal}.items():
            if said := self.quantities.said(of, "fidelity"):
                found.append(f"Model less full scale, {name}: {said}.")
        if share := numbers["motor_limited_share"]:
            found.append(f"The motors cannot exert the demanded torque in {percent(share, 3)} of the time.")
        return found + [f"{label}: {run.attrs['status_message']}" for label, run in early.items()]

    def files(self, results: Scaled, numbers: Numbers) -> Mapping[str, Any]:
        return {**super().files(results, numbers), "full.nc": results.full, "model.nc": results.mapped["model"]}

    def sections(self, results: Scaled, numbers: Numbers) -> list[Section]:
        runs = {"full scale": numbers["full"], "model, mapped back": numbers["model_mapped_back"]}
        sections = [
            *super().sections(results, numbers),
            Section("Numbers", [self.quantities.list_table(runs, "*")]),
        ]
        sections += [Section(title, [Picture(*picture)]) for title, *picture in self._pictures(results, numbers)]
        entries = {LABELS[n]: one for n, one in {"model": numbers["fidelity"], **numbers["error_budget"]}.items()}
        budget = self.quantities.table(entries, "fidelity", "against full scale", "model")
        return [*sections, Section("Error budget of the model", [budget])]

    def _pictures(self, results: Scaled, numbers: Numbers) -> list[tuple[str, str, Any, str]]:
        """Title of the section, and what a Picture takes."""
        full, pictures = results.full, list[tuple[str, str, Any, str]]()
        runs = {"model": results.mapped["model"], "full scale": full}
        styled = list(zip(runs.items(), ("-", "--"), strict=True))
        if "train_speed" in full:
            radius = wheel_radius(full)
            aligned = {LABELS[n]: scaled_model.at_times_of(full, run) for n, run in results.mapped.items()}
            wheels = [(3.6 * radius * run["axle_speed"], 0, style, f"wheel, {label}") for (label, run), style in styled]
            trains = [(3.6 * run["train_speed"], 5, style, f"train, {label}") for (label, run), style in styled]
            measured: tuple[Signal, ...] = (
                ("torque on\nthe axle [kN m]", scaled_model.axle_torque, 1e-3),
                ("contact force\non the axle [kN]", "contact_force", 1e-3),
                ("sliding of wheel\non roller [mm/s]", "real_sliding", 1e3),
            )
            away: tuple[Signal, ...] = (
                (
                    "first axle, model less\nfull scale [m/s]",
                    lambda run: run["axle_speed"] - full["axle_speed"],
                    radius,
                ),
                ("train, model less\nfull scale [m/s]", lambda run: run["train_speed"] - full["train_speed"], 1.0),
            )
            pictures += [
                ("Speeds", "speeds", per_axle("{}\nspeed [km/h]", [*wheels, *trains]),
                 "Train and wheels at full scale; the train is virtual on either rig."),
                ("Torque and contact", "torques", axles_over_time(runs, measured, 6.2),
                 "Both at full scale: what the model measures, mapped back."),
                ("Model less full scale", "differences", leading_axle(aligned, away, 4.8),
                 "At the same time: the model as it is, and with one violation each."),
            ]  # fmt: skip
        if _moves_sideways(numbers):
            moved = [(1e3 * scaled_model.wheelsets_lateral(run).rename(body="axle"), number, style, label)
                     for number, ((label, run), style) in enumerate(styled)]  # fmt: skip
            figure = per_axle("{}\nlateral [mm]", moved)
            pictures.append(("Lateral motion", "lateral", figure, "Wheelsets, positive to the left."))
        return pictures


def scale_study(
    full: Case,
    factors: Similitude,
    *,
    strategy: str,
    keep: tuple[str, ...],
    changes: Mapping[str, object] | None = None,
    error_budget: bool = True,
) -> ScaleStudy:
    """The study of a full-scale case; arguments as of `scale_case`, and whether each violation is run alone, too.

    Raises:
        ConfigError: as `scale_case`.
    """

    def model(kept: tuple[str, ...], own: Mapping[str, object] | None) -> Case:
        return similitude.scale_case(full, factors, strategy=strategy, keep=kept, changes=own)

    variants = {"full": full, "model": model(keep, changes)}
    if error_budget:
        variants["ideal"] = model((), None)
        alone = {name: model((name,), None) for name in keep}
        violated = {n: any(not one.met for one in similitude.requirements(full, case)) for n, case in alone.items()}
        variants |= {name: case for name, case in alone.items() if violated[name]}
        if changes:
            variants["own"] = model((), changes)
    return ScaleStudy(variants)


def _speed_of(name: str) -> str:
    return f"linear critical speed, {LABELS[name]}"


def _moves_sideways(numbers: Numbers) -> bool:
    return any(numbers[of]["lateral_largest_m"] > MICROMETRE for of in ("full", "model_mapped_back"))


@command
def scale(
    case: Case | str,
    strategy: Annotated[str, Option()],
    *,
    length: float | None = None,
    time: float | None = None,
    density: float | None = None,
    keep: Annotated[Sequence[str], Option(commas=True)] = ("gravity", "material"),
    changes: Annotated[Mapping[str, object] | None, Option("change")] = None,
    run: Annotated[bool, Option(default=False)] = True,
    error_budget: bool = True,
    processes: Processes = 1,
    progress: Progress | None = None,
) -> Outcome[Any]:
    """A scaled rig by similitude: its case, to be run like any other, what it violates, and the same test at both scales.

    Args:
        case: full-scale case on rollers: a name of the catalogue or a TOML file.
        strategy: 'mmu' keeps time, 'dlr' gravity, 'inrets' speed and elastic contact.
        length: length at full scale over that of the model; 5, 5, 4 by default.
        time: time at full scale over that of the model.
        density: density at full scale over that of the model.
        keep: what the model does not scale: gravity, material, clock, drives; 'none': ideal similitude.
        changes: what the model has of its own, at its own scale, by dotted key of its case.
        run: also run the test at full scale and on the model, mapped back.
        error_budget: of the runs: also the ideal model, and each violation alone.
        processes: runs at a time; more than 1 asks a script for `if __name__ == "__main__":`.
        progress: called with the fraction done and a short text.

    Returns:
        Outcome whose `study.model` is the model's case.

    Raises:
        ConfigError: the case cannot be scaled so.
        StartError: a case finds no equilibrium to start from.
    """
    full, factors = as_case(case), similitude.similitude(strategy, length, time, density)
    kept, budget = tuple(name for name in keep if name != "none"), run and error_budget
    study = scale_study(full, factors, strategy=strategy, keep=kept, changes=changes, error_budget=budget)
    return (study if run else ModelStudy(study.variants)).outcome(processes, progress)
