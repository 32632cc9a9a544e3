// mechatronics/pneumatics.hpp - from brake demand and dump valves' commands to the pressures of all cylinders.
//
//   demand -> [control valve] -> [air: one of the laws in air/] -> cylinder pressures -> friction_brake.hpp
//
// To add a law of the air: a header in air/, its line in AnyAir, its parameters in python/rollerrig/config/schema/actuators.py.
#pragma once
#include <tuple>
#include <variant>

#include "rollerrig/mechatronics/air/reservoir.hpp"
#include "rollerrig/mechatronics/air/unlimited.hpp"

namespace rollerrig {

using AnyAir = OneOf<UnlimitedAir, ReservoirAir>;

struct Pneumatics {
  ControlValve control_valve{};
  AnyAir air{};

  static constexpr auto fields() {
    return members(Member{"control_valve", &Pneumatics::control_valve}, Member{"air", &Pneumatics::air});
  }
};

}  // namespace rollerrig
