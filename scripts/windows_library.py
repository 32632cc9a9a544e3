"""What the library for Windows offers, and what it asks of Windows; exit code 1 if one of them is not as it should be.

rollerrig.dll -> objdump of mingw-w64 -> [windows_library] -> lines

python scripts/windows_library.py build/windows/fmu/rollerrig.dll
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

OBJDUMP = "x86_64-w64-mingw32-objdump"
ALLOWED = {"kernel32.dll", "msvcrt.dll"}
"""On every Windows since XP, whatever else is installed."""
HEADERS = Path(__file__).parents[1] / "third_party" / "fmi"


def tables(library: Path) -> tuple[set[str], set[str]]:
    """Names that it exports, and libraries that it is linked to."""
    text = subprocess.run([OBJDUMP, "-p", str(library)], check=True, capture_output=True, text=True).stdout
    exports = text.partition("[Ordinal/Name Pointer] Table")[2].partition("\n\n")[0]
    names = re.findall(r"\[\s*\d+\](?:\s\+base\[\s*\d+\])?(?:\s+[0-9a-f]+)?\s+(\w+)$", exports, re.MULTILINE)
    return set(names), {name.lower() for name in re.findall(r"DLL Name: (\S+)", text)}


def of_the_standard() -> set[str]:
    """Functions that both versions of the standard ask for, and our own one."""
    found = {"rollerrig_needs"}
    for version, types in (("2", "2.0"), ("3", "3.0")):
        text = (HEADERS / types / f"fmi{version}Functions.h").read_text(encoding="utf-8")
        found |= set(re.findall(rf"FMI{version}_Export\s+\w+TYPE\s+(fmi{version}\w+)\s*;", text))
    return found


def main(library: Path) -> int:
    """Print both lists; 1 if something is missing or too much."""
    exports, imports = tables(library)
    wanted = of_the_standard()
    print(f"{library}: {library.stat().st_size / 1e6:.1f} MB")
    print(f"   exports {len(exports)} names: {', '.join(sorted(exports))}")
    print(f"   imports {', '.join(sorted(imports))}")
    for what, names in (
        ("not exported", wanted - exports),
        ("exported, but not of the standard", exports - wanted),
        ("not on every Windows", imports - ALLOWED),
    ):
        if names:
            print(f"   {what}: {', '.join(sorted(names))}", file=sys.stderr)
    return int(exports != wanted or not imports <= ALLOWED)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
