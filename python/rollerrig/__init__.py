"""rollerrig: a roller rig for railway bogies, in software.

    load_case -> Case -> simulate  -> xarray.Dataset -> save_run, figures, report
                      -> stability -> xarray.Dataset
    run -> wheel_forces -> Y, Q, Y/Q, wear number

Names are loaded when first used, so that `import rollerrig` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rollerrig.analysis.stability import stability
    from rollerrig.analysis.wheel_rail_forces import wheel_forces
    from rollerrig.assembly import assemble
    from rollerrig.catalog import catalog_entries, catalog_text
    from rollerrig.config import Case, ConfigError, load_case
    from rollerrig.contact_table import contact_table
    from rollerrig.results import OutputError, load_run, save_run
    from rollerrig.simulation import simulate
    from rollerrig.starting_state import StartError
    from rollerrig.studies.envelope import envelope

__version__ = "0.1.0"

_HOME = {
    "Case": "config",
    "ConfigError": "config",
    "OutputError": "results",
    "StartError": "starting_state",
    "assemble": "assembly",
    "catalog_entries": "catalog",
    "catalog_text": "catalog",
    "contact_table": "contact_table",
    "envelope": "studies.envelope",
    "load_case": "config",
    "load_run": "results",
    "wheel_forces": "analysis",
    "save_run": "results",
    "simulate": "simulation",
    "stability": "analysis",
}
"""Module that defines each public name."""

__all__ = [
    "Case",
    "ConfigError",
    "OutputError",
    "StartError",
    "__version__",
    "assemble",
    "catalog_entries",
    "catalog_text",
    "contact_table",
    "envelope",
    "load_case",
    "load_run",
    "save_run",
    "simulate",
    "stability",
    "wheel_forces",
]


def __getattr__(name: str) -> Any:
    """A public name, from the module that defines it."""
    if name not in _HOME:
        raise AttributeError(f"module 'rollerrig' has no attribute {name!r}")
    value = getattr(import_module(f"rollerrig.{_HOME[name]}"), name)
    globals()[name] = value  # also where a submodule of the same name has just been bound
    return value


def __dir__() -> list[str]:
    """Public names, for completion."""
    return sorted(__all__)
