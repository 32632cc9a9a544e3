"""The train behind the bogie: axles that are only simulated, on a rig and on track."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from rollerrig import ConfigError, load_case, scale, simulate
from rollerrig.analysis.rig_limits import friction_used
from rollerrig.analysis.slide_statistics import slip
from rollerrig.analysis.slide_statistics import test_record as record_of
from rollerrig.config import Case, load_programme
from rollerrig.study.envelope import EnvelopeStudy
from rollerrig.study.lateral import LateralStudy
from rollerrig.study.limitations import limitations
from rollerrig.study.runs.adhesion import track_case
from rollerrig.study.runs.control import run_numbers
from rollerrig.study.runs.wsp import check_case

RADIUS, SPIN_INERTIA = 0.46, 112.0  # vehicle 1
COACH = {"positions": [0.0, 2.56, 19.0, 21.56], "under_test": [1, 2]}
SIGNAL_SPEED = 250.0
FOUR = {"train.axles": COACH, "train.brake_signal_speed": SIGNAL_SPEED, "time.duration": "6 s"}


def case_of(**changes: object) -> Case:
    return load_case("adhesion_brake").with_changes({**FOUR, **changes})


@pytest.fixture(scope="module")
def rig() -> xr.Dataset:
    return simulate(case_of())


@pytest.fixture(scope="module")
def track() -> xr.Dataset:
    return simulate(track_case(case_of()))


@pytest.mark.parametrize("name", ["rig", "track"])
def test_every_axle_of_the_train_is_recorded_and_protected(name: str, request: pytest.FixtureRequest) -> None:
    run = request.getfixturevalue(name)
    assert list(run["axle"].to_numpy()) == ["wheelset_1", "wheelset_2", "axle_3", "axle_4"]
    assert run["dump_cycles"].isel(time=-1).min() > 2
    slip = 1.0 - RADIUS * run["axle_speed"] / run["train_speed"]
    late = slip.isel(time=run["time"].to_numpy() > 4.0).mean("time")
    assert (late > 0.01).all()
    assert (late < 0.3).all()


def test_rig_and_track_brake_the_same_train(rig: xr.Dataset, track: xr.Dataset) -> None:
    found, on_track = record_of(rig, case_of()), record_of(track, track_case(case_of()))
    assert found.distance[-1] == pytest.approx(on_track.distance[-1], rel=0.005)


@pytest.mark.parametrize("name", ["rig", "track"])
def test_the_energy_of_the_simulated_axles_closes(name: str, request: pytest.FixtureRequest) -> None:
    """Change of 1/2 J w^2 = work of brake and motor - work on the train - slip: at every output, of what was dissipated."""
    run = request.getfixturevalue(name).sel(axle=["axle_3", "axle_4"])
    gained = 0.5 * SPIN_INERTIA * (run["axle_speed"] ** 2 - run["axle_speed"].isel(time=0) ** 2)
    rest = run["axle_work"] - run["work_on_train"] - run["slip_dissipation"] - gained
    assert float(abs(run["axle_work"]).max()) > 1e5
    assert float(abs(rest).max()) < 1e-7 * float(abs(run["axle_work"]).max())
    assert float(run["slip_dissipation"].isel(time=-1).min()) > 0.0


def test_force_of_all_axles_brakes_the_virtual_train(rig: xr.Dataset) -> None:
    """M v' = sum T, whichever axles are on rollers; the simulated ones' forces arrive one sample later."""
    lost = float(rig["train_speed"][0] - rig["train_speed"][-1])
    forces = rig["virtual_force"].sum("axle")
    mass = 2.0 * float(rig["vertical_force"].isel(time=0).sum()) / 9.81  # four axles, two of them on rollers
    assert mass * lost == pytest.approx(-float(forces.integrate("time")), rel=0.01)  # outputs every 10 ms
    assert lost > 1.0


@pytest.mark.parametrize("name", ["rig", "track"])
def test_the_brake_demand_arrives_by_distance_over_signal_speed(name: str, request: pytest.FixtureRequest) -> None:
    """Asked torque of an axle over time is that of the first axle, later by its distance over the signal's speed."""
    run = request.getfixturevalue(name)
    asked = run["demanded_brake_torque"]
    time = run["time"].to_numpy()
    half = 0.5 * float(asked.max())
    rising = time < 1.0

    def passes(axle: str) -> float:
        values = asked.sel(axle=axle).to_numpy()[rising]
        k = int(np.argmax(values > half))
        part = (half - values[k - 1]) / (values[k] - values[k - 1])
        return float(time[k - 1] + part * (time[k] - time[k - 1]))

    first = passes("wheelset_1")
    for axle, place in zip(("wheelset_2", "axle_3", "axle_4"), COACH["positions"][1:], strict=True):
        assert passes(axle) - first == pytest.approx(float(place) / SIGNAL_SPEED, abs=1.5e-3)  # friction over speed


