// Estimators of contact force and axle torque: bandwidth and delay as measured, against closed forms.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <cmath>
#include <complex>

#include "rollerrig/mechatronics/estimators.hpp"
#include "rollerrig/mechatronics/sensors.hpp"

using namespace rollerrig;

namespace {

constexpr double period = 1e-3;

AssumedParameters const assumed{
    .roller_inertia = 705.0, .roller_radius = 0.725, .wheelset_inertia = 112.0, .wheel_radius = 0.46};

FilteredDerivative derivative(double hertz = 20.0) { return {.bandwidth = 2 * pi * hertz}; }
DisturbanceObserver observer(double hertz = 20.0) { return {.bandwidth = 2 * pi * hertz, .damping_ratio = 0.8}; }
KalmanFilter kalman(double hertz = 20.0) { return {.bandwidth = 2 * pi * hertz, .speed_noise = 1e-3}; }

/// T estimated over T, or C over C, of the Kalman filter at z = exp(i w h): x = (I - K H) F x / z + K y.
std::complex<double> kalman_response(KalmanFilter const& filter, Estimated what, double w) {
  AssumedParameters const& p = assumed;
  auto const gain = filter.gain(assumed, period);
  Eigen::Matrix4d F = Eigen::Matrix4d::Identity();
  F(0, 2) = period * p.roller_radius / p.roller_inertia;
  F(1, 2) = -period * p.wheel_radius / p.wheelset_inertia;
  F(1, 3) = period / p.wheelset_inertia;
  Eigen::Matrix4d KH = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 2> K;
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 2; ++k) KH(i, k) = K(i, k) = gain[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
  bool const force = what == Estimated::force;
  // The integral of the sine is 1/(i w): all inputs are imaginary.
  Eigen::Vector2d const y{force ? p.roller_radius / p.roller_inertia : 0.0,
                          (force ? -p.wheel_radius : 1.0) / p.wheelset_inertia};
  Eigen::Matrix4d const step = (Eigen::Matrix4d::Identity() - KH) * F;
  Eigen::Vector4d const in = K * (y / -w);
  Eigen::Vector4d re = Eigen::Vector4d::Zero(), im = in;
  double const c = std::cos(w * period), s = std::sin(w * period);
  for (int k = 0; k < 4000; ++k) {  // the filter forgets: a geometric series in step / z
    Eigen::Vector4d const a = step * re, b = step * im;
    re = c * a + s * b;
    im = c * b - s * a + in;
  }
  int const row = force ? 2 : 3;
  return {re[row], im[row]};
}

}  // namespace

TEST_CASE("the filtered derivative has the bandwidth and delay of its low-pass and of half a sample") {
  for (double hertz : {5.0, 20.0, 60.0}) {
    auto const p = derivative(hertz);
    for (auto what : {Estimated::force, Estimated::torque}) {
      auto const found = measure_response(p, assumed, what, period);
      CHECK(found.delay == doctest::Approx(period / std::expm1(p.bandwidth * period) + 0.5 * period).epsilon(1e-4));
      double const half = 0.5 * found.bandwidth * period;  // mean over a sample: sin(half)/half
      double const keep = std::exp(-p.bandwidth * period);
      double const gain = (1 - keep) / std::abs(1.0 - keep * std::polar(1.0, -2 * half)) * std::sin(half) / half;
      CHECK(gain == doctest::Approx(std::sqrt(0.5)).epsilon(1e-4));
    }
  }
}

TEST_CASE("the observer has the bandwidth and delay of a system of second order") {
  for (double zeta : {0.7, 0.8, 1.2}) {
    auto p = observer(5.0);
    p.damping_ratio = zeta;
    auto const found = measure_response(p, assumed, Estimated::force, 1e-4);
    double const k = 1 - 2 * zeta * zeta;
    // Sampled every thirtieth part of a thousandth of 1/omega: 2 % of lead at most.
    CHECK(found.bandwidth / p.bandwidth == doctest::Approx(std::sqrt(k + std::sqrt(k * k + 1))).epsilon(5e-3));
    CHECK(found.delay * p.bandwidth == doctest::Approx(2 * zeta).epsilon(5e-3));
  }
}

TEST_CASE("the Kalman filter responds as its own matrices say") {
  for (double hertz : {5.0, 20.0}) {
    auto const p = kalman(hertz);
    for (auto what : {Estimated::force, Estimated::torque}) {
      auto const found = measure_response(p, assumed, what, period);
      CHECK(std::abs(kalman_response(p, what, found.bandwidth)) == doctest::Approx(std::sqrt(0.5)).epsilon(1e-3));
      double const slow = 1e-3 * p.bandwidth;
      CHECK(found.delay == doctest::Approx(-std::arg(kalman_response(p, what, slow)) / slow).epsilon(1e-3));
    }
  }
}

