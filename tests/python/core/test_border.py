"""Whatever is passed to rollerrig._core: no crash, no hang, and a sentence that names what is wrong."""

from __future__ import annotations

import ast
import copy
import dataclasses
import gc
import os
import pickle
import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import rollerrig as rr
from rollerrig import _core
from rollerrig.assembly.actuators import assemble_with_actuators
from rollerrig.assembly.model import assemble
from rollerrig.simulation.run import begin, prepare

WORKER = Path(__file__).parent / "border" / "worker.py"
SECONDS = 10.0
"""That one abuse may take, on a busy machine."""
REFUSALS = ("ValueError", "TypeError")
SIGALRM = -14


@dataclasses.dataclass
class Watched:
    """What a batch of abuses led to."""

    public: set[str] = dataclasses.field(default_factory=set)
    outcomes: dict[str, str] = dataclasses.field(default_factory=dict)
    deaths: list[str] = dataclasses.field(default_factory=list)

    @property
    def wrong(self) -> Iterator[str]:
        """Refusals that are no sentence about an argument."""
        for name, outcome in self.outcomes.items():
            if not outcome.startswith(("returned", *REFUSALS)):
                yield f"{name} -> {outcome}"


def watch(kind: str, stride: int = 1) -> Watched:
    """Run abuses in a process of their own; one that dies is named, and the next takes over behind the culprit."""
    found, first = Watched(), 0
    while len(found.deaths) < 50:
        command = [sys.executable, str(WORKER), kind, str(first), str(stride), str(SECONDS)]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
        name, index = "", -1
        for line in done.stdout.splitlines():
            word, *rest = line.split(" ", 2)
            if word == "public":
                found.public.add(rest[0])
            elif word == "begin":
                index, name = int(rest[0]), ast.literal_eval(rest[1])
            elif word == "end":
                found.outcomes[name] = ast.literal_eval(rest[1])
                name = ""
        if done.returncode == 0:
            break
        if not name:
            raise AssertionError(f"the worker failed outside the core: {done.stderr[-2000:]}")
        found.deaths.append(f"{name}: {'no end' if done.returncode == SIGALRM else f'exit code {done.returncode}'}")
        first = index + stride
    return found


@pytest.fixture(scope="module")
def calls() -> Watched:
    return watch("calls")


@pytest.mark.slow
def test_no_abuse_of_a_call_crashes_or_hangs(calls: Watched) -> None:
    assert not calls.deaths


@pytest.mark.slow
def test_every_refusal_is_a_value_or_type_error(calls: Watched) -> None:
    assert not list(calls.wrong)


@pytest.mark.slow
def test_everything_public_is_abused_beside_a_call_that_works(calls: Watched) -> None:
    valid = {
        name.removesuffix(": as it should be"): end
        for name, end in calls.outcomes.items()
        if name.endswith("should be")
    }
    assert {name: end for name, end in valid.items() if end != "returned"} == {}
    assert calls.public
    assert calls.public - set(valid) == set()


@pytest.mark.slow
def test_what_is_not_a_number_is_refused_by_the_name_of_its_argument(calls: Watched) -> None:
    outputs = ("advance: times", "advance: rows", "keep_readings: times", "keep_readings: values")  # never read
    pattern = re.compile(r"(\w+)(\[\d+\])*( = nan| full of nan = .*| ending in nan = .*) #")
    spoiled = {name: (found[1], end) for name, end in calls.outcomes.items() if (found := pattern.search(name))}
    assert len(spoiled) > 200
    for name, (argument, end) in spoiled.items():
        if any(output in name for output in outputs):
            continue
        shown = {"state": "x0", "fixed": "fixed"}.get(argument, argument)
        assert end.startswith("ValueError"), f"{name} -> {end}"
        assert shown in end, f"{name} -> {end}"


@pytest.mark.slow
def test_no_number_in_a_model_crashes_or_hangs_what_is_done_with_it() -> None:
    check_models(stride=401)


@pytest.mark.long
def test_no_number_in_a_model_at_all_crashes_or_hangs_what_is_done_with_it() -> None:
    check_models(stride=1)


def check_models(stride: int) -> None:
    """Every so many of the abuses of whole models: built, linearised, run, each with a number spoiled."""
    models = watch("models", stride)
    assert len(models.outcomes) > 15000 / stride
    assert not models.deaths
    assert not list(models.wrong)


# ---------------------------------------------------------------------------------------------------- one by one


def simulation() -> _core.Simulation:
    return _core.Simulation(assemble(rr.load_case("wheelset_rollers")).core)


def test_room_that_is_too_short_for_the_outputs_is_refused() -> None:
    model = assemble(rr.load_case("wheelset_rollers").with_changes({"time.duration": 0.1}))
    own = prepare(model)
    with pytest.raises(ValueError, match="room for 3 outputs"):
        own.advance(0.1, np.zeros(3), np.zeros((3, own.width)), 0)


def test_numbers_are_written_into_the_callers_own_arrays_or_refused() -> None:
    own = prepare(assemble(rr.load_case("wheelset_rollers").with_changes({"time.duration": 0.1})))
    with pytest.raises(TypeError):
        own.advance(0.1, np.zeros(60, dtype=np.float32), np.zeros((60, own.width)), 0)
    with pytest.raises(TypeError):
        own.advance(0.1, np.zeros(60), np.zeros((60, 2 * own.width))[:, ::2], 0)


