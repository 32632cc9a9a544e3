"""A run in the files of other programs: MATLAB, CSV, Parquet.

    Dataset -> [export] -> .mat: arrays with their dimensions; .csv, .parquet: a table, a column per signal of each part

Numbers are the run's own, to the last bit. A table has the signals over one time: those at output times, or with
`over="reading_time"` those of the finer readings; what belongs to no time, and texts, only go into a .mat file.
"""

import io
import itertools
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any, cast

import xarray as xr
from numpy.typing import NDArray

from rollerrig.results.files import load_run, output_file, write_bytes
from rollerrig.results.marks import PROGRAM
from rollerrig.results.run_info import ResultsError

MAT_HEAD = f"MATLAB 5.0 MAT-file, written by {PROGRAM}".encode()
Columns = dict[str, NDArray[Any]]


def export(
    run: xr.Dataset | str | Path, path: str | Path, *, to: str = "", over: str = "time", force: bool = False
) -> Path:
    """Write a run for another program.

    Args:
        run: of `simulate`, or a file that `save_run` wrote.
        path: the file.
        to: 'mat', 'csv' or 'parquet'; "": what the name ends in.
        over: dimension of a table: 'time' or 'reading_time'.
        force: whether a file that this program did not write, or does not know again (.parquet), may be replaced.

    Returns:
        The path.

    Raises:
        ResultsError: no such kind or dimension; no results in the file; pyarrow is not installed.
        OutputError: it could not be written, or would have replaced such a file.
    """
    kind = to or Path(path).suffix.removeprefix(".")
    if kind not in KINDS:
        raise ResultsError(f"--to {kind or 'nothing'}; allowed: {', '.join(KINDS)}")
    if kind == "parquet" and find_spec("pyarrow") is None:
        raise ResultsError('--to parquet: needs pyarrow, which is not installed: pip install "rollerrig[parquet]"')
    found = run if isinstance(run, xr.Dataset) else load_run(run)
    if kind != "mat" and over not in found.dims:
        there = [str(name) for name in found.dims if str(name).endswith("time")]
        shown = ", ".join(there) or "they have no time: --to mat"
        raise ResultsError(f"--over {over}: not in these results; allowed: {shown}")
    tables = [_head_line(found, over)] if kind == "csv" else []
    output_file(path, tables=tables, force=force)
    return write_bytes(path, KINDS[kind](found, over), tables=tables, force=force)


def table_columns(run: xr.Dataset, over: str = "time") -> Columns:
    """Column -> values over a time: 'wheelset_1_left.vertical_force [N]'; of patches 'wheelset_1_left.0.patch_normal [N]'."""
    columns: Columns = {_heading(over, run[over]): run[over].to_numpy()}
    for name, variable in run.data_vars.items():
        if over not in variable.dims or variable.dtype.kind not in "fiub":
            continue
        moved = variable.transpose(over, ...)
        labels = [[str(label) for label in run[dim].to_numpy()] for dim in moved.dims[1:]]
        flat = moved.to_numpy().reshape(run.sizes[over], -1)
        for k, owner in enumerate(itertools.product(*labels)):
            columns[_heading(".".join([*owner, str(name)]), variable)] = flat[:, k]
    return columns


def _heading(name: str, variable: xr.DataArray) -> str:
    unit = str(variable.attrs.get("units", ""))
    return name if unit in ("", "1") else f"{name} [{unit}]"


def _head_line(run: xr.Dataset, over: str) -> str:
    return ",".join(f'"{name}"' if "," in name else name for name in table_columns(run, over))


def _csv(run: xr.Dataset, over: str) -> bytes:
    columns = table_columns(run, over)
    lines = [_head_line(run, over)]
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    lines += [",".join("" if value != value else repr(value) for value in row) for row in rows]
    return ("\n".join(lines) + "\n").encode()


def _parquet(run: xr.Dataset, over: str) -> bytes:
    from pyarrow import parquet, table

    kept = {key: str(run.attrs.get(key, "")) for key in ("case", "rollerrig_version", "config_toml")}
    about = {"program": PROGRAM, **kept}
    columns = table(table_columns(run, over)).replace_schema_metadata(about)
    buffer = io.BytesIO()
    parquet.write_table(columns, buffer, compression="zstd")
    return buffer.getvalue()


def _mat(run: xr.Dataset, _: str) -> bytes:
    content: dict[str, Any] = {}
    units, meanings, dimensions = {}, {}, {}
    for name in map(str, [*run.coords, *run.data_vars]):
        variable = run[name]
        text = variable.dtype.kind in "UO"
        content[name] = variable.to_numpy().astype(object) if text else variable.to_numpy()
        units[name] = str(variable.attrs.get("units", ""))
        meanings[name] = str(variable.attrs.get("long_name", ""))
        dimensions[name] = " ".join(map(str, variable.dims))
    content |= {"units": units, "long_names": meanings, "dimensions": dimensions}
    content["about"] = {key: str(value) for key, value in run.attrs.items()}
    return mat_bytes(content)


def mat_bytes(content: dict[str, Any]) -> bytes:
    """A MATLAB 5 file of arrays, texts and structs; the same content gives the same bytes."""
    import scipy.io

    buffer = io.BytesIO()
    scipy.io.savemat(cast("Any", buffer), content, do_compression=True, long_field_names=True, oned_as="column")
    return MAT_HEAD.ljust(116) + buffer.getvalue()[116:]  # scipy writes the time there


KINDS: dict[str, Callable[[xr.Dataset, str], bytes]] = {"mat": _mat, "csv": _csv, "parquet": _parquet}
"""What a run is exported to, by the ending of a file's name."""
