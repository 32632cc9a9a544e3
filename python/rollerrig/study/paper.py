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

from rollerrig.analysis import end_of_hunting, hunting_table
from rollerrig.analysis.signals import fit
from rollerrig.analysis.traction import asymmetry, sliding_course
from rollerrig.common.formatting import number, percent
from rollerrig.config import Case, Rig
from rollerrig.plot import amplitude_over_speed, hunting_over_time, ramp_over_speed, traction_forces, traction_sliding
from rollerrig.plot.modes import hunting_frequencies
from rollerrig.study import critical_speeds as speeds
from rollerrig.study.assessment import NOT_DECIDED, Interval, check_table, counts_text
from rollerrig.study.contact_models import sensitivity_table
from rollerrig.study.frame import Study, dataset_rows
from rollerrig.study.jobs import Done, Round
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import VIEW, Block, Mark, Picture, Section, Table, Text
from rollerrig.study.run import audit_tables
from rollerrig.study.runs.paper import (
    EXACT,
    FRONT,
    FULL,
    MATERIALS,
    NAMES,
    OWN,
    REAR,
    RIG,
    RUN_COLUMNS,
    TABLE_PARTS,
    VARIANTS,
    VEHICLE,
    PaperPlan,
    Results,
    around_onset,
    frequency_rows,
    numbers_of,
    results_of,
    rig_case,
    rounds,
    traction_case,
    traction_columns,
)

TEXT = tomllib.loads(files("rollerrig.study").joinpath("paper.toml").read_text(encoding="utf-8"))
CAPTIONS: Mapping[str, str] = TEXT["captions"]
"""Picture -> what it shows."""

NAMELESS: str = TEXT["nameless"]
PAPER: str = TEXT["paper"]
CRITICAL_KMH, NEAR = 100.0, 0.1
"""Speed above which the paper's figure 7a grows [km/h]; a critical speed within this share of it fits it [1]."""


