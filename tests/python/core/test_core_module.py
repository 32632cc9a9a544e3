"""The compiled module as Python sees it: what it refuses, what it promises."""

from __future__ import annotations

import gc
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from rollerrig import _core
from rollerrig.assembly.model import AssembledModel, assemble, axle_torque
from rollerrig.config import load_case


@pytest.fixture(scope="module")
def simulation() -> _core.Simulation:
    return _core.Simulation(assemble(load_case("wheelset_rollers")).core)


def start(simulation: _core.Simulation, x0: np.ndarray, **given: object) -> None:
    arguments: dict[str, object] = {
        "method": "rodas4", "step": 0.0, "relative_tolerance": 1e-6, "absolute_tolerance": [1e-9], "initial_step": 0.0,
        "maximum_step": 0.01, "final_time": 0.1, "output_step": 0.01, "breakpoints": [],
    }  # fmt: skip
    simulation.start(_core.Options(**arguments | given), t0=0.0, x0=x0)


def test_a_state_of_the_wrong_length_is_refused(simulation: _core.Simulation) -> None:
    short = np.zeros(simulation.state_count - 1)
    for call in (simulation.derivative, simulation.jacobian):
        with pytest.raises(ValueError, match="one value per state"):
            call(0.0, short)
    with pytest.raises(ValueError, match="one value per state"):
        start(simulation, short)


def test_an_unknown_method_names_the_known_ones(simulation: _core.Simulation) -> None:
    with pytest.raises(ValueError, match="rk4, exponential_rk4, exponential_adams, dormand_prince, rodas4"):
        start(simulation, np.zeros(simulation.state_count), method="euler")


def test_a_creep_table_of_the_wrong_size_is_refused() -> None:
    with pytest.raises(ValueError, match="coefficients"):
        _core.CreepTable.of(2.3, 1.5, 4, (2, 2, 2), np.zeros(10, dtype=np.float32))


def test_an_item_that_does_not_exist_is_refused() -> None:
    parts = AssembledModel(load_case("wheelset_rollers")).parts
    with pytest.raises(ValueError, match="axle torque 0: wheelset: there is no body 3"):
        _core.model_of(_core.ModelParts(**parts | {"axle_torques": [axle_torque(3, -1, [])]}))
    with pytest.raises(ValueError, match="speed must be given at increasing points"):
        _core.ModelParts(**parts | {"speed": [(1.0, 20.0), (0.0, 20.0)]})


def test_advancing_before_the_start_is_refused() -> None:
    fresh = _core.Simulation(assemble(load_case("wheelset_rollers")).core)
    with pytest.raises(ValueError, match="start"):
        fresh.advance(1.0, np.zeros(1), np.zeros((1, fresh.width)), 0)
    with pytest.raises(ValueError, match="start"):
        _ = fresh.state


def test_a_simulation_keeps_its_model_alive() -> None:
    own = _core.Simulation(assemble(load_case("wheelset_rollers")).core)
    gc.collect()
    assert own.equilibrium(20.0, 0.0, [])["converged"]


def test_the_row_is_as_wide_as_its_fields_say(simulation: _core.Simulation) -> None:
    assembled = assemble(load_case("wheelset_rollers"))
    bodies, wheels, elements = len(assembled.bodies), len(assembled.wheels), len(assembled.elements)
    assert simulation.width == (
        bodies * len(_core.body_fields)
        + wheels * (len(_core.wheel_fields) + _core.patches_recorded * len(_core.patch_fields))
        + elements * len(_core.element_fields)
        + len(_core.run_fields)
    )


def test_every_status_has_a_sentence_with_a_remedy() -> None:
    assert _core.status_codes["ok"] == 0
    sentences = {name: _core.status_sentence(code) for name, code in _core.status_codes.items()}
    assert len(set(sentences.values())) == len(sentences)
    assert all(sentence.endswith(".") and len(sentence) > 30 for sentence in sentences.values())


