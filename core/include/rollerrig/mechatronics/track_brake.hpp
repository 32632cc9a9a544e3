// mechatronics/track_brake.hpp - brakes that act on the rail, not on a wheel: one of the laws in track_brake/, and when it is on.
//
//   demand, speed of the train -> [delay, straight rise] -> excitation, 0 to 1 -> force on each bogie, against running
//
// On track the force acts on what carries the magnets, in the line of its centre; on a rig there is no rail beside the rollers: it
// acts on the virtual train alone, by the same law.
//
// To add a law: a header in track_brake/, its line in AnyTrackBrake, its table in python/rollerrig/config/schema/brakes.py.
#pragma once
#include <algorithm>
#include <tuple>
#include <variant>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/track_brake/eddy_current.hpp"
#include "rollerrig/mechatronics/track_brake/magnetic.hpp"

namespace rollerrig {

using AnyTrackBrake = OneOf<MagneticTrackBrake, EddyCurrentTrackBrake>;

struct TrackBrake {
  AnyTrackBrake law{};  ///< of one bogie
  double bogies{};
  TimeTable demand{};
  double delay{}, rise_time{}, release_speed{};

  static constexpr auto fields() {
    using P = TrackBrake;
    return members(Member{"law", &P::law},
                   Member{"bogies", &P::bogies, "1", "number of bogies under test that have it", not_negative},
                   Member{"demand", &P::demand, "1", "demanded excitation, 0 to 1", fraction},
                   Member{"delay", &P::delay, "s", "delay from the demand to the first force: lowering", not_negative},
                   Member{"rise_time", &P::rise_time, "s", "rise time of the excitation, from none to full", positive},
                   Member{"release_speed", &P::release_speed, "m/s", "train speed below which the magnets are lifted",
                          not_negative});
  }

  /// Of one bogie in full excitation, against running [N], at a speed over the rail [m/s].
  template <Scalar T>
  T force(T const& speed) const {
    return std::visit([&](auto const& one) { return one.force(speed); }, law);
  }

  /// The excitation a step later.
  double next(double excitation, double t, double train_speed, double h) const {
    double const wanted = train_speed < release_speed ? 0.0 : demand.at(t - delay);
    return std::clamp(wanted, excitation - h / rise_time, excitation + h / rise_time);
  }
};

}  // namespace rollerrig
