"""What a page can plot of a scene: groups of its columns with units.

head of a scene -> [plots] -> groups: title, sign and filter, unit, curves of column, label, factor

Forces have the signs of a report (`analysis.wheel_rail_forces`), and its filter where the scene has them filtered: then they
have times of their own, at which extremes lie. A simulation that goes on is not filtered.
"""

from __future__ import annotations

from typing import Any

Group = dict[str, Any]


def plots(head: dict[str, Any]) -> list[Group]:
    """The groups that have at least one curve."""
    columns, bodies = head["columns"], head["bodies"]
    moving = [
        (number, body["name"].replace("_", " "))
        for number, body in enumerate(bodies)
        if body["kind"] not in ("roller", "rail")
    ]
    wheels = [
        (number, wheel["name"].replace("wheelset_", "").replace("_", " "))
        for number, wheel in enumerate(head["wheels"])
    ]
    axles = [(number, name.replace("_", " ")) for number, name in enumerate(head["axles"])]
    radius, roller = head["shapes"]["wheel_radius"], head["shapes"]["roller_radius"]

    def group(title: str, unit: str, curves: list[tuple[str, str, float]], note: str = "") -> Group:
        known = [[column, label, factor] for column, label, factor in curves if column in columns]
        own = f"time.{known[0][0].partition('.')[2]}" if known else ""
        times = {"times": own} if own in columns else {}
        return {"title": title, "note": note, "unit": unit, "curves": known, **times}

    speeds = [("train_speed" if "train_speed" in columns else "speed", "train", 3.6)]
    speeds += [(f"a{k}.axle_speed", name, 3.6 * radius) for k, name in axles]
    if roller:
        speeds += [(f"a{k}.roller_speed", f"roller {name.rpartition(' ')[2]}", 3.6 * roller) for k, name in axles]
    filtered = head.get("filter", "unfiltered")
    if "w0.guiding_force" in columns:
        guiding = [(f"w{k}.guiding_force", name, 1e-3) for k, name in wheels]
        load = [(f"w{k}.wheel_load", name, 1e-3) for k, name in wheels]
    else:  # that on the wheel, to the left
        guiding = [(f"w{k}.lateral_force", name, -1e-3 if name.endswith("left") else 1e-3) for k, name in wheels]
        load = [(f"w{k}.vertical_force", name, 1e-3) for k, name in wheels]
    longitudinal = [(f"w{k}.longitudinal_force", name, 1e-3) for k, name in wheels]
    groups = [
        group("Lateral displacement", "mm", [(f"b{k}.lateral", name, 1e3) for k, name in moving], "to the left"),
        group("Yaw", "mrad", [(f"b{k}.yaw", name, 1e3) for k, name in moving]),
        group("Speed, at nominal radii", "km/h", speeds),
        group("Guiding force Y", "kN", guiding, f"outwards, {filtered}"),
        group("Wheel load Q", "kN", load, filtered),
        group("Longitudinal force", "kN", longitudinal, "forwards on the wheel, unfiltered"),
        group("Longitudinal sliding", "m/s", [(f"w{k}.longitudinal_sliding", name, 1.0) for k, name in wheels]),
        group("Brake cylinder pressure", "bar", [(f"a{k}.cylinder_pressure", name, 1e-5) for k, name in axles]),
        group("Drive torque of the rollers", "kN m", [(f"a{k}.roller_torque", name, 1e-3) for k, name in axles]),
        group("Vertical displacement", "mm", [(f"b{k}.vertical", name, 1e3) for k, name in moving]),
        group("Roll", "mrad", [(f"b{k}.roll", name, 1e3) for k, name in moving]),
    ]
    return [one for one in groups if one["curves"]]
