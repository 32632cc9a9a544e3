// mechatronics/sensors.hpp - what controllers see of speeds, torques and loads.
//
//   true motion and forces -> [sensors] -> measurements
//
// To add a speed sensor: a struct in speed_sensors.hpp, its line in AnySpeedSensor, its table in
// python/rollerrig/config/schema/rig_control.py.
#pragma once
#include <cmath>
#include <cstdint>
#include <optional>
#include <variant>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/speed_sensors.hpp"

namespace rollerrig {

/// What a controller gets to see of forces and torques: filtered, noisy, or as a mean.
///
///   true force at each step -> [transducer] -> reading at the sampling instant
/// A force or torque transducer: first-order lag, then noise, resolution and range of its reading.
struct ForceSensor {
  std::optional<double> bandwidth{};
  double noise{}, resolution{};
  std::optional<double> range{};

  static constexpr auto fields() {
    using P = ForceSensor;
    return members(Member{"bandwidth", &P::bandwidth, "rad/s", "bandwidth of the lag; absent: no lag", positive},
                   Member{"noise", &P::noise, "N or N m", "standard deviation of a reading", not_negative},
                   Member{"resolution", &P::resolution, "N or N m", "resolution of a reading; 0: none", not_negative},
                   Member{"range", &P::range, "N or N m", "largest |reading|; absent: no limit", positive});
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

  void state(auto& archive) { archive(filtered_, last_, samples_); }

 private:
  double filtered_{0.0}, last_{0.0};
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

  void state(auto& archive) {
    archive(now_, sum_, begun_);
    archive.within(steps_, 0, 1 << 30);
  }

 private:
  double now_{0.0}, sum_{0.0};
  int steps_{0};
  bool begun_{false};
};

using AnySpeedSensor = OneOf<Encoder, PulsePeriod, PulseFrequency>;

struct Sensors {
  AnySpeedSensor axles{}, rollers{};           ///< for the rig's controller
  std::optional<AnySpeedSensor> vehicle{};     ///< the vehicle's own, for its controllers; absent: those of `axles`
  std::optional<ForceSensor> roller_torque{};  ///< in the drive shaft of each roller axle; absent: its torque is known
  ForceSensor axle_load{};                     ///< vertical force of rail or rollers on both wheels of an axle
  std::uint64_t seed{};                        ///< of all noise

  static constexpr auto fields() {
    using P = Sensors;
    return members(Member{"axles", &P::axles}, Member{"rollers", &P::rollers}, Member{"vehicle", &P::vehicle},
                   Member{"roller_torque", &P::roller_torque}, Member{"axle_load", &P::axle_load},
                   Member{"seed", &P::seed, any_integer});
  }
};

}  // namespace rollerrig
