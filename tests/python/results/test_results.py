"""Energy audit, files, tables and summary of a run."""

from __future__ import annotations

import errno
import os
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig import results
from rollerrig.config import Case
from rollerrig.results import ResultsError, files, variable
from rollerrig.results.dataset import DISSIPATED, STORED, WORK_IN


def short_case() -> Case:
    return rr.load_case("wheelset_rollers").with_changes({"motion.speed": "40 km/h", "time.duration": "0.1 s"})


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return rr.simulate(short_case())


def audited(samples: int = 3, **given: list[float]) -> results.Draft:
    """The audit of so many samples of every account, zero unless given."""
    names = (*WORK_IN, *STORED, *DISSIPATED)
    accounts = {name: variable("time", np.array(given.get(name, [0.0] * samples)), "J", name) for name in names}
    draft = results.Draft(accounts, {"time": variable("time", np.arange(float(samples)), "s", "time")}, {})
    results.add_energy_audit(draft)
    return draft


def test_a_swing_turns_its_energy_over_without_residual() -> None:
    swing = audited(energy_kinetic=[0.0, 5.0, 0.0], energy_gravity=[7.0, 2.0, 7.0])
    assert swing.attributes == {"energy_turned_over_j": 10.0, "energy_relative_residual": 0.0}


def test_a_missing_joule_shows() -> None:
    audit = audited(energy_work_of_drive=[0.0, 4.0, 8.0], energy_dissipated_creep=[0.0, 4.0, 7.0])
    assert audit.values("energy_residual").tolist() == [0.0, 0.0, 1.0]
    assert audit.attributes["energy_relative_residual"] == 1.0 / 7.5


def test_runs_alike_share_nothing_but_what_is_constant() -> None:
    first, second = (audited(energy_kinetic=[0.0, height, 0.0]) for height in (5.0, 3.0))
    one = first.dataset()
    one["energy_kinetic"].attrs["units"] = "kJ"
    one.attrs["title"] = "changed"
    other = second.dataset()
    assert one["energy_kinetic"].values.tolist() == [0.0, 5.0, 0.0]
    assert other["energy_kinetic"].values.tolist() == [0.0, 3.0, 0.0]
    assert other["energy_kinetic"].attrs["units"] == "J"
    assert other.attrs == second.attributes
    assert np.shares_memory(other["energy_kinetic"].values, second.values("energy_kinetic"))  # nothing is copied
    later = results.Draft(second.variables, {"time": variable("time", np.arange(3.0) + 1.0, "s", "time")}, {}).dataset()
    assert later["time"].values.tolist() == [1.0, 2.0, 3.0]
    assert other["time"].values.tolist() == [0.0, 1.0, 2.0]


def test_no_samples_have_no_residual() -> None:
    assert audited(samples=0).attributes == {"energy_turned_over_j": 0.0, "energy_relative_residual": 0.0}


def test_what_is_saved_is_what_is_loaded(run: xr.Dataset, tmp_path: Path) -> None:
    path = rr.save_run(run, tmp_path / "run.nc")
    xr.testing.assert_identical(rr.load_run(path), run)


@pytest.mark.slow
def test_a_file_is_read_as_xarray_reads_it(run: xr.Dataset, tmp_path: Path) -> None:
    """By h5netcdf, which is slow: values, order, types of values and attributes; a dimension without coordinate, lists, flags."""
    more = {"flag": ("side", [True, False]), "name": ("side", ["left", "right"]), "count": ((), 3)}
    attributes = {"names": ["a", "b"], "one": [1.5], "several": [1, 2], "none": ""}
    path = rr.save_run(run.assign(more).assign_attrs(attributes), tmp_path / "run.nc")
    found, expected = rr.load_run(path), xr.load_dataset(path, engine="h5netcdf")
    for name in ("format", "program"):
        del expected.attrs[name]
    xr.testing.assert_identical(found, expected)
    assert list(found.data_vars) == list(expected.data_vars)
    assert {name: v.dtype for name, v in found.variables.items()} == {n: v.dtype for n, v in expected.variables.items()}
    assert {name: type(v) for name, v in found.attrs.items()} == {n: type(v) for n, v in expected.attrs.items()}


def test_same_run_same_bytes(run: xr.Dataset, tmp_path: Path) -> None:
    again = rr.simulate(short_case())
    first = rr.save_run(run, tmp_path / "first.nc").read_bytes()
    assert first == rr.save_run(again, tmp_path / "second.nc").read_bytes()


