"""`rollerrig replay`: the rig's controller on logs of runs of the program's own, and logs that are none."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray
from scipy.io import savemat

from called import called
from reported import unexplained, unreported
from rollerrig import ConfigError, ResultsError, load_case, reconstruct, simulate
from rollerrig import replay as replay_log
from rollerrig.analysis.controller_replay import episodes, replay
from rollerrig.analysis.rig_log import check_case, read_rig_log
from rollerrig.cli import main
from rollerrig.config import Case
from rollerrig.results import export
from rollerrig.study.replay import ReplayStudy

COLUMNS = ["measured_axle_speed", "axle_speed", "roller_speed", "measured_roller_torque", "roller_torque", "cylinder_pressure",
           "creep_force", "brake_torque", "estimated_force", "estimated_torque", "virtual_speed", "train_speed"]  # fmt: skip
SHORT = {
    "contact.normal": "hertz",  # what presses on the rollers is none of the controller's
    "motion.speed": "60 km/h",
    "brake.demand": [[0.0, 0.0], [0.1, "3.8 bar"]],
    "time.output_step": "1 ms",  # the sample time of the controller
}
COUNTS, WINDOW, JITTER, NOISE = 20000, 4, 0.1, 20.0
SENSOR = {"counts": COUNTS, "window": WINDOW, "jitter": JITTER}
SENSORS = {"sensors": {"axles": SENSOR, "rollers": SENSOR, "roller_torque": {"noise": NOISE}}}


@pytest.fixture(scope="module")
def case() -> Case:
    return load_case("adhesion_brake").with_changes({**SHORT, "time.duration": "3.5 s"})


@pytest.fixture(scope="module")
def run(case: Case) -> xr.Dataset:
    found = simulate(case)[COLUMNS]
    assert float((found["virtual_speed"] * 0.46 / found["train_speed"]).min()) < 0.95  # the wheels of its train slide
    return found.transpose("time", "axle")


@pytest.fixture(scope="module")
def found(case: Case, run: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    return replay(case, read_rig_log(export(run, tmp_path_factory.mktemp("log") / "rig.csv"), case))


def largest(difference: xr.DataArray) -> float:
    return float(np.abs(difference).max())


def test_the_log_of_a_run_gives_the_estimates_and_the_virtual_train_of_the_run(found: xr.Dataset) -> None:
    """To round-off: 8 kN, 5 kN m and 36 rad/s, sampled at the same instants."""
    assert largest(found["force_at_once"] - found["estimated_force"]) < 1e-7
    assert largest(found["torque_taken"] - found["estimated_torque"]) < 1e-7
    assert largest(found["virtual_axle_speed"] - found["virtual_speed"]) < 1e-9


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        # A controller that samples every fourth row: of the torque in between it takes the mean.
        ("adhesion_brake", {"brake.demand": [[0.0, 0.0], [0.1, "3.8 bar"]], "time.sampling_step": "0.5 ms",
                            "time.output_step": "0.5 ms", "rig_control.sample_time": "2 ms"}),
        ("adhesion_start", {"time.output_step": "1 ms", "rig_control.axle_torque.kind": "extrapolated"}),  # by motors
    ],
)  # fmt: skip
def test_other_samples_and_motors(name: str, changes: dict[str, object], tmp_path: Path) -> None:
    case = load_case(name).with_changes({"contact.normal": "hertz", "time.duration": "0.7 s", **changes})
    run = simulate(case)[[*COLUMNS, "traction_torque"]]
    found = replay(case, read_rig_log(export(run, tmp_path / "rig.csv"), case))
    every = round((run.sizes["time"] - 1) / (found.sizes["time"] - 1))
    for ours, theirs in (("force_at_once", "estimated_force"), ("virtual_axle_speed", "virtual_speed")):
        expected = run[theirs].transpose("time", "axle").to_numpy()[::every]
        np.testing.assert_allclose(found[ours], expected, rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize("kind", ["filtered_derivative", "kalman"])
def test_with_the_noise_of_its_sensors_too(kind: str, tmp_path: Path) -> None:
    """The rollers' sensors stay exact, since a run records true speeds of rollers alone. The flange's reading before the
    first row is unknown: 10 N m of the first mean, forgotten before the torque rises."""
    sensors = {"sensors.axles": SENSOR, "sensors.roller_torque": {"noise": NOISE}}
    changes = {**SHORT, **sensors, "rig_control.estimator.kind": kind, "time.duration": "0.7 s"}
    case = load_case("adhesion_brake").with_changes(changes)
    found = replay(case, read_rig_log(export(simulate(case)[COLUMNS], tmp_path / "rig.csv"), case)).sel(
        time=slice(0.3, None)
    )
    assert largest(found["force_at_once"] - found["estimated_force"]) < 1e-6
    assert largest(found["virtual_axle_speed"] - found["virtual_speed"]) < 1e-3


def test_rows_that_are_no_samples_of_the_controller(
    case: Case, run: xr.Dataset, found: xr.Dataset, tmp_path: Path
) -> None:
    """Every 4 ms, a straight line in between: within 0.5 % of the largest force, and the virtual wheels within 0.02 rad/s."""
    coarse = replay(case, read_rig_log(export(run.isel(time=slice(None, None, 4)), tmp_path / "rig.csv"), case))
    settled = found["time"].to_numpy() > 0.1
    assert largest((coarse["force"] - found["force"])[settled]) < 0.005 * largest(found["force"])
    assert largest(coarse["virtual_axle_speed"] - found["virtual_axle_speed"]) < 0.02


def test_the_delay_is_known_afterwards(found: xr.Dataset) -> None:
    """Of the observer 12.2 ms, docs/theory/rig_control.md; without it a fifth of the error is left."""
    assert found.attrs["force_delay_s"] == pytest.approx(12.2e-3, abs=1e-4)
    good = ~found["doubtful"].any("reason")
    late, left = (
        ((found[name] - found["creep_force"]).where(good) ** 2).mean() ** 0.5 for name in ("force_at_once", "force")
    )
    assert float(left) < 0.3 * float(late)


# ----------------------------------------------------------------------------------------------------------- noise


def encoder(
    speed: NDArray[np.float64], random: np.random.Generator, per_turn: int = COUNTS, window: int = WINDOW
) -> NDArray[np.float64]:
    """Speed of one axle as an encoder sees it, after docs: counts that have passed, differenced over a window."""
    angle = np.concatenate([[0.0], np.cumsum(0.5e-3 * (speed[1:] + speed[:-1]))])
    counts = np.floor(angle / (2 * np.pi) * per_turn + JITTER * random.normal(size=len(angle)))
    sample = np.arange(len(counts))
    back = np.clip(sample, 1, window)
    passed = counts - counts[np.maximum(sample - back, 0)]
    return np.where(sample == 0, speed[0], passed * 2 * np.pi / (per_turn * back * 1e-3))


@pytest.fixture(scope="module")
def noisy(run: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same run as encoders and a torque flange see it, written without the program's own."""
    random, seen = np.random.default_rng(2), run.drop_vars([name for name in COLUMNS if name.startswith("measured_")])
    for name in ("axle_speed", "roller_speed"):
        columns = [encoder(seen[name].to_numpy()[:, k], random) for k in range(2)]
        seen[name] = seen[name].copy(data=np.column_stack(columns))
    seen["roller_torque"] = seen["roller_torque"] + NOISE * random.normal(size=seen["roller_torque"].shape)
    seen["roller_torque"].attrs["units"] = "N m"
    return export(seen, tmp_path_factory.mktemp("noisy") / "rig.csv")


