"""The libraries that were built with the package, and where an FMU keeps them.

rollerrig/shells/<platform>/rollerrig.* -> [shells] -> Shell per platform
"""

from __future__ import annotations

import ctypes
import platform
from dataclasses import dataclass
from pathlib import Path

from rollerrig import _core

WINDOWS = "x86_64-windows"
FOLDERS = {"2": {"x86_64-linux": "linux64", WINDOWS: "win64"}, "3": {}}
"""Platform -> folder in binaries/, where the standard calls it otherwise: FMI 2.0.4, section 2.3."""


@dataclass(frozen=True)
class Shell:
    """A library for one platform.

    Attributes:
        platform: processor and system, as FMI 3.0 writes them: x86_64-linux.
        file: the library.
        needs: instructions beyond the oldest processor of its kind, with commas; empty: none.
    """

    platform: str
    file: Path
    needs: str

    def place(self, fmi: str, identifier: str) -> str:
        """Where an FMU keeps it."""
        return f"binaries/{FOLDERS[fmi].get(self.platform, self.platform)}/{identifier}{self.file.suffix}"


def shells() -> list[Shell]:
    """Those that came with the package; none on a system for which none is built."""
    folder = Path(str(_core.__file__)).parent / "shells"
    files = sorted(folder.glob("*/rollerrig.*"))
    return [Shell(file.parent.name, file, _needs(file)) for file in files if file.suffix in {".so", ".dll"}]


def _needs(file: Path) -> str:
    """Requirements of a library that this machine can load; the others are built for every processor of their kind."""
    if file.parent.name != f"{platform.machine()}-{platform.system().lower()}":
        return ""
    ask = ctypes.CDLL(str(file)).rollerrig_needs
    ask.restype = ctypes.c_char_p
    return str(ask().decode("ascii"))
