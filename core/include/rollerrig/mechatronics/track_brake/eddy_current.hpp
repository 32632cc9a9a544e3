// mechatronics/track_brake/eddy_current.hpp - magnets over the rail that do not touch it: eddy currents in the rail brake.
//
//     F(v) = 2 F_k / (v/v_k + v_k/v)        (A21)
//
// Source  J.H. Wouterse, Critical torque and speed of eddy current brake with widely separated soft iron poles, IEE Proc. B 138
//         (1991): the curve over a critical speed. Its numbers for rails are the case's.
#pragma once
#include <tuple>

#include "rollerrig/fields.hpp"

namespace rollerrig {

struct EddyCurrentTrackBrake {
  static constexpr char const* name = "eddy_current";

  double largest_force{}, critical_speed{};

  static constexpr auto fields() {
    using P = EddyCurrentTrackBrake;
    return members(Member{"largest_force", &P::largest_force, "N",
                          "largest force of all magnets of a bogie together, F_k", not_negative},
                   Member{"critical_speed", &P::critical_speed, "m/s",
                          "speed at which the largest force is reached, v_k", positive});
  }

  /// Against running [N], at a speed over the rail [m/s].
  template <Scalar T>
  T force(T const& speed) const {
    return 2.0 * largest_force * critical_speed * speed / (speed * speed + critical_speed * critical_speed);
  }
};

}  // namespace rollerrig
