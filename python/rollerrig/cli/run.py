"""`rollerrig run CASE --out DIR`."""

from __future__ import annotations

from rollerrig.cli.command import AllowCode, CaseName, Changes, Force, Out, carry_out, read_case


def command(
    case: CaseName, out: Out, change: Changes = None, allow_code: AllowCode = False, force: Force = False
) -> None:
    """Simulate one case: run.nc (every signal), summary.json, tables as CSV, report.html, view.html (in motion)."""
    from rollerrig.study.run import RunStudy

    carry_out(RunStudy(read_case(case, allow_code=allow_code, changes=change)), out, force=force)
