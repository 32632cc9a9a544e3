"""Adhesion that recovers under sliding wheels: both units of its constant, and wheels that are cleaned too."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from rollerrig import ConfigError, simulate
from rollerrig.assembly.model import assemble
from rollerrig.config import Case, case_from_toml, load_case
from rollerrig.similitude import scale_case, similitude
from rollerrig.simulation.virtual_train import rail_patch
from rollerrig.study.runs.adhesion import track_case

RADIUS = 0.46


def recovering(**changes: object) -> Case:
    dotted = {f"adhesion.{key}": value for key, value in changes.items()}
    return load_case("adhesion_recovery").with_changes({"time.duration": "6 s", **dotted})


def sliding(case: Case) -> xr.Dataset:
    return simulate(case).sel(time=slice(5.0, 6.0))


def test_the_unit_beside_the_constant_says_what_it_goes_with() -> None:
    for text, per, value in (
        ("5e-6 m^2/J", "area", 5e-6),
        ("1.9e-4 m/J", "length", 1.9e-4),
        ("1.9e-4 1/N", "length", 1.9e-4),
    ):
        adhesion = recovering(recovery_constant=text).adhesion
        assert adhesion is not None
        assert (adhesion.recovery_per, adhesion.recovery_constant) == (per, value)
        case = recovering(recovery_constant=text)
        assert case_from_toml(case.to_toml()) == case
    bare = recovering(recovery_constant=1.9e-4, recovery_per="length").adhesion
    assert bare is not None
    assert bare.recovery_unit == "m/J"


def test_other_units_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"adhesion\.recovery_constant: '5e-6 m'"):
        recovering(recovery_constant="5e-6 m")


@pytest.mark.slow
def test_the_patch_s_width_converts_one_into_the_other() -> None:
    """tau per metre run and tau per area over the width that the patches sweep: the same recovery."""
    width = rail_patch(assemble(recovering())).width
    assert 5e-3 < width < 30e-3
    by_area = recovering(recovery_constant="5e-6 m^2/J")
    by_length = recovering(recovery_constant=f"{5e-6 / width} m/J")
    area, length = simulate(by_area), simulate(by_length)
    np.testing.assert_allclose(length["virtual_force"], area["virtual_force"], atol=1e-3)  # of some kN
    # On track patches change their width a little, which only energy per area sees.
    area, length = sliding(track_case(by_area)), sliding(track_case(by_length))
    spent = length["dissipated_energy_density"] / width / area["dissipated_energy_density"]
    assert float(spent.median()) == pytest.approx(1.0, abs=0.15)


def test_units_scale_each_in_its_own_way() -> None:
    factors = similitude("dlr")
    for text, unit in (("5e-6 m^2/J", "m^2/J"), ("1.9e-4 m/J", "m/J")):
        full = recovering(recovery_constant=text)
        made = scale_case(full, factors, strategy="dlr")
        assert made.adhesion is not None
        assert full.adhesion is not None
        assert made.adhesion.recovery_constant == pytest.approx(full.adhesion.recovery_constant / factors.factor(unit))
        assert made.adhesion.recovery_unit == unit


@pytest.mark.parametrize("on", ["rig", "track"])
def test_a_cleaned_wheel_adds_what_its_memory_keeps(on: str) -> None:
    """Half of its own energy on the rail, and with it the tread's, own L / (2 pi r) over the slip; recovery itself is nil."""
    memory = 4.0

    def leading(length: float) -> xr.Dataset:
        case = recovering(recovery_constant="1e-15 m^2/J", wheel_memory=length)
        return sliding(track_case(case) if on == "track" else case).sel(axle="wheelset_1")

    rail, both = leading(0.0), leading(memory)
    np.testing.assert_allclose(both["train_speed"], rail["train_speed"], rtol=1e-9)  # nothing else has changed
    speed = rail["virtual_speed" if on == "rig" else "axle_speed"] * RADIUS / rail["train_speed"]
    kept = 2.0 * rail["dissipated_energy_density"] * memory / (2.0 * np.pi * RADIUS * speed)
    added = both["dissipated_energy_density"] - rail["dissipated_energy_density"]
    assert float(speed.min()) < 0.95  # it slides
    # The sliding changes within the memory's length, 0.15 s.
    assert float(added.mean()) == pytest.approx(float(kept.mean()), rel=0.05)
