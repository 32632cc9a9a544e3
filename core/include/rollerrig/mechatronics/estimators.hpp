// mechatronics/estimators.hpp - the estimators of contact force and axle torque that a case can name.
//
// To add one: a struct here, its line in AnyEstimator, its parameters in python/rollerrig/config/schema/rig_control.py.
#pragma once
#include <array>
#include <cmath>
#include <optional>

#include "rollerrig/fields.hpp"

namespace rollerrig {

//     J_r W' = U + R T        (D1)     J_w w' = C - r T        (D2)
// Signs   roller speed W is positive when the roller turns as under a wheel that rolls forward; its drive's torque U and the
//         force T on the wheel are positive forward; so is the torque C on the axle.

/// Wheel and roller as the controller assumes them; they may differ from the rig's.
struct AssumedParameters {
  double roller_inertia{}, roller_radius{}, wheelset_inertia{}, wheel_radius{};

  static constexpr auto fields() {
    using P = AssumedParameters;
    return members(Member{"roller_inertia", &P::roller_inertia, "kg m^2",
                          "moment of inertia of a roller axle about its axis as assumed, J_r", positive},
                   Member{"roller_radius", &P::roller_radius, "m", "radius of the rollers as assumed, R", positive},
                   Member{"wheelset_inertia", &P::wheelset_inertia, "kg m^2",
                          "moment of inertia of a wheelset about its axis as assumed, J_w", positive},
                   Member{"wheel_radius", &P::wheel_radius, "m", "radius of the wheels as assumed, r", positive});
  }
};

/// One axle at one sample.
struct AxleSample {
  double roller_speed{}, wheel_speed{};  ///< W, w as measured [rad/s]
  double roller_torque{};                ///< U since the last sample, as far as it is known [N m]
  double true_force{}, true_torque{};    ///< T [N] and C [N m] at the sample: for the estimator `exact`
};

struct ContactForceEstimate {
  double force{};   ///< T [N]
  double torque{};  ///< C [N m]
  void state(auto& archive) { archive(force, torque); }
};

/// C from the wheel's acceleration behind a low-pass of first order, (D2).
struct AxleTorqueFilter {
  double last_speed{}, rate{};  ///< w [rad/s], w' [rad/s^2]

  double step(AssumedParameters const& p, double low_pass, double wheel_speed, double force, double period) {
    rate += low_pass * ((wheel_speed - last_speed) / period - rate);
    last_speed = wheel_speed;
    return p.wheelset_inertia * rate + p.wheel_radius * force;
  }
  void state(auto& archive) { archive(last_speed, rate); }
};

/// Contact force and axle torque that really act: for studies of what estimating costs.
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

/// Contact force from differences of the roller's speed, low-passed.
///
///     T = (J_r W' - U) / R     behind a low-pass of first order, (D1)
///
/// Source  Malvezzi, Pugi et al., roller rig control; docs/theory/rig_control.md.
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

/// Contact force and axle torque by a stationary Kalman filter of both speeds.
///
/// States W, w, T, C of (D1), (D2); T and C are random walks, both speeds are measured with noise: docs/theory/rig_control.md,
/// (D10)-(D12).
struct KalmanFilter {
  static constexpr char const* name = "kalman";
  static constexpr bool settled_at_start = true;  ///< its gain does not follow its numbers
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

/// Contact force by a Luenberger observer of the roller.
///
/// States W and T with T' = 0; the error's poles are those of s^2 + 2 zeta w s + w^2, and the prediction is discretised exactly,
/// gains (D16).
///
/// Source  Malvezzi, Pugi et al., roller rig control; docs/theory/rig_control.md.
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

using AnyEstimator = OneOf<DisturbanceObserver, FilteredDerivative, KalmanFilter, ExactForces>;

/// Bandwidth and delay that an estimate really has.
struct EstimatorResponse {
  double bandwidth{};  ///< where the estimate is down to 1/sqrt(2) [rad/s]; half the sampling rate where it never is
  double delay{};      ///< of slow changes, ideal sensors [s]
};

enum class Estimated : int { force, torque };

/// Measured with a sine of force or torque, on a roller and a wheel that are as assumed, with exact speeds.
EstimatorResponse measure_response(AnyEstimator const& estimator, AssumedParameters const& assumed, Estimated what,
                                   double period);

}  // namespace rollerrig
