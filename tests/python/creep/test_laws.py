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
    """Cylinders, free of spin: creepage is inverse to the stiffness at the same share of the friction limit, here 8 %.

    A fall by 0.7 within 0.1 mm/s of sliding leaves what a constant friction of 0.3 times as much does.
    """
    torque = [[0.0, 0.0], [0.1, 1500.0], [1.0, 1500.0]]
    axles = [{"wheelset": f"wheelset_{n}", "reacts_on": "front_frame", "table": torque} for n in (1, 2)]
    base = rr.load_case("bogie_rollers_traction").with_changes(
        {
            "vehicle.wheel.profile": "cylinder",
            "time.duration": "0.4 s",
            "contact.creep": "modified_fastsim",
            "axle_torque": axles,
        }
    )

    def sliding(**contact: object) -> float:
        run = rr.simulate(base.with_changes({f"contact.{key}": value for key, value in contact.items()}))
        return float(abs(run["longitudinal_sliding"].isel(time=-1)).mean())

    clean = sliding()
    assert sliding(stiffness_reduction={"initial": 1 / 3}) == pytest.approx(
        3 * clean, rel=2e-3
    )  # the force is 1e-3 less
    fallen = sliding(friction_fall={"A": 0.3, "B": 1e4})
    assert fallen == pytest.approx(sliding(friction=0.3 * 0.3), rel=1e-6)
    assert fallen > 1.05 * clean
