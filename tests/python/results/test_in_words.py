"""Results print well: what, how long, how it ended, its energy residual; of analyses what they are over and hold."""

from __future__ import annotations

from pathlib import Path

import pytest
import xarray as xr

import rollerrig as rr


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return rr.simulate(
        rr.load_case("bogie_rollers_constant").with_changes({"time.duration": "0.2 s", "time.output_step": "5 ms"})
    )


def test_a_run_says_what_how_long_how_it_ended_and_its_residual(run: xr.Dataset, tmp_path: Path) -> None:
    rows = dict(rr.summary(run).rows)
    assert rows["what"] == "leading bogie on rollers of 725 mm: moving bodies 3, wheels 4"
    assert rows["time"] == "0.2 s, 41 samples, one every 5 ms"
    assert rows["speed"] == "150 km/h"
    assert rows["ended"] == f"ok: {run.attrs['status_message']}"
    assert "of the" in rows["energy"]
    text = repr(rr.summary(run))
    assert text.startswith("Run of bogie_rollers_constant: ")
    assert max(map(len, text.splitlines())) < 130
    assert len(text.splitlines()) == 1 + len(rows)
    assert rr.summary(rr.save_run(run, tmp_path / "run.nc")) == rr.summary(run)


def test_what_ended_early_and_warnings_are_said(run: xr.Dataset) -> None:
    early = run.assign_attrs(status="not_finite", status_message="It broke <here>.", warnings="one\ntwo")
    summary = rr.summary(early)
    assert ("ended", "not_finite: It broke <here>.") in summary.rows
    assert [words for what, words in summary.rows if what == "warning"] == ["one", "two"]
    assert "It broke &lt;here&gt;." in summary._repr_html_()


def test_a_run_without_samples_is_summed_up(run: xr.Dataset) -> None:
    assert dict(rr.summary(run.isel(time=slice(0, 0))).rows)["time"] == "0.2 s, 0 samples"


def test_what_is_no_run_is_refused() -> None:
    with pytest.raises(rr.ResultsError, match="no run"):
        rr.summary(rr.stability("wheelset_rollers", [100.0, 150.0]))
    with pytest.raises(rr.ResultsError, match="do not say which case"):
        rr.summary(xr.Dataset({"a": ("x", [1.0, 2.0])}))
