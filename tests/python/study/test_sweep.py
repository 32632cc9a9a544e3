"""Sweeps: which cases, what is kept of them, what goes on after an end, and what is said about a plan that is wrong."""

from __future__ import annotations

import json
import math
import os
import re
import signal
import subprocess
import sys
import time
import tracemalloc
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy import stats

import rollerrig as rr
from called import called
from reported import unexplained
from rollerrig.config import Case, ConfigError, WholePlan, load_case, load_plan
from rollerrig.config.schema.plan import CriticalSpeedMeasure
from rollerrig.results import load_run
from rollerrig.study import measures
from rollerrig.study.checkpoint import NAME
from rollerrig.study.report import Table
from rollerrig.study.runs.adhesion import track_case
from rollerrig.study.runs.sweep import FAILED, Axis, Points, quantile, sobol_indices, statistics
from rollerrig.study.runs.wsp import StopRecord, stop_record
from rollerrig.study.sweep import SweepStudy, sweep_rows, sweep_study

PLAN = """
name = "small"
case = "wheelset_rollers"
[design]
kind = "grid"
[[vary]]
key = "support.roller_radius"
values = ["500 mm", 1.0]
[[vary]]
key = "vehicle.element.primary_*.x.stiffness"
name = "primary"
least = "10 MN/m"
most = "30 MN/m"
count = 3
[[measure]]
kind = "critical_speed"
"""


def plan_of(tmp_path: Path, text: str = PLAN) -> WholePlan:
    (tmp_path / "plan.toml").write_text(text)
    return load_plan(tmp_path / "plan.toml")


def speed_and_friction(case: Case) -> dict[str, float]:
    """A measure that costs nothing."""
    if case.motion.speed > 30.0:
        raise ValueError("too fast")
    return {"product": case.motion.speed * case.contact.friction.mu_0}  # type: ignore[union-attr]


VARY: dict[str, Any] = {"motion.speed": ["36 km/h", "72 km/h", "144 km/h"], "contact.friction.mu_0": [0.1, 0.2]}


# ------------------------------------------------------------------------------------------------------------ cases


def test_a_grid_has_all_combinations_in_si(tmp_path: Path) -> None:
    points = Points(plan_of(tmp_path))
    assert len(points) == 6
    assert points.columns == [[0.5] * 3 + [1.0] * 3, [1e7, 2e7, 3e7] * 2]
    assert list(points.changes())[4] == {"support.roller_radius": 1.0, "vehicle.element.primary_*.x.stiffness": 2e7}
    assert [axis.unit for axis in points.axes] == ["m", "N/m"]


@pytest.mark.parametrize("kind", ["random", "latin_hypercube", "sobol", "saltelli"])
def test_samples_are_those_of_the_seed_and_lie_in_their_distributions(kind: str) -> None:
    case = load_case("wheelset_rollers")
    vary = {
        "support.roller_radius": {"distribution": {"kind": "normal", "mean": "725 mm", "deviation": "5 mm"}},
        "motion.speed": {"least": "30 km/h", "most": "300 km/h", "scale": "logarithmic"},
        "contact.friction.mu_0": {"distribution": {"kind": "triangular", "mode": 0.3}, "least": 0.1, "most": 0.4},
    }

    def columns(seed: int) -> list[np.ndarray]:
        study = sweep_study(case, vary, "stability", {"kind": kind, "samples": 512, "seed": seed})
        return [np.array(column) for column in study.points.columns]

    first, again, other = columns(1), columns(1), columns(2)
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))
    assert not np.array_equal(first[0], other[0])
    assert len(first[0]) == (512 * 5 if kind == "saltelli" else 512)
    speed = stats.loguniform(30 / 3.6, 300 / 3.6)
    laws = (stats.norm(0.725, 0.005), speed, stats.triang(2 / 3, 0.1, 0.3))
    for column, law in zip(first, laws, strict=True):
        assert stats.kstest(column[:: 5 if kind == "saltelli" else 1], law.cdf).statistic < 1.6 / math.sqrt(512)  # 1 %


