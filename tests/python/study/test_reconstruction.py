"""`rollerrig reconstruct`: the rail under a stop that the program ran itself, and logs that are none."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from reported import unexplained, unreported
from rollerrig import ConfigError, ResultsError, load_case, simulate
from rollerrig.analysis.adhesion_reconstruction import StopLog, check_case, read_stop, reconstruct, with_map
from rollerrig.cli import main
from rollerrig.config import Case, case_from_toml
from rollerrig.results import export
from rollerrig.study.frame import Outcome
from rollerrig.study.reconstruction import ReconstructionStudy
from rollerrig.study.runs.adhesion import track_case

CHANGE = 90.0
"""Where the rail becomes better [m]."""


@pytest.fixture(scope="module")
def case() -> Case:
    """On the rig, braked at once, on the rail whose friction the reconstruction does not know."""
    return load_case("adhesion_brake").with_changes({
        "motion.speed": "60 km/h",
        "motion.stop_speed": "5 m/s",
        "brake.demand": [[0.0, 0.0], [0.1, "3.8 bar"]],
    })  # fmt: skip


@pytest.fixture(scope="module")
def run(case: Case) -> xr.Dataset:
    """Two kinds of rail, on track."""
    rail = case.adhesion.rail.model_dump()  # type: ignore[union-attr]
    better = {**rail, "friction": {**rail["friction"], "mu_0": 0.11}}
    return simulate(track_case(case.with_changes({"adhesion.piece": [{"distance": f"{CHANGE} m", "rail": better}]})))


@pytest.fixture(scope="module")
def log(case: Case, run: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> StopLog:
    """The run as a file, every 50 ms."""
    file = tmp_path_factory.mktemp("log") / "stop.csv"
    export(run.isel(time=slice(None, None, 5)), file)
    return read_stop(file, case)


@pytest.fixture(scope="module")
def outcome(case: Case, log: StopLog) -> Outcome[xr.Dataset]:
    found = ReconstructionStudy(case, log).run()
    assert found is not None
    return found


@pytest.mark.slow
def test_the_log_is_that_of_the_run(run: xr.Dataset, log: StopLog) -> None:
    assert log.axles == ("wheelset_1", "wheelset_2")
    assert log.distance[-1] == pytest.approx(float(run["train_distance"][-1]), rel=2e-3)
    expected = run["cylinder_pressure"].transpose("time", "axle").to_numpy()[::5]
    np.testing.assert_allclose(log.pressure, expected, rtol=1e-12)


@pytest.mark.slow
def test_friction_is_found_within_two_per_cent(case: Case, log: StopLog) -> None:
    """In every piece in which an axle slid, but where the rail changes under the bogie."""
    rail = reconstruct(case, log, 10.0)
    places, found = rail["distance"].to_numpy(), rail["friction"].to_numpy()
    true = np.where(places < CHANGE, 0.08, 0.11)
    away = (abs(places - CHANGE) > 10.0) & (rail["measured"].to_numpy() > 0.0)
    assert away.sum() > 10
    assert (true[away] > 0.1).sum() > 3
    np.testing.assert_allclose(found[away], true[away], rtol=0.02)


@pytest.mark.slow
def test_of_a_rail_that_slides_clean_it_is_said_that_one_map_does_not_describe_it(
    outcome: Outcome[xr.Dataset], tmp_path: Path
) -> None:
    """Each axle finds what the one before left; the map has the cleaning in it, and the case on it cleans nothing again."""
    assert "One map does not" not in outcome.summary
    case = load_case("adhesion_recovery")
    export(simulate(track_case(case)).isel(time=slice(None, None, 5)), tmp_path / "stop.csv")
    study = ReconstructionStudy(case, read_stop(tmp_path / "stop.csv", case))
    found = study.run()
    assert found is not None
    adhesion = with_map(case.with_changes({"adhesion.wheel_memory": "10 m"}), study.rail).adhesion
    assert adhesion is not None
    assert adhesion.recovery_constant == adhesion.wheel_memory == 0.0
    assert found.numbers["friction_apart"] > 0.05 > 0.02 > outcome.numbers["friction_apart"]
    assert "One map does not describe this rail: " in found.summary
    assert "the axles' frictions at a place differ by " in found.summary


@pytest.mark.long
def test_friction_of_random_rails(tmp_path: Path) -> None:
    """Thirty stops, 982 pieces: the worst is a place where one axle alone slid for a moment."""
    draw, errors = np.random.default_rng(1), list[float]()
    for k in range(30):
        speed, (first, second) = draw.uniform(40, 120), np.exp(draw.uniform(np.log(0.04), np.log(0.15), 2))
        change, name = draw.uniform(60, 200), draw.choice(["adhesion_brake", "adhesion_valves"])
        case = load_case(name).with_changes({
            "motion.speed": f"{speed} km/h",
            "motion.stop_speed": "5 m/s",
            "time.duration": "25 s",
            "brake.demand": [[0.0, 0.0], [0.1, "3.8 bar"]],
        })  # fmt: skip
        rail = case.adhesion.rail.model_dump()  # type: ignore[union-attr]
        one, two = ({**rail, "friction": {**rail["friction"], "mu_0": mu}} for mu in (first, second))
        changes = {"adhesion.rail": one, "adhesion.piece": [{"distance": f"{change} m", "rail": two}]}
        export(simulate(track_case(case.with_changes(changes))).isel(time=slice(None, None, 5)), tmp_path / f"{k}.csv")
        found = reconstruct(case, read_stop(tmp_path / f"{k}.csv", case), 10.0)
        places = found["distance"].to_numpy()
        away = (abs(places - change) > 10.0) & (found["measured"].to_numpy() > 0.0)
        errors += abs(found["friction"] / np.where(places < change, first, second) - 1.0).to_numpy()[away].tolist()
    assert len(errors) > 900
    assert np.median(errors) < 0.004
    assert np.percentile(errors, 95) < 0.014
    assert max(errors) < 0.042


@pytest.mark.slow
def test_a_wrong_radius_of_the_wheels_is_no_slide(case: Case, log: StopLog) -> None:
    """4 % would be a slip of every sample: a dry rail would pass for one as slippery as the brake needs."""
    still = {name: np.concatenate([value[:1].repeat(10, axis=0), value])
             for name in ("train_speed", "axle_speed", "pressure") for value in (getattr(log, name),)}  # fmt: skip
    still["pressure"][:10] = 0.0
    before = replace(log, time=np.concatenate([log.time[0] + np.arange(-10, 0) * 0.05, log.time]), **still)
    with pytest.raises(
        ResultsError, match=r"wheelset_2: before the brake acts its circumference runs 4 % slower .*by the log"
    ):
        reconstruct(case, replace(before, axle_speed=before.axle_speed * [1.0, 0.96]), 10.0)
    found = reconstruct(case, replace(before, axle_speed=before.axle_speed * [0.995, 1.005]), 10.0)
    np.testing.assert_allclose(found["friction"].mean(), reconstruct(case, before, 10.0)["friction"].mean(), rtol=0.01)


@pytest.mark.slow
def test_noise_of_measured_speeds_hardly_counts(case: Case, log: StopLog) -> None:
    """0.5 km/h at the circumference: by differences of single samples the force would be off by three times itself."""
    noise = np.random.default_rng(5).normal(0.0, 0.5 / 3.6 / 0.46, log.axle_speed.shape)
    noisy = StopLog(log.file, log.time, log.train_speed, log.axles, log.axle_speed + noise, log.pressure)
    clean = reconstruct(case, log, 10.0)
    other = reconstruct(case, noisy, 10.0).interp(distance=clean["distance"])
    away = abs(clean["distance"].to_numpy() - CHANGE) > 10.0
    ratio = (other["friction"] / clean["friction"]).to_numpy()[away]
    assert abs(np.nanmean(ratio) - 1.0) < 0.01
    assert np.nanstd(ratio) < 0.05


@pytest.mark.slow
def test_the_stop_on_the_reconstructed_rail_is_the_measured_one(outcome: Outcome[xr.Dataset], tmp_path: Path) -> None:
    numbers = outcome.numbers
    assert numbers["status"] == "stopped"
    assert abs(numbers["distance_difference"]) < 0.005
    assert numbers["speed_difference_rms_kmh"] < 0.5
    quantities = ReconstructionStudy.quantities
    assert unexplained(quantities, numbers) == []
    assert unreported(quantities, numbers) == []
    written = {path.relative_to(tmp_path).as_posix() for path in outcome.write(tmp_path)}
    assert {"case.toml", "adhesion_map.csv", "figures/rail.png", "figures/stop.png"} <= written
    again = load_case(str(tmp_path / "case.toml"))
    assert again.rig_control is not None
    assert again.adhesion is not None
    assert len(again.adhesion.piece) == numbers["pieces"] - 1
    text = 'base = "adhesion_brake"\n[adhesion]\nrail = "low"\nfile = "adhesion_map.csv"\n'
    from_file = case_from_toml(text, folder=tmp_path).adhesion
    assert from_file is not None
    assert from_file.blend == pytest.approx(again.adhesion.blend)
    assert [piece.distance for piece in from_file.piece] == pytest.approx([p.distance for p in again.adhesion.piece])
    friction = [[piece.rail.friction.mu_0 for piece in rail.piece] for rail in (from_file, again.adhesion)]
    assert friction[0] == pytest.approx(friction[1], rel=1e-5)  # digits of the file


@pytest.mark.slow
def test_where_no_axle_slides_nothing_is_found(case: Case, log: StopLog) -> None:
    rolling = np.repeat(log.train_speed[:, None] / 0.46, 2, axis=1)
    with pytest.raises(ResultsError, match="no axle slid"):
        reconstruct(case, StopLog(log.file, log.time, log.train_speed, log.axles, rolling, log.pressure), 10.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("train_speed [m/s]", "speed [m/s]"), r"no column 'train_speed \[m/s\]'; there are time"),
        (("train_speed [m/s]", "train_speed"), r"train_speed has no unit; write 'train_speed \[m/s\]'"),
        (("train_speed [m/s]", "train_speed [bar]"), r"train_speed \[bar\] is no unit of it"),
        (("\n0.1,", "\n0.05,"), "time: 0.05 s follows 0.05 s: not later"),
        (("\n0.1,", "\n0.9,"), "time: 0.15 s follows 0.9 s: not later"),
        ((",30,1\n", ",30,-2\n"), r"wheelset_2.cylinder_pressure: -2 bar at 0 s; allowed: at least -0.1 bar"),
    ],
)
def test_a_log_that_is_none_is_refused_in_a_line(
    case: Case, tmp_path: Path, change: tuple[str, str], message: str
) -> None:
    heads = ["time [s]", "train_speed [m/s]"]
    for axle in ("wheelset_1", "wheelset_2"):
        heads += [f"{axle}.axle_speed [km/h]", f"{axle}.cylinder_pressure [bar]"]
    lines = [",".join(heads), *(f"{0.05 * k:g},10,30,1,30,1" for k in range(8))]
    file = tmp_path / "stop.csv"
    file.write_text("\n".join(lines) + "\n")
    stop = read_stop(file, case)
    assert stop.axle_speed[0, 0] == pytest.approx(30.0 / 3.6 / case.vehicle.data.wheel.radius)
    assert stop.pressure[0, 0] == pytest.approx(1e5)
    file.write_text(file.read_text().replace(*change, 1))
    with pytest.raises(ResultsError, match=message):
        read_stop(file, case)


def test_an_axle_that_does_not_turn_is_refused_in_a_line(case: Case, tmp_path: Path) -> None:
    """At no time, and before the brake acts: of which no radius follows."""
    file = tmp_path / "stop.csv"
    heads = "time [s],train_speed [m/s]," + ",".join(
        f"wheelset_{k}.axle_speed [rad/s],wheelset_{k}.cylinder_pressure [bar]" for k in (1, 2)
    )
    for last, message in ((0, "wheelset_1.axle_speed: 0 in all rows"), (20, "by the log the axle does not turn")):
        rows = [f"{0.05 * k:g},10,{last if k == 7 else 0},0,21,0" for k in range(8)]
        file.write_text("\n".join([heads, *rows]) + "\n")
        with pytest.raises(ResultsError, match=message):
            reconstruct(case, read_stop(file, case), 10.0)


@pytest.mark.parametrize(("name", "said"), [("none.csv", "no such file"), ("stop.csv", "no column 'time [s]'")])
def test_the_command_refuses_a_log_in_a_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], name: str, said: str
) -> None:
    (tmp_path / "stop.csv").write_text("t,v\n0,1\n1,1\n")
    monkeypatch.setattr(
        "sys.argv", ["rollerrig", "reconstruct", "adhesion_brake", str(tmp_path / name), "--out", str(tmp_path / "x")]
    )
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert said in error


def test_a_case_whose_pressures_do_not_say_the_force_is_refused(case: Case) -> None:
    with pytest.raises(ConfigError, match=r"brake.electrodynamic: there; allowed: none"):
        check_case(load_case("adhesion_sanding"))
    with pytest.raises(ConfigError, match="adhesion: missing"):
        check_case(track_case(case).with_changes({"adhesion": None}))
