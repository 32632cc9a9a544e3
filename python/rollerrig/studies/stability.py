"""The stability study of one case: modes over speed, limit cycles, critical speeds.

Case, speeds -> [stability study] -> report.html, stability.nc, CSV tables, summary.json
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import xarray as xr

from rollerrig import __version__
from rollerrig.analysis import (
    CriticalSpeedByDisturbance,
    Diagram,
    LimitCycleSettings,
    limit_cycle_table,
    limit_cycles,
    stability,
)
from rollerrig.config import Case
from rollerrig.plot import (
    damping_map,
    damping_over_speed,
    figure_bytes,
    frequency_over_speed,
    limit_cycle_diagram,
    mode_shape,
    mode_shapes,
    root_locus,
)
from rollerrig.report import render
from rollerrig.results import output_folder, save_run, write_text
from rollerrig.studies.contact_effects import COUNTERPART, ContactEffect, contact_effects, effect_rows, effects_section
from rollerrig.studies.output import finite, write_rows
from rollerrig.studies.stability_page import report_page, shape_speed, suspension_modes

Progress = Callable[[float, str], None]

STABILITY_KEYS = {
    "case": "name of the case",
    "speeds_kmh": "speeds of the table of modes [km/h]",
    "linear_critical_speed_kmh": "lowest speed at which an oscillation begins to grow [km/h]; null: none in the range",
    "linear_critical_frequency_hz": "its frequency [Hz]",
    "linear_critical_mode": "its name",
    "crossings": "all speeds at which an oscillation begins or ends to grow: speed, frequency, mode, and on which side it grows",
    "grows_at_lowest_speed": "names of the oscillations that grow already at the lowest speed",
    "diverging": "motions that grow without oscillating: name, largest growth rate, speed where it is reached",
    "least_damping": "per speed, the smallest damping ratio of all oscillatory modes [1]",
    "interrupted": "whether Ctrl-C ended the study early; what is missing was not computed",
    "limit_cycles": "not with --no-limit-cycles: the numbers below",
    "limit_cycles.bifurcation": "none, subcritical, supercritical, detached, or unstable throughout",
    "limit_cycles.critical_speed_by_continuation_kmh": "lowest speed with a limit cycle that persists [km/h]; null: none",
    "limit_cycles.decays_kmh": "highest speed below it at which everything comes to rest [km/h]",
    "limit_cycles.jump_up_kmh": "lowest speed run at which the perturbation of the way up grows into a limit cycle [km/h]",
    "limit_cycles.hysteresis_kmh": "lowest and highest speed run at which the two ways end differently [km/h]; null: nowhere",
    "limit_cycles.tolerance_kmh": "to which the critical speed by continuation was looked for [km/h]",
    "limit_cycles.disturbance_mm": "lateral offset of the leading wheelset at the start of the way down [mm]",
    "limit_cycles.perturbation_mm": "the same on the way up [mm]",
    "limit_cycles.points": "per run: way, speed, amplitude, peak, frequency, largest |Y|, settled, simulated time, status",
    "rollerrig_version": "version of this program",
}
"""Key of summary.json -> meaning and unit."""

MOST_CYCLE_SPEEDS = 20
"""Runs are made at no more speeds than this, spread over the range."""


@dataclass(frozen=True)
class StabilityStudy:
    """What was computed.

    Attributes:
        case: the case.
        modes: Dataset of `stability`.
        cycles: the limit-cycle diagram, if asked for.
        settings: of its runs.
        effects: what the contact model changes, if asked for.
    """

    case: Case
    modes: xr.Dataset
    cycles: Diagram | None
    settings: LimitCycleSettings
    effects: tuple[ContactEffect, ...] = ()

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended it early."""
        return bool(self.modes.attrs["interrupted"]) or (self.cycles is not None and self.cycles.interrupted)


def stability_study(
    case: Case,
    speeds_kmh: Sequence[float],
    *,
    with_limit_cycles: bool = True,
    settings: LimitCycleSettings | None = None,
    processes: int = 1,
    progress: Progress | None = None,
) -> StabilityStudy:
    """Modes over speed, and the limit-cycle diagram.

    Args:
        case: the case.
        speeds_kmh: speeds of the table [km/h]; runs are made at no more than MOST_CYCLE_SPEEDS of them.
        with_limit_cycles: whether runs are made.
        settings: of the runs.
        processes: with 2, the way up and the way down run at a time.
        progress: called with the fraction done and a short text.
    """
    chosen = settings or LimitCycleSettings()
    report = progress or (lambda _fraction, _text: None)
    share = 0.1 if with_limit_cycles else 1.0
    modes = stability(case, speeds_kmh, progress=lambda f, t: report(share * f, t))
    if not with_limit_cycles or modes.attrs["interrupted"]:
        return StabilityStudy(case, modes, None, chosen)
    found = limit_cycles(
        case,
        cycle_speeds(speeds_kmh),
        float(modes.attrs["linear_critical_speed_kmh"]),
        chosen,
        processes=processes,
        progress=lambda f, t: report(share + (1 - share) * f, t),
    )
    return StabilityStudy(case, modes, found, chosen)


