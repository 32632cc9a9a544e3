// mechatronics/sanding_start/on_slide.hpp - sand while an axle slides, as slide protection or wheel-slip control sees it.
#pragma once
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/sanding_start/sanding_moment.hpp"

namespace rollerrig {

struct SandOnSlide {
  static constexpr char const* name = "on_slide";
  static constexpr auto fields() { return members(); }

  bool wanted(SandingMoment const& now) const { return now.slides; }
};

}  // namespace rollerrig
