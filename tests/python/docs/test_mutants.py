"""The mistakes of `scripts/mutation_check.py` can still be made: each text stands once where it is said to stand."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


def test_every_mutant_finds_its_text_and_its_tests() -> None:
    spec = importlib.util.spec_from_file_location("mutation_check", ROOT / "scripts" / "mutation_check.py")
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = script
    spec.loader.exec_module(script)
    assert len(script.MUTANTS) > 30
    for mutant in script.MUTANTS:
        assert (ROOT / "core" / mutant.file).read_text(encoding="utf-8").count(mutant.right) == 1, mutant.what
        assert all((ROOT / "tests" / "core" / test).is_file() for test in mutant.tests), mutant.what
