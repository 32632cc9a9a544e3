"""What `rollerrig lateral` leaves.

LateralStudy -> [write_lateral] -> one .nc per run, summary.json, report.html
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from rollerrig import __version__
from rollerrig.analysis.tracking import wheel_radius
from rollerrig.plot import figure_bytes
from rollerrig.plot import lateral as figures
from rollerrig.report import Figure, Page, Preformatted, Section, Table, Text, number, render
from rollerrig.results import save_run, write_text
from rollerrig.studies.control.lateral import (
    KEYS,
    WORDS,
    Guidance,
    LateralStudy,
    envelope,
    guidance,
    lateral_creep,
    lateral_stiffness,
    longitudinal_creep,
    numbers,
    slide_begins,
    train_slip,
)

LEFT_OUT = (
    "One bogie with its car body held, smooth rails and rollers, one push at the start. On the rig 'slide' is that of the "
    "virtual wheels; the real ones roll on dry rollers but for what is told as real sliding. Bearings of the roller axles as the "
    "case has them."
)

TRACKS = ("track", "track_exact")
GUIDANCE_KEYS = {
    "slope": "lateral creep force of fully sliding axles over -F v_y / w; 1: Coulomb [-]",
    "correlation": "of the two [-]",
    "rolling_ns_per_m": "damping of a rolling wheel, f22 / V [N s/m]",
    "sliding_ns_per_m": "of a sliding one, median of F / w [N s/m]",
}


def write_lateral(study: LateralStudy, folder: Path) -> list[Path]:
    """Write all files.

    Args:
        study: of `compare_lateral`.
        folder: an existing folder.

    Returns:
        The files, the report last.

    Raises:
        OutputError: a file could not be written.
    """
    found = summary(study)
    text = json.dumps(
        {
            **found,
            "keys": {"slide_begins_s": "on track, the time by which all runs are parted [s]", **KEYS, **GUIDANCE_KEYS},
        },
        indent=2,
        ensure_ascii=False,
    )
    files = [save_run(run, folder / f"{key}.nc") for key, run in study.runs.items()]
    files.append(write_text(folder / "summary.json", text + "\n"))
    files.append(write_text(folder / "report.html", report(study, found)))
    return files


def summary(study: LateralStudy) -> dict[str, Any]:
    """The numbers of all runs under the keys of KEYS, and of the guidance that is left on track."""
    begin = _slide(study)
    left = {key: _guidance(study, key) for key in TRACKS if key in study.runs}
    return {
        "case": study.case.name,
        "slide_begins_s": begin if math.isfinite(begin) else None,
        "runs": {key: numbers(run, begin) for key, run in study.runs.items()},
        "guidance": {key: _numbers(g) for key, g in left.items() if g is not None},
        "interrupted": study.interrupted,
        "rollerrig_version": __version__,
    }


def _slide(study: LateralStudy) -> float:
    """When the wheels begin to slide, on track where that was run [s]."""
    return slide_begins(study.runs.get("track", study.runs["rig"]))


def _guidance(study: LateralStudy, key: str) -> Guidance | None:
    run = study.runs[key]
    return guidance(run, lateral_stiffness(study.case, run))


def _numbers(found: Guidance) -> dict[str, float]:
    values = (found.slope, found.correlation, found.rolling, found.sliding)
    return dict(zip(GUIDANCE_KEYS, values, strict=True))


def lead(study: LateralStudy) -> str:
    """The verdict in a few lines."""
    found = summary(study)
    runs, lines = found["runs"], []
    errors = {key: runs[key]["tracking_rms"] for key in ("rig", "rig_centred", "rig_rigid") if key in runs}
    if len(errors) == 3 and all(errors.values()):
        lines.append(
            f"Tracking error, RMS of train speed: {_percent(errors['rig_centred'])} while the bogie stays in the middle, "
            f"{_percent(errors['rig_rigid'])} where it hunts on rigid rollers, {_percent(errors['rig'])} on elastic ones "
            f"({errors['rig'] / errors['rig_centred']:.2g} times as much): wheels then slide on the rollers at up to "
            f"{runs['rig']['real_sliding_largest_mps']:.2g} m/s, rigid {runs['rig_rigid']['real_sliding_largest_mps']:.2g} m/s, "
            f"centred {runs['rig_centred']['real_sliding_largest_mps']:.2g} m/s."
        )
    track, rig = runs.get("track"), runs["rig"]
    if track is not None and track["amplitude_in_slide_mm"] is not None and rig["amplitude_in_slide_mm"] is not None:
        lines.append(
            f"Hunting, amplitude of the leading wheelset before the slide and later than 1 s into it: on track "
            f"{track['amplitude_before_mm']:.2g} and {track['amplitude_in_slide_mm']:.2g} mm, on the rig "
            f"{rig['amplitude_before_mm']:.2g} and {rig['amplitude_in_slide_mm']:.2g} mm. "
            "Wheels on low adhesion, and all the more once they slide, are guided no more and hunt no more; the rig's real "
            "wheels go on rolling on dry rollers, and hunt."
        )
    left = found["guidance"].get("track")
    if left is not None:
        exact = found["guidance"].get("track_exact")
        lines.append(
            f"What is left of lateral creep on a sliding wheel is viscous, {left['sliding_ns_per_m']:.3g} N s/m in place of "
            f"{left['rolling_ns_per_m']:.3g}. Against -F v_y/w its slope is {left['slope']:.2f} with the case's creep law"
            + (f", {exact['slope']:.2f} with the exact theory." if exact is not None else ".")
        )
    ended = [
        f"{WORDS[key]}: {run.attrs['status_message']}" for key, run in study.runs.items() if run.attrs["status"] != "ok"
    ]
    if study.interrupted:
        ended.append("Interrupted: not all runs were done.")
    return "\n".join(lines + ended)


def _percent(value: float) -> str:
    return f"{100 * value:.2g} %"


def report(study: LateralStudy, found: dict[str, Any]) -> str:
    """One self-contained HTML page."""
    sections = [Section("Numbers", [_table(found)])]
    sections += [
        Section(title, [Figure(figure_bytes(picture, "png"), caption)]) for picture, title, caption in _pictures(study)
    ]
    if "track" in study.runs:
        sections.append(Section("What guides a sliding wheel", _guidance_blocks(study)))
    sections.append(Section("What is left out", [Text(LEFT_OUT)]))
    sections.append(Section("Case", [Preformatted("the whole case", study.case.to_toml())]))
    heading = f"{study.case.name}: lateral motion during a slide"
    return render(Page(heading, lead(study), sections, f"rollerrig {__version__}"))


def _table(found: dict[str, Any]) -> Table:
    runs = found["runs"]
    header = ("", *(WORDS[key] for key in runs))
    rows = []
    for key in KEYS:
        values = [run[key] for run in runs.values()]
        rows.append([key.replace("_", " "), *(_cell(v) for v in values)])
    return Table(header, rows, "meanings and units in summary.json")


def _cell(value: object) -> object:
    """Without the motions of rounding: a bogie in the middle stays there to 1e-10 mm."""
    if value is None:
        return "–"
    return number(round(value, 6), 3) if isinstance(value, float) else value


def _pictures(study: LateralStudy) -> list[tuple[Any, str, str]]:
    runs = study.runs
    shown = [key for key in ("rig", "rig_rigid", "rig_dry", "track", "track_dry") if key in runs]
    lead_of = {key: runs[key]["lateral"].isel(body=_row(runs[key])).to_numpy() for key in shown}
    times = {key: runs[key]["time"].to_numpy() for key in shown}
    begin = _slide(study)
    motion = {WORDS[key]: (times[key], 1e3 * lead_of[key]) for key in shown}
    sizes = {WORDS[key]: envelope(times[key], 1e3 * lead_of[key]) for key in shown}
    slips = {WORDS[key]: (times[key], 100.0 * train_slip(runs[key]).isel(axle=0).to_numpy()) for key in shown}
    rigs = {WORDS[key]: runs[key] for key in ("rig", "rig_rigid", "rig_centred") if key in runs}
    forces = {
        WORDS[key]: (times[key], 1e-3 * longitudinal_creep(runs[key])[:, 0], 1e-3 * lateral_creep(runs[key])[:, 0])
        for key in ("rig", "track")
        if key in runs
    }
    return [
        (
            figures.disturbed_control(rigs, wheel_radius(runs["rig"])),
            "Is the control disturbed",
            "Leading wheelset: tracking error, and sliding of the real wheel on its roller.",
        ),
        (
            figures.motions(motion, begin),
            "Lateral motion",
            "Displacement of the leading wheelset; dashed: the wheels of the train on track begin to slide.",
        ),
        (
            figures.amplitudes(sizes, slips),
            "Hunting and slide",
            "Half of peak to peak in windows of 0.4 s, and slip against the train; on the rig that of the virtual wheels.",
        ),
        (
            figures.creep_forces(forces),
            "Creep forces",
            "Leading left wheel: along and across the track. Sliding uses up the friction along the track.",
        ),
    ]


def _row(run: Any) -> int:
    return [str(body) for body in run["body"].to_numpy()].index(str(run["axle"].to_numpy()[0]))


def _guidance_blocks(study: LateralStudy) -> list[Any]:
    text = (
        "A wheel that slides along the track at a speed w far above its lateral speed v_y feels friction against its sliding: "
        "F_y = -F v_y / w, viscous and weak, where a rolling wheel has f22 / V. Kalker's theory saturated by its length keeps "
        "the direction of the linear force, so that its slope is near f22 / f11; the exact theory and Fastsim turn to Coulomb's. "
        "Spin, which pulls left and right apart, cancels in an axle."
    )
    blocks: list[Any] = [Text(text)]
    rows = []
    for key in TRACKS:
        found = _guidance(study, key) if key in study.runs else None
        if found is None:
            continue
        rows.append([WORDS[key], *(number(value, 3) for value in _numbers(found).values())])
        picture = figures.viscous(found.expected, found.force, found.slope)
        blocks.append(
            Figure(
                figure_bytes(picture, "png"), f"{WORDS[key]}: axles whose wheels slide faster than 1 m/s, each sample."
            )
        )
    header = ("run", "slope", "correlation", "rolling f22/V [N s/m]", "sliding F/w [N s/m]")
    if not rows:
        return [*blocks, Text("No wheel slid while it moved sideways.")]
    return [blocks[0], Table(header, rows), *blocks[1:]]
