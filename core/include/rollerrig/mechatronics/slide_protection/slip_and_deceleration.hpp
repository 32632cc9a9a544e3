// mechatronics/slide_protection/slip_and_deceleration.hpp - our law of slide protection: two slips, a deceleration, pulses.
//
//   axle speeds (sampled) -> reference speed, slip, deceleration -> [criteria] -> dump valve of each axle: fill, hold, vent
//
// Written after the published principles of EN 15595 and UIC 541-05. It is not a certified device.
#pragma once
#include <cmath>
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/dump_valve.hpp"
#include "rollerrig/mechatronics/slide_protection/axle_observation.hpp"

namespace rollerrig {

struct SlipAndDeceleration {
  static constexpr char const* name = "slip_and_deceleration";

  double wheel_radius{};            ///< assumed [m]
  double reference_deceleration{};  ///< largest of the reference speed [m/s^2]
  double filter_time{};             ///< of the axles' deceleration [s]
  double vent_slip{};               ///< relative slip above which a cylinder is vented [-]
  double vent_slip_speed{};         ///< and the least such slip as a speed [m/s]
  double vent_deceleration{};       ///< an axle that slows faster, and slips at all, is vented [m/s^2]
  double fill_slip{};               ///< relative slip below which a cylinder is filled again [-]
  double fill_slip_speed{};         ///< and the least such slip as a speed [m/s]
  double recovery_acceleration{};   ///< an axle that regains speed faster is not vented [m/s^2]
  double pulse_time{};              ///< after a slide filling is stepwise: open for this long ... [s]
  double pulse_pause{};             ///< ... closed for this long, as long as the axle slips [s]
  double longest_vent{};            ///< after this the watchdog fills, whatever the criteria say [s]
  double least_speed{};             ///< below it all valves fill [m/s]
  double release_interval{};    ///< while all axles slide, one is released this often for the reference; 0: never [s]
  double shortest_release{};    ///< the valve needs some time to open, the cylinder to empty [s]
  double longest_release{};     ///< [s]
  double least_deceleration{};  ///< of the reference between releases [m/s^2]
  double regained_after{};      ///< without slip for this long, an axle counts as gripping again [s]

  static constexpr auto fields() {
    using P = SlipAndDeceleration;
    return std::tuple{Member{"wheel_radius", &P::wheel_radius, positive},
                      Member{"reference_deceleration", &P::reference_deceleration},
                      Member{"filter_time", &P::filter_time, not_negative},
                      Member{"vent_slip", &P::vent_slip},
                      Member{"vent_slip_speed", &P::vent_slip_speed},
                      Member{"vent_deceleration", &P::vent_deceleration},
                      Member{"fill_slip", &P::fill_slip},
                      Member{"fill_slip_speed", &P::fill_slip_speed},
                      Member{"recovery_acceleration", &P::recovery_acceleration},
                      Member{"pulse_time", &P::pulse_time},
                      Member{"pulse_pause", &P::pulse_pause},
                      Member{"longest_vent", &P::longest_vent},
                      Member{"least_speed", &P::least_speed},
                      Member{"release_interval", &P::release_interval},
                      Member{"shortest_release", &P::shortest_release},
                      Member{"longest_release", &P::longest_release},
                      Member{"least_deceleration", &P::least_deceleration},
                      Member{"regained_after", &P::regained_after}};
  }

  /// One sample: new valve states.
  void step(BrakedAxles& s, Measurements const& now, double period, PerAxle<double>& valve) const {
    s.observe(*this, now, period);
    for (int i = 0; i < now.axles; ++i) {
      auto const k = static_cast<std::size_t>(i);
      valve[k] = static_cast<double>(decide(s.axle[k], s.reference_speed(), s.reference.releases(i), period));
    }
  }

 private:
  DumpValve decide(BrakedAxle& axle, double reference, bool released, double period) const {
    double const slip = reference - axle.speed;
    double const vent_above = std::fmax(vent_slip * reference, vent_slip_speed);
    double const fill_below = std::fmax(fill_slip * reference, fill_slip_speed);
    axle.grips_for = slip < fill_below ? axle.grips_for + period : 0.0;
    if (axle.grips_for > regained_after) axle.slid = false;
    bool const locks_up = axle.acceleration < -vent_deceleration && slip > 0.5 * fill_slip_speed;
    bool const recovers = axle.acceleration > recovery_acceleration;
    DumpValve wanted = DumpValve::hold;
    if (reference < least_speed || axle.vents_for > longest_vent) {
      wanted = DumpValve::fill;
      axle.slid = false;
    } else if (released || ((slip > vent_above || locks_up) && !recovers)) {
      wanted = DumpValve::vent;
    } else if (slip < fill_below && !axle.slid) {
      wanted = DumpValve::fill;
    } else if (slip < fill_below) {
      axle.pulse_clock += period;
      if (axle.pulse_clock > pulse_time + pulse_pause) axle.pulse_clock = 0.0;
      wanted = axle.pulse_clock <= pulse_time ? DumpValve::fill : DumpValve::hold;
    }
    bool const vents = wanted == DumpValve::vent;
    axle.vents_for = vents ? axle.vents_for + period : 0.0;
    axle.slid = axle.slid || vents;
    if (vents) axle.pulse_clock = 0.0;
    return wanted;
  }
};

}  // namespace rollerrig
