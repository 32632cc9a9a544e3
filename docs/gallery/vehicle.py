"""A bogie on the rig: bodies, springs and dampers, axes and senses of turning."""

import rollerrig as rr

figure = rr.plot.vehicle("adhesion_brake")
