"""The drawing of a vehicle: to scale, everything in it named."""

from __future__ import annotations

from itertools import combinations

import pytest
from matplotlib.patches import Circle
from matplotlib.text import Text

from rollerrig.config import load_case
from rollerrig.plot import vehicle, vehicle_names
from rollerrig.plot.vehicle_scene import family


@pytest.fixture(scope="module")
def bogie():
    return vehicle("adhesion_brake")


def names(figure) -> str:
    """What the legend and the names above the views say."""
    texts = [*figure.legends[0].get_texts(), *(text for axes in figure.axes for text in axes.texts)]
    return "\n".join(text.get_text() for text in texts)


@pytest.mark.slow
def test_the_views_have_one_scale_and_the_axes_of_the_conventions(bogie) -> None:
    side, end, plan = bogie.axes
    assert [axes.get_title(loc="left").split(":")[0] for axes in bogie.axes] == [
        "from the right",
        "from behind",
        "from above",
    ]
    for axes in bogie.axes:
        box = axes.get_position()
        across = abs(axes.get_xlim()[1] - axes.get_xlim()[0]) / (box.width * bogie.get_figwidth())
        up = (axes.get_ylim()[1] - axes.get_ylim()[0]) / (box.height * bogie.get_figheight())
        assert across == pytest.approx(up, rel=1e-6)
        assert across == pytest.approx(
            (side.get_ylim()[1] - side.get_ylim()[0]) / (side.get_position().height * bogie.get_figheight())
        )
    assert side.get_xlim()[0] < side.get_xlim()[1]
    assert end.get_xlim()[0] > end.get_xlim()[1]  # left is left
    assert plan.get_ylim()[0] < plan.get_ylim()[1]


@pytest.mark.slow
def test_wheels_stand_on_the_rollers(bogie) -> None:
    circles = [patch for patch in bogie.axes[0].patches if isinstance(patch, Circle)]
    rollers, wheels = circles[:2], circles[2:]
    assert [roller.radius for roller in rollers] == [0.725, 0.725]
    assert [wheel.radius for wheel in wheels] == [0.46, 0.46]
    assert sorted(wheel.center[0] for wheel in wheels) == pytest.approx([-1.28, 1.28])
    assert {round(wheel.center[1] - wheel.radius, 9) for wheel in wheels} == {0.0}
    assert {roller.center[1] + roller.radius for roller in rollers} == {0.0}


@pytest.mark.slow
def test_everything_is_named(bogie) -> None:
    case = load_case("adhesion_brake")
    text = names(bogie)
    part = case.vehicle.part
    for name in (*part.bodies, *part.fixed, *(family(e.name) for e in case.vehicle.data.elements_in(part))):
        assert name in text
    for words in ("car_body, held", "primary ×4: spring x, y, z; damper x, y, z", "rollers of 725 mm",
                  "acting: adhesion, brake, slide protection, rig control"):  # fmt: skip
        assert words in text
    assert "locked x" in names(vehicle("vehicle_curve"))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["wheelset_rollers", "locomotive_traction", "scaled_brake", "contact_benchmark_track"])
def test_every_kind_of_case_is_drawn(name: str) -> None:
    figure = vehicle(name)
    assert all(axes.patches for axes in figure.axes)
    assert figure.get_figheight() < 16


def test_families_are_elements_of_one_name() -> None:
    assert [family(name) for name in ("primary_1_left", "bumpstop_front", "rod", "left")] == [
        "primary",
        "bumpstop",
        "rod",
        "left",
    ]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["adhesion_brake", "vehicle_curve", "locomotive_traction", "wheelset_rollers"])
def test_everything_is_named_in_the_drawing_and_no_name_lies_upon_another(name: str) -> None:
    case, figure = load_case(name), vehicle(name)
    renderer = figure.canvas.get_renderer()
    texts = [text for axes in figure.axes for text in axes.texts if text.get_gid() == "callout"]
    part = case.vehicle.part
    named = [text.get_text() for text in texts]
    families = {family(one.name) for one in case.vehicle.data.elements_in(part)}
    for what in (*part.bodies, *part.fixed, *families):
        assert sum(one.split(",")[0] == what for one in named) == 1, what
    assert len(named) == len(part.bodies) + len(part.fixed) + len(families) + 1  # the roller or rail
    if case.brake is not None:
        assert "wheelset_1, brake" in named
    for text in texts:
        text.update_positions(renderer)
    boxes = [Text.get_window_extent(text, renderer) for text in texts]  # without its line
    titles = [axes._left_title.get_window_extent(renderer) for axes in figure.axes]
    assert [(a, b) for a, b in combinations([*boxes, *titles], 2) if a.overlaps(b)] == []
    inside = figure.bbox
    assert all(inside.x0 <= box.x0 and box.x1 <= inside.x1 and box.y1 <= inside.y1 for box in [*boxes, *titles])
    ends = [text.axes.transData.transform(text.xy) for text in texts if text.axes is not None]
    assert all(box.y0 > end[1] for box, end in zip(boxes, ends, strict=True))  # above what it names


def crossings(places: dict[int, float], anchors: list[tuple[float, float]], height: float) -> int:
    """Pairs of lines that cross on their way from names at a height to different places."""

    def turn(a, b, c) -> float:
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    count = 0
    for i, j in combinations(places, 2):
        a, b, c, d = (places[i], height), anchors[i], (places[j], height), anchors[j]
        count += turn(a, b, c) * turn(a, b, d) < 0.0 and turn(c, d, a) * turn(c, d, b) < 0.0
    return count


def test_lines_cross_less_than_in_the_order_of_their_places() -> None:
    anchors = [(100.0, 0.0), (100.0, 40.0), (100.0, 80.0)]
    order = vehicle_names.in_order(anchors)
    places = vehicle_names._spread(order, anchors, [30.0] * 3, (0.0, 400.0))
    assert crossings(places, anchors, 120.0) == 0
    assert crossings({0: 100.0, 1: 135.0, 2: 170.0}, anchors, 120.0) == 1
