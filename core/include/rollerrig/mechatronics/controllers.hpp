// mechatronics/controllers.hpp - the controllers that a case can have, each a table of its name.
//
// To add one: a header with a struct like WheelSlipControl, its line in AnyController, its table in the configuration.
#pragma once
#include <variant>

#include "rollerrig/mechatronics/brake_unit.hpp"
#include "rollerrig/mechatronics/rig_controller.hpp"
#include "rollerrig/mechatronics/wheel_slide_protection.hpp"
#include "rollerrig/mechatronics/wheel_slip_control.hpp"

namespace rollerrig {

using AnyController = std::variant<WheelSlideProtection, WheelSlipControl, RigController, BrakeUnit>;

inline Command command_of(AnyController const& any) {
  return std::visit([](auto const& law) { return law.command; }, any);
}

inline constexpr Range sampling_steps{1.0, 1e9, "one step or more"};
inline constexpr Range delay_steps{0.0, 1e5, "none to 100000 steps"};  ///< each is kept

/// When a controller is asked, and how long its answer takes.
struct Sampling {
  int every{1};          ///< sample time in sampling steps
  int delay{0};          ///< sampling steps from the sample to the command's acting
  bool external{false};  ///< the caller computes the command

  static constexpr auto fields() {
    return members(Member{"every", &Sampling::every, sampling_steps}, Member{"delay", &Sampling::delay, delay_steps},
                   Member{"external", &Sampling::external});
  }
};

struct SampledController {
  Sampling sampling{};
  AnyController controller{};

  static constexpr auto fields() {
    using P = SampledController;
    return members(Member{"sampling", &P::sampling}, Member{"controller", &P::controller});
  }
};

}  // namespace rollerrig
