"""Result files: written whole or not at all, the same bytes for the same run.

    Dataset, text -> [files] -> temporary name -> final name

A NetCDF file is made in memory and then written like any text, so that a full disk is met by one plain write. No time
stamps, no names of machines or folders go into it.
"""

import errno
import io
import math
import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np
import xarray as xr

from rollerrig.common.input_files import check_hdf5
from rollerrig.results.dataset import wrong_attribute, wrong_dimensions
from rollerrig.results.marks import PROGRAM, exists, is_ours
from rollerrig.results.run_info import ResultsError


def available_memory() -> float:
    """Memory that a process can still get, also under a limit on its addresses [bytes]; infinite where none is known."""
    try:
        import resource  # none on Windows

        with open("/proc/meminfo", encoding="ascii") as file:  # noqa: PTH123
            fields = dict(line.split(":", 1) for line in file)
        free = 1024.0 * float(fields["MemAvailable"].split()[0])
        with open("/proc/self/statm", encoding="ascii") as file:  # noqa: PTH123
            used = int(file.read().split()[0]) * resource.getpagesize()
        limit, _ = resource.getrlimit(resource.RLIMIT_AS)
        return free if limit == resource.RLIM_INFINITY else max(0.0, min(free, float(limit - used)))
    except (ImportError, OSError, KeyError, ValueError, IndexError):
        return math.inf


FORMAT = 2
"""Version of the files' layout; raised when variables, attributes or their meaning change."""

COMPRESSION_LEVEL = 1  # of zlib; higher levels take longer and save little on vibrating floats

PLACE_HOLDER = "This is a netCDF dimension but not a netCDF variable."
LAYOUT = {"CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST", "_Netcdf4Dimid", "_Netcdf4Coordinates", "_NCProperties"}
"""Dimensions without a coordinate have this name in a NetCDF 4 file, and the attributes of its layout these."""

_REMEDIES = {
    errno.ENOSPC: "the disk is full; free some space or choose another folder",
    errno.EDQUOT: "the disk quota is used up; free some space or choose another folder",
    errno.EFBIG: "the file would be larger than allowed here; raise time.output_step or choose another folder",
    errno.EACCES: "no permission to write there; choose another folder",
    errno.EPERM: "no permission to write there; choose another folder",
    errno.EROFS: "the file system is read-only; choose another folder",
    errno.ENOTDIR: "a part of the path is a file; choose another folder",
    errno.EEXIST: "there is a file of that name; choose another folder",
    errno.EISDIR: "there is a folder of that name; choose another name",
    errno.ENOENT: "the folder does not exist; create it or choose another",
    errno.ENAMETOOLONG: "the name is too long; choose a shorter one",
}


FOREIGN = "not written by this program; choose another name, or replace it with --force (force=True)"
"""Message about a file that is in the way."""


class OutputError(Exception):
    """A result could not be written; nothing half-written was left."""

    def __init__(self, path: Path, cause: OSError | str) -> None:
        if isinstance(cause, OSError):
            remedy = _REMEDIES.get(cause.errno or 0, f"{cause.strerror or cause}; choose another folder")
            cause = f"cannot be written: {remedy}"
        super().__init__(f"{path}: {cause}")
        self.path = path


def _named(path: str | Path) -> Path:
    """The path; an OutputError where no file can have that name."""
    if "\0" in str(path):
        raise OutputError(Path(str(path).replace("\0", "\\0")), OSError(errno.EINVAL, "a null byte in its name"))
    return Path(path)