def test_a_list_goes_through_its_values_together() -> None:
    study = sweep_study(
        load_case("wheelset_rollers"), {**VARY, "contact.friction.mu_0": [0.1, 0.2, 0.3]}, "run", "list"
    )
    assert study.points.columns == [[10.0, 20.0, 40.0], [0.1, 0.2, 0.3]]


# ------------------------------------------------------------------------------------------------------ what is found


class _Counted(dict[str, Any]):
    """Results of jobs that count how many of them are looked at."""

    looks = 0

    def values(self) -> Any:
        """Themselves, to be iterated."""
        return _CountedValues(self)


class _CountedValues:
    def __init__(self, owner: _Counted) -> None:
        self._owner = owner

    def _each(self, keys: Iterable[str]) -> Iterator[Any]:
        for key in keys:
            self._owner.looks += 1
            yield self._owner[key]

    def __iter__(self) -> Iterator[Any]:
        return self._each(self._owner)

    def __reversed__(self) -> Iterator[Any]:
        return self._each(reversed(self._owner))


def test_work_beside_the_cases_grows_with_their_number_only(monkeypatch: pytest.MonkeyPatch) -> None:
    count, asked = 2000, list[int]()
    vary = {"motion.speed": {"least": "36 km/h", "most": "72 km/h", "count": count}}
    study = sweep_study(load_case("wheelset_rollers"), vary, speed_and_friction, "grid")
    record = {"changes": {}, "numbers": {"product": 1.0}, FAILED: ""}
    done = _Counted()
    for number in range(count):
        done[f"case {number}"] = {**record, FAILED: "" if number % 4 else "a reason"}
        text = study.progress_text(done, 2.0)
    assert done.looks == count  # each once, as it comes
    assert text.endswith(f", {count // 4} failed")
    found = study.collect(done)
    assert found is not None
    whole = Axis.is_number.fget  # type: ignore[attr-defined]
    monkeypatch.setattr(Axis, "is_number", property(lambda axis: asked.append(1) or whole(axis)))
    assert len(sweep_rows(found)) == count + 1
    assert len(asked) < 10  # it looks at all values: of each axis, not of each case


def test_results_lie_over_the_varied_keys_and_failed_cases_say_why() -> None:
    found = rr.sweep("wheelset_rollers", VARY, measure=speed_and_friction)
    assert found["product"].sel(speed=20.0, mu_0=0.2) == pytest.approx(4.0)
    assert found["speed"].attrs["units"] == "m/s"
    assert found["product"].isnull().sum() == 2
    assert set(found["failed"].sel(speed=40.0).to_numpy()) == {"ValueError: too fast"}
    assert (found.attrs["finished"], found.attrs["failed"]) == (4, 2)


def test_a_cell_is_what_the_command_of_that_name_finds() -> None:
    radii = {"support.roller_radius": ["0.6 m"]}
    found = rr.sweep("bogie_rollers_constant", radii, measure={"kind": "critical_speed", "slowest": "100 km/h"})
    case = load_case("bogie_rollers_constant").with_changes({"support.roller_radius": "0.6 m"})
    alone = rr.stability(case, np.arange(100.0, 401.0, 50.0).tolist()).attrs["linear_critical_speed_kmh"]
    assert float(found["linear_critical_speed"][0]) == pytest.approx(alone, rel=1e-4)  # both search to a tolerance


@pytest.mark.parametrize("kind", list(measures.MEASURES))
def test_every_measure_gives_all_its_numbers(kind: str) -> None:
    name, changes = "bogie_rollers_constant", {"time.duration": "0.5 s"}
    if kind == "adhesion":
        name, changes = "adhesion_brake", {"time.duration": "2 s"}
    measure: Any = kind
    if kind == "wsp":
        name, changes = "adhesion_brake", {"motion.stop_speed": "5 m/s"}  # stationary early, to be short
        measure = {"kind": kind, "stop": {"name": "low", "kind": "uniform", "speed": "26 km/h", "rail": "low"}}
    case = load_case(name).with_changes(changes)
    found = rr.sweep(case, {"contact.friction.mu_0": [0.25]}, measure=measure)
    assert found["failed"].item() == ""
    quantities = measures.quantities(kind)
    assert set(quantities) | {"failed"} == set(found.data_vars)
    assert not [name for name in quantities if not np.isfinite(found[name].item())]
    assert {name: found[name].attrs["units"] for name in quantities} == {n: unit for n, (unit, _) in quantities.items()}


