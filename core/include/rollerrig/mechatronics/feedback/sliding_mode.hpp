// mechatronics/feedback/sliding_mode.hpp - a torque of constant size against the error's sign, in proportion near zero.
#pragma once
#include <algorithm>
#include <string_view>

#include "rollerrig/mechatronics/feedback/tracking_error.hpp"

namespace rollerrig {

struct SlidingMode {
  static constexpr char const* name = "sliding_mode";
  double switching{}, boundary_layer{};

  static constexpr auto fields() {
    using P = SlidingMode;
    return members(Member{"switching", &P::switching, "N m", "largest torque of the feedback"},
                   Member{"boundary_layer", &P::boundary_layer, "rad/s",
                          "speed error at which the largest torque is reached", positive});
  }

  struct State {};

  double step(State& /*state*/, AssumedParameters const& /*assumed*/, TrackingError const& now,
              double /*limit*/) const {
    return now.feed_forward + switching * std::clamp(now.error / boundary_layer, -1.0, 1.0);
  }
};

}  // namespace rollerrig
