"""A brake test with dump valves that take time and a reservoir that can run out."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from rollerrig import ConfigError, _core, load_case, simulate
from rollerrig.config import Case, case_from_toml
from rollerrig.interfaces.plant import assembled_model

AMBIENT = 101325.0


def braked(duration: str = "8 s", **air: object) -> Case:
    changes = {"brake.air": {"kind": "reservoir", **air}, "time.duration": duration}
    return load_case("adhesion_brake").with_changes(changes)


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return simulate(braked())


def test_air_is_conserved_over_a_run(run: xr.Dataset) -> None:
    """(A13): what the main pipe gave is in the volumes or went out; to round-off of the single precision of results."""
    assert_air_is_conserved(run, ["wheelset_1"])


def assert_air_is_conserved(run: xr.Dataset, one_of_each: list[str], pipe_volume: float = 0.0) -> None:
    """Over all reservoirs, of each of which one axle is named; volume of the pipe of one axle [m^3]."""
    pressure = run["reservoir_pressure"].sel(axle=one_of_each)
    in_reservoirs = 0.1 * (pressure - pressure[0]).sum("axle") / AMBIENT
    in_cylinders = (5e-3 * run["cylinder_pressure"] + pipe_volume * run["pipe_pressure"]).sum("axle") / AMBIENT
    balance = run["main_pipe_air"] - in_reservoirs - in_cylinders - run["exhausted_air"].sum("axle")
    scale = float(run["air"].sum("axle")[-1])
    assert scale > 0.05, "some air was used"
    assert float(abs(balance).max()) < 1e-6 * scale


def test_valves_move_one_dead_time_after_their_command(run: xr.Dataset) -> None:
    """20 ms: two outputs of 10 ms."""
    wanted, moved = run["valve"].isel(axle=0) == 2, run["outlet_open"].isel(axle=0) == 1
    commanded = np.flatnonzero(np.diff(wanted.to_numpy().astype(int)) == 1)
    opened = np.flatnonzero(np.diff(moved.to_numpy().astype(int)) == 1)
    assert len(opened) >= 3
    for index in opened:
        assert index - commanded[commanded <= index][-1] in (1, 2)


def test_a_small_reservoir_that_is_not_fed_runs_out(run: xr.Dataset) -> None:
    small = simulate(braked(reservoir_volume="20 l", charging_conductance=0.0))
    assert float(small["main_pipe_air"][-1]) == 0.0
    assert (np.diff(small["reservoir_pressure"], axis=0) <= 1e-3).all()
    assert float(small["reservoir_pressure"][-1, 0]) < 0.75 * float(run["reservoir_pressure"][-1, 0])


TRAIN = {"positions": [0.0, 2.56, 19.0, 21.56], "under_test": [3, 4]}


def train(**air: object) -> xr.Dataset:
    """A coach whose rear bogie is under test; its reservoirs are not fed."""
    return simulate(braked("5 s", charging_conductance=0.0, **air).with_changes({"train.axles": TRAIN}))


@pytest.fixture(scope="module")
def by_bogie() -> xr.Dataset:
    return train(axles_per_reservoir=2)


def test_each_bogie_has_its_own_reservoir_and_air_is_conserved(by_bogie: xr.Dataset) -> None:
    """Counted from the front of the train, wherever the axles stand in the model's lists."""
    pressure = by_bogie["reservoir_pressure"]
    assert list(pressure["axle"].to_numpy()) == ["wheelset_1", "wheelset_2", "axle_1", "axle_2"]
    assert np.array_equal(pressure.sel(axle="wheelset_1"), pressure.sel(axle="wheelset_2"))
    assert np.array_equal(pressure.sel(axle="axle_1"), pressure.sel(axle="axle_2"))
    assert float(abs(pressure.sel(axle="wheelset_1") - pressure.sel(axle="axle_1")).max()) > 1e3
    assert_air_is_conserved(by_bogie, ["wheelset_1", "axle_1"])
    for bogie in (["wheelset_1", "wheelset_2"], ["axle_1", "axle_2"]):  # not fed: what its cylinders took it has lost
        lost = 0.1 * (pressure[0] - pressure[-1]).sel(axle=bogie[0]) / AMBIENT
        assert float(lost) == pytest.approx(float(by_bogie["air"][-1].sel(axle=bogie).sum()), rel=1e-6)


def test_one_reservoir_for_all_is_what_the_absent_key_means(by_bogie: xr.Dataset) -> None:
    shared, four = train(), train(axles_per_reservoir=4)
    for name in ("reservoir_pressure", "cylinder_pressure", "train_speed"):
        assert np.array_equal(shared[name].to_numpy(), four[name].to_numpy())
    assert float(shared["reservoir_pressure"][-1, 0]) < float(by_bogie["reservoir_pressure"][-1].min())


PIPE = {"length": "4 m", "diameter": "16 mm"}
PIPE_VOLUME = np.pi / 4.0 * 0.016**2 * 4.0


@pytest.fixture(scope="module")
def piped() -> xr.Dataset:
    return train(axles_per_reservoir=2, pipe=PIPE)


