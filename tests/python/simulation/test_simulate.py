"""A run from start to end: what the Dataset holds, where it starts, how it ends."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig.analysis.signals import low_pass
from rollerrig.assembly.model import assemble
from rollerrig.config import Case, case_from_toml
from rollerrig.results import dataset as dataset_module
from rollerrig.results.termination import _points_end
from rollerrig.simulation import run as simulation_module

WHEELSET = "wheelset_rollers"


def short_case(**changes: object) -> Case:
    """A wheelset at 40 km/h, 0.2 s; further changes with `__` for the dots of their keys."""
    given = {key.replace("__", "."): value for key, value in changes.items()}
    basis = {"motion.speed": "40 km/h", "time.duration": "0.2 s", "time.method": "rodas4", "time.step": "0.1 ms"}
    return rr.load_case(WHEELSET).with_changes({**basis, **given})


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return rr.simulate(short_case())


def test_every_variable_says_its_unit_and_meaning(run: xr.Dataset) -> None:
    for name, variable in run.data_vars.items():
        assert variable.attrs["units"], name
        assert variable.attrs["long_name"], name
    assert run["lateral"].dims == ("time", "body")
    assert run["patch_normal"].dims == ("time", "wheel", "patch")
    assert run["element_force_x"].dims == ("time", "element")
    assert {"longitudinal", "lateral_velocity", "vertical_acceleration", "yaw_rate", "energy_kinetic"} <= set(run)


def test_the_patches_of_a_wheel_add_up_to_its_force(run: xr.Dataset) -> None:
    # the same numbers, summed in another order
    assert np.allclose(run["patch_normal"].sum("patch"), run["normal_force"], rtol=1e-13)


def test_all_output_times_are_there(run: xr.Dataset) -> None:
    assert np.allclose(run["time"], 0.002 * np.arange(101), atol=1e-12)
    assert np.isfinite(run["lateral"]).all()
    assert run.attrs["status"] == "ok"
    assert run.attrs["stopped_at_s"] == 0.2


@pytest.mark.parametrize(
    ("duration", "step", "count"), [("0.1 s", "30 ms", 4), ("0.3 s", "0.1 s", 4), ("7 ms", "7 ms", 2)]
)
def test_output_times_need_not_divide_the_duration(duration: str, step: str, count: int) -> None:
    case = short_case(time__duration=duration, time__output_step=step)
    assert rr.simulate(case).sizes["time"] == count


def test_the_energy_balance_closes(run: xr.Dataset) -> None:
    assert run.attrs["energy_turned_over_j"] > 10
    # tolerance 1e-6 per step, of which the run takes some hundred, seldom all of one sign
    assert run.attrs["energy_relative_residual"] < 1e-6
    assert run["energy_residual"].attrs["units"] == "J"


def test_the_run_holds_its_whole_configuration(run: xr.Dataset) -> None:
    assert case_from_toml(run.attrs["config_toml"]) == short_case()
    assert json.loads(run.attrs["solver_statistics"])["steps"] > 0
    assert json.loads(run.attrs["contact_counters"])["checked"] > 0
    assert "Malvezzi" in run.attrs["sources"]


def test_a_disturbance_is_an_offset_from_equilibrium() -> None:
    still = rr.simulate(short_case(disturbance=[]))
    offset = short_case(disturbance=[{"body": "wheelset_1", "lateral": "2 mm", "yaw": "1 mrad"}])
    moved = rr.simulate(offset.with_changes({"time.duration": "4 ms"}))
    for name, by in (("lateral", 2e-3), ("yaw", 1e-3)):
        difference = (moved[name] - still[name]).sel(body="wheelset_1").isel(time=0)
        assert float(difference) == pytest.approx(by, abs=1e-15)
    # a symmetric model in equilibrium stays there, to the tolerance of the integration
    assert float(np.abs(still["lateral"]).max()) < 1e-9


def test_yaw_is_kept_where_only_a_lateral_offset_is_given(run: xr.Dataset) -> None:
    start = run.sel(body="wheelset_1").isel(time=0)
    assert abs(float(start["yaw"])) < 1e-12
    assert float(start["lateral"]) == pytest.approx(3e-3, abs=1e-12)


@pytest.mark.parametrize("offset", ["8 mm", "-8 mm"])
def test_a_run_can_start_on_the_flange(offset: str) -> None:
    case = short_case(disturbance=[{"body": "wheelset_1", "lateral": offset}], time__duration="10 ms")
    start = rr.simulate(case).sel(body="wheelset_1").isel(time=0)
    assert abs(float(start["lateral"])) == pytest.approx(8e-3, abs=1e-9)
    assert abs(float(start["vertical_acceleration"])) < 1e-3


@pytest.mark.parametrize(
    "changes",
    [
        {"method": "rk4", "step": "0.02 ms"},
        {"method": "exponential_rk4", "step": "0.02 ms"},
        {"method": "exponential_adams", "step": "0.02 ms"},
        {"method": "dormand_prince"},
    ],
)
def test_methods_agree(changes: dict[str, str]) -> None:
    tight = {"time__duration": "20 ms", "time__relative_tolerance": 1e-9, "time__absolute_tolerance": 1e-12}
    reference = rr.simulate(short_case(**tight))
    other = rr.simulate(short_case(**tight, **{f"time__{key}": value for key, value in changes.items()}))
    for name in ("lateral", "yaw", "vertical"):
        scale = float(np.abs(reference[name].sel(body="wheelset_1")).max())
        # of fourth and fifth order; the contact's second derivative jumps where patches appear
        assert float(np.abs(reference[name] - other[name]).max()) < 1e-5 * scale


def test_standstill() -> None:
    run = rr.simulate(short_case(motion__speed=0, time__duration="50 ms"))
    assert run.attrs["status"] == "ok"
    assert float(np.abs(run["speed"]).max()) == 0.0


def test_two_runs_are_equal_and_slices_do_not_matter(run: xr.Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation_module, "_SLICE_SECONDS", 0.0)  # a slice per output time
    assert rr.simulate(short_case()).identical(run)


def test_progress_grows_to_one() -> None:
    seen: list[tuple[float, str]] = []
    rr.simulate(short_case(), progress=lambda fraction, text: seen.append((fraction, text)))
    fractions = [fraction for fraction, _ in seen]
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0
    assert "40 km/h" in seen[-1][1]


def test_an_interrupted_run_keeps_what_was_computed() -> None:
    def interrupt(fraction: float, text: str) -> None:
        if fraction > 0.2:
            raise KeyboardInterrupt

    run = rr.simulate(short_case(), progress=interrupt)
    assert run.attrs["status"] == "interrupted"
    assert 0 < run.sizes["time"] < 101
    part = {dim: slice(run.sizes[dim]) for dim in ("time", "reading_time")}
    assert run.sizes["reading_time"] > run.sizes["time"]
    assert run.equals(rr.simulate(short_case()).isel(part))


def test_leaving_the_model_is_named_with_time_and_wheel() -> None:
    """Dropped from 300 mm: longer in the air than a wheel may be."""
    case = rr.load_case("contact_benchmark_track")
    lifted = case.with_changes({"disturbance": [{"body": "wheelset_1", "vertical": "300 mm"}]})
    run = rr.simulate(lifted)
    assert run.attrs["status"] == "contact_lost"
    assert run.attrs["stopped_wheel"] == "wheelset_1_left"
    assert 0.2 < run.attrs["stopped_at_s"] < 0.25
    assert run.attrs["status_message"].startswith("t = 0.2")
    assert "wheelset_1_left" in run.attrs["status_message"]
    assert "touched" not in run.attrs["status_message"]  # it never did
    assert float(run["time"][-1]) == pytest.approx(run.attrs["stopped_at_s"], abs=2e-3)
    # free fall is exact for a method of order 4
    fallen = run["vertical"].sel(body="wheelset_1") - run["vertical"].sel(body="wheelset_1")[0]
    assert np.allclose(fallen, -0.5 * 9.81 * run["time"] ** 2, atol=1e-12)


def test_a_diverging_run_ends_with_a_status(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation_module, "check_fixed_step", lambda *_: None)  # it would have been refused
    run = rr.simulate(short_case(time__method="rk4", time__step="5 ms", time__output_step="5 ms"))
    assert run.attrs["status"] in ("not_finite", "off_profile")  # whichever is seen first
    assert 0 < run.sizes["time"] < 41


def test_an_impossible_torque_has_no_equilibrium() -> None:
    case = short_case(axle_torque=[{"wheelset": "wheelset_1", "constant": "60 kN m"}])
    with pytest.raises(rr.StartError, match="no equilibrium at 40 km/h"):
        rr.simulate(case)


def test_a_start_that_spins_absurdly_fast_is_refused() -> None:
    case = rr.load_case("bogie_rollers_constant").with_changes({"contact.friction.mu_0": 3e-7})
    with pytest.raises(rr.StartError, match=r"wheelset_1 would start with 1\.4.e\+06 .*too large for the friction"):
        rr.simulate(case)


def test_results_that_do_not_fit_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation_module, "SURELY_THERE", 1e3)
    monkeypatch.setattr(simulation_module, "available_memory", lambda: 1e5)
    with pytest.raises(rr.ConfigError, match=r"time.output_step: 0.002; allowed: at least .* s for a run of 0.2 s"):
        rr.simulate(short_case())


@pytest.mark.parametrize(
    ("least", "said"), [(1e-3, "are valid"), (-1.0, "its energy balance is open, see the warning")]
)
def test_a_run_that_ends_early_is_valid_where_its_energy_closes(
    least: float, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(_done: float, _text: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(simulation_module, "ENERGY_WARNING", least)
    run = rr.simulate(short_case(), progress=interrupt)
    assert run.attrs["status"] == "interrupted"
    assert said in run.attrs["status_message"]
    assert ("energy balance open" in run.attrs["warnings"]) is (least < 0.0)
    assert ("are valid" in run.attrs["status_message"]) is (least > 0.0)


def test_memory_is_taken_once() -> None:
    case = short_case()
    room = simulation_module._room(case, 10, 3)
    assert room.rows.shape == (simulation_module.sample_count(case), 10)
    assert len(room.times) == 101
    assert room.readings.shape == (100 * room.every + 1, 3)


def test_an_unstable_fixed_step_is_refused_with_the_step_that_works() -> None:
    case = short_case(motion__speed="1 km/h", time__method="rk4", time__step="0.25 ms")
    with pytest.raises(rr.ConfigError, match=r"time\.step: 0\.25 ms; allowed: at most 0\.0\d+ ms.*rodas4"):
        rr.simulate(case)


def test_the_exponential_method_goes_beyond_the_limit_that_the_dampers_set(monkeypatch: pytest.MonkeyPatch) -> None:
    """0.7 ms is past rk4's 2.78 / (4000 1/s) for the primary dampers; what the check refuses does blow up."""
    settings = {"motion__speed": "150 km/h", "time__step": "0.75 ms", "time__duration": "0.6 s"}
    limit = r"time\.step: 0\.75 ms; allowed: at most 0\.6\d ms, where rk4"
    with pytest.raises(rr.ConfigError, match=limit):
        rr.simulate(short_case(time__method="rk4", **settings))
    run = rr.simulate(short_case(time__method="exponential_rk4", **settings))
    assert run.attrs["status"] == "ok"
    assert run.attrs["energy_relative_residual"] < 1e-3
    monkeypatch.setattr(simulation_module, "check_fixed_step", lambda *_: None)
    assert rr.simulate(short_case(time__method="rk4", **settings)).attrs["status"] != "ok"


