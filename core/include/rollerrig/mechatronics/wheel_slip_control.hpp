// mechatronics/wheel_slip_control.hpp - takes torque off a driven axle that slips, and gives it back.
//
//   axle speeds (sampled), train speed it believes in -> slip and acceleration -> factor on the torque demand of each axle
#pragma once
#include <array>
#include <cmath>

#include "rollerrig/mechatronics/reference_speed.hpp"

namespace rollerrig {

struct WheelSlipControl {
  double wheel_radius{0.46};           ///< that the device believes in [m]
  double reference_acceleration{1.5};  ///< the reference speed rises at most this fast: no train starts faster [m/s^2]
  double slip{0.04};                   ///< relative slip above which torque is taken off [-]
  double slip_speed{0.15};             ///< and the least such slip as a speed [m/s]
  double acceleration{3.0};            ///< an axle that gains speed faster loses torque as well [m/s^2]
  double filter_time{0.04};            ///< of the axles' acceleration [s]
  double reduction_rate{4.0};          ///< of the factor [1/s]
  double restoring_rate{0.35};         ///< [1/s]
  double least_factor{0.05};           ///< [-]
  double release_interval{3.0};        ///< while axles slip, one is released this often for the reference; 0: never [s]
  double shortest_release{0.4};        ///< the torque needs some time to go [s]
  double longest_release{1.2};         ///< [s]
  double release_deceleration{0.5};    ///< a released axle that slows less has run down to the train's speed [m/s^2]
  double least_acceleration{0.05};     ///< of the reference between releases [m/s^2]
  double regained_after{3.0};          ///< without slip for this long, the axles show the train's speed [s]
};

class WheelSlipControlState {
 public:
  static constexpr int most_axles = 8;

  void reset(double speed) {
    reference_.reset(speed);
    quiet_for_ = 1e9;  // nothing has slipped yet
    for (Axle& axle : axle_) axle = {speed, 0.0, 1.0, false, 0};
  }

  /// One sample: factors on the torque demand, 0..1.
  void step(WheelSlipControl const& p, double const* axle_speed, int axles, double period, double* factor) {
    double slowest = p.wheel_radius * axle_speed[0];
    for (int i = 1; i < axles; ++i) slowest = std::fmin(slowest, p.wheel_radius * axle_speed[i]);
    follow(p, slowest, axles, period);
    for (int i = 0; i < axles; ++i) {
      Axle& axle = axle_[static_cast<std::size_t>(i)];
      double const speed = p.wheel_radius * axle_speed[i];
      axle.acceleration += period / (p.filter_time + period) * ((speed - axle.speed) / period - axle.acceleration);
      axle.speed = speed;
      double const slips_above = std::fmax(p.slip * std::fabs(reference_.value()), p.slip_speed);
      bool const slips = speed - reference_.value() > slips_above || axle.acceleration > p.acceleration;
      axle.interventions += slips && !axle.slips;
      axle.slips = slips;
      quiet_for_ = slips ? 0.0 : quiet_for_;
      axle.factor += (slips || reference_.releases(i) ? -p.reduction_rate : p.restoring_rate) * period;
      axle.factor = std::fmin(1.0, std::fmax(p.least_factor, axle.factor));
      factor[i] = axle.factor;
    }
  }

  double reference_speed() const { return reference_.value(); }
  int interventions(int axle) const { return axle_[static_cast<std::size_t>(axle)].interventions; }

 private:
  struct Axle {
    double speed, acceleration, factor;
    bool slips;
    int interventions;
  };
  void follow(WheelSlipControl const& p, double slowest, int axles, double period) {
    ReferenceSpeedRules const rules{p.reference_acceleration, p.least_acceleration, p.release_interval,
                                    p.shortest_release, p.longest_release};
    reference_.advance(slowest, period);
    quiet_for_ += period;
    if (quiet_for_ > p.regained_after) return reference_.is_known(rules);
    reference_.search(rules, slowest, axles, period, [&](int axle) {
      return axle_[static_cast<std::size_t>(axle)].acceleration < -p.release_deceleration;
    });
  }

  std::array<Axle, most_axles> axle_{};
  ReferenceSpeed reference_{false};
  double quiet_for_{0.0};  ///< since the last slip [s]
};

}  // namespace rollerrig
