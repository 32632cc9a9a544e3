"""The report of the stability study.

modes, limit cycles, figures -> [report_page] -> Page
"""

from __future__ import annotations

import json
import math

import numpy as np
import xarray as xr

from rollerrig import __version__
from rollerrig.analysis import Diagram, LimitCycleSettings
from rollerrig.analysis.limit_cycle import KIND_SENTENCES
from rollerrig.plot.modes import shown_modes
from rollerrig.report import Figure, Page, Preformatted, Section, Table, Text

Block = Text | Figure | Table | Preformatted

SUSPENSION_WORDS = ("car body", "bogie", "bogies", "front bogie", "rear bogie")
"""How the names of those modes begin whose shapes are drawn together."""


def report_page(
    name: str,
    modes: xr.Dataset,
    found: Diagram | None,
    cycles: xr.Dataset | None,
    settings: LimitCycleSettings,
    figures: dict[str, bytes],
) -> Page:
    """The report of the study.

    Args:
        name: of the case.
        modes: Dataset of `stability`.
        found: the limit-cycle diagram; None if it was not asked for.
        cycles: the same as a Dataset of `limit_cycle_table`.
        settings: of its runs.
        figures: name -> SVG.
    """
    sections = [modes_section(modes, figures)]
    if found is not None and cycles is not None:
        sections.append(cycles_section(found, cycles, settings, figures))
    sections += [shapes_section(modes, figures), case_section(modes)]
    return Page(f"Stability: {name}", lead(modes, found), sections, f"rollerrig {__version__}")


def lead(modes: xr.Dataset, found: Diagram | None) -> str:
    """What came out, in a few sentences."""
    attributes, speeds = modes.attrs, modes["speed"].to_numpy()
    critical = float(attributes["linear_critical_speed_kmh"])
    growing, diverging = json.loads(attributes["grows_at_lowest_speed"]), json.loads(attributes["diverging"])
    lines = []
    if attributes["interrupted"] or (found is not None and found.interrupted):
        lines.append("Interrupted: what was computed until then.")
    if growing:
        lines.append(f"Unstable already at {speeds[0]:g} km/h, the lowest speed looked at: {', '.join(growing)}.")
    if math.isfinite(critical):
        lines.append(
            f"Linear critical speed: {critical:.1f} km/h, {attributes['linear_critical_mode']}, "
            f"{attributes['linear_critical_frequency_hz']:.2f} Hz."
        )
    elif not growing:
        where = f"between {speeds[0]:g} and {speeds[-1]:g} km/h" if len(speeds) > 1 else f"at {speeds[0]:g} km/h"
        lines.append(f"No linear critical speed {where}: all oscillations are damped.")
    for one in diverging:
        lines.append(
            f"{one['name'].capitalize()} grows without oscillating, at up to {one['growth_rate_per_s']:.2g} 1/s: nothing holds "
            "the vehicle there; on rollers it needs a hold along the track, e.g. locked = ['x'] for its car body."
        )
    if found is not None:
        lines.append(continuation_sentence(found))
    return "\n".join(lines)


def continuation_sentence(found: Diagram) -> str:
    """The critical speed by continuation and the kind of bifurcation as a sentence."""
    if not found.up and not found.down:
        return "Limit cycles: no run was finished."
    if not math.isfinite(found.lowest_cycle):
        highest = max(p.speed for p in [*found.up, *found.down])
        return f"No limit cycle up to {3.6 * highest:.1f} km/h: every disturbance dies out."
    text = f"Critical speed by continuation: {3.6 * found.lowest_cycle:.1f} km/h, the lowest with a limit cycle"
    if math.isfinite(found.decays):
        text += f"; at {3.6 * found.decays:.1f} km/h everything comes to rest"
    else:
        text += " and the lowest run"
    text += f". {KIND_SENTENCES[found.kind]}"
    if found.hysteresis is not None:
        low, high = (f"{3.6 * v:.1f}" for v in found.hysteresis)
        where = f"at {low} km/h" if low == high else f"from {low} to {high} km/h"
        text += f" {where.capitalize()} the way up and the way down end differently."
    return text


def modes_section(modes: xr.Dataset, figures: dict[str, bytes]) -> Section:
    """Frequency, damping, root locus, crossings."""
    blocks: list[Block] = [
        Figure(figures["frequency"], "Frequency over speed. Modes above 30 Hz and heavily damped ones are left out."),
        Figure(figures["damping"], "Damping ratio over speed; below zero a small disturbance grows."),
        Figure(
            figures["damping_map"], "Damping of all oscillatory modes; in brackets the frequency at the highest speed."
        ),
        Figure(figures["root_locus"], "Root locus: eigenvalues over speed, the modes of the first figure."),
        crossing_table(modes),
        mode_table(modes),
    ]
    return Section("Modes", blocks)


def crossing_table(modes: xr.Dataset) -> Table:
    """All speeds at which an oscillation begins or ends to grow."""
    crossings = json.loads(modes.attrs["crossings"])
    rows = [[f"{c['speed_kmh']:.2f}", c["mode"], f"{c['frequency_hz']:.3f}", c["grows"]] for c in crossings]
    caption = (
        "Speeds at which an oscillation begins or ends to grow." if rows else "No oscillation begins or ends to grow."
    )
    return Table(["speed [km/h]", "mode", "frequency [Hz]", "grows"], rows, caption)


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


