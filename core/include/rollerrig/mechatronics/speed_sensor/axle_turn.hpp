// mechatronics/speed_sensor/axle_turn.hpp - the true motion of an axle at an instant, of which a speed sensor reads some.
#pragma once

namespace rollerrig {

struct AxleTurn {
  double time{};   ///< [s]
  double angle{};  ///< since the start [rad]
  double speed{};  ///< [rad/s]
  void state(auto& archive) { archive(time, angle, speed); }
};

}  // namespace rollerrig
