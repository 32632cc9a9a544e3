"""Checksum of the sources of the page that `rollerrig view` writes: what its bundled file was made of."""

from __future__ import annotations

import hashlib
from pathlib import Path

VIEWER = Path(__file__).resolve().parent.parent / "viewer"


def viewer_checksum() -> str:
    """SHA-256 of all sources and of the exact versions of what they use, 16 digits."""
    found = hashlib.sha256()
    for path in [*sorted((VIEWER / "src").iterdir()), VIEWER / "package-lock.json"]:
        found.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return found.hexdigest()[:16]


if __name__ == "__main__":
    print(viewer_checksum())
