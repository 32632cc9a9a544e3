"""Measured signals from a file: columns of numbers with their units.

    .csv, .mat, .nc, .parquet -> [read_log] -> Log: name of a column -> values, unit

A heading is `name` or `name [unit]`; a table is separated by commas, by tabs, or by semicolons with decimal commas. A file that
`rollerrig export` or `simulate` wrote has its columns by the same names.
"""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from rollerrig.common.arrays import Array
from rollerrig.common.input_files import LARGEST_TABLE, check_input, read_input
from rollerrig.results.files import ResultsError
from rollerrig.results.other_formats import table_columns

GAP = 5.5
"""A step of time that is so many times the median one is a gap."""


@dataclass(frozen=True)
class Log:
    """Columns of a file of measured signals.

    Attributes:
        file: as messages name it.
        columns: name -> values, all of one length.
        units: name -> unit in its heading; "" where none is.
    """

    file: str
    columns: Mapping[str, Array]
    units: Mapping[str, str]


def read_log(path: str | Path) -> Log:
    """Read a file of measured signals.

    Raises:
        FileNotFoundError: no such file.
        ResultsError: a file of another kind, damaged, or without columns of numbers.
    """
    kind = Path(path).suffix.lower()
    if kind not in READERS:
        raise ResultsError(f"{path}: a file of measured signals ends in {', '.join(READERS)}")
    if kind == ".parquet" and find_spec("pyarrow") is None:
        raise ResultsError(f'{path}: needs pyarrow, which is not installed: pip install "rollerrig[parquet]"')
    try:
        given = READERS[kind](path)
    except FileNotFoundError:
        raise FileNotFoundError(f"{path}: no such file") from None
    except ResultsError:
        raise
    except OSError as error:
        raise ResultsError(f"{path}: {error.strerror or 'cannot be read'}") from None
    except Exception as error:  # whatever the libraries meet in a damaged file
        raise ResultsError(f"{path}: no table of numbers: {(str(error).splitlines() or [''])[0]}") from None
    return log_of(given, str(path))


def log_of(given: Mapping[str, Any], file: str) -> Log:
    """Columns by their headings as a Log, called `file` in messages.

    Raises:
        ResultsError: there are none, or they are of different lengths.
    """
    columns, units = {}, {}
    for heading, values in given.items():
        found = re.fullmatch(r"(.*?)\s*\[([^\[\]]*)\]", heading.strip())
        name, unit = found.groups() if found else (heading.strip(), "")
        columns[name], units[name] = np.asarray(values, dtype=np.float64), unit
    lengths = {len(values) for values in columns.values()}
    if not lengths or min(lengths) < 1:
        raise ResultsError(f"{file}: no column of numbers")
    if len(lengths) > 1:
        raise ResultsError(f"{file}: columns of different lengths, {', '.join(map(str, sorted(lengths)))}")
    return Log(file, columns, units)


def time_problem(time: Array) -> str:
    """What is wrong with the times of a log, in words with the row (the first is 1); "" where they rise without a gap."""
    steps = np.diff(time)
    if (missing := ~np.isfinite(time)).any():
        return f"row {int(np.argmax(missing)) + 1} has no time"
    if (steps <= 0.0).any():
        row = int(np.argmax(steps <= 0.0)) + 1
        what = "repeats" if steps[row - 1] == 0.0 else "falls behind"
        return f"row {row + 1}, {time[row]:g} s, {what} the time before it, {time[row - 1]:g} s"
    usual = float(np.median(steps)) if len(steps) else 0.0
    if (steps > GAP * usual).any():
        row = int(np.argmax(steps > GAP * usual)) + 1
        return f"a gap from {time[row - 1]:g} to {time[row]:g} s, where rows are {usual:g} s apart"
    return ""


def _csv(path: str | Path) -> Mapping[str, Any]:
    import pandas

    text = read_input(path, LARGEST_TABLE).decode("utf-8-sig")
    lines = "\n".join(line for line in text.splitlines() if not line.startswith("#"))
    first = lines.partition("\n")[0]
    separator = max(",;\t", key=first.count)
    table = pandas.read_csv(io.StringIO(lines), sep=separator, decimal="," if separator == ";" else ".")
    return {
        str(name): values for name, values in table.items() if values.dtype.kind in "fiub" or _wrong_cell(name, values)
    }


def _wrong_cell(name: object, values: Any) -> bool:
    """Refuse a column of numbers with something else among them; a column of texts is left out."""
    import pandas

    numbers = pandas.to_numeric(values, errors="coerce")
    wrong = numbers.isna() & values.notna()
    if wrong.all():
        return False
    row = int(np.argmax(wrong.to_numpy()))
    raise ResultsError(f"row {row + 1}, column '{name}': '{values.iloc[row]}' is no number")


def _mat(path: str | Path) -> Mapping[str, Any]:
    from scipy.io import loadmat

    content = loadmat(check_input(path, LARGEST_TABLE), squeeze_me=True)
    arrays = {n: v for n, v in content.items() if isinstance(v, np.ndarray) and v.ndim == 1 and v.dtype.kind in "fiub"}
    length = len(arrays["time"]) if "time" in arrays else max((len(values) for values in arrays.values()), default=0)
    units = content.get("units")  # of a run that was exported
    named = getattr(getattr(units, "dtype", None), "names", None) or ()
    return {
        f"{name} [{units[name].item()}]" if units is not None and name in named else name: values
        for name, values in arrays.items()
        if len(values) == length
    }


def _netcdf(path: str | Path) -> Mapping[str, Any]:
    import xarray as xr

    data = xr.load_dataset(check_input(path, LARGEST_TABLE), engine="h5netcdf")
    over = "time" if "time" in data.dims else str(next(iter(data.dims)))
    return table_columns(data if over in data.coords else data.assign_coords({over: np.arange(data.sizes[over])}), over)


def _parquet(path: str | Path) -> Mapping[str, Any]:
    from pyarrow import parquet

    table = parquet.read_table(check_input(path, LARGEST_TABLE))
    return {name: table[name].to_numpy() for name in table.column_names}


READERS = {".csv": _csv, ".mat": _mat, ".nc": _netcdf, ".parquet": _parquet}
