"""Writes what the fuzz targets of tests/fuzz/core.cpp begin with: python -m fuzz.sound_files FOLDER.

FOLDER/TARGET.bin is a sound file whole, FOLDER/TARGET/ holds bodies, without their heads, as the first inputs.
"""

from __future__ import annotations

import struct
import sys
from pathlib import Path

import rollerrig as rr
from rollerrig import _core
from rollerrig.interfaces.plant import assembled_model, controller_part

CASES = ("adhesion_sanding", "adhesion_train", "adhesion_start")
PARTS = ("rig_control", "slide_protection")


def main(folder: Path) -> None:
    for case in CASES:
        model = _core.write_model(assembled_model(rr.load_case(case)))
        (folder / "model.bin").write_bytes(model)
        layout = struct.unpack("<Q", model[24:32])[0]
        (folder / "model" / case).write_bytes(model[48 + layout :])
    (folder / "state.bin").write_bytes(_core.write_model(assembled_model(rr.load_case("adhesion_sanding"))))
    plant = _core.Plant(assembled_model(rr.load_case("adhesion_sanding")))
    plant.start()
    for k in range(3):
        plant.advance(0.006 * (k + 1))
        (folder / "state" / str(k)).write_bytes(plant.save()[16:])
    for part in PARTS:
        whole = _core.write_part(controller_part(rr.load_case("adhesion_brake"), part))
        (folder / "controller.bin").write_bytes(whole)
        (folder / "controller" / part).write_bytes(whole[32:])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
