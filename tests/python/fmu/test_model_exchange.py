"""Model exchange: the tool integrates. Against our own integrators, co-simulation, and differences of the FMU's own numbers."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from ctypes import POINTER, c_double
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy import validation
from fmpy.fmi2 import FMU2Model, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Model

from rollerrig import catalog_entries, export_fmu, load_case, simulate

TIGHT = {"time.relative_tolerance": 1e-9, "time.absolute_tolerance": 1e-12}


@pytest.fixture(scope="module", params=["2", "3"])
def bogie(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bogie on rollers, nothing sampled, in both versions of the standard."""
    case = load_case("bogie_rollers_constant").with_changes({"time.duration": "0.2 s"})
    return export_fmu(case, tmp_path_factory.mktemp("fmu") / "bogie.fmu", fmi=request.param, kind="both")


class Exchange:
    """An FMU between its calls, alike in both versions."""

    def __init__(self, file: Path) -> None:
        self.description = fmpy.read_model_description(str(file))
        self.folder = fmpy.extract(str(file))
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.third = self.description.fmiVersion.startswith("3")
        kind = FMU3Model if self.third else FMU2Model
        self.fmu = kind(
            guid=self.description.guid,
            modelIdentifier=self.description.modelExchange.modelIdentifier,
            unzipDirectory=self.folder,
            instanceName="bogie",
        )
        if self.third:
            self.fmu.instantiate()
        else:
            # FMPy's own logger is shared by all FMUs of a process, also by those that have gone.
            self.callbacks = fmi2CallbackFunctions(logger=fmi2CallbackLoggerTYPE(lambda *_: None))
            self.fmu.instantiate(callbacks=self.callbacks)
            self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.states = sum(name.startswith("der(") for name in self.references)
        self.events()

    def events(self) -> float | None:
        """New discrete states, then continuous time; the next time event."""
        if self.third:
            _, over, _, _, defined, time = self.fmu.updateDiscreteStates()
        else:
            _, over, _, _, defined, time = self.fmu.newDiscreteStates()
        assert not over
        self.fmu.enterContinuousTimeMode()
        return time if defined else None

    def get(self, *names: str) -> np.ndarray:
        references = [self.references[name] for name in names]
        return np.array(self.fmu.getFloat64(references) if self.third else self.fmu.getReal(references))

    def _vector(self, call: str, length: int) -> np.ndarray:
        values = np.zeros(length)
        getattr(self.fmu, call)(values.ctypes.data_as(POINTER(c_double)), length)
        return values

    def get_states(self) -> np.ndarray:
        return self._vector("getContinuousStates", self.states)

    def rates(self) -> np.ndarray:
        return self._vector("getContinuousStateDerivatives" if self.third else "getDerivatives", self.states)

    def indicators(self) -> np.ndarray:
        return self._vector("getEventIndicators", 4)

    def put(self, states: np.ndarray, time: float = 0.0) -> None:
        self.fmu.setTime(time)
        states = np.ascontiguousarray(states)
        self.fmu.setContinuousStates(states.ctypes.data_as(POINTER(c_double)), len(states))

    def directional(self, unknown: list[str], known: list[str], seed: list[float]) -> np.ndarray:
        references = [[self.references[name] for name in names] for names in (unknown, known)]
        return np.array(self.fmu.getDirectionalDerivative(*references, seed))

    def close(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder)


@pytest.fixture
def exchange(bogie: Path) -> Iterator[Exchange]:
    one = Exchange(bogie)
    yield one
    one.close()


@pytest.mark.slow
def test_fmpy_has_nothing_to_say(bogie: Path) -> None:
    assert validation.validate_fmu(str(bogie)) == []
    description = fmpy.read_model_description(str(bogie))
    assert description.modelExchange is not None
    assert description.coSimulation is not None
    assert description.numberOfEventIndicators == 4 or len(description.eventIndicators) == 4


