"""The wheel profile S1002, its slope and curvature."""

import rollerrig as rr

figure = rr.plot.profile_figure(rr.profile("s1002"))
