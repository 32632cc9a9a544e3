"""Damping of a bogie's modes over speed: above the speed at which a line crosses zero it hunts."""

import rollerrig as rr

figure = rr.plot.damping_over_speed(rr.stability("bogie_rollers_constant", [100.0, 150.0, 200.0, 250.0, 300.0]))
