// mechatronics/slip_search.hpp - finds by trial the slip at which an axle transmits most.
//
//   motor torque and speed of an axle -> mean torque of adhesion over an interval -> has the last change of the slip helped? -> slip
//
//     M = mean(C) - J (w_1 - w_0)/t,   s <- s q or s/q: as before where M has grown, the other way where it has fallen   (A24)
//
// Perturb and observe. Only intervals count in which the axle has slipped and was not released for the reference speed: where the
// slip limits nothing there is nothing to learn. Source  ours; docs/theory/adhesion.md.
#pragma once
#include <algorithm>
#include <cmath>

#include "rollerrig/fields.hpp"

namespace rollerrig {

struct SlipSearch {
  double interval{}, ratio{}, least{}, largest{}, axle_inertia{};

  static constexpr auto fields() {
    using P = SlipSearch;
    return members(
        Member{"interval", &P::interval, "s", "interval t between two changes of the slip; 0: no search", not_negative},
        Member{"ratio", &P::ratio, "1", "ratio q of a change", Range{1.0, 10.0, "1 to 10"}},
        Member{"least", &P::least, "1", "least slip tried, over that of the thresholds", not_negative},
        Member{"largest", &P::largest, "1", "largest slip tried, over that of the thresholds", not_negative},
        Member{"axle_inertia", &P::axle_inertia, "kg m^2", "inertia of an axle with its motor as assumed, J",
               not_negative});
  }

  /// Of one axle.
  struct State {
    double slip{1.0};           ///< s, on the thresholds of slip
    bool rises{false};          ///< by its last change
    double clock{}, impulse{};  ///< of the interval [s], of the motor in it [N m s]
    double speed_before{};      ///< w_0 [rad/s]
    double last{};              ///< M of the interval before [N m]; 0: it does not count
    bool slipped{false};        ///< in the interval
    void state(auto& archive) { archive(slip, rises, clock, impulse, speed_before, last, slipped); }
  };

  /// One sample of an axle that slips or not.
  ///
  /// @param torque, speed  of the motor and of the axle, both in the sense in which the axle slips [N m], [rad/s]
  void step(State& s, double torque, double speed, bool slips, bool released, double period) const {
    if (!(interval > 0.0)) return;
    if (released || s.clock == 0.0) s = {s.slip, s.rises, 0.0, 0.0, speed, released ? 0.0 : s.last, false};
    s.clock += period;
    s.impulse += torque * period;
    s.slipped = s.slipped || slips;
    if (s.clock < interval) return;
    double const transmitted = (s.impulse - axle_inertia * (speed - s.speed_before)) / s.clock;
    if (s.slipped) {
      if (transmitted < s.last) s.rises = !s.rises;
      s.slip = std::fmin(std::fmax(largest, least), std::fmax(least, s.rises ? s.slip * ratio : s.slip / ratio));
    }
    s.last = s.slipped ? transmitted : 0.0;
    s.clock = 0.0;
  }
};

}  // namespace rollerrig
