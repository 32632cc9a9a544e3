"""What a report says is left out follows from the case: another model, other sentences."""

from __future__ import annotations

import pytest

from rollerrig import load_case
from rollerrig.study.limitations import limitations

PAPER = {"contact__normal": "hertz", "contact__creep": "kalker_saturated"}
"""The paper's contact."""


def said(name: str, **changes: object) -> str:
    return "\n".join(limitations(load_case(name).with_changes({k.replace("__", "."): v for k, v in changes.items()})))


def test_the_paper_s_contact_on_rigid_rollers() -> None:
    text = said("bogie_rollers_constant", **PAPER)
    for part in ("Hertzian ellipse", "Kalker's linear theory, saturated", "spin moment is not limited", "perfectly round",
                 "rigid bearings", "coefficient of friction is constant", "Fixed, as on a test rig: car body",
                 "rollers' speed is prescribed"):  # fmt: skip
        assert part in text, part
    for part in ("strips", "virtual train", "actuators", "track"):
        assert part not in text, part


@pytest.mark.parametrize(
    ("changes", "there", "gone"),
    [
        ({"contact__normal": "strips"}, "elastic strips", "Hertzian ellipse"),
        ({"contact__creep": "table"}, "table of Kalker's exact theory", "spin moment is not limited"),
        ({"contact__creep": "fastsim"}, "FASTSIM", "saturated"),
        ({"contact__creep": {"kind": "polach", "k_A": 1.0, "k_S": 0.4}}, "Polach's law", "saturated"),
        ({"contact__creep": "kalker_linear"}, "without a friction limit", "saturated"),
        ({"contact__creep": {"kind": "kalker_saturated", "saturate_spin_moment": True}}, "saturated by friction",
         "spin moment is not limited"),
        ({"contact__friction": {"kind": "falling", "mu_0": 0.3, "A": 0.4, "B": 0.6}}, "depends on the slip velocity",
         "friction is constant"),
        ({"contact__roller_effects__spin": False}, "Switched off, unlike on a real rig: the rollers' effect of spin", "%"),
        ({"motion__drive": "free"}, "Rolling contact is quasi-steady", "speed is prescribed"),
    ],
)  # fmt: skip
def test_another_model_other_limitations(changes: dict[str, object], there: str, gone: str) -> None:
    text = said("bogie_rollers_constant", **PAPER | changes)
    assert there in text
    assert gone not in text


def test_irregular_track() -> None:
    text = said("vehicle_track_irregular")
    assert "without wavelengths below 3 m" in text
    assert "free of irregularities" not in text
    assert "The rails are rigid and do not move." in text
    assert "free of irregularities" in said("bogie_track")


def test_elastic_rollers_and_degraded_adhesion() -> None:
    text = said("adhesion_lateral")
    assert "their axles stand on linear springs and dampers" in text
    assert "rigid bearings" not in text
    assert "The adhesion of the rail depends on" in text
    assert "friction is constant" not in text
    assert "virtual train" in text
    assert "prescribed" not in text


def test_controllers_and_sensors() -> None:
    assert "exact speeds" in said("adhesion_brake")
    assert "exact speeds" not in said("adhesion_brake", sensors__axles__counts=4096)
    assert "quasi-static load transfer" in said("adhesion_brake")
    assert "no load transfer" in said("adhesion_brake", rig_control__load_transfer="none")
    assert "known to the controller exactly" in said("adhesion_brake", rig_control__estimator__kind="exact")
    assert "pure-rolling assumption" in said("adhesion_brake", contact__pure_rolling=True)
    assert "certified" not in said("bogie_rollers_constant")
