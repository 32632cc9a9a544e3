// mechatronics/estimator/kalman.hpp - contact force and axle torque by a stationary Kalman filter of both speeds.
//
// States W, w, T, C of (D1), (D2); T and C are random walks, both speeds are measured with noise: docs/theory/rig_control.md,
// (D10)-(D12).
#pragma once
#include <array>
#include <optional>
#include <string_view>

#include "rollerrig/mechatronics/estimator/axle_sample.hpp"

namespace rollerrig {

struct KalmanFilter {
  static constexpr char const* name = "kalman";
  double bandwidth{}, speed_noise{};
  std::optional<double> force_change{}, torque_change{};

  static constexpr auto fields() {
    using P = KalmanFilter;
    return members(
        Member{"bandwidth", &P::bandwidth, "rad/s", "bandwidth from which absent changes follow, (D12)", positive},
        Member{"speed_noise", &P::speed_noise, "rad/s", "standard deviation of a measured speed", not_negative},
        Member{"force_change", &P::force_change, "N", "standard deviation of the contact force's change over 1 s",
               not_negative},
        Member{"torque_change", &P::torque_change, "N m", "standard deviation of the axle torque's change over 1 s",
               not_negative});
  }

  /// Rows W, w, T, C over the innovations of W and w.
  using Gain = std::array<std::array<double, 2>, 4>;
  /// The stationary gain for a sample time, (D11).
  Gain gain(AssumedParameters const& assumed, double period) const;

  struct State {
    double roller_speed{}, wheel_speed{}, force{}, torque{};
    Gain gain{};
    void state(auto& archive) { archive(roller_speed, wheel_speed, force, torque, gain); }
  };

  State start(AssumedParameters const& assumed, double period, AxleSample const& now) const {
    return {now.roller_speed, now.wheel_speed, 0.0, 0.0, gain(assumed, period)};
  }

  /// Predicts with (D1), (D2) over the sample, exactly for constant T and C; then corrects.
  ContactForceEstimate step(State& s, AssumedParameters const& p, AxleSample const& now, double period) const {
    s.roller_speed += period * (now.roller_torque + p.roller_radius * s.force) / p.roller_inertia;
    s.wheel_speed += period * (s.torque - p.wheel_radius * s.force) / p.wheelset_inertia;
    double const of_roller = now.roller_speed - s.roller_speed, of_wheel = now.wheel_speed - s.wheel_speed;
    auto const correction = [&](std::size_t row) { return s.gain[row][0] * of_roller + s.gain[row][1] * of_wheel; };
    s.roller_speed += correction(0);
    s.wheel_speed += correction(1);
    s.force += correction(2);
    s.torque += correction(3);
    return {s.force, s.torque};
  }
};

}  // namespace rollerrig
