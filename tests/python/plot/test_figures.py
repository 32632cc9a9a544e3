"""Figures: axes carry units, the same input gives the same bytes, nothing of the user's settings shows."""

from __future__ import annotations

import math

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.text import Text

from rollerrig.plot import (
    amplitude_over_speed,
    damping_map,
    damping_over_speed,
    figure_bytes,
    frequency_over_speed,
    hunting_over_time,
    limit_cycle_diagram,
    mode_shapes,
    ramp_over_speed,
    root_locus,
    style,
    tornado_diagram,
    traction_forces,
    traction_sliding,
    wheel_rail_forces,
)
from rollerrig.plot.contact import COMPARED, comparison_figure
from rollerrig.plot.hunting import MOST_BARS
from rollerrig.plot.style import house_style

TIME = np.linspace(0, 2, 201)
SPEED = np.array([60.0, 120.0, 180.0])
WHEELS = ["front", "rear"]


def modes() -> xr.Dataset:
    growth = np.array([[-1.0, -5.0], [0.2, -5.0], [1.0, -5.0]])
    frequency = np.array([[2.0, 10.0], [4.0, 10.0], [5.0, 10.0]])
    variables = {
        name: (("speed", "mode"), values) for name, values in (("growth_rate", growth), ("frequency", frequency))
    }
    damping = -growth / np.hypot(growth, 2 * np.pi * frequency)
    coordinates = {"speed": SPEED, "mode": ["hunting", "frame pitch"]}
    return xr.Dataset(
        {**variables, "damping": (("speed", "mode"), damping), "hunting_frequency": ("speed", [np.nan, 4.0, 5.0])},
        coordinates,
        {"linear_critical_speed_kmh": 110.0, "linear_critical_frequency_hz": 3.7, "hunting_mode": "hunting"},
    )


def shapes() -> xr.Dataset:
    bodies, ways = ["body", "wheelset_1"], ["longitudinal", "lateral", "vertical", "roll", "pitch", "yaw"]
    dims = ("speed", "mode", "body", "direction")
    size = np.broadcast_to(np.array([0.0, 1.0, 0.0, 0.2, 0.0, 0.1]), (3, 2, 2, 6))
    return (
        modes()
        .assign(
            shape_amplitude=(dims, size),
            shape_phase=(dims, 30.0 * size),
            energy_share=(dims, size / size[0, 0].sum()),
            position=(("body", "axis"), np.array([[0.0, 0.0, 1.8], [1.0, 0.0, 0.46]])),
            role=("body", ["car body", "wheelsets"]),
        )
        .assign_coords(body=bodies, direction=ways)
    )


def cycles() -> xr.Dataset:
    columns = {
        "speed": SPEED,
        "amplitude": [0.0, 1e-3, 2e-3],
        "frequency": [np.nan, 4.0, 5.0],
    }
    columns |= {"guiding_force": [np.nan, 1e4, 9e5], "sweep": ["up", "up", "down"], "status": ["ok", "ok", "derailed"]}
    variables = {f"cycle_{name}": ("cycle_point", values) for name, values in columns.items()}
    return xr.Dataset(variables, attrs={"critical_speed_by_continuation_kmh": 120.0})


def motion() -> xr.Dataset:
    lateral = 1e-3 * np.sin(20 * TIME)[:, None]
    return xr.Dataset(
        {"lateral": (("time", "body"), lateral), "speed": ("time", 20 + 5 * np.sin(np.pi * TIME / 2))},
        {"time": TIME, "body": ["front_frame"]},
        {"perturbation_times_s": "[0.5]"},
    )


def table() -> xr.Dataset:
    values = {"amplitude": [0.0, 1e-3, 2e-3], "oscillation_frequency": [np.nan, 4.0, 5.0], "persists": [0, 1, 1]}
    values |= {"decays": [1, 0, 0]}
    return xr.Dataset({name: ("speed", v) for name, v in values.items()}, {"speed": SPEED})


