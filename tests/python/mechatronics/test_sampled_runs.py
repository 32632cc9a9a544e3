"""Runs with actuators and controllers: against limits that are known, and what goes wrong in it."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig import ConfigError, load_case, simulate
from rollerrig.analysis.slide_statistics import test_record as record_of
from rollerrig.config import Case
from rollerrig.similitude import scale_case, similitude
from rollerrig.study.runs.adhesion import track_case

RADIUS = 0.46  # of the wheels of vehicle 1 [m]
SHORT = {"time.duration": "6 s", "contact.normal": "hertz"}  # sampling is none of the contact's


def brake_case(**changes: object) -> Case:
    return load_case("adhesion_brake").with_changes({**SHORT, **changes})


@pytest.fixture(scope="module")
def rig() -> xr.Dataset:
    return simulate(brake_case())


@pytest.fixture(scope="module")
def track() -> xr.Dataset:
    return simulate(track_case(brake_case()))


def test_the_rig_follows_the_virtual_train_and_the_track(rig: xr.Dataset, track: xr.Dataset) -> None:
    """The project's target: below 1 % of train speed RMS, the way within 2 %."""
    case = brake_case()
    found, on_track = record_of(rig, case), record_of(track, track_case(case))
    assert found.measures["tracking_rms"] < 0.01
    assert found.distance[-1] == pytest.approx(on_track.distance[-1], rel=0.02)
    assert found.measures["largest_slip"] > 0.1  # it did slide, or the test says nothing
    assert found.measures["real_sliding_largest_mps"] < 0.1 < RADIUS * 33 * 0.1  # and the rollers saw none of it


def test_slide_protection_holds_the_axles(track: xr.Dataset) -> None:
    slip = 1.0 - RADIUS * track["axle_speed"] / track["train_speed"]
    late = slip.isel(time=track["time"].to_numpy() > 4.0)
    assert 0.02 < float(late.mean()) < 0.25
    assert float(slip.max()) < 0.35
    assert int(track["dump_cycles"][-1].min()) > 2


@pytest.mark.parametrize("name", ["rig", "track"])
def test_energy_closes_with_brakes(name: str, request: pytest.FixtureRequest) -> None:
    """Brakes turn about a megajoule into heat; fourth order at 1 ms leaves 1e-6 of it."""
    run = request.getfixturevalue(name)
    assert float(run["energy_dissipated_brakes"][-1]) > 1e5
    assert run.attrs["energy_relative_residual"] < 1e-6


def test_the_creep_force_is_what_turns_the_rollers_and_the_contact_force_has_the_tilted_load_beside(
    rig: xr.Dataset,
) -> None:
    """A wheel off the crown by x feels its load along x, Q x / (R + r): no torque, no adhesion, nothing the estimate sees."""
    info, late = rr.RunInfo.of(rig), rig.sel(time=slice(2.0, None)).mean("time")
    assert info.roller_radius is not None
    loads = late["vertical_force"].to_numpy().reshape(2, 2).sum(axis=1)
    off_crown = late["longitudinal"].sel(body=rig["axle"].to_numpy()).to_numpy()
    tilted = (late["contact_force"] - late["creep_force"]).to_numpy()
    assert tilted == pytest.approx(loads * off_crown / (info.roller_radius + RADIUS), rel=0.02)
    assert np.abs(tilted).min() > 200.0  # of some 7 kN
    assert late["creep_force"].to_numpy() == pytest.approx(late["estimated_force"].to_numpy(), rel=0.01)
    used = abs(rig["creep_force"]).where(rig["brake_torque"] < -1.0) / (loads.sum() / 2)
    assert record_of(rig, brake_case()).measures["adhesion_used_mean"] == pytest.approx(float(used.mean()), rel=1e-3)


def test_on_track_momentum_is_kept(track: xr.Dataset) -> None:
    """What slows the train is the force of the rails: M v' = sum T, over the whole run."""
    mass = float(track["vertical_force"].isel(time=0).sum()) / 9.81
    impulse = float(track["contact_force"].sum("axle").integrate("time"))
    change = mass * float(track["train_speed"][-1] - track["train_speed"][0])
    assert impulse == pytest.approx(change, rel=2e-3)  # output every 10 ms, switching valves between