def test_a_bogie_s_cylinders_share_a_relay_valve_and_its_pipes(piped: xr.Dataset, by_bogie: xr.Dataset) -> None:
    pressure = piped["pipe_pressure"]
    assert pressure.attrs["units"] == "Pa"
    assert np.array_equal(pressure.sel(axle="wheelset_1"), pressure.sel(axle="wheelset_2"))
    assert float(abs(pressure.sel(axle="wheelset_1") - pressure.sel(axle="axle_1")).max()) > 1e3
    assert_air_is_conserved(piped, ["wheelset_1", "axle_1"], PIPE_VOLUME)
    assert bool((piped["valve"] == 2).any()), "the axles slid"
    assert float(pressure.max()) == pytest.approx(3.8e5, rel=0.02)
    assert not by_bogie["pipe_pressure"].any()


def test_a_longer_pipe_lets_a_vented_cylinder_fill_more_slowly() -> None:
    """The control valve asks for all at once; what is left is the pipe."""

    def until(length: str) -> float:
        changes = {"adhesion.rail": "dry", "brake.application_rate": "1000 bar/s", "brake.follow_rate": "1000 1/s"}
        run = simulate(braked("2 s", pipe={"length": length, "diameter": "12 mm"}).with_changes(changes))
        filled = run["cylinder_pressure"].sel(axle="wheelset_1").to_numpy() > 0.95 * 3.8e5
        return float(run["time"][int(np.argmax(filled))])

    times = [until(length) for length in ("2 m", "8 m", "32 m")]
    assert times[0] < times[1] - 0.02 < times[2] - 0.04


def test_a_plant_that_is_saved_goes_on_with_the_pressure_in_its_pipes() -> None:
    model = assembled_model(braked("3 s", pipe=PIPE).with_changes({"time.output_step": "1 ms"}))
    plant, other = _core.Plant(model), _core.Plant(model)
    for one in (plant, other):
        assert one.start() == _core.status_codes["ok"]
    plant.advance(1.2)
    other.restore(plant.save())
    names = [plant.find(f"wheelset_1.{name}") for name in ("pipe_pressure", "cylinder_pressure")]
    assert plant.get(names[0]) > plant.get(names[1]) > 1e4
    for one in (plant, other):
        one.advance(1.5)
    assert plant.values(names).tolist() == other.values(names).tolist()


@pytest.mark.parametrize(
    ("air", "message"),
    [
        ({"vent_conductance": -1e-7}, "brake.air.vent_conductance: -1e-07; allowed: a number in m^3/(s Pa) or a text"),
        ({"fill_conductance": 0.0}, "brake.air.fill_conductance: 0"),
        ({"reservoir_volume": 0.0}, "brake.air.reservoir_volume: 0"),
        ({"axles_per_reservoir": 0}, "brake.air.axles_per_reservoir: 0"),
        ({"axles_per_reservoir": 33}, "brake.air.axles_per_reservoir: 33"),
        (
            {"reservoir_pressure": 0.0},
            "brake.air.reservoir_pressure: 0 bar; a reservoir that is empty from the start brakes nothing",
        ),
        (
            {"main_pipe_pressure": 0.0},
            "brake.air.main_pipe_pressure: 0 bar; a reservoir that is empty from the start brakes nothing",
        ),
        (
            {"opening_time": "20.5 ms"},
            "brake.air.opening_time: 20.5 ms; allowed: a multiple of time.sampling_step, 1 ms; the nearest is 20 ms",
        ),
        ({"pipe": {"length": 0.0}}, "brake.air.pipe.length: 0"),
        ({"pipe": {"length": "2 km"}}, "brake.air.pipe.length: '2 km'"),
        ({"pipe": {"diameter": "12 mm"}}, "brake.air.pipe.length: missing"),
        ({"pipe": {"length": "2 m", "diameter": "2 m"}}, "brake.air.pipe.diameter: '2 m'"),
        (
            {"pipe": {"length": "0.2 m", "diameter": "12 mm"}},
            "brake.air.pipe.length: 0.2 m; a volume of 22.6 cm^3 is filled within a sampling step; allowed: at least 0.345 m",
        ),
        (
            {"axles_per_reservoir": 3, "pipe": {"length": "4 m"}},
            "brake.air.pipe.axles_per_relay_valve: 2; allowed: a divisor of brake.air.axles_per_reservoir, 3",
        ),
        ({"critical_ratio": 1.0}, "brake.air.critical_ratio: 1"),
        ({"fill_rate": 6.0}, "brake.air.fill_rate"),
    ],
)
def test_what_no_brake_has_is_refused_by_name(air: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        braked(**air)
    assert message in str(caught.value)


def test_a_conductance_may_be_written_as_data_sheets_do() -> None:
    case = braked(fill_conductance="20 dm^3/(s bar)")
    assert case.brake is not None
    assert case.brake.air.kind == "reservoir"
    assert case.brake.air.fill_conductance == pytest.approx(2e-7, rel=1e-15)
    assert case_from_toml(case.to_toml()) == case
