// mechatronics/wheel_slide_protection.hpp - WSP: keeps braked axles near the adhesion limit by venting and refilling cylinders.
//
//   axle speeds (sampled) -> reference speed, slip, acceleration -> [law] -> dump valve of each axle: fill, hold, vent
//
// To add a law: a struct here with its fields and `decide`, its line in AnySlideProtection, its table in
// python/rollerrig/config/schema/actuators.py.
#pragma once
#include <cmath>
#include <variant>
#include <vector>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/measurements.hpp"
#include "rollerrig/mechatronics/pneumatics.hpp"
#include "rollerrig/mechatronics/reference_speed.hpp"

namespace rollerrig {

/// What every law of slide protection knows of its axles.
///
///   axle speeds (sampled) -> speed and filtered acceleration of each axle -> reference speed -> the law's criteria
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

  template <class Law>
  void step(Law const& law, Measurements const& now, double period, PerAxle<double>& valve) {
    observe(law, now, period);
    for (int i = 0; i < now.axles; ++i) {
      auto const k = static_cast<std::size_t>(i);
      valve[k] = static_cast<double>(law.decide(axle[k], *this, reference.releases(i), period));
    }
  }

 private:
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

/// Our law of slide protection: two slips, a deceleration, pulses.
///
///   axle speeds (sampled) -> reference speed, slip, deceleration -> [criteria] -> dump valve of each axle: fill, hold, vent
///
/// Written after the published principles of EN 15595 and UIC 541-05. It is not a certified device.
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

/// Slide protection by a table over bands of slip and of acceleration.
///
///   relative slip -> band (row), acceleration of the axle -> band (column) -> [table] -> fill, hold, vent, or vent in steps
///
/// The cycle of phases that passes through such a table, hold at the threshold of deceleration, vent at that of slip, hold while
/// the wheel regains speed, fill in steps, is that of anti-lock brakes:
/// Source  U. Kiencke, L. Nielsen, Automotive Control Systems, Springer (2005), control cycles of anti-lock braking. The table as a
///         form and its numbers, for the slower air of railway brakes, are ours. It is not a certified device.
struct ThresholdTable {
  static constexpr char const* name = "threshold_table";

  /// What an entry of the table says.
  enum class Entry : int { fill, hold, vent, vent_in_steps };

  double wheel_radius{}, reference_deceleration{}, filter_time{}, least_slip_reference{};
  std::vector<double> slip_thresholds{}, acceleration_thresholds{};
  std::vector<int> entries{};  ///< entries row by row: least slip first, strongest deceleration first
  double recovery_acceleration{}, pulse_time{}, pulse_pause{}, longest_vent{}, least_speed{}, return_speed{};
  double release_interval{}, shortest_release{}, longest_release{}, least_deceleration{}, regained_after{};

  static constexpr auto fields() {
    using P = ThresholdTable;
    return members(
        Member{"wheel_radius", &P::wheel_radius, "m", "radius of the wheels as assumed", positive},
        Member{"reference_deceleration", &P::reference_deceleration, "m/s^2",
               "largest deceleration of the reference speed"},
        Member{"filter_time", &P::filter_time, "s", "filter time of the axles' acceleration", not_negative},
        Member{"least_slip_reference", &P::least_slip_reference, "m/s",
               "reference speed below which slip is over it, not over the reference", positive},
        Member{"slip_thresholds", &P::slip_thresholds, "1", "relative slips between the rows, ascending", not_negative},
        Member{"acceleration_thresholds", &P::acceleration_thresholds, "m/s^2",
               "accelerations between the columns, ascending"},
        Member{"entries", &P::entries, Range{0.0, 3.0, "0 to 3"}},
        Member{"recovery_acceleration", &P::recovery_acceleration, "m/s^2",
               "acceleration below which a released axle has come to train speed"},
        Member{"pulse_time", &P::pulse_time, "s",
               "duration for which the valve is open in stepwise filling or venting"},
        Member{"pulse_pause", &P::pulse_pause, "s",
               "duration for which the valve is closed in stepwise filling or venting"},
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

  Entry entry(double slip, double acceleration) const {
    std::size_t const row = band(slip_thresholds, slip), column = band(acceleration_thresholds, acceleration);
    return static_cast<Entry>(entries[row * (acceleration_thresholds.size() + 1) + column]);
  }

  DumpValve decide(BrakedAxle& axle, BrakedAxles const& all, bool released, double period) const {
    double const reference = all.reference_speed();
    double const slip = (reference - axle.speed) / std::fmax(reference, least_slip_reference);
    bool const grips = slip_thresholds.empty() || slip < slip_thresholds.front();
    axle.grips_for = grips ? axle.grips_for + period : 0.0;
    if (axle.grips_for > regained_after) axle.slid = false;
    Entry const wanted = released ? Entry::vent : entry(slip, axle.acceleration);
    axle.pulse_clock = axle.pulse_clock > pulse_time + pulse_pause ? 0.0 : axle.pulse_clock + period;
    bool const pulse = axle.pulse_clock <= pulse_time;
    DumpValve valve = DumpValve::hold;
    if (all.off || axle.vents_for > longest_vent) {
      valve = DumpValve::fill;
      axle.slid = false;
    } else if (wanted == Entry::vent || (wanted == Entry::vent_in_steps && pulse)) {
      valve = DumpValve::vent;
    } else if (wanted == Entry::fill && (pulse || !axle.slid)) {
      valve = DumpValve::fill;
    }
    bool const vents = valve == DumpValve::vent;
    axle.vents_for = vents ? axle.vents_for + period : 0.0;
    axle.slid = axle.slid || vents;
    return valve;
  }

 private:
  static std::size_t band(std::vector<double> const& thresholds, double value) {
    std::size_t found = 0;
    while (found < thresholds.size() && value >= thresholds[found]) ++found;
    return found;
  }
};

using AnySlideProtection = OneOf<SlipAndDeceleration, ThresholdTable>;

struct WheelSlideProtection {
  static constexpr char const* name = "slide_protection";
  static constexpr Command command = Command::dump_valve;

  AnySlideProtection law{};

  static constexpr auto fields() { return members(Member{"law", &WheelSlideProtection::law}); }

  using State = BrakedAxles;

  State start(Measurements const& /*now*/, double train_speed, double /*period*/) const {
    return State::at(train_speed);
  }

  void step(State& s, Measurements const& now, double period, PerAxle<double>& valve) const {
    std::visit([&](auto const& one) { s.step(one, now, period, valve); }, law);
  }
};

}  // namespace rollerrig
