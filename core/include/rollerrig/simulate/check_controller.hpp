// simulate/check_controller.hpp - whether the lists in a controller belong together.
#pragma once
#include <cstddef>

#include "rollerrig/mechatronics/controllers.hpp"

namespace rollerrig {

/// Throws std::invalid_argument: lists of the wrong length for so many axles under test, a sample time or delay out of its range.
void check_controller(SampledController const& sampled, std::size_t axles);

}  // namespace rollerrig
