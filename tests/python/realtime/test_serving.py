"""A rig on the loopback and a controller: the same run as in one process, and what happens when one of them misbehaves."""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from python.realtime.running import Running, brake_case
from rollerrig import _core, load_case, simulate
from rollerrig.config import ConfigError
from rollerrig.interfaces.realtime import Client, ClientError
from rollerrig.interfaces.realtime.links import SHARED_MEMORY, Rings
from rollerrig.interfaces.realtime.server import Served, check_rate, open_server, replay, serve_case

Serve = Callable[..., Running]


class Pulses:
    """Vents an axle that is slower than the other, in the process of the rig."""

    sample_time = 5e-3

    def step(self, measurements: dict[str, Any]) -> dict[str, Any]:
        return {"valve": valves(measurements["axle_speed"])}


def valves(speed: Any) -> list[float]:
    return [2.0 if s < 0.97 * max(speed) else float(k % 2) for k, s in enumerate(speed)]


def drive(running: Running) -> list[np.ndarray]:
    """The same rule over the network; all sensors."""
    found = []
    with Client(running.address, timeout=20.0) as rig:
        places = [rig.outputs.index(f"slide_protection.wheelset_{i}.axle_speed") for i in (1, 2)]
        demand = dict.fromkeys(rig.inputs, 0.0)
        for sensors in rig.sensors():
            found.append(np.array(sensors.values))
            if sensors.state == "ended":
                break
            for i, valve in enumerate(valves([sensors.values[k] for k in places])):
                demand[f"wheelset_{i + 1}.valve_command"] = valve
            rig.command(demand)
    return found


PLACES = ("127.0.0.1", f"/rollerrig_test_{os.getpid()}")


@pytest.mark.parametrize("address", PLACES, ids=["udp", "shared memory"])
def test_in_lock_step_the_run_is_that_of_one_process_bit_for_bit(
    serve: Serve, served_brake: Served, address: str
) -> None:
    running = serve(served_brake, address, lock_step=True, record=True)
    found = drive(running)
    assert running.join().ending == "ran"
    rows = running.server.sensors()
    np.testing.assert_array_equal(np.array(found)[-len(rows) :], rows)
    run = simulate(brake_case(), controllers={"slide_protection": Pulses()})
    names = [v.name for v in served_brake.outputs]
    for name in ("train.speed", "train.distance"):
        column = rows[:, names.index(name)]
        # at the end of a run nobody is asked any more; the server has read its sensors, and the virtual train is a sample ahead
        np.testing.assert_array_equal(column[:-1], run[name.replace(".", "_")].to_numpy()[:-1])
    assert running.server.statistics()["frames"]["accepted"] == 200


def test_recorded_commands_give_the_same_bytes(serve: Serve, served_brake: Served) -> None:
    running = serve(served_brake, at_once=True, lock_step=True, record=True)
    running.join()
    again = replay(served_brake, running.server.commands())
    assert again.tobytes() == running.server.sensors().tobytes()


def test_in_real_time_a_run_takes_its_time_and_counts_its_deadlines(serve: Serve, served_brake: Served) -> None:
    begun = time.monotonic()
    running = serve(served_brake, patience=1000)
    drive(running)
    assert time.monotonic() - begun >= 1.0
    running.join()
    told = running.server.statistics()
    assert told["periods"] == told["step"][0] == 200
    assert told["wake"][0] == 200 + told["waited"]
    assert told["frames"]["accepted"] > 20  # a client on a busy machine answers the newest sensors only
    assert told["time"] == pytest.approx(1.0)


