"""Damaged run.nc: refused in one line, or results that can be summarised, exported and compared."""

from __future__ import annotations

import random
import tempfile
from pathlib import Path

import rollerrig as rr
from hostile.bytes_of import spoiled
from rollerrig import results
from rollerrig.results import ResultsError

REFUSALS = (ResultsError, rr.OutputError)


def prepare() -> tuple[Path, bytes]:
    case = rr.load_case("wheelset_rollers").with_changes({"time.duration": 0.05})
    return Path(tempfile.mkdtemp(prefix="hostile")), bytes(results.netcdf_bytes(rr.simulate(case)))


def attack(prepared: tuple[Path, bytes], choose: random.Random) -> str:
    folder, whole = prepared
    path = folder / "damaged.nc"
    path.write_bytes(spoiled(whole, choose))
    try:
        run = results.load_run(path)
    except ResultsError as error:
        if "\n" in str(error):
            return f"nonsense a mistake in several lines: {error}"
        raise
    rr.summary(run)
    results.export(path, folder / "out.csv", force=True) if choose.random() < 0.1 else None
    return "ran"
