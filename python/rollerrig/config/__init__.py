"""Configuration: TOML in, frozen and checked objects in SI out.

    TOML files, catalogue names -> [schema -> read -> validate -> write -> load] -> Case -> assembly

Every mistake of a file is reported at once, one line each (`ConfigError`). Each folder uses only those before it.
"""

from rollerrig.config.errors import ConfigError, ConfigProblem
from rollerrig.config.load.any import load_any
from rollerrig.config.load.case import (
    Case,
    case_from_toml,
    load_case,
    load_material,
    load_profile,
    load_programme,
    load_support,
    load_vehicle,
)
from rollerrig.config.load.code import Code, code_of
from rollerrig.config.load.plan import WholePlan, load_plan, plan_of_case
from rollerrig.config.schema.actuators import (
    Brake,
    Controller,
    Motor,
    SlideProtection,
    Traction,
    WheelSlipControl,
)
from rollerrig.config.schema.adhesion import CONDITIONS, Adhesion, Condition, Piece
from rollerrig.config.schema.brakes import Train
from rollerrig.config.schema.case import (
    GRAVITY,
    AxleTorque,
    Contact,
    Disturbance,
    Motion,
    RollerEffects,
    ScaledFrom,
    SupportChoice,
    TimeSettings,
    VehicleChoice,
)
from rollerrig.config.schema.contact import Material
from rollerrig.config.schema.plan import Plan
from rollerrig.config.schema.profile import S1002, Arc, Cone, Cylinder, ProfileFile, ProfileSpec, Uic60
from rollerrig.config.schema.programme import CRITERIA, Limit, Programme
from rollerrig.config.schema.rig_control import Encoder, ForceSensor, RigControl, Sensors
from rollerrig.config.schema.support import Rig
from rollerrig.config.schema.track import (
    AngularSupport,
    Curve,
    Foundation,
    LinearSupport,
    MeasuredIrregularity,
    Mounting,
    Restraint,
    SpectrumIrregularity,
    Straight,
    Track,
    Transition,
)
from rollerrig.config.schema.vehicle import (
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
from rollerrig.config.write.explain import explain
from rollerrig.config.write.json_schema import json_schema

__all__ = [
    "CONDITIONS",
    "CRITERIA",
    "GRAVITY",
    "S1002",
    "Adhesion",
    "AngularLaw",
    "AngularSeriesDamper",
    "AngularSupport",
    "Arc",
    "AxleTorque",
    "Body",
    "Brake",
    "Case",
    "Code",
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
    "Limit",
    "LinearLaw",
    "LinearSupport",
    "Material",
    "MeasuredIrregularity",
    "Motion",
    "Motor",
    "Mounting",
    "Piece",
    "Plan",
    "ProfileFile",
    "ProfileSpec",
    "Programme",
    "Restraint",
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
    "WholePlan",
    "case_from_toml",
    "code_of",
    "explain",
    "json_schema",
    "load_any",
    "load_case",
    "load_material",
    "load_plan",
    "load_profile",
    "load_programme",
    "load_support",
    "load_vehicle",
    "plan_of_case",
]