@dataclass(frozen=True)
class PaperStudy(Study[Results]):
    """Both studies of the paper."""

    chosen: PaperPlan = FULL

    command = "paper"
    writes = ("data/*.nc", "data/*.csv", VIEW)
    formats = ("svg", "png")
    round_ends = (0.2, 0.8)
    assumes = (TEXT["limitation"],)

    heading = "Malvezzi, Meli and Pugi (2010): critical speed and traction of a bogie on a roller rig"

    @property
    def mark(self) -> Mark | None:
        return self.chosen.mark

    def cases(self) -> Mapping[str, Case]:
        return {"figure 7 (steel)": rig_case("steel"), "figure 8": traction_case(self.chosen)}

    def rounds(self, done: Done) -> Iterator[Round]:
        return rounds(self.chosen, done)

    def collect(self, done: Done) -> Results | None:
        return results_of(self.chosen, done)

    def sources(self, results: Results) -> Mapping[str, str]:
        return {"paper": PAPER.replace("Pugi, Sim", "Pugi: Sim").removesuffix(".")}

    def numbers(self, results: Results) -> dict[str, Any]:
        return numbers_of(results)

    def summary(self, results: Results, numbers: Numbers) -> list[str]:
        size = 1e3 * self.chosen.hunting.disturbance
        lines = [
            f"{NAMES[m].capitalize()}: critical speed on the rig, linear: {self._linear(results.linear_kmh(m))}; by disturbance "
            f"(from {size:g} mm): {results.by_disturbance(m).text('km/h', 1)}."
            for m in results.modes
        ]
        lines += _contact_sentences(results)
        by = [one for variant in (RIG, VEHICLE) for one in results.runs_of(variant).values()]
        lines += [sentence for one in by if (sentence := speeds.ended_early_sentence(one))]
        end = numbers["traction"]
        if end is not None:
            front, rear = (end[wheel]["sliding_mmps"] for wheel in (FRONT, REAR))
            lines.append(TEXT["traction_end"].format(front=front, rear=rear, speed=end["speed_kmh"]))
        return [*lines, counts_text(results.checks)] if results.checks else lines

    def _linear(self, value: float) -> str:
        """A linear critical speed [km/h] as text; where there is none, the range that was looked at."""
        if math.isfinite(value):
            return f"{value:z.1f} km/h"
        return f"none from {self.chosen.linear_kmh[0]:g} to {self.chosen.linear_kmh[-1]:g} km/h"

    def files(self, results: Results, numbers: Numbers) -> Mapping[str, Any]:
        found: dict[str, Any] = {}
        for m, variants in results.modes.items():
            found |= {f"data/modes_{m}_{variant.replace(' ', '_')}.nc": modes for variant, modes in variants.items()}
        found |= {f"data/ramp_{m}.nc": ramp for m, ramp in results.ramps.items()}
        for m, one in results.runs_of(RIG).items():
            found |= {f"data/run_{m}_{3.6 * run.speed:.2f}_kmh.nc": run.motion for run in one.runs}
        for variant, name in ((RIG, "figure_7_runs"), (VEHICLE, "figure_7b_vehicle_runs")):
            for m, one in results.runs_of(variant).items():
                table = hunting_table(one.runs, one.disturbance)
                found[f"data/{name}_{m}.csv"] = dataset_rows(table, RUN_COLUMNS, "speed")
        if results.modes:
            found["data/figure_7b_linear.csv"] = frequency_rows(results)
        if results.traction is not None and results.theory is not None:
            found["data/traction.nc"] = results.traction
            found["data/figure_8.csv"] = traction_columns(results.theory)
        return found

    def shown(self, results: Results) -> Mapping[str, xr.Dataset]:
        run = results.traction
        return {} if run is None else {"the bogie on free rollers under traction, figure 8": run}

    # ---------------------------------------------------------------------------------------------------- report

    def sections(self, results: Results, numbers: Numbers) -> list[Section]:
        drawn = {name: Picture(name, figure, CAPTIONS[name]) for name, figure in _figures(results).items()}

        def pictures(*names: str) -> list[Block]:
            return [drawn[name] for name in names if name in drawn] or [Text("Not computed.")]

        ramp = self.chosen.ramps[MATERIALS[0]]
        every, rate = (round(3.6 * value, 6) for value in (ramp.perturbation_every, ramp.acceleration))
        stability: list[Block] = [
            *self._critical_table(results),
            *map(Text, [*_contact_sentences(results), *_critical_paragraphs(results)]),
            Text(TEXT["ramp"].format(every=every, perturbation=1e3 * ramp.perturbation, rate=rate)),
            *pictures("figure_7a_ramp"),
            Text(TEXT["constant_speed"]),
            *pictures("figure_7a_time_steel", "figure_7a_time_paper", "figure_7a_amplitude"),
            *map(Text, self._frequency_paragraphs(results)),
            *pictures("figure_7b_steel", "figure_7b_paper"),
        ]
        rig: list[Block] = [
            *map(Text, _rig_paragraphs(results)),
            *(speeds.radius_table(one, TEXT["radii"].format(NAMES[m])) for m, one in results.over_radius.items()),
            *pictures("radius_steel", "radius_paper"),
            *(speeds.effects_table(one, TEXT["effects"].format(NAMES[m])) for m, one in results.effects.items()),
            *pictures("roller_effects"),
        ]
        checks: list[Block] = [Text(counts_text(results.checks)), check_table(results.checks)]
        return [
            self._compared(results, numbers),
            Section("Figure 7: stability", stability),
            Section("What the rig changes", rig),
            Section("Which material fits the paper", self._fit_blocks(results, numbers)),
            Section("Figure 8: traction", [Text(TEXT["traction"]), *pictures("figure_8a", "figure_8b")]),
            Section("Checks", checks if results.checks else [Text("No checks.")]),
            Section("Solver and contact", audit_tables(_audited(results)), folded=True),
            Section("Parameters", self._parameters(), folded=True),
        ]

    def _compared(self, results: Results, numbers: Numbers) -> Section:
        """What the paper says, what is found here, and why they differ."""
        rows = [*self._critical_rows(results), *_rig_and_rails(results), *_figure_8_rows(results)]
        header = ("of", "paper", "here", "why they differ")
        table = Table(header, rows, "Statements of the paper beside what is computed here; nothing was tuned.")
        found: list[Block] = [table, Text(TEXT["not_read"])] if rows else [Text("Not computed.")]
        return Section("The paper and this computation", [Text(f"The paper: {PAPER}"), *found])

    def _critical_rows(self, results: Results) -> Iterator["Row"]:
        for m in results.modes:
            size = f"{1e3 * self.chosen.hunting.disturbance:g} mm"
            words = []
            for contact, whose, offset in ((OWN, "the paper's contact", size), (EXACT, "the exact one", "the offset")):
                if (contact, m, RIG) in results.linear:
                    words.append(f"with {whose}: linear {self._linear(results.linear_kmh(m, RIG, contact))}")
                    by = results.by_disturbance(m, RIG, contact)
                    words += [f"from {offset} {by.text('km/h', 1)}"] if by.known else []
            title = f"critical speed on the rig, {NAMES[m]} (figure 7a)"
            yield title, f"{CRITICAL_KMH:g} km/h", "; ".join(words), TEXT["nameless"]

    def _critical_table(self, results: Results) -> list[Block]:
        """Critical speeds with the paper's own contact and with the exact one; nothing where none was computed."""
        called = {OWN: "the paper's: hertz, kalker saturated", EXACT: "exact: strips, table"}
        rows = []
        for m, variant, contact in itertools.product(results.modes, VARIANTS, called):
            if (place := (contact, m, variant)) in results.linear:
                value, frequency = results.linear[place]
                shown = f"{number(frequency, 3)} Hz" if math.isfinite(frequency) else ""
                by = results.by_disturbance(m, variant, contact).text("km/h", 1) if place in results.runs else ""
                rows.append((NAMES[m], variant, called[contact], self._linear(value), shown, by))
        header = ("material", "vehicle and support", "contact", "linear critical speed", "its frequency",
                  "by disturbance: decays … persists")  # fmt: skip
        caption = TEXT["side_by_side"].format(offset=1e3 * self.chosen.hunting.disturbance)
        return [Table(header, rows, caption)] if rows else []

    def _frequency_paragraphs(self, results: Results) -> list[str]:
        """What figure 7b says: how far the bogie on the rig and the whole vehicle on the rails are apart."""
        texts = []
        for m in MATERIALS:
            if not (apart := results.frequency_differences(m)):
                continue
            text = TEXT["frequency"].format(material=NAMES[m].capitalize(), count=len(apart), apart=_percents(apart))
            rig, vehicle = results.by_disturbance(m), results.by_disturbance(m, VEHICLE)
            if rig.known and vehicle.known:
                ratio, offset = rig.over(vehicle), 1e3 * self.chosen.hunting.disturbance
                lower = Interval(100 * (1 - ratio.high), 100 * (1 - ratio.low))
                on = {"rig": rig.text("km/h"), "rails": vehicle.text("km/h")}
                text += TEXT["on_rig_and_rails"].format(offset=offset, **on)
                text += f", lower on the rig by {lower.text('%')}." if lower.bounded else "."
            texts.append(text)
        return [TEXT["frequencies"], *texts] if texts else []

    def _fit_blocks(self, results: Results, numbers: Numbers) -> list[Block]:
        """Which material fits the paper's critical speed."""
        blocks: list[Block] = [*map(Text, _fit_paragraphs(results))] or [Text("Not computed.")]
        words = {True: "yes", False: "no", None: NOT_DECIDED}
        found = {(NAMES[m], kind): speed for (m, kind), speed in results.rig_speeds().items()}
        rows = [(*who, one.text("km/h", 1), _off(one).text("%"), words[_fits(one)]) for who, one in found.items()]
        if rows:
            header = ("material", "critical speed", "computed", f"less {CRITICAL_KMH:g} km/h", "within a tenth of it")
            blocks.append(Table(header, rows, "Bogie on the rig against the paper's critical speed."))
        if results.contact:
            entries = {NAMES[m]: numbers["materials"][m]["contact"] for m in results.contact if m in results.modes}
            caption = "Steady rolling on the rig, small motions."
            blocks.append(self.quantities.table(entries, "materials.*.contact", caption, "material"))
        if any(results.merging.values()):
            scans = {b: [results.merging[m].get(b) for m in MATERIALS] for b in self.chosen.criteria}
            cells = [[f"{b:g}", *map(speeds.linear_cell, own)] for b, own in scans.items()]
            blocks.append(Table(("merging criterion", *map(NAMES.__getitem__, MATERIALS)), cells, TEXT["merging"]))
        if results.sensitivity:
            blocks.append(sensitivity_table(results.sensitivity))
        return blocks

    def _parameters(self) -> list[Block]:
        """What was assumed."""
        case, traction, soft = rig_case("steel"), traction_case(self.chosen), rig_case("paper").contact.material
        rig, vehicle, steel, contact = case.support.data, case.vehicle.data, case.contact.material, case.contact
        assert isinstance(rig, Rig)
        values = {
            "vehicle": vehicle,
            "rig": rig,
            "contact": contact,
            "soft": soft,
            "hunting": self.chosen.hunting,
            "time": traction.time,
            "mm": [1e3 * length for length in (vehicle.wheel.radius, vehicle.wheel.back_to_back, rig.roller_radius)],
            "gpa": [1e-9 * one.shear_modulus for one in (steel, soft)],
            "laws": f"{contact.creep.kind}, {contact.normal.kind}".replace("_", " "),
            "merging": getattr(contact.normal, "merging_criterion", 0.0),
            "kmh": 3.6 * traction.motion.speed,
        }
        rows = [(name, text.format(**values)) for name, text in TEXT["parameters"]]
        bodies = [(b.name.replace("_", " "), b.mass, *b.inertia) for b in vehicle.bodies_in(case.vehicle.part)]
        header = ("body", "mass [kg]", "Ixx [kg m²]", "Iyy [kg m²]", "Izz [kg m²]")
        return [Table(("parameter", "value"), rows), Table(header, bodies, "Bodies; the car body is fixed.")]


