"""Laws by name: the configuration and the core know the same ones, with the same parameters, and runs use them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_args

import numpy as np
import pytest
from pydantic import BaseModel

import rollerrig as rr
from rollerrig import _core
from rollerrig.assembly.laws import creep_law, linear_coefficients
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.config import ConfigError
from rollerrig.config.schema.contact import (
    CREEP_LAWS,
    NORMAL_LAWS,
    AnyCreep,
    AnyFriction,
    AnyNormal,
    kinds,
)
from rollerrig.contact_analysis.static_contact import leading_wheelset

COEFFICIENTS = {"kind": "coefficients", "f11": "7 MN", "f22": "6 MN", "f23": "15 kN m", "f33": 15.0}
POLACH = {"kind": "polach", "k_A": 0.3, "k_S": 0.1}
FROM_PYTHON = {"table": {"table"}, "strip_theory": {"table"}}
"""Fields of a law that no configuration gives."""


@pytest.mark.parametrize(
    ("laws", "registry"),
    [(AnyCreep, _core.creep_laws), (AnyNormal, _core.normal_laws), (AnyFriction, _core.friction_laws)],
    ids=["creep", "normal", "friction"],
)
def test_configuration_and_core_agree_on_names_and_parameters(laws: Any, registry: Mapping[str, Any]) -> None:
    assert set(kinds(laws)) == set(registry)
    tables: tuple[type[BaseModel], ...] = get_args(get_args(laws)[0])
    for name, table in zip(kinds(laws), tables, strict=True):
        ours = set(registry[name].fields) - FROM_PYTHON.get(name, set())
        assert table.model_fields.keys() - {"kind"} == ours, name


def test_unknown_laws_and_missing_parameters_are_named() -> None:
    with pytest.raises(ValueError, match="kind: 'coulomb'; allowed: kalker_saturated"):
        creep_law("coulomb")
    with pytest.raises(ValueError, match="polach: k_A: missing"):
        creep_law("polach")


def test_a_case_says_what_a_law_needs_and_what_another_does_not() -> None:
    case = rr.load_case("wheelset_rollers")
    with pytest.raises(ConfigError, match=r"contact\.creep\.k_A: missing"):
        case.with_changes({"contact.creep": "polach"})
    with pytest.raises(ConfigError, match=r"contact\.creep\.k_A: unknown key"):
        case.with_changes({"contact.creep.k_A": 0.3})
    with pytest.raises(ConfigError, match=r"contact\.normal\.merging_criterion: unknown key"):
        case.with_changes({"contact.normal": {"kind": "strips", "merging_criterion": 0.1}})
    with pytest.raises(ConfigError, match=r"contact\.creep: 'coulomb'; allowed: kalker_saturated"):
        case.with_changes({"contact.creep": "coulomb"})


def test_a_law_is_its_name_or_a_table() -> None:
    case = rr.load_case("wheelset_rollers")
    for key, names in (("creep", CREEP_LAWS), ("normal", NORMAL_LAWS), ("friction", kinds(AnyFriction))):
        own = getattr(case.contact, key)
        assert own.kind in names
        assert case.with_changes({f"contact.{key}": own.model_dump()}) == case
    assert case.with_changes({"contact.friction": 0.2}).contact.friction.mu_0 == 0.2


@pytest.mark.parametrize("law", CREEP_LAWS)
def test_a_run_with_every_law_closes_its_energy(law: str) -> None:
    given = {"polach": POLACH, "coefficients": COEFFICIENTS}
    changes: dict[str, object] = {"contact.creep": given.get(law, law), "time.duration": "0.3 s"}
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
    assert sliding(creep={"kind": "modified_fastsim", "k_0": 1 / 3}) == pytest.approx(
        3 * clean, rel=2e-3
    )  # the force is 1e-3 less
    fallen = sliding(friction={"kind": "falling", "mu_0": 0.3, "A": 0.3, "B": 1e4})
    assert fallen == pytest.approx(sliding(friction=0.3 * 0.3), rel=1e-6)
    assert fallen > 1.05 * clean


def test_a_factor_on_kalker_s_coefficients_is_a_factor_on_small_creepage() -> None:
    """Slow traction on cylinders: creepage is inverse to the stiffness; coefficients as given have no such factor."""
    torque = {"wheelset": "wheelset_1", "reacts_on": "front_frame", "table": [[0.0, 0.0], [0.1, 100.0], [1.0, 100.0]]}
    base = rr.load_case("bogie_rollers_traction").with_changes(
        {"vehicle.wheel.profile": "cylinder", "time.duration": "0.3 s", "axle_torque": [torque]}
    )

    def sliding(factor: float) -> float:
        run = rr.simulate(base.with_changes({"contact.kalker_factor": factor}))
        return float(abs(run["longitudinal_sliding"].sel(wheel="wheelset_1_left").isel(time=-1)))

    assert sliding(0.5) == pytest.approx(2 * sliding(1.0), rel=5e-3)  # 1 % of the friction limit
    with pytest.raises(
        ConfigError, match=r"contact\.kalker_factor: 0\.5; allowed with contact\.creep = 'coefficients': 1"
    ):
        base.with_changes({"contact.creep": COEFFICIENTS, "contact.kalker_factor": 0.5})


def test_reports_know_coefficients_as_given() -> None:
    case = rr.load_case("wheelset_rollers").with_changes({"contact.creep": COEFFICIENTS, "contact.normal": "hertz"})
    assert linear_coefficients(case.contact, 5e-3, 4e-3) == (7e6, 6e6, 15e3, 15.0)
    with pytest.raises(ValueError, match="coefficients: they hold for the patch of a case"):
        rr.creep(laws=["coefficients"])


@pytest.mark.parametrize("normal", NORMAL_LAWS)
def test_coefficients_as_given_are_those_of_one_patch_with_every_normal_law(normal: str) -> None:
    """Slopes of the forces on the tread of a cone; across, both the creepage and the force are turned by the contact angle."""
    law = {**COEFFICIENTS, "saturation": False}
    changes = {"contact.normal": normal, "contact.creep": law, "contact.normal_damping": 0.0}
    case = rr.load_case("cooperrider_bogie").with_changes(changes)
    model = assemble(case)
    wheelset, body = leading_wheelset(model), model.body_index(model.wheelsets[0])
    found = wheelset.contact.solve(0.0, 0.0, 0.0, 0.0, model.axle_loads[wheelset.name], True)
    (patch,) = (one for one in found.patches if not one.right)
    speed, step = 50.0, 1e-4
    parts = AssembledModel(case).parts
    left = [one for one in parts["contacts"] if one.wheelset == body and not one.right]
    alone = _core.model_of(_core.ModelParts(**parts | {"contacts": left, "elements": [], "speed": [(0.0, 0.0)]}))
    simulation = _core.Simulation(alone)
    places, rates = simulation.coordinate_index[body], simulation.rate_index[body]

    def force(along: float, across: float, spin: float) -> np.ndarray:
        """Of the left wheel alone, on rails at rest."""
        x = np.zeros(simulation.state_count)
        x[[places[2], places[3]]] = found.z, found.roll
        turning = (1 - along) * speed / patch.wheel_radius
        x[[rates[i] for i in (0, 1, 4, 5)]] = (
            speed,
            across * speed,
            turning - spin * speed * np.sin(found.roll),
            spin * speed,
        )
        return model.masses[model.wheelsets[0]] * simulation.derivative(0.0, x)[0][rates]

    f11, f22, f23 = ((force(0.0, 0.0, 0.0) - force(*creepage)) / step for creepage in np.eye(3) * step)
    assert f11[0] == pytest.approx(7e6, rel=2e-3)
    assert f22[1] == pytest.approx(6e6 * np.cos(patch.angle) ** 2, rel=2e-3)
    assert f23[1] == pytest.approx(15e3, rel=0.05)
