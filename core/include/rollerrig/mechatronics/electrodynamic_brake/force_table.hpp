// mechatronics/electrodynamic_brake/force_table.hpp - the characteristic of a traction motor that brakes, as points of a diagram.
#pragma once
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/math/piecewise_linear.hpp"

namespace rollerrig {

struct ForceTableBrake {
  static constexpr char const* name = "table";

  TimeTable forces{};

  static constexpr auto fields() {
    return members(Member{"forces", &ForceTableBrake::forces, "N",
                          "largest force of one axle over the speed of the wheels' circumference [m/s]"});
  }

  /// Largest force [N] at a speed of the wheels' circumference, not negative [m/s]; constant beyond the ends of the table.
  template <Scalar T>
  T force(T const& speed) const {
    return forces.at(speed);
  }
};

}  // namespace rollerrig
