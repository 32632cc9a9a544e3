"""The report of the adhesion study: the verdict, why rig and track differ, numbers of both, signals of their first tests.

rows, runs, numbers -> [adhesion_sections] -> sections with tables and figures
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from rollerrig.analysis.slide_statistics import SLIP_EDGES, TestRecord, axle_load
from rollerrig.analysis.tracking import under_test, wheel_radius
from rollerrig.config import Case
from rollerrig.plot import adhesion as figures
from rollerrig.plot.causes import cause_bars, dead_time_curve, slip_histogram
from rollerrig.study.adhesion_causes import CAUSES
from rollerrig.study.adhesion_laws import law_table
from rollerrig.study.adhesion_numbers import QUANTITIES, RIG, RUN
from rollerrig.study.adhesion_variants import VARIANTS
from rollerrig.study.adhesion_verdicts import Row, verdict_table
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Picture, Section, Table, Text
from rollerrig.wording import number

Whole = Mapping[str, xr.Dataset]

PHASE = (
    "Both are first tests of their ensembles. From the first slides on their limit cycles have different phases: what differs at "
    "one instant is no error of the rig, and nothing of the verdict is taken from it."
)


def adhesion_sections(
    case: Case, rows: Sequence[Row], whole: Whole, records: Mapping[str, Sequence[TestRecord]], numbers: Numbers
) -> list[Section]:
    """All sections of the report."""
    sections = [Section("Verdict", [verdict_table(rows), Text(PHASE)])]
    if numbers["causes"]:
        sections.append(_causes(numbers))
    if numbers["dead_time"]:
        sections.append(_dead_time(numbers))
    if numbers["creep_laws"]:
        sections.append(Section("Creep laws", [law_table(numbers["creep_laws"])]))
    sections += [_slip(records), _numbers(numbers)]
    return [
        *sections,
        *(Section(picture.name.replace("_", " ").capitalize(), [picture]) for picture in _signals(case, whole)),
    ]


def _causes(numbers: Numbers) -> Section:
    causes = numbers["causes"]
    bars = {
        CAUSES.get(name, name): (one["share"], one["standard_error"] or 0.0, one["within_its_error"])
        for name, one in causes.items()
    }
    caption = (
        "Part of the difference in mean distance that goes away with each imperfection, one after the other; standard errors. "
        "Hollow: inside its error of 95 %, not told from zero."
    )  # fmt: skip
    entries = {text: _flat(numbers["variants"][name]) for name, text in VARIANTS.items() if name in numbers["variants"]}
    shares = {CAUSES.get(name, name): one for name, one in causes.items()}
    names = ("share", "causes.*.standard_error", "causes.*.low", "causes.*.high", "within_its_error")
    return Section(
        "Why rig and track differ",
        [
            Picture("causes", cause_bars(bars), caption),
            QUANTITIES.table(shares, names, "Shares of the distance on track.", "cause"),
            _variants(entries),
        ],
    )


def _flat(numbers: Numbers) -> dict[str, object]:
    return {name: _pair(one) if isinstance(one, Mapping) else one for name, one in numbers.items()}


def _pair(one: Numbers, factor: float = 1.0) -> str:
    """Mean and standard error."""
    if one["mean"] is None:
        return "–"
    error = one["standard_error"]
    return number(factor * one["mean"]) + (f" ± {number(factor * error, 2)}" if error is not None else "")


def _variants(entries: Mapping[str, Mapping[str, object]]) -> Table:
    names = ("distance_relative", "tracking_rms", "mean_slip", "dump_cycles", "air_litres")
    header = ("run", "distance over track, less 1", "tracking RMS", "mean slip", "ventings", "air [l]")
    rows = [(label, *(str(one[name]) for name in names)) for label, one in entries.items()]
    return Table(header, rows, "Each of the lines after the first takes one more imperfection away; ± standard error.")


def _dead_time(numbers: Numbers) -> Section:
    found = numbers["dead_time"]
    blocks: list[Picture | Table] = []
    if found.get("track"):
        track = {0.0: numbers["track"]["distance_m"]} | {
            float(delay): {"mean": one["distance_m"], "standard_error": one["standard_error_m"]}
            for delay, one in found["track"].items()
        }
        curve = {delay: (one["mean"], one["standard_error"] or 0.0) for delay, one in track.items()}
        rig = numbers["rig"]["distance_m"]
        caption = (
            "Mean distance on track with more dead time of the protection, on the rig: where the curve has the rig's distance "
            "is its equivalent dead time. Dashed: in closed form, (D17); dotted: (Q8). Standard errors."
        )
        ends = (1e3 * found["predicted_s"], 1e3 * found["least_s"])
        blocks.append(
            Picture("dead_time", dead_time_curve(curve, (rig["mean"], rig["standard_error"] or 0.0), ends), caption)
        )
    names = [name for name in found if name.endswith("_s")]
    rows = [
        (QUANTITIES[f"dead_time.{name}"].in_words, None if found[name] is None else 1e3 * found[name]) for name in names
    ]
    table = Table(
        ("", "ms"), [(text, "–" if value is None else round(value, 2)) for text, value in rows], "Equivalent dead time."
    )
    return Section("Equivalent dead time", [*blocks, table])


def _slip(records: Mapping[str, Sequence[TestRecord]]) -> Section:
    shares = {name: np.mean([one.slip_shares for one in records[name]], axis=0) for name in ("track", "rig")}
    caption = "Part of the time that the axles spent at a slip, mean of all starts, while brake or traction act."
    return Section("Slip", [Picture("slip_histogram", slip_histogram(SLIP_EDGES, shares), caption)])


def _numbers(numbers: Numbers) -> Section:
    rows = []
    for name, _, _, _, shown in (*RUN, *RIG):
        quantity = QUANTITIES[f"{'*' if name in dict.fromkeys(one[0] for one in RUN) else 'rig'}.{name}.mean"]
        factor = shown[1] if shown else 1.0
        cells = [_pair(numbers[where][name], factor) if name in numbers[where] else "–" for where in ("track", "rig")]
        rows.append((quantity.heading, *cells))
    both = Table(("", "track", "rig"), rows, "Means of all starts ± standard error.")
    names = ("wheel_speed_rms", "wheel_speed_largest", "slip_difference_rms")
    labels = {"rig": "the rig", "track, second": "another start on the same track"}
    points = {labels[name]: one for name, one in numbers["point_by_point"].items()}
    caption = (
        "Against the first test on track at the same time, point by point: mostly phase, as the second line shows."
    )
    return Section("Numbers", [both, QUANTITIES.table(points, names, caption, "run")])


def _signals(case: Case, whole: Whole) -> Iterator[Picture]:
    """Of the first tests."""
    track, rig, ideal = whole["track"], whole["rig"], whole.get("rolling")
    radius = wheel_radius(rig)
    yield Picture("speeds", figures.speeds(track, rig, radius), "Train and wheels: rig, virtual train, track.")
    track, rig, ideal = under_test(track), under_test(rig), None if ideal is None else under_test(ideal)
    yield Picture("first_slide", figures.first_slide(track, rig, radius), "Slip, and the response to it.")
    if case.brake is not None:
        yield Picture("brakes", figures.brakes(track, rig), "Cylinder pressure, ventings, air taken.")
    if case.traction is not None:
        text = "Torque of the motors, and the part of the demand that is left."
        yield Picture("traction", figures.tractions(track, rig), text)
    yield Picture("adhesion", figures.forces(track, rig, axle_load(rig)), "Force on each axle over its static load.")
    yield Picture("roller_drives", figures.rollers(rig), "Torque of the roller drives, positive forward.")
    sliding = (
        "Full: the rig with its contact model; dashed: wheels that roll on the rollers without sliding. Below, the wheelsets' "
        "own motion along the track: the bogie swings on its traction rod, which the control law does not know, and the wheels "
        "turn by it (D14)."
    )
    yield Picture("sliding", figures.sliding(rig, ideal, radius), sliding)
    text = (
        "Rig less track at the same time. Once the wheels slide, the wheels' lines show two phases of one limit cycle."
    )
    yield Picture("differences", figures.errors(track, rig, radius), text)


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
