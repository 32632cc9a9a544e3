// What is worked out about an estimator before a run: the Kalman filter's gain, bandwidth and delay as measured.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>

#include "rollerrig/mechatronics/estimator_response.hpp"
#include "rollerrig/scalar.hpp"

namespace rollerrig {

void solve_kalman_gain(ContactForceEstimator& p, double period) {
  using Matrix4 = Eigen::Matrix4d;
  double const per_root = p.bandwidth * p.bandwidth * p.speed_noise * std::sqrt(period);  // (D12)
  double const J_r = p.roller_inertia, R = p.roller_radius, J_w = p.wheelset_inertia, r = p.wheel_radius;
  double const force = p.force_change > 0.0 ? p.force_change : per_root * J_r / R;
  double const torque = p.torque_change > 0.0 ? p.torque_change : per_root * (J_w + J_r * r / R);
  Matrix4 A = Matrix4::Zero(), Q = Matrix4::Zero();
  A(0, 2) = R / J_r;
  A(1, 2) = -r / J_w;
  A(1, 3) = 1.0 / J_w;
  Q(2, 2) = force * force;
  Q(3, 3) = torque * torque;
  double const h = period;
  // A A = 0: the exponential and the integral of the noise end after few terms.
  Matrix4 const F = Matrix4::Identity() + h * A;
  Matrix4 const noise = h * Q + h * h / 2.0 * (A * Q + Q * A.transpose()) + h * h * h / 3.0 * A * Q * A.transpose();
  Eigen::Matrix<double, 2, 4> const H = Eigen::Matrix<double, 2, 4>::Identity();
  Eigen::Matrix2d const measured = p.speed_noise * p.speed_noise * Eigen::Matrix2d::Identity();
  Matrix4 P = noise;
  P.topLeftCorner<2, 2>() += measured;
  Eigen::Matrix<double, 4, 2> gain = Eigen::Matrix<double, 4, 2>::Zero();
  for (int i = 0; i < 200000; ++i) {
    Eigen::Matrix<double, 4, 2> const before = gain;
    gain = P * H.transpose() * (H * P * H.transpose() + measured).inverse();
    Matrix4 const left = Matrix4::Identity() - gain * H;
    Matrix4 const corrected = left * P * left.transpose() + gain * measured * gain.transpose();  // stays symmetric
    P = F * corrected * F.transpose() + noise;
    if ((gain - before).cwiseAbs().maxCoeff() < 1e-13 * gain.cwiseAbs().maxCoeff()) break;
  }
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 2; ++k) p.gain[i][k] = gain(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
}

namespace {

/// Amplitude and phase of the estimate over those of a sine with `cycles` in `samples` samples.
std::complex<double> response_at(ContactForceEstimator const& p, Estimated what, double period, int cycles,
                                 int samples) {
  double const w = 2.0 * pi * cycles / (samples * period);
  bool const of_force = what == Estimated::force;
  double const roller = of_force ? p.roller_radius / p.roller_inertia : 0.0;
  double const wheel = (of_force ? -p.wheel_radius : 1.0) / p.wheelset_inertia;
  ContactForceEstimate estimate;
  estimate.reset(0.0, 0.0, 0.0);
  std::complex<double> sum{};
  for (int k = 1; k <= 2 * samples; ++k) {
    double const t = k * period;
    double const integral = (1.0 - std::cos(w * t)) / w;  // of the sine
    estimate.step(p, roller * integral, wheel * integral, 0.0, period);
    double const found = of_force ? estimate.force() : estimate.axle_torque(p);
    if (k > samples) sum += found * std::polar(1.0, -w * t);
  }
  return sum * std::complex<double>(0.0, 2.0 / samples);  // of sin(w t) itself: 1
}

}  // namespace

EstimatorResponse measure_response(ContactForceEstimator const& p, Estimated what, double period) {
  // A window of whole cycles, long against the transient, fine in frequency.
  int const samples = std::clamp(static_cast<int>(2000.0 / (p.bandwidth * period)), 2000, 400000);
  double const unit = 2.0 * pi / (samples * period);
  auto const gain = [&](int cycles) { return std::abs(response_at(p, what, period, cycles, samples)); };
  EstimatorResponse out;
  out.delay = -std::arg(response_at(p, what, period, 1, samples)) / unit;
  double const down = std::sqrt(0.5);
  int low = 1, high = samples / 2 - 1;
  if (gain(high) > down) return {unit * high, out.delay};
  while (high - low > 1) {
    int const middle = (low + high) / 2;
    (gain(middle) > down ? low : high) = middle;
  }
  double const at_low = gain(low), at_high = gain(high);
  out.bandwidth = unit * (low + (at_low - down) / (at_low - at_high));
  return out;
}

}  // namespace rollerrig
