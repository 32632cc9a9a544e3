// contact/patch_strips.hpp - the strips of a patch one by one: what normal contact knows of a bent patch and a creep law may follow.
#pragma once
#include <array>
#include <cstddef>

#include "rollerrig/scalar.hpp"

namespace rollerrig {

/// Number by number, so that as many strips as there are lanes are read at once. Frame b. A region that was solved with few strips
/// and with many has both, their forces and areas times the weights of the two.
template <Scalar T>
struct PatchStrips {
  static constexpr std::size_t capacity = 48;  ///< 16, and 32 more where these had not settled
  using Row = std::array<T, capacity>;
  int count{0};               ///< a multiple of 16
  std::array<Row, 3> point;   ///< middle of the strip on the roller: x, y, z [m]
  std::array<Row, 3> normal;  ///< there, out of the roller
  Row force;                  ///< of its pressures [N]
  Row area;                   ///< [m^2]
  Row half_length;            ///< along the rolling direction [m]
};

/// Every number of the strips through a function.
template <Scalar From, Scalar To, class F>
void convert(PatchStrips<From> const& from, PatchStrips<To>& to, F const& f) {
  to.count = from.count;
  auto const n = at(from.count);
  auto const row = [&](auto const& numbers, auto& into) {
    for (std::size_t i = 0; i < n; ++i) into[i] = f(numbers[i]);
  };
  for (std::size_t k = 0; k < 3; ++k) row(from.point[k], to.point[k]), row(from.normal[k], to.normal[k]);
  row(from.force, to.force), row(from.area, to.area), row(from.half_length, to.half_length);
}

}  // namespace rollerrig