def test_a_silent_controller_brings_the_safe_state_and_a_command_takes_the_rig_up_again(
    serve: Serve, served_brake: Served
) -> None:
    """Only what holds on a busy machine: each period one by one is in tests/core/realtime."""
    running = serve(served_brake, patience=20, ramp=0.05, record=True)
    asked, phases = [1e4, 1e4, 1.0, 1.0], ["waiting"]
    with Client(running.address, timeout=20.0) as rig:
        for sensors in rig.sensors():
            if sensors.state != phases[-1]:
                phases.append(sensors.state)
            if sensors.time < 0.1 or "safe" in phases:
                rig.command(asked, rearm=sensors.time > 0.5)
    running.join()
    assert phases[0] == "waiting"
    assert phases.index("running") < phases.index("safe") < len(phases) - 1 - phases[::-1].index("running")
    assert phases[-1] == "ended"
    told = running.server.statistics()
    assert told["trips"] >= 1
    commands = running.server.commands()
    assert (commands[0] == asked).all()
    assert (commands[-1] == asked).all()
    assert (commands == 0.0).all(axis=1).any()
    ramp = commands[(commands[:, 0] > 0.0) & (commands[:, 0] < 1e4)]
    np.testing.assert_allclose(ramp[:9, 0], 1e4 * np.arange(9, 0, -1) / 10, rtol=1e-12)
    assert (ramp[:, 2] == 0.0).all()


def test_noise_on_the_port_is_counted_and_changes_nothing(serve: Serve, served_brake: Served) -> None:
    random = np.random.default_rng(1)
    running = serve(served_brake, lock_step=True)
    host, port = running.address.split(":")
    with Client(running.address, timeout=20.0) as rig, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        rig.receive()
        for _ in range(40):
            for _ in range(10):
                stranger.sendto(random.bytes(random.integers(0, 200)), (host, int(port)))
            rig.command([0.0] * 4)
            rig.receive()
        with pytest.raises(ClientError, match="another controller"):
            Client(running.address, timeout=1.0)
        running.server.stop()
    assert running.join().ending == "stopped_by_caller"
    frames = running.server.statistics()["frames"]
    assert frames["accepted"] == 40
    assert frames["wrong_length"] + frames["foreign"] == 400
    assert frames["refused"] >= 1


def test_nobody_there_is_one_sentence() -> None:
    with pytest.raises(ClientError, match="nobody answers"):
        Client("127.0.0.1:9", timeout=0.2)


def test_commands_by_name_are_all_needed(serve: Serve, served_brake: Served) -> None:
    running = serve(served_brake, lock_step=True)
    with Client(running.address, timeout=20.0) as rig:
        assert rig.description["period"] == 0.005
        assert [one["unit"] for one in rig.description["inputs"]] == ["Pa", "Pa", "1", "1"]
        assert {one["measured"] for one in rig.description["outputs"]} == {True, False}
        with pytest.raises(ValueError, match="commands needed"):
            rig.command({"wheelset_1.valve_command": 1.0})
        with pytest.raises(ValueError, match="4 commands"):
            rig.command([0.0])


def test_sensors_have_the_noise_and_steps_of_the_case() -> None:
    teeth = {"sensors.vehicle": {"kind": "pulse_period", "teeth": 80}}
    exact, coarse = (serve_case(brake_case(**changes), "200 Hz") for changes in ({}, teeth))
    commands = np.zeros((100, 4))
    column = [v.name for v in exact.outputs].index("slide_protection.wheelset_1.axle_speed")
    speeds = [replay(served, commands)[:, column] for served in (exact, coarse)]
    assert 1e-6 < np.abs(speeds[0][1:] - speeds[1][1:]).max() < 1.0


