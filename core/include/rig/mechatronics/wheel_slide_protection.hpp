// mechatronics/wheel_slide_protection.hpp - holds braked axles near the adhesion limit by venting and refilling cylinders.
//
//   axle speeds (sampled) -> reference speed, slip, deceleration -> [criteria] -> dump valve of each axle: fill, hold, vent
//
// Written after the published principles of EN 15595 and UIC 541-05. It is not a certified device.
#pragma once
#include <array>
#include <cmath>

#include "rig/mechatronics/pneumatic_brake.hpp"

namespace rig {

struct WheelSlideProtection {
  double wheel_radius{0.46};           ///< that the device believes in [m]
  double reference_deceleration{1.6};  ///< the reference speed falls at most this fast [m/s^2]
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
};

class WheelSlideProtectionState {
 public:
  static constexpr int most_axles = 8;

  void reset(double speed) {
    reference_ = speed;
    for (Axle& axle : axle_) axle = {speed};
  }

  /// One sample: new valve states.
  ///
  /// @param axle_speed  [rad/s], `axles` of them
  void step(WheelSlideProtection const& p, double const* axle_speed, int axles, double period, DumpValve* valve) {
    double fastest = 0.0;
    for (int i = 0; i < axles; ++i) fastest = std::fmax(fastest, p.wheel_radius * axle_speed[i]);
    reference_ = std::fmax(fastest, reference_ - p.reference_deceleration * period);
    for (int i = 0; i < axles; ++i) {
      Axle& axle = axle_[static_cast<std::size_t>(i)];
      double const speed = p.wheel_radius * axle_speed[i];
      double const gain = period / (p.filter_time + period);
      axle.acceleration += gain * ((speed - axle.speed) / period - axle.acceleration);
      axle.speed = speed;
      valve[i] = decide(p, axle, period);
    }
  }

  double reference_speed() const { return reference_; }
  int cycles(int axle) const { return axle_[static_cast<std::size_t>(axle)].cycles; }

 private:
  struct Axle {
    double speed{0.0}, acceleration{0.0};
    double venting_for{0.0};  ///< [s]
    double pulse_clock{0.0};  ///< [s]
    bool slid{false};         ///< since the cylinder was last full
    DumpValve valve{DumpValve::fill};
    int cycles{0};
  };

  DumpValve decide(WheelSlideProtection const& p, Axle& axle, double period) {
    double const slip = reference_ - axle.speed;
    double const vent_above = std::fmax(p.vent_slip * reference_, p.vent_slip_speed);
    double const fill_below = std::fmax(p.fill_slip * reference_, p.fill_slip_speed);
    bool const locks_up = axle.acceleration < -p.vent_deceleration && slip > 0.5 * p.fill_slip_speed;
    bool const recovers = axle.acceleration > p.recovery_acceleration;
    DumpValve wanted = DumpValve::hold;
    if (reference_ < p.least_speed || axle.venting_for > p.longest_vent) {
      wanted = DumpValve::fill;
      axle.slid = false;
    } else if ((slip > vent_above || locks_up) && !recovers) {
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
  double reference_{0.0};
};

}  // namespace rig
