"""Electrodynamic brake with blending, track brake, sand and limited drives in runs: on the rig and on its track."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from rollerrig import ConfigError, load_case, simulate
from rollerrig.config import Case, case_from_toml
from rollerrig.study.runs.adhesion import track_case

RADIUS = 0.46  # of the wheels of vehicle 1 [m]
MACHINE = {"largest_force": "6 kN", "largest_power": "150 kW", "blending_delay": "0.1 s"}


def case_with(duration: str = "5 s", **changes: object) -> Case:
    return load_case("adhesion_brake").with_changes({"time.duration": duration, **changes})


def both(case: Case) -> dict[str, xr.Dataset]:
    return {"rig": simulate(case), "track": simulate(track_case(case))}


@pytest.fixture(scope="module")
def blended() -> dict[str, xr.Dataset]:
    """On a rail that bears the whole brake."""
    return both(case_with(**{"adhesion.rail": "dry", "brake.electrodynamic": MACHINE}))


@pytest.fixture(scope="module")
def magnets() -> dict[str, xr.Dataset]:
    demand = [[0.0, 0.0], [0.5, 0.0], [0.501, 1.0]]
    return both(case_with(**{"adhesion.rail": "dry", "track_brake": {"demand": demand}}))


@pytest.fixture(scope="module")
def sanded() -> dict[str, xr.Dataset]:
    return both(case_with("6 s", sanding={}))


@pytest.mark.parametrize("support", ["rig", "track"])
def test_motor_and_friction_brake_give_what_is_asked(blended: dict[str, xr.Dataset], support: str) -> None:
    """The control valve follows 0.15 s late, in which a motor of constant power gains 0.6 % of its 40 %."""
    run = blended[support].sel(time=slice(4.6, None))
    total = -(run["brake_torque"] + run["electrodynamic_torque"])
    assert np.allclose(total, run["demanded_brake_torque"], rtol=3e-3)
    by_motor = -run["electrodynamic_torque"] / run["demanded_brake_torque"]
    assert 0.2 < float(by_motor.min()) < float(by_motor.max()) < 0.8, "both of them brake"
    power = run["electrodynamic_torque"] * run["axle_speed"]
    force = run["electrodynamic_torque"] / RADIUS
    assert float(-power.min()) <= 150e3 * (1 + 1e-3) or float(-force.min()) <= 6e3 * (1 + 1e-9)


@pytest.mark.parametrize("support", ["rig", "track"])
def test_the_motor_only_takes_energy_and_the_audit_closes(blended: dict[str, xr.Dataset], support: str) -> None:
    run = blended[support]
    assert float((run["electrodynamic_torque"] * run["axle_speed"]).max()) <= 0.0
    assert float(run["energy_work_of_torque"][-1]) < -1e5
    assert run.attrs["energy_relative_residual"] < 1e-6


def test_the_rig_brakes_by_motor_as_the_track_does(blended: dict[str, xr.Dataset]) -> None:
    rig, track = blended["rig"].isel(time=-1), blended["track"].isel(time=-1)
    assert float(rig["train_distance"]) == pytest.approx(float(track["train_distance"]), rel=5e-3)
    for name in ("electrodynamic_torque", "brake_torque"):
        assert rig[name].to_numpy() == pytest.approx(track[name].to_numpy(), rel=0.02)


def test_a_motor_on_one_axle_leaves_the_other_to_friction() -> None:
    run = simulate(case_with("2.5 s", **{"brake.electrodynamic": {**MACHINE, "axles": ["wheelset_2"]}}))
    assert float(abs(run["electrodynamic_torque"].sel(axle="wheelset_1")).max()) == 0.0
    last = run.isel(time=-1)
    assert float(last["electrodynamic_torque"].sel(axle="wheelset_2")) < -1e3
    assert float(last["cylinder_pressure"].sel(axle="wheelset_2")) < float(
        last["cylinder_pressure"].sel(axle="wheelset_1")
    )


def test_on_a_slide_the_motor_gives_way_as_the_case_says() -> None:
    least = {}
    for reaction in ("keep", "switch_off"):
        machine = {**MACHINE, "on_slide": reaction}
        run = simulate(case_with("5 s", **{"brake.electrodynamic": machine}))
        assert bool((run["valve"] == 2).any()), "the axles slid"
        least[reaction] = float(-run["electrodynamic_torque"].isel(time=-1).max())
    assert least["switch_off"] == 0.0
    assert least["keep"] > 1e3


def test_wheel_slip_control_keeps_axles_turning_that_motors_brake_without_dump_valves() -> None:
    """From 60 km/h on `low`: a motor that gives no way lets its axle slide until its characteristic ends."""
    motors = {"largest_force": "20 kN", "largest_power": "1 MW", "fade_from": "5 km/h", "fade_to": "3 km/h"}
    least, slowed = {}, {}
    for reaction in ("keep", "slip_control"):
        changes = {"brake.electrodynamic": {**motors, "on_slide": reaction}, "slide_protection": None}
        changes |= {"motion.speed": "60 km/h", "wheel_slip_control": None if reaction == "keep" else {}}
        run = simulate(track_case(case_with("6 s", **changes)))
        rolls = run.where(run["train_speed"] > 3.0)
        least[reaction] = float((RADIUS * rolls["axle_speed"] / rolls["train_speed"]).min())
        slowed[reaction] = float(run["train_speed"][0] - run["train_speed"][-1])
    assert least["keep"] < 0.05
    assert least["slip_control"] > 0.7
    assert slowed["slip_control"] > 1.3 * slowed["keep"]


@pytest.mark.parametrize("support", ["rig", "track"])
def test_a_track_brake_takes_the_energy_of_its_force(magnets: dict[str, xr.Dataset], support: str) -> None:
    """F(v) of the law, by hand, and the work that it does: the trapezoid over 10 ms of outputs, single precision."""
    run = magnets[support]
    v, force = run["train_speed"].to_numpy(), run["track_brake_force"].to_numpy()
    full = run["time"].to_numpy() > 1.6
    wanted = 160e3 * 0.2 * (0.65 * np.exp(-0.1 * v) + 0.35)
    assert force[full] == pytest.approx(wanted[full], rel=1e-4)
    assert (force[run["time"].to_numpy() < 0.99] == 0.0).all()
    work = np.trapezoid(force * v, run["time"].to_numpy())
    assert float(run["track_brake_energy"][-1]) == pytest.approx(work, rel=1e-3)
    assert run.attrs["energy_relative_residual"] < 1e-6


def test_a_track_brake_slows_rig_and_track_alike(magnets: dict[str, xr.Dataset]) -> None:
    ends = {name: run.isel(time=-1) for name, run in magnets.items()}
    for name in ("train_distance", "train_speed", "track_brake_energy"):
        assert float(ends["rig"][name]) == pytest.approx(float(ends["track"][name]), rel=5e-3)


def test_on_track_momentum_is_kept_with_a_track_brake(magnets: dict[str, xr.Dataset]) -> None:
    """M v' = sum T - F: the rails' forces and the magnets' slow the train, rotating masses apart."""
    run = magnets["track"]
    t = run["time"].to_numpy()
    mass = float(run["vertical_force"].isel(time=0).sum()) / 9.81
    force = run["contact_force"].sum("axle").to_numpy() - run["track_brake_force"].to_numpy()
    lost = mass * float(run["train_speed"][-1] - run["train_speed"][0])
    assert lost == pytest.approx(np.trapezoid(force, t), rel=5e-3)