def test_without_degradation_rig_and_track_run_the_same_way() -> None:
    """Friction of the case on both, moderate braking: within 1 %."""
    changes = {"brake.demand": [[0.0, 0.0], [0.1, 0.0], [0.2, 2e5]], "motion.speed": "20 km/h", "time.duration": "15 s"}
    case = brake_case(**changes).model_copy(update={"adhesion": None})
    rig, track = simulate(case), simulate(track_case(case))
    for run in (rig, track):
        assert run.attrs["status"] == "stopped"
        assert int(run["dump_cycles"][-1].sum()) == 0
    assert float(rig["train_distance"][-1]) == pytest.approx(float(track["train_distance"][-1]), rel=0.01)


def test_without_control_a_sampled_run_is_the_plain_rig() -> None:
    """Brakes that are never applied, drives that are not there: the same motion as an ordinary run."""
    still = {"brake.demand": [[0.0, 0.0], [1.0, 0.0]], "time.duration": "1 s"}
    bench = brake_case(**still).model_copy(update={"adhesion": None, "rig_control": None, "slide_protection": None})
    plain = bench.model_copy(update={"brake": None}).with_changes(
        {"time.method": "exponential_rk4", "time.step": "0.5 ms"}
    )
    perturbation = {"disturbance": [{"body": "wheelset_1", "lateral": "1 mm"}]}
    a, b = simulate(bench.with_changes(perturbation)), simulate(plain.with_changes(perturbation))
    # The same method with other steps: its error at 1 ms, 4e-7 m while the wheelset strikes back into the middle.
    np.testing.assert_allclose(a["lateral"], b["lateral"], rtol=0, atol=2e-6)
    assert float(np.abs(a["lateral"] - a["lateral"][0]).max()) > 5e-4
    np.testing.assert_allclose(a["pitch_rate"], b["pitch_rate"], rtol=0, atol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("on_track", [False, True], ids=["rig", "track"])
def test_slow_wheels_cost_no_more_steps_and_stay_exact(on_track: bool) -> None:
    """Creep relaxes at 5e4 1/s and more: two and a little evaluations per millisecond, and the motion is that of 0.25 ms."""
    slow: dict[str, object] = {
        "motion.speed": "12 km/h",
        "time.duration": "10 s",
        "contact.creepage_regularisation_speed": "0.5 m/s",
        "contact.normal": "strips",  # ellipses that appear and merge are not smooth in time
    }
    slow["brake.demand"] = [[0.0, 0.0], [0.1, 0.0], [0.6, 1.2e5]]
    case = brake_case(**slow).model_copy(update={"slide_protection": None, "adhesion": None})
    alone = case.model_copy(update={"rig_control": None}).with_changes({"time.duration": "3 s"})
    case = track_case(case) if on_track else alone
    coarse, fine = simulate(case), simulate(case.with_changes({"time.sampling_step": 0.25e-3}))
    statistics = json.loads(coarse.attrs["solver_statistics"])
    assert statistics["derivative_calls"] < 2.5e3 * float(coarse["time"][-1])
    assert float(coarse["axle_speed"].min()) * RADIUS < 2.0
    both = min(coarse.sizes["time"], fine.sizes["time"])
    a, b = coarse.isel(time=slice(both)), fine.isel(time=slice(both))
    # The brake's cylinder is integrated on the same grid: its own error at 1 ms is 3e-4 of the force. A linear part that is not
    # renewed as the train slows makes errors of some per cent for some tens of steps, until a step fails.
    error = np.abs(a["contact_force"] - b["contact_force"]).to_numpy() / float(np.abs(b["contact_force"]).max())
    assert np.sqrt(np.mean(error**2)) < 5e-4
    assert error.max() < 1e-3
    assert coarse.attrs["energy_relative_residual"] < 1e-6


@pytest.mark.parametrize(
    ("method", "step"),
    [("rodas4", None), ("dormand_prince", None), ("rk4", "0.1 ms"), ("exponential_rk4", "0.5 ms")],
)
def test_the_method_of_the_case_integrates_between_the_samples(method: str, step: str | None) -> None:
    """At 1 ms the default's own error is 1e-6 of the speed; the samples, and what acts between them, are the same."""
    short = {"time.duration": "1 s", "time.output_step": "10 ms", "brake.demand": [[0.0, 0.0], [0.1, 3.8e5]]}
    default, other = (simulate(brake_case(**short, **own)) for own in ({}, {"time.method": method, "time.step": step}))
    calls = [json.loads(run.attrs["solver_statistics"])["derivative_calls"] for run in (default, other)]
    assert calls[0] < 2200
    assert calls[1] > 1.5 * calls[0]
    moved = float(np.ptp(default["axle_speed"].to_numpy()))
    assert moved > 0.3
    np.testing.assert_allclose(other["axle_speed"], default["axle_speed"], rtol=0, atol=1e-3 * moved)


def test_a_step_that_misses_the_samples_or_is_unstable_is_refused() -> None:
    with pytest.raises(
        ConfigError, match=r"time\.step: 0\.3 ms; allowed: time\.sampling_step, 1 ms, or a whole part of it"
    ):
        brake_case(**{"time.method": "exponential_rk4", "time.step": "0.3 ms"})
    slow = {
        "motion.speed": "1 km/h",
        "time.method": "rk4",
        "time.step": "1 ms",
        "contact.creepage_regularisation_speed": 0.01,
    }
    with pytest.raises(ConfigError, match=r"time\.step: 1 ms; allowed: at most"):
        simulate(brake_case(**slow))


def test_the_same_seed_gives_the_same_bytes() -> None:
    noisy = {"sensors.axles": {"counts": 4096, "jitter": 0.2, "window": 4}, "time.duration": "1.5 s"}
    first, second = simulate(brake_case(**noisy)), simulate(brake_case(**noisy))
    other = simulate(brake_case(**noisy, **{"sensors.seed": 2}))
    assert first["measured_axle_speed"].to_numpy().tobytes() == second["measured_axle_speed"].to_numpy().tobytes()
    assert not np.array_equal(first["measured_axle_speed"], other["measured_axle_speed"])


def test_anti_slip_holds_a_start() -> None:
    run = simulate(track_case(load_case("adhesion_start").with_changes({"time.duration": "5 s"})))
    slip = RADIUS * run["axle_speed"] - run["train_speed"]
    assert float(run["torque_factor"].min()) < 0.8
    assert float(slip.max()) < 3.0
    assert float(run["train_speed"][-1]) > float(run["train_speed"][0]) + 1.0


# ------------------------------------------------------------------------------------------- a user's controllers


class Feedforward:
    """The law of pure rolling and a proportional correction."""

    sample_time = 1e-3

    def step(self, measurements):
        error = measurements["virtual_speed"] - measurements["axle_speed"]
        return {"roller_torque": measurements["feed_forward"] + 4000.0 * error}


class Broken:
    sample_time = 5e-3

    def __init__(self, answer: object) -> None:
        self.answer = answer

    def step(self, measurements):
        if measurements["time"] < 0.1:
            return {"valve": [0, 0]}
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


def test_a_users_rig_controller_does_the_work() -> None:
    case = brake_case(**{"time.duration": "4 s"})
    run = simulate(case, controllers={"rig_control": Feedforward()})
    assert run.attrs["status"] == "ok"
    error = RADIUS * (run["axle_speed"] - run["virtual_speed"])
    assert float(np.abs(error).max()) < 0.5
    assert float(np.abs(run["roller_torque"]).max()) > 1000


def test_a_users_slide_protection_keeps_the_axles_turning() -> None:
    """Two lines of Python against locked wheels: on track, where nothing but the valves holds them."""

    class Simplest:
        sample_time = 5e-3

        def __init__(self) -> None:
            self.train = 0.0

        def step(self, measurements):
            fastest = RADIUS * measurements["axle_speed"].max()
            self.train = max(fastest, self.train - 0.6 * self.sample_time) if self.train else fastest
            slip = 1.0 - RADIUS * measurements["axle_speed"] / self.train
            return {"valve": np.where(slip > 0.1, 2, np.where(slip > 0.05, 1, 0))}

    case = track_case(brake_case(**{"time.duration": "8 s"}))
    held = simulate(case, controllers={"slide_protection": Simplest()})
    free = simulate(case.model_copy(update={"slide_protection": None}))
    assert held.attrs["status"] == "ok"
    assert float(held["axle_speed"].min()) * RADIUS > 15.0
    assert float(free["axle_speed"].min()) * RADIUS < 5.0  # without it they lock
    assert int(held["dump_cycles"][-1].min()) > 2


def test_the_last_row_is_of_the_last_instant() -> None:
    """Sensors, estimates and the train too; nobody outside is asked at the end."""
    asked = []

    class Listening(Feedforward):
        def step(self, measurements):
            asked.append(measurements["time"])
            return super().step(measurements)

    long = simulate(brake_case(**{"time.duration": "1 s"}), controllers={"rig_control": Feedforward()})
    short = simulate(brake_case(**{"time.duration": "0.5 s"}), controllers={"rig_control": Listening()})
    assert max(asked) == pytest.approx(0.499)
    end, same = short.isel(time=-1), long.sel(time=0.5)
    assert float(end["train_speed"]) < float(short["train_speed"][-2])
    for name in ("train_speed", "train_distance", "measured_axle_speed", "measured_load", "virtual_speed"):
        np.testing.assert_array_equal(end[name], same[name])


class Interrupting(Feedforward):
    """Ctrl-C while the user's own code runs."""

    def step(self, measurements):
        if measurements["time"] >= 0.5:
            raise KeyboardInterrupt
        return super().step(measurements)


def test_ctrl_c_keeps_what_was_computed() -> None:
    def interrupting(fraction: float, text: str) -> None:
        if fraction > 0.2:
            raise KeyboardInterrupt

    in_controller = simulate(brake_case(), controllers={"rig_control": Interrupting()})
    between = simulate(brake_case(), progress=interrupting)
    for run in (in_controller, between):
        assert run.attrs["status"] == "interrupted"
        assert 10 < run.sizes["time"] < 600
        assert np.isfinite(run["axle_speed"]).all()
    assert in_controller.sizes["time"] == 50 or in_controller.sizes["time"] == 51


@pytest.mark.parametrize("answer", [[np.nan, 0.0], [np.inf, 0.0], [[0.0, 0.0]], [0.0]])
def test_a_torque_that_is_none_ends_the_run(answer: object) -> None:
    class Bad:
        sample_time = 1e-3

        def step(self, measurements):
            return {"roller_torque": answer if measurements["time"] > 0.2 else [0.0, 0.0]}

    run = simulate(brake_case(), controllers={"rig_control": Bad()})
    assert run.attrs["status"] == "controller_failed"
    assert "rig_control, controller Bad" in run.attrs["status_message"]
    assert run.sizes["time"] == 21  # every 10 ms until then


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        ({"valve": [np.nan, 0]}, "allowed: 0 fill, 1 hold, 2 vent"),
        ({"valve": [0, 0, 0]}, "has shape (3,); needed: (2,)"),
        ({"valves": [0, 0]}, "needed: a dict with the one key 'valve'"),
        ({"valve": ["open", "shut"]}, "no number"),
        (7, "returned int"),
        (ValueError("lost the plot"), "raised ValueError: lost the plot"),
    ],
)
def test_a_broken_controller_ends_the_run_by_name(answer: object, message: str) -> None:
    run = simulate(brake_case(), controllers={"slide_protection": Broken(answer)})
    assert run.attrs["status"] == "controller_failed"
    text = run.attrs["status_message"]
    assert message in text
    assert "t = 0.1 s, slide_protection, controller Broken" in text
    assert '"axle_speed": [72.' in text
    assert run.sizes["time"] == 10 or run.sizes["time"] == 11  # results until then are kept


