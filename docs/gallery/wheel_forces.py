"""Wheel-rail forces of a bogie that hunts."""

import rollerrig as rr

changes = {"motion.speed": "260 km/h", "time.duration": "1 s", "time.output_step": "10 ms"}
run = rr.simulate(rr.load_case("bogie_rollers_constant").with_changes(changes))
figure = rr.plot.wheel_forces_over_time(rr.wheel_forces(run))
