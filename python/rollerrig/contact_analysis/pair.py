"""A wheelset of any wheel profile on rails or rollers of any head: a case made of two names and a few lengths."""

from __future__ import annotations

from rollerrig.config import Case, load_case, load_profile

DEFAULT_GAUGE = 1.435
DEFAULT_GAUGE_DEPTH = 14e-3
DEFAULT_BACK_TO_BACK = 1.360
DEFAULT_RADIUS = 0.460


def pair_case(
    wheel: str,
    rail: str,
    *,
    gauge: float = DEFAULT_GAUGE,
    gauge_depth: float = DEFAULT_GAUGE_DEPTH,
    back_to_back: float = DEFAULT_BACK_TO_BACK,
    radius: float = DEFAULT_RADIUS,
    roller_radius: float | None = None,
) -> Case:
    """A lone wheelset on a track or, with a roller radius, on a pair of rollers whose generatrix is the rail's head.

    Args:
        wheel: wheel profile: a name of the catalogue, a TOML file or a file of points.
        rail: rail profile, likewise.
        gauge: distance between the gauge sides [m].
        gauge_depth: depth below the highest point at which the gauge is taken [m].
        back_to_back: distance between the flange backs [m].
        radius: wheel radius at the tape circle [m].
        roller_radius: radius at the crown of the rollers [m]; None: rails.

    Raises:
        ConfigError: all mistakes found; also where the wheels would miss the rails.
    """
    titles = [load_profile(wheel, "wheel").name or wheel, load_profile(rail, "rail").name or rail]
    changes: dict[str, object] = {
        "description": " on ".join(titles),
        "vehicle.wheel.profile": wheel,
        "vehicle.wheel.radius": radius,
        "vehicle.wheel.back_to_back": back_to_back,
        "vehicle.body.wheelset_1.position": [0.0, 0.0, radius],
        "support.profile": rail,
        "support.gauge": gauge,
        "support.gauge_depth": gauge_depth,
    }
    if roller_radius is not None:
        changes["support.roller_radius"] = f"{roller_radius} m"
    base = load_case("contact_benchmark_track" if roller_radius is None else "contact_benchmark_rollers")
    return base.with_changes({"name": "conicity"}).with_changes(changes)
