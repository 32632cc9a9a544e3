"""What a roller changes, each effect switched off: nothing of it left is the track."""

from __future__ import annotations

import numpy as np
import pytest

from rollerrig.analysis.critical_speed import scan_linear
from rollerrig.config import Case, load_case
from rollerrig.simulation.run import simulate

EFFECTS = ("curvature", "conicity", "spin", "yaw")


def without(case: Case, *effects: str) -> Case:
    return case.with_changes({f"contact.roller_effects.{name}": False for name in effects})


def critical_kmh(case: Case) -> float:
    found = scan_linear(case, np.arange(100.0, 420.0, 20.0).tolist()).onset
    assert found is not None
    return 3.6 * found.speed


def test_without_all_effects_the_rig_has_the_critical_speed_of_the_track() -> None:
    rig = critical_kmh(without(load_case("bogie_rollers_constant"), *EFFECTS))
    # Both are found to 1e-4 km/h.
    assert rig == pytest.approx(critical_kmh(load_case("bogie_track")), abs=2e-4)


@pytest.mark.parametrize("effect", EFFECTS)
def test_every_switch_acts(effect: str) -> None:
    case = load_case("bogie_rollers_constant")
    assert abs(critical_kmh(without(case, effect)) - critical_kmh(case)) > 0.5


@pytest.mark.parametrize("effects", [("conicity",), ("spin",), ("yaw",), EFFECTS])
def test_energy_balances_without_an_effect_too(effects: tuple[str, ...]) -> None:
    """What is left out of the roller's surface speed is left out of the moment on it as well."""
    case = load_case("wheelset_rollers").with_changes(
        {"time.duration": 0.5, "time.method": "rodas4", "time.step": None, "time.relative_tolerance": 1e-6}
    )
    run = simulate(without(case, *effects))
    assert run.attrs["status"] == "ok"
    assert run.attrs["energy_relative_residual"] < 1e-6  # 1e-8 to 6e-8 come out, integrated to 1e-6 per step
