// mechatronics/estimator/observer.hpp - contact force by a Luenberger observer of the roller.
//
// States W and T with T' = 0; the error's poles are those of s^2 + 2 zeta w s + w^2, and the prediction is discretised exactly,
// gains (D16).
//
// Source  Malvezzi, Pugi et al., roller rig control; docs/theory/rig_control.md.
#pragma once
#include <cmath>
#include <string_view>

#include "rollerrig/mechatronics/estimator/axle_sample.hpp"

namespace rollerrig {

struct DisturbanceObserver {
  static constexpr char const* name = "observer";
  double bandwidth{}, damping_ratio{};

  static constexpr auto fields() {
    using P = DisturbanceObserver;
    return members(
        Member{"bandwidth", &P::bandwidth, "rad/s", "natural frequency of the observer's poles, w", positive},
        Member{"damping_ratio", &P::damping_ratio, "1", "damping ratio of the observer's poles, zeta", positive});
  }

  struct State {
    double roller_speed{}, force{};
    AxleTorqueFilter axle{};
    void state(auto& archive) { archive(roller_speed, force, axle); }
  };

  State start(AssumedParameters const& /*assumed*/, double /*period*/, AxleSample const& now) const {
    return {now.roller_speed, 0.0, {now.wheel_speed, 0.0}};
  }

  ContactForceEstimate step(State& s, AssumedParameters const& p, AxleSample const& now, double period) const {
    double const predicted =
        s.roller_speed + period * (now.roller_torque + p.roller_radius * s.force) / p.roller_inertia;
    double const error = now.roller_speed - predicted;
    double const w = bandwidth * period;
    double const l1 = 1.0 - std::exp(-2.0 * damping_ratio * w);  // (D16), as l2
    double const root = std::sqrt(std::fabs(1.0 - damping_ratio * damping_ratio));
    double const turn = damping_ratio < 1.0 ? std::cos(w * root) : std::cosh(w * root);
    double const l2 = 1.0 + std::exp(-2.0 * damping_ratio * w) - 2.0 * std::exp(-damping_ratio * w) * turn;
    s.roller_speed = predicted + l1 * error;
    s.force += l2 * error * p.roller_inertia / (p.roller_radius * period);
    double const low_pass = 1.0 - std::exp(-bandwidth * period);
    return {s.force, s.axle.step(p, low_pass, now.wheel_speed, s.force, period)};
  }
};

}  // namespace rollerrig
