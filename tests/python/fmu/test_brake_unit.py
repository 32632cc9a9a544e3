"""The brake unit as a machine that is asked: ours, a class, an FMU. Against the one that is a part of the plant."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from rollerrig import ConfigError, _core, export_part, load_case, simulate
from rollerrig.config import Case
from rollerrig.interfaces.plant import assembled_model, controller_part

SHORT = {"time.duration": "4 s", "contact.normal": "hertz"}  # what presses on the rail is none of the brake's


def braked(name: str = "adhesion_brake", **changes: object) -> Case:
    return load_case(name).with_changes({**SHORT, **changes})


@pytest.fixture(scope="module")
def built_in() -> xr.Dataset:
    run = simulate(braked())
    assert run.attrs["status"] == "ok"
    assert (run["valve"] == 2.0).any()
    assert float(run["cylinder_pressure"].max()) > 2e5
    return run


def different(a: xr.Dataset, b: xr.Dataset) -> set[str]:
    return {
        str(name)
        for name in a.data_vars
        if a[name].dtype.kind == "f" and not np.array_equal(a[name].values, b[name].values, equal_nan=True)
    }


class Ours:
    """Our own brake unit, behind a Python class."""

    def __init__(self, case: Case) -> None:
        self.plant = _core.ControllerPlant(controller_part(case, "brake_unit"))
        self.plant.start()
        self.sample_time = self.plant.period
        self.index = {variable.name: i for i, variable in enumerate(self.plant.variables)}

    def step(self, measurements):
        for axle in range(2):
            for name in ("dump_valve", "brake_demand"):
                self.plant.set_input(self.index[f"wheelset_{axle + 1}.{name}"], measurements[name][axle])
        self.plant.advance(measurements["time"] + self.sample_time)
        names = [f"wheelset_{axle}.cylinder_pressure_command" for axle in (1, 2)]
        return {"cylinder_pressure": [self.plant.get(self.index[name]) for name in names]}


def test_asked_in_time_it_gives_the_run_of_the_built_in_one(built_in: xr.Dataset) -> None:
    assert different(built_in, simulate(braked(brake_unit={}))) <= {"air", "exhausted_air"}


def test_air_is_counted_at_the_cylinders(built_in: xr.Dataset) -> None:
    run = simulate(braked(brake_unit={}))
    for name in ("air", "exhausted_air"):
        assert float(built_in[name][-1].min()) > 0.0
        np.testing.assert_allclose(run[name], built_in[name], rtol=1e-12, atol=1e-15)


def test_a_class_gives_the_run_of_the_built_in_one(built_in: xr.Dataset) -> None:
    run = simulate(braked(), controllers={"brake_unit": Ours(braked())})
    assert different(built_in, run) <= {"air", "exhausted_air"}


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="the library inside FMUs is built on Linux")
@pytest.mark.parametrize("fmi", ["2", "3"])
def test_exported_and_brought_back_in_it_gives_the_run_of_the_built_in_one(
    fmi: str, built_in: xr.Dataset, tmp_path: Path
) -> None:
    validation = pytest.importorskip("fmpy.validation", reason="FMPy is an optional dependency")
    unit = export_part("adhesion_brake", "brake_unit", tmp_path / "unit.fmu", fmi=fmi)
    assert validation.validate_fmu(str(unit)) == []
    run = simulate(braked(brake_unit={"fmu": str(unit)}))
    assert run.attrs["status"] == "ok"
    assert "unit.fmu" in run.attrs["brake_unit_fmu"]
    assert different(built_in, run) <= {"air", "exhausted_air"}


def test_valves_with_dead_times_and_a_reservoir() -> None:
    """Of a brake unit that is asked the rig knows neither the reservoir nor how its valves move."""
    case = braked("adhesion_valves", **{"time.duration": "3 s"})
    run, asked = simulate(case), simulate(case.with_changes({"brake_unit": {}}))
    assert (run["valve"] == 2.0).any()
    assert float(run["reservoir_pressure"][-1].min()) < float(run["reservoir_pressure"][0].min())
    of_its_inside = {"air", "exhausted_air", "reservoir_pressure", "main_pipe_air", "inlet_open", "outlet_open"}
    assert different(run, asked) <= of_its_inside | {"dump_cycles"}


def test_in_another_tool_bench_and_unit_give_the_built_in_loop(built_in: xr.Dataset) -> None:
    """The bench shows at each instant what the unit is to see; its answer acts over the step that begins."""
    case = braked()
    bench = _core.Plant(assembled_model(case, external=["brake_unit"]))
    bench.start()
    unit = Ours(case)
    axles = ("wheelset_1", "wheelset_2")
    seen = {
        name: [bench.find(f"brake_unit.{axle}.{name}") for axle in axles] for name in ("dump_valve", "brake_demand")
    }
    command = [bench.find(f"{axle}.cylinder_pressure_command") for axle in axles]
    assert min(command + seen["dump_valve"]) >= 0
    for k in range(2000):
        measured = {name: bench.values(found) for name, found in seen.items()}
        pressure = unit.step({"time": 1e-3 * k, **measured})["cylinder_pressure"]
        for index, value in zip(command, pressure, strict=True):
            bench.set_input(index, value)
        bench.advance(1e-3 * (k + 1))
    end = built_in.sel(time=2.0)
    assert bench.get(bench.find("train.speed")) == end["train_speed"]
    assert bench.values([bench.find(f"{axle}.cylinder_pressure") for axle in axles]).tolist() == (
        end["cylinder_pressure"].values.tolist()
    )


def test_it_is_asked_after_the_slide_protection() -> None:
    class Venting:
        sample_time = 5e-3

        def step(self, measurements):
            return {"valve": [2.0 if measurements["time"] > 0.1 else 0.0, 0.0]}

    class Listening:
        sample_time = 1e-3
        first = 0.0

        def step(self, measurements):
            if not self.first and measurements["dump_valve"][0] == 2.0:
                self.first = measurements["time"]
            return {"cylinder_pressure": np.where(measurements["dump_valve"] == 0.0, measurements["brake_demand"], 0.0)}

    unit = Listening()
    case = braked(
        **{"time.duration": "0.3 s", "slide_protection.delay": "0 s", "brake.demand": [[0.0, 1e5], [1.0, 1e5]]}
    )
    run = simulate(case, controllers={"slide_protection": Venting(), "brake_unit": unit})
    assert run.attrs["status"] == "ok"
    assert unit.first == pytest.approx(0.105)  # no step later than what it commands
    assert run["cylinder_pressure"].sel(time=0.09).values.tolist() == [1e5, 1e5]
    assert run["cylinder_pressure"][-1].values.tolist() == [0.0, 1e5]
    assert run["dump_cycles"][-1].values.tolist() == [1.0, 0.0]


def test_a_state_in_the_middle_of_a_stop_goes_on_the_same(built_in: xr.Dataset) -> None:
    plant = _core.Plant(assembled_model(braked(brake_unit={})))
    plant.start()
    plant.advance(1.5)
    kept = plant.save()
    other = _core.Plant(assembled_model(braked(brake_unit={})))
    other.restore(kept)
    other.advance(3.0)
    assert other.get(other.find("train.speed")) == built_in["train_speed"].sel(time=3.0)


def test_a_pressure_that_is_none_ends_the_run_with_its_time() -> None:
    class Bad:
        sample_time = 1e-3

        def step(self, measurements):
            return {"cylinder_pressure": [np.nan if measurements["time"] > 0.2 else 0.0, 0.0]}

    run = simulate(braked(), controllers={"brake_unit": Bad()})
    assert run.attrs["status"] == "controller_failed"
    assert "t = 0.201 s, brake_unit, controller Bad: cylinder_pressure = [nan" in run.attrs["status_message"]


@pytest.mark.parametrize(
    ("name", "changes", "message"),
    [
        ("adhesion_sanding", {"brake_unit": {}}, r"brake_unit: .*allowed without brake.electrodynamic"),
        ("bogie_rollers_constant", {"brake_unit": {}}, r"brake_unit: .*allowed only with \[brake\]"),
        ("adhesion_brake", {"brake_unit": {"sample_time": "1.5 ms"}}, r"brake_unit.sample_time: .*multiple of"),
    ],
)
def test_what_it_cannot_stand_beside_is_refused(name: str, changes: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        load_case(name).with_changes(changes)
