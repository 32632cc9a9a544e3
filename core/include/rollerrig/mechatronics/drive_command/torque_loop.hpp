// mechatronics/drive_command/torque_loop.hpp - a loop around the drive, closed over its measured torque.
//
//     c = U + g (U - U_measured)        (D21)
//
// A drive of first order gets the bandwidth (1 + g) w_b. Source  docs/theory/rig_control.md.
#pragma once
#include <string_view>
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/drive_command/wanted_torque.hpp"

namespace rollerrig {

struct TorqueLoop {
  static constexpr char const* name = "torque_loop";
  double gain{};

  static constexpr auto fields() {
    return members(Member{"gain", &TorqueLoop::gain, "1", "gain on demanded less measured torque, g", not_negative});
  }

  struct State {};

  double step(State& /*state*/, WantedTorque const& now, double /*period*/) const {
    return now.total + gain * (now.total - now.measured);
  }
};

}  // namespace rollerrig