# -------------------------------------------------------------------------------------------------------------- figures

LABELS = {"steel": "Steel", "paper": "Paper's material, G = 10 GPa"}


def _figures(results: Results) -> dict[str, Figure]:
    """All figures for which something was computed, by name."""
    found: dict[str, Figure] = {}
    body, stated = "front_frame", {"the paper": CRITICAL_KMH}  # the one number that the paper states of its figure 7
    runs = results.runs_of(RIG)
    if results.ramps:
        lines: dict[str, dict[str, float | tuple[float, float]]] = {
            LABELS[m]: {**stated, "linear": results.linear_kmh(m), "by disturbance": (by.low, by.high)}
            for m in results.ramps
            for by in [results.by_disturbance(m)]
        }
        found["figure_7a_ramp"] = ramp_over_speed({LABELS[m]: ramp for m, ramp in results.ramps.items()}, body, lines)
    for m, one in runs.items():
        chosen = [(3.6 * run.speed, run.motion) for run in around_onset(one.runs, one.persists)]
        found[f"figure_7a_time_{m}"] = hunting_over_time(chosen, body, LABELS[m])
    if runs:
        tables = {LABELS[m]: hunting_table(one.runs, one.disturbance) for m, one in runs.items()}
        exact = results.runs_of(RIG, EXACT).items()
        tables |= {f"{LABELS[m]}, exact contact": hunting_table(one.runs, one.disturbance) for m, one in exact}
        critical = {**stated, **{f"linear, {m}": results.linear_kmh(m) for m in runs}}
        found["figure_7a_amplitude"] = amplitude_over_speed(tables, critical)
    for m, modes in results.modes.items():
        both = {v: results.runs_of(v)[m] for v in (RIG, VEHICLE) if m in results.runs_of(v)}
        points = {v: hunting_table(one.runs, one.disturbance) for v, one in both.items()}
        found[f"figure_7b_{m}"] = hunting_frequencies(modes, points, LABELS[m])
    rig = rig_case(MATERIALS[0]).support.data
    assert isinstance(rig, Rig)
    for m, table in results.over_radius.items():
        found[f"radius_{m}"] = speeds.radius_picture("", table, rig.roller_radius, "").figure
    if MATERIALS[0] in results.effects:
        found["roller_effects"] = speeds.effects_picture("", results.effects[MATERIALS[0]], "").figure
    if results.theory is not None:
        wheels = {FRONT: "front right wheel", REAR: "rear right wheel"}
        found["figure_8a"] = traction_sliding(results.theory, wheels)
        found["figure_8b"] = traction_forces(results.theory, wheels)
    return found


