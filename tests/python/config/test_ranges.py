"""Every number of a configuration has a range; what lies outside is refused, what lies inside can be checked."""

from __future__ import annotations

import contextlib
import copy
import math
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import pytest

from rollerrig.catalog import catalog_text
from rollerrig.cli.describe import describe_case
from rollerrig.config import Case, ConfigError, explain, json_schema, load_case
from rollerrig.config.schema.units import Quantity
from rollerrig.config.validate.messages import item_labels
from rollerrig.simulation.starting_state import StartError

from .schema_walk import Place, Raw, WholeNumber, build, inner, numbers_in, places, put, tables, whole_cases, with_value

ABSURD = (1e300, -1e300, 1e17, -1e17, math.nan, math.inf, -math.inf, True, 10**400, 2**63, -(2**63), "1e300 m", "x")
NEARLY_NOTHING = (1e-300, -1e-300, 5e-324)


def ranges_below(annotation: Any) -> Iterator[Quantity | WholeNumber | None]:
    yield from numbers_in(annotation)
    for item in inner(annotation):
        if item is not Ellipsis:
            yield from ranges_below(item)


def numeric_fields() -> dict[tuple[type, str], list[Quantity | WholeNumber | None]]:
    found = {}
    for table in tables(Case):
        for name, field in table.model_fields.items():
            annotation = Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation
            if ranges := list(ranges_below(annotation)):
                found[table, name] = ranges
    return found


def test_every_number_of_the_schema_has_a_finite_range() -> None:
    assert len(numeric_fields()) > 200
    for (table, name), ranges in numeric_fields().items():
        for one in ranges:
            assert one is not None, f"{table.__name__}.{name} has no range"
            assert -1e12 <= one.least < one.most <= 1e14, f"{table.__name__}.{name}"


def test_the_walk_meets_every_number_of_the_schema() -> None:
    met = {place.field for raw in whole_cases().values() for place in places(build(raw))}
    assert met == numeric_fields().keys()


def test_explain_and_the_json_schema_show_the_ranges() -> None:
    assert "from 0.001 to 1e+06 m, with its unit written beyond 10 m" in explain("support.roller_radius")
    radius = json_schema()["$defs"]["Rig"]["properties"]["roller_radius"]
    assert (radius["anyOf"][0]["minimum"], radius["anyOf"][0]["maximum"], radius["x-range"]) == (1e-3, 10, [1e-3, 1e6])


def numbers_of(name: str) -> list[Place]:
    """Places of a case; the hundreds of the whole vehicle are looked at in one of them."""
    found = places(build(whole_cases()[name]))
    shared = ("vehicle.data.body.", "vehicle.data.element.")
    return [place for place in found if name in ("track", "small") or not place.key.startswith(shared)]


def label(raw: Raw, path: tuple[str | int, ...]) -> str:
    """The key as a message writes it: items of lists by their names."""
    holder: Any = raw
    text = ""
    for part in path:
        named = f".{part}" if isinstance(part, str) else item_labels(holder)[part]
        text += named if named.startswith(("[", ".")) else f".{named}"
        holder = holder[part] if isinstance(holder, list) or part in holder else None
    return text.removeprefix(".")


@pytest.mark.parametrize("value", ABSURD, ids=lambda v: f"{str(v)[:8]}")
@pytest.mark.parametrize("name", whole_cases())
def test_what_no_number_may_be_is_refused_with_the_range(name: str, value: object) -> None:
    """All numbers of a case are spoiled at once: all of them are told, each with its key, its value and what is allowed."""
    raw = copy.deepcopy(whole_cases()[name])
    override = "support.roller_radius"  # of the rig's own, which then is not looked at
    spoiled = [place for place in numbers_of(name) if not fits(place, value) and place.key != override]
    for place in sorted(
        spoiled, key=lambda place: -len(place.path)
    ):  # a list inside of a list first, then nothing above it
        put(raw, place, value)
    with pytest.raises(ConfigError) as error:
        build(raw)
    told = {problem.key: problem for problem in error.value.problems}
    for place in spoiled:
        problem = told.get(label(raw, place.path)) or told.get(label(raw, place.path[:-1]))
        assert problem is not None, f"{place.key} = {value!r} is not refused"
        assert problem.file == "case.toml"
        assert problem.allowed.startswith(("allowed: ", "needed: "))
        if isinstance(place.range, Quantity) and problem.key == label(raw, place.path):
            assert place.range.bounds in problem.allowed or "whole number" in problem.allowed


def fits(place: Place, value: object) -> bool:
    assert place.range is not None
    return (
        isinstance(value, float | int)
        and not isinstance(value, bool)
        and place.range.least <= value <= place.range.most
    )


def survives(raw: Raw) -> None:
    """Refused in words, or accepted; what is accepted can be checked and written."""
    with contextlib.suppress(ConfigError, StartError):
        describe_case(build(raw))


def written(place: Place, value: float) -> object:
    return place.range.as_written(value) if isinstance(place.range, Quantity) else int(value)


@pytest.mark.slow
@pytest.mark.parametrize("name", whole_cases())
def test_the_ends_of_every_range_can_be_checked(name: str) -> None:
    """A sample of the places, the same in every run; all of them take five minutes."""
    raw = whole_cases()[name]
    by_field = {place.field: place for place in numbers_of(name)}
    for place in random.Random(name).sample(list(by_field.values()), 8):
        assert place.range is not None
        for value in (place.range.least, place.range.most, *(v for v in (0.0, *NEARLY_NOTHING) if fits(place, v))):
            survives(with_value(raw, place, written(place, value)))


