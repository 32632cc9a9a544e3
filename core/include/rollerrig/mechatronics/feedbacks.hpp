// mechatronics/feedbacks.hpp - the feedback laws of the roller drives that a case can name.
//
// To add one: a struct here, its line in AnyFeedback, its parameters in python/rollerrig/config/schema/rig_control.py.
#pragma once
#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <variant>

#include "rollerrig/mechatronics/estimators.hpp"

namespace rollerrig {

/// What the feedback of a roller's drive acts on at one sample.
struct TrackingError {
  double feed_forward{};  ///< (D5) [N m]
  double error{};         ///< virtual minus measured wheel speed [rad/s]
  double period{};        ///< since the last sample [s]
};

/// The feed-forward alone.
struct NoFeedback {
  static constexpr char const* name = "none";
  static constexpr auto fields() { return members(); }

  struct State {};

  double step(State& /*state*/, AssumedParameters const& /*assumed*/, TrackingError const& now,
              double /*limit*/) const {
    return now.feed_forward;
  }
};

/// PI feedback on the wheels' speed, without wind-up at the command's limit.
///
/// For wheel and roller as one inertia J = J_w + J_r (r/R)^2, with bandwidth w and damping ratio zeta of the loop:
///
///     k_p = 2 zeta w J R/r,   k_i = w^2 J R/r        (D6)
///
/// Source  docs/theory/rig_control.md.
struct ProportionalIntegral {
  static constexpr char const* name = "proportional_integral";
  double bandwidth{}, damping_ratio{};
  std::optional<double> proportional{}, integral{};

  static constexpr auto fields() {
    using P = ProportionalIntegral;
    return members(Member{"bandwidth", &P::bandwidth, "rad/s", "bandwidth of the loop, w", positive},
                   Member{"damping_ratio", &P::damping_ratio, "1", "damping ratio of the loop, zeta", not_negative},
                   Member{"proportional", &P::proportional, "N m s/rad", "proportional gain k_p in place of (D6)"},
                   Member{"integral", &P::integral, "N m/rad", "integral gain k_i in place of (D6)"});
  }

  struct Gains {
    double proportional{}, integral{};
  };
  /// (D6), where they are not given.
  Gains gains(AssumedParameters const& p) const {
    double const ratio = p.wheel_radius / p.roller_radius;
    double const inertia = p.wheelset_inertia + p.roller_inertia * (ratio * ratio);
    return {proportional.value_or(2.0 * damping_ratio * bandwidth * inertia / ratio),
            integral.value_or(bandwidth * bandwidth * inertia / ratio)};
  }

  struct State {
    double integral{};  ///< of the error [rad]
    void state(auto& archive) { archive(integral); }
  };

  double step(State& s, AssumedParameters const& assumed, TrackingError const& now, double limit) const {
    auto const [k_p, k_i] = gains(assumed);
    double const with = now.feed_forward + k_p * now.error + k_i * (s.integral + now.period * now.error);
    if (std::fabs(with) <= limit) s.integral += now.period * now.error;
    return now.feed_forward + (k_p * now.error + k_i * s.integral);
  }
};

/// A torque of constant size against the error's sign, in proportion near zero.
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

using AnyFeedback = std::variant<ProportionalIntegral, SlidingMode, NoFeedback>;

}  // namespace rollerrig