@pytest.mark.parametrize("support", ["rig", "track"])
def test_the_axle_behind_finds_what_the_sanding_axle_leaves(sanded: dict[str, xr.Dataset], support: str) -> None:
    run = sanded[support]
    first, second = (run["sand"].isel(axle=i).to_numpy() for i in (0, 1))
    flow = np.diff(run["sand_used"].to_numpy())
    flowing = np.flatnonzero(flow > 0.9 * flow.max())
    assert len(flowing) > 100
    steady = flowing[20:]  # rolled over since by both
    speed = run["train_speed"].to_numpy()
    assert first[steady] == pytest.approx(0.01 / speed[steady], rel=0.02)
    assert np.median(second[steady] / first[steady]) == pytest.approx(0.7, rel=0.02)
    assert run.attrs["energy_relative_residual"] < 2e-6


def test_sand_raises_adhesion_on_rig_and_track_alike(sanded: dict[str, xr.Dataset]) -> None:
    bare = simulate(track_case(case_with("6 s")))
    speeds = {name: float(run["train_speed"][-1]) for name, run in sanded.items()}
    assert speeds["track"] < float(bare["train_speed"][-1]) - 1.0
    assert speeds["rig"] == pytest.approx(speeds["track"], abs=0.3)


def test_a_drive_tells_how_long_each_of_its_limits_acted() -> None:
    limits = {"largest_power": "100 kW", "largest_torque": "6 kN m"}
    run = simulate(case_with("3 s", **{"rig_control.motor": limits}))
    last = run.isel(time=-1)
    assert float(abs(run["roller_power"]).max()) < 102e3  # the lag of the torque loop behind the limit
    assert float(abs(run["demanded_roller_power"]).max()) > 110e3
    assert float(last["drive_power_limited"].min()) > 0.1
    assert float(last["drive_speed_limited"].max()) == 0.0
    assert (
        f"the roller drives met their limit of power for {float(last['drive_power_limited'].max()):.3g} s"
        in run.attrs["warnings"]
    )


