// mechatronics/axles.hpp - how many axles sensors, controllers and actuators have room for.
#pragma once
#include <array>
#include <cstddef>

namespace rollerrig {

/// Of the vehicle under test; a model with more of them is refused.
constexpr int most_axles = 32;

template <class V>
using PerAxle = std::array<V, static_cast<std::size_t>(most_axles)>;

}  // namespace rollerrig
