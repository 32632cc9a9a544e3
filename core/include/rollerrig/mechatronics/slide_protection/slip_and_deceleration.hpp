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

  double wheel_radius{}, reference_deceleration{}, filter_time{}, vent_slip{}, vent_slip_speed{}, vent_deceleration{};
  double fill_slip{}, fill_slip_speed{}, recovery_acceleration{}, pulse_time{}, pulse_pause{}, longest_vent{};
  double least_speed{}, return_speed{}, release_interval{}, shortest_release{}, longest_release{};
  double least_deceleration{}, regained_after{};

  static constexpr auto fields() {
    using P = SlipAndDeceleration;
    return members(
        Member{"wheel_radius", &P::wheel_radius, "m", "radius of the wheels as assumed", positive},
        Member{"reference_deceleration", &P::reference_deceleration, "m/s^2",
               "largest deceleration of the reference speed"},
        Member{"filter_time", &P::filter_time, "s", "filter time of the axles' acceleration", not_negative},
        Member{"vent_slip", &P::vent_slip, "1", "relative slip above which a cylinder is vented"},
        Member{"vent_slip_speed", &P::vent_slip_speed, "m/s", "lower limit of that slip as a speed"},
        Member{"vent_deceleration", &P::vent_deceleration, "m/s^2",
               "deceleration above which a slipping axle is vented"},
        Member{"fill_slip", &P::fill_slip, "1", "relative slip below which a cylinder is filled again"},
        Member{"fill_slip_speed", &P::fill_slip_speed, "m/s", "lower limit of that slip as a speed"},
        Member{"recovery_acceleration", &P::recovery_acceleration, "m/s^2",
               "acceleration above which a sliding axle regains speed and is not vented"},
        Member{"pulse_time", &P::pulse_time, "s", "duration for which the valve is open in stepwise filling"},
        Member{"pulse_pause", &P::pulse_pause, "s", "duration for which the valve is closed in stepwise filling"},
        Member{"longest_vent", &P::longest_vent, "s", "longest venting, after which the watchdog fills"},
        Member{"least_speed", &P::least_speed, "m/s", "speed below which the protection is off: all valves fill"},
        Member{"return_speed", &P::return_speed, "m/s",
               "speed above which a protection that is off is on again, at least least_speed"},
        Member{"release_interval", &P::release_interval, "s",
               "interval at which an axle is released for the reference speed while all slide; 0: never"},
        Member{"shortest_release", &P::shortest_release, "s", "shortest duration of such a release"},
        Member{"longest_release", &P::longest_release, "s", "longest duration of such a release"},
        Member{"least_deceleration", &P::least_deceleration, "m/s^2",
               "least deceleration of the reference speed between releases"},
        Member{"regained_after", &P::regained_after, "s",
               "duration without slip after which an axle counts as gripping again"});
  }

  /// One sample: new valve states.
  void step(BrakedAxles& s, Measurements const& now, double period, PerAxle<double>& valve) const {
    s.observe(*this, now, period);
    for (int i = 0; i < now.axles; ++i) {
      auto const k = static_cast<std::size_t>(i);
      valve[k] = static_cast<double>(decide(s.axle[k], s, s.reference.releases(i), period));
    }
  }

 private:
  DumpValve decide(BrakedAxle& axle, BrakedAxles const& all, bool released, double period) const {
    double const reference = all.reference_speed();
    double const slip = reference - axle.speed;
    double const vent_above = std::fmax(vent_slip * reference, vent_slip_speed);
    double const fill_below = std::fmax(fill_slip * reference, fill_slip_speed);
    axle.grips_for = slip < fill_below ? axle.grips_for + period : 0.0;
    if (axle.grips_for > regained_after) axle.slid = false;
    bool const locks_up = axle.acceleration < -vent_deceleration && slip > 0.5 * fill_slip_speed;
    bool const recovers = axle.acceleration > recovery_acceleration;
    DumpValve wanted = DumpValve::hold;
    if (all.off || axle.vents_for > longest_vent) {
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
