"""Checks that need the curves themselves: profiles that cannot be used, and wheels that miss the rail."""

from collections.abc import Iterator
from typing import Literal

from rollerrig.config.errors import ConfigProblem, show_value
from rollerrig.config.schema.profile import ProfileSpec
from rollerrig.config.schema.support import Rig, heads
from rollerrig.config.schema.track import Track
from rollerrig.config.schema.vehicle import Wheel
from rollerrig.profiles import ProfileError, ProfileTable, gauge_point, profile_from_spec

FLANGE_DEPTH = 0.010  # [m] below the tape circle, where the thickness of a flange is taken, EN 13715
WIDEST_SCALES = 10.0  # [-] between the lengths of wheel and rail: beyond it they are of different models
WIDEST_CLEARANCE = 0.040  # [m] between the flanges of a wheelset and the rails, both sides together


def check_profile(
    spec: ProfileSpec, kind: Literal["wheel", "rail"], file: str, key: str
) -> tuple[ProfileTable | None, list[ConfigProblem]]:
    """The table of a profile, or what is wrong with the profile."""
    try:
        return profile_from_spec(spec.arguments(), kind), []
    except (ProfileError, OSError) as error:
        what = str(getattr(spec, "path", None) or getattr(spec, "kind", ""))
        reason = str(error).removeprefix("profile: ").removeprefix(f"{what}: ")
        return None, [ConfigProblem(file, key, show_value(what), reason)]


def check_gauge(support: Rig | Track, file: str) -> list[ConfigProblem]:
    """The profiles must be usable as rails and reach down to where the gauge is taken."""
    problems = []
    for key in ("profile", "right_profile")[: 1 if support.right_profile is None else 2]:
        table, mistakes = check_profile(getattr(support, key), "rail", file, key)
        problems += mistakes
        try:
            if table is not None:
                gauge_point(table, support.gauge_depth)
        except ProfileError as error:
            problems.append(ConfigProblem(file, "gauge_depth", show_value(support.gauge_depth), str(error)))
    return problems


def gauges(support: Rig | Track) -> Iterator[tuple[str, float]]:
    """Key and value of every gauge of a support [m]."""
    yield "support.data.gauge", support.gauge
    for i, segment in enumerate(support.segment if isinstance(support, Track) else ()):
        gauge = getattr(segment, "gauge", None)
        if gauge is not None:
            yield f"support.data.segment[{i}].gauge", gauge


def check_reach(wheel: Wheel, support: Rig | Track, file: str) -> list[ConfigProblem]:
    """The tape circle of the centred wheel must lie over the rail or roller, and the flange beside it."""
    half_wheel = profile_from_spec(wheel.profile.arguments(), "wheel").domain
    tape_circle = wheel.back_to_back / 2 + wheel.tape_circle
    what = "rollers" if support.kind == "rig" else "rails"
    for head in heads(support).values():
        rail_table = profile_from_spec(head.arguments(), "rail")
        for key, gauge in gauges(support):
            rail_origin = gauge / 2 - gauge_point(rail_table, support.gauge_depth)
            low, high = (rail_origin + end for end in rail_table.domain)
            if low < tape_circle < high:
                continue
            allowed = (
                f"the wheels miss the {what}: the tape circle lies {tape_circle * 1e3:.1f} mm from the middle, the running "
                f"surface from {low * 1e3:.1f} to {high * 1e3:.1f} mm; check gauge ({gauge * 1e3:g} mm) and "
                f"wheel.back_to_back ({wheel.back_to_back * 1e3:g} mm); the wheel spans "
                f"{half_wheel[0] * 1e3:.0f} to {half_wheel[1] * 1e3:.0f} mm about its tape circle"
            )
            return [ConfigProblem(file, key, show_value(gauge), allowed)]
    return []


def check_scales(wheel: Wheel, support: Rig | Track, file: str) -> list[ConfigProblem]:
    """Wheel and rail must be of one model: the contact between them is looked for at the wheel's scale."""
    of_wheel = wheel.profile.length_scale
    for key, head in zip(("profile", "right_profile"), heads(support).values(), strict=True):
        if not 1.0 / WIDEST_SCALES <= head.length_scale / of_wheel <= WIDEST_SCALES:
            allowed = f"allowed: about that of the wheel, {of_wheel:g}, at most a factor of {WIDEST_SCALES:g} from it"
            return [ConfigProblem(file, f"support.data.{key}.length_scale", show_value(head.length_scale), allowed)]
    return []


def flange_clearance(wheel: Wheel, gauge: float) -> float | None:
    """Play of a wheelset between rails or rollers of a gauge [m]; None for wheels without a flange."""
    table = profile_from_spec(wheel.profile.arguments(), "wheel")
    flange, radius = table.outline[table.outline[:, 0] < 0].T
    depth = wheel.profile.length_scale * FLANGE_DEPTH
    if radius.max(initial=0.0) < depth:
        return None
    nearest_to_tread = float(flange[radius >= depth].max())
    return gauge - (wheel.back_to_back + 2 * (wheel.tape_circle + nearest_to_tread))


def check_flange_clearance(wheel: Wheel, support: Rig | Track, file: str) -> list[ConfigProblem]:
    """The flanges must fit between the rails or rollers, and not stand far inside of them."""
    widest = wheel.profile.length_scale * WIDEST_CLEARANCE
    for key, gauge in gauges(support):
        clearance = flange_clearance(wheel, gauge)
        if clearance is None or 0.0 <= clearance <= widest:
            continue
        across = gauge - clearance
        what = "rollers" if support.kind == "rig" else "rails"
        verb = "do not fit between" if clearance < 0 else "stand far inside of"
        allowed = (
            f"wheel and rail of different gauge: the flanges, {1e3 * across:.1f} mm across, {verb} the {what}; allowed: a "
            f"gauge {across:.4g} to {across + widest:.4g} m, or another wheel.back_to_back ({1e3 * wheel.back_to_back:g} mm)"
        )
        return [ConfigProblem(file, key, show_value(gauge), allowed)]
    return []
