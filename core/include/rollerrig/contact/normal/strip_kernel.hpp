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
// Source: Boussinesq's point load, integrated; docs/theory/non_elliptic_contact.md.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "rollerrig/math/lane_spline.hpp"

namespace rollerrig {

class StripKernel {
 public:
  StripKernel();

  template <Scalar T>
  T deflection(T const& k) const {
    return read(k, &Cell::deflection);
  }
  template <Scalar T>
  T curvature(T const& k) const {
    return read(k, &Cell::curvature);
  }

 private:
  static constexpr int lowest_octave = -12, octaves = 40;
  struct Cell {
    double start;
    std::array<double, 4> deflection, curvature;
  };

  /// @param k  not negative
  template <Scalar T>
  T read(T const& k, std::array<double, 4> Cell::* function) const {
    double const x = value_of(k);
    // The exponent and the first three bits of the mantissa number the piece.
    auto const bits = static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(x) >> 49);
    auto const i = std::clamp<std::int64_t>(bits - 8 * (1023 + lowest_octave) + 1, 0, 8 * octaves);
    Cell const& cell = cells_[static_cast<std::size_t>(i)];
    auto const& c = cell.*function;
    double const t = x - cell.start;
    double const value = ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
    if constexpr (std::same_as<T, double>)
      return value;
    else
      return along(k, value, (3.0 * c[3] * t + 2.0 * c[2]) * t + c[1]);
  }

  std::vector<Cell> cells_;  ///< the first one from zero
};

/// The kernel, built once for all.
StripKernel const& strip_kernel();

}  // namespace rollerrig
