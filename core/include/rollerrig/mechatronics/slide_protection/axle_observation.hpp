// mechatronics/slide_protection/axle_observation.hpp - what every law of slide protection knows of its axles.
//
//   axle speeds (sampled) -> speed and filtered acceleration of each axle -> reference speed -> the law's criteria
#pragma once
#include <cmath>

#include "rollerrig/mechatronics/measurements.hpp"
#include "rollerrig/mechatronics/reference_speed.hpp"

namespace rollerrig {

struct BrakedAxle {
  double speed{}, acceleration{};  ///< at the wheel's circumference [m/s], [m/s^2]
  double vents_for{};              ///< [s]
  double pulse_clock{};            ///< [s]
  double grips_for{};              ///< [s]
  bool slid{false};                ///< and has not gripped for long since
  void state(auto& archive) { archive(speed, acceleration, vents_for, pulse_clock, grips_for, slid); }
};

struct BrakedAxles {
  PerAxle<BrakedAxle> axle{};
  ReferenceSpeed reference{true, 0.0};
  bool off{false};  ///< near standstill: all valves fill

  double reference_speed() const { return reference.value(); }
  void state(auto& archive) { archive(axle, reference, off); }

  static BrakedAxles at(double train_speed) {
    BrakedAxles state{.axle = {}, .reference = {true, train_speed}, .off = false};
    for (BrakedAxle& axle : state.axle) axle.speed = train_speed;
    return state;
  }

  /// One sample: speeds, accelerations and the reference of a law with the parameters of (A7).
  template <class Law>
  void observe(Law const& law, Measurements const& now, double period) {
    double fastest = 0.0;
    bool gripping = true;  // of some axle: its speed is the train's
    for (int i = 0; i < now.axles; ++i) {
      auto const k = static_cast<std::size_t>(i);
      BrakedAxle& own = axle[k];
      double const speed = law.wheel_radius * now.vehicle_axle_speed[k];
      double const gain = period / (law.filter_time + period);
      own.acceleration += gain * ((speed - own.speed) / period - own.acceleration);
      own.speed = speed;
      fastest = std::fmax(fastest, speed);
      gripping = (i > 0 && gripping) || !own.slid;
    }
    ReferenceSpeedRules const rules{law.reference_deceleration, law.least_deceleration, law.release_interval,
                                    law.shortest_release, law.longest_release};
    reference.advance(fastest, period);
    off = reference.value() < (off ? std::fmax(law.return_speed, law.least_speed) : law.least_speed);
    if (gripping || off) return reference.is_known(rules);
    reference.search(rules, fastest, now.axles, period, [&](int released) {
      return axle[static_cast<std::size_t>(released)].acceleration > law.recovery_acceleration;
    });
  }
};

}  // namespace rollerrig
