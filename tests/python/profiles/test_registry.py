"""What a profile may be used for."""

import pytest

from catalogued import profile_table
from rollerrig.catalog import catalog_names
from rollerrig.config import load_profile
from rollerrig.profiles import SHAPES, ProfileError, profile_from_spec


@pytest.mark.parametrize("name", catalog_names("profile"))
def test_every_profile_of_the_catalogue_is_built_for_every_use_it_allows(name):
    _, uses = SHAPES[load_profile(name).kind]
    for kind in uses:
        table = profile_table(name, kind)
        assert table.kind == kind
        assert table.source
        assert table.domain[0] < 0 < table.domain[1]


def test_a_specification_is_not_changed_by_its_use():
    spec = {"kind": "uic60", "inclination": 0.025}
    profile_from_spec(spec, "rail")
    assert spec == {"kind": "uic60", "inclination": 0.025}


@pytest.mark.parametrize(("name", "kind"), [("s1002", "rail"), ("en_60e1_1_40", "wheel")])
def test_a_wheel_profile_is_no_rail_and_a_rail_no_wheel(name, kind):
    with pytest.raises(ProfileError, match=f"cannot be used as a {kind}"):
        profile_table(name, kind)
