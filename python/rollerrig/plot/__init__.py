"""Figures: one function per figure, results in, matplotlib Figure out; no physics is computed here.

With `axes=` they draw into axes of your own and return these: one, or several for a figure of several panels, from its top.

Datasets of run and analysis -> [plot] -> Figure -> report, files
"""

from inspect import isfunction

from rollerrig.plot.contact import comparison_figure as comparison_figure
from rollerrig.plot.contact import contact_figure as contact_figure
from rollerrig.plot.contact import creep_comparison_figure as creep_comparison_figure
from rollerrig.plot.contact import creep_figure as creep_figure
from rollerrig.plot.contact import profile_figure as profile_figure
from rollerrig.plot.hunting import amplitude_over_speed as amplitude_over_speed
from rollerrig.plot.hunting import bifurcation_diagram as bifurcation_diagram
from rollerrig.plot.hunting import hunting_over_time as hunting_over_time
from rollerrig.plot.hunting import limit_cycle_diagram as limit_cycle_diagram
from rollerrig.plot.hunting import ramp_over_speed as ramp_over_speed
from rollerrig.plot.hunting import tornado_diagram as tornado_diagram
from rollerrig.plot.hunting import traction_forces as traction_forces
from rollerrig.plot.hunting import traction_sliding as traction_sliding
from rollerrig.plot.modes import damping_map as damping_map
from rollerrig.plot.modes import damping_over_speed as damping_over_speed
from rollerrig.plot.modes import frequency_over_speed as frequency_over_speed
from rollerrig.plot.modes import mode_shapes as mode_shapes
from rollerrig.plot.modes import root_locus as root_locus
from rollerrig.plot.modes import shape_speed as shape_speed
from rollerrig.plot.run import curving_over_radius as curving_over_radius
from rollerrig.plot.run import energy_over_time as energy_over_time
from rollerrig.plot.run import motion_over_time as motion_over_time
from rollerrig.plot.run import runs_together as runs_together
from rollerrig.plot.run import sliding_over_time as sliding_over_time
from rollerrig.plot.style import figure_bytes as figure_bytes
from rollerrig.plot.vehicle import vehicle as vehicle
from rollerrig.plot.wheel_rail_forces import accelerations_along as accelerations_along
from rollerrig.plot.wheel_rail_forces import line_and_response as line_and_response
from rollerrig.plot.wheel_rail_forces import quotient as quotient
from rollerrig.plot.wheel_rail_forces import track_shifting as track_shifting
from rollerrig.plot.wheel_rail_forces import wear as wear
from rollerrig.plot.wheel_rail_forces import wheel_forces_over_time as wheel_forces_over_time

__all__ = [name for name, value in dict(globals()).items() if isfunction(value) and name != "isfunction"]
"""All of them."""