def with_contact_effects(
    study: StabilityStudy, speeds_kmh: Sequence[float], run_speed_kmh: float, *, progress: Progress | None = None
) -> StabilityStudy:
    """The study with what the contact model changes, on the case's own support and on the catalogue's of the other kind.

    Args:
        study: of the case.
        speeds_kmh: range in which critical speeds are looked for [km/h].
        run_speed_kmh: speed of the runs [km/h].
        progress: called with the fraction done and a short text.
    """
    own = study.case.support.data.kind
    other, support = COUNTERPART[own]
    cases = {own: study.case, other: study.case.with_changes({"support.use": support})}
    effects = contact_effects(cases, speeds_kmh, run_speed_kmh, progress=progress)
    return replace(study, effects=tuple(effects))


def cycle_speeds(speeds_kmh: Sequence[float]) -> list[float]:
    """Speeds at which runs are made: the first, the last and at most 18 between them, as even as the list allows."""
    picks = np.unique(
        np.round(np.linspace(0, len(speeds_kmh) - 1, min(len(speeds_kmh), MOST_CYCLE_SPEEDS))).astype(int)
    )
    return [float(speeds_kmh[k]) for k in picks]


def write_study(study: StabilityStudy, out: str | Path) -> list[Path]:
    """Write report.html, stability.nc, modes.csv, shapes.csv, limit_cycles.csv, summary.json and the figures.

    Raises:
        OutputError: a file could not be written.
    """
    folder = output_folder(out)
    cycles = None if study.cycles is None else limit_cycle_table(study.cycles)
    figures = study_figures(study.modes, cycles)
    data = study.modes if cycles is None else study.modes.merge(cycles, combine_attrs="drop_conflicts")
    written = [
        save_run(data, folder / "stability.nc"),
        write_rows(folder / "modes.csv", mode_rows(study.modes)),
        write_rows(folder / "shapes.csv", shape_rows(study.modes)),
        write_text(folder / "summary.json", json.dumps(summary(study), indent=2) + "\n"),
    ]
    if cycles is not None:
        written.append(write_rows(folder / "limit_cycles.csv", cycle_rows(cycles)))
    for name, image in figures.items():
        written.append(write_text(folder / f"{name}.svg", image.decode()))
    if study.effects:
        written.append(write_rows(folder / "contact_effects.csv", effect_rows(study.effects)))
    page = report_page(study.case.name, study.modes, study.cycles, cycles, study.settings, figures)
    if study.effects:
        page.sections.insert(-1, effects_section(study.effects, study.settings.disturbance))
    return [*written, write_text(folder / "report.html", render(page))]


def study_figures(modes: xr.Dataset, cycles: xr.Dataset | None) -> dict[str, bytes]:
    """Name -> SVG of each figure of the study."""
    speed, names = shape_speed(modes), suspension_modes(modes)
    figures = {
        "frequency": frequency_over_speed(modes, cycles),
        "damping": damping_over_speed(modes),
        "damping_map": damping_map(modes),
        "root_locus": root_locus(modes),
    }
    critical = modes.attrs["linear_critical_mode"] or modes.attrs["hunting_mode"]
    if critical:
        figures["critical_mode"] = mode_shape(modes, critical, speed)
    if names:
        figures["mode_shapes"] = mode_shapes(modes, names, speed)
    if cycles is not None and cycles.sizes["cycle_point"]:
        figures["limit_cycles"] = limit_cycle_diagram(cycles, modes)
    return {name: figure_bytes(figure) for name, figure in figures.items()}


def summary(study: StabilityStudy) -> dict[str, object]:
    """The numbers of the study under the keys of STABILITY_KEYS, and the keys themselves."""
    modes = study.modes
    result: dict[str, object] = {
        "case": study.case.name,
        "speeds_kmh": modes["speed"].to_numpy().round(9).tolist(),
        "linear_critical_speed_kmh": finite(modes.attrs["linear_critical_speed_kmh"]),
        "linear_critical_frequency_hz": finite(modes.attrs["linear_critical_frequency_hz"]),
        "linear_critical_mode": modes.attrs["linear_critical_mode"],
        "crossings": json.loads(modes.attrs["crossings"]),
        "grows_at_lowest_speed": json.loads(modes.attrs["grows_at_lowest_speed"]),
        "diverging": json.loads(modes.attrs["diverging"]),
        "least_damping": modes["damping"].where(modes["frequency"] > 0.05).min("mode").to_numpy().tolist(),
        "interrupted": study.interrupted,
    }
    if study.cycles is not None:
        result["limit_cycles"] = cycle_summary(study.cycles, study.settings)
    return {**result, "rollerrig_version": __version__, "keys": STABILITY_KEYS}


