"""Saved states of a plant, changed and with their checksum made right: refused, or a run that goes on.

Bytes 0 to 7 name the model and 8 to 15 are the checksum; both are right.
"""

from __future__ import annotations

import random
import struct
from typing import Any

from hostile.bytes_of import crc64, spoiled
from rollerrig import _core, load_case
from rollerrig.interfaces.plant import assembled_model

REFUSALS = (ValueError,)
CASES = ("adhesion_sanding", "adhesion_train")
METHODS = ("exponential_adams", "exponential_rk4", "dormand_prince", "rodas4", "rk4")


STEPS = {"exponential_adams": "1 ms", "exponential_rk4": "0.2 ms", "rk4": "0.02 ms"}


def prepare() -> list[tuple[Any, list[bytes]]]:
    return [plant_of(case, "") for case in CASES] + [plant_of("wheelset_rollers", method) for method in METHODS]


def plant_of(case: str, method: str) -> tuple[Any, list[bytes]]:
    """A plant and three of its sound states."""
    changes = {"time.method": method} if method else {}
    if method in STEPS:
        changes["time.step"] = STEPS[method]
    plant = _core.Plant(assembled_model(load_case(case).with_changes(changes)))
    plant.start()
    friction = next(k for k, variable in enumerate(plant.variables) if "friction_change" in variable.name)
    states = []
    for k in range(3):
        plant.advance(0.006 * (k + 1))
        if k == 1:
            plant.set_input(friction, -0.5)
        states.append(plant.save())
    return plant, states


def attack(prepared: list[tuple[Any, list[bytes]]], choose: random.Random) -> str:
    plant, states = choose.choice(prepared)
    state = choose.choice(states)
    body = spoiled(state[16:], choose)
    if choose.random() < 0.2:  # two halves of two states
        other, at = choose.choice(states)[16:], choose.randrange(len(state))
        body = body[:at] + other[at:]
    if len(body) < 8:
        body = bytes(8)
    known = struct.unpack("<Q", state[:8])[0]
    checked = state[:8] + struct.pack("<Q", crc64(body, known)) + body
    try:
        plant.restore(checked)
    except ValueError:
        plant.restore(state)  # nothing is left of it
        raise
    before = plant.time
    code = plant.advance(before + 0.004)
    plant.values(list(range(len(plant.variables))))
    plant.save()
    if code == 0 and not before <= plant.time <= before + 0.005:
        return f"nonsense went from {before} to {plant.time} s"
    return "ran"
