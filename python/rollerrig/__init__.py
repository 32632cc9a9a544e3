"""rollerrig: a roller rig for railway bogies, in software.

    load_case -> Case -> simulate -> xarray.Dataset -> save_run, plot
                      -> stability, critical_speed, limit_cycle -> xarray.Dataset
                      -> linearize -> control.StateSpace
    run -> wheel_forces -> Y, Q, Y/Q, wear number
                      -> envelope, sweep -> xarray.Dataset
    response, adhesion, wsp, control, lateral, compare, scale -> Outcome -> write(folder)

Every command of the command line is a function here, under the same name; `plot` draws what they return. Names are loaded when
first used, so that `import rollerrig` costs nothing. No public object has the name of a module.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rollerrig import plot as plot
    from rollerrig.analysis.curving import curving as curving
    from rollerrig.analysis.linear_bench import linearize as linearize
    from rollerrig.analysis.mode_table import stability as stability
    from rollerrig.analysis.runs_together import compare_runs as compare_runs
    from rollerrig.analysis.wheel_rail_forces import wheel_forces as wheel_forces
    from rollerrig.assembly.model import assemble as assemble
    from rollerrig.catalog import catalog_entries as catalog_entries
    from rollerrig.catalog import catalog_text as catalog_text
    from rollerrig.catalog.starting_case import starting_case as starting_case
    from rollerrig.cli.commands import adhesion as adhesion
    from rollerrig.cli.commands import compare as compare
    from rollerrig.cli.commands import conicity as conicity
    from rollerrig.cli.commands import contact as contact
    from rollerrig.cli.commands import control as control
    from rollerrig.cli.commands import creep as creep
    from rollerrig.cli.commands import envelope as envelope
    from rollerrig.cli.commands import lateral as lateral
    from rollerrig.cli.commands import limit_cycle as limit_cycle
    from rollerrig.cli.commands import paper as paper
    from rollerrig.cli.commands import response as response
    from rollerrig.cli.commands import scale as scale
    from rollerrig.cli.commands import sweep as sweep
    from rollerrig.cli.commands import wsp as wsp
    from rollerrig.config import Case as Case
    from rollerrig.config import ConfigError as ConfigError
    from rollerrig.config import explain as explain
    from rollerrig.config import json_schema as json_schema
    from rollerrig.config import load_case as load_case
    from rollerrig.contact_analysis.profile_curve import profile as profile
    from rollerrig.interfaces.fmu.export import export_fmu as export_fmu
    from rollerrig.interfaces.fmu.export import export_part as export_part
    from rollerrig.interfaces.plant import assemble_file as assemble_file
    from rollerrig.interfaces.plant import read_model as read_model
    from rollerrig.interfaces.realtime.server import serve as serve
    from rollerrig.results import OutputError as OutputError
    from rollerrig.results import ResultsError as ResultsError
    from rollerrig.results import RunInfo as RunInfo
    from rollerrig.results import cite as cite
    from rollerrig.results import export as export
    from rollerrig.results import load_run as load_run
    from rollerrig.results import save_run as save_run
    from rollerrig.results.in_words import summary as summary
    from rollerrig.simulation.run import simulate as simulate
    from rollerrig.simulation.starting_state import StartError as StartError
    from rollerrig.study.limit_cycles import critical_speed as critical_speed
    from rollerrig.viewer import view as view
    from rollerrig.viewer.play import play as play

__version__ = "0.1.0"

_HOME = {
    "Case": "config",
    "ConfigError": "config",
    "OutputError": "results",
    "ResultsError": "results",
    "RunInfo": "results",
    "StartError": "simulation.starting_state",
    "adhesion": "cli.commands",
    "assemble": "assembly.model",
    "assemble_file": "interfaces.plant",
    "catalog_entries": "catalog",
    "catalog_text": "catalog",
    "cite": "results",
    "compare": "cli.commands",
    "compare_runs": "analysis.runs_together",
    "conicity": "cli.commands",
    "contact": "cli.commands",
    "control": "cli.commands",
    "creep": "cli.commands",
    "critical_speed": "study.limit_cycles",
    "curving": "analysis.curving",
    "envelope": "cli.commands",
    "explain": "config",
    "export_fmu": "interfaces.fmu.export",
    "export_part": "interfaces.fmu.export",
    "json_schema": "config",
    "lateral": "cli.commands",
    "export": "results",
    "limit_cycle": "cli.commands",
    "linearize": "analysis.linear_bench",
    "load_case": "config",
    "load_run": "results",
    "paper": "cli.commands",
    "play": "viewer.play",
    "profile": "contact_analysis.profile_curve",
    "read_model": "interfaces.plant",
    "response": "cli.commands",
    "save_run": "results",
    "scale": "cli.commands",
    "serve": "interfaces.realtime.server",
    "simulate": "simulation.run",
    "stability": "analysis.mode_table",
    "view": "viewer",
    "starting_case": "catalog.starting_case",
    "summary": "results.in_words",
    "sweep": "cli.commands",
    "wheel_forces": "analysis.wheel_rail_forces",
    "wsp": "cli.commands",
}
"""Public name -> module that defines it."""

__all__ = ["__version__", "plot", *_HOME]


def __getattr__(name: str) -> Any:
    """A public name, from the module that defines it."""
    if name == "plot":
        return import_module("rollerrig.plot")
    if name not in _HOME:
        raise AttributeError(f"module 'rollerrig' has no attribute {name!r}")
    value = getattr(import_module(f"rollerrig.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Public names, for completion."""
    return sorted(__all__)
