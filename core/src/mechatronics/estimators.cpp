// The stationary gain of the Kalman filter, docs/theory/rig_control.md, (D10)-(D12); bandwidth and delay of any estimator: it is
// run on sines and measured.
#include "rollerrig/mechatronics/estimators.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>

#include "rollerrig/scalar.hpp"

namespace rollerrig {

KalmanFilter::Gain KalmanFilter::gain(AssumedParameters const& assumed, double period) const {
  using Matrix4 = Eigen::Matrix4d;
  double const per_root = bandwidth * bandwidth * speed_noise * std::sqrt(period);  // (D12)
  auto const [J_r, R, J_w, r] = assumed;
  double const force = force_change.value_or(per_root * J_r / R);
  double const torque = torque_change.value_or(per_root * (J_w + J_r * r / R));
  Matrix4 A = Matrix4::Zero(), Q = Matrix4::Zero();  // (D10)
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
  Eigen::Matrix2d const measured = speed_noise * speed_noise * Eigen::Matrix2d::Identity();
  Matrix4 P = noise;
  P.topLeftCorner<2, 2>() += measured;
  Eigen::Matrix<double, 4, 2> K = Eigen::Matrix<double, 4, 2>::Zero();
  for (int i = 0; i < 200000; ++i) {  // (D11)
    Eigen::Matrix<double, 4, 2> const before = K;
    K = P * H.transpose() * (H * P * H.transpose() + measured).inverse();
    Matrix4 const left = Matrix4::Identity() - K * H;
    Matrix4 const corrected = left * P * left.transpose() + K * measured * K.transpose();  // stays symmetric
    P = F * corrected * F.transpose() + noise;
    if ((K - before).cwiseAbs().maxCoeff() < 1e-13 * K.cwiseAbs().maxCoeff()) break;
  }
  Gain gain{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 2; ++k) gain[i][k] = K(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
  return gain;
}

namespace {

/// An estimator on a roller and a wheel that are as it assumes.
template <class Law>
struct Trial {
  Law const& law;
  AssumedParameters const& assumed;
  typename Law::State const& from_rest;
  Estimated what;
  double period;
  int samples;

  /// Amplitude and phase of the estimate over those of a sine of force or torque with `cycles` in `samples` samples.
  std::complex<double> response(int cycles) const {
    double const w = 2.0 * pi * cycles / (samples * period);
    bool const of_force = what == Estimated::force;
    double const roller = of_force ? assumed.roller_radius / assumed.roller_inertia : 0.0;
    double const wheel = (of_force ? -assumed.wheel_radius : 1.0) / assumed.wheelset_inertia;
    auto state = from_rest;
    std::complex<double> sum{};
    for (int k = 1; k <= 2 * samples; ++k) {
      double const t = k * period, sine = std::sin(w * t);
      double const integral = (1.0 - std::cos(w * t)) / w;  // of the sine
      AxleSample const now{roller * integral, wheel * integral, 0.0, of_force ? sine : 0.0, of_force ? 0.0 : sine};
      auto const found = law.step(state, assumed, now, period);
      if (k > samples) sum += (of_force ? found.force : found.torque) * std::polar(1.0, -w * t);
    }
    return sum * std::complex<double>(0.0, 2.0 / samples);  // of sin(w t) itself: 1
  }
};

template <class Law>
EstimatorResponse measure(Law const& law, AssumedParameters const& assumed, Estimated what, double period) {
  // A window of whole cycles, long against the transient, fine in frequency.
  double window = 0.0;
  if constexpr (requires { law.bandwidth; }) window = 2000.0 / (law.bandwidth * period);
  int const samples = static_cast<int>(std::clamp(window, 2000.0, 400000.0));
  double const unit = 2.0 * pi / (samples * period);
  auto const from_rest = law.start(assumed, period, {});
  Trial<Law> const trial{law, assumed, from_rest, what, period, samples};
  auto const gain = [&](int cycles) { return std::abs(trial.response(cycles)); };
  EstimatorResponse out;
  out.delay = -std::arg(trial.response(1)) / unit;
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

}  // namespace

EstimatorResponse measure_response(AnyEstimator const& estimator, AssumedParameters const& assumed, Estimated what,
                                   double period) {
  return std::visit([&](auto const& law) { return measure(law, assumed, what, period); }, estimator);
}

}  // namespace rollerrig
