"""Adds what is compiled into the extension to a software bill of materials.

bill of the Python packages, exact versions of the compiled parts -> [this] -> the whole bill

usage: add_compiled_parts.py IN.json REQUIREMENTS.txt OUT.json; called by scripts/write_sbom
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

LICENCES = {"nanobind": "BSD-3-Clause", "cmeel-eigen": "MPL-2.0"}
NAMES = {"cmeel-eigen": "eigen"}
"""The package that carries a part, where the part has another name."""


def component(line: str) -> dict[str, object]:
    """The entry of a part from a line `package==version`."""
    package, _, version = line.partition("==")
    return {
        "bom-ref": f"compiled-{package}",
        "type": "library",
        "name": NAMES.get(package, package),
        "version": version,
        "description": "compiled into rollerrig._core",
        "licenses": [{"license": {"id": LICENCES[package]}}],
        "purl": f"pkg:pypi/{package}@{version}",
    }


def main() -> None:
    """Read, add, write."""
    source, parts, target = map(Path, sys.argv[1:])
    bill = json.loads(source.read_text(encoding="utf-8"))
    lines = [line.strip() for line in parts.read_text(encoding="utf-8").splitlines() if "==" in line]
    bill["components"] = bill.get("components", []) + [component(line) for line in lines]
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(json.dumps(bill, indent=2) + "\n", encoding="utf-8")
    print(f"{target}: {len(bill['components'])} components")


if __name__ == "__main__":
    main()
