"""A whole brake test with the controller in a process of its own, in real time: a minute."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

import rollerrig as rr
from rollerrig import _core
from rollerrig.interfaces.plant import controller_part
from rollerrig.interfaces.realtime import Client

SERVER = """
from rollerrig.cli import main
main()
"""


@pytest.mark.long
def test_in_real_time_the_train_stops_within_half_a_percent_of_the_built_in_controllers_distance() -> None:
    """The law every 5 ms; what differs is one period from sensor to valve, and periods that a busy machine gives up."""
    case, address = rr.load_case("adhesion_brake"), f"/rollerrig_brake_test_{os.getpid()}"
    protection = _core.ControllerPlant(controller_part(case, "slide_protection"))
    protection.start()
    names = [variable.name for variable in protection.variables]
    speeds, valves = ([names.index(f"wheelset_{i}.{what}") for i in (1, 2)] for what in ("axle_speed", "valve_command"))
    options = ["--rate", "1 kHz", "--shm", address, "--patience", "200", "--outputs", "slide_protection.*,train.*"]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-c", SERVER, "serve", "adhesion_brake", *options]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as server:
        with Client(address, timeout=30.0) as rig:
            axles = [rig.outputs.index(f"slide_protection.wheelset_{i}.axle_speed") for i in (1, 2)]
            samples, own = 0, {names[k]: 0.0 for k in valves}
            for sensors in rig.sensors():
                if sensors.state == "ended":
                    break
                if sensors.time >= samples * protection.period - 1e-9:
                    for index, k in zip(speeds, axles, strict=True):
                        protection.set_input(index, sensors.values[k])
                    protection.advance((round(sensors.time / protection.period) + 1) * protection.period)
                    own = {names[k]: protection.get(k) for k in valves}
                    samples = int(sensors.time / protection.period + 1e-6) + 1
                rig.command(dict.fromkeys(rig.inputs, 0.0) | own)
        told = server.communicate(timeout=60)[0]
    assert server.returncode == 0, told
    assert "watchdog: 0 times" in told
    distance = sensors.values[rig.outputs.index("train.distance")]
    assert distance == pytest.approx(float(rr.simulate(case).train_distance[-1]), rel=5e-3)
