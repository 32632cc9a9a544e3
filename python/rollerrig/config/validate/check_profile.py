"""Checks of profiles, and of patches that their contact would have.

    Case -> [check_patch] -> problems

The patch is estimated as the Hertzian circle of two balls of the radii of wheel and roller, under the mean wheel load.
"""

from collections.abc import Iterator
from itertools import islice
from typing import Literal

from rollerrig import _core
from rollerrig.config.errors import Mistake, show_value
from rollerrig.config.schema.case import CaseTables
from rollerrig.config.schema.profile import ProfileSpec
from rollerrig.config.schema.support import Rig, heads
from rollerrig.config.schema.track import Track
from rollerrig.config.schema.vehicle import Wheel
from rollerrig.profiles import ProfileError, gauge_point, profile_from_spec

FLANGE_DEPTH = 0.010  # [m] below the tape circle, where the thickness of a flange is taken, EN 13715
WIDEST_SCALES = 10.0  # [-] between the lengths of wheel and rail: beyond it they are of different models
WIDEST_CLEARANCE = 0.040  # [m] between the flanges of a wheelset and the rails, both sides together


def check_profile(spec: ProfileSpec, kind: Literal["wheel", "rail"], key: str) -> Iterator[Mistake]:
    """The profile must be usable as a wheel or as a rail."""
    try:
        profile_from_spec(spec.arguments(), kind)
    except (ProfileError, OSError) as error:
        what = str(getattr(spec, "path", None) or getattr(spec, "kind", ""))
        reason = str(error).removeprefix("profile: ").removeprefix(f"{what}: ")
        yield key, show_value(what), reason


def check_gauge(support: Rig | Track) -> Iterator[Mistake]:
    """The profiles must be usable as rails and reach down to where the gauge is taken."""
    for key in ("profile", "right_profile")[: 1 if support.right_profile is None else 2]:
        head = getattr(support, key)
        if mistakes := [*check_profile(head, "rail", key)]:
            yield from mistakes
            continue
        try:
            gauge_point(profile_from_spec(head.arguments(), "rail"), support.gauge_depth)
        except ProfileError as error:
            yield "gauge_depth", show_value(support.gauge_depth), str(error)


def gauges(support: Rig | Track) -> Iterator[tuple[str, float]]:
    """Key and value of every gauge of a support [m]."""
    yield "support.data.gauge", support.gauge
    for i, segment in enumerate(support.segment if isinstance(support, Track) else ()):
        gauge = getattr(segment, "gauge", None)
        if gauge is not None:
            yield f"support.data.segment[{i}].gauge", gauge


def check_fit(case: CaseTables) -> Iterator[Mistake]:
    """Wheels and rails of one model, of which the wheels stand on the rails, with the flanges between them."""
    wheel, support = case.vehicle.data.wheel, case.support.data
    mistakes = (mistake for check in (_scales, _misses, _flanges) for mistake in check(wheel, support))
    yield from islice(mistakes, 1)


def _misses(wheel: Wheel, support: Rig | Track) -> Iterator[Mistake]:
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
            yield key, show_value(gauge), allowed


def _scales(wheel: Wheel, support: Rig | Track) -> Iterator[Mistake]:
    """Wheel and rail must be of one model: the contact between them is looked for at the wheel's scale."""
    of_wheel = wheel.profile.length_scale
    for key, head in zip(("profile", "right_profile"), heads(support).values(), strict=True):
        if not 1.0 / WIDEST_SCALES <= head.length_scale / of_wheel <= WIDEST_SCALES:
            allowed = f"allowed: about that of the wheel, {of_wheel:g}, at most a factor of {WIDEST_SCALES:g} from it"
            yield f"support.data.{key}.length_scale", show_value(head.length_scale), allowed


def flange_clearance(wheel: Wheel, gauge: float) -> float | None:
    """Play of a wheelset between rails or rollers of a gauge [m]; None for wheels without a flange."""
    table = profile_from_spec(wheel.profile.arguments(), "wheel")
    flange, radius = table.outline[table.outline[:, 0] < 0].T
    depth = wheel.profile.length_scale * FLANGE_DEPTH
    if radius.max(initial=0.0) < depth:
        return None
    nearest_to_tread = float(flange[radius >= depth].max())
    return gauge - (wheel.back_to_back + 2 * (wheel.tape_circle + nearest_to_tread))


def _flanges(wheel: Wheel, support: Rig | Track) -> Iterator[Mistake]:
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
        yield key, show_value(gauge), allowed


LARGEST_SHARE = 0.1
"""Largest share of the radius: half of the patch's length may be at most so long [-]."""


def check_patch(case: CaseTables) -> Iterator[Mistake]:
    """Rollers, and wheels, that are too small for what presses on them."""
    support = case.support.data
    if not isinstance(support, Rig):
        return
    wheel = case.vehicle.data.wheel.radius
    radii = {"vehicle.data.wheel.radius": wheel, "support.data.roller_radius": support.roller_radius}
    load, material = wheel_load(case), case.contact.material
    curvature = 0.5 * sum(1.0 / radius for radius in radii.values())  # (14)
    patch = _core.hertz_ellipse(load, curvature, curvature, material.shear_modulus, material.poisson_ratio)[0]
    key, radius = min(radii.items(), key=lambda one: one[1])
    if patch > LARGEST_SHARE * radius:
        allowed = (
            f"the patch between wheel and roller is about {1e3 * patch:.3g} mm long to either side (load {load:.3g} N, "
            f"E {material.young_modulus:.3g} Pa), and contact theory takes both for bodies much larger than it; allowed: up to "
            f"{LARGEST_SHARE:g} of the radius: larger wheels and rollers, less load, or a harder material"
        )
        yield key, f"{1e3 * radius:.3g} mm", allowed


def wheel_load(case: CaseTables) -> float:
    """Mean over the whole vehicle [N]."""
    bodies = case.vehicle.data.body
    wheelsets = sum(body.kind == "wheelset" for body in bodies)
    return case.gravity * sum(body.mass for body in bodies) / (2 * wheelsets)
