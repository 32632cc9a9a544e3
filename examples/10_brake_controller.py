"""Does a brake controller in a process of its own stop the train where the built-in one does?"""

import subprocess
import sys

import rollerrig as rr
from rollerrig import _core
from rollerrig.interfaces.plant import controller_part
from rollerrig.interfaces.realtime import Client

PORT = "127.0.0.1:50105"
case = rr.load_case("adhesion_brake")
protection = _core.ControllerPlant(controller_part(case, "slide_protection"))
protection.start()
names = [variable.name for variable in protection.variables]
speeds, valves = ([names.index(f"wheelset_{i}.{what}") for i in (1, 2)] for what in ("axle_speed", "valve_command"))

# The rig: a server in lock-step, faster than real time. Without --lock-step the same program drives it in real time.
command = [sys.executable, "-c", "from rollerrig.cli import main; main()", "serve", "adhesion_brake", "--lock-step"]
with subprocess.Popen(
    [*command, "--rate", "200 Hz", "--udp", PORT, "--outputs", "slide_protection.*,train.*"]
) as server:
    with Client(PORT, timeout=30.0) as rig:
        axles = [rig.outputs.index(f"slide_protection.wheelset_{i}.axle_speed") for i in (1, 2)]
        distance, speed = rig.outputs.index("train.distance"), rig.outputs.index("train.speed")
        for sensors in rig.sensors():
            if sensors.state != "ended":
                for speed_input, k in zip(speeds, axles, strict=True):
                    protection.set_input(speed_input, sensors.values[k])
                protection.advance((round(sensors.time / protection.period) + 1) * protection.period)
                rig.command(dict.fromkeys(rig.inputs, 0.0) | {names[k]: protection.get(k) for k in valves})
    server.wait()

run = rr.simulate(case)
over_network, built_in = sensors.values[distance], float(run.train_distance[-1])
print(f"after {sensors.time:.3f} s at {3.6 * sensors.values[speed]:.1f} km/h")
print(
    f"controller outside: {over_network:.2f} m, built in: {built_in:.2f} m, {100 * (over_network / built_in - 1):+.3f} %"
)
