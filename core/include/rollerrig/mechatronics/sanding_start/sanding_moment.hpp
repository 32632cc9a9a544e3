// mechatronics/sanding_start/sanding_moment.hpp - what decides whether sand is wanted.
#pragma once

namespace rollerrig {

struct SandingMoment {
  double time{};      ///< [s]
  double distance{};  ///< of the train since the start [m]
  bool slides{};      ///< slide protection vents some axle's cylinder, or wheel-slip control takes torque off one
};

}  // namespace rollerrig
