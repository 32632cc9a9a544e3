"""The stability of one case: modes over speed, limit cycles, critical speeds.

Case, speeds -> [StabilityStudy] -> stability.nc, tables of modes, shapes and limit cycles, report
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from rollerrig.analysis import Diagram, LimitCycleSettings, limit_cycle_table, limit_cycles, stability
from rollerrig.analysis.limit_cycle import KIND_SENTENCES, CyclePoint
from rollerrig.config import Case
from rollerrig.plot import damping_map, damping_over_speed, frequency_over_speed, limit_cycle_diagram, root_locus
from rollerrig.study import contact_effects
from rollerrig.study.contact_effects import ContactEffect
from rollerrig.study.frame import Study
from rollerrig.study.jobs import Done, Progress, Round, job
from rollerrig.study.mode_tables import mode_rows, mode_table, shape_blocks, shape_rows
from rollerrig.study.quantities import Numbers, Quantities, Quantity
from rollerrig.study.report import Block, Picture, Section, Text

MOST_CYCLE_SPEEDS = 20
"""Runs are made at no more speeds than this, spread over the range."""

POINT = "limit_cycles.points.*"
POINTS = (
    Quantity(
        f"{POINT}.sweep", "up: from a small perturbation at each speed; down: from the limit cycle of the speed before"
    ),
    Quantity(f"{POINT}.speed_kmh", "of the run", "km/h", "speed", 5),
    Quantity(f"{POINT}.amplitude_mm", "half the range of the wheelset that moves most; 0: rest", "mm", "amplitude"),
    Quantity(f"{POINT}.peak_mm", "its largest displacement", "mm", "peak"),
    Quantity(f"{POINT}.frequency_hz", "of the limit cycle", "Hz", "frequency", 3),
    Quantity(f"{POINT}.guiding_force_n", "largest |Y|, unfiltered", "N", "largest |Y|", 3, ("kN", 1e-3)),
    Quantity(f"{POINT}.growth_rate_at_end_per_s", "of the amplitude", "1/s", "growth rate at the end", 2),
    Quantity(f"{POINT}.settled", "whether the amplitude has settled"),
    Quantity(f"{POINT}.duration_s", "simulated", "s", "time", 3),
    Quantity(f"{POINT}.status", "how the run ended"),
)
QUANTITIES = Quantities(
    Quantity("case", "name of the case"),
    Quantity("speeds_kmh", "speeds of the table of modes", "km/h"),
    Quantity("linear_critical_speed_kmh", "lowest speed at which an oscillation begins to grow; null: none in the range", "km/h"),
    Quantity("linear_critical_frequency_hz", "its frequency", "Hz"),
    Quantity("linear_critical_mode", "its name"),
    Quantity("crossings", "empty: no oscillation begins or ends to grow"),
    Quantity("crossings.*.speed_kmh", "at which the growth rate of an oscillation changes its sign", "km/h", "speed", 5),
    Quantity("crossings.*.frequency_hz", "of the oscillation", "Hz", "frequency"),
    Quantity("crossings.*.mode", "its name"),
    Quantity("crossings.*.grows", "on which side it grows"),
    Quantity("grows_at_lowest_speed", "names of the oscillations that grow already at the lowest speed"),
    Quantity("diverging", "empty: no motion grows without oscillating"),
    Quantity("diverging.*.name", "motion that grows without oscillating"),
    Quantity("diverging.*.growth_rate_per_s", "its largest growth rate", "1/s"),
    Quantity("diverging.*.speed_kmh", "where it is reached", "km/h"),
    Quantity("least_damping", "per speed, the smallest damping ratio of all oscillatory modes", "1"),
    Quantity("limit_cycles.bifurcation", "none, subcritical, supercritical, detached, or unstable throughout"),
    Quantity("limit_cycles.critical_speed_by_continuation_kmh", "lowest speed with a lasting limit cycle; null: none", "km/h"),
    Quantity("limit_cycles.decays_kmh", "highest speed below it at which every motion comes to rest", "km/h"),
    Quantity("limit_cycles.jump_up_kmh", "lowest speed run at which the perturbation grows into a limit cycle", "km/h"),
    Quantity("limit_cycles.hysteresis_kmh", "lowest and highest speed at which the sweeps end differently; null: none", "km/h"),
    Quantity("limit_cycles.tolerance_kmh", "to which the critical speed by continuation was looked for", "km/h"),
    Quantity("limit_cycles.disturbance_mm", "lateral offset of the leading wheelset at the start of the downward sweep", "mm"),
    Quantity("limit_cycles.perturbation_mm", "the same on the upward sweep", "mm"),
    POINTS,
    contact_effects.QUANTITIES,
)  # fmt: skip


@dataclass(frozen=True)
class Results:
    """Modes over speed, limit-cycle diagram, effects of the contact models; None and empty where not asked for."""

    modes: xr.Dataset
    diagram: Diagram | None
    contact: tuple[ContactEffect, ...]


@dataclass(frozen=True)
class StabilityStudy(Study[Results]):
    """Modes over speed, and the limit-cycle diagram.

    Attributes:
        case: the case.
        speeds_kmh: speeds of the table [km/h]; runs are made at no more than MOST_CYCLE_SPEEDS of them.
        with_limit_cycles: whether runs are made.
        settings: of the runs.
        contacts_kmh: also compare the contact models, with runs at this speed [km/h].
        processes: with 2, the upward and the downward sweep run at a time.
    """

    case: Case
    speeds_kmh: tuple[float, ...]
    with_limit_cycles: bool = True
    settings: LimitCycleSettings = field(default_factory=LimitCycleSettings)
    contacts_kmh: float | None = None
    processes: int = 1

    command = "stability"
    quantities = QUANTITIES
    formats = ("svg",)
    irrelevant = ("description", "processes")

    @property
    def title(self) -> str:
        return f"Stability: {self.case.name}"

    @property
    def round_ends(self) -> tuple[float, ...]:  # type: ignore[override]
        """The modes take a tenth of the runs."""
        return (0.1, 1.0) if self.with_limit_cycles else (1.0,)

    def rounds(self, done: Done) -> Iterator[Round]:
        yield {"modes": job(stability, self.case, self.speeds_kmh)}
        if self.with_limit_cycles:
            linear = float(done["modes"].attrs["linear_critical_speed_kmh"])
            yield {"limit cycles": job(diagram_of, self, linear)}
        if self.contacts_kmh is not None:
            yield contact_effects.contact_effect_jobs(self.case, self.speeds_kmh, self.contacts_kmh)

    def collect(self, done: Done) -> Results | None:
        contact = tuple(result for result in done.values() if isinstance(result, ContactEffect))
        return Results(done["modes"], done.get("limit cycles"), contact) if "modes" in done else None

    def limitations(self) -> list[str]:
        return [
            "The linear model is exact for small motions around steady rolling; it includes neither flange contact nor "
            "saturation beyond its slope.",
            "Rollers or rails are speed-controlled at each speed; torques keep their value at time 0.",
            *super().limitations(),
        ]

    # --------------------------------------------------------------------------------------------------- numbers

    def numbers(self, results: Results) -> dict[str, Any]:
        attributes = results.modes.attrs
        oscillates = results.modes["frequency"] > 0.05
        found = {
            "case": self.case.name,
            "speeds_kmh": results.modes["speed"].to_numpy().round(9),
            **{key: attributes[key] for key in ("linear_critical_speed_kmh", "linear_critical_frequency_hz")},
            "linear_critical_mode": attributes["linear_critical_mode"],
            **{key: json.loads(attributes[key]) for key in ("crossings", "grows_at_lowest_speed", "diverging")},
            "least_damping": results.modes["damping"].where(oscillates).min("mode").to_numpy(),
        }
        if results.diagram is not None:
            found["limit_cycles"] = cycle_numbers(results.diagram, self.settings)
        if results.contact:
            found["contact_effects"] = [asdict(one) for one in results.contact]
        return found

    def summary(self, results: Results, numbers: Numbers) -> list[str]:
        speeds, critical, lines = numbers["speeds_kmh"], numbers["linear_critical_speed_kmh"], []
        growing = numbers["grows_at_lowest_speed"]
        if growing:
            lines.append(f"Unstable already at {speeds[0]:g} km/h, the lowest speed: {', '.join(growing)}.")
        if critical is not None:
            mode, frequency = numbers["linear_critical_mode"], numbers["linear_critical_frequency_hz"]
            lines.append(f"Linear critical speed: {critical:.1f} km/h, {mode}, {frequency:.2f} Hz.")
        elif not growing:
            where = f"between {speeds[0]:g} and {speeds[-1]:g} km/h" if len(speeds) > 1 else f"at {speeds[0]:g} km/h"
            lines.append(f"No linear critical speed {where}: all oscillations are damped.")
        lines += [
            f"{one['name'].capitalize()} grows without oscillating, at up to {one['growth_rate_per_s']:.2g} 1/s: the "
            "vehicle is not restrained; on rollers it needs a longitudinal restraint, e.g. locked = ['x'] for its car body."
            for one in numbers["diverging"]
        ]
        return lines if results.diagram is None else [*lines, continuation_sentence(results.diagram)]

    def files(self, results: Results, numbers: Numbers) -> Mapping[str, Any]:
        modes, data = results.modes, results.modes
        if results.diagram is not None:
            data = modes.merge(limit_cycle_table(results.diagram), combine_attrs="drop_conflicts")
        found = {"stability.nc": data, "modes.csv": mode_rows(modes), "shapes.csv": shape_rows(modes)}
        if results.diagram is not None:
            points = numbers["limit_cycles"]["points"]
            found["limit_cycles.csv"] = QUANTITIES.csv(points, [quantity.key for quantity in POINTS])
        if results.contact:
            names = [quantity.key for quantity in contact_effects.QUANTITIES]
            found["contact_effects.csv"] = QUANTITIES.csv(numbers["contact_effects"], names)
        return found

    # ---------------------------------------------------------------------------------------------------- report

    def sections(self, results: Results, numbers: Numbers) -> list[Section]:
        cycles = None if results.diagram is None else limit_cycle_table(results.diagram)
        found = [Section("Modes", self._modes(results.modes, cycles, numbers))]
        if results.diagram is not None and cycles is not None:
            found.append(Section("Limit cycles", self._cycles(results, cycles, numbers)))
        found.append(Section("Mode shapes", shape_blocks(results.modes)))
        if results.contact:
            text = (
                "The same vehicle with each normal contact and creep law. The limit cycle is the end of a run from a "
                f"lateral offset of {1e3 * contact_effects.SETTINGS.disturbance:g} mm of the leading wheelset."
            )
            names = [quantity.key for quantity in contact_effects.QUANTITIES]
            table = QUANTITIES.table(numbers["contact_effects"], names)
            found.append(Section("Effect of the contact model", [Text(text), table]))
        return found

    def _modes(self, modes: xr.Dataset, cycles: xr.Dataset | None, numbers: Numbers) -> list[Block]:
        drawn = (
            ("frequency", frequency_over_speed(modes, cycles), "Frequency over speed, without heavily damped modes."),
            ("damping", damping_over_speed(modes), "Damping ratio over speed; below zero a small disturbance grows."),
            ("damping_map", damping_map(modes), "Damping of all oscillatory modes, with their frequency at the highest speed."),
            ("root_locus", root_locus(modes), "Root locus: eigenvalues over speed, the modes of the first figure."),
        )  # fmt: skip
        names = ["crossings.*.speed_kmh", "mode", "crossings.*.frequency_hz", "grows"]
        found = numbers["crossings"]
        caption = f"{'Speeds at which an' if found else 'No'} oscillation begins or ends to grow."
        return [*(Picture(*one) for one in drawn), QUANTITIES.table(found, names, caption), mode_table(modes)]

    def _cycles(self, results: Results, cycles: xr.Dataset, numbers: Numbers) -> list[Block]:
        assert results.diagram is not None
        blocks: list[Block] = [Text(continuation_sentence(results.diagram))]
        if cycles.sizes["cycle_point"]:
            caption = (
                "What each run ends in, with the speed stepped up and stepped down. Amplitude: half the range of the lateral "
                "displacement of the wheelset that moves most. |Y|: unfiltered; where flanges strike rigid rails it is short and "
                "very high."
            )
            blocks.append(Picture("limit_cycles", limit_cycle_diagram(cycles, results.modes), caption))
        method = (
            f"Way up: from a lateral offset of the leading wheelset of {1e3 * self.settings.perturbation:g} mm until a limit "
            f"cycle is reached. Way down: from {1e3 * self.settings.disturbance:g} mm at the highest speed, then from the "
            "limit cycle of the speed above; where that has decayed, from the same offset again. Each run lasts until its "
            f"amplitude has settled, or {self.settings.longest:g} s. The perturbation need not grow or decay as the linear "
            "model predicts: that is exact only as long as the contact stays on the smooth piece of the profiles around its "
            "position, often less than a tenth of a millimetre."
        )
        points = QUANTITIES.table(numbers["limit_cycles"]["points"], [quantity.key for quantity in POINTS], "All runs.")
        return [*blocks, Text(method), points]


def diagram_of(study: StabilityStudy, linear_kmh: float, progress: Progress | None = None) -> Diagram:
    """The limit-cycle diagram of a study; after Ctrl-C what was done until then."""
    speeds = cycle_speeds(study.speeds_kmh)
    return limit_cycles(study.case, speeds, linear_kmh, study.settings, processes=study.processes, progress=progress)


def cycle_speeds(speeds_kmh: tuple[float, ...]) -> list[float]:
    """Speeds at which runs are made: the first, the last and at most 18 between them, as even as the list allows."""
    count = min(len(speeds_kmh), MOST_CYCLE_SPEEDS)
    picks = np.unique(np.round(np.linspace(0, len(speeds_kmh) - 1, count)).astype(int))
    return [float(speeds_kmh[k]) for k in picks]


def cycle_numbers(found: Diagram, settings: LimitCycleSettings) -> dict[str, Any]:
    """The diagram and what follows from it."""
    sweeps: tuple[tuple[str, list[CyclePoint]], ...] = (("up", found.up), ("down", found.down))
    return {
        "bifurcation": found.kind,
        "critical_speed_by_continuation_kmh": 3.6 * found.lowest_cycle,
        "decays_kmh": 3.6 * found.decays,
        "jump_up_kmh": 3.6 * found.jumps,
        "hysteresis_kmh": None if found.hysteresis is None else [3.6 * v for v in found.hysteresis],
        "tolerance_kmh": settings.tolerance_kmh,
        "disturbance_mm": 1e3 * settings.disturbance,
        "perturbation_mm": 1e3 * settings.perturbation,
        "points": [
            {
                "sweep": sweep,
                "speed_kmh": round(3.6 * point.speed, 6),
                "amplitude_mm": 1e3 * point.amplitude,
                "peak_mm": 1e3 * point.peak,
                "frequency_hz": point.frequency,
                "guiding_force_n": point.guiding_force,
                "growth_rate_at_end_per_s": point.rate,
                "settled": point.settled,
                "duration_s": point.duration,
                "status": point.status,
            }
            for sweep, points in sweeps
            for point in points
        ],
    }


def continuation_sentence(found: Diagram) -> str:
    """The critical speed by continuation and the kind of bifurcation."""
    if not found.up and not found.down:
        return "Limit cycles: no run was finished."
    if not math.isfinite(found.lowest_cycle):
        highest = max(p.speed for p in [*found.up, *found.down])
        return f"No limit cycle up to {3.6 * highest:.1f} km/h: every disturbance decays."
    text = f"Critical speed by continuation: {3.6 * found.lowest_cycle:.1f} km/h, the lowest with a limit cycle"
    rest = (
        f"; at {3.6 * found.decays:.1f} km/h every motion comes to rest"
        if math.isfinite(found.decays)
        else " and the lowest run"
    )
    text += f"{rest}. {KIND_SENTENCES[found.kind]}"
    if found.hysteresis is not None:
        low, high = (f"{3.6 * v:.1f}" for v in found.hysteresis)
        where = f"At {low} km/h" if low == high else f"From {low} to {high} km/h"
        text += f" {where} the upward and the downward sweep end differently."
    return text