def traction() -> xr.Dataset:
    names = ("sliding", "sliding_theory", "longitudinal_creep_force", "longitudinal_creep_force_theory")
    both = (*names, "vertical_force", "vertical_force_theory")
    variables = {name: (("time", "wheel"), np.ones((len(TIME), 2))) for name in both}
    return xr.Dataset({**variables, "torque": ("time", TIME), "speed": ("time", TIME)}, {"time": TIME, "wheel": WHEELS})


def read_off() -> xr.Dataset:
    wave = 40e3 + 1e3 * np.sin(20 * TIME)[:, None] * np.ones(2)
    names = ("guiding_force", "wheel_load", "wear_number", "derailment_quotient")
    wheels = {name: (("time", "wheel"), wave, {"filter": "20 Hz"}) for name in names}
    shifting = {
        "guiding_force_sum": (("time", "wheelset"), wave[:, :1]),
        "guiding_force_sum_limit": ("wheelset", [45e3]),
    }
    coordinates = {"time": TIME, "wheel": ["wheelset_1_left", "wheelset_1_right"], "wheelset": ["wheelset_1"]}
    return xr.Dataset({**wheels, **shifting}, coordinates, {"prudhomme_factor": 0.85})


def on_track() -> xr.Dataset:
    line = {"curvature": ("time", 1e-3 * np.minimum(TIME, 1)), "cant": ("time", 0.1 * np.minimum(TIME, 1))}
    rail = 1e-3 * np.sin(7 * TIME)[:, None] * [1.0, -1.0]
    rails = dict.fromkeys(("rail_lateral", "rail_vertical"), (("time", "wheel"), rail))
    coordinates = {"time": TIME, "wheel": ["wheelset_1_left", "wheelset_1_right"], "body": ["wheelset_1"]}
    return xr.Dataset({**line, **rails, "lateral": (("time", "body"), rail[:, :1])}, coordinates)


def felt() -> xr.Dataset:
    values = np.sin(TIME)[:, None, None] * np.ones((2, 2))
    coordinates = {"time": TIME, "point": ["car_body, centre", "car_body over front_frame"]}
    coordinates |= {"direction": ["lateral", "vertical"], "filter": ("point", ["0.4 to 10 Hz"] * 2)}
    return xr.Dataset({"acceleration": (("time", "point", "direction"), values)}, coordinates)


def sensitivity(changes: list[float]) -> xr.Dataset:
    keys = [f"vehicle.element.primary_*.x.number_{k}" for k in range(len(changes))]
    return xr.Dataset(
        {"critical_speed_change": ("parameter", changes)}, {"parameter": keys}, {"linear_critical_speed_kmh": 200.0}
    )


def curving_sensitivity() -> xr.Dataset:
    """Of two wheels, of which the second pushes more, to the inside."""
    variables = {
        "value": ("parameter", [2.0, 0.5]),
        "guiding_force": ("wheel", [10.0, -40.0], {"units": "N"}),
        "guiding_force_derivative": (("parameter", "wheel"), [[9.0, 10.0], [9.0, -80.0]]),
    }
    return xr.Dataset(variables, {"parameter": ["one", "other"], "wheel": ["wheelset_1_left", "wheelset_1_right"]})


def distance() -> xr.DataArray:
    return xr.DataArray(40 * TIME, {"time": TIME}, "time", attrs={"units": "m", "long_name": "distance"})


