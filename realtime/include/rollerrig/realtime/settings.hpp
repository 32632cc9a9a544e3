// realtime/settings.hpp - how a server keeps time, and how long it is patient.
#pragma once
#include <cmath>
#include <cstdint>

#include "rollerrig/fields.hpp"

namespace rollerrig::realtime {

struct ServerSettings {
  double period{1e-3};
  int periods{};     ///< of the run
  int session{};     ///< told to the controller
  int oldest{3};     ///< periods that the sensors may be old that a command answers
  int patience{10};  ///< periods without a command until the watchdog acts
  int ramp{200};     ///< periods from there to the safe state
  bool lock_step{};  ///< wait for each command
  bool at_once{};    ///< begin without a controller, and go on without one
  double give_up{10.0}, spin{5e-5};
  bool record{};  ///< keep what acted and what was sent

  static constexpr auto fields() {
    using P = ServerSettings;
    constexpr Range a_period{1e-6, 10.0, "from 1e-6 to 10 s"};
    constexpr Range count{1.0, 1e9, "a count from 1 to 1e9"};
    constexpr Range from_zero{0.0, 1e9, "a count from 0 to 1e9"};
    constexpr Range patience_range{1e-3, 1e6, "from 0.001 to 1e6 s"};
    constexpr Range spin_range{0.0, 1.0, "from 0 to 1 s"};
    return members(
        Member{"period", &P::period, "s", "period of the loop", a_period}, Member{"periods", &P::periods, count},
        Member{"session", &P::session, count}, Member{"oldest", &P::oldest, from_zero},
        Member{"patience", &P::patience, count}, Member{"ramp", &P::ramp, from_zero},
        Member{"lock_step", &P::lock_step}, Member{"at_once", &P::at_once},
        Member{"give_up", &P::give_up, "s", "duration without a command after which a run in lock-step ends",
               patience_range},
        Member{"spin", &P::spin, "s", "busy waiting before each deadline", spin_range}, Member{"record", &P::record});
  }

  std::int64_t period_ns() const { return std::llround(1e9 * period); }
};

}  // namespace rollerrig::realtime
