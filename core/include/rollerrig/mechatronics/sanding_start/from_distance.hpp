// mechatronics/sanding_start/from_distance.hpp - sand from a place on.
#pragma once
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/sanding_start/sanding_moment.hpp"

namespace rollerrig {

struct SandFromDistance {
  static constexpr char const* name = "from_distance";
  double begin{}, end{};

  static constexpr auto fields() {
    return members(
        Member{"begin", &SandFromDistance::begin, "m", "begin of sanding, distance of the train since the start"},
        Member{"end", &SandFromDistance::end, "m", "end of sanding"});
  }
  bool wanted(SandingMoment const& now) const { return now.distance >= begin && now.distance < end; }
};

}  // namespace rollerrig
