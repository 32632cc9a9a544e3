// mechatronics/wheel_slide_protection.hpp - holds braked axles near the adhesion limit by venting and refilling cylinders.
//
//   axle speeds (sampled) -> reference speed, slip, deceleration -> [criteria] -> dump valve of each axle: fill, hold, vent
//
// Written after the published principles of EN 15595 and UIC 541-05. It is not a certified device.
#pragma once
#include <array>
#include <cmath>

#include "rollerrig/mechatronics/pneumatic_brake.hpp"
#include "rollerrig/mechatronics/reference_speed.hpp"

namespace rollerrig {

struct WheelSlideProtection {
  double wheel_radius{0.46};           ///< that the device believes in [m]
  double reference_deceleration{1.6};  ///< the reference speed falls at most this fast: no train brakes harder [m/s^2]
  double filter_time{0.04};            ///< of the axles' deceleration [s]
  double vent_slip{0.12};              ///< relative slip above which a cylinder is vented [-]
  double vent_slip_speed{1.0};         ///< and the least such slip as a speed [m/s]
  double vent_deceleration{4.0};       ///< an axle that slows faster, and slips at all, is vented [m/s^2]
  double fill_slip{0.06};              ///< relative slip below which a cylinder is filled again [-]
  double fill_slip_speed{0.5};         ///< and the least such slip as a speed [m/s]
  double recovery_acceleration{0.5};   ///< an axle that regains speed faster is left alone [m/s^2]
  double pulse_time{0.06};             ///< filling is stepwise: open for this long ... [s]
  double pulse_pause{0.14};            ///< ... closed for this long, as long as the axle slips [s]
  double longest_vent{5.0};            ///< after this the watchdog fills, whatever the criteria say [s]
  double least_speed{5.0 / 3.6};       ///< below it all valves fill [m/s]
  double release_interval{3.0};  ///< while all axles slide, one is released this often for the reference; 0: never [s]
  double shortest_release{0.3};  ///< the valve needs some time to open, the cylinder to empty [s]
  double longest_release{1.2};   ///< [s]
  double least_deceleration{0.2};  ///< of the reference between releases: a braked train slows at least so [m/s^2]
  double regained_after{2.0};      ///< without slip for this long, an axle counts as gripping again [s]
};

class WheelSlideProtectionState {
 public:
  static constexpr int most_axles = 8;

  void reset(double speed) {
    reference_.reset(speed);
    axle_.fill({});
    for (Axle& axle : axle_) axle.speed = speed;
  }

  /// One sample: new valve states.
  ///
  /// @param axle_speed  [rad/s], `axles` of them
  void step(WheelSlideProtection const& p, double const* axle_speed, int axles, double period, DumpValve* valve) {
    double fastest = 0.0;
    bool gripping = true;  // of some axle: its speed is the train's
    for (int i = 0; i < axles; ++i) {
      Axle& axle = axle_[static_cast<std::size_t>(i)];
      double const speed = p.wheel_radius * axle_speed[i];
      double const gain = period / (p.filter_time + period);
      axle.acceleration += gain * ((speed - axle.speed) / period - axle.acceleration);
      axle.speed = speed;
      fastest = std::fmax(fastest, speed);
      gripping = (i > 0 && gripping) || !axle.slid;
    }
    follow(p, fastest, gripping, axles, period);
    for (int i = 0; i < axles; ++i)
      valve[i] = decide(p, axle_[static_cast<std::size_t>(i)], reference_.releases(i), period);
  }

  double reference_speed() const { return reference_.value(); }
  int cycles(int axle) const { return axle_[static_cast<std::size_t>(axle)].cycles; }

 private:
  struct Axle {
    double speed{0.0}, acceleration{0.0};
    double venting_for{0.0};  ///< [s]
    double pulse_clock{0.0};  ///< [s]
    double grips_for{0.0};    ///< [s]
    bool slid{false};         ///< and has not gripped for long since
    DumpValve valve{DumpValve::fill};
    int cycles{0};
  };

  void follow(WheelSlideProtection const& p, double fastest, bool gripping, int axles, double period) {
    ReferenceSpeedRules const rules{p.reference_deceleration, p.least_deceleration, p.release_interval,
                                    p.shortest_release, p.longest_release};
    reference_.advance(fastest, period);
    if (gripping || reference_.value() < p.least_speed) return reference_.is_known(rules);
    reference_.search(rules, fastest, axles, period, [&](int axle) {
      return axle_[static_cast<std::size_t>(axle)].acceleration > p.recovery_acceleration;
    });
  }

  DumpValve decide(WheelSlideProtection const& p, Axle& axle, bool released, double period) {
    double const slip = reference_.value() - axle.speed;
    double const vent_above = std::fmax(p.vent_slip * reference_.value(), p.vent_slip_speed);
    double const fill_below = std::fmax(p.fill_slip * reference_.value(), p.fill_slip_speed);
    axle.grips_for = slip < fill_below ? axle.grips_for + period : 0.0;
    if (axle.grips_for > p.regained_after) axle.slid = false;
    bool const locks_up = axle.acceleration < -p.vent_deceleration && slip > 0.5 * p.fill_slip_speed;
    bool const recovers = axle.acceleration > p.recovery_acceleration;
    DumpValve wanted = DumpValve::hold;
    if (reference_.value() < p.least_speed || axle.venting_for > p.longest_vent) {
      wanted = DumpValve::fill;
      axle.slid = false;
    } else if (released || ((slip > vent_above || locks_up) && !recovers)) {
      wanted = DumpValve::vent;
    } else if (slip < fill_below && !axle.slid) {
      wanted = DumpValve::fill;
    } else if (slip < fill_below) {
      axle.pulse_clock += period;
      if (axle.pulse_clock > p.pulse_time + p.pulse_pause) axle.pulse_clock = 0.0;
      wanted = axle.pulse_clock <= p.pulse_time ? DumpValve::fill : DumpValve::hold;
    }
    if (wanted == DumpValve::vent) {
      axle.cycles += axle.valve != DumpValve::vent;
      axle.venting_for += period;
      axle.slid = true;
      axle.pulse_clock = 0.0;
    } else {
      axle.venting_for = 0.0;
    }
    axle.valve = wanted;
    return wanted;
  }

  std::array<Axle, most_axles> axle_{};
  ReferenceSpeed reference_{true};
};

}  // namespace rollerrig