def test_a_run_whose_energy_does_not_close_says_so() -> None:
    dropped = {"body": "wheelset_1", "vertical": "0.3 m"}
    run = rr.simulate(
        short_case(
            disturbance=[dropped],
            time__duration="0.6 s",
            time__step=None,
            time__relative_tolerance=1e-1,
            time__absolute_tolerance=1e-3,
        )
    )
    assert run.attrs["energy_relative_residual"] > 1e-3
    assert "energy balance open" in run.attrs["warnings"]


def test_a_quiet_run_carries_no_warning(run: xr.Dataset) -> None:
    assert run.attrs["warnings"] == ""


def test_a_wheelset_that_runs_off_a_narrow_tread_is_stopped_there() -> None:
    """A cone without a flange, 20 mm to each side, set askew: it rolls sideways until its tread ends."""
    case = rr.load_case("contact_benchmark_track").with_changes(
        {
            "vehicle.wheel.profile": {"kind": "cone", "conicity": 0.05, "half_width": "20 mm"},
            "disturbance": [{"body": "wheelset_1", "lateral": "2 mm", "yaw": 0.03}],
            "motion.speed": "20 m/s",
            "time.duration": "1 s",
            "contact.normal": "hertz",  # a point of contact that leaves the profile
        }
    )
    run = rr.simulate(case)
    assert run.attrs["status"] == "off_profile"
    assert run.attrs["status_message"].startswith("t = 0.09")
    assert run.attrs["stopped_wheel"] == "wheelset_1_left"
    assert run.sizes["time"] > 50
    text = run.attrs["status_message"]
    assert re.search(
        r"its profile \(cone 0.05\) at S = -19.\d mm, the rail \(UIC60.*\) at y = -15.\d mm, flange side", text
    )
    assert re.search(r"contact angle 3 degrees, Y 2.\d kN, Q \d.\d kN, \|Y\|/Q 0.2\d\.", text)
    assert re.search(
        r"That is [01]\.\d mm from the end of the wheel's profile\. Its points end there: give a profile that", text
    )
    assert "support.foundation" not in text  # no chattering


