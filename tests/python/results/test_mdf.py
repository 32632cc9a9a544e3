"""Logs in MDF4: channels of several rates, their units; what is none, and what is not installed."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from rollerrig.results.logs import log_quantity, read_log
from rollerrig.results.run_info import ResultsError


@pytest.fixture
def log_file(tmp_path: Path) -> Path:
    """A speed 100 times a second, a pressure 20 times, from 0.5 s on, and a group without a record."""
    asammdf = pytest.importorskip("asammdf")
    fast, slow = np.arange(0.0, 3.0, 0.01), np.arange(0.5, 2.51, 0.05)
    with asammdf.MDF(version="4.10") as file:
        file.append(asammdf.Signal(120.0 - 3.6 * fast, fast, name="train_speed", unit="km/h"))
        file.append(asammdf.Signal(1.0 + slow, slow, name="axle.cylinder_pressure", unit="bar"))
        file.append(asammdf.Signal(np.array([]), np.array([]), name="never_sampled", unit="V"))
        return Path(file.save(tmp_path / "stop.mf4"))


def test_channels_of_two_rates_are_columns_of_the_faster_one(log_file: Path) -> None:
    log = read_log(log_file)
    assert list(log.columns) == ["time", "train_speed", "axle.cylinder_pressure"]
    time = log_quantity(log, "time", {"s": 1.0})
    assert (time[0], time[-1]) == pytest.approx((0.5, 2.5))
    assert np.diff(time) == pytest.approx(0.01)
    assert log_quantity(log, "train_speed", {"m/s": 1.0}) == pytest.approx(120.0 / 3.6 - time)
    assert log_quantity(log, "axle.cylinder_pressure", {"Pa": 1.0}) == pytest.approx(1e5 * (1.0 + time))


def test_a_file_that_is_none_is_refused_in_a_line(tmp_path: Path) -> None:
    pytest.importorskip("asammdf")
    wrong = tmp_path / "wrong.mf4"
    wrong.write_bytes(b"MDF     4.10" + bytes(80))
    with pytest.raises(ResultsError, match=r"wrong\.mf4: ") as caught:
        read_log(wrong)
    assert "\n" not in str(caught.value)


def test_without_the_library_the_refusal_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "asammdf", None)
    (tmp_path / "stop.mf4").write_bytes(b"MDF     4.10")
    with pytest.raises(ResultsError, match=r'needs asammdf, .*: pip install "rollerrig\[mdf\]"'):
        read_log(tmp_path / "stop.mf4")