# ------------------------------------------------------------------------------------------------------------ sentences

Row = Sequence[str]


def _percents(values: list[float]) -> str:
    return f"{100 * min(values):+z.0f} to {100 * max(values):+z.0f} %"


def _contact_sentences(results: Results) -> list[str]:
    """What the paper's critical speed is with its own contact and with the exact one, by material."""

    def one(material: str, contact: str) -> str:
        linear, by = results.linear_kmh(material, RIG, contact), results.by_disturbance(material, RIG, contact)
        small = f"{linear:z.1f} km/h" if math.isfinite(linear) else "none in the range"
        return f"{small} for small motions and {by.text('km/h', 1) if by.known else 'not computed'} from the offset"

    return [
        TEXT["contact"].format(paper=CRITICAL_KMH, material=NAMES[m], own=one(m, OWN), exact=one(m, EXACT))
        for m in results.modes
        if any(place[:2] == (EXACT, m) for place in results.linear)
    ]


def _critical_paragraphs(results: Results) -> Iterator[str]:
    """What figure 7 says about the critical speed."""
    for material, found in results.runs_of(RIG).items():
        small, large = results.linear_kmh(material), results.by_disturbance(material)
        if not (math.isfinite(small) and large.known):
            continue
        offset, words = 1e3 * found.disturbance, large.text("km/h", 1)
        text = TEXT["critical"].format(material=NAMES[material].capitalize(), small=small, offset=offset, large=words)
        if large.high < small - 5:
            text += TEXT["hysteresis"].format(high=large.high, small=small)
        ramp = results.ramps.get(material)
        end = 3.6 * end_of_hunting(ramp, "front_frame") if ramp is not None else math.nan
        yield text + (f" On the ramp down, the hunting ends at {end:z.0f} km/h." if math.isfinite(end) else "")


