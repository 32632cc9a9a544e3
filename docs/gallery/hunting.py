"""A bogie on rollers released from 3 mm: at 150 km/h its motion decays."""

import rollerrig as rr

case = rr.load_case("bogie_rollers_constant").with_changes({"time.duration": "3 s", "time.output_step": "10 ms"})
figure = rr.plot.motion_over_time(rr.simulate(case))