@pytest.mark.parametrize("kind", ["observer", "filtered_derivative", "kalman"])
def test_the_band_holds_the_truth_in_95_per_cent(kind: str, case: Case, noisy: Path) -> None:
    """Samples follow each other over the estimator's memory: some 40 independent ones a second, 0.95 is known to 0.02."""
    sensed = case.with_changes({**SENSORS, "rig_control.estimator.kind": kind})
    found = replay(sensed, read_rig_log(noisy, sensed))
    good = ~found["doubtful"].any("reason").to_numpy()
    assert good.mean() > 0.8
    for name, true in (("force", "creep_force"), ("torque", "torque_known")):
        error = (found[name] - found[true]).to_numpy()[good]
        assert (np.abs(error) < found[f"{name}_band"].to_numpy()[good]).mean() == pytest.approx(0.96, abs=0.02), name
        assert error.std() == pytest.approx(found.attrs[f"{name}_noise"], rel=0.08), name


# ------------------------------------------------------------------------------------------------ what is doubtful


def seconds(found: xr.Dataset, reason: str) -> list[tuple[str, float, float]]:
    return [(axle, begin, end) for axle, why, begin, end in episodes(found) if why == reason]


def test_a_run_of_the_rig_itself_is_not_doubtful(found: xr.Dataset) -> None:
    for reason in ("torque", "limit", "sliding", "locked"):
        assert seconds(found, reason) == []
    assert {axle for axle, _, _ in seconds(found, "start")} == {"wheelset_1", "wheelset_2"}