FIGURES = {
    "wheel_forces": lambda: wheel_rail_forces.wheel_forces_over_time(read_off(), distance()),
    "quotient": lambda: wheel_rail_forces.quotient(read_off(), distance(), {"near": 45e3, "far": 1e9, "none": np.nan}),
    "track_shifting": lambda: wheel_rail_forces.track_shifting(read_off(), distance()),
    "wear": lambda: wheel_rail_forces.wear(read_off(), distance()),
    "accelerations": lambda: wheel_rail_forces.accelerations_along(felt(), distance()),
    "line": lambda: wheel_rail_forces.line_and_response(on_track(), distance()),
    "root_locus": lambda: root_locus(modes()),
    "damping": lambda: damping_over_speed(modes()),
    "damping_map": lambda: damping_map(modes()),
    "frequency": lambda: frequency_over_speed(modes(), cycles()),
    "limit_cycles": lambda: limit_cycle_diagram(cycles(), modes()),
    "mode_shapes": lambda: mode_shapes(shapes(), ["hunting", "frame pitch"], 110.0),
    "ramp": lambda: ramp_over_speed({"steel": motion()}, "front_frame", {"steel": {"linear": 80.0, "none": np.nan}}),
    "time": lambda: hunting_over_time([(60.0, motion()), (80.0, motion())], "front_frame"),
    "amplitude": lambda: amplitude_over_speed({"steel": table()}, {"linear": 100.0}),
    "tornado": lambda: tornado_diagram(sensitivity([0.1, -0.5, 0.3])),
    "tornado_curving": lambda: tornado_diagram(curving_sensitivity(), "guiding_force"),
    "sliding": lambda: traction_sliding(traction(), {w: w for w in WHEELS}),
    "forces": lambda: traction_forces(traction(), {w: w for w in WHEELS}),
}


@pytest.mark.parametrize("name", FIGURES)
def test_every_axis_carries_its_unit(name: str) -> None:
    figure = FIGURES[name]()
    labels = [label for axes in figure.axes for label in (axes.get_xlabel(), axes.get_ylabel()) if label]
    assert labels
    assert all("[" in label and label.rstrip(")").count("[") == label.count("]") for label in labels), labels


@pytest.mark.slow
@pytest.mark.parametrize("name", FIGURES)
def test_the_same_figure_gives_the_same_bytes(name: str) -> None:
    first = figure_bytes(FIGURES[name]())
    with mpl.rc_context({"font.size": 30, "lines.linewidth": 9}):
        second = figure_bytes(FIGURES[name]())
    assert first == second
    assert b"<dc:date>" not in first


def test_what_hardly_changes_is_not_drawn_as_if_it_did() -> None:
    """Y/Q of a vehicle that runs straight on is 0.011 and a millionth: no axis of 1e-6 with an offset."""
    still = read_off()
    for name in ("guiding_force", "wheel_load", "wear_number", "derailment_quotient", "guiding_force_sum"):
        middle = 0.011 if name in ("derailment_quotient", "wear_number") else 54e3
        still[name] = still[name].copy(data=middle * (1.0 + 2.5e-11 * still[name].to_numpy()))
    still["nadal_limit"] = 1.3
    (axes,) = wheel_rail_forces.quotient(still, limits={"EN 14363": 0.8}).axes
    assert np.ptp(axes.get_ylim()) == pytest.approx(0.05)
    for figure in (wheel_rail_forces.wheel_forces_over_time(still), wheel_rail_forces.track_shifting(still)):
        assert all(np.ptp(axes.get_ylim()) >= 2.0 for axes in figure.axes)  # [kN]
    (axes,) = wheel_rail_forces.wear(still).axes
    assert axes.get_ylim() == (0.0, 1.0)


def test_a_limit_in_sight_stays_in_sight_of_values_that_hardly_change() -> None:
    still = read_off()
    still["derailment_quotient"] = still["derailment_quotient"].copy(
        data=0.4 + 1e-7 * still["derailment_quotient"].to_numpy()
    )
    (axes,) = wheel_rail_forces.quotient(still, limits={"EN 14363": 0.8}).axes
    assert axes.get_ylim()[1] >= 0.8


