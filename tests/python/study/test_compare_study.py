"""`rollerrig compare`: one vehicle on several supports; files, keys, messages, and the sums of its tables."""

from __future__ import annotations

import json
import math
from functools import partial
from pathlib import Path

import pytest

from called import called
from reported import unexplained, unreported
from rollerrig.analysis.critical_speed import EFFECTS, TRACK, LinearCriticalSpeed, effect_split
from rollerrig.analysis.hunting import HuntingSettings
from rollerrig.analysis.mode_table import Crossing
from rollerrig.config import ConfigError, Rig, Track, load_case, load_support
from rollerrig.study.assessment import Interval, change_in_words
from rollerrig.study.compare import CompareStudy, compared_cases
from rollerrig.study.critical_speeds import radius_table

BOGIE = "leading_bogie"


def run(*arguments: str):
    return called("compare", *arguments)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("compare")
    options = [
        "--cut",
        BOGIE,
        "--speeds-kmh",
        "140:260:60",
        "--duration",
        "1",
        "--radii-m",
        "0.725,2",
        "--processes",
        "1",
    ]
    with pytest.MonkeyPatch.context() as patch:  # critical speeds by disturbance between two of the speeds
        patch.setattr("rollerrig.study.compare.CompareStudy", partial(CompareStudy, bracket_kmh=60.1))
        result = run("manchester_vehicle_1", *options, "--out", str(out))
    assert result.exit_code == 0, result.output
    return out


@pytest.fixture(scope="module")
def numbers(folder) -> dict:
    return json.loads((folder / "summary.json").read_text())


@pytest.mark.slow
def test_everything_is_written(folder) -> None:
    names = {path.name for path in folder.iterdir()}
    tables = {"modes.csv", "runs.csv", "wheels.csv", "critical_speeds.csv", "roller_effects.csv"}
    assert {
        "report.html",
        "summary.json",
        "timing.json",
        "rollerrig.json",
        "figures",
        *tables,
    } == names
    for kind in ("svg", "png"):
        drawn = {path.stem for path in (folder / "figures").glob(f"*.{kind}")}
        assert drawn == {"modes", "hunting", "amplitude"}
    page = (folder / "report.html").read_text()
    assert "http://" not in page.replace("http://www.w3.org", "")
    assert page.count("<figure") == 3


@pytest.mark.slow
def test_every_number_is_registered_and_every_registered_quantity_reported(numbers) -> None:
    assert unexplained(CompareStudy.quantities, numbers) == []
    assert unreported(CompareStudy.quantities, numbers) == ["roller_effects"]  # null where it is not computed


@pytest.mark.slow
def test_tables_hold_what_the_summary_says(folder, numbers) -> None:
    rows = [line.split(",") for line in (folder / "wheels.csv").read_text().splitlines()]
    for row in rows[1:]:
        found = dict(zip(rows[0], row, strict=True))
        own = numbers["supports"][found["on"]]["wheels"][found["wheel"]]
        assert {key: float(found[key]) for key in own} == pytest.approx(own, rel=1e-8)
    assert len(rows) == 1 + sum(len(one["wheels"]) for one in numbers["supports"].values())
    header, *runs = (folder / "runs.csv").read_text().splitlines()
    assert header.startswith("on,speed_kmh,amplitude_mm")
    assert len(runs) == sum(len(one["by_disturbance"]["runs"]) for one in numbers["supports"].values())


@pytest.mark.slow
def test_rollers_come_below_the_track_and_the_smaller_the_lower(numbers) -> None:
    speeds = numbers["critical_speed_over_radius_kmh"]
    for part in (BOGIE, "vehicle"):
        assert speeds[part]["0.725"] < speeds[part]["2"] < speeds[part]["track"]
    assert numbers["supports"]["rig"]["linear_critical_speed_kmh"] == pytest.approx(speeds[BOGIE]["0.725"], abs=1e-3)
    # The bogie with its car body held, within a few per cent of the whole vehicle.
    for radius in ("0.725", "2", "track"):
        assert speeds[BOGIE][radius] == pytest.approx(speeds["vehicle"][radius], rel=0.02)