def test_asking_for_outputs_changes_no_bit_of_a_run() -> None:
    """Two runs, one with a hundred times the outputs: the same end, to the last bit."""
    assembled = assemble(load_case("wheelset_rollers"))
    ends = []
    for output_step in (0.1, 0.001):
        run = _core.Simulation(assembled.core)
        x0 = run.equilibrium(40.0, 0.0, [(assembled.body_index("wheelset_1"), 1, 2e-3)])["x"]
        start(run, x0, output_step=output_step)
        times, rows = np.zeros(200), np.zeros((200, run.width))
        status, _ = run.advance(0.1, times, rows, 0)
        assert status == 0
        ends.append(run.state)
    assert np.array_equal(ends[0], ends[1])


def test_two_runs_of_one_input_are_equal_to_the_last_bit() -> None:
    assembled = assemble(load_case("wheelset_rollers"))
    results = []
    for _ in range(2):
        run = _core.Simulation(assembled.core)
        x0 = run.equilibrium(40.0, 0.0, [])["x"].copy()
        x0[1] += 1e-3
        start(run, x0)
        times, rows = np.zeros(20), np.zeros((20, run.width))
        run.advance(0.1, times, rows, 0)
        results.append(rows.copy())
    assert np.array_equal(results[0], results[1], equal_nan=True)


def test_a_run_cut_into_slices_is_the_run_in_one_piece() -> None:
    """The integrator stops at outputs and slices by interpolation or on its own grid, never by a changed step."""
    assembled = assemble(load_case("wheelset_rollers"))
    ends = []
    for slices in (1, 7):
        run = _core.Simulation(assembled.core)
        x0 = run.equilibrium(40.0, 0.0, [])["x"].copy()
        x0[1] += 1e-3
        start(run, x0)
        times, rows, filled = np.zeros(20), np.zeros((20, run.width)), 0
        for stop in np.linspace(0.0, 0.1, slices + 1)[1:]:
            status, filled = run.advance(float(stop), times, rows, filled)
            assert status == 0
        ends.append((times[:filled].copy(), rows[:filled].copy()))
    assert np.array_equal(ends[0][0], ends[1][0])
    assert np.array_equal(ends[0][1], ends[1][1], equal_nan=True)


def test_runs_of_one_model_in_two_threads_give_the_bytes_of_runs_one_after_the_other() -> None:
    core = assemble(load_case("bogie_rollers_constant")).core

    def end_of_run(offset: float) -> bytes:
        run = _core.Simulation(core)
        x0 = run.equilibrium(40.0, 0.0, [])["x"].copy()
        x0[1] += offset
        start(run, x0, method="exponential_rk4", step=2e-4)
        rows = np.zeros((20, run.width))
        assert run.advance(0.1, np.zeros(20), rows, 0) == (0, 11)
        return rows.tobytes()

    offsets = [1e-3, -2e-3, 3e-3, 0.5e-3]
    with ThreadPoolExecutor(max_workers=2) as threads:
        together = list(threads.map(end_of_run, offsets))
    assert together == [end_of_run(offset) for offset in offsets]


def test_a_model_at_another_speed_outlives_the_one_it_was_made_from() -> None:
    assembled = assemble(load_case("bogie_track"))
    faster = assembled.core.with_speed([(0.0, 30.0)])
    del assembled
    gc.collect()
    assert _core.Simulation(faster).equilibrium(30.0, 0.0, [])["converged"]


def test_an_equilibrium_near_a_state_alone_is_found_at_once_or_not_at_all() -> None:
    assembled = assemble(load_case("bogie_track"))
    run, speed = _core.Simulation(assembled.core), assembled.case.motion.speed
    rest = run.equilibrium(speed, 0.0, [])
    again = run.equilibrium(speed, 0.0, [], rest["x"], only_near=True)
    assert again["converged"]
    assert again["iterations"] <= 2
    np.testing.assert_allclose(again["x"], rest["x"], atol=1e-9)
    far = rest["x"].copy()
    far[run.coordinate_index[assembled.body_index("wheelset_1")][1]] += 0.02  # beyond its flange
    assert not run.equilibrium(speed, 0.0, [], far, only_near=True)["converged"]
    assert run.equilibrium(speed, 0.0, [], far)["converged"]
