"""Faults of single axles: what acts on the axle that has one, and on the others as before."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from rollerrig import ConfigError, load_case, simulate
from rollerrig.analysis.slide_statistics import test_record as record_of
from rollerrig.cli.describe import actuator_lines
from rollerrig.config import Case
from rollerrig.interfaces.plant import assembled_model
from rollerrig.study.run import RunStudy
from rollerrig.study.runs.adhesion import track_case

FAULTY, SOUND = "wheelset_1", "wheelset_2"


def stop(rail: str = "dry", duration: str = "3 s", **changes: object) -> Case:
    """On track, from 40 km/h, the demand at once."""
    demand = [[0.0, 0.0], [0.01, 3.8e5]]
    given = {"motion.speed": "40 km/h", "time.duration": duration, "adhesion.rail": rail, "brake.demand": demand}
    return track_case(load_case("adhesion_valves").with_changes({**given, **changes}))


def with_fault(kind: str, case: Case | None = None, **more: object) -> Case:
    return (case or stop()).with_changes({"fault": [{"axle": FAULTY, "kind": kind, **more}]})


@pytest.fixture(scope="module")
def slide() -> Case:
    return stop("low", "4 s")


VALVES = ("valve", "inlet_open", "outlet_open", "dump_cycles")


def test_with_no_fault_the_run_is_that_of_the_built_in_brake_to_the_last_bit(slide: Case) -> None:
    """The brake unit is asked in time, as it is inside; only the reference speed of the last instant is a sample old."""
    built_in, asked = simulate(slide), simulate(with_fault("none", slide))
    assert bool((built_in["valve"] == 2).any()), "the axles slid"
    assert float(built_in["dump_cycles"].max()) > 0.0
    for name in ("train_speed", "axle_speed", "cylinder_pressure", *VALVES):
        assert np.array_equal(built_in[name], asked[name]), name
    for name in ("reference_speed", "reference_speed_error"):
        assert np.array_equal(built_in[name][:-1], asked[name][:-1])
    assert asked.attrs["energy_relative_residual"] < 1e-6


def torques(run: xr.Dataset) -> tuple[float, float]:
    """Of the axle with the fault, and of the sound one, at the end [N m]."""
    last = run["brake_torque"].isel(time=-1)
    return float(last.sel(axle=FAULTY)), float(last.sel(axle=SOUND))


@pytest.mark.parametrize(("kind", "part"), [("isolated", 0.0), ("pads", 0.8), ("never_vents", 1.0)])
def test_the_axle_brakes_by_its_part_and_the_other_as_before(kind: str, part: float) -> None:
    """On a dry rail, where no dump valve acts: torques of both axles at the same speed."""
    run = simulate(with_fault(kind))
    own, other = torques(run)
    assert other == pytest.approx(torques(simulate(with_fault("none", stop(duration="3 s"))))[1], rel=2e-2)
    assert own == pytest.approx(part * other, rel=2e-3, abs=1.0)


def test_a_fault_begins_when_it_begins() -> None:
    pressure = simulate(with_fault("isolated", begin="2 s"))["cylinder_pressure"]
    early = pressure.sel(time=slice(None, 1.9))
    assert np.allclose(early.sel(axle=FAULTY), early.sel(axle=SOUND), rtol=1e-6)
    assert float(pressure.sel(axle=FAULTY)[-1]) < 0.8 * float(pressure.sel(axle=SOUND)[-1])


def test_a_dragging_brake_never_releases(slide: Case) -> None:
    """From the first sample on, also while its dump valve vents."""
    pressure = simulate(with_fault("dragging", slide, pressure="0.7 bar"))["cylinder_pressure"]
    assert float(pressure.sel(axle=FAULTY)[1:].min()) == pytest.approx(0.7e5)
    assert float(pressure.sel(axle=SOUND)[1:].min()) < 0.1e5


def test_an_axle_whose_valve_never_vents_locks(slide: Case) -> None:
    run = simulate(with_fault("never_vents", slide))
    speed = run["axle_speed"].isel(time=-1) * 0.46 / run["train_speed"].isel(time=-1)
    assert float(speed.sel(axle=FAULTY)) < 0.05
    assert float(speed.sel(axle=SOUND)) > 0.5
    assert float(run["cylinder_pressure"].sel(axle=FAULTY).max()) > 2.5e5


def test_an_axle_without_a_speed_is_taken_for_locked_and_vented() -> None:
    """On a dry rail, whatever its wheels do; the reference is that of the others."""
    run = simulate(with_fault("silent_sensor"))
    own, other = torques(run)
    assert abs(own) < 0.2 * abs(other)
    late = run["reference_speed_error"].sel(time=slice(0.5, None))
    assert float(abs(late).max()) < 0.05


def test_a_silent_sensor_of_one_axle_of_two_ends_in_a_lock_of_the_other() -> None:
    """The only speed left is the reference, and falls with its axle by 1.6 m/s^2 until all valves fill below 5 km/h."""
    run = simulate(with_fault("silent_sensor", stop("low", "9 s")))
    last = run.isel(time=-1)
    assert float(last["axle_speed"].sel(axle=SOUND)) < 0.05 * float(last["train_speed"]) / 0.46
    assert float(last["train_speed"] - last["reference_speed"]) > 5.0
    case = with_fault("silent_sensor", stop("low", "9 s"))
    assert record_of(run, case).measures["odometer_error_m"] < -20.0


def test_an_odometer_counts_too_much_by_the_radius_of_smaller_wheels() -> None:
    """Nothing slides: the fastest axle is the reference, and turns by 1 / 0.97 too fast all the way."""
    case = with_fault("wheel_radius", factor=0.97)
    found = record_of(simulate(case), case).measures
    assert found["odometer_error_m"] == pytest.approx((1.0 / 0.97 - 1.0) * found["distance_m"], rel=0.02)
    sound = record_of(simulate(stop()), stop()).measures["odometer_error_m"]
    assert abs(sound) < 0.002 * found["distance_m"]


class Watching:
    """A slide protection of the user that remembers what it was given."""

    sample_time = 5e-3

    def __init__(self) -> None:
        self.speeds: list[Any] = []

    def step(self, measurements: dict[str, Any]) -> dict[str, Any]:
        self.speeds.append(measurements["axle_speed"])
        return {"valve": [0.0, 0.0]}


def test_a_users_protection_is_given_the_faulty_speed() -> None:
    mine = Watching()
    run = simulate(with_fault("silent_sensor", stop(duration="0.5 s")), controllers={"slide_protection": mine})
    assert run.attrs["status"] == "ok"
    given = np.array(mine.speeds)
    assert (given[:, 0] == 0.0).all()
    assert (given[1:, 1] > 20.0).all()


def test_a_users_controller_that_fails_under_a_fault_is_named() -> None:
    class Broken(Watching):
        def step(self, measurements: dict[str, Any]) -> dict[str, Any]:
            raise ZeroDivisionError("mine")

    run = simulate(with_fault("none", stop(duration="0.1 s")), controllers={"slide_protection": Broken()})
    assert run.attrs["status"] == "controller_failed"
    assert "slide_protection, controller Broken: raised ZeroDivisionError: mine" in run.attrs["status_message"]


@pytest.mark.parametrize(
    ("fault", "changes", "line"),
    [
        (
            {"axle": "wheelset_3", "kind": "isolated"},
            {},
            "fault[0].axle: 'wheelset_3'; allowed: wheelset_1, wheelset_2",
        ),
        ({"axle": FAULTY, "kind": "silent_sensor"}, {"slide_protection": None}, "allowed with [slide_protection]"),
        ({"axle": FAULTY, "kind": "isolated"}, {"brake.electrodynamic": {}}, "without brake.electrodynamic"),
        ({"axle": FAULTY, "kind": "pads", "factor": 4.0}, {}, "factor"),
        ({"axle": FAULTY, "kind": "dragging", "pressure": "0.7 m"}, {}, "pressure"),
        ({"axle": FAULTY, "kind": "broken"}, {}, "kind"),
        (
            {"axle": FAULTY, "kind": "isolated", "begin": "1 h"},
            {},
            "fault[0].begin: 3600 s; allowed: before time.duration",
        ),
    ],
)
def test_a_fault_that_cannot_be_is_refused_in_a_line(fault: dict[str, Any], changes: dict[str, Any], line: str) -> None:
    with pytest.raises(ConfigError) as error:
        stop().with_changes({**changes, "fault": [fault]})
    assert line in str(error.value)


def test_the_same_fault_of_an_axle_stands_once() -> None:
    twice = [{"axle": FAULTY, "kind": "pads", "factor": factor} for factor in (0.8, 0.9)]
    with pytest.raises(ConfigError, match=rf"fault\[1\].kind: 'pads'; allowed: once for {FAULTY}"):
        stop().with_changes({"fault": twice})


def test_a_brake_that_is_cut_off_does_not_drag() -> None:
    both = [{"axle": FAULTY, "kind": kind} for kind in ("isolated", "dragging")]
    with pytest.raises(
        ConfigError, match=rf"fault\[1\].kind: 'dragging'; allowed: one of isolated and dragging for {FAULTY}"
    ):
        stop().with_changes({"fault": both})


def test_what_is_no_run_knows_no_faults(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="fault: 1 faults; allowed in runs"):
        assembled_model(with_fault("isolated"))


def test_check_names_the_faults() -> None:
    case = with_fault("pads", stop(), factor=0.8, begin="1 s")
    assert f"fault: {FAULTY}, pads × 0.8, from 1 s on" in actuator_lines(case)


def test_a_run_says_first_what_is_at_fault() -> None:
    for case, said in (
        (with_fault("dragging", stop(duration="0.1 s")), [f"Fault: {FAULTY}, dragging at 1 bar, from 0 s on."]),
        (with_fault("none", stop(duration="0.1 s")), []),
    ):
        found = RunStudy(case).run()
        assert found is not None
        assert [line for line in found.summary.splitlines()[:1] if line.startswith("Fault")] == said
