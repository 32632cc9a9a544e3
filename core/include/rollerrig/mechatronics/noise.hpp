// mechatronics/noise.hpp - noise of sensors: a function of seed and sample number alone, so that a run repeats to the last bit.
#pragma once
#include <cmath>
#include <cstdint>

#include "rollerrig/scalar.hpp"

namespace rollerrig {

/// Normally distributed number of mean 0 and deviation 1, the n-th of a stream (SplitMix64 and Box-Muller).
inline double normal_number(std::uint64_t stream, std::uint64_t n) {
  auto const mix = [](std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
  };
  auto const uniform = [&](std::uint64_t k) {  // in (0, 1)
    return (static_cast<double>(mix(mix(stream) ^ k) >> 11) + 0.5) * 0x1p-53;
  };
  return std::sqrt(-2.0 * std::log(uniform(2 * n))) * std::cos(2.0 * pi * uniform(2 * n + 1));
}

}  // namespace rollerrig
