// mechatronics/drive_commands.hpp - how a roller's drive is asked for a torque: the laws that a case can name.
//
//   wanted torque, measured torque -> [drive command] -> command, within the largest torque
//
// To add one: a header in drive_command/, its line in AnyDriveCommand, its parameters in python/rollerrig/config/schema/rig_control.py.
#pragma once
#include <variant>

#include "rollerrig/mechatronics/drive_command/direct.hpp"
#include "rollerrig/mechatronics/drive_command/lead.hpp"
#include "rollerrig/mechatronics/drive_command/torque_loop.hpp"

namespace rollerrig {

using AnyDriveCommand = std::variant<DirectCommand, LeadCommand, TorqueLoop>;

}  // namespace rollerrig
