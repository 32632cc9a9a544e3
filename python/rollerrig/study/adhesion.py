"""The same brake or traction test on degraded track and on the dry rig that reproduces it, and why the two differ.

Case of a rig with [rig_control] -> [AdhesionStudy] -> both runs, variants of the rig, repeated tests -> error budget

Tracking compares the rig's axles with the virtual train that they follow; fidelity compares the rig with the run on real track,
which also contains what the virtual train leaves out. Equations: docs/theory/rig_control.md.

The variants take one imperfection of the rig away after the other: pure rolling of the wheels on the rollers, then drives
without lag and limit, then known force and torque. The differences between them, and what remains between the last and the
track, add up to the whole: the error budget. Repeated tests that begin some milliseconds later show how far it can be trusted.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import xarray as xr
from numpy.typing import ArrayLike

from rollerrig.analysis.rig_fidelity import axle_load, error_budget, fidelity, rig_numbers, run_numbers, variant_numbers
from rollerrig.analysis.tracking import distances, wheel_radius
from rollerrig.config import Case
from rollerrig.plot import adhesion as figures
from rollerrig.results import COMPLETED
from rollerrig.simulation import simulate
from rollerrig.study.adhesion_variants import STEPS, VARIANTS, track_case, variant, variants_of
from rollerrig.study.ensemble import scatter, starts
from rollerrig.study.frame import Study
from rollerrig.study.jobs import Done, Round, job
from rollerrig.study.quantities import Numbers, Quantities, Quantity
from rollerrig.study.report import Picture, Section
from rollerrig.wording import percent

TRACKING_TARGET, DISTANCE_TARGET = 0.01, 0.02

CONTRIBUTIONS = {
    "rolling": "sliding of the wheels on the rollers",
    "drives": "lag and torque limit of the roller drives",
    "estimator": "lag of the estimated torque",
    "model": "simplifications of the virtual train, and sampling",
}
PERCENT = ("%", 100.0)
RUN = (
    Quantity("*.status", "how the run ended: on degraded track, and on the dry rig"),
    Quantity("*.status_message", "the same as a sentence"),
    Quantity("*.stopped", "whether the train came to a stop before the end of the run"),
    Quantity("*.distance_m", "run by the train, on the rig by the virtual one", "m", "distance"),
    Quantity("*.duration_s", "time at the end of the test", "s", "duration"),
    Quantity("*.speed_end_kmh", "of the train at the end", "km/h", "speed at the end"),
    Quantity("*.largest_slip", "largest |wheel speed - train speed| over train speed, above 2 m/s", "1"),
    Quantity("*.mean_slip", "mean of the same over all axles and times", "1", shown=PERCENT, digits=2),
    Quantity("*.adhesion_used_mean", "mean of |creep force| over static axle load under brake or traction", "1"),
    Quantity("*.adhesion_used_largest", "largest of the same", "1"),
    Quantity("*.dump_cycles", "times that dump valves opened to vent, all axles", "1", "dump cycles, all axles"),
    Quantity("*.air_litres", "air at ambient pressure taken by all cylinders", "l", "air taken by the cylinders"),
    Quantity("*.energy_relative_residual", "energy audit", "1", "residual of the energy audit"),
)
RIG = (
    Quantity("rig.real_sliding_largest_mps", "wheel against roller, largest", "m/s", "sliding on the roller, largest"),
    Quantity("rig.real_sliding_rms_mps", "the same, RMS", "m/s", "the same, RMS"),
    Quantity("rig.roller_torque_largest_nm", "of a roller drive", "N m", "torque of a roller drive, largest"),
    Quantity("rig.drive_limited_s", "time with a drive's command at its limit", "s", "time at a drive's limit"),
)
FIDELITY = (
    Quantity("fidelity.tracking_rms", "wheel less virtual wheel, over train speed, RMS", "1", digits=2, shown=PERCENT),
    Quantity("fidelity.tracking_largest", "largest of the same", "1"),
    Quantity(
        "fidelity.tracking_by_own_motion", "part of its variance in proportion to the wheelsets' own motion, (D14)", "1"
    ),
    Quantity("fidelity.wheel_speed_rms", "wheel of rig less wheel on track, over train speed, RMS", "1"),
    Quantity("fidelity.wheel_speed_largest", "largest of the same, any axle", "1"),
    Quantity("fidelity.train_speed_largest_mps", "virtual train less train on track, largest", "m/s"),
    Quantity(
        "fidelity.distance_relative", "stopping distance of rig over track, less 1; null: no stop", "1", shown=PERCENT
    ),
    Quantity("fidelity.distance_at_end_relative", "the same at the end of the shorter run", "1"),
    Quantity("fidelity.slip_difference_rms", "slip of rig less slip on track at the same time, RMS", "1"),
    Quantity("fidelity.torque_difference_rms_nm", "brake and traction torque, rig less track, RMS", "N m"),
)
QUANTITIES = Quantities(
    Quantity("case", "name of the case"),
    RUN,
    RIG,
    FIDELITY,
    Quantity("variants.*.**", "the rig without some imperfections: tracking_rms, distance_relative, dump_cycles, mean_slip"),
    Quantity("error_budget.*", "part of (distance of rig over track, less 1) that goes away with it; the sum is the whole", "1"),
    Quantity("repeatability.*.mean_distance_m", "of the test begun 0 to 40 ms later, on track and rig", "m", "mean distance"),
    Quantity("repeatability.*.standard_error_m", "of that mean", "m", "standard error"),
    Quantity("repeatability.*.relative_range", "range of these distances over their mean", "1", "range", 2, PERCENT),
    Quantity("targets.*", "tracking RMS below 1 % of train speed, stopping distance within 2 %; null: unknown"),
)  # fmt: skip


@dataclass(frozen=True)
class Runs:
    """What was run: the rig, the track, variants of the rig by name, and both tests begun later."""

    track: xr.Dataset
    rig: xr.Dataset
    variants: Mapping[str, xr.Dataset]
    repeated: Mapping[str, Sequence[xr.Dataset]]


@dataclass(frozen=True)
class AdhesionStudy(Study[Runs]):
    """A test on degraded track and on the rig.

    Attributes:
        case: of the rig.
        error_budget: also run the variants of the rig, and both tests begun a little later.
    """

    case: Case
    error_budget: bool = True

    command = "adhesion"
    quantities = QUANTITIES
    writes = ("track.nc", "rig.nc", "axles.csv")
    irrelevant = ("description", "error_budget")

    def __post_init__(self) -> None:
        """Refuse a case that is not that of a rig which reproduces a test on track."""
        track_case(self.case)

    @property
    def title(self) -> str:
        return f"{self.case.name}: degraded track and the rig that reproduces it"

    def cases(self) -> Mapping[str, Case]:
        return {"rig": self.case, "track": track_case(self.case)}

    def rounds(self, done: Done) -> Iterator[Round]:
        cases = {"track": track_case(self.case), "rig": self.case}
        if self.error_budget:
            cases |= {name: variant(self.case, name) for name in variants_of(self.case)}
            pairs = [(label, cases[label]) for label in ("track", "rig")]
            cases |= {f"{label} {s:g} s later": later for label, one in pairs for s, later in starts(one).items()}
        yield {name: job(simulate, case) for name, case in cases.items()}

    def collect(self, done: Done) -> Runs | None:
        if "track" not in done or "rig" not in done:
            return None
        repeated = {
            label: [done[label], *(run for name, run in done.items() if name.startswith(f"{label} "))]
            for label in ("track", "rig")
        }
        return Runs(
            done["track"], done["rig"], {k: v for k, v in done.items() if k in VARIANTS and k != "rig"}, repeated
        )

    def statuses(self, results: Runs) -> Sequence[str]:
        return [run.attrs["status"] for run in (results.track, results.rig)]

    # --------------------------------------------------------------------------------------------------- numbers

    def numbers(self, results: Runs) -> dict[str, Any]:
        track, rig = results.track, results.rig
        compared = fidelity(track, rig)
        error, distance = compared["tracking_rms"] or math.nan, compared["distance_relative"]
        return {
            "case": self.case.name,
            "track": run_numbers(track),
            "rig": {**run_numbers(rig), **rig_numbers(rig, self.case)},
            "fidelity": compared,
            "variants": {name: variant_numbers(track, run) for name, run in results.variants.items()},
            "error_budget": error_budget(track, rig, results.variants, STEPS),
            "repeatability": {label: repeatability(runs) for label, runs in results.repeated.items()},
            "targets": {
                "tracking_rms_below_1_percent": bool(error < TRACKING_TARGET) if math.isfinite(error) else None,
                "stopping_distance_within_2_percent": None
                if distance is None
                else bool(abs(distance) <= DISTANCE_TARGET),
            },
        }

    def summary(self, results: Runs, numbers: Numbers) -> list[str]:
        return assessment(numbers)

    def files(self, results: Runs, numbers: Numbers) -> Mapping[str, Any]:
        return {"track.nc": results.track, "rig.nc": results.rig, "axles.csv": axle_columns(results.track, results.rig)}

    def sections(self, results: Runs, numbers: Numbers) -> list[Section]:
        names = [quantity.name for quantity in RUN if not quantity.name.startswith("status")]
        tables = [
            QUANTITIES.list_table({label: numbers[label] for label in ("track", "rig")}, names, "both runs"),
            QUANTITIES.list_table({"": numbers["fidelity"]}, [q.name for q in FIDELITY], "rig against track"),
            QUANTITIES.list_table({"": numbers["rig"]}, [q.name for q in RIG], "rig"),
        ]
        pictures = [Section(title, [Picture(*picture)]) for title, *picture in self._pictures(results)]
        budget = [self._budget(results, numbers)] if numbers["error_budget"] is not None else []
        return [*budget, Section("Numbers", list(tables)), *pictures]

    def _budget(self, results: Runs, numbers: Numbers) -> Section:
        parts = {CONTRIBUTIONS[name]: share for name, share in numbers["error_budget"].items()}
        ranges = [one["relative_range"] for one in numbers["repeatability"].values() if one is not None]
        fidelity, entries = numbers["fidelity"], {name: dict(one) for name, one in numbers["variants"].items()}
        at_end = fidelity["distance_relative"]
        entries["rig"] = {**numbers["rig"], **fidelity}
        entries["rig"]["distance_relative"] = fidelity["distance_at_end_relative"] if at_end is None else at_end
        labelled = {text: entries[name] for name, text in VARIANTS.items() if name in entries}
        labelled["the track"] = {**numbers["track"], "distance_relative": 0.0}
        names = ("distance_relative", "tracking_rms", "mean_slip", "dump_cycles")
        repeated = {label: one for label, one in numbers["repeatability"].items() if one is not None}
        caption = (
            "Part of the difference in distance that goes away with each imperfection, one after the other. Grey: the range in "
            "which the same test ends when it begins up to 40 ms later."
        )
        return Section(
            "Why rig and track differ",
            [
                Picture("error_budget", figures.error_budget(parts, max(ranges, default=0.0)), caption),
                QUANTITIES.table(labelled, names, "Each of the lines after the first takes one more imperfection away.", "run"),
                QUANTITIES.table(repeated, ("mean_distance_m", "standard_error_m", "relative_range"), "Repeated tests.", "on"),
            ],
        )  # fmt: skip

    def _pictures(self, results: Runs) -> list[tuple[str, str, Any, str]]:
        """Title of the section, and what a Picture takes."""
        track, rig, radius = results.track, results.rig, wheel_radius(results.rig)
        load, ideal = axle_load(rig), results.variants.get("rolling")
        brake, traction = self.case.brake is not None, self.case.traction is not None
        sliding = (
            "Full: the rig with its contact model; dashed: wheels that roll on the rollers without sliding. Below, the "
            "wheelsets' own motion along the track: the bogie swings on its traction rod, which the control law does not know "
            "of, and the wheels turn by it (D14)."
        )
        found = [
            ("Speeds", "speeds", figures.speeds(track, rig, radius), "Train and wheels: rig, virtual train, track."),
            (
                "The first slide",
                "first_slide",
                figures.first_slide(track, rig, radius),
                "Slip, and the response to it.",
            ),
        ]
        if brake:
            found.append(("Brakes", "brakes", figures.brakes(track, rig), "Cylinder pressure, dump cycles, air taken."))
        if traction:
            text = "Torque of the motors, and the part of the demand that is left."
            found.append(("Traction", "traction", figures.tractions(track, rig), text))
        return found + [
            ("Adhesion used", "adhesion", figures.forces(track, rig, load), "Force on each axle over its static load."),
            ("Roller drives", "roller_drives", figures.rollers(rig), "Torque of the roller drives, positive forward."),
            ("Sliding on the rollers", "sliding", figures.sliding(rig, ideal, radius), sliding),
            ("Rig less track", "differences", figures.errors(track, rig, radius), "At the same time."),
        ]


# ------------------------------------------------------------------------------------------------- tables and words


def repeatability(runs: Sequence[xr.Dataset]) -> dict[str, float] | None:
    """Distances of repeated tests; None for a single one."""
    if len(runs) < 2:
        return None
    names = ("mean_distance_m", "standard_error_m", "relative_range")
    return dict(zip(names, scatter(distances(runs)), strict=True))


def axle_columns(track: xr.Dataset, rig: xr.Dataset) -> dict[str, ArrayLike]:
    """Speeds and forces of each axle, rig beside track, as long as both ran."""
    count = min(track.sizes["time"], rig.sizes["time"])
    both = ("axle_speed", "cylinder_pressure", "contact_force", "creep_force", "brake_torque", "traction_torque")
    columns = {"time_s": rig["time"], "train_speed_track": track["train_speed"], "train_speed_rig": rig["train_speed"]}
    for name in (*both, "virtual_speed", "real_sliding", "roller_torque"):
        for axle in rig["axle"].to_numpy():
            for label, run in (("track", track), ("rig", rig)):
                if label == "rig" or name in both:
                    columns[f"{name}_{axle}_{label}"] = run[name].sel(axle=axle)
    return {name: column.to_numpy()[:count] for name, column in columns.items()}


def assessment(numbers: Numbers) -> list[str]:
    """The findings, targets first."""
    return [*_tracking(numbers), *_distance(numbers), *_budget(numbers), *_sliding(numbers), *_ends(numbers)]


def _tracking(numbers: Numbers) -> Iterator[str]:
    error, largest = numbers["fidelity"]["tracking_rms"], numbers["fidelity"]["tracking_largest"]
    if error is None:
        return
    limited = numbers["rig"]["drive_limited_s"]
    yield (
        f"Target {'met' if error < TRACKING_TARGET else 'missed'}: the wheels on the rig follow the virtual train within "
        f"{percent(error)} RMS of train speed (target: below {percent(TRACKING_TARGET)}), {percent(largest)} at most."
        + (f" A roller drive was at its torque limit for {limited:.2g} s." if limited > 0.0 else "")
    )


def _distance(numbers: Numbers) -> Iterator[str]:
    relative, track, rig = numbers["fidelity"]["distance_relative"], numbers["track"], numbers["rig"]
    if relative is None:
        at_end = numbers["fidelity"]["distance_at_end_relative"]
        yield f"No stop to compare: at the end of the shorter run the distances differ by {percent(at_end, signed=True)}."
        return
    yield (
        f"Target {'met' if abs(relative) <= DISTANCE_TARGET else 'missed'}: stopping distance {track['distance_m']:z.1f} m on "
        f"track, {rig['distance_m']:z.1f} m on the rig, {percent(relative, signed=True)} "
        f"(target: within {percent(DISTANCE_TARGET)})."
    )


def _budget(numbers: Numbers) -> Iterator[str]:
    parts = numbers["error_budget"]
    if parts is None:
        return
    ranked = sorted(parts, key=lambda name: -abs(parts[name]))
    listed = ", ".join(f"{CONTRIBUTIONS[name]} {percent(parts[name], signed=True)}" for name in ranked)
    yield f"Error budget of the difference of {percent(sum(parts.values()), signed=True)} in distance: {listed}."
    ranges = {label: one["relative_range"] for label, one in numbers["repeatability"].items() if one is not None}
    if not ranges:
        return
    both = ", ".join(f"{percent(value)} on the {label}" for label, value in ranges.items())
    yield f"Repeatability: begun 10 to 40 ms later, the same test ends in distances within {both}; less is not significant."
    if abs(parts[ranked[0]]) > max(ranges.values()):
        yield f"Largest contribution: {CONTRIBUTIONS[ranked[0]]}."
    else:
        yield "No contribution exceeds the repeatability."


def _sliding(numbers: Numbers) -> Iterator[str]:
    text = f"Wheels slide on the rollers by at most {1e3 * numbers['rig']['real_sliding_largest_mps']:.3g} mm/s"
    ideal, real = numbers["variants"].get("rolling", {}).get("tracking_rms"), numbers["fidelity"]["tracking_rms"]
    if ideal is not None:
        text += f"; with pure rolling the tracking error would be {percent(ideal)} instead of {percent(real)} RMS"
    yield f"{text}."


def _ends(numbers: Numbers) -> Iterator[str]:
    for label in ("track", "rig"):
        if numbers[label]["status"] not in COMPLETED:
            yield f"{label}: {numbers[label]['status_message']}"
