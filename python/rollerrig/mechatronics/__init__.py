"""Sensors, controllers and actuators of a case, as the core takes them, and the user's own controllers.

AssembledModel -> [mechatronics] -> _core.MechatronicSetup; measurements -> the user's controllers -> commands
"""

from rollerrig.mechatronics.controllers import (
    BRAKE_UNIT,
    COMMANDS,
    MEASUREMENTS,
    ControllerError,
    UserController,
    ask,
    close_controllers,
    fmu_controller,
    look_at_controller,
    provenance_of,
    roles_of,
    users_controllers,
    with_brake_unit,
)
from rollerrig.mechatronics.setup import mechatronic_setup

__all__ = [
    "BRAKE_UNIT",
    "COMMANDS",
    "MEASUREMENTS",
    "ControllerError",
    "UserController",
    "ask",
    "close_controllers",
    "fmu_controller",
    "look_at_controller",
    "mechatronic_setup",
    "provenance_of",
    "roles_of",
    "users_controllers",
    "with_brake_unit",
]