def test_unhindered_drives_are_not_worth_a_word(blended: dict[str, xr.Dataset]) -> None:
    run = blended["rig"]
    assert run.attrs["warnings"] == ""
    given, wanted = run["roller_torque"].to_numpy()[1:], run["roller_command"].to_numpy()[1:]
    assert np.abs(given - wanted).max() < 0.2 * np.abs(wanted).max(), "but for the lag of the loop"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"brake.electrodynamic": {"largest_force": -1.0}}, "brake.electrodynamic.largest_force: -1"),
        (
            {"brake.electrodynamic": {"fade_from": "5 km/h", "fade_to": "8 km/h"}},
            "brake.electrodynamic.fade_to: '8 km/h'; allowed: below fade_from, 1.38889 m/s",
        ),
        (
            {"brake.electrodynamic": {"largest_power": "20 kW"}},
            "this curve crosses the fading at 1.33 m/s",
        ),
        (
            {"brake.electrodynamic": {"kind": "table", "forces": [[10.0, 1e4], [5.0, 1e4]]}},
            "brake.electrodynamic.forces",
        ),
        ({"brake.electrodynamic": {"axles": ["wheelset_3"]}}, "allowed: wheelset_1, wheelset_2; did you mean"),
        (
            {"brake.electrodynamic": {"blending_delay": "100.5 ms"}},
            "brake.electrodynamic.blending_delay: 100.5 ms; allowed",
        ),
        (
            {"brake.electrodynamic": {}, "brake.by_traction_motors": True, "traction": {}},
            "brake.electrodynamic: a table; allowed without brake.by_traction_motors",
        ),
        ({"track_brake": {"demand": [[0.0, 0.0], [1.0, 1.0]], "attraction": -1.0}}, "track_brake.attraction: -1"),
        ({"track_brake": {"demand": [[0.0, 0.0], [1.0, 1.5]]}}, "track_brake.demand"),
        (
            {"track_brake": {"demand": [[0.0, 0.0], [1.0, 1.0]]}, "adhesion": None, "rig_control": None},
            "track_brake: a table; allowed on rollers with [rig_control]",
        ),
        ({"sanding": {}, "adhesion": None}, "sanding: a table; allowed only with [adhesion], the rail that it covers"),
        ({"sanding": {}, "slide_protection": None}, "sanding.start: 'on_slide'; allowed with [slide_protection]"),
        ({"sanding": {"flow": -0.01}}, "sanding.flow: -0.01"),
        ({"sanding": {"axles": ["wheelset_9"]}}, "sanding.axles: 'wheelset_9'; allowed: wheelset_1, wheelset_2"),
        (
            {"sanding": {"start": {"kind": "from_distance", "begin": "50 m", "end": "40 m"}}},
            "sanding.start.end: '40 m'; allowed: beyond begin, 50 m",
        ),
    ],
)
def test_what_no_machine_is_is_refused_by_name(changes: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        case_with(**changes)
    assert message in str(caught.value)


def test_cases_with_the_machines_are_written_as_they_are_read() -> None:
    demand = [[0.0, 0.0], [0.5, 1.0]]
    case = case_with(**{"brake.electrodynamic": MACHINE, "track_brake": {"demand": demand}, "sanding": {}})
    assert case_from_toml(case.to_toml()) == case