@pytest.mark.slow
def test_thresholds_of_slide_protection_are_swept_by_the_numbers_of_the_programme() -> None:
    """K_wet of each as the programme itself finds it, of tests and dry references by hand."""
    case = load_case("adhesion_brake").with_changes({"motion.stop_speed": "5 m/s"})
    stop = {"name": "low", "kind": "uniform", "speed": "26 km/h", "rail": "low"}
    slips = [0.12, 0.5]
    found = rr.sweep(
        case,
        {"slide_protection.vent_slip": slips},
        measure={"kind": "wsp", "stop": stop, "keep": ["k_wet", "distance"]},
    )
    braked = case.with_changes(
        {"motion.speed": "26 km/h", "brake.demand": [[0.0, 0.0], [0.1, "3.8 bar"]], "time.duration": "60 s"}
    )
    dry = rr.simulate(track_case(braked.with_changes({"adhesion.rail": "dry"})))
    pressure = dry["cylinder_pressure"].mean("axle").to_numpy()
    way = 26.0 / 3.6 * np.trapezoid(1.0 - pressure / pressure.max(), dry["time"].to_numpy())
    for slip, distance, k_wet in zip(slips, found["distance"].to_numpy(), found["k_wet"].to_numpy(), strict=True):
        wet = rr.simulate(track_case(braked.with_changes({"slide_protection.vent_slip": slip})))
        assert distance == pytest.approx(float(wet["train_distance"][-1]), rel=1e-6)
        assert k_wet == pytest.approx((float(dry["train_distance"][-1]) - way) / (distance - way), rel=1e-6)
    assert abs(found["distance"][1] / found["distance"][0] - 1.0) > 1e-3


def test_the_dry_reference_is_run_once_for_all_thresholds(monkeypatch: pytest.MonkeyPatch) -> None:
    """And anew for what changes it, such as another brake."""
    times = {f"slide_protection.{key}": "6 ms" for key in ("sample_time", "delay")}
    times |= {"time.sampling_step": "2 ms", "rig_control.sample_time": "2 ms"}
    case = load_case("adhesion_brake").with_changes({"motion.stop_speed": "5 m/s", **times})
    stop = {"name": "low", "kind": "uniform", "speed": "22 km/h", "rail": "low"}
    made: list[str] = []

    def counted(case: Case, *args: Any, **more: Any) -> StopRecord:
        made.append(case.name)
        return stop_record(case, *args, **more)

    monkeypatch.setattr("rollerrig.study.runs.wsp.stop_record", counted)
    vary = {"slide_protection.vent_slip": [0.12, 0.5], "brake.friction_radius": ["240 mm", "250 mm"]}
    rr.sweep(case, vary, measure={"kind": "wsp", "stop": stop, "keep": ["k_wet"]})
    assert len([name for name in made if name.endswith("_dry_track")]) == 2
    assert len(made) == 6


def test_a_stop_that_does_not_end_is_a_failed_case() -> None:
    stop = {"name": "low", "kind": "uniform", "speed": "80 km/h", "rail": "low", "duration": "1 s"}
    found = rr.sweep("adhesion_brake", {"slide_protection.vent_slip": [0.12]}, measure={"kind": "wsp", "stop": stop})
    assert found["failed"].item().startswith("RuntimeError: in 1 of 1 tests the train had not stopped after 1 s")


