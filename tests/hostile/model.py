"""Model files, changed and with their checksum made right: refused, or a model that starts and runs.

Source: core/include/rollerrig/plant/model_file.hpp: a mark, version, sizes of layout and model, checksum; layout; model.
"""

from __future__ import annotations

import random
import struct

from hostile.bytes_of import crc64, spoiled
from rollerrig import _core, load_case
from rollerrig.interfaces.plant import assembled_model

REFUSALS = (ValueError,)
CASES = ("adhesion_brake", "adhesion_start", "wheelset_rollers", "adhesion_train")
AT, HEADER = 40, 48


def prepare() -> list[bytes]:
    return [_core.write_model(assembled_model(load_case(case))) for case in CASES]


def attack(prepared: list[bytes], choose: random.Random) -> str:
    whole = choose.choice(prepared)
    layout = struct.unpack("<Q", whole[24:32])[0]
    start = HEADER + layout
    body = spoiled(whole[start:], choose)
    head = whole[:32] + struct.pack("<Q", len(body))
    content = whole[HEADER:start] + body
    read = _core.read_model(head + struct.pack("<Q", crc64(content, crc64(head))) + content)
    plant = _core.Plant(read)
    if plant.start() == 0:
        plant.advance(plant.time + 0.003)
    plant.values(list(range(len(plant.variables))))
    return "ran"