def test_drives_at_their_limit_are_named_with_their_time(case: Case, run: xr.Dataset, tmp_path: Path) -> None:
    torque = np.abs(run["roller_torque"])
    limit = 0.9 * float(torque.max())
    weak = case.with_changes({"rig_control.motor.largest_torque": f"{limit} N m"})
    got = replay(weak, read_rig_log(export(run, tmp_path / "rig.csv"), weak))
    beyond = (torque > 0.99 * limit).any("axle").to_numpy()
    assert seconds(got, "limit")[0][1] == pytest.approx(float(run["time"][int(np.argmax(beyond))]), abs=1e-9)


def test_pads_that_rub_otherwise_show_in_the_torques(
    case: Case, run: xr.Dataset, found: xr.Dataset, tmp_path: Path
) -> None:
    other = run.assign(cylinder_pressure=run["cylinder_pressure"] * 1.25)
    other["cylinder_pressure"].attrs["units"] = "Pa"
    outcome = replay_log(case, str(export(other, tmp_path / "rig.csv")))
    for axle in outcome.numbers["axles"].values():
        assert axle["torque_ratio"] == pytest.approx(0.8, abs=0.01)
        assert axle["torque_s"] > 1.0


@pytest.mark.parametrize(("name", "per_turn"), [("axle_speed", 4096), ("roller_speed", 5000)])
def test_wheels_read_from_sample_to_sample_roll_on_their_rollers(
    name: str, per_turn: int, case: Case, run: xr.Dataset, tmp_path: Path
) -> None:
    """With steps of 4 % of the speed; the median of the ratio of such speeds is off by 2 %."""
    random, part = np.random.default_rng(1), run.isel(time=slice(0, 1000)).drop_vars("measured_axle_speed")
    read = [encoder(speed, random, per_turn, 1) for speed in part[name].to_numpy().T]
    part[name] = part[name].copy(data=np.column_stack(read))
    ratio = 0.46 * part["axle_speed"] / (0.725 * part["roller_speed"])
    assert abs(float(ratio.median()) - 1.0) > 0.01
    read_rig_log(export(part, tmp_path / "rig.csv"), case)


@pytest.mark.slow
def test_the_steps_of_encoders_alone_contradict_no_brake(case: Case, run: xr.Dataset, tmp_path: Path) -> None:
    """600 N m without braking; where it brakes, bar in place of Pa shows with these sensors, too."""
    built = load_case("adhesion_rig_as_built")
    rolling = built.with_changes({**SHORT, "brake.demand": [[0.0, 0.0], [1.0, 0.0]], "time.duration": "1.5 s"})
    found = replay(rolling, read_rig_log(export(simulate(rolling), tmp_path / "rolling.csv"), rolling))
    assert float((found["torque"] ** 2).mean() ** 0.5) > 50.0 * float((found["torque_known"] ** 2).mean() ** 0.5)
    other = run.assign(cylinder_pressure=run["cylinder_pressure"] * 1e-5)
    other["cylinder_pressure"].attrs["units"] = "Pa"
    sensed = case.with_changes({"sensors": built.sensors})
    with pytest.raises(ResultsError, match="look at the units of pressures"):
        replay(sensed, read_rig_log(export(other, tmp_path / "rig.csv"), sensed))


def test_a_wheel_that_slides_or_stands_is_named(case: Case, run: xr.Dataset, tmp_path: Path) -> None:
    """By 1.5 m/s for 0.2 s; then it stands, with its roller."""
    other = run.drop_vars("measured_axle_speed").copy(deep=True)
    late, last = (run["time"].to_numpy() >= begin for begin in (3.0, 3.2))
    other["axle_speed"].values[late, 1] -= 1.5 / 0.46
    for name in ("axle_speed", "roller_speed"):
        other[name].values[last, 1] = 0.0
    got = replay(case, read_rig_log(export(other, tmp_path / "rig.csv"), case))
    assert seconds(got, "sliding") == [("wheelset_2", pytest.approx(3.0), pytest.approx(3.2))]
    assert seconds(got, "locked") == [("wheelset_2", pytest.approx(3.2), pytest.approx(3.501))]


# ------------------------------------------------------------------------------------------------------- refusals