@pytest.mark.slow
def test_the_split_adds_up_and_its_ends_are_rig_and_track(numbers) -> None:
    causes = numbers["roller_effects"]
    loss = causes["track_kmh"] - causes["rig_kmh"]
    off, alone = (sum(causes[key].values()) for key in ("gain_switched_off_kmh", "loss_alone_kmh"))
    assert off + causes["interaction_switched_off_kmh"] == pytest.approx(loss, abs=1e-9)
    assert alone + causes["interaction_alone_kmh"] == pytest.approx(loss, abs=1e-9)
    assert causes["track_kmh"] == pytest.approx(numbers["supports"]["track"]["linear_critical_speed_kmh"], abs=1e-3)
    assert causes["rig_kmh"] == pytest.approx(numbers["supports"]["rig"]["linear_critical_speed_kmh"], abs=1e-3)


@pytest.mark.slow
def test_static_loads_do_not_depend_on_the_support(numbers) -> None:
    wheels = (numbers["supports"][name]["wheels"].values() for name in ("rig", "track"))
    rig, track = ([wheel["vertical_force_kn"] for wheel in one] for one in wheels)
    assert rig == pytest.approx(
        track, rel=1e-3
    )  # rollers press the wheels in deeper, which lowers the held bogie a little


def test_rig_and_track_of_a_case_keep_its_head() -> None:
    cases = compared_cases("contact_benchmark_rollers", ["rig", "track"])
    own = load_case("contact_benchmark_rollers").support.data
    assert cases["rig"].support.data == own
    track = cases["track"].support.data
    assert isinstance(track, Track)
    assert (track.profile, track.gauge) == (own.profile, own.gauge)
    assert cases["rig"].contact.material == load_case("contact_benchmark_rollers").contact.material


def test_a_support_may_be_named_or_a_file(tmp_path) -> None:
    from rollerrig.catalog import catalog_text

    file = tmp_path / "small.toml"
    file.write_text(catalog_text("full_scale_rig").replace("725 mm", "500 mm"))
    cases = compared_cases("manchester_vehicle_1", ["en_60e1_track", str(file)], BOGIE)
    assert list(cases) == ["en_60e1_track", "small"]
    assert cases["en_60e1_track"].support.data == load_support("en_60e1_track")
    rig = cases["small"].support.data
    assert isinstance(rig, Rig)
    assert rig.roller_radius == 0.5


def scan(kmh: float) -> LinearCriticalSpeed:
    return LinearCriticalSpeed(Crossing(kmh / 3.6, 5.0, "hunting"))


def test_a_table_over_the_radius_has_changes_against_the_track() -> None:
    found = {
        ("bogie", 0.5): scan(200),
        ("bogie", 1.0): scan(190),
        ("bogie", TRACK): scan(300),
        ("wheelset", 0.5): scan(90),
    }
    rows = radius_table(found, "").rows
    assert rows[0] == ["track", "300.0", "", "not computed", ""]
    assert rows[2] == ["rollers of 0.5 m", "200.0", "-33.3 %", "90.0", ""]


def test_a_loss_of_independent_effects_leaves_no_interaction() -> None:
    cost = dict(zip(EFFECTS, (-5.0, 30.0, 10.0, 1.0), strict=True))
    every = frozenset(EFFECTS)
    sets = [every, frozenset(), *(every - {e} for e in EFFECTS), *(frozenset({e}) for e in EFFECTS)]
    split = effect_split({on: scan(300.0 - sum(cost[e] for e in on)) for on in sets})
    assert split["track_kmh"] - split["rig_kmh"] == pytest.approx(36.0)
    for name, single in (("switched_off", "gain_switched_off_kmh"), ("alone", "loss_alone_kmh")):
        assert split[single] == pytest.approx(cost)
        assert split[f"interaction_{name}_kmh"] == pytest.approx(0.0, abs=1e-9)
    assert math.isnan(effect_split({})["track_kmh"])


