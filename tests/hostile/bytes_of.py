"""Changes of bytes, and the checksum made right behind them."""

from __future__ import annotations

import functools
import random
import struct

import numpy as np

_POLYNOMIAL = 0xC96C5795D7870F42
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


@functools.cache
def _weights(size: int) -> np.ndarray:
    """What each bit of the last `size` bytes adds to a checksum that begins with zero, from the end."""
    table = np.zeros(256, np.uint64)
    for i in range(256):
        value = i
        for _ in range(8):
            value = (value >> 1) ^ (_POLYNOMIAL if value & 1 else 0)
        table[i] = value
    weights = np.zeros((size, 8), np.uint64)
    row = table[1 << np.arange(8)]
    for k in range(size):
        weights[k] = row
        row = table[(row & np.uint64(255)).astype(np.int64)] ^ (row >> np.uint64(8))
    return weights


def crc64(content: bytes, before: int = 0) -> int:
    """CRC-64/XZ as the core has it; of at least eight bytes."""
    data = np.frombuffer(content, np.uint8).copy()
    data[:8] ^= np.frombuffer(struct.pack("<Q", before ^ (2**64 - 1)), np.uint8)
    room = 1 << max(17, (len(data) - 1).bit_length())
    bits = np.unpackbits(data[::-1, None], axis=1, bitorder="little").astype(bool)
    return int(np.bitwise_xor.reduce(_weights(room)[: len(data)][bits], initial=np.uint64(0))) ^ (2**64 - 1)
