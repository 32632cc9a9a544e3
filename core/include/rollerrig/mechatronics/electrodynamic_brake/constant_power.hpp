// mechatronics/electrodynamic_brake/constant_power.hpp - the characteristic of a traction motor that brakes, from four numbers.
//
//     F(v) = min(F_max, P/v) f(v),   f = 0 up to v_0, then a straight line to 1 at v_1        (A17)
//
// Constant force at low speed, constant power beyond P/F_max, and the fading of a machine that no longer feeds back.
#pragma once
#include <tuple>

#include "rollerrig/fields.hpp"

namespace rollerrig {

struct ConstantPowerBrake {
  static constexpr char const* name = "constant_power";

  double largest_force{}, largest_power{}, fade_from{}, fade_to{};

  static constexpr auto fields() {
    using P = ConstantPowerBrake;
    return members(Member{"largest_force", &P::largest_force, "N",
                          "largest force of one axle at the wheels' circumference, F_max", not_negative},
                   Member{"largest_power", &P::largest_power, "W", "largest power of one axle, P", not_negative},
                   Member{"fade_from", &P::fade_from, "m/s", "speed below which the force fades, v_1", positive},
                   Member{"fade_to", &P::fade_to, "m/s", "speed from which down there is no force, v_0", not_negative});
  }

  /// Largest force [N] at a speed of the wheels' circumference, not negative [m/s].
  template <Scalar T>
  T force(T const& speed) const {
    T const fast = select(largest_force * speed > largest_power, speed, T(1.0));
    T const full = select(largest_force * speed > largest_power, largest_power / fast, T(largest_force));
    T const part = (speed - fade_to) / (fade_from - fade_to);
    return full * select(part < 0.0, T(0.0), select(part < 1.0, part, T(1.0)));
  }
};

}  // namespace rollerrig
