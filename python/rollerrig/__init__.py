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

from functools import cache
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
    from rollerrig.config import Case as Case
    from rollerrig.config import ConfigError as ConfigError
    from rollerrig.config import explain as explain
    from rollerrig.config import json_schema as json_schema
    from rollerrig.config import load_case as load_case
    from rollerrig.contact_analysis.profile_curve import profile as profile
    from rollerrig.contact_analysis.static_contact import contact as contact
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
    from rollerrig.study.adhesion import adhesion as adhesion
    from rollerrig.study.compare import compare as compare
    from rollerrig.study.conicity import conicity as conicity
    from rollerrig.study.control import control as control
    from rollerrig.study.creep import creep as creep
    from rollerrig.study.envelope import envelope as envelope
    from rollerrig.study.fit import fit as fit
    from rollerrig.study.lateral import lateral as lateral
    from rollerrig.study.limit_cycles import critical_speed as critical_speed
    from rollerrig.study.limit_cycles import limit_cycle as limit_cycle
    from rollerrig.study.paper import paper as paper
    from rollerrig.study.protection_comparison import wsp as wsp
    from rollerrig.study.reconstruction import reconstruct as reconstruct
    from rollerrig.study.replay import replay as replay
    from rollerrig.study.response import response as response
    from rollerrig.study.run import run as run
    from rollerrig.study.scale import scale as scale
    from rollerrig.study.sweep import sweep as sweep
    from rollerrig.study.tune import tune as tune
    from rollerrig.viewer import view as view
    from rollerrig.viewer.play import play as play

__version__ = "0.1.0"


@cache
def _homes() -> dict[str, str]:
    """Public name -> its module: of functions of studies as they are found, of others as listed for type checkers."""
    import re
    from pathlib import Path

    from rollerrig.study import heads

    imports = re.compile(r"^    from rollerrig\.(\S+) import (\w+) as", re.MULTILINE)
    listed = {name: module for module, name in imports.findall(Path(__file__).read_text(encoding="utf-8"))}
    return {name: module for name, (module, _) in heads().items()} | listed


def __getattr__(name: str) -> Any:
    """A public name, from the module that defines it; `__all__`: all of them."""
    if name == "__all__":
        return ["__version__", "plot", *_homes()]
    if name == "plot":
        return import_module("rollerrig.plot")
    if name.startswith("_") or name not in _homes():
        raise AttributeError(f"module 'rollerrig' has no attribute {name!r}")
    value = getattr(import_module(f"rollerrig.{_homes()[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Public names, for completion."""
    return sorted(__getattr__("__all__"))