def test_sobol_indices_are_those_of_ishigamis_function() -> None:
    """sin x1 + 7 sin² x2 + 0.1 x3⁴ sin x1 over (-π, π)³, whose indices are known in closed form (Ishigami, Homma 1990)."""
    keys = ("motion.speed", "contact.friction.mu_0", "support.roller_radius")
    vary = {key: {"least": 0.2, "most": 0.5} for key in keys}
    study = sweep_study(load_case("wheelset_rollers"), vary, "run", {"kind": "saltelli", "samples": 4096})
    x1, x2, x3 = (math.pi * (2.0 * (np.array(column) - 0.2) / 0.3 - 1.0) for column in study.points.columns)
    found = sobol_indices(np.sin(x1) + 7.0 * np.sin(x2) ** 2 + 0.1 * x3**4 * np.sin(x1), ["x1", "x2", "x3"])
    parts = 0.5 * (1 + 0.1 * math.pi**4 / 5) ** 2, 49 / 8, 0.0
    mixed = 0.01 * math.pi**8 * (1 / 18 - 1 / 50)
    whole = sum(parts) + mixed
    for name, first, total in zip(found, parts, (parts[0] + mixed, parts[1], mixed), strict=True):
        one = found[name]
        assert one["first"] == pytest.approx(first / whole, abs=max(0.02, 1.5 * one["first_confidence"]))
        assert one["total"] == pytest.approx(total / whole, abs=max(0.02, 1.5 * one["total_confidence"]))
        assert one["total_confidence"] < 0.06


def test_a_sample_with_a_failed_case_is_left_out_of_sobol_indices() -> None:
    rng = np.random.default_rng(3)
    a, b = rng.random((256, 2)), rng.random((256, 2))
    rows = np.stack([a, np.column_stack([b[:, 0], a[:, 1]]), np.column_stack([a[:, 0], b[:, 1]]), b], axis=1).reshape(
        -1, 2
    )
    values = rows[:, 0].copy()  # only the first one matters
    values[8 * 4 + 1] = math.nan
    found = sobol_indices(values, ["x", "y"])
    assert found["x"]["total"] == pytest.approx(1.0, abs=0.1)
    assert found["y"]["total"] == 0.0


# ----------------------------------------------------------------------------------------------------- going on


class Counted:
    """A measure that ends the sweep at a case."""

    calls = 0
    stop_at = -1


def counted(case: Case) -> dict[str, float]:
    Counted.calls += 1
    if Counted.calls == Counted.stop_at:
        raise KeyboardInterrupt
    return speed_and_friction(case)


def run(folder: Path, vary: dict[str, Any] = VARY) -> xr.Dataset | None:
    study = sweep_study(load_case("wheelset_rollers"), vary, counted, "grid")
    outcome = study.run(folder=folder)
    assert outcome is not None
    outcome.write(folder)
    return None if outcome.interrupted else outcome.results


def test_an_interrupted_sweep_goes_on_and_ends_in_the_same_bytes(tmp_path: Path) -> None:
    Counted.calls, Counted.stop_at = 0, 4
    assert run(tmp_path / "a") is None
    with (tmp_path / "a" / NAME).open("ab") as file:  # as if killed while it wrote, on a disk that is full
        file.write(b'{"job": "case 3", "result": {"chan')
    Counted.calls, Counted.stop_at = 0, -1
    assert run(tmp_path / "a") is not None
    assert Counted.calls == 3
    run(tmp_path / "b")
    assert (tmp_path / "a" / NAME).read_bytes() == (tmp_path / "b" / NAME).read_bytes()
    for name in ("sweep.nc", "sweep.csv", "summary.json", "report.html"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    assert len((tmp_path / "a" / NAME).read_bytes().splitlines()) == 1 + 6


@pytest.mark.long
@pytest.mark.parametrize("times", [1, 2])
def test_ctrl_c_is_answered_at_once_and_keeps_the_finished_cases(tmp_path: Path, times: int) -> None:
    """A real process, its group signalled as a terminal does; the time limits are for a machine that is busy."""
    (tmp_path / "plan.toml").write_text(PLAN.replace("count = 3", "count = 200"))
    journal = tmp_path / "out" / NAME
    command = [sys.executable, "-c", "from rollerrig.cli import main; main()", "sweep", str(tmp_path / "plan.toml")]
    process = subprocess.Popen(
        [*command, "--workers", "1", "--out", str(tmp_path / "out")],
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    )
    assert process.stderr is not None
    try:
        limit = time.monotonic() + 60.0
        while not (journal.exists() and journal.read_bytes().count(b"\n") > 2):
            assert process.poll() is None, process.stderr.read()
            assert time.monotonic() < limit
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGINT)
        begun, said = time.monotonic(), ""
        while "Interrupted, writing results" not in said:
            line = process.stderr.readline()
            assert line, said
            said += line
        assert time.monotonic() - begun < 10.0
        if times == 2:
            process.send_signal(signal.SIGINT)
        rest = process.communicate(timeout=60)[1]
    finally:
        if process.poll() is None:
            process.kill()
    assert process.returncode == 130, rest
    assert "Traceback" not in said + rest
    if times == 1:
        assert "the same command continues" in rest
    kept = [json.loads(line) for line in journal.read_text().splitlines()]
    assert 2 < len(kept) < 400