def output_folder(path: str | Path) -> Path:
    """The folder, made if need be, and known to take files: better before a long run than after it.

    Raises:
        OutputError: it cannot be made or written to.
    """
    folder = _named(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as probe:
            probe.write(b"0")
    except OSError as cause:
        raise OutputError(folder, cause) from None
    return folder


def output_file(path: str | Path, *, tables: Sequence[str] = (), force: bool = False) -> Path:
    """The path of a file, its folder made if need be and known to take files.

    Args:
        path: the file.
        tables: first lines of the tables that may be replaced there.
        force: whether a file of another program may be replaced.

    Raises:
        OutputError: the folder cannot be made or written to, or the path is a folder or a file that this program did not
            write.
    """
    target = _named(path)
    if target.is_dir():
        raise OutputError(target, IsADirectoryError(errno.EISDIR, "is a folder"))
    if _is_device(target):
        return target
    if exists(target) and not (force or is_ours(target, tables)):
        raise OutputError(target, FOREIGN)
    output_folder(target.resolve().parent)
    return target


def _is_device(target: Path) -> bool:
    """Something that takes bytes but no other name: /dev/stdout, a pipe."""
    return target.exists() and not target.is_file()


def write_bytes(
    path: str | Path, content: bytes | memoryview, *, tables: Sequence[str] = (), force: bool = False
) -> Path:
    """Write a file under a temporary name and rename it; an older file of that name stays until then.

    Args:
        path: the file; its folder exists.
        content: all of it.
        tables: first lines of the tables that may be replaced there.
        force: whether a file of another program may be replaced.

    Raises:
        OutputError: it could not be written, or would have replaced a file that this program did not write.
    """
    target = _named(path).resolve()
    temporary: Path | None = None
    if exists(target) and not (force or _is_device(target) or is_ours(target, tables)):
        raise OutputError(Path(path), FOREIGN)
    try:
        if _is_device(target):
            with target.open("wb", buffering=0) as file:
                file.write(content)
            return Path(path)
        handle, name = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
        temporary = Path(name)
        with os.fdopen(handle, "wb") as file:
            _write_all(file, content)
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(target)
    except OSError as cause:
        raise OutputError(Path(path), cause) from None
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
    return Path(path)


def write_new(path: Path, content: bytes | memoryview) -> None:
    """Write a file that does not exist yet, down to the disk.

    Raises:
        OSError: it could not be written; what is there of it is not whole.
    """
    with path.open("xb") as file:
        _write_all(file, content)


def _write_all(file: IO[bytes], content: bytes | memoryview) -> None:
    file.write(content)
    file.flush()
    os.fsync(file.fileno())


def write_text(path: str | Path, text: str, *, tables: Sequence[str] = (), force: bool = False) -> Path:
    """Write a text file as `write_bytes` does, in UTF-8."""
    return write_bytes(path, text.encode(), tables=tables, force=force)


def save_run(run: xr.Dataset, path: str | Path, *, force: bool = False) -> Path:
    """Write a Dataset as compressed NetCDF 4; the same Dataset gives the same bytes.

    Args:
        run: results of `simulate` or any other Dataset.
        path: the file; its name ends in .nc by custom. Results that are there already are replaced.
        force: whether a file that this program did not write may be replaced, too.

    Raises:
        OutputError: it could not be written, or would have replaced such a file.

    Example:
        >>> import tempfile
        >>> import rollerrig as rr
        >>> run = rr.simulate(rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.02 s"}))
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     again = rr.load_run(rr.save_run(run, Path(folder) / "run.nc"))
        >>> again.equals(run)
        True
    """
    return write_bytes(path, netcdf_bytes(run), force=force)


def netcdf_bytes(run: xr.Dataset) -> memoryview:
    """The Dataset as a NetCDF 4 file in memory.

    Written by h5py, as the NetCDF library lays it out: a dimension is an HDF5 dimension scale, `_Netcdf4Dimid` its number,
    `_Netcdf4Coordinates` those of a variable's dimensions. h5netcdf looks each of them up again for every variable, which
    takes four times as long.

    Source: NetCDF-4 file format specification, appendix C of the NetCDF user's guide.
    """
    import h5py

    buffer = io.BytesIO()
    numbers = {str(name): number for number, name in enumerate(run.sizes)}
    with h5py.File(buffer, "w", track_order=True) as file:
        scales = {name: _scale(file, name, numbers[name], run) for name in numbers}
        for name in (str(name) for name in [*run.coords, *run.data_vars] if name not in numbers):
            stored = _stored(file, name, run, numbers)
            for place, dimension in enumerate(run[name].dims):
                h5py.h5ds.attach_scale(stored.id, scales[str(dimension)].id, place)
            outer = [str(c) for c in run[name].coords if c not in run.dims and str(c) != name]
            if outer and name in run.data_vars:
                stored.attrs["coordinates"] = " ".join(outer)
        for key, value in (run.attrs | {"format": FORMAT, "program": PROGRAM}).items():
            file.attrs[key] = value
    return buffer.getbuffer()


def _scale(file: Any, name: str, number: int, run: xr.Dataset) -> Any:
    """A dimension as HDF5 has it: its coordinate, or a place holder where it has none."""
    if name in run.coords:
        scale = _stored(file, name, run, {name: number})
        scale.make_scale(name)
    else:
        scale = file.create_dataset(name, (run.sizes[name],), ">f4", track_order=True)
        scale.make_scale(f"{PLACE_HOLDER}{run.sizes[name]:10}")
        scale.attrs["_Netcdf4Dimid"] = np.int32(number)
    return scale


def _stored(file: Any, name: str, run: xr.Dataset, numbers: Mapping[str, int]) -> Any:
    """A variable with its values and attributes."""
    import h5py

    variable = run.variables[name]
    values = variable.to_numpy()
    options: dict[str, Any] = {"track_order": True}
    if values.dtype.kind in "UO":
        values, options["dtype"] = values.astype(object), h5py.string_dtype()
    elif values.ndim and values.size:
        options |= {
            "chunks": values.shape, "compression": "gzip", "compression_opts": COMPRESSION_LEVEL, "shuffle": True
        }  # fmt: skip
    stored = file.create_dataset(name, data=values, **options)
    if variable.dims:
        stored.attrs["_Netcdf4Dimid"] = np.int32(numbers[str(variable.dims[0])])
        stored.attrs["_Netcdf4Coordinates"] = np.array([numbers[str(one)] for one in variable.dims], np.int32)
    for key, value in variable.attrs.items():
        stored.attrs[key] = value
    return stored


def load_run(path: str | Path) -> xr.Dataset:
    """Read a Dataset that `save_run` wrote, whole, into memory. Nothing that the file holds is ever executed.

    Raises:
        FileNotFoundError: no such file.
        ResultsError: it was written by another version of rollerrig or by another program, is damaged, is a folder, or does not
            fit in memory.

    Example:
        >>> load_run("none.nc")
        Traceback (most recent call last):
        FileNotFoundError: none.nc: no such file
    """
    if Path(path).is_dir():
        raise ResultsError(f"{path}: a folder; {_of_folder(Path(path))}")
    damaged = "no NetCDF file of results such as run.nc, or a damaged one"
    try:
        _check_results(check_hdf5(path, None))
        run = _dataset(Path(path))
        wrong = wrong_dimensions(run) or wrong_attribute(run)
    except FileNotFoundError:
        raise FileNotFoundError(f"{path}: no such file") from None
    except ResultsError:
        raise
    except OSError as error:  # those of the HDF5 library have no strerror
        raise ResultsError(f"{path}: {error.strerror or damaged}") from None
    except Exception:  # whatever h5py and xarray meet in a damaged file
        raise ResultsError(f"{path}: {damaged}") from None
    if wrong:
        raise ResultsError(f"{path}: a damaged file: {wrong}")
    for name in ("format", "program"):
        run.attrs.pop(name, None)
    return run


def _dataset(path: Path) -> xr.Dataset:
    """What a NetCDF 4 file holds, read by h5py: h5netcdf takes four times as long, for the same reason as in `netcdf_bytes`."""
    import h5py

    variables = {}
    with h5py.File(path, "r") as file:
        for name, stored in file.items():
            name.encode()
            text = h5py.check_string_dtype(stored.dtype)
            if not h5py.h5ds.is_scale(stored.id):
                dimensions = [scales[0].name.lstrip("/") for scales in stored.dims]
            elif h5py.h5ds.get_scale_name(stored.id).startswith(PLACE_HOLDER.encode()):
                continue
            else:
                dimensions = [name]
            values = (stored.asstr() if text else stored)[()]
            encoding = {"dtype": str} if text else None  # without it an index of texts is one of objects
            variables[name] = xr.Variable(dimensions, values, _attributes(stored), encoding)
        return xr.decode_cf(xr.Dataset(variables, attrs=_attributes(file))).load()  # what is damaged shows here


def _attributes(stored: Any) -> dict[str, Any]:
    """Those that are not the layout's own; what is alone in its array without it."""
    found = {name: value for name, value in stored.attrs.items() if name not in LAYOUT}
    for name, value in found.items():
        if isinstance(value, np.ndarray):
            found[name] = value.flat[0] if value.size == 1 else value.tolist() if value.dtype == object else value
        for text in (name, *np.ravel(found[name])):
            str(text).encode()  # UnicodeEncodeError: h5py lets bytes through that are no UTF-8
    return found


def _of_folder(folder: Path) -> str:
    """What a user who named a folder of results may have meant."""
    try:
        found = sorted(path.name for path in folder.glob("*.nc"))
    except OSError:
        found = []
    if not found:
        return "there is no NetCDF file of results such as run.nc in it"
    name = "run.nc" if "run.nc" in found else found[0]
    others = f"; or another one there: {', '.join(one for one in found if one != name)}" if len(found) > 1 else ""
    return f"give the {name} in it: {folder / name}{others}"


def _check_results(path: Path) -> None:
    """Refuse what is not ours, and what would not fit: a small file may hold many zeros."""
    import h5py

    with h5py.File(path, "r") as file:
        found = np.ravel(file.attrs.get("format", "none"))
        writer = file.attrs.get("rollerrig_version", "another program")
        if found.tolist() != [FORMAT]:
            raise ResultsError(
                f"{path}: results of another version (rollerrig {writer}, format {found[0] if found.size else 'none'}); this "
                f"one reads format {FORMAT}: run the case again"
            )
        size = sum(data.size * data.dtype.itemsize for data in file.values() if isinstance(data, h5py.Dataset))
    if size > 0.9 * available_memory():
        allowed = f"{available_memory() / 1e9:.3g} GB of memory are available"
        raise ResultsError(f"{path}: {size / 1e9:.3g} GB of results; {allowed}")


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
