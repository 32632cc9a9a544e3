// mechatronics/drive_commands.hpp - how a roller's drive is asked for a torque: the laws that a case can name.
//
//   wanted torque, measured torque -> [drive command] -> command, within the largest torque
//
// To add one: a struct here, its line in AnyDriveCommand, its parameters in python/rollerrig/config/schema/rig_control.py.
#pragma once
#include <string_view>
#include <variant>

#include "rollerrig/fields.hpp"

namespace rollerrig {

/// The torque that a roller's drive is to exert, and what it exerts.
struct WantedTorque {
  double feed_forward{};  ///< of it, (D5) [N m]
  double total{};         ///< with the feedback [N m]
  double measured{};      ///< of the drive now [N m]
};

/// The drive is asked for the wanted torque, and follows with its lag.
struct DirectCommand {
  static constexpr char const* name = "direct";
  static constexpr auto fields() { return members(); }

  struct State {};

  double step(State& /*state*/, WantedTorque const& now, double /*period*/) const { return now.total; }
};

/// The feed-forward runs ahead along its slope by what the drive will be late.
///
///     c = U + a U_ff'        (D20)
///
/// With a the lag 1/w_b of a drive of first order this is its inverse. Source  docs/theory/rig_control.md.
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

/// A loop around the drive, closed over its measured torque.
///
///     c = U + g (U - U_measured)        (D21)
///
/// A drive of first order gets the bandwidth (1 + g) w_b. Source  docs/theory/rig_control.md.
struct TorqueLoop {
  static constexpr char const* name = "torque_loop";
  double gain{};

  static constexpr auto fields() {
    return members(Member{"gain", &TorqueLoop::gain, "1", "gain on demanded less measured torque, g", not_negative});
  }

  struct State {};

  double step(State& /*state*/, WantedTorque const& now, double /*period*/) const {
    return now.total + gain * (now.total - now.measured);
  }
};

using AnyDriveCommand = std::variant<DirectCommand, LeadCommand, TorqueLoop>;

}  // namespace rollerrig