@pytest.mark.slow
def test_axles_clean_the_rail_one_after_the_other() -> None:
    """The axle behind finds what all ahead have dissipated: on track and rig, tested or simulated."""
    case = load_case("adhesion_recovery").with_changes({"train.axles": COACH, "time.duration": "8 s"})
    for run in (simulate(case), simulate(track_case(case))):
        late = run["dissipated_energy_density"].sel(time=slice(7.0, None)).mean("time").to_numpy()
        assert (np.diff(late) > 0.0).all()
        assert late[0] > 1e4  # it does slide


def test_all_axles_under_test_is_the_case_without_the_table() -> None:
    plain = load_case("adhesion_brake").with_changes({"time.duration": "2 s"})
    all_tested = plain.with_changes({"train.axles": {"positions": [0.0, 2.56], "under_test": [1, 2]}})
    a, b = simulate(plain), simulate(all_tested)
    for name in ("train_speed", "axle_speed", "roller_torque", "virtual_force"):
        assert np.array_equal(a[name].to_numpy(), b[name].to_numpy())


def test_the_rear_bogie_may_be_under_test() -> None:
    """Where the simulated axles run ahead they clean for those under test."""
    axles = {**COACH, "under_test": [3, 4]}
    case = load_case("adhesion_recovery").with_changes({"train.axles": axles, "time.duration": "8 s"})
    run = simulate(case)
    assert list(run["axle"].to_numpy()) == ["wheelset_1", "wheelset_2", "axle_1", "axle_2"]
    late = run["dissipated_energy_density"].sel(time=slice(7.0, None)).mean("time")
    in_order = late.sel(axle=["axle_1", "axle_2", "wheelset_1", "wheelset_2"]).to_numpy()
    assert (np.diff(in_order) > 0.0).all()


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"under_test": [1, 2, 3, 4, 1]}, "under_test"),
        ({"under_test": [2, 1]}, "under_test"),
        ({"under_test": [1, 1]}, "under_test"),
        ({"under_test": [1, 9]}, "under_test"),
        ({"under_test": [1, 5]}, "under_test"),
        ({"under_test": []}, "under_test"),
        ({"under_test": [1, 2, 3]}, "under_test"),  # the vehicle has two
        ({"positions": [0.0, 2.56, 2.56, 21.0]}, "positions"),
        ({"positions": [0.0, 19.0, 2.56, 21.0]}, "positions"),
        ({"positions": [1.0, 2.56, 19.0, 21.0]}, "positions"),
        ({"positions": [0.0, 2.0, 19.0, 21.56]}, "positions"),  # not spaced as the vehicle's
        ({"positions": [0.0, 2.56, 19.0, 90.0]}, "positions"),  # beyond the rail that is remembered
        ({"loads": [1e5]}, "loads"),
        ({"load_transfer": [0.0, 0.0, 0.0]}, "load_transfer"),
    ],
)
def test_axles_that_cannot_be_are_refused_by_name(changes: dict[str, object], key: str) -> None:
    with pytest.raises(ConfigError, match=rf"train\.axles\.{key}"):
        case_of(**{"train.axles": {**COACH, **changes}})


def test_more_axles_under_test_than_in_the_train_are_refused_with_the_cure() -> None:
    with pytest.raises(ConfigError, match="no more than the train has"):
        case_of(**{"train.axles": {"positions": [0.0], "under_test": [1, 2]}})


