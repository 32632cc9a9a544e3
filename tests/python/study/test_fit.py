"""Fits to logs: numbers recovered from synthetic measurements within their own intervals, and what is refused before a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

import rollerrig as rr
from called import called
from reported import unexplained
from rollerrig.analysis.equivalent_dead_time import predicted_dead_time
from rollerrig.analysis.signals import low_pass
from rollerrig.config.load.fit import WholeFit, load_fit
from rollerrig.config.read import Document, catalog_file, read_document
from rollerrig.results.logs import log_of, read_log, time_problem
from rollerrig.study.fit import FitStudy, records
from rollerrig.study.runs.fit import MODELS, Record, UnusableRunError, search

CREEPAGES = np.geomspace(0.004, 0.2, 13)
BINS = Path(__file__).parents[2] / "validation" / "data" / "eurosprinter_bins.csv"


def plan_of(name: str, **changes: Any) -> WholeFit:
    """A plan of the catalogue."""
    document = read_document("fit", name)
    return load_fit(Document({**document.raw, **changes}, document.file, document.folder))


def synthetic(whole: WholeFit, columns: Mapping[str, Any]) -> tuple[Record, list[np.ndarray]]:
    """The record of a log whose measured values are without noise those of the case at its start."""
    (record,) = records(whole, [log_of(columns, "log.csv")])
    exact = MODELS[record.kind].values(record, record.case)
    return record, exact


def trial(
    whole: WholeFit, record: Record, exact: Sequence[np.ndarray], seed: int, start: Sequence[float]
) -> dict[str, Any]:
    """Whether each number of one noisy log is within its own interval."""
    rng = np.random.default_rng(seed)
    noisy = [
        replace(channel, measured=values + channel.error * rng.normal(size=len(values)))
        for channel, values in zip(record.channels, exact, strict=True)
    ]
    found = search(whole, [replace(record, channels=tuple(noisy))], start).estimate
    ends = {one.name: found.intervals[one.name] for one in whole.free}
    return {one.name: ends[one.name][0] <= one.start <= ends[one.name][1] for one in whole.free}


def inside(whole: WholeFit, record: Record, exact: Sequence[np.ndarray], count: int) -> dict[str, int]:
    """How often each number is within its own interval; each search begins a quarter above the truth."""
    start = [min(1.25 * one.start, one.most) for one in whole.free]
    trials = [trial(whole, record, exact, seed, start) for seed in range(count)]
    return {name: sum(one[name] for one in trials) for name in trials[0]}


# -------------------------------------------------------------------------------------------------- adhesion from a curve


def creep_log(error: float = 0.006) -> tuple[WholeFit, Record, list[np.ndarray]]:
    whole = plan_of("creep_curve")
    zeros, errors = np.zeros(len(CREEPAGES)), np.full(len(CREEPAGES), error)
    columns = {"creepage": CREEPAGES, "traction_coefficient": zeros, "traction_error": errors}
    return whole, *synthetic(whole, columns)


@pytest.mark.parametrize("count", [8, pytest.param(200, marks=pytest.mark.long)])
def test_an_adhesion_law_is_within_its_own_interval(count: int) -> None:
    """95 % are expected: 190 of 200 with a standard deviation of 3."""
    found = inside(*creep_log(), count)
    least = 6 if count == 8 else 180
    assert min(found.values()) >= least, found


def test_the_measured_points_of_a_locomotive_give_the_condition_of_the_catalogue() -> None:
    log = {"kind": "creep", "over": "creepage_mean", "unit": "%", "a_over_b": 0.5, "output": [
        {"of": "traction_coefficient", "column": "traction_mean", "error_column": "traction_se"}]}  # fmt: skip
    plan = {**read_document("fit", "creep_curve").raw, "log": [log]}
    found = rr.fit(plan, [BINS]).results.found.estimate
    for name, expected in {"mu_0": 0.358, "B": 0.56, "k_S": 0.38}.items():  # docs/measured.md
        assert found.values[name] == pytest.approx(expected, abs=0.5 * found.errors[name])
    assert found.undetermined == []
    free = [*plan["free"], {"key": "adhesion.rail.friction.A", "least": 0.0, "most": 1.0}]
    wider = rr.fit({**plan, "free": free}, [BINS])
    number = {one.name: k for k, one in enumerate(wider.results.found.estimate.free)}
    assert abs(wider.results.found.estimate.correlations[number["A"], number["B"]]) > 0.95
    assert "go together" in wider.summary


# ------------------------------------------------------------------------------------------------ suspension from hunting


def hunting_log() -> tuple[WholeFit, Record, list[np.ndarray]]:
    raw = read_document("fit", "hunting_decay").raw
    outputs = [{"of": "hunting_frequency", "error": "0.03 Hz"}, {"of": "hunting_damping", "error": 0.005}]
    whole = plan_of("hunting_decay", log=[{**raw["log"][0], "output": outputs}])
    speeds = np.array([100.0, 130.0, 160.0])
    columns = {"speed [km/h]": speeds, "hunting_frequency [Hz]": 0.0 * speeds, "hunting_damping": 0.0 * speeds}
    return whole, *synthetic(whole, columns)


@pytest.mark.slow
def test_a_suspension_is_found_from_its_hunting() -> None:
    whole, record, exact = hunting_log()
    channels = tuple(replace(c, measured=v) for c, v in zip(record.channels, exact, strict=True))
    found = search(whole, [replace(record, channels=channels)], [2e7, 6e6]).estimate
    for one in whole.free:
        assert found.values[one.name] == pytest.approx(one.start, rel=1e-3)
    assert all(0.0 < found.errors[one.name] < 0.3 * one.start for one in whole.free)


@pytest.mark.long
def test_a_suspension_is_within_its_own_interval() -> None:
    """95 % are expected: 190 of 200 with a standard deviation of 3."""
    assert min(inside(*hunting_log(), 200).values()) >= 180


# --------------------------------------------------------------------------------------- inertia and losses of the rollers

TIMES = np.arange(0.0, 420.0, 1.0)
DRIVING = np.where((TIMES > 10.0) & (TIMES < 60.0), 300.0, 0.0)


def coast_down(*without: str, torque: np.ndarray = DRIVING) -> tuple[WholeFit, Record, list[np.ndarray]]:
    raw = read_document("fit", "coast_down").raw
    output = {**raw["log"][0]["output"][0], "error": "0.1 km/h"}
    free = [one for one in raw["free"] if one.get("name") not in without]
    whole = plan_of("coast_down", free=free, log=[{**raw["log"][0], "output": [output]}])
    return whole, *synthetic(whole, {"time [s]": TIMES, "speed [km/h]": 0.0 * TIMES, "torque [N m]": torque})


@pytest.mark.slow
def test_inertia_and_losses_are_within_their_own_intervals() -> None:
    found = inside(*coast_down(), 1)
    assert sum(found.values()) >= 4, found


@pytest.mark.long
def test_inertia_and_losses_are_within_their_own_intervals_in_95_of_100_trials() -> None:
    """Of 40 trials 38 are expected, with a standard deviation of 1.4; a trial takes some 8 s."""
    assert min(inside(*coast_down(), 40).values()) >= 34


@pytest.mark.slow
def test_a_model_that_lacks_something_widens_the_intervals() -> None:
    """A shoe drags from 200 to 300 s, which the model does not know: the truth stays within."""
    whole, record, (exact,) = coast_down()
    dragging = (
        exact - 0.01 * np.clip(TIMES - 200.0, 0.0, 100.0) + np.random.default_rng(1).normal(0.0, 0.03, len(TIMES))
    )
    channel = replace(record.channels[0], measured=dragging)
    found = search(whole, [replace(record, channels=(channel,))], [one.start for one in whole.free]).estimate
    for one in whole.free:
        low, high = found.intervals[one.name]
        assert low <= one.start <= high, one.name
    assert abs(found.values["roller_inertia"] - 705.0) > 10.0, "by noise alone 1 kg m^2"
    assert found.scale > found.deviation > 1.0


@pytest.mark.slow
def test_without_a_known_torque_only_losses_over_inertia_are_determined() -> None:
    whole, record, exact = coast_down(torque=0.0 * TIMES)
    channels = tuple(replace(c, measured=v) for c, v in zip(record.channels, exact, strict=True))
    found = search(whole, [replace(record, channels=channels)], [one.start for one in whole.free]).estimate
    assert any("roller_inertia" in words for words in found.undetermined)


# ----------------------------------------------------------------------------------------------- dead time from a step


def step_log() -> tuple[WholeFit, Record, list[np.ndarray]]:
    raw = read_document("fit", "drive_lag").raw
    output = {**raw["log"][0]["output"][0], "error": "5 N m"}
    times = np.arange(0.0, 1.0, 2e-3)
    whole = plan_of("drive_lag", log=[{**raw["log"][0], "output": [output]}])
    return whole, *synthetic(whole, {"time [s]": times, "torque [N m]": 0.0 * times})


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, pytest.param(200, marks=pytest.mark.long)])
def test_a_drive_s_bandwidth_is_within_its_own_interval(count: int) -> None:
    """95 % are expected: 190 of 200 with a standard deviation of 3."""
    assert inside(*step_log(), count)["bandwidth"] >= (1 if count == 2 else 180)


@pytest.mark.slow
def test_the_equivalent_dead_time_of_a_rig_is_found_from_its_step() -> None:
    """Half a sample and the lag of the drive, 1/(2 pi f): (D17)."""
    whole, record, _ = step_log()
    true = record.case.with_changes({"rig_control.motor.bandwidth": "30 Hz"})
    (measured,) = MODELS["run"].values(record, true)
    noisy = measured + 5.0 * np.random.default_rng(1).normal(size=len(measured))
    found = search(whole, [replace(record, channels=(replace(record.channels[0], measured=noisy),))], [50.0]).estimate
    dead, low, high = (
        predicted_dead_time(true.with_changes({"rig_control.motor.bandwidth": bandwidth})).total
        for bandwidth in (found.values["bandwidth"], *found.intervals["bandwidth"][::-1])
    )
    assert low < 0.5e-3 + 1.0 / (2.0 * np.pi * 30.0) < high
    assert dead == pytest.approx(0.5e-3 + 1.0 / (2.0 * np.pi * found.values["bandwidth"]), rel=1e-3)


# -------------------------------------------------------------------------------------------------- dump valve from a curve

SINCE = np.arange(0.0, 2.6, 5e-3)
COMMANDS = np.select([SINCE < 0.6, SINCE < 0.8, SINCE < 1.6, SINCE < 1.7, SINCE < 2.1], [0.0, 1.0, 2.0, 1.0, 0.0], 2.0)


def valve_log(commands: np.ndarray = COMMANDS, **changes: object) -> tuple[WholeFit, Record, list[np.ndarray]]:
    """Noise of 0.02 bar; changes of the case, 'brake.air.' before them."""
    raw = read_document("fit", "dump_valve").raw
    output = {**raw["log"][0]["output"][0], "error": "0.02 bar"}
    given = {**raw["changes"], **{f"brake.air.{key}": value for key, value in changes.items()}}
    whole = plan_of("dump_valve", log=[{**raw["log"][0], "output": [output]}], changes=given)
    return whole, *synthetic(whole, {"time [s]": SINCE, "valve": commands, "cylinder_pressure [Pa]": 0.0 * SINCE})


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, pytest.param(200, marks=pytest.mark.long)])
def test_a_dump_valve_is_within_its_own_intervals(count: int) -> None:
    """95 % are expected: 190 of 200 with a standard deviation of 3."""
    found = inside(*valve_log(), count)
    assert set(found) == {"fill_conductance", "vent_conductance", "critical_ratio"}
    assert min(found.values()) >= (1 if count == 2 else 180), found


@pytest.mark.slow
def test_a_valve_s_data_sheet_returns_from_its_curve() -> None:
    """All three numbers others than those where the search begins; intervals of a few per cent."""
    sheet = {"fill_conductance": 1.7e-7, "vent_conductance": 3.1e-7, "critical_ratio": 0.42}
    whole, record, _ = valve_log()
    changes = {f"brake.air.{key}": value for key, value in sheet.items()}
    (exact,) = MODELS["brake_unit"].values(record, record.case.with_changes(changes))
    noisy = exact + 2e3 * np.random.default_rng(4).normal(size=len(exact))
    channels = (replace(record.channels[0], measured=noisy),)
    found = search(whole, [replace(record, channels=channels)], [one.start for one in whole.free]).estimate
    for name, value in sheet.items():
        low, high = found.intervals[name]
        assert low < value < high
        assert high - low < (0.3 if name == "critical_ratio" else 0.04) * value


@pytest.mark.slow
def test_dead_times_of_a_valve_are_those_that_leave_least() -> None:
    """Opening, closing, and opening again: the one hardly depends on the other."""
    exact = valve_log(opening_time="18 ms", closing_time="24 ms")[2][0]
    noisy = exact + 2e3 * np.random.default_rng(5).normal(size=len(exact))
    log = {"time [s]": SINCE, "valve": COMMANDS, "cylinder_pressure [Pa]": noisy}
    plan = {**read_document("fit", "dump_valve").raw}
    plan["free"] = plan["free"][:2]
    found = {"opening_time": 20, "closing_time": 20}
    for name in ("opening_time", "closing_time", "opening_time"):
        left = {}
        for ms in range(14, 29, 2):
            changes = {f"brake.air.{key}": f"{value} ms" for key, value in {**found, name: ms}.items()}
            left[ms] = rr.fit(plan, [log], changes=changes).numbers["outputs"]["cylinder_pressure"]["rms"]
        found[name] = min(left, key=lambda ms: left[ms])
    assert found == {"opening_time": 18, "closing_time": 24}
    assert left[18] == pytest.approx(2e3, rel=0.1)


def test_a_log_whose_valve_never_vents_is_told_that_it_says_nothing_about_venting() -> None:
    whole, record, _ = valve_log(np.minimum(COMMANDS, 1.0))
    with pytest.raises(rr.ConfigError) as error:
        search(whole, [record], [one.start for one in whole.free])
    assert len(error.value.problems) == 1
    assert "free[1].key: 'brake.air.vent_conductance'; allowed: keys that some output depends on" in str(error.value)


@pytest.mark.parametrize(
    ("change", "log", "expected"),
    [
        ({}, {"valve": COMMANDS + 1.0}, "log 1: valve: 3; allowed: 0 fill, 1 hold, 2 vent"),
        ({}, {"valve": None}, "log 1: log[0].valve: no column 'valve'; allowed: time, cylinder_pressure"),
        ({"case": "wheelset_rollers", "changes": {}, "free": [{"key": "contact.friction.mu_0", "least": 0.1, "most": 0.6}]},
         {}, "plan: case: 'wheelset_rollers'; needed: a case with [brake]"),
    ],
    ids=["command", "column", "no_brake"],
)  # fmt: skip
def test_a_valve_log_with_a_mistake_is_refused_in_a_line(
    change: dict[str, Any], log: dict[str, Any], expected: str
) -> None:
    columns = {"time [s]": SINCE, "valve": COMMANDS, "cylinder_pressure [Pa]": 0.0 * SINCE, **log}
    plan = {**read_document("fit", "dump_valve").raw, **change}
    assert expected in refused(plan, {name: values for name, values in columns.items() if values is not None})


# -------------------------------------------------------------------------------------------------------------- refusals

AT = np.arange(0.0, 1.0, 0.01)
GOOD = {"time [s]": AT, "y [m]": np.zeros(100)}


def run_plan(**output: Any) -> dict[str, Any]:
    return {
        "name": "plan",
        "case": "wheelset_rollers",
        "free": [{"key": "contact.friction.mu_0", "least": 0.1, "most": 0.6}],
        "log": [{"output": [{"of": "wheelset_1.lateral", "column": "y", **output}]}],
    }


def refused(plan: Mapping[str, Any], *logs: Any) -> str:
    with pytest.raises(rr.ConfigError) as error:
        rr.fit(plan, logs)
    assert len(error.value.problems) == 1, error.value
    return str(error.value)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"time [s]": np.r_[AT[:50], AT[50:] + 0.3]}, "time: 0.8 s follows 0.49 s: a gap, rows are 0.01 s apart"),
        ({"time [s]": np.r_[AT[:50], 0.49, AT[51:]]}, "log 1: time: 0.49 s follows 0.49 s: not later"),
        ({"time [s]": np.r_[AT[:50], 0.3, AT[51:]]}, "log 1: time: 0.3 s follows 0.49 s: not later"),
        ({"y [m]": np.r_[np.zeros(70), np.nan, np.zeros(29)]}, "log 1: y: nothing in row 71"),
        ({"y [m]": None, "yy [m]": AT}, "log 1: log[0].output[0].column: no column 'y'; allowed: time, yy; did you mean"),
        ({"y [m]": None, "y [km/h]": np.zeros(100)}, "log 1: y: 'km/h'; allowed: a unit of what is compared, such as m"),
        ({"y [m]": None, "y [blips]": np.zeros(100)}, "log 1: y: 'blips'"),
        ({"y [m]": None, "y": np.zeros(100)}, "log 1: y: has no unit; needed: a heading 'y [m]', or `log[0].output[0].unit`"),
        ({"time [s]": None, "time": AT}, "log 1: time: has no unit; needed: a heading 'time [s]', or `log[0].unit`"),
        ({"time [s]": AT[::-1]}, "log 1: time: 0.98 s follows 0.99 s: not later"),
        ({"time [s]": np.r_[AT[50:], AT[:50]]}, "log 1: time: 0 s follows 0.99 s: not later"),
        ({"y [m]": np.r_[np.zeros(70), np.inf, np.zeros(29)]}, "log 1: y: inf in row 71"),
        ({"time [s]": 1e-12 * AT}, "log 1: time: 9.9e-13 s in all; allowed: at least time.output_step of the case"),
        ({"y [m]": np.full(100, 1e300)}, "log 1: y: 1e+300 m; allowed: up to 1e+30 m"),
    ],
    ids=["gap", "repeated", "falling", "empty", "no_column", "unit", "unknown_unit", "no_unit", "no_unit_of_time", "all_falling",
         "begun_anew", "infinite", "in_no_time", "huge"],
)  # fmt: skip
def test_a_log_with_a_mistake_is_refused_in_a_line(change: dict[str, Any], expected: str) -> None:
    columns = {name: values for name, values in {**GOOD, **change}.items() if values is not None}
    assert expected in refused(run_plan(), columns)


def test_a_part_of_a_log_without_its_gap_is_taken() -> None:
    whole = load_fit(Document({**run_plan(), "log": [{**run_plan()["log"][0], "begin": 0.8}]}, "plan", Path()))
    gap = np.r_[AT[:50], AT[50:] + 0.3]
    (record,) = records(whole, [log_of({**GOOD, "time [s]": gap}, "log 1")])
    assert record.x[[0, -1]] == pytest.approx([0.0, 0.49])


@pytest.mark.parametrize(
    ("output", "expected"),
    [
        ({"of": "wheelset_1.latera"}, "plan: log[0].output[0].of: 'wheelset_1.latera'"),
        ({"unit": "N"}, "plan: log[0].output[0].unit: 'N'; allowed: a unit of what is compared, such as m"),
        ({"error": "1 N"}, "plan: log[0].output[0].error: '1 N'"),
        ({"error": "0 mm"}, "a positive standard deviation"),
        ({"low_pass": "400 Hz"}, "plan: log[0].output[0].low_pass: 400.0; a filter at 400 Hz needs an output_step"),
        ({"error": "1 mm", "error_column": "y"}, "allowed: one of `error` and `error_column`"),
    ],
    ids=["of", "unit", "error_unit", "zero", "filter", "both"],
)
def test_an_output_with_a_mistake_is_refused_in_a_line(output: dict[str, Any], expected: str) -> None:
    log = {"time [s]": AT, "y": AT} if "unit" in output else GOOD
    assert expected in refused(run_plan(**output), log)


def test_a_column_of_errors_has_a_unit_of_its_own() -> None:
    log, columns = run_plan(error_column="e"), {"time [s]": AT, "y [mm]": np.ones(100)}
    for heading, error in (("e [m]", 1e-5), ("e [um]", 10.0), ("e", 0.01)):  # without one it is that of y
        (record,) = records(
            load_fit(Document(log, "plan", Path())), [log_of({**columns, heading: error * np.ones(100)}, "log 1")]
        )
        assert record.channels[0].error == pytest.approx(1e-5)
    line = refused(log, {**columns, "e [km/h]": np.ones(100)})
    assert line == "log 1: e: 'km/h'; allowed: a unit of what is compared, such as m"


@pytest.mark.parametrize(
    ("free", "expected"),
    [
        ({"key": "contact.frition.mu_0"}, "plan: free[0].key: 'contact.frition.mu_0'"),
        ({"key": "contact.friction"}, "needed: the key of a number; its numbers are contact.friction.mu_0"),
        ({"most": 0.05}, "plan: free[0].most: 0.05; allowed: more than `least`, 0.1"),
        ({"least": 0.4}, "allowed: a range with the start in it, 0.3 1"),
        ({"least": "0.1 m"}, "plan: free[0].least: '0.1 m'"),
        ({"key": "support.losses.linear"}, "give the key a `start`"),
        ({"prior": {"kind": "lognormal", "median": 0.3, "deviation": 0.1}}, "plan: free[0].prior.kind: 'lognormal'"),
    ],
    ids=["key", "no_number", "most", "start", "unit", "absent", "prior"],
)
def test_a_free_key_with_a_mistake_is_refused_in_a_line(free: dict[str, Any], expected: str) -> None:
    plan = run_plan()
    assert expected in refused({**plan, "free": [{**plan["free"][0], **free}]}, GOOD)


def test_twenty_free_keys_and_ten_points_are_refused() -> None:
    keys = [
        f"vehicle.element.{name}.{d}.stiffness"
        for name in ("primary_1_left", "primary_1_right", "primary_2_left")
        for d in "xyz"
    ]
    keys += [
        f"vehicle.body.{name}.inertia.{k}" for name in ("wheelset_1", "front_frame", "car_body") for k in range(3)
    ] + ["gravity", "motion.speed"]
    free = [{"key": key, "name": f"n{k}", "least": 0.0, "most": 1.0} for k, key in enumerate(keys)]
    case = rr.load_case("bogie_rollers_constant")
    for one in free:
        value = float(plain_value(case, one["key"]))
        one |= {"least": 0.5 * value, "most": 1.5 * value}
    free[-1] |= {"least": "50 km/h", "most": "300 km/h"}
    ten = {name: values[:10] for name, values in GOOD.items()}
    line = refused({**run_plan(), "case": "bogie_rollers_constant", "free": free}, ten)
    assert (
        line
        == "plan: free: 20 keys without a prior; allowed: fewer free keys than points, 10; a `prior` counts as a point"
    )


def plain_value(case: rr.Case, key: str) -> Any:
    from rollerrig.config.load.plan import value_at

    found = value_at(case, {}, key, "case")
    assert isinstance(found, tuple)
    return found[1]


def test_a_free_key_that_changes_nothing_is_refused() -> None:
    plan = {**read_document("fit", "creep_curve").raw}
    plan["free"] = [*plan["free"], {"key": "vehicle.body.car_body.mass", "least": "40 t", "most": "60 t"}]
    columns = {
        "creepage": CREEPAGES,
        "traction_coefficient": 0.3 + 0.0 * CREEPAGES,
        "traction_error": 0.01 + 0.0 * CREEPAGES,
    }
    line = refused(plan, columns)
    assert line.startswith("plan: free[3].key: 'vehicle.body.car_body.mass'; allowed: keys that some output depends on")


def test_what_kept_a_free_key_from_running_is_said() -> None:
    """Of a gauge at which wheels miss the rollers."""
    whole = load_fit(Document(run_plan(), "plan", Path()))
    (record,) = records(whole, [log_of(GOOD, "log 1")])
    wide = replace(whole, free=(replace(whole.free[0], key="support.gauge"),))
    with pytest.raises(UnusableRunError, match=r"no run about support\.gauge = 0\.3 .*; the wheels miss"):
        search(wide, [record], [0.3])


def test_a_creepage_in_per_cent_without_its_unit_is_refused() -> None:
    columns = {
        "creepage": 100.0 * CREEPAGES,
        **{f"traction_{name}": 0.0 * CREEPAGES for name in ("coefficient", "error")},
    }
    allowed = "allowed: parts of the vehicle's speed, most of them from -1 to 1; is it in per cent?"
    line = refused({**read_document("fit", "creep_curve").raw}, columns)
    assert line == f"log 1: creepage: 2.82843 in the median; {allowed}"
    spinning = {
        **columns,
        "creepage": np.where(CREEPAGES > 0.1, 3.0, CREEPAGES),
        "traction_error": 0.01 + 0.0 * CREEPAGES,
    }
    (record,) = records(plan_of("creep_curve"), [log_of(spinning, "log 1")])
    assert record.x.max() == 3.0


def test_speeds_of_hunting_are_positive_in_any_order_and_may_repeat() -> None:
    plan = read_document("fit", "hunting_decay").raw
    whole = plan_of("hunting_decay")
    columns = {name: np.zeros(3) for name in ("hunting_frequency [Hz]", "hunting_damping")}
    (record,) = records(whole, [log_of({"speed [km/h]": [160.0, 100.0, 160.0], **columns}, "log 1")])
    frequency, damping = MODELS["modes"].values(record, record.case)
    assert frequency[0] == frequency[2] > frequency[1]
    assert damping[0] == damping[2] < damping[1]
    line = refused(plan, {"speed [km/h]": [160.0, 0.0, 120.0], **columns})
    assert line == "log 1: speed: 0 in row 2; allowed: more than 0 m/s"


def test_a_radius_of_rollers_in_place_of_the_rig_s_own_may_be_free() -> None:
    free = {"key": "support.roller_radius", "least": "0.5 m", "most": "1 m"}
    (found,) = load_fit(Document({**run_plan(), "free": [free]}, "plan", Path())).free
    assert (found.start, found.quantity.unit) == (0.725, "m")


def test_a_switched_torque_is_held_until_the_next_row() -> None:
    """A line between the rows in which it is switched would be 50 N m s more, or less."""
    raw = read_document("fit", "coast_down").raw
    log, times = raw["log"][0], np.arange(0.0, 4.0, 0.5)
    columns = {
        "time [s]": times,
        "speed [km/h]": 0.0 * times,
        "torque [kN m]": np.where((times > 0.9) & (times < 2.1), 0.2, 0.0),
    }
    tables = {}
    for between in ("line", "hold"):
        whole = plan_of("coast_down", log=[{**log, "input": [{**log["input"][0], "between": between}]}])
        (record,) = records(whole, [log_of(columns, "log 1")])
        tables[between] = np.transpose(record.case.motion.torque_table)
    assert np.interp([0.75, 1.25, 2.25, 2.75], *tables["line"]).tolist() == [100.0, 200.0, 100.0, 0.0]
    assert np.interp([0.75, 1.25, 2.25, 2.75], *tables["hold"]).tolist() == [0.0, 200.0, 200.0, 0.0]
    assert np.trapezoid(*tables["hold"][::-1]) == pytest.approx(300.0, abs=0.1)
    line = refused(
        {**raw}, {**{name: columns[name] for name in ("time [s]", "speed [km/h]")}, "torque": columns["torque [kN m]"]}
    )
    assert (
        line == "log 1: torque: has no unit; needed: a heading 'torque [UNIT]', or `log[0].input[0].unit` in the plan"
    )


def test_as_many_logs_as_tables_are_needed() -> None:
    assert "plan: log: 0 logs; needed: at least one log" in refused(run_plan())
    two = {**run_plan(), "log": [run_plan()["log"][0]] * 2}
    assert "plan: log: 1 logs; needed: as many logs as tables [[log]], 2" in refused(two, GOOD)


# ----------------------------------------------------------------------------------------------------------------- files


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["csv", "mat", "nc", "parquet"])
def test_a_run_is_read_again_as_a_log(tmp_path: Path, kind: str) -> None:
    run = rr.simulate(rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.05 s"}))
    path = tmp_path / f"run.{kind}"
    rr.save_run(run, path) if kind == "nc" else rr.export(run, path)
    log = read_log(path)
    name = "distance" if kind == "mat" else "wheelset_1.lateral"
    own = run["distance"] if kind == "mat" else run["lateral"].sel(body="wheelset_1")
    assert log.units[name] == "m"
    np.testing.assert_array_equal(log.columns[name], own.to_numpy())
    assert time_problem(log.columns["time"]) == ""


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_table_with_decimal_commas_is_read(tmp_path: Path, separator: str) -> None:
    text = "# from a rig\ntime [s];speed [km/h];note;\n0,0;1,5;on;\n0,1;2,5;1.2.2026;\n"
    for one in (text, text.replace("note;", "note")):  # cells that end in a separator, with a heading for each or not
        (tmp_path / "log.csv").write_text(one.replace(";", separator))
        log = read_log(tmp_path / "log.csv")
        assert log.columns["speed"].tolist() == [1.5, 2.5]
        assert log.units == {"time": "s", "speed": "km/h"}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("time,y\n0,1\n0.1,oops\n", "row 2, column 'y': 'oops' is no number"),
        ("a\nb\n", "no column of numbers"),
        ("", "log.csv: an empty file; needed: a heading and rows of numbers"),
        ("time,y\n0,0,1,5\n", "row 1 has 4 cells, the heading 2; decimal commas need ; or tabs between the cells"),
        ("time,y\n0,1\n1\n", "row 2 has 1 cells, the heading 2"),
        ("time;y\n0;1;2\n", "row 1 has 3 cells, the heading 2$"),
        ("time\ty\n0.0\t1.5\n0.1\t1,234\n", "a point in '0.0', a comma in '1,234'; allowed: one of them"),
        ("time;y\n0.0;1,234\n", "a point in '0.0', a comma in '1,234'; allowed: one of them"),
        ("time,y,y\n0,1,2\n", "column 'y' is there twice; allowed: each heading once"),
        ("time,y [m],y [mm]\n0,1,2\n", "column 'y' is there twice; allowed: each heading once"),
    ],
)
def test_a_file_without_numbers_is_refused_in_a_line(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path / "log.csv").write_text(text)
    with pytest.raises(rr.ResultsError, match=expected) as error:
        read_log(tmp_path / "log.csv")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("log", "line"),
    [
        ("none.csv", "rollerrig: none.csv: no such file"),
        ("log.txt", "rollerrig: log.txt: a file of measured signals ends in .csv, .mat, .mf4, .nc, .parquet, .npz"),
        ("log.csv", "rollerrig: log.csv: log[0].over: no column 'creepage'; allowed: time, y"),
    ],
)
def test_the_command_refuses_a_log_in_a_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, log: str, line: str
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("log.csv", "log.txt"):
        Path(name).write_text("time,y\n0,1\n0.1,2\n")
    result = called("fit", "creep_curve", log, "--out", "out")
    assert (result.exit_code, result.output.strip()) == (2, line)
    assert not Path("out").exists()


@pytest.mark.slow
def test_the_fitted_case_says_where_its_numbers_come_from(tmp_path: Path) -> None:
    _, record, exact = creep_log()
    log = {"creepage": CREEPAGES, "traction_coefficient": exact[0], "traction_error": record.channels[0].error}
    plan = {**read_document("fit", "creep_curve").raw, "held_back": 0.2, "starts": 2}
    outcome = rr.fit(plan, [log])
    written = {path.name for path in outcome.write(tmp_path)}
    assert {"fitted.toml", "estimates.csv", "log_1.csv", "summary.json", "report.html"} <= written
    text = (tmp_path / "fitted.toml").read_text()
    first, second, *_ = text.splitlines()
    assert first == "# Fitted by `rollerrig fit`, plan creep_curve, to log 1; all else is as in the plan."
    assert second.startswith("# adhesion.rail.friction.mu_0 = 0.35, 95 % from")
    case = rr.load_case(tmp_path / "fitted.toml")
    assert case.adhesion.rail.k_S == pytest.approx(0.3, rel=1e-4)
    numbers = outcome.numbers
    assert (numbers["points"], numbers["points_held_back"]) == (10, 3)
    assert numbers["searches_at_the_same_end"] == 2
    assert unexplained(FitStudy.quantities, numbers) == []
    assert numbers["outputs"]["traction_coefficient"]["rms_held_back"] < 1e-5


def test_several_logs_at_different_speeds_are_fitted_at_once() -> None:
    """Friction falls with the slip velocity: two speeds tell its fall better than one."""
    raw = read_document("fit", "creep_curve").raw
    tables = [{**raw["log"][0], "changes": {"motion.speed": f"{speed} km/h"}} for speed in (36, 108)]
    whole = plan_of("creep_curve", log=tables)
    columns = {"creepage": CREEPAGES, "traction_coefficient": 0.0 * CREEPAGES, "traction_error": 0.0 * CREEPAGES + 0.01}
    logs = [
        {**columns, "traction_coefficient": MODELS["creep"].values(record, record.case)[0]}
        for record in records(whole, [log_of(columns, "log")] * 2)
    ]
    both, one = (rr.fit({**raw, "log": tables[:n]}, logs[:n]) for n in (2, 1))
    assert both.numbers["numbers"]["B"]["value"] == pytest.approx(0.5, rel=1e-4)
    assert both.numbers["numbers"]["B"]["standard_error"] < 0.75 * one.numbers["numbers"]["B"]["standard_error"]
    assert list(both.numbers["outputs"]) == ["traction_coefficient, log 1", "traction_coefficient, log 2"]
    assert len(both.study._fitted_cases(both.results)) == 2  # type: ignore[attr-defined]


@pytest.mark.slow
def test_a_filtered_sensor_with_an_unknown_zero_gives_the_same_stiffness() -> None:
    run = rr.simulate(rr.load_case("wheelset_rollers").with_changes({"time.duration": "1 s"}))
    exact = run["lateral"].sel(body="wheelset_1")
    seen = low_pass(exact, 15.0).to_numpy()[:-5] + 2e-3
    key, log = "vehicle.element.primary_*.y.stiffness", {"time [s]": run["time"].to_numpy()[:-5], "y [mm]": 1e3 * seen}
    free = [{"key": key, "least": "2 MN/m", "most": "6 MN/m", "start": "5 MN/m"}]
    right, wrong = (
        rr.fit({**run_plan(error="0.01 mm", any_offset=True, **more), "free": free}, [log]).results.found.estimate
        for more in ({"low_pass": "15 Hz"}, {})
    )
    assert right.values["stiffness"] == pytest.approx(3.884e6, rel=5e-3)
    assert abs(wrong.values["stiffness"] / 3.884e6 - 1.0) > 0.02
    assert wrong.deviation > 10.0 * right.deviation


@pytest.mark.slow
def test_errors_that_are_not_given_are_found() -> None:
    """Two outputs of different size and noise: each gets its own standard deviation."""
    times = np.arange(0.0, 1.0, 0.01)
    run = rr.simulate(rr.load_case("wheelset_rollers").with_changes({"time.duration": "1 s"}))
    rng = np.random.default_rng(2)
    log = {"time [s]": times}
    outputs = []
    for name, unit, noise in (("lateral", "m", 1e-5), ("yaw", "rad", 1e-6)):
        exact = np.interp(times, run["time"], run[name].sel(body="wheelset_1"))
        log[f"{name} [{unit}]"] = exact + noise * rng.normal(size=len(times))
        outputs.append({"of": f"wheelset_1.{name}", "column": name})
    free = [{"key": "vehicle.element.primary_*.y.stiffness", "least": "2 MN/m", "most": "6 MN/m"}]
    found = rr.fit({**run_plan(), "free": free, "log": [{"output": outputs}]}, [log])
    for name, noise in (("lateral", 1e-5), ("yaw", 1e-6)):
        assert found.numbers["outputs"][f"wheelset_1.{name}"]["error"] == pytest.approx(noise, rel=0.25)
    low, high = found.results.found.estimate.intervals["stiffness"]
    assert low < 3.884e6 < high


def test_every_plan_of_the_catalogue_is_one() -> None:
    for path in sorted(catalog_file("fit", "creep_curve").parent.glob("*.toml")):
        assert load_fit(path.stem).plan.name == path.stem
        assert tomli_w.dumps(read_document("fit", path.stem).raw)
