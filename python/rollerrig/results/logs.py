"""Measured signals from a file: columns of numbers with their units.

    .csv, .mat, .mf4, .nc, .parquet, .npz of `rollerrig serve --record` -> [read_log] -> Log: name of a column -> values, unit

A heading is `name` or `name [unit]`; a table is separated by commas, or by tabs or semicolons, where commas may be decimal. A
file that `rollerrig export` or `simulate` wrote has its columns by the same names.
"""

from __future__ import annotations

import csv
import re
import subprocess
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rollerrig.common.arrays import Array
from rollerrig.common.input_files import LARGEST_TABLE, check_hdf5, check_input, read_input
from rollerrig.config.schema.units import unit_factor
from rollerrig.results.other_formats import table_columns
from rollerrig.results.run_info import ResultsError

GAP = 5.5
"""A step of time that is so many times the median one is a gap."""

LONGEST_TRIAL = 60.0
"""Longest reading of a file in a process of its own [s]."""


Columns = Mapping[str, Any] | Iterable[tuple[str, Any]]
"""Headings and what stands below them."""


@dataclass(frozen=True)
class Log:
    """Columns of a file of measured signals: name -> values, all of one length; name -> unit in its heading, "" for none."""

    file: str
    columns: Mapping[str, Array]
    units: Mapping[str, str]


def read_log(source: Log | Mapping[str, Any] | str | Path, name: str = "log") -> Log:
    """Read a file of measured signals, or columns by their headings, called `name` in messages; a Log is one already.

    Raises:
        FileNotFoundError: no such file.
        ResultsError: a file of another kind, damaged, or without columns of numbers.
    """
    if isinstance(source, Log | Mapping):
        return log_of(source, name) if isinstance(source, Mapping) else source
    if (kind := Path(source).suffix.lower()) not in READERS:
        raise ResultsError(f"{source}: a file of measured signals ends in {', '.join(READERS)}")
    try:
        return log_of(READERS[kind](source), str(source))
    except FileNotFoundError:
        raise FileNotFoundError(f"{source}: no such file") from None
    except ImportError:
        library, extra = _OPTIONAL[kind]
        raise ResultsError(f'{source}: needs {library}, not installed: pip install "rollerrig[{extra}]"') from None
    except Exception as error:  # whatever the libraries meet in a damaged file
        reason = (str(error).splitlines() or [""])[0]
        raise (
            error if isinstance(error, ResultsError) else ResultsError(f"{source}: no table of numbers: {reason}")
        ) from None


def log_of(given: Columns, file: str) -> Log:
    """Columns by their headings as a Log, called `file` in messages; those without a heading are left out.

    Raises:
        ResultsError: there are none, one is there twice, a cell is no number, or they are of different lengths.
    """
    columns, units = {}, {}
    for heading, values in given.items() if isinstance(given, Mapping) else given:
        found = re.fullmatch(r"(.*?)\s*\[([^\[\]]*)\]", heading.strip())
        name, unit = found.groups() if found else (heading.strip(), "")
        if not name:
            continue
        if name in columns:
            raise ResultsError(f"{file}: column '{name}' is there twice; allowed: each heading once")
        if len(numbers := _numbers(name, np.asarray(values), file)):
            columns[name], units[name] = numbers, unit
    lengths = {len(values) for values in columns.values()}
    if not lengths:
        raise ResultsError(f"{file}: no column of numbers")
    if len(lengths) > 1:
        raise ResultsError(f"{file}: columns of different lengths, {', '.join(map(str, sorted(lengths)))}")
    return Log(file, columns, units)


def _numbers(name: str, values: Any, file: str) -> Array:
    """Values as numbers, NaN where nothing stands; none of a column of texts."""
    if values.dtype.kind in "fiub":
        return np.asarray(values, dtype=np.float64)
    numbers, wrong = np.full(len(values), np.nan), []
    for row, text in enumerate(map(str, values)):
        try:
            numbers[row] = float(text or "nan")
        except ValueError:
            wrong.append(row)
    if wrong and not np.isnan(numbers).all():
        raise ResultsError(f"{file}: row {wrong[0] + 1}, column '{name}': '{values[wrong[0]]}' is no number")
    return numbers[:0] if wrong else numbers


def column_of(log: Log, name: str) -> str:
    """The column of a name, also with '_' in place of '.' as MATLAB writes it; "" where there is none."""
    return next((one for one in (name, name.replace(".", "_")) if one in log.columns), "")


def log_quantity(log: Log, name: str, units: Mapping[str, float]) -> Array:
    """A column in SI.

    Args:
        log: of the columns.
        name: of the column, see `column_of`.
        units: in which it may be -> what one of it is in the unit of the result, which is the first one.

    Raises:
        ResultsError: there is no such column, it has no unit or one of something else, or a row has no number.
    """
    needed = f"'{name} [{next(iter(units))}]'"
    if not (column := column_of(log, name)):
        raise ResultsError(f"{log.file}: no column {needed}; there are {', '.join(log.columns)[:200]}")
    given = log.units[column]
    for unit, scale in units.items():
        factor = unit_factor(given, unit) if given else None
        if factor is not None:
            values = float(factor) * scale * log.columns[column]
            if not np.isfinite(values).all():
                row = int(np.argmax(~np.isfinite(values))) + 1
                raise ResultsError(f"{log.file}: {name}: row {row} has no number")
            return values
    said = f"[{given}] is no unit of it" if given else "has no unit"
    raise ResultsError(f"{log.file}: {name} {said}; write {needed}")


