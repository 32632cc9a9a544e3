"""`rollerrig tune`: the front on invented numbers and on a loop whose errors are monotone, margins kept, what is refused."""

import math
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rollerrig as rr
from rollerrig.study.checkpoint import NAME
from rollerrig.study.ensemble import estimate
from rollerrig.study.tune import SHIPPED, TuneStudy, compromise, margins_of, not_dominated, outcome

GAIN = "rig_control.feedback.bandwidth"


@cache
def tuned(**options: Any) -> Any:
    """Two seconds of braking: 0.5 s of rolling, then the wheels slide."""
    return rr.tune("adhesion_brake", {GAIN: ("0.2 Hz", 12.0)}, duration=2.0, draws=2, candidates=6, **options)


def test_a_point_that_another_surpasses_is_not_on_the_front() -> None:
    errors = np.array([[1.0, 4.0], [2.0, 2.0], [2.0, 3.0], [4.0, 1.0], [4.0, 1.0], [5.0, 5.0], [1.0, 4.5]])
    assert not_dominated(errors) == [0, 1, 3, 4]  # equal ones do not surpass each other
    assert not_dominated(np.array([[3.0, 3.0]])) == [0]
    assert not_dominated(np.empty((0, 2))) == []


def test_the_compromise_is_nearest_to_the_least_of_both() -> None:
    assert compromise(np.array([[1.0, 100.0], [2.0, 2.0], [100.0, 1.0]])) == 1
    assert compromise(np.array([[2.0, 3.0]])) == 0


def test_a_verdict_needs_the_whole_interval() -> None:
    assert outcome(estimate([-0.2, -0.21, -0.19])) == "better"
    assert outcome(estimate([0.2, 0.21, 0.19])) == "worse"
    assert outcome(estimate([-0.2, 0.1, -0.05])) == outcome(estimate([-0.2])) == "not decided"


@pytest.mark.slow
def test_every_candidate_on_offer_keeps_the_margins_and_higher_gains_track_better() -> None:
    numbers = tuned().numbers
    points = {name: one for name, one in numbers["points"].items() if name != SHIPPED}
    refused = [one for one in points.values() if one["cause"] == "margins"]
    kept = [one for one in points.values() if not one["cause"]]
    assert refused
    assert kept
    assert len(refused) + len(kept) == len(points)
    assert all(one["gain_margin"] < 2.0 or one["phase_margin_deg"] < 45.0 for one in refused)
    assert all(one["tracking_rms"]["mean"] is None for one in refused)
    assert all(one["gain_margin"] >= 2.0 and one["phase_margin_deg"] >= 45.0 for one in kept)
    assert max(one["values"][GAIN] for one in kept) < min(one["values"][GAIN] for one in refused)
    rising = sorted(kept, key=lambda one: one["values"][GAIN])
    assert all(a["tracking_rms"]["mean"] > b["tracking_rms"]["mean"] for a, b in zip(rising, rising[1:], strict=False))
    assert all(a["ripple_nm"]["mean"] < b["ripple_nm"]["mean"] for a, b in zip(rising, rising[1:], strict=False))
    assert all(one["on_front"] for one in kept)  # monotone in one key: nothing surpasses anything
    assert numbers["points"][SHIPPED]["on_front"]


def test_the_margin_reported_is_the_gain_at_which_the_loop_is_unstable() -> None:
    """Twice the gains have half the margin: the plant does not change with them."""
    gains = {"rig_control.feedback.proportional": 2000.0, "rig_control.feedback.integral": 6000.0}
    case = rr.load_case("adhesion_brake").with_changes(gains)
    twice = case.with_changes({key: 2.0 * value for key, value in gains.items()})
    candidates = {"one": {"changes": {}}}
    once, doubled = (margins_of(one, candidates)["one"]["gain_margin"] for one in (case, twice))
    assert once == pytest.approx(2.0 * doubled, rel=1e-3)