def test_rows_before_the_first_are_refused() -> None:
    own = prepare(assemble(rr.load_case("wheelset_rollers").with_changes({"time.duration": 0.1})))
    with pytest.raises(ValueError, match="filled"):
        own.advance(0.1, np.zeros(60), np.zeros((60, own.width)), -1)


def test_a_second_thread_is_told_that_the_simulation_is_busy() -> None:
    model = assemble(rr.load_case("bogie_rollers_constant").with_changes({"time.duration": 20.0}))
    own = prepare(model)
    times, rows = np.zeros(20000), np.zeros((20000, own.width))
    state = np.array(own.state)
    running = threading.Thread(target=own.advance, args=(1.0, times, rows, 0))
    refused = []
    running.start()
    while running.is_alive():
        try:
            own.derivative(0.0, state)
            own.advance(1.0, times, rows, 0)
        except RuntimeError as error:
            refused.append(str(error))
    running.join()
    assert refused
    assert all("another thread" in text for text in refused)
    assert np.isfinite(own.derivative(0.0, state)[0]).all()


def test_objects_live_as_long_as_what_was_made_of_them() -> None:
    case = rr.load_case("adhesion_brake").with_changes({"time.duration": 0.05})
    model = assemble_with_actuators(case)
    own = prepare(model)
    begin(own, model, np.array(own.state))
    contact = _core.StaticWheelsetContact(model.core, *model.axles[0].contacts)
    del model
    gc.collect()
    assert own.advance(0.02, np.zeros(50), np.zeros((50, own.width)), 0)[0] == _core.status_codes["ok"]
    height = contact.touch_height(0.0, 0.0, 0.0, 0.0, False)
    assert contact.patches(0.0, 0.0, height - 1e-4, 0.0, 0.0, False)


@pytest.mark.parametrize("make", [copy.copy, copy.deepcopy, pickle.dumps])
def test_objects_of_the_core_are_not_copied_by_halves(make: object) -> None:
    for item in (simulation(), assemble(rr.load_case("wheelset_rollers")).core, _core.Constant(mu_0=0.3)):
        with pytest.raises(TypeError, match="pickle"):
            make(item)


def test_what_was_checked_cannot_be_changed_afterwards() -> None:
    law = _core.Falling(mu_0=0.3, A=0.4, B=0.6)
    with pytest.raises(AttributeError):
        law.mu_0 = -1.0
    body = _core.Body(
        mass=1.0, inertia=(1.0, 1.0, 1.0), position=(0.0, 0.0, 0.0), axisymmetric=False, locked=[False] * 6,
        speed_controlled_radius=0.0, in_moving_frame=True, loss_constant=0.0, loss_linear=0.0, loss_quadratic=0.0,
    )  # fmt: skip
    body.inertia[0] = -1.0  # of a copy
    assert body.inertia[0] == 1.0


class Controller:
    """A user's own slide protection that answers with what it was made of."""

    sample_time = 0.01

    def __init__(self, answer: object) -> None:
        self.answer = answer

    def step(self, measurements: dict[str, object]) -> object:
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer(measurements) if callable(self.answer) else self.answer


@pytest.mark.parametrize(
    "answer",
    [
        RuntimeError("no idea"), None, {}, {"valve": [0.0]}, {"valve": np.zeros((2, 2))}, {"valve": [np.nan, 0.0]},
        {"valve": [0.5, 0.0]}, {"valve": [3.0, 0.0]}, {"valve": ["open", "shut"]}, {"valve": [10**400, 0]}, {"valve": None},
    ],
)  # fmt: skip
def test_a_controller_that_fails_ends_the_run_with_its_name(answer: object) -> None:
    case = rr.load_case("adhesion_brake").with_changes({"time.duration": 0.05})
    run = rr.simulate(case, controllers={"slide_protection": Controller(answer)})
    assert run.attrs["status"] == "controller_failed"
    assert "slide_protection, controller Controller" in run.attrs["status_message"]


def test_a_command_that_no_actuator_takes_is_refused_by_the_core() -> None:
    case = rr.load_case("adhesion_brake").with_changes({"time.duration": 0.05})
    model = assemble_with_actuators(case)
    own = prepare(model, {"slide_protection": Controller(None)})
    own.advance(0.05, np.zeros(50), np.zeros((50, own.width)), 0)
    assert own.waits_for("slide_protection")
    for command in ([np.nan, 0.0], [0.5, 0.0], [3.0, 0.0], [0.0], []):
        with pytest.raises(ValueError, match="command"):
            own.set_command("slide_protection", command)
    with pytest.raises(ValueError, match="nonsense"):
        own.set_command("nonsense", [0.0, 0.0])
    own.set_command("slide_protection", [0.0, 2.0])


def test_a_controller_may_look_at_its_simulation_and_call_it_back() -> None:
    case = rr.load_case("adhesion_brake").with_changes({"time.duration": 0.05})
    nested: list[str] = []

    def calls_back(measurements: dict[str, object]) -> dict[str, object]:
        del measurements
        nested.append(
            rr.simulate(rr.load_case("wheelset_rollers").with_changes({"time.duration": 0.01})).attrs["status"]
        )
        return {"valve": [0.0, 0.0]}

    run = rr.simulate(case, controllers={"slide_protection": Controller(calls_back)})
    assert run.attrs["status"] == "ok"
    assert nested
    assert set(nested) == {"ok"}
