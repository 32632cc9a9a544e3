"""rollerrig: a roller rig for railway bogies, in software.

    load_case -> Case -> simulate -> xarray.Dataset -> save_run, plot
                      -> stability, critical_speed, limit_cycle -> xarray.Dataset
                      -> linearize -> control.StateSpace
    run -> wheel_forces -> Y, Q, Y/Q, wear number
                      -> envelope, sweep -> xarray.Dataset
    response, adhesion, wsp, control, lateral, compare, scale, fit -> Outcome -> write(folder)

Every command of the command line is a function here, under the same name; `plot` draws what they return. Names are loaded when
first used, so that `import rollerrig` costs nothing. No public object has the name of a module.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rollerrig import plot as plot
    from rollerrig.analysis.bifurcation import bifurcation as bifurcation
    from rollerrig.analysis.curving import curving as curving
    from rollerrig.analysis.curving_sensitivity import curving_sensitivity as curving_sensitivity
    from rollerrig.analysis.linear_bench import linearize as linearize
    from rollerrig.analysis.mode_table import stability as stability
    from rollerrig.analysis.runs_together import compare_runs as compare_runs
    from rollerrig.analysis.stability_sensitivity import stability_sensitivity as stability_sensitivity
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
    from rollerrig.cli.commands import fit as fit
    from rollerrig.cli.commands import lateral as lateral
    from rollerrig.cli.commands import limit_cycle as limit_cycle
    from rollerrig.cli.commands import paper as paper
    from rollerrig.cli.commands import reconstruct as reconstruct
    from rollerrig.cli.commands import replay as replay
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
    from rollerrig.simulation.sensitivity import sensitivity as sensitivity
    from rollerrig.simulation.starting_state import StartError as StartError
    from rollerrig.study.limit_cycles import critical_speed as critical_speed
    from rollerrig.viewer import view as view
    from rollerrig.viewer.play import play as play

__version__ = "0.1.0"

_NAMES = {
    "analysis.curving": "curving",
    "analysis.curving_sensitivity": "curving_sensitivity",
    "analysis.linear_bench": "linearize",
    "analysis.mode_table": "stability",
    "analysis.runs_together": "compare_runs",
    "analysis.bifurcation": "bifurcation",
    "analysis.stability_sensitivity": "stability_sensitivity",
    "analysis.wheel_rail_forces": "wheel_forces",
    "assembly.model": "assemble",
    "catalog": "catalog_entries catalog_text",
    "catalog.starting_case": "starting_case",
    "cli.commands": "adhesion compare conicity contact control creep envelope fit lateral limit_cycle paper "
    "reconstruct replay response scale sweep tune wsp",
    "config": "Case ConfigError explain json_schema load_case",
    "contact_analysis.profile_curve": "profile",
    "interfaces.fmu.export": "export_fmu export_part",
    "interfaces.plant": "assemble_file read_model",
    "interfaces.realtime.server": "serve",
    "results": "OutputError ResultsError RunInfo cite export load_run save_run",
    "results.in_words": "summary",
    "simulation.run": "simulate",
    "simulation.sensitivity": "sensitivity",
    "simulation.starting_state": "StartError",
    "study.limit_cycles": "critical_speed",
    "viewer": "view",
    "viewer.play": "play",
}
"""Module -> public names that it defines."""

_HOME = {name: module for module, names in _NAMES.items() for name in names.split()}

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