@pytest.mark.long
@pytest.mark.parametrize("fmi", ["2", "3"])
@pytest.mark.parametrize("kind", ["me", "both"])
@pytest.mark.parametrize("name", [name for kind, name, _ in catalog_entries() if kind == "case"])
def test_fmpy_has_nothing_to_say_of_any_case_that_ships(name: str, kind: str, fmi: str, tmp_path: Path) -> None:
    export_fmu(name, out := tmp_path / "case.fmu", fmi=fmi, kind=kind)
    assert validation.validate_fmu(str(out)) == []


@pytest.mark.slow
def test_cvode_gives_the_run_of_rodas4(bogie: Path) -> None:
    case = load_case("bogie_rollers_constant").with_changes(
        {"time.duration": "0.2 s", "time.method": "rodas4", "time.step": None, "time.output_step": "10 ms", **TIGHT}
    )
    run = simulate(case)
    outputs = ["wheelset_1.lateral", "wheelset_1.yaw", "wheelset_1_left.vertical_force"]
    found = fmpy.simulate_fmu(
        str(bogie), fmi_type="ModelExchange", solver="CVode", relative_tolerance=1e-9, stop_time=0.2,
        output_interval=0.01, output=outputs,
    )  # fmt: skip
    for output, column, where in zip(
        outputs, ["lateral", "yaw", "vertical_force"],
        [{"body": "wheelset_1"}, {"body": "wheelset_1"}, {"wheel": "wheelset_1_left"}], strict=True,
    ):  # fmt: skip
        expected = run[column].sel(where).to_numpy()
        assert np.ptp(expected) > 0.0
        np.testing.assert_allclose(found[output], expected, rtol=0.0, atol=1e-6 * np.abs(expected).max())


def test_instants_of_sampling_are_time_events(tmp_path: Path) -> None:
    case = load_case("adhesion_brake").with_changes({"time.duration": "0.2 s", **TIGHT})
    export_fmu(case, out := tmp_path / "case.fmu", fmi="3", kind="both")
    names = [
        "wheelset_1_left.vertical_force",
        "wheelset_1.pitch_rate",
        "wheelset_2.cylinder_pressure",
        "train.distance",
    ]
    settings = {
        "stop_time": 0.2,
        "output_interval": 0.01,
        "output": names,
        "start_values": {"wheelset_2.brake_demand": 2e5},
    }
    steps = fmpy.simulate_fmu(str(out), fmi_type="CoSimulation", **settings)
    found = fmpy.simulate_fmu(str(out), fmi_type="ModelExchange", solver="CVode", relative_tolerance=1e-8, **settings)
    before = np.searchsorted(found["time"], steps["time"] - 1e-9)
    behind = np.searchsorted(found["time"], steps["time"] + 1e-9) - 1
    for name in names:
        # A step ends with the sensors read and the train moved on; actuators move with the next.
        rows = before if name.endswith("cylinder_pressure") else behind
        expected = steps[name][1:-1]  # at 0 the first event has passed in one, not in the other
        assert np.ptp(expected) > 0.0
        np.testing.assert_allclose(found[name][rows][1:-1], expected, rtol=0.0, atol=1e-6 * np.abs(expected).max())


def test_directional_derivatives_are_those_of_the_rates(exchange: Exchange) -> None:
    rng = np.random.default_rng(1)
    names = [name for name in exchange.references if name.startswith("state.")]
    start = exchange.get_states()
    nominal = np.where(np.abs(start) > 1.0, 1.0, 1e-3)
    seed = nominal * rng.standard_normal(len(names))
    rates = [f"der({name})" for name in names]
    outputs = [
        "wheelset_1_left.vertical_force",
        "wheelset_2_right.lateral_force",
        "frame.lateral_acceleration",
        "wheelset_1_left.derailment_quotient",
    ]
    outputs = [name for name in outputs if name in exchange.references]
    given = exchange.directional([*rates, *outputs], names, list(seed))
    h = 1e-5
    sides = []
    for way in (h, -h):
        exchange.put(start + way * seed)
        sides.append(np.concatenate([exchange.rates(), exchange.get(*outputs)]))
    expected = (sides[0] - sides[1]) / (2 * h)
    np.testing.assert_allclose(given, expected, rtol=1e-4, atol=1e-6)  # W, m/s^2: round-off of the differences
    assert np.abs(given).max() > 1.0


