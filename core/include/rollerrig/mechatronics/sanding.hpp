// mechatronics/sanding.hpp - when sand flows in front of which wheels, and how much.
//
//   time, distance, sliding axles -> [start, run-on, delay] -> flow in front of each sanding axle -> sanded_rail.hpp
//
// To add a start: a header in sanding_start/, its line in AnySandingStart, its table in python/rollerrig/config/schema/brakes.py.
#pragma once
#include <cmath>
#include <tuple>
#include <variant>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/sanding_start/from_distance.hpp"
#include "rollerrig/mechatronics/sanding_start/from_time.hpp"
#include "rollerrig/mechatronics/sanding_start/on_slide.hpp"

namespace rollerrig {

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