def _rig_paragraphs(results: Results) -> Iterator[str]:
    """Order of the critical speeds and the split of the loss."""
    bogie, vehicle = TABLE_PARTS
    for material, table in results.over_radius.items():
        apart = [table.kmh(bogie, radius) / table.kmh(vehicle, radius) - 1 for radius in table.radii]
        known = [100 * value for value in apart if math.isfinite(value)]
        text = f"{NAMES[material].capitalize()}. {' '.join(speeds.radius_sentences(table))}"
        if known:
            ends = f"{min(known):+z.1f} to {max(known):+z.1f} %"
            text += f" The bogie with fixed car body differs by {ends} from the whole vehicle."
        yield text
    for material, split in results.effects.items():
        yield f"{NAMES[material].capitalize()}, bogie. {speeds.effects_sentence(split)}"


def _rig_and_rails(results: Results) -> Iterator[Row]:
    """Figure 7b: bogie on the rig against the whole vehicle on the rails."""
    for m in MATERIALS:
        if apart := results.frequency_differences(m):
            what = f"frequency of hunting, rig against rails, {NAMES[m]} (figure 7b)"
            yield what, "similar", f"differs by {_percents(apart)}", TEXT["short"]
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


# ----------------------------------------------------------------------------------------- which material fits the paper


def _fits(speed: Interval) -> bool | None:
    """Whether a critical speed [km/h] is near the paper's; None: not decided."""
    return speed.within((1 - NEAR) * CRITICAL_KMH, (1 + NEAR) * CRITICAL_KMH)


