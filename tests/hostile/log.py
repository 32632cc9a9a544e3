"""Damaged files of measured signals, in every format, and of measured rails: refused in one line, or columns of numbers."""

from __future__ import annotations

import io
import random
import tempfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.io import savemat

from hostile.bytes_of import spoiled
from rollerrig import ResultsError
from rollerrig.irregularity.measured import measured_irregularity, read_measured_track
from rollerrig.irregularity.rails import IrregularityError
from rollerrig.results.files import netcdf_bytes
from rollerrig.results.logs import log_quantity, read_log, time_problem

REFUSALS = (ResultsError, IrregularityError)
ROWS = 60
RAILS = "rails.csv"


def prepare() -> tuple[Path, dict[str, bytes]]:
    time = np.linspace(0.0, 3.0, ROWS)
    columns = {"time": time, "axle_speed": 20.0 - time, "pressure": 1e5 + 1e4 * np.sin(time)}
    units = {"time": "s", "axle_speed": "m/s", "pressure": "Pa"}
    heads = [f"{name} [{units[name]}]" for name in columns]
    rows = np.column_stack(list(columns.values())).tolist()
    content = {
        "comma.csv": "\n".join([",".join(heads), *(",".join(map(str, row)) for row in rows)]).encode(),
        "semicolon.csv": "\n".join(
            [";".join(heads), *(";".join(map(str, row)).replace(".", ",") for row in rows)]
        ).encode(),
        "log.mat": mat(columns, units, compressed=False),
        "compressed.mat": mat(columns, units, compressed=True),
        "log.nc": bytes(netcdf_bytes(dataset(columns, units))),
        "record.npz": record(columns, units),
        RAILS: "\n".join(
            ["distance [m],left_y_mm,left_z_mm,right_y_mm,right_z_mm"]
            + [f"{0.25 * k},{np.sin(k):.3f},{np.cos(k):.3f},0.1,{k % 3}" for k in range(ROWS)]
        ).encode(),
    }
    folder = Path(tempfile.mkdtemp(prefix="hostile"))
    with suppress(ImportError):
        import pyarrow as pa
        from pyarrow import parquet

        parquet.write_table(pa.table(dict(zip(heads, columns.values(), strict=True))), sink := io.BytesIO())
        content["log.parquet"] = sink.getvalue()
    with suppress(ImportError):
        from asammdf import MDF, Signal

        with MDF(version="4.10") as file:
            for key in ("axle_speed", "pressure"):
                file.append(Signal(columns[key], time, name=key, unit=units[key]))
            content["log.mf4"] = Path(file.save(folder / "sound.mf4")).read_bytes()
    return folder, content


def dataset(columns: dict[str, np.ndarray], units: dict[str, str]) -> xr.Dataset:
    return xr.Dataset(
        {name: ("time", values, {"units": units[name]}) for name, values in columns.items() if name != "time"},
        {"time": ("time", columns["time"], {"units": "s"})},
    )


def mat(columns: dict[str, np.ndarray], units: dict[str, str], *, compressed: bool) -> bytes:
    savemat(sink := io.BytesIO(), {**columns, "units": units}, do_compression=compressed)
    return sink.getvalue()


def record(columns: dict[str, np.ndarray], units: dict[str, str]) -> bytes:
    """As `rollerrig serve --record` writes it."""
    names = [name for name in columns if name != "time"]
    sensors = np.column_stack([columns[name] for name in names])
    np.savez(sink := io.BytesIO(), sensors=sensors, period=0.05, outputs=names, units=[units[name] for name in names])
    return sink.getvalue()


def attack(prepared: tuple[Path, dict[str, bytes]], choose: random.Random) -> str:
    folder, content = prepared
    name = choose.choice(list(content))
    tried_apart = name.endswith((".mat", ".mf4"))  # in a process of its own, which takes long
    if tried_apart and choose.random() < 0.9:
        name = RAILS
    path = folder / name
    path.write_bytes(spoiled(content[name], choose))
    try:
        if name == RAILS:
            track = read_measured_track(path)
            measured_irregularity(track, start=0.0, needed=(0.0, 10.0), fade_in=1.0)
            return "ran"
        log = read_log(path)
        problem = time_problem(log_quantity(log, "time", {"s": 1.0}))
        log_quantity(log, "axle_speed", {"m/s": 1.0, "km/h": 1.0 / 3.6})
    except REFUSALS as error:
        if "\n" in str(error):
            return f"nonsense a mistake in several lines: {error}"
        raise
    return "nonsense a problem in several lines" if "\n" in problem else "ran"