def test_any_dataset_can_be_saved(tmp_path: Path) -> None:
    data = xr.Dataset(
        {"a": ("x", [1.0, 2.0], {"units": "m"}), "n": ((), 3)},
        {"x": ["p", "q"], "label": ("x", ["one", "two"])},
        {"title": "ä"},
    )
    xr.testing.assert_identical(rr.load_run(rr.save_run(data, tmp_path / "any.nc")), data)


@pytest.mark.slow
def test_the_file_is_laid_out_as_h5netcdf_lays_it_out(run: xr.Dataset, tmp_path: Path) -> None:
    """Dimensions, their numbers, scales and attributes are those that an independent writer makes of the same Dataset."""
    import h5netcdf
    import h5py

    run.to_netcdf(
        tmp_path / "theirs.nc", engine="h5netcdf", encoding={name: {"_FillValue": None} for name in run.variables}
    )
    rr.save_run(run, tmp_path / "ours.nc")
    with h5netcdf.File(tmp_path / "ours.nc") as ours, h5netcdf.File(tmp_path / "theirs.nc") as theirs:
        assert {name: one.size for name, one in ours.dimensions.items()} == dict(run.sizes)
        assert ours.variables.keys() == theirs.variables.keys()
        for name, one in ours.variables.items():
            assert one.dimensions == theirs.variables[name].dimensions == run[name].dims, name
    with h5py.File(tmp_path / "ours.nc") as ours, h5py.File(tmp_path / "theirs.nc") as theirs:
        for name in run.variables:
            own = {key for key in ours[name].attrs if key != "coordinates"}
            assert own == {key for key in theirs[name].attrs if key != "coordinates"}, name
            scales = [[scale.name for scale in dimension.values()] for dimension in ours[name].dims]
            assert scales == [[scale.name for scale in dimension.values()] for dimension in theirs[name].dims], name


def test_a_full_disk_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    target = tmp_path / "summary.json"
    target.write_text("old")
    monkeypatch.setattr(files.os, "fsync", full)
    with pytest.raises(rr.OutputError, match=r"summary.json: cannot be written: the disk is full"):
        results.write_text(target, "new", force=True)
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_a_device_is_written_to_and_a_full_one_reported(tmp_path: Path) -> None:
    results.write_text("/dev/null", "text")
    with pytest.raises(rr.OutputError, match="/dev/full: cannot be written: the disk is full"):
        results.write_text("/dev/full", "text")


def test_folders_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(rr.OutputError, match="choose another folder"):
        results.output_folder(tmp_path / "file")
    with pytest.raises(rr.OutputError, match="a part of the path is a file"):
        results.output_folder(tmp_path / "file" / "below")
    with pytest.raises(rr.OutputError, match="the folder does not exist"):
        results.write_text(tmp_path / "missing" / "a.txt", "text")
    with pytest.raises(rr.OutputError, match="there is a folder of that name"):
        results.output_file(tmp_path)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(rr.OutputError, match="no permission"):
        results.output_folder(tmp_path)


def test_files_are_readable_by_others_as_usual(tmp_path: Path) -> None:
    mask = os.umask(0o022)
    try:
        assert results.write_text(tmp_path / "a.txt", "text").stat().st_mode & 0o777 == 0o644
    finally:
        os.umask(mask)


def test_a_missing_run_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"nothing.nc: no such file"):
        rr.load_run(tmp_path / "nothing.nc")


def test_an_offset_counts_from_the_equilibrium(run: xr.Dataset) -> None:
    """Which rounding leaves less than an attometre beside the middle."""
    assert float(run["lateral"].sel(body="wheelset_1")[0]) == pytest.approx(0.003, rel=1e-15)


def test_a_run_without_samples_has_a_summary(run: xr.Dataset) -> None:
    summary = results.summarise(run.isel(time=slice(0)))
    assert summary["samples"] == 0
    assert summary["bodies"]["wheelset_1"]["lateral_largest_mm"] is None


def test_a_damaged_file_is_refused_in_one_line(run: xr.Dataset, tmp_path: Path) -> None:
    """A byte changed in the tables of HDF5 or elsewhere: read, or one line; no error of a library."""
    whole = bytes(results.netcdf_bytes(run))
    random = np.random.default_rng(29)
    lines, read = [], 0
    for at in (8, 84, 204, 529, 3809, 3828, *random.integers(0, len(whole), 4)):
        path = tmp_path / "damaged.nc"
        path.write_bytes(whole[:at] + bytes([whole[at] ^ int(random.integers(1, 256))]) + whole[at + 1 :])
        try:
            results.load_run(path)
        except ResultsError as error:
            lines.append(str(error))
        else:
            read += 1
    assert all("\n" not in line and "damaged.nc: " in line for line in lines)
    assert len(lines) > 2
    assert read > 2


