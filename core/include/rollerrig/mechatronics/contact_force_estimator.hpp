// mechatronics/contact_force_estimator.hpp - the tangential force in the contact, from the roller side.
//
//   roller speed (measured), torque of its drive -> [estimator] -> force T on the wheel, forward   -> torque C on the axle
//
// Signs   W is positive when the roller turns as under a wheel that rolls forward; U positive drives the wheel forward.
//         J_r W' = U + R T        (D1)     J_w w' = C - r T        (D2)
// Source  Malvezzi, Pugi et al., roller rig control: T_est = (J_r W' - U)/R, C_est = J_w w' + r T_est.
#pragma once
#include <array>
#include <cmath>

namespace rollerrig {

enum class EstimatorKind : int { filtered_derivative, observer, kalman, exact };

struct ContactForceEstimator {
  EstimatorKind kind{EstimatorKind::observer};
  double bandwidth{2.0 * 3.14159265358979323846 * 20.0};  ///< [rad/s]
  double damping_ratio{0.8};                              ///< of the observer
  double roller_inertia{705.0};                           ///< J_r that the controller believes in [kg m^2]
  double roller_radius{0.725};                            ///< R [m]
  double wheelset_inertia{112.0};                         ///< J_w [kg m^2]
  double wheel_radius{0.46};                              ///< r [m]

  // Of the Kalman filter: T and C are random walks, speeds are measured with noise.
  double speed_noise{1e-3};   ///< standard deviation of a measured speed [rad/s]
  double force_change{0.0};   ///< standard deviation of T's change over 1 s [N]; 0: from the bandwidth
  double torque_change{0.0};  ///< of C's [N m]; 0: from the bandwidth
  /// Rows W, w, T, C over the innovations of W and w; of solve_kalman_gain().
  std::array<std::array<double, 2>, 4> gain{};
};

/// Fills in the stationary gain of the Kalman filter for its sample time, docs/theory/rig_control.md (D11), (D12).
void solve_kalman_gain(ContactForceEstimator& p, double period);

/// State of the estimator of one axle.
class ContactForceEstimate {
 public:
  void reset(double roller_speed, double wheel_speed, double force) {
    last_roller_ = roller_ = roller_speed;
    last_wheel_ = wheel_ = wheel_speed;
    force_ = force;
    wheel_rate_ = 0.0;
    torque_ = 0.0;
  }

  /// One sample.
  ///
  /// @param roller_speed, wheel_speed  measured [rad/s]
  /// @param roller_torque              that acted since the last sample [N m]
  void step(ContactForceEstimator const& p, double roller_speed, double wheel_speed, double roller_torque,
            double period) {
    if (p.kind == EstimatorKind::kalman) return correct(p, roller_speed, wheel_speed, roller_torque, period);
    double const low_pass = 1.0 - std::exp(-p.bandwidth * period);
    if (p.kind == EstimatorKind::filtered_derivative) {
      double const rate = (roller_speed - last_roller_) / period;
      force_ += low_pass * ((p.roller_inertia * rate - roller_torque) / p.roller_radius - force_);
    } else {
      // Luenberger observer of (W, T) with T' = 0, both poles at the bandwidth, discretised exactly in its prediction.
      double const predicted = roller_ + period * (roller_torque + p.roller_radius * force_) / p.roller_inertia;
      double const error = roller_speed - predicted;
      double const w = p.bandwidth * period;
      double const l1 = 1.0 - std::exp(-2.0 * p.damping_ratio * w);
      double const root = std::sqrt(std::fabs(1.0 - p.damping_ratio * p.damping_ratio));
      double const turn = p.damping_ratio < 1.0 ? std::cos(w * root) : std::cosh(w * root);
      double const l2 = 1.0 + std::exp(-2.0 * p.damping_ratio * w) - 2.0 * std::exp(-p.damping_ratio * w) * turn;
      roller_ = predicted + l1 * error;
      force_ += l2 * error * p.roller_inertia / (p.roller_radius * period);
    }
    wheel_rate_ += low_pass * ((wheel_speed - last_wheel_) / period - wheel_rate_);
    last_roller_ = roller_speed;
    last_wheel_ = wheel_speed;
  }

  /// In place of a sample: what really acts, for studies of what estimating costs.
  void set(ContactForceEstimator const& p, double force, double axle_torque) {
    force_ = force;
    torque_ = axle_torque;
    wheel_rate_ = (axle_torque - p.wheel_radius * force) / p.wheelset_inertia;
  }

  double force() const { return force_; }                     ///< T [N]
  double axle_torque(ContactForceEstimator const& p) const {  ///< C [N m], (D2)
    if (p.kind == EstimatorKind::kalman) return torque_;
    return p.wheelset_inertia * wheel_rate_ + p.wheel_radius * force_;
  }

 private:
  /// Kalman filter: predict with (D1), (D2) over the sample, exactly for constant T and C; then correct.
  void correct(ContactForceEstimator const& p, double roller_speed, double wheel_speed, double roller_torque,
               double period) {
    roller_ += period * (roller_torque + p.roller_radius * force_) / p.roller_inertia;
    wheel_ += period * (torque_ - p.wheel_radius * force_) / p.wheelset_inertia;
    double const of_roller = roller_speed - roller_, of_wheel = wheel_speed - wheel_;
    auto const by = [&](std::size_t row) { return p.gain[row][0] * of_roller + p.gain[row][1] * of_wheel; };
    roller_ += by(0);
    wheel_ += by(1);
    force_ += by(2);
    torque_ += by(3);
  }

  double roller_{0.0}, wheel_{0.0}, last_roller_{0.0}, last_wheel_{0.0};
  double force_{0.0}, wheel_rate_{0.0}, torque_{0.0};
};

}  // namespace rollerrig
