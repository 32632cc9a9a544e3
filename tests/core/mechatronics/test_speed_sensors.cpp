// Encoders and phonic wheels: what a controller sees of an axle's speed.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "rollerrig/mechatronics/sensors.hpp"

using namespace rollerrig;

namespace {

constexpr double radius = 0.46;  ///< of the wheels [m]
constexpr double sampling_step = 1e-3;

/// Readings every `every` steps of an axle that turns as `angle(t)` and `speed(t)` say.
template <class Sensor>
std::vector<double> readings(Sensor const& sensor, double duration, std::function<double(double)> const& angle,
                             std::function<double(double)> const& speed, int every = 5, std::uint64_t stream = 7) {
  auto state = sensor.start({0.0, 0.0, speed(0.0)}, stream);
  std::vector<double> out;
  for (int k = 0; k * sampling_step <= duration; ++k) {
    double const t = k * sampling_step;
    AxleTurn const now{t, angle(t), speed(t)};
    sensor.follow(state, now, stream);
    if (k % every == 0) out.push_back(sensor.read(state, now, every * sampling_step, stream));
  }
  return out;
}

template <class Sensor>
std::vector<double> steady(Sensor const& sensor, double speed, double duration = 2.0, int every = 5) {
  return readings(sensor, duration, [=](double t) { return speed * t; }, [=](double) { return speed; }, every);
}

PulsePeriod const pulses{.teeth = 100.0, .pitch_error = 0.0, .averaging_time = 5e-3, .timeout = 0.3, .clock = 1e6};

}  // namespace

TEST_CASE("100 teeth read any steady speed from 1 to 83 m/s to what the clock resolves") {
  for (double speed : {1.0, 1.7, 4.0, 13.3, 33.3, 55.0, 83.0})
    for (int every : {1, 5})
      for (double reading : steady(pulses, speed / radius, 2.0, every)) {
        double const timed = std::fmax(5e-3, 2 * pi / 100.0 / (speed / radius));
        CHECK(std::fabs(reading * radius / speed - 1.0) < 1.01 * 1e-6 / timed);
      }
}

TEST_CASE("without a clock's steps the period is exact at constant speed") {
  PulsePeriod exact = pulses;
  exact.clock = 0.0;
  for (double reading : steady(exact, 12.3)) CHECK(reading == doctest::Approx(12.3).epsilon(1e-11));
}

TEST_CASE(
    "an axle that locks reads ever slower and stands after the timeout; the first edge after it only starts the "
    "clock") {
  double const w = 30.0, locks_at = 0.5;  // [rad/s], [s]
  auto const angle = [&](double t) { return t < locks_at ? w * t : t < 2.0 ? w * locks_at : w * (locks_at + t - 2.0); };
  auto const speed = [&](double t) { return t < locks_at || t >= 2.0 ? w : 0.0; };
  auto const seen = readings(pulses, 3.0, angle, speed, 1);
  double const pitch = 2 * pi / 100.0;
  for (std::size_t k = 501; k < 2000; ++k) {
    double const since = k * sampling_step - locks_at;
    CHECK(seen[k] <= std::fmin(w * 1.001, pitch / std::fmax(1e-9, since - sampling_step)) + 1e-9);
    CHECK(seen[k] <= seen[k - 1]);
    if (since > 0.3 + 2.1e-3) CHECK(seen[k] == 0.0);
  }
  CHECK(seen[2002] == 0.0);                               // an edge or two, not yet timed over 5 ms
  CHECK(seen[2020] == doctest::Approx(w).epsilon(3e-4));  // 1 us of 5 ms
}

TEST_CASE("counting edges in a gate reads in steps of one edge per gate, right on average") {
  PulseFrequency const counter{.teeth = 100.0, .pitch_error = 0.0, .gate_time = 0.1};
  double const speed = 37.3, quantum = 2 * pi / 100.0 / 0.1;
  auto const seen = steady(counter, speed, 20.0);
  double sum = 0.0;
  for (std::size_t k = 20; k < seen.size(); ++k) {
    sum += seen[k];
    CHECK(std::fabs(seen[k] - speed) <= quantum * (1.0 + 1e-9));
    CHECK(std::fabs(seen[k] / quantum - std::round(seen[k] / quantum)) < 1e-6);
  }
  CHECK(sum / static_cast<double>(seen.size() - 20) == doctest::Approx(speed).epsilon(2e-3));
}

TEST_CASE("teeth that are out of place ripple the reading, the same in each turn, and not on average over turns") {
  PulsePeriod uneven = pulses;
  uneven.pitch_error = 0.02;
  uneven.averaging_time = 0.0;
  double const speed = 2 * pi;  // one turn a second, 10 ms a tooth
  auto const seen = steady(uneven, speed, 4.0, 10);
  double largest = 0.0, mean = 0.0;
  for (std::size_t k = 200; k < 300; ++k) {
    CHECK(seen[k] == doctest::Approx(seen[k + 100]).epsilon(3e-4));  // 1 us of 10 ms, twice
    largest = std::fmax(largest, std::fabs(seen[k] / speed - 1.0));
    mean += seen[k] / 100.0;
  }
  CHECK(largest > 0.03);
  CHECK(largest < 0.2);
  CHECK(mean == doctest::Approx(speed).epsilon(0.01));  // a late tooth reads as an axle that slows
  CHECK(steady(uneven, speed) == steady(uneven, speed));
}

TEST_CASE("a speed that falls is read late by half of what is averaged, no more") {
  double const w = 60.0, slope = -20.0;  // 10 m/s^2 and more at the wheel
  auto const seen = readings(
      pulses, 1.0, [&](double t) { return w * t + 0.5 * slope * t * t; }, [&](double t) { return w + slope * t; });
  for (std::size_t k = 5; k < seen.size(); ++k) {
    double const error = seen[k] - (w + slope * 5e-3 * static_cast<double>(k));
    CHECK(error < -slope * 12e-3);
    CHECK(error > -0.02);
  }
}

TEST_CASE("an encoder's speed is right on average, quantised in steps, and repeats with its seed") {
  Encoder const encoder{.counts = 1000.0, .jitter = 0.2, .window = 4};
  double const period = 1e-3, speed = 37.3;
  auto const read = [&](std::uint64_t seed) {
    return readings(encoder, 4.0, [=](double t) { return speed * t; }, [=](double) { return speed; }, 1, seed);
  };
  auto const a = read(1);
  CHECK(a == read(1));
  CHECK(a != read(2));
  double const quantum = 2 * pi / (encoder.counts * encoder.window * period);
  double sum = 0.0;
  for (std::size_t k = 10; k < a.size(); ++k) {
    sum += a[k];
    CHECK(std::abs(a[k] - speed) < 3 * quantum);
    CHECK(std::abs(a[k] / quantum - std::round(a[k] / quantum)) < 1e-6);
  }
  CHECK(sum / static_cast<double>(a.size() - 10) == doctest::Approx(speed).epsilon(1e-3));
  Encoder const ideal{.counts = 0.0, .jitter = 0.0, .window = 1};
  CHECK(steady(ideal, 12.5).back() == 12.5);
}