@pytest.mark.parametrize("text", ["lateral displacement", "vertical_force"])
def test_a_text_with_bytes_that_are_no_utf_8_is_refused(run: xr.Dataset, tmp_path: Path, text: str) -> None:
    """In an attribute, in a name: what is read could not be written again."""
    assert run["lateral"].attrs["long_name"].startswith("lateral displacement")
    path = tmp_path / "damaged.nc"
    path.write_bytes(bytes(results.netcdf_bytes(run)).replace(text.encode(), b"\x9c" + text[1:].encode()))
    with pytest.raises(ResultsError, match=r"damaged.nc: no NetCDF file of results such as run.nc, or a damaged one"):
        results.load_run(path)


def test_a_collection_of_texts_without_an_end_is_refused(run: xr.Dataset, tmp_path: Path) -> None:
    """The HDF5 library walks through it for ever: an object that has neither index nor size."""
    whole = bytearray(results.netcdf_bytes(run))
    second = whole.index(b"GCOL\1\0\0\0") + 16 + 24  # behind the head and one object of a short text
    whole[second : second + 16] = bytes(16)
    path = tmp_path / "endless.nc"
    path.write_bytes(whole)
    with pytest.raises(ResultsError, match="its collection of texts has no end"):
        results.load_run(path)
    assert not results.output_file(tmp_path / "new.nc").exists()
    with pytest.raises(rr.OutputError):
        results.save_run(run, path)  # it does not say that it is ours


def test_collections_of_texts_that_overlap_are_refused(tmp_path: Path) -> None:
    """Each of 30000 heads begins a collection up to the end of the file, of objects that skip the heads: 450 million."""
    path = tmp_path / "overlapping.nc"
    head = b"GCOL\1\0\0\0" + (1 << 40).to_bytes(8, "little")
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + 30_000 * (head + b"\1" + bytes(7) + (16).to_bytes(8, "little")))
    begun = time.process_time()
    with pytest.raises(ResultsError, match="its collection of texts has no end"):
        results.load_run(path)
    assert time.process_time() - begun < 10.0


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("status_message", None),
        ("stopped_at_s", "soon"),
        ("energy_turned_over_j", None),
        ("warnings", 3),
        ("case", None),
    ],
)
def test_a_run_without_a_sound_attribute_is_refused(run: xr.Dataset, tmp_path: Path, name: str, value: object) -> None:
    kept = {key: own for key, own in run.attrs.items() if key != name} | ({} if value is None else {name: value})
    path = tmp_path / "damaged.nc"
    path.write_bytes(results.netcdf_bytes(xr.Dataset(run.data_vars, run.coords, kept)))
    with pytest.raises(
        ResultsError, match=rf"damaged.nc: a damaged file: its attribute {name} is missing or of another"
    ):
        results.load_run(path)


def test_an_offset_that_is_no_number_is_found_at_once(run: xr.Dataset, tmp_path: Path) -> None:
    path = results.save_run(run, tmp_path / "damaged.nc")
    with h5py.File(path, "r+") as file:
        file["lateral"].attrs["add_offset"] = "x"
    with pytest.raises(ResultsError, match="or a damaged one"):
        results.load_run(path)


def test_a_variable_of_other_dimensions_is_named(run: xr.Dataset, tmp_path: Path) -> None:
    turned = run.copy()
    turned["lateral"] = run["lateral"].isel(body=0, drop=True)
    with pytest.raises(ResultsError, match="a damaged file: lateral over time, not over time, body"):
        results.load_run(results.save_run(turned, tmp_path / "run.nc"))


def test_one_moment_of_a_run_is_read(run: xr.Dataset, tmp_path: Path) -> None:
    moment = run.isel(time=0)
    again = results.load_run(results.save_run(moment, tmp_path / "moment.nc"))
    xr.testing.assert_equal(again["lateral"].drop_vars("time", errors="ignore"), moment["lateral"].drop_vars("time"))
    moment["lateral"] = moment["lateral"].isel(body=0, drop=True)
    with pytest.raises(ResultsError, match="a damaged file: lateral over nothing, not over body"):
        results.load_run(results.save_run(moment, tmp_path / "turned.nc"))
