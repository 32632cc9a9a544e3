// mechatronics/estimator/filtered_derivative.hpp - contact force from differences of the roller's speed, low-passed.
//
//     T = (J_r W' - U) / R     behind a low-pass of first order, (D1)
//
// Source  Malvezzi, Pugi et al., roller rig control; docs/theory/rig_control.md.
#pragma once
#include <cmath>
#include <string_view>

#include "rollerrig/mechatronics/estimator/axle_sample.hpp"

namespace rollerrig {

struct FilteredDerivative {
  static constexpr char const* name = "filtered_derivative";
  double bandwidth{};

  static constexpr auto fields() {
    return members(Member{"bandwidth", &FilteredDerivative::bandwidth, "rad/s", "pole of the filter", positive});
  }

  struct State {
    double last_roller_speed{}, force{};
    AxleTorqueFilter axle{};
    void state(auto& archive) { archive(last_roller_speed, force, axle); }
  };

  State start(AssumedParameters const& /*assumed*/, double /*period*/, AxleSample const& now) const {
    return {now.roller_speed, 0.0, {now.wheel_speed, 0.0}};
  }

  ContactForceEstimate step(State& s, AssumedParameters const& p, AxleSample const& now, double period) const {
    double const low_pass = 1.0 - std::exp(-bandwidth * period);
    double const rate = (now.roller_speed - s.last_roller_speed) / period;
    s.force += low_pass * ((p.roller_inertia * rate - now.roller_torque) / p.roller_radius - s.force);
    s.last_roller_speed = now.roller_speed;
    return {s.force, s.axle.step(p, low_pass, now.wheel_speed, s.force, period)};
  }
};

}  // namespace rollerrig
