"""Studies: what is run, what is reported, what the models leave out.

analysis, plot -> [study] -> summary.json, data, figures, report.html
"""

from importlib import import_module
from typing import Any

_HOME = {
    "PaperStudy": "paper",
    "RunStudy": "run",
    "StabilityStudy": "stability",
    "ResponseStudy": "response",
    "CompareStudy": "compare",
    "CurvingStudy": "curving",
    "AdhesionStudy": "adhesion",
    "WspStudy": "wsp",
    "ProtectionComparison": "protection_comparison",
    "ReconstructionStudy": "reconstruction",
    "ReplayStudy": "replay",
    "ControlStudy": "control",
    "TuneStudy": "tune",
    "LateralStudy": "lateral",
    "EnvelopeStudy": "envelope",
    "SweepStudy": "sweep",
    "FitStudy": "fit",
    "ScaleStudy": "scale",
    "CreepStudy": "creep",
    "ConicityStudy": "conicity",
}
"""Study -> its module, in the order of the reference page."""


def __getattr__(name: str) -> Any:
    """A study, imported when first asked for; STUDIES: all of them."""
    if name == "STUDIES":
        return tuple(__getattr__(one) for one in _HOME)
    if name not in _HOME:
        raise AttributeError(f"module 'rollerrig.study' has no attribute {name!r}")
    return getattr(import_module(f"rollerrig.study.{_HOME[name]}"), name)
