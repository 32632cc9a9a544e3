// mechatronics/slide_protection/threshold_table.hpp - slide protection by a table over bands of slip and of acceleration.
//
//   relative slip -> band (row), acceleration of the axle -> band (column) -> [table] -> fill, hold, vent, or vent in steps
//
// The cycle of phases that passes through such a table, hold at the threshold of deceleration, vent at that of slip, hold while
// the wheel regains speed, fill in steps, is that of anti-lock brakes:
// Source  U. Kiencke, L. Nielsen, Automotive Control Systems, Springer (2005), control cycles of anti-lock braking. The table as a
//         form and its numbers, for the slower air of railway brakes, are ours. It is not a certified device.
#pragma once
#include <cmath>
#include <tuple>
#include <vector>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/dump_valve.hpp"
#include "rollerrig/mechatronics/slide_protection/axle_observation.hpp"

namespace rollerrig {

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

  /// One sample: new valve states.
  void step(BrakedAxles& s, Measurements const& now, double period, PerAxle<double>& valve) const {
    s.observe(*this, now, period);
    for (int i = 0; i < now.axles; ++i) {
      auto const k = static_cast<std::size_t>(i);
      valve[k] = static_cast<double>(decide(s.axle[k], s, s.reference.releases(i), period));
    }
  }

  /// The entry for an axle with this slip and acceleration.
  Entry entry(double slip, double acceleration) const {
    std::size_t const row = band(slip_thresholds, slip), column = band(acceleration_thresholds, acceleration);
    return static_cast<Entry>(entries[row * (acceleration_thresholds.size() + 1) + column]);
  }

 private:
  static std::size_t band(std::vector<double> const& thresholds, double value) {
    std::size_t found = 0;
    while (found < thresholds.size() && value >= thresholds[found]) ++found;
    return found;
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
};

}  // namespace rollerrig