def test_shared_memory_holds_frames_and_noise_apart(serve: Serve, served_brake: Served) -> None:
    """A writer beside the controller's client: whatever stands in its ring, the server goes on."""
    random = np.random.default_rng(2)
    running = serve(served_brake, PLACES[1], lock_step=True)
    with Client(running.address, timeout=20.0) as rig:
        rig.receive()
        memory = np.memmap(SHARED_MEMORY / PLACES[1][1:], mode="r+")
        for k in range(200):
            ring = memory[64 + Rings.RING + 64 :]
            at = random.integers(0, 8 * Rings.SLOT, 50) // 2 * 2
            ring[at] = random.integers(0, 256, 50)
            rig.command([0.0] * 4)
            rig.receive()
            if k == 100:
                memory[64 + Rings.RING : 64 + Rings.RING + 8] = 255  # frames written: more than there can be
                memory[64 + Rings.RING : 64 + Rings.RING + 8] = 0
        running.server.stop()
    assert running.join().ending in ("stopped_by_caller", "ran")
    assert not (SHARED_MEMORY / PLACES[1][1:]).exists() or running.server


def test_the_memory_is_gone_with_its_server(served_brake: Served) -> None:
    name = f"{PLACES[1]}_gone"
    server = open_server(served_brake, name, 0)
    assert (SHARED_MEMORY / name[1:]).exists()
    with pytest.raises(ConfigError, match=rf"shm: {name}; .*remove /dev/shm{name}"):
        open_server(served_brake, name, 0)
    del server
    assert not (SHARED_MEMORY / name[1:]).exists()


# ---------------------------------------------------------------------------------------------------- refusals


def test_a_system_without_a_server_is_told_by_name(served_brake: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> None:
        raise RuntimeError("not on this system: the server in real time is written for Linux")

    monkeypatch.setattr(_core, "require_real_time", missing)
    for attempt in (check_rate, lambda served: open_server(served, "127.0.0.1", 0)):
        with pytest.raises(ConfigError, match=r"serve: \w+; not on this system: .* for Linux"):
            attempt(served_brake)


def test_a_port_in_use_is_refused(serve: Serve, served_brake: Served) -> None:
    running = serve(served_brake, lock_step=True)
    with pytest.raises(ConfigError, match=rf"udp: {running.address}; .*in use"):
        open_server(served_brake, "127.0.0.1", running.server.port)


def test_a_rate_that_one_core_cannot_hold_is_refused_with_what_it_can() -> None:
    served = serve_case(brake_case(**{"time.sampling_step": 1e-5, "time.duration": 0.005}), "100 kHz")
    with pytest.raises(ConfigError, match=r"rate: 100 kHz; one core of this machine holds [\d.]+ kHz"):
        check_rate(served)


def test_without_a_controller_rollers_keep_the_speed_of_the_case() -> None:
    case = load_case("bogie_rollers_constant")
    served = serve_case(case)
    safe = {v.name: value for v, value in zip(served.inputs, served.safe, strict=True)}
    assert safe == {"run.speed_command": case.motion.speed, "run.speed_rise_time": 0.1}


@pytest.mark.parametrize(
    ("changes", "options", "message"),
    [
        ({}, {"rate": "1.5 kHz"}, "multiple of time.sampling_step, 1 ms; the nearest is 1 kHz"),
        ({}, {"rate": "fast"}, "allowed: a rate like '1 kHz'"),
        ({}, {"external": ["slide_protecton"]}, "did you mean 'slide_protection'"),
        ({}, {"outputs": ["train.sped"]}, "did you mean 'train.speed'"),
        ({}, {"safe": {"wheelset_1.valve": 1.0}}, "did you mean 'wheelset_1.valve_command'"),
        ({}, {"safe": {"wheelset_1.valve_command": 1.5}}, "allowed: a whole number from 0 to 2"),
        ({"slide_protection.user": "mine:Mine"}, {}, "two controllers for one command"),
        ({}, {"outputs": ["*"]}, ""),
    ],
)
def test_bad_input_is_refused_by_name(changes: dict[str, Any], options: dict[str, Any], message: str) -> None:
    case = brake_case(**changes)
    rate = options.pop("rate", "1 kHz")
    if not message:
        assert len(serve_case(case, rate, **options).outputs) > 200
        return
    with pytest.raises(ConfigError) as refused:
        serve_case(case, rate, **options)
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)
