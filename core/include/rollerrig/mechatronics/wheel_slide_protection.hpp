// mechatronics/wheel_slide_protection.hpp - WSP: keeps braked axles near the adhesion limit by venting and refilling cylinders.
//
//   axle speeds (sampled) -> reference speed, slip, acceleration -> [law] -> dump valve of each axle: fill, hold, vent
//
// To add a law: a struct here with its fields, the State of one axle, `grips` and `decide`, its line in AnySlideProtection, its table
// in python/rollerrig/config/schema/actuators.py.
#pragma once
#include <cmath>
#include <vector>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/measurements.hpp"
#include "rollerrig/mechatronics/pneumatics.hpp"
#include "rollerrig/mechatronics/reference_speed.hpp"

namespace rollerrig {

/// What every law of slide protection knows of an axle.
struct BrakedAxle {
  double speed{}, acceleration{};  ///< at the wheel's circumference, the second one filtered [m/s], [m/s^2]
  bool slid{false};                ///< and has not gripped for long since
  void state(auto& archive) { archive(speed, acceleration, slid); }

  // Found anew at each sample.
  bool recovers{false};  ///< it gains speed
  bool released{false};  ///< for the reference speed
};

/// Our law of slide protection: two slips, a deceleration, pulses.
///
/// Written after the published principles of EN 15595 and UIC 541-05. It is not a certified device.
struct SlipAndDeceleration {
  static constexpr char const* name = "slip_and_deceleration";

  double vent_slip{}, vent_slip_speed{}, vent_deceleration{}, fill_slip{}, fill_slip_speed{};
  double pulse_time{}, pulse_pause{};

  static constexpr auto fields() {
    using P = SlipAndDeceleration;
    return members(
        Member{"vent_slip", &P::vent_slip, "1", "relative slip above which a cylinder is vented"},
        Member{"vent_slip_speed", &P::vent_slip_speed, "m/s", "lower limit of that slip as a speed"},
        Member{"vent_deceleration", &P::vent_deceleration, "m/s^2",
               "deceleration above which a slipping axle is vented"},
        Member{"fill_slip", &P::fill_slip, "1", "relative slip below which a cylinder is filled again"},
        Member{"fill_slip_speed", &P::fill_slip_speed, "m/s", "lower limit of that slip as a speed"},
        Member{"pulse_time", &P::pulse_time, "s", "duration for which the valve is open in stepwise filling"},
        Member{"pulse_pause", &P::pulse_pause, "s", "duration for which the valve is closed in stepwise filling"});
  }

  struct State {
    double pulse_clock{};  ///< [s]
    void state(auto& archive) { archive(pulse_clock); }
  };

  bool grips(BrakedAxle const& axle, double reference) const {
    return reference - axle.speed < std::fmax(fill_slip * reference, fill_slip_speed);
  }

  DumpValve decide(State& s, BrakedAxle const& axle, double reference, double period) const {
    double const slip = reference - axle.speed;
    double const vent_above = std::fmax(vent_slip * reference, vent_slip_speed);
    bool const locks_up = axle.acceleration < -vent_deceleration && slip > 0.5 * fill_slip_speed;
    if (axle.released || ((slip > vent_above || locks_up) && !axle.recovers)) {
      s.pulse_clock = 0.0;
      return DumpValve::vent;
    }
    if (!grips(axle, reference)) return DumpValve::hold;
    if (!axle.slid) return DumpValve::fill;
    s.pulse_clock += period;
    if (s.pulse_clock > pulse_time + pulse_pause) s.pulse_clock = 0.0;
    return s.pulse_clock <= pulse_time ? DumpValve::fill : DumpValve::hold;
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

  double least_slip_reference{};
  std::vector<double> slip_thresholds{}, acceleration_thresholds{};
  std::vector<int> entries{};  ///< entries row by row: least slip first, strongest deceleration first
  double pulse_time{}, pulse_pause{};

  static constexpr auto fields() {
    using P = ThresholdTable;
    return members(
        Member{"least_slip_reference", &P::least_slip_reference, "m/s",
               "reference speed below which slip is over it, not over the reference", positive},
        Member{"slip_thresholds", &P::slip_thresholds, "1", "relative slips between the rows, ascending", not_negative},
        Member{"acceleration_thresholds", &P::acceleration_thresholds, "m/s^2",
               "accelerations between the columns, ascending"},
        Member{"entries", &P::entries, Range{0.0, 3.0, "0 to 3"}},
        Member{"pulse_time", &P::pulse_time, "s",
               "duration for which the valve is open in stepwise filling or venting"},
        Member{"pulse_pause", &P::pulse_pause, "s",
               "duration for which the valve is closed in stepwise filling or venting"});
  }

  /// Throws std::invalid_argument where the table has not one entry for each pair of bands.
  void check() const {
    need(entries.size() == (slip_thresholds.size() + 1) * (acceleration_thresholds.size() + 1),
         "slide_protection: entries: needed is one for each band of slip and acceleration");
  }

  Entry entry(double slip, double acceleration) const {
    std::size_t const row = band(slip_thresholds, slip), column = band(acceleration_thresholds, acceleration);
    return static_cast<Entry>(entries[row * (acceleration_thresholds.size() + 1) + column]);
  }

  struct State {
    double pulse_clock{};  ///< [s]
    void state(auto& archive) { archive(pulse_clock); }
  };

  bool grips(BrakedAxle const& axle, double reference) const {
    return slip_thresholds.empty() || slip(axle, reference) < slip_thresholds.front();
  }

  DumpValve decide(State& s, BrakedAxle const& axle, double reference, double period) const {
    Entry const wanted = axle.released ? Entry::vent : entry(slip(axle, reference), axle.acceleration);
    s.pulse_clock = s.pulse_clock > pulse_time + pulse_pause ? 0.0 : s.pulse_clock + period;
    bool const pulse = s.pulse_clock <= pulse_time;
    if (wanted == Entry::vent || (wanted == Entry::vent_in_steps && pulse)) return DumpValve::vent;
    return wanted == Entry::fill && (pulse || !axle.slid) ? DumpValve::fill : DumpValve::hold;
  }

 private:
  double slip(BrakedAxle const& axle, double reference) const {
    return (reference - axle.speed) / std::fmax(reference, least_slip_reference);
  }
  static std::size_t band(std::vector<double> const& thresholds, double value) {
    std::size_t found = 0;
    while (found < thresholds.size() && value >= thresholds[found]) ++found;
    return found;
  }
};

using AnySlideProtection = OneOf<SlipAndDeceleration, ThresholdTable>;

/// One law, with what all of them need: speeds, filtered accelerations, reference speed, a watchdog.
struct WheelSlideProtection {
  static constexpr char const* name = "slide_protection";
  static constexpr Command command = Command::dump_valve;