def test_a_longer_profile_is_advised_only_where_its_points_end() -> None:
    """The points of S1002 end on the back of its flange tip; those of a rail go on down its side, too steep for a table."""
    model = assemble(rr.load_case("bogie_track"))
    for profile, ends in ((model.wheel_profile, True), (model.rail_profile, False)):
        low, high = profile.domain
        assert [_points_end(profile, low + 0.4e-3), _points_end(profile, high - 0.4e-3)] == [ends, ends]


@pytest.mark.slow
def test_a_wheelset_that_climbs_its_flange_is_stopped_there() -> None:
    case = rr.load_case("contact_benchmark_track").with_changes(
        {
            "disturbance": [{"body": "wheelset_1", "lateral": "5 mm", "yaw": 0.15}],
            "contact.friction": 0.6,
            "motion.speed": "30 m/s",
            "time.duration": "1 s",
        }
    )
    run = rr.simulate(case)
    assert run.attrs["status"] == "derailed"
    assert run.attrs["stopped_wheel"] == "wheelset_1_left"
    assert 0.1 < run.attrs["stopped_at_s"] < 0.4
    assert "S = -5" in run.attrs["status_message"]
    assert "The rails are rigid: support.foundation, as flexible_track has it" in run.attrs["status_message"]
    # the centre rises by half of what the climbing wheel does, which is nearly the flange's 28 mm
    assert 0.010 < float(run["vertical"].sel(body="wheelset_1").max()) < 0.016