def shape_tables(modes: xr.Dataset) -> list[Table]:
    """One table per mode shown."""
    at = modes.sel(speed=shape_speed(modes))
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
        caption = f"{name}, {float(at['frequency'].sel(mode=name)):.2f} Hz at {float(at['speed']):g} km/h"
        tables.append(Table(["body", *map(str, at["direction"].to_numpy())], rows, caption))
    return tables


def shape_speed(modes: xr.Dataset) -> float:
    """Speed of the table at which shapes are shown: the nearest to the linear critical one, else the highest [km/h]."""
    critical, speed = float(modes.attrs["linear_critical_speed_kmh"]), modes["speed"].to_numpy()
    return float(speed[np.argmin(np.abs(speed - critical))] if math.isfinite(critical) else speed[-1])


def suspension_modes(modes: xr.Dataset) -> list[str]:
    """Modes of car body and bogies on their springs that are worth a picture."""
    return [name for name in shown_modes(modes) if name.startswith(SUSPENSION_WORDS)]


def shapes_section(modes: xr.Dataset, figures: dict[str, bytes]) -> Section:
    """Pictures and tables of the mode shapes."""
    at = f"at {shape_speed(modes):g} km/h, the speed of the table nearest to the linear critical one, or the highest"
    blocks: list[Block] = [
        Text(
            f"All {at}. Displacements are not to scale; outlines are schematic: wheelsets red, bogies blue, car body green, "
            "dashed in their design position. x points forward, y to the left."
        )
    ]
    critical = modes.attrs["linear_critical_mode"] or modes.attrs["hunting_mode"]
    if "critical_mode" in figures:
        blocks.append(Figure(figures["critical_mode"], f"The mode '{critical}', from above and from behind."))
    if "mode_shapes" in figures:
        blocks.append(
            Figure(figures["mode_shapes"], "Modes of the suspension, each in the view that shows most of it.")
        )
    blocks.append(
        Text(
            "In the tables: displacement amplitudes in m and rad, scaled so that the largest is 1, and phase in degrees. Parts "
            "below 0.02 are left out. All modes at all speeds are in shapes.csv."
        )
    )
    return Section("Mode shapes", [*blocks, *shape_tables(modes)])


def cycles_section(
    found: Diagram, cycles: xr.Dataset, settings: LimitCycleSettings, figures: dict[str, bytes]
) -> Section:
    """The limit-cycle diagram."""
    blocks: list[Block] = [Text(continuation_sentence(found))]
    if "limit_cycles" in figures:
        blocks.append(
            Figure(
                figures["limit_cycles"],
                "What is left at each speed, stepped up and stepped down with the state carried over. Amplitude: half the "
                "range of the lateral displacement of the wheelset that moves most. |Y|: unfiltered; where flanges strike "
                "rigid rails it is short and very high.",
            )
        )
    blocks.append(
        Text(
            f"Way up: from a lateral offset of the leading wheelset of {1e3 * settings.perturbation:g} mm until a limit cycle is "
            f"reached. Way down: from {1e3 * settings.disturbance:g} mm at the highest speed, then from the limit cycle of the "
            "speed above; where that has died out, from the same offset again. Each run lasts until its amplitude has come "
            f"to stay, or {settings.longest:g} s. The perturbation need not follow the linear model, which is exact only as long "
            "as the contact stays on the smooth piece of the profiles around its place, often less than a tenth of a "
            "millimetre."
        )
    )
    return Section("Limit cycles", [*blocks, cycle_table(cycles)])


def cycle_table(cycles: xr.Dataset) -> Table:
    """All runs of the diagram."""
    header = [
        "way",
        "speed [km/h]",
        "amplitude [mm]",
        "peak [mm]",
        "frequency [Hz]",
        "largest |Y| [kN]",
        "time [s]",
        "ends",
    ]
    rows: list[list[object]] = []
    for k in range(cycles.sizes["cycle_point"]):
        one = cycles.isel(cycle_point=k)
        number = {name: float(one[f"cycle_{name}"]) for name in ("speed", "amplitude", "peak", "frequency", "duration")}
        status, force = str(one["cycle_status"].item()), float(one["cycle_guiding_force"])
        settled = "settled" if float(one["cycle_settled"]) else "not settled"
        ends = status.replace("_", " ") if status != "ok" else settled if number["amplitude"] > 0 else "rest"
        cells = [number["speed"], 1e3 * number["amplitude"], 1e3 * number["peak"], number["frequency"], 1e-3 * force]
        digits = (2, 3, 3, 2, 1)
        shown = [f"{v:.{n}f}" if math.isfinite(v) else "" for v, n in zip(cells, digits, strict=True)]
        rows.append([str(one["cycle_way"].item()), *shown, f"{number['duration']:.1f}", ends])
    return Table(header, rows, "All runs.")


def case_section(modes: xr.Dataset) -> Section:
    """What was computed, with the whole configuration."""
    return Section(
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