def _off(speed: Interval) -> Interval:
    """A critical speed [km/h] less the paper's [%]."""
    return Interval(*(100 * (end / CRITICAL_KMH - 1) for end in (speed.low, speed.high)))


def _fit_paragraphs(results: Results) -> Iterator[str]:
    """Which material the paper's critical speed fits, and why."""
    if not (found := results.rig_speeds()):
        return
    yield f"The paper reports growing oscillations above {CRITICAL_KMH:z.0f} km/h. {_nearest(found)}"
    if all(m in results.contact for m in MATERIALS):
        yield _effect_of_the_material(results)
    parts = []
    for m in MATERIALS:
        known = [v for scan in results.merging.get(m, {}).values() if math.isfinite(v := scan.speed_kmh)]
        if len(known) > 1:
            parts.append(f"{NAMES[m]} {min(known):z.0f} to {max(known):z.0f} km/h")
    if parts:
        yield TEXT["accuracy"].format(ranges=" and ".join(parts))


def _nearest(found: dict[tuple[str, str], Interval]) -> str:
    """The nearest critical speed, where the intervals tell which it is."""
    distances = {key: one.distance(CRITICAL_KMH) for key, one in found.items()}
    nearest = min(distances, key=lambda key: distances[key].high)
    if any(other.low < distances[nearest].high for key, other in distances.items() if key != nearest):
        which = f"Which critical speed is nearest to that is {NOT_DECIDED} at the width of the intervals below."
        return f"{which} {NAMELESS}"
    (material, kind), speed = nearest, found[nearest]
    text = f"The nearest critical speed is that of {NAMES[material]} ({kind}), {speed.text('km/h', 1)}"
    others = [distance.low for (other, _), distance in distances.items() if other != material]
    text += f"; the other material differs from the paper by at least {min(others):z.0f} km/h. " if others else ". "
    verdict = _fits(speed)
    if verdict:
        return f"{text}That is within a tenth of the paper's value."
    if verdict is None:
        return f"{text}Whether that is within a tenth of the paper's value is {NOT_DECIDED}. {NAMELESS}"
    off = _off(speed)
    apart = f"{off.text('%')} above" if off.low > 0 else f"{Interval(-off.high, -off.low).text('%')} below"
    return f"{text}That is {apart} the paper's value: neither reproduces it. {NAMELESS}"


def _effect_of_the_material(results: Results) -> str:
    steel, soft = (results.contact[m] for m in MATERIALS)
    moduli = [rig_case(m).contact.material.shear_modulus for m in MATERIALS]
    text: str = TEXT["material"].format(
        modulus=1e-9 * moduli[1],
        deeper=soft.approach / steel.approach,
        soft=1e6 * soft.approach,
        steel=1e6 * steel.approach,
        stiffness=100 * soft.creep_stiffness / steel.creep_stiffness,
        cube_root=100 * (moduli[1] / moduli[0]) ** (1 / 3),
    )
    linear, by = [results.linear_kmh(m) for m in MATERIALS], [results.by_disturbance(m) for m in MATERIALS]
    if linear[1] < linear[0] and by[1].below(by[0]):
        text += " Both the linear critical speed and that by disturbance fall with it."
    waves = [results.onset_wavelength(m) for m in MATERIALS]
    if all(math.isfinite(w) for w in waves):
        slow = [state.wavelength for state in (steel, soft)]
        factor = [(own / wave) ** 2 for own, wave in zip(slow, waves, strict=True)]
        text += TEXT["steeper"].format(onset=waves, slow=slow, factor=factor)
    return text


def _audited(results: Results) -> dict[str, dict[str, Any]]:
    """Attributes of the runs whose solver and contacts are shown."""
    found: dict[str, dict[str, Any]] = {}
    for m in MATERIALS:
        if m in results.ramps:
            found[f"ramp, {NAMES[m]}"] = results.ramps[m].attrs
        for run in results.runs_of(RIG)[m].runs if m in results.runs_of(RIG) else []:
            found[f"{3.6 * run.speed:z.1f} km/h, {NAMES[m]}"] = run.motion.attrs
    return found if results.traction is None else found | {"traction": results.traction.attrs}
