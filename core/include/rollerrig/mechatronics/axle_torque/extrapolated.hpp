// mechatronics/axle_torque/extrapolated.hpp - the estimated torque of the axle, run ahead along its slope.
//
//     C = C_e + a G C_e'        (D19)
//
// G, a low-pass of first order, keeps noise out of the slope. Source  docs/theory/rig_control.md.
#pragma once
#include <cmath>
#include <string_view>
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/axle_torque/torque_sample.hpp"

namespace rollerrig {

struct ExtrapolatedTorque {
  static constexpr char const* name = "extrapolated";
  double ahead{}, bandwidth{};

  static constexpr auto fields() {
    return members(Member{"ahead", &ExtrapolatedTorque::ahead, "s", "lead of the estimate, a", not_negative},
                   Member{"bandwidth", &ExtrapolatedTorque::bandwidth, "rad/s",
                          "bandwidth of the low-pass on its slope, G", positive});
  }

  struct State {
    double last{}, slope{};  ///< C_e [N m], its filtered rate [N m/s]
    void state(auto& archive) { archive(last, slope); }
  };

  double step(State& s, TorqueSample const& now, double period) const {
    s.slope += (1.0 - std::exp(-bandwidth * period)) * ((now.estimate - s.last) / period - s.slope);
    s.last = now.estimate;
    return now.estimate + ahead * s.slope;
  }
};

}  // namespace rollerrig
