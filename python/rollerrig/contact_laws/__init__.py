"""Laws of the contact by name, and the table that one of them reads."""

from rollerrig.contact_laws.core_laws import CoreLaw, adhesion_map, contact_laws, core_law, creep_law
from rollerrig.contact_laws.table_file import CreepTableError, read_table, shipped_table, write_table

__all__ = [
    "CoreLaw",
    "CreepTableError",
    "adhesion_map",
    "contact_laws",
    "core_law",
    "creep_law",
    "read_table",
    "shipped_table",
    "write_table",
]
