// mechatronics/sanding.hpp - when sand flows in front of which wheels, and how much.
//
//   time, distance, sliding axles -> [start, run-on, delay] -> flow in front of each sanding axle -> rail_memory.hpp
//
// To add a start: a struct here, its line in AnySandingStart, its table in python/rollerrig/config/schema/brakes.py.
#pragma once
#include <variant>

#include "rollerrig/fields.hpp"

namespace rollerrig {

struct SandingMoment {
  double time{};      ///< [s]
  double distance{};  ///< of the train since the start [m]
  bool slides{};      ///< slide protection vents some axle's cylinder, or wheel-slip control takes torque off one
};

/// Sand while an axle slides, as slide protection or wheel-slip control sees it.
struct SandOnSlide {
  static constexpr char const* name = "on_slide";
  static constexpr auto fields() { return members(); }

  bool wanted(SandingMoment const& now) const { return now.slides; }
};

/// Sand from a place on.
struct SandFromDistance {
  static constexpr char const* name = "from_distance";
  double begin{}, end{};

  static constexpr auto fields() {
    return members(
        Member{"begin", &SandFromDistance::begin, "m", "begin of sanding, distance of the train since the start"},
        Member{"end", &SandFromDistance::end, "m", "end of sanding"});
  }
  bool wanted(SandingMoment const& now) const { return now.distance >= begin && now.distance < end; }
};

/// Sand from a time on, as a driver switches it.
struct SandFromTime {
  static constexpr char const* name = "from_time";
  double begin{}, end{};

  static constexpr auto fields() {
    return members(Member{"begin", &SandFromTime::begin, "s", "begin of sanding"},
                   Member{"end", &SandFromTime::end, "s", "end of sanding"});
  }
  bool wanted(SandingMoment const& now) const { return now.time >= begin && now.time < end; }
};

using AnySandingStart = OneOf<SandOnSlide, SandFromDistance, SandFromTime>;

struct Sanding {
  AnySandingStart start{};
  double flow{}, delay{}, run_on{}, least_speed{}, kept{};

  static constexpr auto fields() {
    using P = Sanding;
    return members(
        Member{"start", &P::start},
        Member{"flow", &P::flow, "kg/s", "mass flow on each rail in front of a sanding axle", not_negative},
        Member{"delay", &P::delay, "s", "delay from the demand to the sand on the rail, and back", not_negative},
        Member{"run_on", &P::run_on, "s", "duration of sanding after its reason has gone", not_negative},
        Member{"least_speed", &P::least_speed, "m/s", "train speed below which there is no sanding", not_negative},
        Member{"kept", &P::kept, "1", "share of the sand on the rail that a wheel leaves behind", fraction});
  }
};

/// Of all axles of a vehicle: they are switched together.
class SandingSwitch {
 public:
  /// One step: whether sand is wanted now; it flows after the delay.
  bool step(Sanding const& sanding, SandingMoment const& now, double train_speed, double h) {
    bool const reason = std::visit([&](auto const& start) { return start.wanted(now); }, sanding.start);
    since_ = reason ? 0.0 : since_ + h;
    return (reason || since_ <= sanding.run_on) && train_speed >= sanding.least_speed;
  }

  void state(auto& archive) { archive(since_); }

 private:
  double since_{1e300};  ///< there was a reason [s]; at the start: never
};

}  // namespace rollerrig
