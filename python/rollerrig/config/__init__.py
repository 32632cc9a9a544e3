"""Configuration: TOML in, frozen and checked objects in SI out.

    TOML files, catalogue names -> [schema -> read -> validate -> write -> load] -> Case -> assembly

Every mistake of a file is reported at once, one line each (`ConfigError`). Each folder uses only those before it.
"""

from rollerrig.config.errors import ConfigError as ConfigError
from rollerrig.config.errors import ConfigProblem as ConfigProblem
from rollerrig.config.load.any import load_any as load_any
from rollerrig.config.load.case import Case as Case
from rollerrig.config.load.case import case_from_toml as case_from_toml
from rollerrig.config.load.case import load_case as load_case
from rollerrig.config.load.case import load_material as load_material
from rollerrig.config.load.case import load_profile as load_profile
from rollerrig.config.load.case import load_programme as load_programme
from rollerrig.config.load.case import load_support as load_support
from rollerrig.config.load.case import load_vehicle as load_vehicle
from rollerrig.config.load.code import Code as Code
from rollerrig.config.load.code import code_of as code_of
from rollerrig.config.load.plan import WholePlan as WholePlan
from rollerrig.config.load.plan import load_plan as load_plan
from rollerrig.config.load.plan import plan_of_case as plan_of_case
from rollerrig.config.schema.actuators import Brake as Brake
from rollerrig.config.schema.actuators import Motor as Motor
from rollerrig.config.schema.actuators import SlideProtection as SlideProtection
from rollerrig.config.schema.actuators import Traction as Traction
from rollerrig.config.schema.actuators import WheelSlipControl as WheelSlipControl
from rollerrig.config.schema.adhesion import Adhesion as Adhesion
from rollerrig.config.schema.adhesion import Condition as Condition
from rollerrig.config.schema.adhesion import Piece as Piece
from rollerrig.config.schema.case import GRAVITY as GRAVITY
from rollerrig.config.schema.case import Contact as Contact
from rollerrig.config.schema.case import ScaledFrom as ScaledFrom
from rollerrig.config.schema.contact import Material as Material
from rollerrig.config.schema.fit import FitPlan as FitPlan
from rollerrig.config.schema.plan import Plan as Plan
from rollerrig.config.schema.profile import Uic60 as Uic60
from rollerrig.config.schema.programme import CRITERIA as CRITERIA
from rollerrig.config.schema.programme import Limit as Limit
from rollerrig.config.schema.programme import Programme as Programme
from rollerrig.config.schema.rig_control import Encoder as Encoder
from rollerrig.config.schema.rig_control import ForceSensor as ForceSensor
from rollerrig.config.schema.rig_control import RigControl as RigControl
from rollerrig.config.schema.rig_control import Sensors as Sensors
from rollerrig.config.schema.support import Rig as Rig
from rollerrig.config.schema.track import AngularSupport as AngularSupport
from rollerrig.config.schema.track import Foundation as Foundation
from rollerrig.config.schema.track import LinearSupport as LinearSupport
from rollerrig.config.schema.track import Restraint as Restraint
from rollerrig.config.schema.track import Track as Track
from rollerrig.config.schema.vehicle import Body as Body
from rollerrig.config.schema.vehicle import Element as Element
from rollerrig.config.schema.vehicle import Vehicle as Vehicle
from rollerrig.config.schema.vehicle import Wheel as Wheel
from rollerrig.config.write.explain import explain as explain
from rollerrig.config.write.json_schema import json_schema as json_schema
