"""What `check` prints about a track: its line, and what its rails deviate from it."""

from __future__ import annotations

import math

from rollerrig.config import GRAVITY, Case, Rig, Track
from rollerrig.config.schema.track import SpectrumIrregularity, rails_of_run
from rollerrig.config.validate.check_track import highest_speed_on, speeds_on
from rollerrig.irregularity import RailIrregularity
from rollerrig.track import Segment, equilibrium_speed, plane_acceleration

Rows = list[list[str]]


def line_rows(track: Track, case: Case | None = None) -> Rows:
    """A heading and one row per segment; with a case, also how its vehicle runs there at its highest speed."""
    line = track.line
    if line is None:
        return []
    heading = ["segment", "from m", "to m", "radius m", "cant mm", "equilibrium km/h"]
    heading += ["speed km/h", "cant deficiency mm", "at most km/h"] if case else []
    rows, gravity = [heading], case.gravity if case else GRAVITY
    for i, segment in enumerate(line.segments):
        row = [
            f"{i} {segment.kind}",
            f"{segment.start:g}",
            f"{segment.end:g}",
            *_curve(segment, track.cant_base, gravity),
        ]
        rows.append(row + (_run(case, track, segment) if case else []))
    return rows


def _curve(segment: Segment, base: float, gravity: float) -> list[str]:
    if segment.kind != "curve":
        return [segment.shape if segment.kind == "transition" else "", "", ""]
    curvature, cant = segment.curvature[0], segment.cant[0]
    side = "left" if curvature > 0 else "right"
    balanced = equilibrium_speed(curvature, cant, base, gravity)
    outer = math.copysign(1.0, curvature) * cant
    return [
        f"{1 / abs(curvature):g} {side}",
        f"{1e3 * outer + 0.0:g}",
        "none" if math.isnan(balanced) else f"{3.6 * balanced:z.1f}",
    ]


def _run(case: Case, track: Track, segment: Segment) -> list[str]:
    """Speed, cant deficiency and highest speed; a cant deficiency is the cant that would have to be added."""
    speeds = speeds_on(case, segment)
    if speeds is None:
        return ["not reached", "", ""]
    if segment.kind != "curve":
        return [f"{3.6 * speeds[1]:z.1f}", "", ""]
    curvature, cant = segment.curvature[0], segment.cant[0]
    left_over = plane_acceleration(speeds[1], curvature, cant, track.cant_base, case.gravity)
    outward = math.copysign(1.0, curvature) * left_over
    highest = highest_speed_on(case, track, segment)
    return [
        f"{3.6 * speeds[1]:z.1f}",
        f"{1e3 * track.cant_base * outward / case.gravity:z.0f}",
        f"{3.6 * highest:z.0f}",
    ]


def irregularity_lines(support: Rig | Track, rails: RailIrregularity | None = None) -> list[str]:
    """Where the irregularity comes from, and the root mean square of its components where they are known."""
    chosen = support.irregularity
    if chosen is None:
        return []
    if isinstance(chosen, SpectrumIrregularity):
        rails = rails or rails_of_run(chosen, 0.0, 0.0)
        waves = f"waves of {chosen.shortest_wavelength:g} to {chosen.longest_wavelength:g} m"
        origin = f"ORE B 176, {chosen.level} level, seed {chosen.seed}, {waves}, repeating after {chosen.period:g} m"
    else:
        origin = f"measured, {chosen.path}"
    scaled = f", scaled by {chosen.scale:g}" if chosen.scale != 1.0 else ""
    lines = [f"irregularity: {origin}{scaled}, fading in over {chosen.fade_in:g} m"]
    if rails is not None:
        sizes = ", ".join(
            f"{name.replace('_', ' ')} {1e3 * size:z.2f}" for name, size in rails.root_mean_square().items()
        )
        lines.append(f"root mean square [mm]: {sizes}")
    return lines
