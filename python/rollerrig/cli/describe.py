"""What `check` prints about a case or a part of one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import xarray as xr

from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.cli.describe_actuators import actuator_lines
from rollerrig.cli.describe_track import irregularity_lines, line_rows
from rollerrig.config import Case, Element, Material, ProfileSpec, Programme, Rig, Track, Vehicle
from rollerrig.simulation.starting_state import degrees_of_freedom, equilibrium_dataset

_CLOSED = 1e-6
"""Part of the weight: a larger difference to the wheel loads has a reason."""

Part = Vehicle | Rig | Track | Material | ProfileSpec | Programme


def describe_case(case: Case, *, run_code: bool = False) -> list[str]:
    """The assembled model, static wheel loads and masses.

    Args:
        case: what is described.
        run_code: whether controllers that it brings are made and checked; they are only looked at otherwise.

    Raises:
        StartError: the model has no equilibrium.
    """
    model = assemble(case)
    run = equilibrium_dataset(model).isel(time=0)
    lines = [f"{case.name}: {case.description}", ""]
    lines += _bodies(model) + [""]
    if model.elements:
        lines += _elements(model) + [""]
    lines += _way(model)

    vertical = [float(v) for v in run["vertical_force"]]
    lateral = [float(v) for v in run["lateral_force"]]
    speed = 3.6 * float(run["speed"])
    rows = [
        [wheel.name, f"{q / 1e3:z.3f}", f"{y / 1e3:z.3f}", f"{count:z.0f}"]
        for wheel, q, y, count in zip(model.wheels, vertical, lateral, run["patch_count"].to_numpy(), strict=True)
    ]
    lines += _table([f"wheels at {speed:.4g} km/h", "vertical kN", "lateral kN", "patches"], rows)
    lines += [""] + _balance(model, run)
    actuators = actuator_lines(case, run_code=run_code)
    return [*lines, "", *actuators] if actuators else lines


def describe_part(part: Part) -> list[str]:
    """A line or two about a vehicle, a support, a material, a profile or a test programme."""
    match part:
        case Vehicle():
            total = sum(body.mass for body in part.body)
            cuts = ", ".join(part.cut) or "none"
            return [
                f"{part.name}: {len(part.body)} bodies, {len(part.element)} force elements, {total / 1e3:z.3f} t",
                f"cuts: {cuts}",
            ]
        case Rig():
            rollers = f"{part.name}: rollers of {1e3 * part.roller_radius:g} mm radius, gauge {1e3 * part.gauge:g} mm"
            return [rollers, *irregularity_lines(part)]
        case Track():
            rails = "rigid rails" if part.foundation is None else "rails on an elastic foundation"
            lines = [f"{part.name}: track, gauge {1e3 * part.gauge:g} mm, {rails}", *irregularity_lines(part)]
            return lines + _table_of(line_rows(part))
        case Material():
            return [f"G = {part.shear_modulus / 1e9:g} GPa, Poisson's ratio {part.poisson_ratio:g}"]
        case Programme():
            kinds = [stop.kind for stop in part.stop]
            stops = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
            return [f"{part.name}: {len(kinds)} stops ({stops}) of {part.starts} starts, {len(part.limit)} limits"]
        case _:
            return [f"profile of kind {part.arguments()['kind']}"]


def _way(model: AssembledModel) -> list[str]:
    """The line and the irregularity, each with an empty line behind it."""
    support = model.case.support.data
    rows = line_rows(support, model.case) if isinstance(support, Track) else []
    parts = (_table_of(rows), irregularity_lines(support, model.irregularity))
    return [line for part in parts if part for line in (*part, "")]


def _table_of(rows: Sequence[Sequence[str]]) -> list[str]:
    return _table(rows[0], rows[1:]) if rows else []


def _bodies(model: AssembledModel) -> list[str]:
    free = degrees_of_freedom(model)
    rows = []
    for body in model.bodies:
        state = ", ".join(free[body]) if free[body] else ("speed-controlled" if body in model.rollers else "fixed")
        rows.append([body, f"{model.masses[body]:z.0f}", state])
    count = sum(len(directions) for directions in free.values())
    return _table([f"bodies ({count} degrees of freedom)", "mass kg", "free"], rows)


def _elements(model: AssembledModel) -> list[str]:
    known = {element.name: element for element in model.case.vehicle.data.element}
    sleepers = any(name.startswith("sleeper_") for name in model.rails)
    rows = []
    for name in model.elements:
        element = known.get(name)
        between = (
            " - ".join(element.between)
            if element
            else f"{'sleeper' if sleepers and '_rail_' in name else 'ground'} - {name.split('_')[1]}"
            if name.removeprefix("mounting_") in model.rails
            else "ground - roller"
        )
        directions = ", ".join(element.laws) if element else "mounting"
        preload = f"{model.preloads[name] / 1e3:z.3f}" if name in model.preloads else ""
        rows.append([name, between, directions, preload])
    return _table(["force elements", "between", "acts along", "preload kN"], rows)


def _balance(model: AssembledModel, run: xr.Dataset) -> list[str]:
    """Weight, and what fixed bodies add to it, against the sum of the wheel loads of the solved equilibrium."""
    own = list(model.lateral_bodies)
    mass = sum(model.masses[body] for body in own)
    weight = model.case.gravity * mass
    lines = [f"mass of {', '.join(own)}: {mass / 1e3:z.3f} t, weight {weight / 1e3:z.3f} kN"]
    supported = sum(
        _downward(run, element, model.fixed) for element in model.case.vehicle.data.elements_in(model.case.vehicle.part)
    )
    if model.fixed:
        design = sum(model.axle_loads.values()) - weight
        lines.append(
            f"load from {', '.join(model.fixed)}, which is fixed: {supported / 1e3:z.3f} kN, in the design position "
            f"{design / 1e3:z.3f} kN"
        )
    total, on_wheels = weight + supported, float(run["vertical_force"].sum())
    sums = f"total weight {total / 1e3:z.3f} kN, sum of the wheel loads {on_wheels / 1e3:z.3f} kN"
    if float(run["curvature"]) or float(run["cant"]):  # the plane of the track takes a part of both forces
        return [*lines, f"{sums}, normal to the track in the curve where the run starts"]
    lines.append(f"{sums} (difference {on_wheels - total:+.1e} N)")
    held = [body for body in own if "z" in model.case.vehicle.data.body_named(body).locked]
    if held and abs(on_wheels - total) > _CLOSED * total:
        lines.append(f"the difference is what holds {', '.join(held)}, whose z is locked")
    return lines


def _downward(run: xr.Dataset, element: Element, fixed: Sequence[str]) -> float:
    """Force by which an element presses free bodies down, 0 unless one of its ends is fixed [N]."""
    a_fixed, b_fixed = (name in fixed for name in element.between)
    force = float(run["element_force_z"].sel(element=element.name))
    return (force if b_fixed else 0.0) - (force if a_fixed else 0.0)


def _table(heading: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    cells = [list(heading), *(list(row) for row in rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(heading))]
    numeric = [all(_is_number(row[i]) for row in cells[1:]) and len(cells) > 1 for i in range(len(heading))]
    return [
        "  ".join(c.rjust(w) if n else c.ljust(w) for c, w, n in zip(row, widths, numeric, strict=True)).rstrip()
        for row in cells
    ]


def _is_number(text: str) -> bool:
    return text == "" or text.replace(".", "").replace("-", "").isdigit()