def test_patches_are_counted_in_whole_numbers() -> None:
    lateral, models = 1e-3 * np.arange(-4.0, 5.0), ["hertz", "strips"]
    shape = (len(lateral), 2, 2)
    data = {name: (("lateral", "side", "model"), np.ones(shape)) for name in COMPARED}
    data["patches"] = (("lateral", "side", "model"), np.ones(shape) + (np.arange(9) % 2)[:, None, None])
    attributes = {"load_n": 54e3, "case": "bogie_track", "wheelset": "wheelset_1"}
    coordinates = {"lateral": lateral, "side": ["left", "right"], "model": models}
    figure = comparison_figure(xr.Dataset(data, coordinates, attributes))
    ticks = next(axes.get_yticks() for axes in figure.axes if axes.get_ylabel() == "patches")
    assert len(ticks) >= 2
    assert np.all(ticks == np.round(ticks))


@pytest.mark.slow
@pytest.mark.parametrize("name", FIGURES)
def test_numbers_in_figures_have_one_minus(name: str) -> None:
    with house_style():
        figure = FIGURES[name]()
        figure.draw_without_rendering()
        texts = [text.get_text() for axes in figure.axes for text in axes.findobj(Text)]  # type: ignore[attr-defined]
    assert not [text for text in texts if "\N{MINUS SIGN}" in text]


def test_limits_in_sight_are_drawn_and_others_named() -> None:
    figure = FIGURES["quotient"]()
    (axes,) = figure.axes
    assert [line.get_label() for line in axes.lines if str(line.get_label()).startswith("near")] == ["near: 4.5e+04"]
    assert axes.get_title("right") == "limits beyond these axes: far: 1e+09"
    assert axes.get_ylim()[1] < 1e5


def test_png_is_the_same_too() -> None:
    assert figure_bytes(root_locus(modes()), "png") == figure_bytes(root_locus(modes()), "png")


def drawn(name: str, panel: int, label: str) -> np.ndarray:
    """Ordinates of a labelled line."""
    lines = [line for line in FIGURES[name]().axes[panel].lines if line.get_label() == label]
    assert len(lines) == 1
    return np.asarray(lines[0].get_ydata(), dtype=float)


def test_runs_that_ended_early_are_drawn_as_neither() -> None:
    lost = table().assign(persists=("speed", [0, 0, 1]), decays=("speed", [1, 0, 0]))
    (axes,) = amplitude_over_speed({"steel": lost}).axes
    lines = {str(line.get_label()): list(line.get_xdata()) for line in axes.lines}
    assert lines["steel: persists"] == [180.0]
    assert lines["steel: decays"] == [60.0]
    assert lines["steel: not decided"] == [120.0]


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 4, 12, 40])
def test_the_damping_map_has_room_for_its_labels(count: int) -> None:
    """Also with few modes, where the figure is low."""
    names = [f"mode {k}" for k in range(count)]
    many = modes().isel(mode=[0] * count).assign_coords(mode=names)
    figure = damping_map(many)
    figure.canvas.draw()
    drawn_on = figure.bbox
    for axes in figure.axes:
        for label in (axes.xaxis.label, axes.yaxis.label):
            box = label.get_window_extent()
            assert not label.get_text() or (drawn_on.x0 <= box.x0 and box.x1 <= drawn_on.x1), label.get_text()
            assert not label.get_text() or (drawn_on.y0 <= box.y0 and box.y1 <= drawn_on.y1), label.get_text()


