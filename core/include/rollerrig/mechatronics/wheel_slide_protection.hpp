// mechatronics/wheel_slide_protection.hpp - WSP: keeps braked axles near the adhesion limit by venting and refilling cylinders.
//
//   axle speeds (sampled) -> reference speed, slip, acceleration -> [law] -> dump valve of each axle: fill, hold, vent
//
// To add a law: a header in slide_protection/, its line in AnySlideProtection, its table in
// python/rollerrig/config/schema/actuators.py.
#pragma once
#include <tuple>
#include <variant>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/law_state.hpp"
#include "rollerrig/mechatronics/slide_protection/slip_and_deceleration.hpp"
#include "rollerrig/mechatronics/slide_protection/threshold_table.hpp"

namespace rollerrig {

using AnySlideProtection = OneOf<SlipAndDeceleration, ThresholdTable>;

struct WheelSlideProtection {
  static constexpr char const* name = "slide_protection";
  static constexpr Command command = Command::dump_valve;

  AnySlideProtection law{};

  static constexpr auto fields() { return members(Member{"law", &WheelSlideProtection::law}); }

  using State = BrakedAxles;

  State start(Measurements const& /*now*/, double train_speed, double /*period*/) const {
    return State::at(train_speed);
  }

  /// One sample: new valve states.
  void step(State& s, Measurements const& now, double period, PerAxle<double>& valve) const {
    std::visit([&](auto const& one) { one.step(s, now, period, valve); }, law);
  }
};

}  // namespace rollerrig
