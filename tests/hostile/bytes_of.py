"""Changes of bytes, and the checksum made right behind them."""

from __future__ import annotations

import random
import struct

import fastcrc

NUMBERS = (
    0.0,
    -0.0,
    -1.0,
    1e-300,
    1e300,
    -1e300,
    1e30,
    1e9,
    -1e9,
    1e-12,
    0.5,
    float("nan"),
    float("inf"),
    float("-inf"),
)
WHOLE = (0, 1, 2, 7, 8, 255, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1, 2**40)


def spoiled(content: bytes, choose: random.Random, fixed: int = 0) -> bytes:
    """One to four deeds behind the first `fixed` bytes: changed numbers and bytes, pieces moved, doubled, cut away."""
    data = bytearray(content)
    for _ in range(choose.choice([1, 1, 2, 4])):
        if len(data) <= fixed:
            break
        at = choose.randrange(fixed, len(data))
        even = fixed + (at - fixed) // 8 * 8 if choose.random() < 0.7 else at  # most numbers stand there
        match choose.choice(["byte", "number", "number", "whole", "whole", "copy", "copy", "cut", "grow", "zeros"]):
            case "byte":
                data[at : at + 1] = bytes([choose.randrange(256)])
            case "number":
                data[even : even + 8] = struct.pack("<d", choose.choice(NUMBERS))
            case "whole":
                value, form = choose.choice(WHOLE), choose.choice(["<Q", "<Q", "<I", "<B"])
                data[even : even + struct.calcsize(form)] = struct.pack(form, value % 256 ** struct.calcsize(form))
            case "copy":
                start, size = choose.randrange(len(data)), choose.choice([1, 4, 8, 8, 64, 512])
                data[even : even + size] = data[start : start + size]
            case "cut":
                size = choose.choice([1, 8, 64, len(data)])
                del data[even : even + size]
            case "grow":
                data[even:even] = data[even : even + choose.choice([1, 8, 64, 4096])]
            case "zeros":
                data[even : even + 64] = bytes(len(data[even : even + 64]))
    return bytes(data)


def crc64(content: bytes, before: int = 0) -> int:
    """CRC-64/XZ as the core has it: of bytes behind others whose checksum is `before`."""
    return fastcrc.crc64.xz(content, before)