def test_a_controller_that_cannot_be_used_is_refused() -> None:
    with pytest.raises(
        ConfigError, match="adhesion_brake: controllers: 'wheel_slip_control'; allowed: a table of the case"
    ):
        simulate(brake_case(), controllers={"wheel_slip_control": Feedforward()})
    with pytest.raises(ConfigError, match="needed: an attribute sample_time"):
        simulate(brake_case(), controllers={"rig_control": object()})
    controller = Feedforward()
    controller.sample_time = 0.0015
    with pytest.raises(ConfigError, match=r"sample_time: 0\.0015; allowed: a multiple of time\.sampling_step"):
        simulate(brake_case(), controllers={"rig_control": controller})
    with pytest.raises(ConfigError, match=r"rig_control\.user.*'module:Class' or 'file\.py:Class'"):
        simulate(brake_case(**{"rig_control.user": "nowhere"}))
    with pytest.raises(ConfigError, match=r"rig_control\.user.*No module named"):
        simulate(brake_case(**{"rig_control.user": "no_such_module:Mine"}))


def test_the_rollers_are_protected() -> None:
    """A controller that brakes the rollers with all it has ends the test, not the rollers; drives of 20 kN m could not."""

    class Mad:
        sample_time = 1e-3

        def step(self, measurements):
            return {"roller_torque": [-1e5 for _ in measurements["axle_speed"]]}

    strong = {"largest_torque": "100 kN m", "largest_power": "10 MW"}
    run = simulate(brake_case(**{"rig_control.motor": strong}), controllers={"rig_control": Mad()})
    assert run.attrs["status"] == "rollers_protected"
    assert "rig_control.protection.slip" in run.attrs["status_message"]


