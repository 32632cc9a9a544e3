"""Configuration: TOML in, frozen and checked objects in SI out.

    TOML files, catalogue names -> [config] -> Case -> model

Every mistake of a file is reported at once, one line each (`ConfigError`).
"""

from rollerrig.config.actuators import (
    BenchSettings,
    Brake,
    Controller,
    Encoder,
    ForceSensor,
    Motor,
    Sensors,
    SlideProtection,
    Traction,
    WheelSlipControl,
)
from rollerrig.config.adhesion import CONDITIONS, Adhesion, Condition, Piece
from rollerrig.config.case import (
    AxleTorque,
    Case,
    Contact,
    Disturbance,
    Motion,
    RollerEffects,
    SupportChoice,
    TimeSettings,
    VehicleChoice,
)
from rollerrig.config.errors import ConfigError, ConfigProblem
from rollerrig.config.irregularity import MeasuredIrregularity, SpectrumIrregularity
from rollerrig.config.load import (
    case_from_toml,
    load_any,
    load_case,
    load_material,
    load_profile,
    load_support,
    load_vehicle,
)
from rollerrig.config.material import Material
from rollerrig.config.mounting import AngularSupport, Foundation, LinearSupport, Mounting
from rollerrig.config.profile import S1002, Arc, Cone, Cylinder, ProfileFile, ProfileSpec, Uic60
from rollerrig.config.reference import json_schema, reference_markdown
from rollerrig.config.rig_control import RigControl
from rollerrig.config.similitude import ScaledFrom
from rollerrig.config.support import Rig
from rollerrig.config.track import Curve, Straight, Track, Transition
from rollerrig.config.train import Train
from rollerrig.config.vehicle import (
    AngularLaw,
    AngularSeriesDamper,
    Body,
    Cut,
    Element,
    LinearLaw,
    SeriesDamper,
    Vehicle,
    Wheel,
)

__all__ = [
    "CONDITIONS",
    "S1002",
    "Adhesion",
    "AngularLaw",
    "AngularSeriesDamper",
    "AngularSupport",
    "Arc",
    "AxleTorque",
    "BenchSettings",
    "Body",
    "Brake",
    "Case",
    "Condition",
    "Cone",
    "ConfigError",
    "ConfigProblem",
    "Contact",
    "Controller",
    "Curve",
    "Cut",
    "Cylinder",
    "Disturbance",
    "Element",
    "Encoder",
    "ForceSensor",
    "Foundation",
    "LinearLaw",
    "LinearSupport",
    "Material",
    "MeasuredIrregularity",
    "Motion",
    "Motor",
    "Mounting",
    "Piece",
    "ProfileFile",
    "ProfileSpec",
    "Rig",
    "RigControl",
    "RollerEffects",
    "ScaledFrom",
    "Sensors",
    "SeriesDamper",
    "SlideProtection",
    "SpectrumIrregularity",
    "Straight",
    "SupportChoice",
    "TimeSettings",
    "Track",
    "Traction",
    "Train",
    "Transition",
    "Uic60",
    "Vehicle",
    "VehicleChoice",
    "Wheel",
    "WheelSlipControl",
    "case_from_toml",
    "json_schema",
    "load_any",
    "load_case",
    "load_material",
    "load_profile",
    "load_support",
    "load_vehicle",
    "reference_markdown",
]
