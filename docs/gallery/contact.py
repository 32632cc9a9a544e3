"""Contact of a wheelset with the rails over its lateral shift."""

import rollerrig as rr

figure = rr.plot.contact_figure(rr.contact("contact_benchmark_track"))
