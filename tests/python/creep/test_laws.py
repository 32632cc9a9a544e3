"""Laws by name: what they need, what is refused, and that runs use them."""

from __future__ import annotations

import pytest

import rollerrig as rr
from rollerrig.config import ConfigError
from rollerrig.creep import CREEP_LAWS, creep_law

POLACH = {"k_A": 0.3, "k_S": 0.1}


def test_unknown_laws_and_missing_parameters_are_named() -> None:
    with pytest.raises(ValueError, match="no creep law named 'coulomb'; there are kalker_linear"):
        creep_law("coulomb")
    with pytest.raises(ValueError, match="polach needs k_A"):
        creep_law("polach")


def test_a_case_says_what_a_law_needs_and_what_another_does_not() -> None:
    case = rr.load_case("wheelset_rollers")
    with pytest.raises(ConfigError, match=r"polach.*needed for creep = 'polach'"):
        case.with_changes({"contact.creep": "polach"})
    with pytest.raises(ConfigError, match=r"allowed only with creep = 'polach'"):
        case.with_changes({"contact.polach": POLACH})
    with pytest.raises(ConfigError, match=r"allowed only with creep = 'modified_fastsim'"):
        case.with_changes({"contact.stiffness_reduction": {"initial": 0.5}})
    with pytest.raises(ConfigError, match="kalker_linear"):
        case.with_changes({"contact.creep": "coulomb"})


@pytest.mark.parametrize("law", CREEP_LAWS)
def test_a_run_with_every_law_closes_its_energy(law: str) -> None:
    changes: dict[str, object] = {"contact.creep": law, "time.duration": "0.3 s"}
    if law == "polach":
        changes["contact.polach"] = POLACH
    run = rr.simulate(rr.load_case("bogie_rollers_traction").with_changes(changes))
    assert run.attrs["status"] == "ok"
    assert run.attrs["energy_relative_residual"] < 1e-6  # the audit's own limit


def test_falling_friction_and_a_soft_surface_reach_the_core() -> None:
    base = rr.load_case("bogie_rollers_traction").with_changes(
        {"time.duration": "0.1 s", "contact.creep": "modified_fastsim"}
    )
    wet = base.with_changes({"contact.stiffness_reduction": {"initial": 0.3, "ultimate": 0.5, "decay": 1.0}})
    slippery = base.with_changes({"contact.friction_fall": {"A": 0.3, "B": 50.0}})
    sliding = [
        abs(rr.simulate(case)["longitudinal_sliding"].isel(time=-1)).max().item() for case in (base, wet, slippery)
    ]
    assert sliding[1] != sliding[0]
    assert sliding[2] != sliding[0]