@pytest.mark.slow
def test_signs_and_radii_that_contradict_each_other_are_refused(case: Case, run: xr.Dataset, tmp_path: Path) -> None:
    def changed(name: str, factor: float, drop: str = "") -> Path:
        other = run.drop_vars([one for one in (drop, f"measured_{name}") if one in run])
        other[name] = other[name] * factor
        other[name].attrs["units"] = run[name].attrs["units"]
        return export(other, tmp_path / "rig.csv", force=True)

    with pytest.raises(
        ResultsError, match=r"wheelset_1: by drive and speeds its torque is -\d.* allowed: 0\.2 to 5; look at the units"
    ):
        replay(case, read_rig_log(changed("roller_torque", -1.0), case))
    with pytest.raises(ResultsError, match=r"wheelset_1.brake_torque drives the axle; allowed: .* negative"):
        read_rig_log(changed("brake_torque", -1.0, "cylinder_pressure"), case)
    with pytest.raises(ResultsError, match=r"wheelset_1: by the case's radii, 0.46 and 0.725 m, .* at 1\.04 times"):
        read_rig_log(changed("axle_speed", 1.04), case)
    for factor in (1e5, 1e-5):  # Pa called bar, bar called Pa
        with pytest.raises(ResultsError, match=r"look at the units of pressures"):
            replay(case, read_rig_log(changed("cylinder_pressure", factor), case))
    with pytest.raises(ResultsError, match=r"at 9\.\d+e?\d* times the speed of that of its roller|at \d+ times"):
        read_rig_log(changed("roller_speed", 1e-3), case)
    with pytest.raises(ResultsError, match=r"at -0.999 times the speed .* both speeds positive in forward running"):
        read_rig_log(changed("roller_speed", -1.0), case)
    by_torque = replay(case, read_rig_log(changed("brake_torque", 1.0, "cylinder_pressure"), case))
    assert largest(by_torque["torque_known"] - by_torque["torque_expected"]) < 500.0  # but for corners of the demand


def lines(rows: int = 700, step: float = 1e-3) -> str:
    heads = ["time [s]"]
    for axle in ("wheelset_1", "wheelset_2"):
        heads += [f"{axle}.axle_speed [km/h]", f"{axle}.roller_speed [km/h]", f"{axle}.roller_torque [kN m]",
                  f"{axle}.cylinder_pressure [bar]"]  # fmt: skip
    return "\n".join([",".join(heads), *(f"{step * k:g}," + ",".join(["60", "60", "0", "0"] * 2) for k in range(rows))])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (lines().replace("wheelset_2.roller_speed", "wheelset_2.speed"), r"no column 'wheelset_2.roller_speed \[rad/s\]'"),
        (lines().replace("roller_torque [kN m]", "roller_torque"), r"roller_torque has no unit; write '.*roller_torque \[N m\]'"),
        (lines().replace("axle_speed [km/h]", "axle_speed [bar]"), r"axle_speed \[bar\] is no unit of it"),
        (lines().replace("cylinder_pressure", "pressure"), r"no column 'wheelset_1.cylinder_pressure \[Pa\]'"),
        (lines().replace("\n0.1,", "\n0.05,"), "time: 0.05 s follows 0.099 s: not later"),
        (lines().replace("\n0.1,", "\n0.099,"), "time: 0.099 s follows 0.099 s: not later"),
        (lines().replace("\n0.1,", "\n#0.1,").replace("\n0.10", "\n#0.10"), "time: 0.11 s follows 0.099 s: a gap, rows"),
        (lines().replace("\n0.1,60", "\n0.1,"), "axle_speed: row 101 has no number"),
        (lines(100, 1e-2), r"rows are 0.01 s apart; allowed: 0.005 s, 1/10 of a period of the estimator's bandwidth"),
        (lines(300), r"time: 300 rows over 0.299 s; needed: 0.5 s"),
    ],
)  # fmt: skip
def test_a_log_that_is_none_is_refused_in_a_line(case: Case, tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "rig.csv"
    file.write_text(lines() + "\n")
    log = read_rig_log(file, case)
    assert float(log["axle_speed"][0, 0]) == pytest.approx(60 / 3.6 / case.vehicle.data.wheel.radius)
    assert log.attrs["train_speed"] == pytest.approx(60 / 3.6)
    file.write_text(text + "\n")
    with pytest.raises(ResultsError, match=message) as said:
        read_rig_log(file, case)
    assert "\n" not in str(said.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"rig_control.estimator.kind": "exact"},
            "estimator.kind: 'exact'; allowed: observer, .*: no log has what really acts",
        ),
        ({"rig_control.estimator.torque": "commanded"}, "estimator.torque: 'commanded'; allowed: 'measured'"),
    ],
)
def test_a_case_whose_controller_needs_more_than_a_log_is_refused(
    case: Case, change: dict[str, str], message: str
) -> None:
    with pytest.raises(ConfigError, match=message):
        check_case(case.with_changes(change))
    with pytest.raises(ConfigError, match="rig_control: missing"):
        check_case(load_case("bogie_rollers_constant"))


