// mechatronics/estimator/exact.hpp - contact force and axle torque that really act: for studies of what estimating costs.
#pragma once
#include <string_view>

#include "rollerrig/mechatronics/estimator/axle_sample.hpp"

namespace rollerrig {

struct ExactForces {
  static constexpr char const* name = "exact";
  static constexpr auto fields() { return members(); }

  struct State {};

  State start(AssumedParameters const& /*assumed*/, double /*period*/, AxleSample const& /*now*/) const { return {}; }

  ContactForceEstimate step(State& /*state*/, AssumedParameters const& p, AxleSample const& now,
                            double /*period*/) const {
    // The sum of (D2) with the rate that these two give: the same C, rounded as the other estimators round theirs.
    double const rate = (now.true_torque - p.wheel_radius * now.true_force) / p.wheelset_inertia;
    return {now.true_force, p.wheelset_inertia * rate + p.wheel_radius * now.true_force};
  }
};

}  // namespace rollerrig
