"""`rollerrig run CASE --out DIR`."""

from __future__ import annotations

from rollerrig.cli.command import CaseName, Out, carry_out


def command(case: CaseName, out: Out) -> None:
    """Simulate one case: run.nc (every signal), summary.json, motion.csv, wheels.csv, running_safety.csv, report.html."""
    from rollerrig.config import load_case
    from rollerrig.study.run import RunStudy

    carry_out(RunStudy(load_case(case)), out)