@pytest.mark.slow
def test_figures_draw_their_data_in_the_units_of_their_axes() -> None:
    forces = read_off()["wheel_load"].sel(wheel="wheelset_1_right").to_numpy()
    assert drawn("wheel_forces", 0, "wheelset 1 right") == pytest.approx(1e-3 * forces)
    assert drawn("track_shifting", 0, "wheelset 1") == pytest.approx(1e-3 * forces)
    assert drawn("wear", 0, "wheelset 1 left") == pytest.approx(forces)
    assert drawn("root_locus", 0, "hunting") == pytest.approx([2.0, 4.0, 5.0])
    assert drawn("damping", 0, "hunting") == pytest.approx(100 * modes()["damping"].sel(mode="hunting").to_numpy())
    assert drawn("frequency", 0, "frame pitch") == pytest.approx([10.0, 10.0, 10.0])
    assert drawn("amplitude", 0, "steel: persists") == pytest.approx([1.0, 2.0])
    assert drawn("amplitude", 0, "steel: decays") == pytest.approx([0.0])
    assert drawn("limit_cycles", 0, "upward sweep") == pytest.approx([0.0, 1.0])
    assert drawn("limit_cycles", 0, "downward sweep") == pytest.approx([2.0])
    assert drawn("sliding", 0, "front") == pytest.approx(np.full(len(TIME), 1e3))
    assert drawn("forces", 1, "closed form") == pytest.approx(np.full(len(TIME), 1e-3))
    lateral = 1e3 * motion()["lateral"].to_numpy()[:, 0]
    top = int(np.argmax(motion()["speed"].to_numpy()))
    assert drawn("ramp", 0, "speeding up") == pytest.approx(lateral[: top + 1])
    assert drawn("line", 1, "lateral, left") == pytest.approx(1e3 * on_track()["rail_lateral"].to_numpy()[:, 0])
    drawn_to_the_end = FIGURES["time"]().axes[1].lines[0].get_ydata()
    assert drawn_to_the_end == pytest.approx([*lateral, math.nan], nan_ok=True)  # the axis ends with the longest run
    (across,) = (line for line in FIGURES["ramp"]().axes[0].lines if list(line.get_xdata()) == [80.0, 80.0])
    assert across.get_linestyle() == "--"  # the critical speed that is known, not the other


def test_the_longest_bar_of_a_tornado_is_on_top_and_signs_can_be_read() -> None:
    (axes,) = FIGURES["tornado"]().axes
    places, widths = ([getattr(bar, f"get_{of}")() for bar in axes.patches] for of in ("y", "width"))
    assert widths == [-0.5, 0.3, 0.1]
    assert places == sorted(places)
    assert axes.yaxis_inverted()
    assert [label.get_text() for label in axes.get_yticklabels()] == [f"primary, x, number {k}" for k in (1, 2, 0)]
    assert [text.get_text() for text in axes.texts] == ["-0.5", "+0.3", "+0.1"]
    assert [bar.get_hatch() for bar in axes.patches] == ["///", "", ""]  # without colour, too
    (relative,) = axes.child_axes
    assert relative.get_xlabel() == "over the linear critical speed, 200 km/h [%]"
    axes.figure.canvas.draw()
    assert relative.get_xlim() == pytest.approx([0.5 * end for end in axes.get_xlim()])


def test_a_tornado_of_curving_is_that_of_the_wheel_with_the_largest_magnitude() -> None:
    (axes,) = FIGURES["tornado_curving"]().axes
    assert [bar.get_width() for bar in axes.patches] == pytest.approx([-0.4, 0.2])
    assert axes.get_xlabel() == "change of the guiding force, wheelset 1 right by 1 % more [N]"
    (relative,) = axes.child_axes
    assert relative.get_xlabel() == "over the guiding force, wheelset 1 right, 40 N [%]"


def test_a_tornado_of_many_numbers_shows_those_that_can_be_seen() -> None:
    bars = [len(tornado_diagram(sensitivity(own)).axes[0].patches) for own in ([1.0] * 40, [1.0, 1e-3], [])]
    assert bars == [MOST_BARS, 1, 0]


@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_is_drawn_into_given_axes_and_makes_no_others(name: str) -> None:
    own = len(FIGURES[name]().axes)
    figure = Figure()
    axes = tuple(figure.subplots(own, 1, squeeze=False)[:, 0])
    token = style._GIVEN.set(axes)
    try:
        FIGURES[name]()
    finally:
        style._GIVEN.reset(token)
    drawn = [len(one.lines) + len(one.collections) + len(one.patches) for one in axes]
    assert drawn[0] > 0
    assert figure.legends == []
    assert figure.axes[:own] == list(axes)
