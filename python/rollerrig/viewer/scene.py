"""One run, or mode shapes, as a page shows them: parts, motion and forces in thinned frames, and what can be plotted.

    head of a scene -> [plots] -> groups: title, sign and filter, unit, curves of column, label, factor
    run -> [run_scene], modes -> [mode_scene] -> Scene -> page

Forces have the signs of a report (`analysis.wheel_rail_forces`), and its filter where the scene has them filtered: then they
have times of their own, at which extremes lie. A simulation that goes on is not filtered.

Everything that is drawn was recorded in the run, or is asked of the core (`contact_places`). Of a mode the page draws
u(t) = amplitude cos(2 pi f t + phase) of each coordinate; its size is arbitrary, growth and decay are left out.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from rollerrig.analysis.wheel_rail_forces import filtered, unfiltered, wheel_forces
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.common.arrays import Array
from rollerrig.config import ConfigError, case_from_toml
from rollerrig.results import ResultsError, RunInfo
from rollerrig.results.dataset import recorded_names
from rollerrig.viewer import parts
from rollerrig.viewer.columns import MOST_FRAMES, Columns, extremes, thinned
from rollerrig.viewer.contacts import PLACE, contact_places

Group = dict[str, Any]


def plots(head: dict[str, Any]) -> list[Group]:
    """The groups that have at least one curve."""
    columns, bodies = head["columns"], head["bodies"]
    named = [(number, body["name"].replace("_", " ")) for number, body in enumerate(bodies)]
    moving = [one for one, body in zip(named, bodies, strict=True) if body["kind"] not in ("roller", "rail")]
    short = [wheel["name"].replace("wheelset_", "") for wheel in head["wheels"]]
    wheels = [(number, name.replace("_", " ")) for number, name in enumerate(short)]
    axles = [(number, name.replace("_", " ")) for number, name in enumerate(head["axles"])]
    radius, roller = head["shapes"]["wheel_radius"], head["shapes"]["roller_radius"]

    def group(title: str, unit: str, curves: list[tuple[str, str, float]], note: str = "") -> Group:
        known = [[column, label, factor] for column, label, factor in curves if column in columns]
        own = f"time.{str(known[0][0]).partition('.')[2]}" if known else ""
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


MOTION = ("longitudinal", "lateral", "vertical", "roll", "pitch", "yaw")
_ANGLES = ("roll", "pitch", "yaw")
PATCH = (
    "wheel_abscissa",
    "rail_abscissa",
    "contact_angle",
    "normal",
    "a",
    "b",
    "creep_force_x",
    "creep_force_y",
    "sliding_x",
    "sliding_y",
)
WHEEL = (
    "longitudinal_force",
    "lateral_force",
    "vertical_force",
    "longitudinal_sliding",
    "lateral_sliding",
    "rail_lateral",
    "rail_vertical",
)
AXLE = ("cylinder_pressure", "brake_torque", "traction_torque", "roller_torque", "axle_speed", "roller_speed")
TRAIN = ("speed", "distance", "train_speed")
ALLOWED = {"position_mm": 0.05, "angle_mrad": 0.1}
"""Errors that a page may make to have fewer frames; that of the forces is only stated."""

_MOST_PATCHES = 3
"""Largest number of patches of a wheel that are drawn."""

_MOVES = 1e-12


@dataclass(frozen=True)
class Scene:
    """What the page needs of one run: plain tables, as JSON, and the numbers over time."""

    head: dict[str, Any]
    columns: Columns


def run_scene(run: xr.Dataset, *, label: str = "", most: int = MOST_FRAMES) -> Scene:
    """The scene of a run.

    Args:
        run: results of `simulate`.
        label: how it is called beside another one; by default its case.
        most: frames.

    Raises:
        ResultsError: the results hold no motion, or their case cannot be read by this version.
    """
    model = model_of(run)
    index, errors = _frames(run, most)
    shown, columns = run.isel(time=index), Columns()
    columns.add("time", shown["time"].to_numpy(), exact=True)
    _add_motion(columns, shown, model)
    for number in range(run.sizes["wheel"]):
        for name in WHEEL:
            columns.add(f"w{number}.{name}", shown[name].to_numpy()[:, number])
    patches = _add_patches(columns, shown, model)
    bars = _add_elements(columns, run, model, index)
    _add_named(columns, shown)
    done = _add_forces(columns, run, most)
    brake, distance = model.case.brake, run["distance"].to_numpy()
    motors = model.case.traction is not None or (brake is not None and brake.by_traction_motors)
    way, acting = (float(np.nanmin(distance)), float(np.nanmax(distance))), (patches, brake is not None, motors)
    head = head_of(model, _texts(run, label, str(run.attrs["status_message"])), bars, way, acting)
    head |= {"frames": len(index), "samples": int(run.sizes["time"]), "errors": errors}
    head |= {"filter": done, "columns": columns.places}
    head["plots"] = plots(head)
    return Scene(head, columns)


def head_of(
    model: AssembledModel,
    texts: tuple[str, str, str, str],
    elements: list[dict[str, Any]],
    way: tuple[float, float],
    acting: tuple[int, bool, bool],
) -> dict[str, Any]:
    """What every scene says of its model.

    Args:
        model: what is shown.
        texts: label, case, title, and how it ended.
        elements: as the page draws them.
        way: least and greatest distance of the line that is drawn [m].
        acting: patches of a wheel, and whether there are brakes and motors.
    """
    return {
        **dict(zip(("label", "case", "title", "status"), texts, strict=True)),
        "support": model.case.support.data.kind,
        "gravity": model.case.gravity,
        "bodies": parts.bodies(model),
        "wheels": parts.wheels(model),
        "elements": elements,
        "shapes": parts.shapes(model),
        "line": parts.track(model, *way),
        **dict(zip(("patches", "brakes", "motors"), acting, strict=True)),
        "axles": list(model.wheelsets),
    }


def _texts(results: xr.Dataset, label: str, status: str) -> tuple[str, str, str, str]:
    return label or str(results.attrs["case"]), str(results.attrs["case"]), str(results.attrs["title"]), status


def model_of(run: xr.Dataset) -> AssembledModel:
    """The assembled model of the case that a run carries.

    Raises:
        ResultsError: the results hold no motion of bodies, or their case cannot be read by this version.
    """
    missing = [name for name in recorded_names(run) if name not in run]
    if missing or "time" not in run.sizes or "config_toml" not in run.attrs:
        lacking = ", ".join(missing[:3]) or "a time or the case"
        raise ResultsError(f"these results hold no motion of bodies ({lacking}); view takes the run.nc of a run")
    if run.sizes["time"] < 2:
        raise ResultsError("this run has fewer than two samples; nothing moves")
    return _model_in(run, "results")


def _model_in(results: xr.Dataset, what: str) -> AssembledModel:
    try:
        RunInfo.of(results)
        return assemble(case_from_toml(str(results.attrs["config_toml"]), f"the case of the {what}", allow_code=True))
    except (ConfigError, KeyError, ValueError, OSError) as error:
        raise ResultsError(f"the case of these {what} cannot be read: {str(error).splitlines()[0]}") from None


def _frames(run: xr.Dataset, most: int) -> tuple[NDArray[np.intp], dict[str, float]]:
    def columns(of: xr.Dataset) -> Array:
        return of.to_array().transpose("time", ...).to_numpy().reshape(run.sizes["time"], -1)

    moving = RunInfo.of(run).moving
    drawn = {
        "position_mm": 1e3 * columns(run[["longitudinal", "lateral", "vertical"]].sel(body=moving)),
        "angle_mrad": 1e3 * columns(run[["roll", "yaw"]].sel(body=moving)),
        "force_kn": 1e-3 * columns(run[["lateral_force", "vertical_force"]]),
    }
    return thinned(run["time"].to_numpy(), drawn, ALLOWED, most)


def _add_motion(columns: Columns, shown: xr.Dataset, model: AssembledModel) -> None:
    """Coordinates that change, of each body by its number."""
    spinning = {*model.wheelsets, *model.rollers}
    for number, body in enumerate(model.bodies):
        for name in MOTION:
            values = shown[name].sel(body=body).to_numpy()
            if np.nanmax(np.abs(values), initial=0.0) > _MOVES:
                columns.add(f"b{number}.{name}", values, exact=name == "pitch" and body in spinning)


def _add_forces(columns: Columns, run: xr.Dataset, most: int) -> str:
    """Y and Q as a report has them, at times at which their extremes lie; what was done to them."""
    read = wheel_forces(run)
    try:
        shown = filtered(read)
    except ValueError:  # too short or too coarse for the filter
        shown = unfiltered(read)
    for name in ("guiding_force", "wheel_load"):
        values = shown[name].transpose("time", "wheel").to_numpy()
        kept = extremes(values, most)
        columns.add(f"time.{name}", shown["time"].to_numpy()[kept], exact=True)
        for number in range(values.shape[1]):
            columns.add(f"w{number}.{name}", values[kept, number])
    done = str(shown["guiding_force"].attrs.get("filter", ""))
    return f"low pass {done}" if done else "unfiltered"


def _add_patches(columns: Columns, shown: xr.Dataset, model: AssembledModel) -> int:
    count = int(np.nanmax(shown["patch_count"].to_numpy(), initial=0.0))
    count = max(1, min(count, _MOST_PATCHES, shown.sizes["patch"]))
    try:
        places = contact_places(model, shown, count)
    except ValueError as error:
        raise ResultsError(f"no wheel can stand where these results have one: {error}") from None
    for number in range(shown.sizes["wheel"]):
        for patch in range(count):
            for name in PATCH:
                columns.add(f"w{number}.p{patch}.{name}", shown[f"patch_{name}"].to_numpy()[:, number, patch])
            for k, name in enumerate(PLACE):
                columns.add(f"w{number}.p{patch}.{name}", places[:, number, patch, k])
    return count


def _add_elements(
    columns: Columns, run: xr.Dataset, model: AssembledModel, index: NDArray[np.intp]
) -> list[dict[str, Any]]:
    """A column per element: its force or moment in the direction in which that varies most, over the first sample."""
    table = parts.elements(model)
    for element in table:
        names = {way: f"element_{'force' if way in 'xyz' else 'moment'}_{way}" for way in element["directions"]}
        found = {way: run[name].to_numpy()[:, element["number"]] for way, name in names.items()}
        way = "z" if element["carries"] else max(found, key=lambda name: float(np.nan_to_num(np.nanstd(found[name]))))
        rest = float(found[way][0]) if element["carries"] else 0.0
        element["direction"], element["rest"] = way, rest
        element["largest"] = float(np.nanmax(np.abs(found[way] - rest), initial=0.0))
        columns.add(f"e{element['number']}", found[way][index] - rest)
    return table


def _add_named(columns: Columns, shown: xr.Dataset) -> None:
    for name in TRAIN:
        if name in shown:
            columns.add(name, shown[name].to_numpy(), exact=name == "distance")
    for name in AXLE if "axle" in shown.sizes else ():
        for number in range(len(RunInfo.of(shown).wheelsets)):
            columns.add(f"a{number}.{name}", shown[name].to_numpy()[:, number])


_SMALL = 1e-4
"""Share of the largest displacement or angle of a mode: less is not seen."""


def holds_modes(results: xr.Dataset) -> bool:
    """Whether results are modes, as `stability` finds them."""
    return "shape_amplitude" in results and "shape_phase" in results


def mode_scene(modes: xr.Dataset, *, label: str = "") -> Scene:
    """The scene of the modes of `stability`, called by its label or its case.

    Raises:
        ResultsError: their case cannot be read by this version.
    """
    model = _model_in(modes, "modes")
    elements = [
        {**one, "direction": "z" if "z" in one["directions"] else one["directions"][0], "rest": 0.0, "largest": 0.0}
        for one in parts.elements(model)
    ]
    speeds = [float(v) for v in modes["speed"].to_numpy()]
    critical = float(modes.attrs.get("linear_critical_speed_kmh", np.nan))
    head = head_of(model, _texts(modes, label, ""), elements, (0.0, 0.0), (0, False, False)) | {
        "frames": 0,
        "samples": 0,
        "errors": {},
        "columns": {},
        "plots": [],
        "speeds": speeds,
        "speed": int(np.argmin(np.abs(np.array(speeds) - critical))) if np.isfinite(critical) else len(speeds) - 1,
        "mode": _first(modes),
        "modes": [_mode(modes.sel(mode=name), model.bodies) for name in modes["mode"].to_numpy().tolist()],
    }
    return Scene(head, Columns())


def _first(modes: xr.Dataset) -> int:
    """Number of the mode that is shown first: the one that becomes unstable first, else a hunting mode."""
    names = modes["mode"].to_numpy().tolist()
    chosen = modes.attrs.get("linear_critical_mode") or modes.attrs.get("hunting_mode")
    return names.index(chosen) if chosen in names else 0


def _mode(mode: xr.Dataset, bodies: tuple[str, ...]) -> dict[str, Any]:
    """Frequency, damping and shape at each speed: coordinate -> amplitude and phase, as in a run's columns."""
    amplitude, phase = mode["shape_amplitude"].to_numpy(), np.radians(mode["shape_phase"].to_numpy())
    names = [str(name) for name in mode["body"].to_numpy()]
    shapes = []
    for speed in range(amplitude.shape[0]):
        largest = float(np.nanmax(amplitude[speed], initial=0.0)) or 1.0
        shapes.append(
            {
                f"b{bodies.index(body)}.{MOTION[k]}": [
                    round(float(amplitude[speed, b, k]) / largest, 5),
                    round(float(phase[speed, b, k]), 4),
                ]
                for b, body in enumerate(names)
                for k in range(len(MOTION))
                if amplitude[speed, b, k] > _SMALL * largest
            }
        )
    finite = {key: [_number(v) for v in mode[key].to_numpy()] for key in ("frequency", "damping")}
    return {"name": str(mode["mode"].item()), **finite, "shapes": shapes}


def _number(value: float) -> float | None:
    return round(float(value), 6) if np.isfinite(value) else None
