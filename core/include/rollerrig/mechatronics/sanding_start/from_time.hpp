// mechatronics/sanding_start/from_time.hpp - sand from a time on, as a driver switches it.
#pragma once
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/sanding_start/sanding_moment.hpp"

namespace rollerrig {

struct SandFromTime {
  static constexpr char const* name = "from_time";
  double begin{}, end{};

  static constexpr auto fields() {
    return members(Member{"begin", &SandFromTime::begin, "s", "begin of sanding"},
                   Member{"end", &SandFromTime::end, "s", "end of sanding"});
  }
  bool wanted(SandingMoment const& now) const { return now.time >= begin && now.time < end; }
};

}  // namespace rollerrig
