"""Figures: one function per figure, results in, matplotlib Figure out; no physics is computed here.

Datasets of run and analysis -> [plot] -> Figure -> report, files
"""

from rollerrig.plot.hunting import amplitude_over_speed, hunting_over_time, ramp_over_speed
from rollerrig.plot.limit_cycle import limit_cycle_diagram
from rollerrig.plot.modes import damping_map, damping_over_speed, frequency_over_speed, root_locus
from rollerrig.plot.shapes import mode_shape, mode_shapes
from rollerrig.plot.style import figure_bytes
from rollerrig.plot.traction import traction_forces, traction_sliding

__all__ = [
    "amplitude_over_speed",
    "damping_map",
    "damping_over_speed",
    "figure_bytes",
    "frequency_over_speed",
    "hunting_over_time",
    "limit_cycle_diagram",
    "mode_shape",
    "mode_shapes",
    "ramp_over_speed",
    "root_locus",
    "traction_forces",
    "traction_sliding",
]
