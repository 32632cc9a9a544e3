"""Valid cases with absurd numbers, run for a moment: where energy is open or wheels are in the air, the results say so."""

from __future__ import annotations

import json
import random

import rollerrig as rr
from rollerrig.config import ConfigError
from rollerrig.simulation.starting_state import StartError

REFUSALS = (ConfigError, StartError)
OPEN = 1e-3
"""Part of the energy turned over that may be missing without a word."""
CASES = ("wheelset_rollers", "contact_benchmark_track", "bogie_rollers_constant")
KEYS = ("motion.speed", "gravity", "contact.friction.mu_0", "contact.normal_damping", "contact.damping_onset",
        "contact.creepage_regularisation_speed", "vehicle.wheel.radius", "support.roller_radius", "time.duration",
        "vehicle.body.wheelset_1.mass", "time.output_step", "time.absolute_tolerance", "time.relative_tolerance")  # fmt: skip
FACTORS = (1e-12, 1e-6, 1e-3, 0.1, 0.5, 2.0, 10.0, 100.0, 1e3, 1e6)


def prepare() -> list[rr.Case]:
    cases = [rr.load_case(name).with_changes({"time.duration": 0.1}) for name in CASES]
    assert [key for key in KEYS if not any(number(case, key) for case in cases)] == []
    return cases


def attack(cases: list[rr.Case], choose: random.Random) -> str:
    case = choose.choice(cases)
    changes = {}
    for key in choose.sample([key for key in KEYS if number(case, key)], choose.choice([1, 2, 2])):
        changes[key] = number(case, key) * choose.choice(FACTORS)
    run = rr.simulate(case.with_changes(changes))
    if run.attrs["status"] != "ok" or run.attrs["warnings"]:
        return "ran"
    if not run.attrs["energy_relative_residual"] <= OPEN:
        return f"nonsense energy open by {run.attrs['energy_relative_residual']}, and no warning: {changes}"
    lost = sum(loss["total_s"] for loss in json.loads(run.attrs.get("contact_losses", "[]")))
    return f"nonsense {lost} s in the air, and no warning: {changes}" if lost > 0.05 else "ran"


def number(case: rr.Case, key: str) -> float:
    """The present number behind a key; 0: the case has none."""
    value = case
    for name in key.split("."):
        found = next((one for one in value if one.name == name), None) if isinstance(value, tuple) else None
        value = found or getattr(value, name, None)
        value = getattr(value, "data", value)
    return float(value) if isinstance(value, int | float) else 0.0
