"""Which stiffness and damping moves the critical speed of a bogie on track."""

import rollerrig as rr

figure = rr.plot.tornado_diagram(rr.stability_sensitivity("bogie_track", speeds_kmh=[260, 270]))