def cycle_summary(found: Diagram, settings: LimitCycleSettings) -> dict[str, object]:
    """The diagram and what follows from it, for summary.json."""
    return {
        "bifurcation": found.kind,
        "critical_speed_by_continuation_kmh": finite(3.6 * found.lowest_cycle),
        "decays_kmh": finite(3.6 * found.decays),
        "jump_up_kmh": finite(3.6 * found.jumps),
        "hysteresis_kmh": None if found.hysteresis is None else [3.6 * v for v in found.hysteresis],
        "tolerance_kmh": settings.tolerance_kmh,
        "disturbance_mm": 1e3 * settings.disturbance,
        "perturbation_mm": 1e3 * settings.perturbation,
        "points": [
            {
                "way": way,
                "speed_kmh": round(3.6 * point.speed, 6),
                "amplitude_mm": finite(1e3 * point.amplitude),
                "peak_mm": finite(1e3 * point.peak),
                "frequency_hz": finite(point.frequency),
                "guiding_force_n": finite(point.guiding_force),
                "settled": point.settled,
                "duration_s": point.duration,
                "status": point.status,
            }
            for way, points in (("up", found.up), ("down", found.down))
            for point in points
        ],
    }


def mode_rows(modes: xr.Dataset) -> list[list[object]]:
    """Table of all modes over speed, header first."""
    rows: list[list[object]] = [["speed_kmh", "mode", "growth_rate_per_s", "frequency_hz", "damping"]]
    speeds, names = modes["speed"].to_numpy(), modes["mode"].to_numpy()
    values = [modes[v].transpose("speed", "mode").to_numpy() for v in ("growth_rate", "frequency", "damping")]
    for at in np.ndindex(values[0].shape):
        rows.append([float(speeds[at[0]]), str(names[at[1]]), *(float(v[at]) for v in values)])
    return rows


def shape_rows(modes: xr.Dataset) -> list[list[object]]:
    """Table of all mode shapes over speed, header first."""
    rows: list[list[object]] = [["speed_kmh", "mode", "body", "direction", "amplitude", "phase_deg", "energy_share"]]
    names = ("shape_amplitude", "shape_phase", "energy_share")
    values = [modes[name].transpose("speed", "mode", "body", "direction").to_numpy() for name in names]
    speeds = modes["speed"].to_numpy()
    labels = [[str(label) for label in modes[d].to_numpy()] for d in ("mode", "body", "direction")]
    for k, mode, body, direction in np.ndindex(values[0].shape):
        at = (k, mode, body, direction)
        place = [float(speeds[k]), labels[0][mode], labels[1][body], labels[2][direction]]
        rows.append([*place, *(float(v[at]) for v in values)])
    return rows


def disturbance_summary(found: CriticalSpeedByDisturbance) -> dict[str, object]:
    """The runs and the bracket they give, for summary.json."""
    return {
        "disturbance_mm": 1e3 * found.disturbance,
        "decays_kmh": finite(3.6 * found.decays),
        "persists_kmh": finite(3.6 * found.persists),
        "runs": [
            {
                "speed_kmh": round(3.6 * run.speed, 6),
                "amplitude_mm": 1e3 * run.ending.amplitude,
                "frequency_hz": finite(run.ending.frequency),
                "growth_rate_at_end_per_s": finite(run.ending.rate),
                "persists": run.persists,
                "status": run.motion.attrs["status"],
                "energy_relative_residual": run.motion.attrs["energy_relative_residual"],
            }
            for run in found.runs
        ],
    }


def run_rows(found: CriticalSpeedByDisturbance) -> list[list[object]]:
    """Table of the runs, header first."""
    header: list[object] = [
        "speed_kmh",
        "amplitude_mm",
        "frequency_hz",
        "growth_rate_at_end_per_s",
        "persists",
        "status",
    ]
    return [
        header,
        *(
            [
                round(3.6 * run.speed, 6),
                1e3 * run.ending.amplitude,
                run.ending.frequency,
                run.ending.rate,
                int(run.persists),
                run.motion.attrs["status"],
            ]
            for run in found.runs
        ),
    ]


CYCLE_COLUMNS = {
    "cycle_way": "way",
    "cycle_speed": "speed_kmh",
    "cycle_amplitude": "amplitude_m",
    "cycle_peak": "peak_m",
    "cycle_frequency": "frequency_hz",
    "cycle_guiding_force": "guiding_force_n",
    "cycle_rate": "growth_rate_at_end_per_s",
    "cycle_settled": "settled",
    "cycle_duration": "duration_s",
    "cycle_status": "status",
}
"""Variable -> heading in limit_cycles.csv."""


def cycle_rows(cycles: xr.Dataset) -> list[list[object]]:
    """Table of the limit-cycle diagram, header first."""
    columns = [cycles[name].to_numpy().tolist() for name in CYCLE_COLUMNS]
    return [list(CYCLE_COLUMNS.values()), *(list(row) for row in zip(*columns, strict=True))]
