// mechatronics/sensor.hpp - what a controller gets to see: counted angles, filtered and noisy forces.
//
//   true angle or force at the sampling instant -> [sensor] -> measurement
//
// Noise is a function of seed and sample number alone, so that a run repeats to the last bit.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/scalar.hpp"

namespace rollerrig {

/// Normally distributed number of mean 0 and deviation 1, the n-th of a stream (SplitMix64 and Box-Muller).
inline double normal_number(std::uint64_t stream, std::uint64_t n) {
  auto const mix = [](std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
  };
  auto const uniform = [&](std::uint64_t k) {  // in (0, 1)
    return (static_cast<double>(mix(mix(stream) ^ k) >> 11) + 0.5) * 0x1p-53;
  };
  return std::sqrt(-2.0 * std::log(uniform(2 * n))) * std::cos(2.0 * pi * uniform(2 * n + 1));
}

/// A force or torque transducer: first-order lag, then noise, resolution and range of its reading.
struct ForceSensor {
  std::optional<double> bandwidth{};  ///< [rad/s]; absent: no lag
  double noise{};                     ///< standard deviation of a reading [N or N m]
  double resolution{};                ///< of a reading; 0: none
  std::optional<double> range{};      ///< largest |reading|; absent: no limit

  static constexpr auto fields() {
    using P = ForceSensor;
    return std::tuple{Member{"bandwidth", &P::bandwidth, positive}, Member{"noise", &P::noise, not_negative},
                      Member{"resolution", &P::resolution, not_negative}, Member{"range", &P::range, positive}};
  }
};

/// State of one transducer.
class ForceReading {
 public:
  void reset(double value) {
    filtered_ = last_ = value;
    samples_ = 0;
  }

  /// The lag over one step, exact for a value on a straight line.
  void follow(ForceSensor const& sensor, double value, double step) {
    if (sensor.bandwidth) {
      double const slope = (value - last_) / step;
      double const behind = slope / *sensor.bandwidth;  // of the settled ramp
      filtered_ = value - behind + (filtered_ - last_ + behind) * std::exp(-*sensor.bandwidth * step);
    } else {
      filtered_ = value;
    }
    last_ = value;
  }

  double read(ForceSensor const& sensor, std::uint64_t stream) {
    double reading = filtered_;
    if (sensor.noise > 0.0) reading += sensor.noise * normal_number(stream, samples_++);
    if (sensor.resolution > 0.0) reading = sensor.resolution * std::round(reading / sensor.resolution);
    if (sensor.range) reading = std::fmin(*sensor.range, std::fmax(-*sensor.range, reading));
    return reading;
  }

 private:
  double filtered_{0.0}, last_{0.0};
  std::uint64_t samples_{0};
};

/// Samples over which an encoder's counts may be differenced.
inline constexpr int longest_window = 16;
inline constexpr Range window_range{0.0, longest_window, "0 to 16 samples"};

/// Incremental encoder on an axle: counts per turn, speed from the counts of the last few samples.
struct Encoder {
  double counts{};  ///< per turn; 0: an ideal sensor
  double jitter{};  ///< standard deviation of the edges' position [counts]
  int window{};     ///< samples over which counts are differenced, 1..16

  static constexpr auto fields() {
    return std::tuple{Member{"counts", &Encoder::counts, not_negative},
                      Member{"jitter", &Encoder::jitter, not_negative},
                      Member{"window", &Encoder::window, window_range}};
  }
};

/// State of one encoder.
class EncoderReading {
 public:
  void reset(double angle, double speed) {
    filled_ = 0;
    last_speed_ = speed;
    offset_ = angle;
    samples_ = 0;
  }

  /// Speed [rad/s] that the controller sees.
  ///
  /// @param angle   true angle at the sampling instant [rad]
  /// @param speed   true speed there, returned by an ideal sensor [rad/s]
  /// @param period  sample time [s]
  double step(Encoder const& encoder, double angle, double speed, double period, std::uint64_t stream) {
    if (!(encoder.counts > 0.0)) return speed;
    double const jitter = encoder.jitter > 0.0 ? encoder.jitter * normal_number(stream, samples_) : 0.0;
    ++samples_;
    double const count = std::floor((angle - offset_) / (2.0 * pi) * encoder.counts + jitter);
    int const window = encoder.window < 1 ? 1 : encoder.window > longest_window ? longest_window : encoder.window;
    if (filled_ >= 1) {
      int const back = filled_ < window ? filled_ : window;
      double const before =
          counts_[static_cast<std::size_t>((head_ + longest_window + 1 - back) % (longest_window + 1))];
      last_speed_ = (count - before) * 2.0 * pi / (encoder.counts * back * period);
    }
    head_ = (head_ + 1) % (longest_window + 1);
    counts_[static_cast<std::size_t>((head_ + longest_window) % (longest_window + 1))] = count;
    if (filled_ < longest_window) ++filled_;
    return last_speed_;
  }

 private:
  std::array<double, longest_window + 1> counts_{};
  int head_{0};  ///< one past the newest count
  int filled_{0};
  double last_speed_{0.0}, offset_{0.0};
  std::uint64_t samples_{0};
};

/// Mean of a drive's torque between the samples of its controller, by trapezes over the steps.
class MeanTorque {
 public:
  void follow(double torque) {
    if (begun_) sum_ += 0.5 * (now_ + torque), ++steps_;
    now_ = torque;
    begun_ = true;
  }
  double now() const { return now_; }
  /// The mean since the last call.
  double take() {
    double const mean = steps_ > 0 ? sum_ / steps_ : 0.0;
    sum_ = 0.0;
    steps_ = 0;
    return mean;
  }

 private:
  double now_{0.0}, sum_{0.0};
  int steps_{0};
  bool begun_{false};
};

/// What controllers see of speeds, torques and loads.
struct Sensors {
  Encoder axles{}, rollers{};
  std::optional<ForceSensor> roller_torque{};  ///< in the drive shaft of each roller axle; absent: its torque is known
  ForceSensor axle_load{};                     ///< vertical force of rail or rollers on both wheels of an axle
  std::uint64_t seed{};                        ///< of all noise

  static constexpr auto fields() {
    using P = Sensors;
    return std::tuple{Member{"axles", &P::axles}, Member{"rollers", &P::rollers},
                      Member{"roller_torque", &P::roller_torque}, Member{"axle_load", &P::axle_load},
                      Member{"seed", &P::seed, any_integer}};
  }
};

}  // namespace rollerrig
