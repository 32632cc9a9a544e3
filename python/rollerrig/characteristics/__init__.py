"""Contact characteristics of a wheel and a rail or roller: what their profiles alone say about running.

    WHEEL, RAIL -> [pair] -> Case -> [shift] -> rolling radii, angles, positions -> [conicity] -> conicity, wavelength

The geometry is the compiled core's; here stand the table over lateral shift and the measures made from it.
"""

from rollerrig.characteristics.conicity import conicity_table, equivalent_conicity, nonlinearity_parameter
from rollerrig.characteristics.pair import pair_case
from rollerrig.characteristics.shift import shift_table

__all__ = ["conicity_table", "equivalent_conicity", "nonlinearity_parameter", "pair_case", "shift_table"]
