"""How fast does an axle follow a speed controller of mine? Designed with python-control, tried on the nonlinear bench."""

import control
import numpy as np

import rollerrig as rr
from rollerrig import _core
from rollerrig.analysis.linear_bench import steady_case
from rollerrig.interfaces.plant import assembled_model

SPEED, STEP = 100 / 3.6, 0.05  # m/s; rad/s, of the axle
COMMAND, AXLE = "wheelset_1.roller_torque_command", "wheelset_1.axle_speed"

bench = rr.linearize("adhesion_brake", SPEED, [COMMAND], [AXLE], discrete=True)
limit = control.margin(control.frd(bench, np.geomspace(1.0, 3000.0, 5000)))[0]
gain = 0.1 * limit
times = np.arange(1000) * bench.dt
_, linear = control.forced_response(control.feedback(gain * bench, 1), times, np.full(len(times), STEP))

case = steady_case(rr.load_case("adhesion_brake"), SPEED)
plant = _core.Plant(assembled_model(case, external=["rig_control", "slide_protection"], allow_unrestrained=True))
command, axle = plant.find(COMMAND), plant.find(AXLE)
plant.start()
start, measured = plant.get(axle), []
for time in times:
    measured.append(plant.get(axle) - start)
    plant.set_input(command, gain * (STEP - measured[-1]))
    plant.advance(time + bench.dt)

late = float(times[np.argmax(linear > 0.63 * STEP)])
print(f"loop at its limit at {limit:.3g} N m s/rad; with a tenth of it 63 % of the step after {1e3 * late:.0f} ms")
print(f"linear and nonlinear bench differ by at most {100 * np.abs(measured - linear).max() / STEP:.2f} % of the step")