@pytest.mark.parametrize(
    ("case", "key", "value", "bounds"),
    [
        ("adhesion_brake", "slide_protection.sample_time", 1e300, "from 1e-06 to 1 s"),
        ("adhesion_brake", "slide_protection.delay", 1e300, "from 0 to 1 s"),
        ("adhesion_brake", "rig_control.sample_time", 1e300, "from 1e-06 to 1 s"),
        ("adhesion_brake", "rig_control.delay", 1e300, "from 0 to 1 s"),
        ("adhesion_brake", "rig_control.feedback.bandwidth", 1e300, "from 0.0001 to 1e+07 Hz"),
        ("adhesion_start", "wheel_slip_control.sample_time", 1e300, "from 1e-06 to 1 s"),
        ("adhesion_start", "wheel_slip_control.slip_speed", 1e300, "from 1e-06 to 1000 m/s"),
        ("adhesion_brake", "time.sampling_step", 1e-300, "from 1e-06 to 1 s"),
        ("adhesion_recovery", "adhesion.cell_length", 1e-12, "from 0.0001 to 100 m"),
        ("bogie_rollers_constant", "time.step", 1e-300, "from 1e-08 to 1 s"),
    ],
)
def test_what_once_ended_in_a_traceback_or_a_hang_is_refused(case: str, key: str, value: float, bounds: str) -> None:
    with pytest.raises(ConfigError) as error:
        load_case(case).with_changes({key: value})
    (problem,) = error.value.problems
    assert (problem.key, problem.value) == (key, str(value))
    assert bounds in problem.allowed


@pytest.mark.parametrize(
    ("case", "changes", "key", "told"),
    [
        ("vehicle_track_irregular", {"time.duration": 1e5, "time.output_step": "0.1 ms"}, "time.output_step",
         "GB; allowed for 100000 s: at least "),
        ("bogie_rollers_constant", {"time.duration": 1e5, "time.step": "0.01 us", "time.output_step": 10}, "time.step",
         "steps would take days; allowed for 100000 s: at least 0.1 ms"),
        ("adhesion_recovery", {"adhesion.cell_length": "1 mm"}, "adhesion.cell_length",
         "1024 cells are kept of wheelsets"),
    ],
)  # fmt: skip
def test_sizes_that_only_together_are_too_large_are_refused(
    case: str, changes: dict[str, object], key: str, told: str
) -> None:
    with pytest.raises(ConfigError) as error:
        load_case(case).with_changes(changes)
    (problem,) = error.value.problems
    assert problem.key == key
    assert told in problem.allowed


def test_a_load_that_only_the_statics_tell_is_refused() -> None:
    case = load_case("vehicle_track_irregular").with_changes({"vehicle.body.car_body.mass": "99900 t"})
    told = r"vehicle\.element\.primary_1_left: preload must be at most 1e8, got -1\.2\d*e\+08 .*allowed: lighter bodies above it"
    with pytest.raises(ConfigError, match=told):
        describe_case(case)


def test_wheel_and_rail_of_different_models_are_refused() -> None:
    with pytest.raises(ConfigError) as error:
        build(with_length_scale(copy.deepcopy(whole_cases()["flat"]), 1e-3))
    (problem,) = error.value.problems
    assert (problem.key, problem.value) == ("support.data.profile.length_scale", "1.0")
    assert problem.allowed == "allowed: about that of the wheel, 0.001, at most a factor of 10 from it"


def with_length_scale(raw: Raw, scale: float) -> Raw:
    raw["vehicle"]["data"]["wheel"]["profile"]["length_scale"] = scale
    return raw


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('use = "full_scale_rig"', 'use = "full_scale_rig"\nroller_radius = 500',
         "did you mean '500 mm' or '500 m'?"),
        ('speed = "150 km/h"', "speed = 60", "did you mean '60 km/h' or '60 m/s'?"),
        ('speed = "150 km/h"', "speed_table = [[0, 5], [10, 80]]", "did you mean '80 km/h' or '80 m/s'?"),
    ],
)  # fmt: skip
def test_a_number_in_another_unit_is_asked_about(tmp_path: Path, old: str, new: str, told: str) -> None:
    text = catalog_text("bogie_rollers_constant").replace(old, new)
    (tmp_path / "case.toml").write_text(text)
    with pytest.raises(ConfigError, match=told):
        load_case(tmp_path / "case.toml")


def test_a_case_with_a_large_radius_and_speed_reads_what_it_writes(tmp_path: Path) -> None:
    case = load_case("bogie_rollers_constant").with_changes(
        {"support.roller_radius": "500 m", "motion.speed": "300 km/h"}
    )
    assert case.support.data.roller_radius == 500.0  # type: ignore[union-attr]
    for text in (case.to_toml(), case.to_short_toml()):
        (tmp_path / "case.toml").write_text(text)
        assert load_case(tmp_path / "case.toml").motion.speed == case.motion.speed == 300 / 3.6
    assert case.with_changes({"time.duration": "1 s"}).motion.speed == case.motion.speed