def test_a_loss_is_told_only_once_rig_and_track_are_computed() -> None:
    study = CompareStudy(compared_cases("manchester_vehicle_1", ["rig", "track"], "leading_wheelset"), (60.0,))
    results = study.collect({"linear critical speed rig": scan(200.0)})
    assert results is not None
    told = []
    for on in (frozenset(EFFECTS), frozenset[str]()):
        results.effects[on] = scan(200.0)
        told.append("on track" in study.summary(results, {})[-1] or "no loss" in study.summary(results, {})[-1])
    assert told == [False, True]


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_done(tmp_path) -> None:
    cases = compared_cases("manchester_vehicle_1", ["rig", "track"], "leading_wheelset")
    study = CompareStudy(cases, (60.0, 100.0), (), (0.725,), hunting=HuntingSettings(duration=1.0))

    def press(fraction: float, _text: str) -> None:
        if fraction > 0.1:
            raise KeyboardInterrupt

    outcome = study.run(folder=tmp_path, progress=press)
    assert outcome is not None
    assert outcome.interrupted
    assert outcome.results.modes
    assert not outcome.results.by_disturbance
    assert outcome.write(tmp_path)[-1].name == "report.html"
    assert json.loads((tmp_path / "summary.json").read_text())["interrupted"] is True
    kept = study.run(folder=tmp_path, progress=press)
    assert kept is not None
    done = outcome.results
    parts = (done.modes, done.states, done.linear, done.effects, done.over_radius)
    assert kept.taken_over == sum(map(len, parts))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["manchester"], "manchester: no such file; needed: a vehicle or a case"),
        (["manchester"], "did you mean 'manchester_vehicle_1'?"),
        (["s1002"], "s1002: a profile, not a vehicle"),
        (["manchester_vehicle_1", "--on", "rig,trak"], "trak: no such file"),
        (["manchester_vehicle_1", "--on", "rig,rig"], "name each support once, like rig,track"),
        (["manchester_vehicle_1", "--on", ""], "name each support once, like rig,track"),
        (["manchester_vehicle_1", "--speeds-kmh", "300,200,100"], "speeds must be positive and rise"),
        (["manchester_vehicle_1", "--speeds-kmh", "0:100:20"], "speeds must be positive and rise"),
        (["manchester_vehicle_1", "--radii-m", "0,1"], "--radii-m: '0,1': numbers must lie between 0.05 and 1e+06"),
        (["manchester_vehicle_1", "--cut", "trailer"], "vehicle.cut: 'trailer'"),
    ],
)
def test_wrong_input_is_told_before_anything_runs(arguments: list[str], message: str, tmp_path) -> None:
    result = run(*arguments, "--out", str(tmp_path / "out"))
    assert result.exit_code == 2
    told = " ".join(result.output.replace("│", " ").split())
    assert message in told
    assert not (tmp_path / "out").exists()


def test_an_unknown_part_is_a_config_error() -> None:
    with pytest.raises(ConfigError, match="leading_bogie"):
        compared_cases("manchester_vehicle_1", ["rig"], "bogie")


@pytest.mark.parametrize(
    ("ratio", "words"),
    [
        (Interval(0.816, 0.816), "18.4 % lower"),
        (Interval(0.777, 0.8), "20.0 to 22.3 % lower"),
        (Interval(1.02, 1.05), "2.0 to 5.0 % higher"),
        (Interval(0.99, 1.005), "between 1.0 % lower and 0.5 % higher"),
    ],
)
def test_a_change_between_brackets_is_told_with_both_ends(ratio: Interval, words: str) -> None:
    assert change_in_words(ratio) == words
