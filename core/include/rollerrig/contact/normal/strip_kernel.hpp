// contact/normal/strip_kernel.hpp - what a strip of pressure does to a half-space, as functions of distance over half-length.
//
// A strip lies along the rolling direction x at y = 0: pressure semi-elliptic in x over |x| < a, line load w [N/m of y].
// The surface at x = 0, a distance y beside it, deflects by (Q/pi) w psi(y/a) / a and is curved along x by
// (Q/pi) w chi(y/a) / a^3. A strip of finite width is the integral over y; this table holds both integrals,
//
//     Psi(k) = int_0^k psi,   psi(k) = (4/pi) sqrt(1+k^2) (K - E)
//     Chi(k) = int_0^k chi = (4/pi) k/sqrt(1+k^2) K,   chi(k) = psi(k) / (1+k^2)          (S1), (S2)
//
// with complete elliptic integrals K, E of modulus 1/sqrt(1+k^2). Both are odd. Cubic pieces, eight to an octave of k.
// Other strips lie half a width away or more: over them psi and chi need no integral, but its mean over the width, which is
// psi in the middle and what the logarithm in it adds.
// Source: Boussinesq's point load, integrated; docs/theory/non_elliptic_contact.md.
#pragma once
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

#include "rollerrig/math/lane_spline.hpp"

namespace rollerrig {

class StripKernel {
 public:
  StripKernel();

  using Cubic = std::array<double, 4>;  ///< coefficients of the distance from the start of a piece
  /// What is tabulated over k.
  enum class Function { own_deflection, own_curvature, deflection };  // Psi, Chi, psi

  /// @param k  positive
  template <class T>
  T read(Function function, T const& k) const;

 private:
  static constexpr int lowest_octave = -16, octaves = 44;
  static constexpr double farthest = 1.0e8;  ///< below the end of the table

  std::array<std::vector<Cubic>, 3> cells_;  ///< the first one from zero
};

template <class T>
[[gnu::always_inline]] inline T StripKernel::read(Function function, T const& k) const {
  using N = NumberOf<T>;
  constexpr auto lanes = static_cast<std::size_t>(lanes_of<N>);
  Cubic const* const table = cells_[static_cast<std::size_t>(function)].data();
  N const x = clamped(value_of(k), std::ldexp(1.0, lowest_octave), farthest);
  alignas(64) std::array<double, lanes> number;
  store_lanes(x, number.data());
  // The exponent and the first three bits of the mantissa number the piece; without the other bits it is its start.
  alignas(64) std::array<std::uint64_t, lanes> bits;
  std::memcpy(bits.data(), number.data(), sizeof(bits));
  for (auto& b : bits) b >>= 49;
  RowsOf<N> row;
  for (std::size_t i = 0; i < lanes; ++i) row[i] = (table + (bits[i] - (8 * (1023 + lowest_octave) - 1)))->data();
  for (auto& b : bits) b <<= 49;
  std::memcpy(number.data(), bits.data(), sizeof(bits));
  N start;
  load_lanes(number.data(), start);
  N const t = x - start;
  auto const c = turned(row);
  N const value = ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
  if constexpr (std::same_as<T, N>)
    return value;
  else
    return along(k, value, N((3.0 * c[3] * t + 2.0 * c[2]) * t + c[1]));
}

}  // namespace rollerrig