# --------------------------------------------------------------------------------------------- report, other files


@pytest.mark.slow
def test_the_report_explains_its_numbers(case: Case, run: xr.Dataset, tmp_path: Path) -> None:
    outcome = replay_log(case, str(export(run, tmp_path / "rig.csv")))
    numbers, quantities = outcome.numbers, ReplayStudy.quantities
    assert unexplained(quantities, numbers) == []
    assert unreported(quantities, numbers) == []
    assert numbers["differences"]["force"] < 1e-7
    assert "The sensors of the case are exact: no interval" in outcome.summary
    written = {path.relative_to(tmp_path / "out").as_posix() for path in outcome.write(tmp_path / "out")}
    assert {"replay.nc", "doubtful.csv", "figures/forces.png", "figures/torques.png", "figures/speeds.png"} <= written
    assert xr.load_dataset(tmp_path / "out" / "replay.nc")["force"].attrs["units"] == "N"


def test_a_band_that_never_holds_the_force_is_told(case: Case) -> None:
    """Nothing inside is a finding, a doubt that lasts for no time none."""
    axle = {q.name: 1.0 for q in ReplayStudy.quantities.below("axles.*")} | {
        "share_inside": 0.0,
        "locked_s": 0.0,
        "error_n": None,
    }
    numbers = {"force_delay_ms": 1.0, "force_noise_n": 20.0, "axles": {"wheelset_1": axle}}
    told = ReplayStudy(case, xr.Dataset()).summary(xr.Dataset(), numbers)
    assert "samples inside the band: 0 % (wheelset 1)." in told
    assert not any(line.startswith(("wheel locked", "error without")) for line in told)


def test_columns_of_matlab(case: Case, run: xr.Dataset, found: xr.Dataset, tmp_path: Path) -> None:
    content: dict[str, object] = {"time": run["time"].to_numpy()}
    units = {"time": "s"}
    for axle in run["axle"].to_numpy():
        for name in ("axle_speed", "roller_speed", "roller_torque", "cylinder_pressure"):
            content[f"{axle}_{name}"] = run[name].sel(axle=axle).to_numpy()
            units[f"{axle}_{name}"] = run[name].attrs["units"]
    savemat(tmp_path / "rig.mat", {**content, "units": units})
    again = replay(case, read_rig_log(tmp_path / "rig.mat", case))
    assert largest(again["force"] - found["force"]) < 1e-7


@pytest.mark.parametrize("study", [replay_log, reconstruct])
def test_a_log_may_be_a_path(study: Callable[..., object], tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        study("adhesion_brake", tmp_path / "none.csv")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the server is written for Linux")
def test_what_the_server_records_is_a_log(tmp_path: Path) -> None:
    changes = {**SHORT, "time.duration": "0.7 s"}
    (tmp_path / "case.toml").write_text(load_case("adhesion_brake").with_changes(changes).to_toml())
    options = ["--at-once", "--lock-step", "--record", str(tmp_path / "run.npz"), "--outputs", "wheelset_*,train.speed"]
    done = called("serve", tmp_path / "case.toml", *options)
    assert done.exit_code == 0, done.output
    case = load_case(str(tmp_path / "case.toml"))
    found = replay(case, read_rig_log(tmp_path / "run.npz", case))
    assert largest(found["force_at_once"] - found["estimated_force"]) < 1e-7
    assert largest(found["virtual_axle_speed"] - found["virtual_speed"]) < 1e-9


def test_the_command_refuses_a_log_in_a_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "rig.csv").write_text("t,v\n0,1\n1,1\n")
    monkeypatch.setattr(
        "sys.argv", ["rollerrig", "replay", "adhesion_brake", str(tmp_path / "rig.csv"), "--out", str(tmp_path / "x")]
    )
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "no column 'time [s]'" in error