def test_samples_and_delayed_commands_stand_on_their_instants() -> None:
    """Sampled every 4 ms, acting 3 ms later: the plant's own state at the sample, the torque from the very step on."""

    class Kick:
        sample_time = 4e-3

        def __init__(self) -> None:
            self.times: list[float] = []
            self.speeds: list[float] = []

        def step(self, measurements: dict[str, np.ndarray]) -> dict[str, list[float]]:
            self.times.append(measurements["time"])
            self.speeds.append(float(measurements["axle_speed"][0]))
            return {"roller_torque": [500.0 if measurements["time"] > 0.05 else 0.0] * 2}

    changes = {"time.duration": "0.1 s", "time.output_step": "1 ms", "rig_control.delay": "3 ms"}
    kick = Kick()
    run = simulate(load_case("adhesion_brake").with_changes(changes), controllers={"rig_control": kick})
    assert kick.times == pytest.approx([4e-3 * i for i in range(25)], abs=1e-12)
    at_samples = run["axle_speed"].isel(axle=0, time=slice(0, 100, 4)).to_numpy()
    np.testing.assert_allclose(kick.speeds, at_samples, rtol=1e-13)
    # first asked for at 52 ms, acting from 55 ms: what moved over the step to 56 ms
    torque = run["roller_torque"].isel(axle=0).to_numpy()
    assert np.flatnonzero(np.abs(torque) > 1e-9)[0] == 56


def test_a_step_too_long_for_the_contact_is_refused_by_name() -> None:
    """A model that keeps its material rolls on contacts 25 times as stiff for its mass; the default has no such limit."""
    model = scale_case(
        load_case("adhesion_brake"), similitude("mmu"), strategy="mmu", keep=("gravity", "material", "clock")
    )
    model = model.with_changes({"time.duration": 0.2, "time.sampling_step": 1e-3})
    with pytest.raises(ConfigError, match=r"time\.step: 1 ms; allowed: at most 0\.\d+ ms, where exponential_rk4"):
        simulate(model.with_changes({"time.method": "exponential_rk4", "time.step": 1e-3}))
    run = simulate(model)
    assert run.attrs["status"] == "ok"
