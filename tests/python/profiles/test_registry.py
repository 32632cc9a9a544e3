"""Names, specifications, and what is said to a wrong one."""

import pytest

from rollerrig.profiles import CATALOGUE, SHAPES, ProfileError, profile_from_spec


@pytest.mark.parametrize("name", CATALOGUE)
def test_every_name_of_the_catalogue_builds_for_every_use_it_allows(name):
    _, uses = SHAPES[CATALOGUE[name]["kind"]]
    for kind in uses:
        table = profile_from_spec(name, kind)
        assert table.kind == kind
        assert table.source
        assert table.domain[0] < 0 < table.domain[1]


def test_a_specification_is_not_changed_by_its_use():
    spec = {"kind": "uic60", "inclination": 0.025}
    profile_from_spec(spec, "rail")
    assert spec == {"kind": "uic60", "inclination": 0.025}


def test_a_name_and_its_specification_give_the_same_table():
    by_name = profile_from_spec("cone_1_40", "wheel")
    by_spec = profile_from_spec({"kind": "cone", "conicity": 0.025}, "wheel")
    assert by_name.coefficients.tobytes() == by_spec.coefficients.tobytes()


@pytest.mark.parametrize(
    ("spec", "kind", "message"),
    [
        ("s1020", "wheel", r"'s1020' is not one of .*did you mean 's1002'"),
        ({"kind": "uic6"}, "rail", r"did you mean 'uic60'"),
        ({}, "rail", r"kind: None is not one of"),
        ({"kind": ["uic60"]}, "rail", r"is not one of"),
        ({"kind": "uic60"}, "rail", r"key 'inclination' is missing"),
        ({"kind": "uic60", "inclinatoin": 0.025}, "rail", r"did you mean 'inclination'"),
        ({"kind": "uic60", "inclination": "1:40"}, "rail", r"'1:40' is not a finite number"),
        ({"kind": "uic60", "inclination": True}, "rail", r"not a finite number"),
        ({"kind": "uic60", "inclination": float("nan")}, "rail", r"not a finite number"),
        ({"kind": "uic60", "inclination": 0.025, "variant": ["benchmark"]}, "rail", r"is not a text"),
        ({"kind": "file", "path": "x", "require_flange": "no"}, "wheel", r"not true or false"),
        ({"kind": "file", "path": "x", "base_dir": "/"}, "wheel", r"key 'base_dir' is not one of"),
        ({"kind": "s1002"}, "rail", r"is a wheel profile and cannot be used as a rail"),
        ({"kind": "uic60", "inclination": 0.0}, "wheel", r"is a rail profile and cannot be used as a wheel"),
    ],
)
def test_a_wrong_specification_is_named_with_a_guess(spec, kind, message):
    with pytest.raises(ProfileError, match=message):
        profile_from_spec(spec, kind)
