"""The stability study of one case: modes over speed, critical speeds, and runs where asked.

Case, speeds -> [stability study] -> report.html, stability.nc, CSV tables, summary.json
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from rollerrig import __version__
from rollerrig.analysis import (
    HuntingRun,
    HuntingSettings,
    NonlinearCriticalSpeed,
    hunting_table,
    nonlinear_critical_speed,
    stability,
)
from rollerrig.config import Case
from rollerrig.plot import (
    amplitude_over_speed,
    damping_over_speed,
    figure_bytes,
    frequency_over_speed,
    hunting_over_time,
    root_locus,
)
from rollerrig.plot.modes import shown_modes
from rollerrig.report import Figure, Page, Preformatted, Section, Table, Text, render
from rollerrig.results import output_folder, save_run, write_text
from rollerrig.studies.output import finite, write_rows

Progress = Callable[[float, str], None]

STABILITY_KEYS = {
    "case": "name of the case",
    "speeds_kmh": "speeds of the table of modes [km/h]",
    "linear_critical_speed_kmh": "speed at which the least damped oscillation loses its damping [km/h]; null: none in the range",
    "linear_critical_frequency_hz": "its frequency [Hz]",
    "linear_critical_mode": "its name",
    "least_damping": "per speed, the smallest damping ratio of all oscillatory modes [1]",
    "interrupted": "whether Ctrl-C ended the study early; speeds and runs that are missing were not computed",
    "nonlinear": "only with --nonlinear: the numbers below",
    "nonlinear.disturbance_mm": "lateral offset of the leading wheelset at the start of each run [mm]",
    "nonlinear.dies_out_kmh": "highest speed below the onset at which the disturbance died out [km/h]",
    "nonlinear.goes_on_kmh": "lowest speed at which it went on [km/h]",
    "nonlinear.runs": "per run: speed, amplitude, frequency, growth rate at the end, whether it goes on",
    "rollerrig_version": "version of this program",
}
"""Key of summary.json -> meaning and unit."""


@dataclass(frozen=True)
class StabilityStudy:
    """What was computed.

    Attributes:
        case: the case.
        modes: Dataset of `stability`.
        nonlinear: the runs, if asked for.
    """

    case: Case
    modes: xr.Dataset
    nonlinear: NonlinearCriticalSpeed | None

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended it early."""
        return bool(self.modes.attrs["interrupted"]) or (self.nonlinear is not None and self.nonlinear.interrupted)


def stability_study(
    case: Case,
    speeds_kmh: Sequence[float],
    *,
    nonlinear: bool = False,
    settings: HuntingSettings | None = None,
    processes: int = 1,
    progress: Progress | None = None,
) -> StabilityStudy:
    """Modes over speed, and with `nonlinear` the runs that bracket the nonlinear critical speed.

    Args:
        case: the case.
        speeds_kmh: speeds of the table [km/h]; runs are made at those of them that are at least 20 km/h apart.
        nonlinear: whether runs are made.
        settings: of the runs.
        processes: runs at a time.
        progress: called with the fraction done and a short text.
    """
    report = progress or (lambda _fraction, _text: None)
    share = 0.1 if nonlinear else 1.0
    modes = stability(case, speeds_kmh, progress=lambda f, t: report(share * f, t))
    if not nonlinear or modes.attrs["interrupted"]:
        return StabilityStudy(case, modes, None)
    found = nonlinear_critical_speed(
        case,
        _coarse(speeds_kmh),
        settings,
        processes=processes,
        progress=lambda f, t: report(share + (1 - share) * f, t),
    )
    return StabilityStudy(case, modes, found)


def _coarse(speeds_kmh: Sequence[float], least_step: float = 20.0) -> list[float]:
    chosen = [float(speeds_kmh[0])]
    for speed in speeds_kmh[1:]:
        if speed - chosen[-1] >= least_step - 1e-9:
            chosen.append(float(speed))
    return chosen


def write_study(study: StabilityStudy, out: str | Path) -> list[Path]:
    """Write report.html, stability.nc, modes.csv, shapes.csv, runs.csv, summary.json and the figures.

    Raises:
        OutputError: a file could not be written.
    """
    folder = output_folder(out)
    figures = study_figures(study)
    written = [
        save_run(_merged(study), folder / "stability.nc"),
        write_rows(folder / "modes.csv", mode_rows(study.modes)),
        write_rows(folder / "shapes.csv", shape_rows(study.modes)),
        write_text(folder / "summary.json", json.dumps(summary(study), indent=2) + "\n"),
    ]
    if study.nonlinear is not None:
        written.append(write_rows(folder / "runs.csv", run_rows(study.nonlinear)))
    for name, image in figures.items():
        written.append(write_text(folder / f"{name}.svg", image.decode()))
    return [*written, write_text(folder / "report.html", render(report_page(study, figures)))]


