"""A study is one file: command, public function and reported numbers follow from it alone."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

TOY = '''
from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from rollerrig.cases import as_case
from rollerrig.config import Case
from rollerrig.simulation.run import simulate
from rollerrig.study.frame import Outcome, Study
from rollerrig.study.jobs import job
from rollerrig.study.options import Option, command
from rollerrig.study.quantities import Quantities, Quantity


@dataclass(frozen=True)
class ToyStudy(Study):
    """One run of `length` [m]."""

    case: Case
    length: float

    command = "toy"
    quantities = Quantities(Quantity("distance", "distance run", "m"))

    def rounds(self, done):
        duration = self.length / self.case.motion.speed
        yield {self.command: job(simulate, self.case.with_changes({"time.duration": f"{duration} s"}))}

    def numbers(self, results):
        return {"distance": float(results["distance"][-1])}

    def summary(self, results, numbers):
        return [f"{numbers['distance']:.3g} m"]

    def sections(self, results, numbers):
        return []


@command
def toy(case: Case | str, *, length: Annotated[float, Option("length_mm", "mm", 1.0, 1e4)] = 2.0) -> Outcome:
    """How far a case runs.

    Args:
        case: any.
        length: at which it ends [m].

    Raises:
        ArithmeticError: they are 3 m.
    """
    if length == 3.0:
        raise ArithmeticError("3 m are refused")
    return ToyStudy(as_case(case), length).outcome()
'''

USED = """
import sys
import rollerrig.study
rollerrig.study.__path__.append(sys.argv.pop(1))
import rollerrig as rr
from called import call

assert "toy" in rr.__all__ and "toy" in dir(rr)
print(rr.toy("wheelset_rollers").summary)
for words in (["--help"], ["toy", "--help"], ["toy", "wheelset_rollers", "--out", "out", "--length-mm", "1500"],
              ["toy", "wheelset_rollers", "--out", "out", "--length-mm", "3000"]):
    print(*call(*words))
"""


@pytest.mark.slow
def test_a_study_is_found_from_its_file_alone(tmp_path: Path) -> None:
    (tmp_path / "more").mkdir()
    (tmp_path / "more/toy.py").write_text(TOY)
    command = [sys.executable, "-c", USED, str(tmp_path / "more")]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stderr
    outcome, everything = done.stdout.partition("0 ")[0], " ".join(done.stdout.split())
    assert outcome == "2 m\n"
    assert "toy How far a case runs." in everything
    assert "At which it ends [mm]. [default: 2000.0; 1.0<=x<=10000.0]" in everything
    assert "2 rollerrig: 3 m are refused" in everything
    assert json.loads((tmp_path / "out/summary.json").read_text())["distance"] == pytest.approx(1.5)
