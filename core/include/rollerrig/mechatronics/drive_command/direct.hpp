// mechatronics/drive_command/direct.hpp - the drive is asked for the wanted torque, and follows with its lag.
#pragma once
#include <string_view>
#include <tuple>

#include "rollerrig/mechatronics/drive_command/wanted_torque.hpp"

namespace rollerrig {

struct DirectCommand {
  static constexpr char const* name = "direct";
  static constexpr auto fields() { return members(); }

  struct State {};

  double step(State& /*state*/, WantedTorque const& now, double /*period*/) const { return now.total; }
};

}  // namespace rollerrig