@pytest.mark.slow
def test_the_files_say_where_the_numbers_come_from(tmp_path: Path) -> None:
    found = tuned()
    found.write(tmp_path / "out")
    text = (tmp_path / "out" / "tuned.toml").read_text(encoding="utf-8")
    chosen = found.numbers["points"][found.numbers["compromise"]]
    assert tomllib.loads(text)["base"] == "adhesion_brake"
    assert found.numbers["compromise"] in text.splitlines()[0]
    case = rr.load_case(tmp_path / "out" / "tuned.toml")
    assert case.rig_control.feedback.bandwidth == chosen["values"][GAIN]
    assert case.time.duration == rr.load_case("adhesion_brake").time.duration  # the test was shortened, not the case
    assert {one["outcome"] for one in found.numbers["changes"].values()} <= {"better", "worse", "not decided"}
    rows = (tmp_path / "out" / "candidates.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == 8
    assert (tmp_path / "out" / "figures" / "front.png").exists()


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_computed_and_the_same_command_goes_on(tmp_path: Path) -> None:
    """Within the second candidates, which follow from the first: they are the same again."""
    study = TuneStudy(rr.load_case("adhesion_brake"), {GAIN: (0.3, 3.0)}, 1.0, 2, 2, 2.0, 45.0, 1)

    def pressed(fraction: float, _text: str) -> None:
        if fraction >= 0.7:
            raise KeyboardInterrupt

    cut = study.run(folder=tmp_path / "cut", progress=pressed)
    assert cut is not None
    assert cut.interrupted
    cut.write(tmp_path / "cut")
    assert "Interrupted" in (tmp_path / "cut" / "report.html").read_text(encoding="utf-8")
    kept = (tmp_path / "cut" / NAME).read_bytes().count(b"\n") - 1  # less the first line
    again, whole = study.run(folder=tmp_path / "cut"), study.run()
    assert again is not None
    assert whole is not None
    assert again.taken_over == kept > 0
    for name, found in (("cut", again), ("whole", whole)):
        found.write(tmp_path / name)
    for name in ("summary.json", "candidates.csv", "tuned.toml", "report.html"):
        assert (tmp_path / "cut" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


@pytest.mark.parametrize(
    ("free", "said"),
    [
        (
            {"rig_control.motor.bandwidth": (1, 2)},
            "free: 'rig_control.motor.bandwidth'; allowed: keys of rig_control.feedback",
        ),
        ({"rig_control.feedback.bandwith": (1, 2)}, "free.rig_control.feedback.bandwith"),
        ({GAIN: 3.0}, f"free.{GAIN}: 3.0; needed: [least, most]"),
        ({GAIN: (3.0, 1.0)}, f"free.{GAIN}.most: 1.0; allowed: more than `least`, 3.0"),
        ({GAIN: ("1 kg", 3.0)}, f"free.{GAIN}.least"),
        ({"rig_control.feedback.kind": (1, 2)}, "free.rig_control.feedback.kind.key"),
        ({}, "needed: a key and its range"),
    ],
)
def test_bad_keys_and_ranges_are_refused_in_a_line(free: Any, said: str) -> None:
    with pytest.raises(rr.ConfigError) as refused:
        rr.tune("adhesion_brake", free)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value).strip()


def test_a_controller_without_a_linear_loop_is_refused() -> None:
    exact = rr.load_case("adhesion_brake").with_changes({"rig_control.estimator": {"kind": "exact"}})
    with pytest.raises(rr.ConfigError, match="no linear loop; needed for the margins"):
        rr.tune(exact)
    with pytest.raises(rr.ConfigError, match="a case on rollers with"):
        rr.tune("bogie_track")


def test_a_margin_beyond_reach_leaves_the_case_as_shipped() -> None:
    found = rr.tune("adhesion_brake", {GAIN: (1.0, 12.0)}, duration=1.0, draws=2, candidates=2, gain_margin=100.0)
    assert found.numbers["compromise"] == SHIPPED
    assert not found.numbers["changes"]
    assert "No candidate" in found.summary
    assert not math.isnan(found.numbers["points"][SHIPPED]["tracking_rms"]["mean"])