TEST_CASE("with a torque that may do anything the Kalman filter is a Butterworth filter of its bandwidth") {
  double const h = 1e-4;
  KalmanFilter p = kalman(5.0);
  p.torque_change = 1e9;  // then only the roller tells of T: (D12)
  auto const found = measure_response(p, assumed, Estimated::force, h);
  CHECK(found.bandwidth == doctest::Approx(p.bandwidth).epsilon(5e-3));  // continuous limit
  CHECK(found.delay == doctest::Approx(std::sqrt(2.0) / p.bandwidth).epsilon(5e-3));
}

TEST_CASE("every estimate converges to a force and a torque that step") {
  auto const converges = [](auto const& law) {
    AssumedParameters const& p = assumed;
    double roller = 45.0, wheel = 71.0;
    auto state = law.start(assumed, period, {roller, wheel});
    ContactForceEstimate found;
    double const drive = -2000.0, force = -9000.0, torque = -4000.0;
    for (int k = 0; k < 500; ++k) {
      roller += period * (drive + p.roller_radius * force) / p.roller_inertia;
      wheel += period * (torque - p.wheel_radius * force) / p.wheelset_inertia;
      found = law.step(state, assumed, {roller, wheel, drive}, period);
    }
    CHECK(found.force == doctest::Approx(force).epsilon(1e-9));  // 60 time constants
    CHECK(found.torque == doctest::Approx(torque).epsilon(1e-9));
  };
  converges(derivative());
  converges(observer());
  converges(kalman());
}

TEST_CASE("the estimator `exact` passes on what acts, at once") {
  ExactForces::State state;
  auto const found = ExactForces{}.step(state, assumed, {40.0, 60.0, 0.0, -7000.0, -3500.0}, period);
  CHECK(found.force == -7000.0);
  CHECK(found.torque == doctest::Approx(-3500.0).epsilon(1e-12));
  CHECK(measure_response(ExactForces{}, assumed, Estimated::torque, period).delay ==
        doctest::Approx(0.0).epsilon(1e-9));
}

TEST_CASE("the Kalman filter's error under noise is the least of the three at equal noise of speed") {
  // A force that walks as the filter assumes, speeds with the noise it assumes.
  double const sigma = 5e-3, change = 20e3, axle_change = 12e3;
  auto const error_of = [&](auto const& law) {
    AssumedParameters const& p = assumed;
    double roller = 45.0, wheel = 71.0, force = 0.0, torque = 0.0, sum = 0.0;
    auto state = law.start(assumed, period, {roller, wheel});
    int const n = 40000;
    for (int k = 0; k < n; ++k) {
      auto const u = static_cast<std::uint64_t>(k);
      roller += period * p.roller_radius * force / p.roller_inertia;
      wheel += period * (torque - p.wheel_radius * force) / p.wheelset_inertia;
      double const seen = roller + sigma * normal_number(1, u), wheel_seen = wheel + sigma * normal_number(2, u);
      auto const found = law.step(state, assumed, {seen, wheel_seen}, period);
      if (k > 1000) sum += square(found.force - force);
      force += change * std::sqrt(period) * normal_number(3, u);
      torque += axle_change * std::sqrt(period) * normal_number(4, u);
    }
    return std::sqrt(sum / (n - 1000));
  };
  double const best = error_of(
      KalmanFilter{.bandwidth = 1.0, .speed_noise = sigma, .force_change = change, .torque_change = axle_change});
  for (double hertz : {2.0, 5.0, 10.0, 20.0}) {
    CHECK(error_of(derivative(hertz)) > 1.02 * best);
    CHECK(error_of(observer(hertz)) > 1.02 * best);
  }
}

TEST_CASE("a force sensor lags, is noisy, comes in steps and ends at its range") {
  ForceSensor const lag{.bandwidth = 100.0};
  ForceReading reading;
  reading.reset(0.0);
  for (int k = 1; k <= 100; ++k) reading.follow(lag, 50.0 * k * period, period);  // a ramp of 50 N/s: exact
  CHECK(reading.read(lag, 0) == doctest::Approx(50.0 * (0.1 - (1 - std::exp(-10.0)) / 100.0)).epsilon(1e-12));
  ForceSensor const coarse{.resolution = 20.0, .range = 1000.0};
  reading.reset(473.0);
  CHECK(reading.read(coarse, 0) == 480.0);
  reading.reset(-5000.0);
  CHECK(reading.read(coarse, 0) == -1000.0);
  ForceSensor const noisy{.noise = 30.0};
  double sum = 0.0, squares = 0.0;
  reading.reset(100.0);
  int const n = 20000;
  for (int k = 0; k < n; ++k) {
    double const x = reading.read(noisy, 7) - 100.0;
    sum += x, squares += x * x;
  }
  CHECK(std::abs(sum / n) < 4 * 30.0 / std::sqrt(n));
  CHECK(std::sqrt(squares / n) == doctest::Approx(30.0).epsilon(0.02));
}
