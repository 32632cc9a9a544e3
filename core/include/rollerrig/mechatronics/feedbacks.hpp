// mechatronics/feedbacks.hpp - the feedback laws of the roller drives that a case can name.
//
// To add one: a header in feedback/, its line in AnyFeedback, its parameters in python/rollerrig/config/schema/rig_control.py.
#pragma once
#include <variant>

#include "rollerrig/mechatronics/feedback/none.hpp"
#include "rollerrig/mechatronics/feedback/proportional_integral.hpp"
#include "rollerrig/mechatronics/feedback/sliding_mode.hpp"

namespace rollerrig {

using AnyFeedback = std::variant<ProportionalIntegral, SlidingMode, NoFeedback>;

}  // namespace rollerrig
