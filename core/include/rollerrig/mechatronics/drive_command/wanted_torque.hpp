// mechatronics/drive_command/wanted_torque.hpp - the torque that a roller's drive is to exert, and what it exerts.
#pragma once

namespace rollerrig {

struct WantedTorque {
  double feed_forward{};  ///< of it, (D5) [N m]
  double total{};         ///< with the feedback [N m]
  double measured{};      ///< of the drive now [N m]
};

}  // namespace rollerrig