def test_readings_are_the_columns_of_the_rows_at_the_same_times() -> None:
    run = rr.simulate(short_case(time__duration="0.1 s"))
    whole = run["reading_time"].values.searchsorted(run["time"].values)
    assert run.sizes["reading_time"] == (run.sizes["time"] - 1) * round(float(whole[1])) + 1
    assert whole[1] > 1
    for name in rr._core.reading_fields:
        assert run[f"reading_{name}"].values[whole].tobytes() == run[name].values.tobytes()
    assert run["reading_distance"].values[whole].tobytes() == run["distance"].values.tobytes()


def test_a_run_of_2_ms_is_read_at_its_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    case = rr.load_case("bogie_rollers_constant").with_changes({"time.duration": "2 s"})
    at_steps = rr.simulate(case)
    assert case.integration.step == 2e-3
    assert "reading_time" not in at_steps.variables  # its outputs are at its steps
    monkeypatch.setattr(dataset_module, "READING_STEP", 0.25e-3)
    monkeypatch.setattr(dataset_module, "LONGEST_READING_STEP", 0.25e-3)
    dense = rr.simulate(case)
    assert dense.sizes["reading_time"] == 8001
    for name, bound in (("lateral_force", 3e-5), ("vertical_force", 3e-5), ("wear_number", 1e-4)):
        every = low_pass(dense[f"reading_{name}"].rename(reading_time="time"), 20.0).isel(time=slice(None, None, 8))
        few = low_pass(at_steps[name], 20.0)
        inner = slice(0.2, 1.8)  # a filter has nothing to lean on at the ends
        deviation = abs(few.sel(time=inner).to_numpy() - every.sel(time=inner).to_numpy()).max()
        assert deviation < bound * float(abs(every).max()), name