def _merged(study: StabilityStudy) -> xr.Dataset:
    if study.nonlinear is None or not study.nonlinear.runs:
        return study.modes
    runs = hunting_table(study.nonlinear.runs, study.nonlinear.disturbance).rename(speed="run_speed")
    return study.modes.merge(runs, combine_attrs="drop_conflicts")


def study_figures(study: StabilityStudy) -> dict[str, bytes]:
    """Name -> SVG of each figure of the study."""
    table = None
    figures = {}
    if study.nonlinear is not None and study.nonlinear.runs:
        runs = study.nonlinear.runs
        table = hunting_table(runs, study.nonlinear.disturbance)
        label = f"from {1e3 * study.nonlinear.disturbance:g} mm"
        critical = {"linear": float(study.modes.attrs["linear_critical_speed_kmh"])}
        figures["amplitude"] = figure_bytes(amplitude_over_speed({label: table}, critical))
        chosen = _around(study.nonlinear)
        figures["runs"] = figure_bytes(hunting_over_time([(3.6 * r.speed, r.motion) for r in chosen], runs[0].body))
    return {
        "root_locus": figure_bytes(root_locus(study.modes)),
        "damping": figure_bytes(damping_over_speed(study.modes)),
        "frequency": figure_bytes(frequency_over_speed(study.modes, table)),
        **figures,
    }


