"""`rollerrig run CASE --out DIR`."""

from __future__ import annotations

from rollerrig.cli.command import AllowCode, CaseName, Force, Out, carry_out, read_case


def command(case: CaseName, out: Out, allow_code: AllowCode = False, force: Force = False) -> None:
    """Simulate one case: run.nc (every signal), summary.json, motion.csv, wheels.csv, running_safety.csv, report.html."""
    from rollerrig.study.run import RunStudy

    carry_out(RunStudy(read_case(case, allow_code=allow_code)), out, force=force)