def test_readings_within_a_step_are_those_of_the_state_there() -> None:
    """A long step is read where its forces bend; the others lie on parabolas between."""
    case = rr.load_case("bogie_rollers_traction").with_changes({"time.duration": "3 s"})
    read, dense = rr.simulate(case), rr.simulate(case.with_changes({"time.output_step": "1 ms"}))
    assert json.loads(read.attrs["solver_statistics"])["steps"] < 0.3 * read.sizes["reading_time"]
    assert "reading_time" not in dense.variables
    for name, size in (("lateral_force", "vertical_force"), ("vertical_force", "vertical_force"), ("wear_number",) * 2):
        off = np.abs(read[f"reading_{name}"].to_numpy() - dense[name].to_numpy())
        assert off.max() < 1e-4 * float(dense[size].max()), name
    assert read["reading_distance"].to_numpy() == pytest.approx(dense["distance"].to_numpy(), abs=1e-5)
    rows = read["vertical_force"].to_numpy()
    assert read["reading_vertical_force"].to_numpy()[::10].tobytes() == rows.tobytes()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("wheelset_rollers", {"motion.speed": "170 km/h"}),
        ("wheelset_rollers", {"motion.speed": "65 km/h", "contact.normal": "hertz"}),
        ("bogie_rollers_constant", {"motion.speed": "240 km/h"}),
        ("vehicle_track_irregular", {"motion.speed": "60 km/h", "time.duration": "0.3 s"}),
    ],
)
def test_readings_within_a_step_hold_on_flanges_and_on_irregular_rails(name: str, changes: dict[str, object]) -> None:
    adaptive = {
        "time.method": "rodas4",
        "time.step": None,
        "time.output_step": "20 ms",
        "time.relative_tolerance": 1e-4,
    }
    case = rr.load_case(name).with_changes({"time.duration": "0.6 s", **adaptive, **changes})
    read, dense = rr.simulate(case), rr.simulate(case.with_changes({"time.output_step": "1 ms"}))
    load = float(dense["vertical_force"].max())
    for one in ("lateral_force", "vertical_force"):
        assert np.abs(read[f"reading_{one}"].to_numpy() - dense[one].to_numpy()).max() < 1e-4 * load
    if name == "vehicle_track_irregular":  # forces follow the rail within a step, which the states do not show
        assert read["reading_vertical_force"].to_numpy() == pytest.approx(dense["vertical_force"].to_numpy(), rel=1e-12)


def test_readings_do_not_depend_on_the_slices_of_a_run() -> None:
    case = rr.load_case("bogie_rollers_traction").with_changes({"time.duration": "1 s"})
    model, found = assemble(case), []
    for slice_length in (1.0, 0.0137):
        simulation = simulation_module.prepare(model, output_step=1e-3)
        times, values = np.empty(1001), np.empty((1001, simulation.reading_width))
        simulation.keep_readings(10, times, values)
        room = np.empty(102), np.empty((102, simulation.width))
        simulation_module.march(simulation, 1.0, *room, slice_length=slice_length, begin_at=0.0)
        assert simulation.reading_count == 1001
        found.append(values.tobytes())
    assert found[0] == found[1]
