// mechatronics/feedback/none.hpp - the feed-forward alone.
#pragma once
#include <string_view>
#include <tuple>

#include "rollerrig/mechatronics/feedback/tracking_error.hpp"

namespace rollerrig {

struct NoFeedback {
  static constexpr char const* name = "none";
  static constexpr auto fields() { return members(); }

  struct State {};

  double step(State& /*state*/, AssumedParameters const& /*assumed*/, TrackingError const& now,
              double /*limit*/) const {
    return now.feed_forward;
  }
};

}  // namespace rollerrig
