"""A whole brake test with the controller in a process of its own, in real time: a minute."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

import rollerrig as rr
from rollerrig.interfaces.plant import SlideProtection
from rollerrig.interfaces.realtime import Client

SERVER = """
from rollerrig.cli import main
main()
"""


@pytest.mark.long
def test_in_real_time_the_train_stops_within_half_a_percent_of_the_built_in_controllers_distance() -> None:
    """The law every 5 ms; what differs is one period from sensor to valve, and periods that a busy machine gives up."""
    case, address = rr.load_case("adhesion_brake"), f"/rollerrig_brake_test_{os.getpid()}"
    protection = SlideProtection(case)
    options = ["--rate", "1 kHz", "--shm", address, "--patience", "200", "--outputs", "slide_protection.*,train.*"]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-c", SERVER, "serve", "adhesion_brake", *options]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as server:
        with Client(address, timeout=30.0) as rig:
            axles = [rig.outputs.index(f"slide_protection.wheelset_{i}.axle_speed") for i in (1, 2)]
            samples, valves = 0, [0.0, 0.0]
            for sensors in rig.sensors():
                if sensors.state == "ended":
                    break
                if sensors.time >= samples * protection.sample_time - 1e-9:
                    valves = protection.step(sensors.time, [sensors.values[k] for k in axles])
                    samples = int(sensors.time / protection.sample_time + 1e-6) + 1
                own = {f"wheelset_{i}.valve_command": valve for i, valve in zip((1, 2), valves, strict=True)}
                rig.command(dict.fromkeys(rig.inputs, 0.0) | own)
        told = server.communicate(timeout=60)[0]
    assert server.returncode == 0, told
    assert "watchdog" not in told
    distance = sensors.values[rig.outputs.index("train.distance")]
    assert distance == pytest.approx(float(rr.simulate(case).train_distance[-1]), rel=5e-3)
