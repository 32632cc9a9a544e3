"""Short runs, their pages, and a browser, each made once."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

import rollerrig as rr
from browser import Opened, chromium


@pytest.fixture(scope="package")
def on_rig() -> xr.Dataset:
    return rr.simulate(rr.load_case("bogie_rollers_constant").with_changes({"time.duration": "0.4 s"}))


@pytest.fixture(scope="package")
def on_track() -> xr.Dataset:
    return rr.simulate(rr.load_case("bogie_track").with_changes({"time.duration": "0.3 s"}))


@pytest.fixture(scope="package")
def in_curve() -> xr.Dataset:
    return rr.simulate(rr.load_case("vehicle_curve").with_changes({"time.duration": "4 s"}))


@pytest.fixture(scope="package")
def both(tmp_path_factory: pytest.TempPathFactory, on_rig: xr.Dataset, on_track: xr.Dataset) -> Path:
    return rr.view(on_rig, on_track, path=tmp_path_factory.mktemp("pages") / "both.html")


@pytest.fixture(scope="package")
def browser() -> Iterator[Any]:
    with chromium() as found:
        yield found


@pytest.fixture(scope="package")
def opened(browser: Any, both: Path) -> Iterator[Opened]:
    page = Opened(browser, both)
    yield page
    page.close()