def test_directional_derivatives_by_inputs(tmp_path: Path) -> None:
    export_fmu("bogie_rollers_traction", out := tmp_path / "case.fmu", kind="me")
    exchange = Exchange(out)
    torque, rate, friction = (
        "wheelset_1.axle_torque",
        "der(state.wheelset_1.pitch_rate)",
        "wheelset_1_left.friction_change",
    )
    power = "der(state.energy_work_of_torque)"
    by_torque = exchange.directional([rate, power], [torque], [1.0])
    exchange.fmu.enterEventMode()
    sides = []
    for value in (1e3, -1e3):
        exchange.fmu.setReal([exchange.references[torque]], [value])
        sides.append(exchange.get(rate, power))
    np.testing.assert_allclose(by_torque, (sides[0] - sides[1]) / 2e3, rtol=1e-7)
    assert (np.abs(by_torque) > 1e-4).all()
    both = exchange.directional([rate], [torque, friction], [2.0, 1.0])[0]
    alone = exchange.directional([rate], [friction], [1.0])[0]
    assert alone != 0.0
    assert both == pytest.approx(exchange.directional([rate], [torque], [2.0])[0] + alone, rel=1e-9)
    exchange.close()


def test_the_indicator_of_a_wheel_that_lifts_off_changes_its_sign(exchange: Exchange) -> None:
    start = exchange.get_states()
    assert (exchange.indicators() > 1e4).all()
    names = [name for name in exchange.references if name.startswith("state.")]
    lifted = start.copy()
    lifted[names.index("state.wheelset_1.vertical")] += 2e-3
    exchange.put(lifted)
    assert (exchange.indicators()[:2] == -1.0).all()
    assert (exchange.indicators()[2:] > 1e4).all()


def test_a_saved_state_goes_on_as_if_nothing_had_been(exchange: Exchange) -> None:
    fmu = exchange.fmu
    get, put, free = (
        (fmu.getFMUState, fmu.setFMUState, fmu.freeFMUState) if exchange.third
        else (fmu.getFMUstate, fmu.setFMUstate, fmu.freeFMUstate)
    )  # fmt: skip

    def euler(steps: int, time: float) -> np.ndarray:
        for _ in range(steps):
            exchange.put(exchange.get_states() + 1e-5 * exchange.rates(), time := time + 1e-5)
            fmu.completedIntegratorStep()
        return np.concatenate([exchange.get_states(), exchange.rates(), exchange.get("wheelset_1_left.vertical_force")])

    euler(20, 0.0)
    saved = get()
    first = euler(20, 2e-4)
    put(saved)
    np.testing.assert_array_equal(euler(20, 2e-4), first)
    free(saved)


def test_numbers_of_a_wrong_count_and_calls_out_of_order_are_refused(exchange: Exchange) -> None:
    exchange.states += 1
    with pytest.raises(fmpy.fmi1.FMICallException):
        exchange.get_states()
    exchange.states -= 1
    with pytest.raises(fmpy.fmi1.FMICallException):
        exchange.fmu.enterContinuousTimeMode()  # it is there already
    exchange.put(np.full(exchange.states, 0.0) + exchange.get_states())
    with pytest.raises(fmpy.fmi1.FMICallException):
        exchange.put(np.full(exchange.states, np.nan))
    assert np.isfinite(exchange.rates()).all()


def test_a_parameter_with_which_there_is_no_start_leaves_the_one_before(exchange: Exchange) -> None:
    fmu, third = exchange.fmu, exchange.third
    put = fmu.setFloat64 if third else fmu.setReal
    fmu.reset()
    fmu.enterInitializationMode()
    mass = exchange.references["wheelset_1.mass"]
    before = exchange.get("wheelset_1.mass")
    with pytest.raises(fmpy.fmi1.FMICallException):
        put([mass], [1e12])
    np.testing.assert_array_equal(exchange.get("wheelset_1.mass"), before)
    fmu.exitInitializationMode()
    exchange.events()
    assert np.isfinite(exchange.rates()).all()  # of a plant that had not started it ended the process