def test_a_free_vehicle_and_a_rig_without_a_train_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"train\.axles"):
        case_of(**{"vehicle.cut": "vehicle", "train.axles": {**COACH, "positions": [0.0, 2.56, 19.0, 21.56, 25.0]}})
    with pytest.raises(ConfigError, match="rig_control"):
        case_of(rig_control=None, adhesion=None)


@pytest.mark.parametrize("study", ["envelope", "lateral", "scaled"])
def test_studies_that_know_only_the_axles_under_test_refuse_others(study: str) -> None:
    case = load_case("adhesion_lateral" if study == "lateral" else "adhesion_brake").with_changes(
        {"train.axles": COACH}
    )
    calls = {
        "envelope": EnvelopeStudy,
        "lateral": LateralStudy,
        "scaled": lambda one: scale(one, strategy="dlr"),
    }
    with pytest.raises(
        ConfigError, match=r"train\.axles: 4 axles, 2 of them under test; allowed: all axles under test"
    ):
        calls[study](case)


@pytest.mark.parametrize("name", ["rig", "track"])
def test_what_is_counted_is_of_the_axles_under_test(name: str, request: pytest.FixtureRequest) -> None:
    """What is only simulated agrees between rig and track whatever the rig does: it must not thin out an outcome on the rig."""
    run = request.getfixturevalue(name)
    case = case_of() if name == "rig" else track_case(case_of())
    tested = run.sel(axle=["wheelset_1", "wheelset_2"])
    measures = record_of(run, case).measures
    assert measures["dump_cycles"] == float(tested["dump_cycles"][-1].sum()) < float(run["dump_cycles"][-1].sum())
    assert measures["air_litres"] == pytest.approx(1e3 * float(tested["air"][-1].sum()))
    assert measures["mean_slip"] == pytest.approx(float(abs(slip(tested)).mean()))
    if name == "rig":
        numbers = run_numbers(run, 0.5)
        assert numbers["dump_cycles"] == measures["dump_cycles"]
        assert numbers["ripple_nm"] == run_numbers(tested, 0.5)["ripple_nm"]


def test_friction_used_is_that_of_the_axles_under_test(rig: xr.Dataset) -> None:
    used = friction_used(rig, 0.3)
    assert used.shape == (rig.sizes["time"], 2)
    force = rig["creep_force"].sel(axle="wheelset_2").to_numpy()
    load = rig["vertical_force"].sel(wheel=["wheelset_2_left", "wheelset_2_right"]).sum("wheel").to_numpy()
    late = rig["time"].to_numpy() > 2.0
    assert used[late, 1] == pytest.approx(np.abs(force / load)[late] / 0.3, abs=0.02)


def test_the_report_says_how_many_axles_are_only_simulated() -> None:
    assert any("2 of the train's 4 axles are only simulated" in one for one in limitations(case_of()))
    assert not any("only simulated" in one for one in limitations(load_case("adhesion_brake")))


def test_a_patch_of_a_programme_is_shorter_than_the_least_spacing_of_the_train() -> None:
    programme = load_programme("slide_protection_stops")  # patches of 2.4 m; the bogie's axles are 2.56 m apart
    check_case(case_of(), programme)
    with pytest.raises(ConfigError, match=r"least spacing of the axles, 2 m"):
        check_case(case_of(**{"train.axles": {"positions": [0.0, 2.56, 19.0, 21.0], "under_test": [1, 2]}}), programme)


def test_the_catalogue_s_train_cleans_for_its_rear_bogie() -> None:
    """Each axle finds more adhesion than the one ahead; the energy of the whole test closes."""
    run = simulate(load_case("adhesion_train").with_changes({"time.duration": "12 s"}))
    order = ["axle_1", "axle_2", "wheelset_1", "wheelset_2"]
    late = run.sel(time=slice(4.0, None), axle=order)
    found = late["dissipated_energy_density"].mean("time").to_numpy()
    assert (np.diff(found) > 0.05 * found[-1]).all()
    force = abs(late["virtual_force"]).mean("time").to_numpy()
    assert (np.diff(force[:3]) > 0.0).all()
    assert force[2:].min() > 1.1 * force[0]
    assert (late["dump_cycles"].isel(time=-1) > 5).all()
    assert run.attrs["energy_relative_residual"] < 1e-6