def _around(found: NonlinearCriticalSpeed, count: int = 4) -> list[HuntingRun]:
    """Runs nearest to the onset, or spread over the range if there is none."""
    if not math.isfinite(found.speed):
        return found.runs[:: max(1, len(found.runs) // count)][:count]
    nearest = sorted(found.runs, key=lambda run: abs(run.speed - found.speed))[:count]
    return sorted(nearest, key=lambda run: run.speed)


def summary(study: StabilityStudy) -> dict[str, object]:
    """The numbers of the study under the keys of STABILITY_KEYS, and the keys themselves."""
    modes = study.modes
    result: dict[str, object] = {
        "case": study.case.name,
        "speeds_kmh": modes["speed"].to_numpy().round(9).tolist(),
        "linear_critical_speed_kmh": finite(modes.attrs["linear_critical_speed_kmh"]),
        "linear_critical_frequency_hz": finite(modes.attrs["linear_critical_frequency_hz"]),
        "linear_critical_mode": modes.attrs["linear_critical_mode"],
        "least_damping": modes["damping"].where(modes["frequency"] > 0.05).min("mode").to_numpy().tolist(),
        "interrupted": study.interrupted,
    }
    if study.nonlinear is not None:
        result["nonlinear"] = nonlinear_summary(study.nonlinear)
    return {**result, "rollerrig_version": __version__, "keys": STABILITY_KEYS}


def nonlinear_summary(found: NonlinearCriticalSpeed) -> dict[str, object]:
    """The runs and the bracket they give, for summary.json."""
    return {
        "disturbance_mm": 1e3 * found.disturbance,
        "dies_out_kmh": finite(3.6 * found.dies_out),
        "goes_on_kmh": finite(3.6 * found.goes_on),
        "runs": [
            {
                "speed_kmh": round(3.6 * run.speed, 6),
                "amplitude_mm": 1e3 * run.ending.amplitude,
                "frequency_hz": finite(run.ending.frequency),
                "growth_rate_at_end_per_s": finite(run.ending.rate),
                "goes_on": run.sustained,
                "status": run.motion.attrs["status"],
                "energy_relative_residual": run.motion.attrs["energy_relative_residual"],
            }
            for run in found.runs
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


def run_rows(found: NonlinearCriticalSpeed) -> list[list[object]]:
    """Table of the runs, header first."""
    header: list[object] = [
        "speed_kmh",
        "amplitude_mm",
        "frequency_hz",
        "growth_rate_at_end_per_s",
        "goes_on",
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
                int(run.sustained),
                run.motion.attrs["status"],
            ]
            for run in found.runs
        ),
    ]


# ---------------------------------------------------------------------------------------------------- report


def report_page(study: StabilityStudy, figures: dict[str, bytes]) -> Page:
    """The report of the study."""
    modes = study.modes
    sections = [
        Section(
            "Modes",
            [
                Figure(
                    figures["root_locus"],
                    "Eigenvalues over speed. Modes above 30 Hz and heavily damped ones are left out.",
                ),
                Figure(figures["damping"], "Damping ratio over speed; below zero a small disturbance grows."),
                Figure(figures["frequency"], "Frequency over speed."),
                mode_table(modes),
            ],
        ),
        Section("Mode shapes", [shape_text(), *shape_tables(modes)]),
    ]
    if study.nonlinear is not None:
        sections.append(nonlinear_section(study.nonlinear, figures))
    sections.append(
        Section(
            "Case",
            [
                Text(
                    "The rollers or rails are held at each speed; torques keep their value at time 0. The linear model is "
                    "exact for small motions around steady rolling; it knows neither flange contact nor saturation beyond "
                    "its slope."
                ),
                Preformatted("the whole configuration", str(modes.attrs["config_toml"])),
            ],
        )
    )
    return Page(f"Stability: {study.case.name}", lead(study), sections, f"rollerrig {__version__}")


def lead(study: StabilityStudy) -> str:
    """What came out, in a few sentences."""
    attributes, speeds = study.modes.attrs, study.modes["speed"].to_numpy()
    critical = float(attributes["linear_critical_speed_kmh"])
    if math.isfinite(critical):
        text = (
            f"Linear critical speed: {critical:.1f} km/h, {attributes['linear_critical_mode']}, "
            f"{attributes['linear_critical_frequency_hz']:.2f} Hz."
        )
    elif float(study.modes["growth_rate"].isel(speed=0).max()) > 0:
        text = f"Unstable already at {speeds[0]:g} km/h, the lowest speed looked at."
    else:
        where = f"between {speeds[0]:g} and {speeds[-1]:g} km/h" if len(speeds) > 1 else f"at {speeds[0]:g} km/h"
        text = f"No linear critical speed {where}: all oscillations are damped."
    if study.interrupted:
        text = f"Interrupted: what was computed until then.\n{text}"
    return text if study.nonlinear is None else f"{text}\n{nonlinear_sentence(study.nonlinear)}"


def nonlinear_sentence(found: NonlinearCriticalSpeed) -> str:
    """The bracket of the nonlinear critical speed as a sentence."""
    size = f"A lateral offset of {1e3 * found.disturbance:g} mm of the leading wheelset"
    if not found.runs:
        return f"{size}: no run was finished."
    if math.isfinite(found.speed):
        return f"{size} dies out at {3.6 * found.dies_out:.1f} km/h and goes on at {3.6 * found.goes_on:.1f} km/h."
    if math.isfinite(found.goes_on):
        return f"{size} goes on already at {3.6 * found.goes_on:.1f} km/h, the lowest speed run."
    return f"{size} dies out at all speeds run, up to {3.6 * found.dies_out:.1f} km/h."


def mode_table(modes: xr.Dataset) -> Table:
    """Frequency and damping of the modes shown, at the lowest, a middle and the highest speed."""
    picks = sorted({0, modes.sizes["speed"] // 2, modes.sizes["speed"] - 1})
    header = ["mode"] + [f"{modes['speed'][k]:g} km/h: f [Hz], damping [%]" for k in picks]
    rows = []
    for name in shown_modes(modes):
        one = modes.sel(mode=name)
        cells = [f"{float(one['frequency'][k]):.2f},  {100 * float(one['damping'][k]):.1f}" for k in picks]
        rows.append([name, *cells])
    return Table(header, rows, "Frequency and damping; all modes at all speeds are in modes.csv.")


def shape_text() -> Text:
    """What the shapes' numbers mean."""
    return Text(
        "Displacement amplitudes in m and rad, scaled so that the largest is 1, and phase in degrees; at the speed nearest to "
        "the linear critical one, or the highest. Parts below 0.02 are left out."
    )


def shape_tables(modes: xr.Dataset) -> list[Table]:
    """One table per mode shown."""
    critical = float(modes.attrs["linear_critical_speed_kmh"])
    speed = modes["speed"].to_numpy()
    k = int(np.argmin(np.abs(speed - critical))) if math.isfinite(critical) else len(speed) - 1
    at = modes.isel(speed=k)
    names = sorted(shown_modes(modes), key=lambda name: not name.startswith("hunting"))
    tables = []
    for name in names:
        amplitude, phase = at["shape_amplitude"].sel(mode=name), at["shape_phase"].sel(mode=name)
        rows = []
        for body in at["body"].to_numpy():
            cells = []
            for direction in at["direction"].to_numpy():
                a, p = (float(v.sel(body=body, direction=direction)) for v in (amplitude, phase))
                cells.append(f"{a:.2f} ∠ {round(p):d}°" if a >= 0.02 else "")
            rows.append([str(body), *cells])
        caption = f"{name}, {float(at['frequency'].sel(mode=name)):.2f} Hz at {speed[k]:g} km/h"
        tables.append(Table(["body", *map(str, at["direction"].to_numpy())], rows, caption))
    return tables


RUN_HEADER = (
    "speed [km/h]",
    "amplitude at the end [mm]",
    "frequency [Hz]",
    "growth rate at the end [1/s]",
    "goes on",
    "how the run ended",
)


def nonlinear_section(found: NonlinearCriticalSpeed, figures: dict[str, bytes]) -> Section:
    """Runs from a disturbance."""
    blocks: list[Text | Figure | Table | Preformatted] = [Text(nonlinear_sentence(found))]
    if found.runs:
        blocks += [
            Figure(figures["amplitude"], "Amplitude at the end of each run; open markers: the disturbance dies out."),
            Figure(figures["runs"], "Lateral displacement over time at the speeds nearest to the onset."),
            Table(
                RUN_HEADER, [[*row[:4], "yes" if row[4] else "no", row[5]] for row in run_rows(found)[1:]], "All runs."
            ),
        ]
    return Section("Runs from a disturbance", blocks)
