"""The distance of the contacts in place of the gauge: where the wheels then touch, and mistakes in one line each."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from rollerrig import Case, ConfigError, load_case
from rollerrig.cases import on_rig
from rollerrig.cli.describe import describe_part
from rollerrig.config import load_support
from rollerrig.contact_analysis.conicity import shift_table
from rollerrig.similitude import scale_case, similitude

TRACK, ROLLERS = "contact_benchmark_track", "contact_benchmark_rollers"
"""S1002 on UIC60."""


def touching(case: Case) -> float:
    """Distance of the points at which the core finds the centred wheelset to touch [m]."""
    wheel = case.vehicle.data.wheel
    contacts = shift_table(case, 1e-4, 1e-4)["wheel_abscissa"].sel(lateral=0.0, method="nearest")
    return wheel.back_to_back + 2 * wheel.tape_circle + float(contacts.sum())


def message(case: Case, changes: dict[str, object]) -> str:
    with pytest.raises(ConfigError) as error:
        case.with_changes(changes)
    return "\n".join(map(str, error.value.problems)).partition(": ")[2]


@pytest.mark.parametrize("radius", ["5 mm", "300 mm"])
@pytest.mark.parametrize("conicity", [0.025, 0.1])
def test_a_cone_on_a_circle_has_the_gauge_of_the_closed_form(conicity: float, radius: str) -> None:
    head = (
        {"kind": "arc", "radius": radius, "half_width": "4 mm"}
        if radius == "5 mm"
        else {"kind": "arc", "radius": radius}
    )
    case = load_case("cooperrider_bogie").with_changes({
        "vehicle.wheel.profile.conicity": conicity,
        "support.profile": head,
        "support.contact_distance": "1432.6 mm",
    })  # fmt: skip
    r, depth = float(radius.split()[0]) / 1e3, 1e-3
    inwards = r * math.sin(math.atan(conicity))
    expected = 2 * (0.7163 + inwards - math.sqrt(2 * r * depth - depth**2))
    assert case.support.data.gauge == pytest.approx(expected, abs=1e-7)
    assert touching(case) == pytest.approx(1.4326, abs=1e-7)


@pytest.mark.parametrize("name", [TRACK, ROLLERS])
@pytest.mark.parametrize("distance", [1.475, 1.508, 1.53])
def test_worn_shapes_touch_as_far_apart_as_asked(name: str, distance: float) -> None:
    case = load_case(name).with_changes({"support.contact_distance": distance})
    assert touching(case) == pytest.approx(distance, abs=2e-7)


def test_other_wheels_and_rollers_keep_the_distance() -> None:
    case = load_case("cooperrider_bogie").with_changes({"support.contact_distance": "1430 mm"})
    steeper = case.with_changes({"vehicle.wheel.profile.conicity": 0.1})
    assert steeper.support.data.gauge > case.support.data.gauge + 0.02
    assert touching(steeper) == pytest.approx(1.43, abs=1e-7)
    assert touching(on_rig(case)) == pytest.approx(1.43, abs=1e-7)


def test_a_model_has_the_distance_at_its_scale() -> None:
    case = load_case(ROLLERS).with_changes({"support.contact_distance": 1.51})
    model = scale_case(case, similitude("mmu"), strategy="mmu")
    assert model.support.data.contact_distance == pytest.approx(1.51 / 5)
    assert model.support.data.gauge == pytest.approx(case.support.data.gauge / 5, abs=1e-8)


def test_a_file_has_what_was_given(tmp_path: Path) -> None:
    case = load_case(TRACK).with_changes({"support.contact_distance": 1.51})
    for text in (case.to_toml(), case.to_short_toml()):
        assert "\ncontact_distance = 1.51\n" in text
        assert "\ngauge = " not in text
        (tmp_path / "case.toml").write_text(text)
        assert load_case(tmp_path / "case.toml") == case
    assert case.with_changes({"support.gauge": 1.435}) == load_case(TRACK)


def test_a_support_alone_is_described_by_what_it_gives(tmp_path: Path) -> None:
    file = tmp_path / "head.toml"
    file.write_text(
        'name = "head"\nkind = "track"\nprofile = { kind = "arc", radius = 0.3 }\ncontact_distance_mm = 1432.6\n'
    )
    assert describe_part(load_support(file)) == ["head: track, contacts 1432.6 mm apart, rigid rails"]


def test_mistakes() -> None:
    case = load_case(TRACK)
    assert message(case, {"support.contact_distance": 1.5, "support.gauge": 1.435}) == (
        "support.contact_distance: 1.5; allowed without gauge, which follows from it"
    )
    assert message(case, {"support.contact_distance": 1.51, "support.right_profile": "en_60e1_1_40"}).endswith(
        "allowed with the same head left and right; right_profile is another one"
    )
    no_gauge = "no gauge has contacts of these profiles so far apart; allowed nearest to it:"
    jump = message(case, {"support.contact_distance": "1490 mm"})
    assert jump == f"support.contact_distance: 1.49; {no_gauge} 1483.95 mm or 1504.36 mm"
    assert message(case, {"support.contact_distance": 1.7}) == f"support.contact_distance: 1.7; {no_gauge} 1619.98 mm"
