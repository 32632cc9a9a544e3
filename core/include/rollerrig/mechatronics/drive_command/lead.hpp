// mechatronics/drive_command/lead.hpp - the feed-forward runs ahead along its slope by what the drive will be late.
//
//     c = U + a U_ff'        (D20)
//
// With a the lag 1/w_b of a drive of first order this is its inverse. Source  docs/theory/rig_control.md.
#pragma once
#include <string_view>
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/drive_command/wanted_torque.hpp"

namespace rollerrig {

struct LeadCommand {
  static constexpr char const* name = "lead";
  double ahead{};

  static constexpr auto fields() {
    return members(Member{"ahead", &LeadCommand::ahead, "s", "lead of the feed-forward, a", not_negative});
  }

  struct State {
    double last{};  ///< feed-forward [N m]
    void state(auto& archive) { archive(last); }
  };

  double step(State& s, WantedTorque const& now, double period) const {
    double const slope = (now.feed_forward - s.last) / period;
    s.last = now.feed_forward;
    return now.total + ahead * slope;
  }
};

}  // namespace rollerrig
