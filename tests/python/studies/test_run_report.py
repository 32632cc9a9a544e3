"""The report of a run: what a reader needs stands in it."""

from __future__ import annotations

from html import unescape

from rollerrig import load_case, simulate
from rollerrig.results import summarise
from rollerrig.studies.run import COUNTERS, run_report


def test_every_counter_of_the_contact_model_is_explained() -> None:
    run = simulate(load_case("wheelset_rollers").with_changes({"time.duration": "20 ms"}))
    summary = summarise(run)
    assert set(COUNTERS) == set(summary["contact"])
    text = unescape(run_report(run, summary))
    assert all(meaning in text for meaning in COUNTERS.values())
    assert "10^" not in text
