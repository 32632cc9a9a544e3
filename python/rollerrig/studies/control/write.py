"""What `rollerrig control` leaves.

Study -> [write_control] -> variants.csv, loop.csv, summary.json, report.html
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from rollerrig import __version__
from rollerrig.plot import control as figures
from rollerrig.plot import figure_bytes
from rollerrig.report import Figure, Page, Preformatted, Section, Table, Text, number, render
from rollerrig.results import write_text
from rollerrig.studies.control.compute import LOST, LOST_RIPPLE, RESULT_KEYS, Break, Rank, Result, Study, ranking
from rollerrig.studies.control.families import Family
from rollerrig.studies.control.loop import creep_slope, gain_limit, loop_of, margins, rolling_plant, vehicle_plant
from rollerrig.studies.control.ring import quiet_case
from rollerrig.studies.output import finite, write_rows

LEFT_OUT = (
    "One case and one course of the slide protection; its valves switch on small differences, so that errors of neighbouring "
    "values scatter by some tenths. Each variant changes one thing. Where the axis is an encoder's, all controllers, the slide "
    "protection too, see it; elsewhere speeds are exact."
)

KEYS = {
    "case, duration_s": "what was run",
    "limits": "tracking RMS [-] and torque ripple [N m] from which on a variant counts as broken",
    "references.*, results[]": "numbers of each run:",
    **{f"... {key}": meaning for key, meaning in RESULT_KEYS.items()},
    "ranking[]": "every curve, the worst first; breaks: where it is lost going out from the case's own value",
    "... value, good": "where the limit is passed, interpolated, or where a test first ended early; the last value that was well",
    "... cause": "tracking, ripple, or the status of a run that ended early",
    "loop": "of the PI feedback as shipped: crossover, margins of one axle alone, and the factor on its gains at which it rings",
    "loop.points[]": "growth rate [1/s] and frequency [Hz] of the loop over the factor; rang: 1 where a run did",
}


def write_control(study: Study, folder: Path) -> list[Path]:
    """Write all files.

    Args:
        study: of `compare_controllers`.
        folder: an existing folder.

    Returns:
        The files, the report last.

    Raises:
        OutputError: a file could not be written.
    """
    numbers = summary(study)
    text = json.dumps({**numbers, "keys": KEYS}, indent=2, ensure_ascii=False)
    files = [write_rows(folder / "variants.csv", _rows(study))]
    if study.ring:
        files.append(write_rows(folder / "loop.csv", _loop_rows(study)))
    files.append(write_text(folder / "summary.json", text + "\n"))
    files.append(write_text(folder / "report.html", report(study, numbers)))
    return files


def _rows(study: Study) -> list[list[object]]:
    header: list[object] = ["family", "curve", "value", "cause", *RESULT_KEYS]
    return [header] + [
        [r.family, r.curve, r.value, r.cause, *r.numbers.values()] for r in (*study.references, *study.results)
    ]


def _loop_points(study: Study) -> dict[str, list[float]]:
    points: dict[str, list[float]] = {"factor": [p.factor for p in study.ring]}
    for of in ("rolling", "vehicle", "measured"):
        points[f"{of}_rate"] = [getattr(p, of)[0] for p in study.ring]
        points[f"{of}_hz"] = [getattr(p, of)[1] for p in study.ring]
    points["rang"] = [float(p.rang) for p in study.ring]
    return points


def _loop_rows(study: Study) -> list[list[object]]:
    points = _loop_points(study)
    return [list(points), *(list(row) for row in zip(*points.values(), strict=True))]


def summary(study: Study) -> dict[str, Any]:
    """The numbers of a study under the keys of KEYS."""
    return {
        "case": study.case.name,
        "duration_s": study.case.time.duration,
        "limits": {"tracking_rms": LOST, "ripple_nm": LOST_RIPPLE},
        "references": {r.curve: _plain(r.numbers) for r in study.references},
        "results": [
            {"family": r.family, "curve": r.curve, "value": r.value, "cause": r.cause, **_plain(r.numbers)}
            for r in study.results
        ],
        "ranking": [
            {
                "family": rank.family.name,
                "curve": rank.curve,
                "worst_value": rank.worst.value,
                "worst_tracking_rms": finite(rank.worst.numbers["tracking_rms"]),
                "worst_ripple_nm": finite(rank.worst.numbers["ripple_nm"]),
                "breaks": [{"value": b.value, "good": finite(b.good), "cause": b.cause} for b in rank.breaks],
            }
            for rank in ranking(study)
        ],
        "loop": _loop(study) if study.ring else None,
        "interrupted": study.interrupted,
        "rollerrig_version": __version__,
    }


def _plain(numbers: dict[str, Any]) -> dict[str, Any]:
    return {key: finite(value) if isinstance(value, float) else value for key, value in numbers.items()}


def _loop(study: Study) -> dict[str, Any] | None:
    case = quiet_case(study.case)
    creep = creep_slope(case)
    loop, sliding = (loop_of(case, creep, sliding=slides) for slides in (False, True))
    if loop is None or sliding is None:
        return None
    found, vehicle = margins(loop), vehicle_plant(case)
    points = _loop_points(study)
    rows = [dict(zip(points, map(finite, row), strict=True)) for row in zip(*points.values(), strict=True)]
    return {
        "crossover_hz": finite(found.crossover / (2.0 * math.pi)),
        "phase_margin_deg": finite(math.degrees(found.phase)),
        "gain_margin": finite(found.gain),
        "rings_from_factor_alone": finite(gain_limit(loop, rolling_plant(loop.real, creep))),
        "rings_from_factor": finite(gain_limit(loop, vehicle)),
        "rings_from_factor_sliding": finite(gain_limit(sliding, vehicle)),
        "points": rows,
    }


# ------------------------------------------------------------------------------------------------------------ in words


def lead(study: Study) -> str:
    """The verdict in a few lines."""
    base = study.references[0].numbers
    lines = [
        f"As shipped the wheels follow the virtual train within {100 * base['tracking_rms']:.2g} % RMS of its speed. "
        f"Broken means above {100 * LOST:g} %, a torque ripple above {LOST_RIPPLE:g} N m RMS that never ceases, or a test "
        "that ends early."
    ]
    broken: dict[str, list[Rank]] = {}
    for rank in ranking(study):
        if rank.breaks:
            broken.setdefault(rank.family.name, []).append(rank)
    lines.append("What breaks, worst first:" if broken else "Nothing broke within the ranges tried.")
    lines += [f"– {sentence(study, ranks)}" for ranks in broken.values()]
    if study.interrupted:
        lines.append("Interrupted: not all variants were run.")
    return "\n".join(lines)


def sentence(study: Study, ranks: list[Rank]) -> str:
    """Where the curves of one family break, in words."""
    family = ranks[0].family
    base = f" (shipped: {_value(family, family.base(study.case))})" if family.base is not None else ""
    said = [f"{rank.curve}: {' and '.join(_place(family, rank.points, b) for b in rank.breaks)}" for rank in ranks]
    return f"{family.title}{base} – {'; '.join(said)}."


def _place(family: Family, points: list[Result], b: Break) -> str:
    causes = {"tracking": "tracking lost", "ripple": "torque never calm"}
    cause = causes.get(b.cause, f"{b.cause.replace('_', ' ')}, test ends early,")
    if math.isnan(b.good):
        return f"{cause} throughout, {_value(family, points[0].value)} to {_value(family, points[-1].value)}"
    side = "below" if b.value < b.good else "above"
    if b.cause in causes:
        return f"{cause} {side} {_value(family, b.value)}"
    return f"{cause} between {_value(family, b.good)} and {_value(family, b.value)}"


def _value(family: Family, value: float) -> str:
    if family.unit == "s":
        return f"{1e3 * value:.3g} ms"
    if family.unit == "%":
        return f"{value:+.3g} %" if value else "0 %"
    unit = family.unit if family.unit == "×" else f" {family.unit}"
    return (f"{value:,.0f}".replace(",", "\u202f") if value >= 1000 else f"{value:.3g}") + unit


# ----------------------------------------------------------------------------------------------------------- the report


def report(study: Study, numbers: dict[str, Any]) -> str:
    """One self-contained HTML page."""
    ranked = ranking(study)
    sections = [Section("What breaks first", [_tornado(study, ranked), _ranking_table(study, ranked)])]
    courses = Figure(figure_bytes(_courses(study), "png"), _COURSES)
    sections.append(Section("Where the error comes from", [_references(study), courses]))
    if study.ring and numbers["loop"] is not None:
        sections.append(Section("Stability of the loop", _loop_blocks(study, numbers["loop"])))
    for family in study.families:
        drawn = _family_figure(study, family)
        if drawn is not None:
            sections.append(Section(family.title, [drawn]))
    sections.append(Section("What is left out", [Text(LEFT_OUT)]))
    sections.append(Section("Case", [Preformatted("the whole case", study.case.to_toml())]))
    title = f"{study.case.name}: controllers of the roller drives compared"
    return render(Page(title, lead(study), sections, f"rollerrig {__version__}"))


_COURSES = (
    "Leading axle over time: the case as shipped, and the worst runs of each kind that came to their end. Speeds of train, "
    "wheel and virtual wheel; tracking error over train speed; torque of the roller's drive."
)


def _tornado(study: Study, ranked: list[Rank]) -> Figure:
    bars = []
    for rank in ranked:
        going = [p.numbers for p in rank.points if p.numbers["status"] == "ok"] or [rank.worst.numbers]
        tracking = [max(100.0 * n["tracking_rms"], 1e-4) for n in going]
        ripple = [max(n["ripple_nm"], 0.1) for n in going if math.isfinite(n["ripple_nm"])] or [math.nan]
        label = f"{rank.family.name.replace('_', ' ')}, {rank.curve}"
        ended = rank.worst.numbers["status"] != "ok"
        bars.append(figures.Bar(label, (min(tracking), max(tracking)), (min(ripple), max(ripple)), ended))
    base = study.references[0].numbers
    shipped = (100.0 * base["tracking_rms"], base["ripple_nm"])
    picture = figures.tornado(bars, shipped, (100.0 * LOST, LOST_RIPPLE))
    caption = (
        "Range of the errors along each axis, the worst on top. Dashed: from here on a variant counts as broken; dotted: the "
        "case as shipped. Red bars pass the limit."
    )
    return Figure(figure_bytes(picture, "png"), caption)


def _ranking_table(study: Study, ranked: list[Rank]) -> Table:
    rows = []
    for rank in ranked:
        worst = rank.worst
        verdict = "; ".join(_place(rank.family, rank.points, b) for b in rank.breaks) or "does not break"
        rows.append(
            [
                rank.family.title,
                rank.curve,
                verdict,
                _value(rank.family, rank.family.base(study.case)) if rank.family.base is not None else "–",
                _value(rank.family, worst.value),
                "ended" if worst.numbers["status"] != "ok" else f"{100 * worst.numbers['tracking_rms']:.2g} %",
                "–" if not math.isfinite(worst.numbers["ripple_nm"]) else f"{worst.numbers['ripple_nm']:.0f}",
            ]
        )
    header = ("varied", "curve", "what breaks", "shipped", "worst at", "tracking RMS", "ripple [N m]")
    return Table(header, rows, "every curve, the worst first")


def _references(study: Study) -> Table:
    keys = {
        "tracking_rms": ("tracking RMS [%]", 100.0),
        "tracking_largest": ("largest [%]", 100.0),
        "real_sliding_largest_mps": ("real sliding [mm/s]", 1e3),
        "roller_torque_largest_nm": ("roller torque [kN m]", 1e-3),
        "ripple_nm": ("ripple [N m]", 1.0),
        "distance_relative": ("distance, less shipped [%]", 100.0),
        "dump_cycles": ("dump cycles", 1),
        "air_litres": ("air [l]", 1.0),
    }
    rows = []
    for result in study.references:
        cells = [_cell(result.numbers[key], scale) for key, (_, scale) in keys.items()]
        rows.append([result.curve, result.numbers["status"], *cells])
    return Table(
        ("run", "status", *(label for label, _ in keys.values())), rows, "the case, and where its error comes from"
    )


def _cell(value: float | None, scale: float) -> object:
    if value is None or not math.isfinite(value):
        return "–"
    return value if isinstance(value, int) else number(scale * value, 3)


def _courses(study: Study) -> Any:
    runs = {study.references[0].curve: study.references[0].course}
    for result in study.results:
        if result.course is not None:
            family = next(f for f in study.families if f.name == result.family)
            label = f"{family.name.replace('_', ' ')},\n{result.curve}: {_value(family, result.value)}"
            runs[label] = result.course
    kept = {label: run for label, run in runs.items() if run is not None}
    return figures.courses(kept, study.case.vehicle.data.wheel.radius)


def _loop_blocks(study: Study, loop: dict[str, Any]) -> list[Any]:
    said = {key: "–" if not isinstance(value, float) else f"{value:.3g}" for key, value in loop.items()}
    text = (
        f"The PI loop crosses over at {said['crossover_hz']} Hz with a phase margin of {said['phase_margin_deg']}° and a gain "
        f"margin of {said['gain_margin']}, closed form for one axle. As it is sampled, wheel and roller alone ring from "
        f"{said['rings_from_factor_alone']} times its gains on; with the vehicle on its springs the loop rings from "
        f"{said['rings_from_factor']} times on while the virtual wheel rolls on a dry rail, and from "
        f"{said['rings_from_factor_sliding']} times while it slides. Computed is the least damped motion above "
        "10 Hz, from the core's exact linearisation of the vehicle and a controller written down from the equations; "
        "measured are quiet runs on a dry virtual rail after a light push."
    )
    picture = figures.ring_limit(_loop_points(study))
    return [Text(text), Figure(figure_bytes(picture, "png"), "Growth rate and frequency of the loop over its gains.")]


def _family_figure(study: Study, family: Family) -> Figure | None:
    curves = []
    for label in dict.fromkeys(r.curve for r in study.results if r.family == family.name):
        points = study.curve(family.name, label)
        numbers = [p.numbers for p in points]
        curves.append(
            figures.Curve(
                label,
                [p.value for p in points],
                [100.0 * n["tracking_rms"] for n in numbers],
                [n["ripple_nm"] for n in numbers],
                [n["status"] != "ok" for n in numbers],
            )
        )
    if not curves or not np.isfinite([v for c in curves for v in c.tracking]).any():
        return None
    base = family.base(study.case) if family.base is not None else None
    picture = figures.over_parameter(curves, family.axis, family.scale, base, (100.0 * LOST, LOST_RIPPLE))
    caption = f"{family.title}. Dashed: from here on a variant counts as broken; dotted: the case as shipped."
    return Figure(figure_bytes(picture, "png"), caption)