def kills_its_process(case: Case) -> dict[str, float]:
    """As the kernel does where memory runs out: one kind of case every time, another one the first time only."""
    once = Path(os.environ["ROLLERRIG_TEST_FOLDER"]) / "once"
    if case.motion.speed == 30.0:
        while not once.exists():  # a case that is at work when its neighbour dies counts as having died itself
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGKILL)
    if case.motion.speed == 20.0 and not once.exists():
        once.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return {"its_speed": case.motion.speed}


@pytest.mark.slow
def test_a_worker_that_is_killed_ends_neither_the_sweep_nor_other_cases(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROLLERRIG_TEST_FOLDER", str(tmp_path))
    study = sweep_study(
        load_case("wheelset_rollers"),
        {"motion.speed": [f"{v} m/s" for v in (20, 10, 25, 35, 40, 30)]},
        kills_its_process,
        "grid",
    )
    found = study.run(folder=tmp_path / "out", processes=2)
    assert found is not None
    data = found.results
    np.testing.assert_array_equal(data["its_speed"], [20.0, 10.0, 25.0, 35.0, 40.0, math.nan])
    reason = "its worker process ended in the middle, twice: killed, or out of memory"
    assert data[FAILED].to_numpy().tolist() == ["", "", "", "", "", reason]
    assert len((tmp_path / "out" / NAME).read_bytes().splitlines()) == 1 + 6


def test_ctrl_c_within_a_case_leaves_no_line_of_it() -> None:
    """Modes over speed hand back what they have; a critical speed of half of them would be a wrong one."""
    calls = 0

    def progress(_fraction: float, _text: str) -> None:
        nonlocal calls
        calls += 1
        if calls == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        measures.measured(load_case("bogie_rollers_constant"), CriticalSpeedMeasure(kind="critical_speed"), progress)


def test_another_plan_is_refused_with_what_changed(tmp_path: Path) -> None:
    Counted.stop_at = -1
    run(tmp_path)
    with pytest.raises(ConfigError, match=r"plan\.vary\[1\]\.values\[1\]: 0\.2 there, 0\.3 now"):
        run(tmp_path, {**VARY, "contact.friction.mu_0": [0.1, 0.3]})


def slow_first(case: Case) -> dict[str, float]:
    """The sooner handed out, the later done."""
    time.sleep(max(0.0, 0.06 - 2e-3 * case.motion.speed))
    return speed_and_friction(case)


def test_the_order_in_which_cases_end_changes_no_byte(tmp_path: Path) -> None:
    study = sweep_study(load_case("wheelset_rollers"), VARY, slow_first, "grid")
    with ThreadPoolExecutor(6) as executor:
        for folder, other in (("alone", None), ("together", executor)):
            outcome = study.run(folder=tmp_path / folder, executor=other)
            assert outcome is not None
            outcome.write(tmp_path / folder)
    assert_same_bytes(tmp_path / "alone", tmp_path / "together")


@pytest.mark.long
def test_many_workers_write_the_same_bytes_as_one(tmp_path: Path) -> None:
    plan_of(tmp_path, PLAN)
    for workers in ("1", "2"):
        arguments = ["sweep", str(tmp_path / "plan.toml"), "--out", str(tmp_path / workers), "--workers", workers]
        assert called(*arguments).exit_code == 0
    assert_same_bytes(tmp_path / "1", tmp_path / "2")


def assert_same_bytes(one: Path, other: Path) -> None:
    files = sorted(path.relative_to(one) for path in one.rglob("*") if path.is_file())
    assert {"sweep.nc", "report.html", NAME} <= {str(file) for file in files}
    for file in files:
        assert file.name == "timing.json" or (one / file).read_bytes() == (other / file).read_bytes(), file


def test_the_command_writes_all_files_and_explains_its_numbers(tmp_path: Path) -> None:
    plan_of(tmp_path, PLAN.replace("critical_speed", "stability").replace("count = 3", "count = 2"))
    out = tmp_path / "out"
    arguments = ["sweep", str(tmp_path / "plan.toml"), "--out", str(out), "--workers", "1"]
    assert called(*arguments).exit_code == 0
    numbers = json.loads((out / "summary.json").read_text())
    assert not unexplained(SweepStudy.quantities, {k: v for k, v in numbers.items() if k != "keys"})
    assert numbers["finished"] == 4
    data = load_run(out / "sweep.nc")
    assert data["growth_rate"].dims == ("roller_radius", "primary")
    assert {path.name for path in (out / "figures").iterdir()} >= {"map_growth_rate.png", "tornado_growth_rate.png"}


def test_words_that_are_varied_have_their_means_and_changes_in_pairs() -> None:
    """Full sliding is the friction itself, 0.2 to 0.4, whatever the law; a known change of +2, +4, +6 has its interval."""
    vary = {"contact.creep": ["table", "kalker_saturated"], "contact.friction": [0.2, 0.3, 0.4]}
    study = sweep_study(load_case("wheelset_rollers"), vary, {"kind": "creep", "longitudinal": -1.0}, "grid")
    outcome = study.run()
    assert outcome is not None
    words = outcome.numbers["numbers"]["longitudinal_force"]["words"]["creep"]
    assert [one["mean"] for one in words.values()] == pytest.approx([0.3, 0.3], rel=1e-3)
    assert unexplained(study.quantities, outcome.numbers) == []
    tables = [block for section in study.sections(outcome.results, outcome.numbers) for block in section.blocks]
    table = next(block for block in tables if isinstance(block, Table) and block.header[0] == "creep")
    assert [row[0] for row in table.rows] == ["table", "kalker saturated"]
    values = {"longitudinal_force": [1.0, 5.0, 2.0, 3.0, 9.0, math.nan]}
    data = xr.Dataset({name: ("case", one, {"units": "1"}) for name, one in values.items()})
    change = statistics(data, study.points)["longitudinal_force"]["words"]["creep"]["kalker_saturated"]
    half = float(stats.t.ppf(0.975, 1)) * 1.0  # two pairs, +2 and +4: standard error sqrt(2) / sqrt(2)
    assert change == pytest.approx({"mean": 6.0, "change": 3.0, "low": 3.0 - half, "high": 3.0 + half})


# ------------------------------------------------------------------------------------------------------ bad plans


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("support.roller_radius", "support.roler_radius", r"vary\[0\].key: .*did you mean 'roller_radius'"),
        ("primary_*", "primry_*", r"vary\[1\].key: .*did you mean"),
        ('["500 mm", 1.0]', "[]", r"vary\[0\].values: \[\]; allowed: at least 1 entries"),
        ('"500 mm"', '"500 kg"', r"vary\[0\].values\[0\]: '500 kg'; allowed: a number in m"),
        ('"500 mm"', "-1.0", r"vary\[0\].values\[0\]: -1.0; allowed: .* from 0.001"),
        ('most = "30 MN/m"', 'most = "3 MN/m"', r"vary\[1\].most: 3 MN/m; allowed: more than `least`"),
        ("count = 3", "", r"vary\[1\].count: missing; needed in a grid"),
        ("count = 3", "cont = 3", r"vary.primary.cont: unknown key .*did you mean 'count'"),
        ("count = 3", "count = 100000", r"design: 200000 cases; allowed: up to 100000 cases; more with --yes"),
        ("count = 3", "count = 1000000000", r"design: 2000000000 cases; allowed: up to 100000 cases; more with --yes"),
        ('kind = "critical_speed"', 'kind = "critical_sped"', r"measure\[0\].kind: .*did you mean 'critical_speed'"),
        ('kind = "critical_speed"', 'kind = "run"\nkeep = ["lateral_rm"]', r"keep\[0\]: .*did you mean 'lateral_rms'"),
        ('kind = "grid"', 'kind = "sobol"\nsamples = 100', r"design.samples: 100; allowed .*such as 64 or 128"),
        ('kind = "grid"', 'kind = "random"', r"design.samples: missing; needed by the design random"),
        ("wheelset_rollers", "wheelset_roller", r"case: 'wheelset_roller'; .*did you mean 'wheelset_rollers'"),
        ('name = "primary"', 'name = "roller_radius"', r"vary\[1\].name: 'roller_radius'; allowed: each name once"),
        ('[[measure]]\nkind = "critical_speed"', "", r"measure: missing"),
        ('key = "vehicle.element.primary_*.x.stiffness"', 'key = "contact.friction"',
         r"vary\[1\].key: contact.friction; .*holds no number, which alone has a range; its numbers are contact.friction.mu_0"),
    ],
)  # fmt: skip
def test_a_wrong_plan_is_one_line_with_a_way_out(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in PLAN
    with pytest.raises(ConfigError, match=message):
        SweepStudy(plan_of(tmp_path, PLAN.replace(old, new)))


def test_a_slip_of_the_pen_costs_no_memory(tmp_path: Path) -> None:
    """10^9 cases and more: refused before a value of them is made."""
    whole = plan_of(tmp_path, PLAN.replace("count = 3", "count = 1000000000"))
    tracemalloc.start()
    try:
        with pytest.raises(ConfigError, match=r"more with --yes"):
            SweepStudy(whole)
        with pytest.raises(ConfigError, match=r"2000000000 cases; allowed: up to 1000000 cases"):
            SweepStudy(whole, many=True)
        assert tracemalloc.get_traced_memory()[1] < 1e6
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("wrong", ["values = []", 'valus = ["1 m"]', 'least = "1 m"\nmost = "2 m"\ncount = 0'])
def test_a_wrong_table_is_not_told_a_second_time_as_a_list_too_short(tmp_path: Path, wrong: str) -> None:
    begin, one, _other, end = re.split(r"(?=\[\[)", PLAN)
    with pytest.raises(ConfigError) as refused:
        plan_of(tmp_path, begin + one.replace('values = ["500 mm", 1.0]', wrong) + end)
    keys = [problem.key for problem in refused.value.problems]
    assert keys
    assert "vary" not in keys


def test_a_plan_that_varies_nothing_is_refused(tmp_path: Path) -> None:
    text = "\n".join(["vary = []", PLAN.split("[[vary]]")[0], "[[measure]]", PLAN.split("[[measure]]")[1]])
    with pytest.raises(ConfigError, match=r"vary: \[\]; allowed: at least 1 entries"):
        plan_of(tmp_path, text)


@pytest.mark.parametrize(
    ("distribution", "message"),
    [
        ({"kind": "normal", "mean": "1 t", "deviation": "0.6 t"}, r"4.8 % of it lies below 1e-05 kg"),
        ({"kind": "normal", "mean": "1 t", "deviation": "0 t"}, r"distribution.deviation: 0 t; allowed: positive"),
        ({"kind": "normal", "mean": "1 m", "deviation": "1 t"}, r"distribution.mean: '1 m'; allowed: a number in kg"),
        ({"kind": "lognormal", "median": "-1 t", "deviation": 0.1}, r"distribution.median: -1 t; allowed: positive"),
    ],
)
def test_a_distribution_that_cannot_be_is_refused(distribution: dict[str, Any], message: str) -> None:
    vary = {"vehicle.body.wheelset_1.mass": {"distribution": distribution}}
    with pytest.raises(ConfigError, match=message):
        sweep_study(load_case("wheelset_rollers"), vary, "run", {"kind": "random", "samples": 4})


def test_a_distribution_without_mass_between_its_ends_is_refused() -> None:
    law = {"kind": "normal", "mean": "1 t", "deviation": "10 kg"}
    vary = {"vehicle.body.wheelset_1.mass": {"distribution": law, "least": "2 t", "most": "3 t"}}
    with pytest.raises(ConfigError, match="no probability mass lies between its ends"):
        sweep_study(load_case("wheelset_rollers"), vary, "run", {"kind": "random", "samples": 4})


def test_bad_input_leaves_nothing_behind(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text(PLAN.replace("count = 3", "count = 0"))
    out = tmp_path / "out"
    done = called("sweep", tmp_path / "plan.toml", "--out", out)
    assert done.exit_code == 2
    assert not out.exists()


@pytest.mark.parametrize(
    "name",
    [
        "critical_speed_map",
        "paper_critical_speed",
        "paper_critical_speed_near",
        "stopping_distance_fidelity",
        "axle_faults",
        "flange_force_misalignment",
    ],
)
def test_a_plan_that_ships_is_whole_and_its_first_case_has_numbers(name: str) -> None:

    study = SweepStudy(load_plan(name))
    if study.whole.plan.measure[0].kind == "adhesion":
        assert len(study.points) == (200 if name == "stopping_distance_fidelity" else 7)
        measure = study.whole.plan.measure[0].model_copy(update={"longest": 3.0})
        plan = study.whole.plan.model_copy(update={"measure": (measure,)})
        study = SweepStudy(replace(study.whole, plan=plan))
    first = next(iter(next(study.rounds({})).values()))
    record = first.call(lambda _fraction, _text: None)
    assert record["failed"] == ""
    assert all(math.isfinite(value) for value in record["numbers"].values())


def test_rollers_that_are_mounted_askew_turn_by_that_angle_and_push_the_wheelset_aside() -> None:
    stiff = {"yaw": {"stiffness": "4 GN m/rad", "damping": "500 kN m s/rad"}, "misalignment": ["2 mrad"]}
    changes = {"support.mounting": stiff, "disturbance": [], "motion.speed": "60 km/h", "time.duration": "0.1 s"}
    case = load_case("bogie_rollers_constant").with_changes(changes)
    left, right = (rr.simulate(case.with_changes({"support.mounting.misalignment": [a]})) for a in (2e-3, -2e-3))
    yaw = left["yaw"].isel(time=-1)
    assert float(yaw.sel(body="roller_1")) == pytest.approx(2e-3, rel=0.005)  # the springs give way by 0.3 %
    assert abs(float(yaw.sel(body="roller_2"))) < 2e-5
    lateral = [float(run["lateral"].sel(body="wheelset_1").isel(time=-1)) for run in (left, right)]
    assert lateral[0] == pytest.approx(-lateral[1], rel=1e-3)  # a mirror image
    assert lateral[0] < -1e-3
    with pytest.raises(ConfigError, match=r"mounting\.yaw: missing; needed"):
        case.with_changes({"support.mounting.yaw": None})


@pytest.mark.slow
def test_a_quantile_has_an_interval_that_holds_and_no_end_that_few_samples_do_not_have() -> None:
    """Exponential samples, 64 at a time: at least 95 of 100 intervals have the true quantile, an order statistic at each end."""
    samples = np.random.default_rng(1).exponential(size=(400, 64))
    for share in (0.25, 0.5, 0.95):
        found = [quantile(one, share) for one in samples]
        inside = [not one["low"] > -np.log(1.0 - share) and not one["high"] < -np.log(1.0 - share) for one in found]
        assert 0.93 <= np.mean(inside) <= 1.0
    few = quantile(samples[0, :16], 0.05)
    assert np.isnan(few["low"])
    assert few["value"] < few["high"]
