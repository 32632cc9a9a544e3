"""Damaged run.nc: refused in one line, or results that can be summarised, exported, compared and viewed."""

from __future__ import annotations

import contextlib
import random
import tempfile
from pathlib import Path

import h5py
import numpy as np

import rollerrig as rr
from hostile.bytes_of import spoiled
from rollerrig import results
from rollerrig.results import ResultsError

REFUSALS = (ResultsError, rr.OutputError)
ATTRIBUTES = ("units", "scale_factor", "add_offset", "_FillValue", "dtype", "calendar", "coordinates", "long_name")
VALUES = ("", "x", "{}", "null", "x\ny", "seconds since 2000-01-01", b"\xff", 0, -1, 1e300, np.nan, [1, 2], True)


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
    if choose.random() < 0.5:
        path.write_bytes(spoiled(choose.choice(files), choose))
    else:
        path.write_bytes(files[0])
        with (
            h5py.File(path, "r+") as file,
            contextlib.suppress(OSError, ValueError, RuntimeError),
        ):  # h5py's own refusals
            altered(file, choose)
    try:
        run = results.load_run(path)
    except ResultsError as error:
        if "\n" in str(error):
            return f"nonsense a mistake in several lines: {error}"
        raise
    rr.summary(run)
    results.export(path, folder / "out.mat", to="mat", force=True) if choose.random() < 0.1 else None
    with contextlib.suppress(ResultsError, ValueError):
        rr.compare_runs({"one": run, "other": run})
    rr.view(path, path=folder / "view.html", force=True) if choose.random() < 0.3 else None
    return "ran"


def altered(file: h5py.File, choose: random.Random) -> None:
    """A variable or an attribute renamed, removed or given another value, in a file that stays one of HDF5."""
    name = choose.choice(list(file))
    what = choose.choice(["remove", "rename", "values", "attribute of variable", "attribute", "no attribute"])
    if what == "remove":
        del file[name]
    elif what == "rename":
        file.move(name, choose.choice([f"{name}2", "time2", ".x", "a/b"]))
    elif what == "values":
        file[name][...] = choose.choice([np.nan, np.inf, 1e300, -1.0, 0.0])
    elif what == "attribute of variable":
        file[name].attrs[choose.choice(ATTRIBUTES)] = choose.choice(VALUES)
    elif what == "attribute":
        file.attrs[choose.choice(list(file.attrs))] = choose.choice(VALUES)
    else:
        del file.attrs[choose.choice(list(file.attrs))]