  AnySlideProtection law{};
  double wheel_radius{}, reference_deceleration{}, filter_time{}, recovery_acceleration{}, longest_vent{};
  double least_speed{}, return_speed{}, release_interval{}, shortest_release{}, longest_release{};
  double least_deceleration{}, regained_after{};

  static constexpr auto fields() {
    using P = WheelSlideProtection;
    return members(
        Member{"law", &P::law},
        Member{"wheel_radius", &P::wheel_radius, "m", "radius of the wheels as assumed", positive},
        Member{"reference_deceleration", &P::reference_deceleration, "m/s^2",
               "largest deceleration of the reference speed"},
        Member{"filter_time", &P::filter_time, "s", "filter time of the axles' acceleration", not_negative},
        Member{"recovery_acceleration", &P::recovery_acceleration, "m/s^2",
               "acceleration above which a sliding or released axle regains speed"},
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

  struct AxleState {
    BrakedAxle seen{};
    double vents_for{}, grips_for{};  ///< [s]
    StateOf<AnySlideProtection> law{};
    void state(auto& archive) { archive(seen, vents_for, grips_for, law); }
  };
  struct State {
    PerAxle<AxleState> axle{};
    ReferenceSpeed reference{true, 0.0};
    bool off{false};  ///< near standstill: all valves fill

    double reference_speed() const { return reference.value(); }
    void state(auto& archive) { archive(axle, reference, off); }
  };

  State start(Measurements const& /*now*/, double train_speed, double /*period*/) const {
    State state{.axle = {}, .reference = {true, train_speed}};
    for (AxleState& axle : state.axle) axle.seen.speed = train_speed, axle.law = first_state(law);
    return state;
  }

  void step(State& s, Measurements const& now, double period, PerAxle<double>& valve) const {
    observe(s, now, period);
    for (int i = 0; i < now.axles; ++i) {
      AxleState& axle = s.axle[at(i)];
      axle.seen.released = s.reference.releases(i);
      auto const of_law = [&](auto const& one, auto& state) { return decide(one, state, s, axle, period); };
      valve[at(i)] = static_cast<double>(visit_with_state(of_law, law, axle.law));
    }
  }

 private:
  /// One sample: speeds, accelerations and the reference, (A7).
  void observe(State& s, Measurements const& now, double period) const {
    double fastest = 0.0;
    bool gripping = false;  // of some axle: its speed is the train's
    for (int i = 0; i < now.axles; ++i) {
      BrakedAxle& own = s.axle[at(i)].seen;
      double const speed = wheel_radius * now.vehicle_axle_speed[at(i)];
      double const gain = period / (filter_time + period);
      own.acceleration += gain * ((speed - own.speed) / period - own.acceleration);
      own.speed = speed;
      own.recovers = own.acceleration > recovery_acceleration;
      fastest = std::fmax(fastest, speed);
      gripping = gripping || !own.slid;
    }
    ReferenceSpeedRules const rules{reference_deceleration, least_deceleration, release_interval, shortest_release,
                                    longest_release};
    s.reference.advance(fastest, period);
    s.off = s.reference.value() < (s.off ? std::fmax(return_speed, least_speed) : least_speed);
    if (gripping || s.off) return s.reference.is_known(rules);
    s.reference.search(rules, fastest, now.axles, period, [&](int axle) { return s.axle[at(axle)].seen.recovers; });
  }

  template <class Law>
  DumpValve decide(Law const& one, typename Law::State& own, State const& all, AxleState& axle, double period) const {
    double const reference = all.reference.value();
    bool const overruled = all.off || axle.vents_for > longest_vent;
    axle.grips_for = one.grips(axle.seen, reference) ? axle.grips_for + period : 0.0;
    if (overruled || axle.grips_for > regained_after) axle.seen.slid = false;
    DumpValve const wanted = one.decide(own, axle.seen, reference, period);  // while overruled, too: its pulses go on
    DumpValve const valve = overruled ? DumpValve::fill : wanted;
    bool const vents = valve == DumpValve::vent;
    axle.vents_for = vents ? axle.vents_for + period : 0.0;
    axle.seen.slid = axle.seen.slid || vents;
    return valve;
  }
};

}  // namespace rollerrig
