"""Functions of the library that keep their runs in a folder go on where they were stopped."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import xarray as xr

import rollerrig as rr
from rollerrig.config import Case, ConfigError, load_case
from rollerrig.study.checkpoint import NAME


@pytest.fixture(scope="module")
def wheelset() -> Case:
    return load_case("wheelset_rollers")


def stop_after(lines: int, folder: Path) -> Callable[[float, str], None]:
    """Ctrl-C as soon as so many jobs are kept."""

    def progress(_fraction: float, _text: str) -> None:
        kept = folder / NAME
        if kept.exists() and kept.read_bytes().count(b"\n") > lines:
            raise KeyboardInterrupt

    return progress


def test_limit_cycles_go_on(wheelset: Case, tmp_path: Path) -> None:
    speeds = [100.0, 200.0]
    whole = rr.limit_cycle(wheelset, speeds, longest=1.6)
    cut = rr.limit_cycle(wheelset, speeds, longest=1.6, folder=tmp_path, progress=stop_after(2, tmp_path))
    assert cut.attrs["limit_cycles_interrupted"]
    assert cut.sizes["cycle_point"] == 2
    assert rr.limit_cycle(wheelset, speeds, longest=1.6, folder=tmp_path).identical(whole)
    with pytest.raises(ConfigError, match=r"settings\.longest: 1\.6 there, 2\.4 now"):
        rr.limit_cycle(wheelset, speeds, longest=2.4, folder=tmp_path)


@pytest.mark.slow
def test_critical_speeds_go_on(wheelset: Case, tmp_path: Path) -> None:
    def found(**options: object) -> xr.Dataset:
        methods = ("linear", "continuation")
        return rr.critical_speed(wheelset, methods=methods, speeds_kmh=[100, 200], **options)  # type: ignore[arg-type]

    with pytest.raises(KeyboardInterrupt):
        found(folder=tmp_path, progress=stop_after(2, tmp_path))
    kept = (tmp_path / NAME).read_bytes()
    assert kept.count(b"\n") == 3
    assert found(folder=tmp_path).identical(found())
    assert (tmp_path / NAME).read_bytes().startswith(kept)  # what was kept is not computed again
