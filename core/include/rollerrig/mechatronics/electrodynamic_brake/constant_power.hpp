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

  double largest_force{};  ///< F_max of one axle at the wheels' circumference [N]
  double largest_power{};  ///< P of one axle [W]
  double fade_from{};      ///< v_1: below it the force fades [m/s]
  double fade_to{};        ///< v_0: from here down there is none [m/s]

  static constexpr auto fields() {
    using P = ConstantPowerBrake;
    return std::tuple{Member{"largest_force", &P::largest_force, not_negative},
                      Member{"largest_power", &P::largest_power, not_negative},
                      Member{"fade_from", &P::fade_from, positive}, Member{"fade_to", &P::fade_to, not_negative}};
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
