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


SLICES = 36
"""Files with some of the variables each: most attacks go to these, which are read in a fraction of the time."""


def prepare() -> tuple[Path, list[bytes]]:
    run = rr.simulate(rr.load_case("wheelset_rollers").with_changes({"time.duration": 0.05}))
    names = list(run.data_vars)
    files = [run] + [run[names[k::SLICES]].assign_attrs(run.attrs) for k in range(SLICES)]
    return Path(tempfile.mkdtemp(prefix="hostile")), [bytes(results.netcdf_bytes(one)) for one in files]


def attack(prepared: tuple[Path, list[bytes]], choose: random.Random) -> str:
    folder, files = prepared
    path = folder / "damaged.nc"
    path.write_bytes(spoiled(choose.choice(files), choose))
    try:
        run = results.load_run(path)
    except ResultsError as error:
        if "\n" in str(error):
            return f"nonsense a mistake in several lines: {error}"
        raise
    rr.summary(run)
    results.export(path, folder / "out.csv", force=True) if choose.random() < 0.1 else None
    return "ran"
