"""Analysis of the contact alone: static contact of a wheelset, creep laws on one ellipse, rolling radii and equivalent conicity.

Case, positions -> [static_contact] -> patches -> [comparison, creep_comparison] -> models side by side
WHEEL, RAIL -> [pair] -> Case -> [shift] -> rolling radii, angles -> [conicity] -> conicity, wavelength
a/b, laws -> [creep_laws] -> forces beside the exact theory
"""

from rollerrig.contact_analysis.conicity import conicity_table as conicity_table
from rollerrig.contact_analysis.conicity import equivalent_conicity as equivalent_conicity
from rollerrig.contact_analysis.conicity import nonlinearity_parameter as nonlinearity_parameter
from rollerrig.contact_analysis.conicity import shift_table as shift_table
from rollerrig.contact_analysis.static_contact import pair_case as pair_case
