"""Figures: one function per figure, results in, matplotlib Figure out; no physics is computed here.

With `axes=` they draw into axes of your own and return these: one, or several for a figure of several panels, from its top.

Datasets of run and analysis -> [plot] -> Figure -> report, files
"""

from rollerrig.plot.contact import (
    comparison_figure,
    contact_figure,
    creep_comparison_figure,
    creep_figure,
    profile_figure,
)
from rollerrig.plot.hunting import (
    amplitude_over_speed,
    bifurcation_diagram,
    hunting_over_time,
    limit_cycle_diagram,
    ramp_over_speed,
    tornado_diagram,
    traction_forces,
    traction_sliding,
)
from rollerrig.plot.modes import (
    damping_map,
    damping_over_speed,
    frequency_over_speed,
    mode_shape,
    mode_shapes,
    root_locus,
    shape_speed,
)
from rollerrig.plot.run import curving_over_radius, energy_over_time, motion_over_time, runs_together, sliding_over_time
from rollerrig.plot.style import figure_bytes
from rollerrig.plot.vehicle import vehicle
from rollerrig.plot.wheel_rail_forces import accelerations_along, line_and_response, quotient, track_shifting, wear
from rollerrig.plot.wheel_rail_forces import wheel_forces as wheel_forces_over_time

__all__ = [
    "accelerations_along",
    "amplitude_over_speed",
    "bifurcation_diagram",
    "comparison_figure",
    "contact_figure",
    "creep_comparison_figure",
    "creep_figure",
    "curving_over_radius",
    "damping_map",
    "damping_over_speed",
    "energy_over_time",
    "figure_bytes",
    "frequency_over_speed",
    "hunting_over_time",
    "limit_cycle_diagram",
    "line_and_response",
    "mode_shape",
    "mode_shapes",
    "motion_over_time",
    "profile_figure",
    "quotient",
    "ramp_over_speed",
    "root_locus",
    "runs_together",
    "shape_speed",
    "sliding_over_time",
    "tornado_diagram",
    "track_shifting",
    "traction_forces",
    "traction_sliding",
    "vehicle",
    "wear",
    "wheel_forces_over_time",
]