def time_problem(time: Array) -> str:
    """What is wrong with the times of a log, in words; "" where they rise without a gap."""
    steps = np.diff(time)
    usual = float(np.median(steps))
    for what, wrong in (("not later", steps <= 0.0), (f"a gap, rows are {usual:g} s apart", steps > GAP * usual)):
        if wrong.any():
            row = int(np.argmax(wrong))
            return f"{time[row + 1]:g} s follows {time[row]:g} s: {what}"
    return ""


def _csv(path: str | Path) -> Columns:
    text = read_input(path, LARGEST_TABLE).decode("utf-8-sig")
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    if not lines:
        raise ResultsError(f"{path}: an empty file; needed: a heading and rows of numbers")
    separator = max(",;\t", key=lines[0].count)
    head, *rows = csv.reader(lines, delimiter=separator)
    for number, row in enumerate(rows, 1):
        if len(row) < len(head) or any(cell.strip() for cell in row[len(head) :]):  # each row may end in a separator
            hint = "; decimal commas need ; or tabs between the cells" if separator == "," else ""
            raise ResultsError(f"{path}: row {number} has {len(row)} cells, the heading {len(head)}{hint}")
    decimal = "." if separator == "," else _decimal_mark(path, rows)
    return [(name, [row[k].strip().replace(decimal, ".") for row in rows]) for k, name in enumerate(head)]


def _decimal_mark(path: str | Path, rows: list[list[str]]) -> str:
    """That of the cells; a comma beside points may part thousands."""
    found = {}
    for mark in ".,":
        number = re.compile(rf"\s*[+-]?(\d+[{mark}]\d*|[{mark}]\d+)([eE][+-]?\d+)?\s*")
        found[mark] = next((cell for row in rows for cell in row if mark in cell and number.fullmatch(cell)), "")
    if all(found.values()):
        shown = f"a point in '{found['.']}', a comma in '{found[',']}'"
        raise ResultsError(f"{path}: {shown}; allowed: one of them, as the decimal mark of all cells")
    return "," if found[","] else "."


def _try(path: str | Path, reading: str) -> None:
    """Refuses a file on which its library ends the process, or never ends: it is read in a process of its own first."""
    trial = [sys.executable, "-P", "-c", f"import sys; {reading}", str(check_input(path, LARGEST_TABLE))]
    if not sys.executable:  # Python within another program
        return
    try:
        damaged = subprocess.run(trial, capture_output=True, check=False, timeout=LONGEST_TRIAL).returncode != 0
    except subprocess.TimeoutExpired:
        damaged = True
    if damaged:
        raise ResultsError(f"{path}: a damaged file, or none of {Path(path).suffix}")


def _mat(path: str | Path) -> Mapping[str, Any]:
    from scipy.io import loadmat

    _try(path, "from scipy.io import loadmat; loadmat(sys.argv[1], squeeze_me=True)")
    content = loadmat(path, squeeze_me=True)
    arrays = {n: v for n, v in content.items() if isinstance(v, np.ndarray) and v.ndim == 1 and v.dtype.kind in "fiub"}
    length = len(arrays["time"]) if "time" in arrays else max((len(values) for values in arrays.values()), default=0)
    units = content.get("units")  # of a run that was exported
    named = getattr(getattr(units, "dtype", None), "names", None) or ()
    own = {name: f"{name} [{units[name].item()}]" for name in named if units is not None}
    return {own.get(name, name): values for name, values in arrays.items() if len(values) == length}


def _netcdf(path: str | Path) -> Mapping[str, Any]:
    import xarray as xr

    data = xr.load_dataset(check_hdf5(path, LARGEST_TABLE), engine="h5netcdf")
    return table_columns(data, "time" if "time" in data.coords else str(next(iter(data.coords))))


def _parquet(path: str | Path) -> Mapping[str, Any]:
    from pyarrow import parquet

    table = parquet.read_table(check_input(path, LARGEST_TABLE))
    return {name: table[name].to_numpy() for name in table.column_names}


def _mdf(path: str | Path) -> Columns:
    """Channels of numbers over the times of the one that has most; what was sampled at others is interpolated."""
    from asammdf import MDF

    _try(path, "from asammdf import MDF; list(MDF(sys.argv[1]).iter_channels())")
    with MDF(path) as file:
        filled = (one for one in file.iter_channels() if len(one.timestamps))  # a group may have no record
        kept = [one for one in filled if one.samples.ndim == 1 and one.samples.dtype.kind in "fiub"]
        if not kept:
            raise ResultsError(f"{path}: no channel of numbers")
        time = max((one.timestamps for one in kept), key=len)
        inside = time[(time >= max(s.timestamps[0] for s in kept)) & (time <= min(s.timestamps[-1] for s in kept))]
        heads = [f"{one.name} [{one.unit}]" if one.unit else one.name for one in kept]
        values = [np.interp(inside, one.timestamps, one.samples.astype(np.float64)) for one in kept]
        return [("time [s]", inside), *zip(heads, values, strict=True)]


def _record(path: str | Path) -> Mapping[str, Any]:
    """What `rollerrig serve --record` sent in each period."""
    with np.load(check_input(path, LARGEST_TABLE), allow_pickle=False) as kept:
        sensors, period = kept["sensors"], float(kept["period"])
        heads = [f"{name} [{unit}]" for name, unit in zip(kept["outputs"], kept["units"], strict=True)]
    return {"time [s]": period * np.arange(len(sensors)), **dict(zip(heads, sensors.T, strict=True))}


READERS = {".csv": _csv, ".mat": _mat, ".mf4": _mdf, ".nc": _netcdf, ".parquet": _parquet, ".npz": _record}
_OPTIONAL = {".parquet": ("pyarrow", "parquet"), ".mf4": ("asammdf", "mdf")}
"""Library that a kind of file needs, and the extra of the package that brings it."""
