// contact/creep/kalker.hpp - Kalker's linear creep coefficients C_ij(nu, a/b).
//
// Quadratic in nu between the tabulated 0, 1/4, 1/2; a cubic spline with continuous second derivative over ln(a/b), exact
// at the table's knots. Outside 0.1 <= a/b <= 10 the end values hold (the asymptotes of the textbook jump there).
// Source: Kalker, On the rolling contact of two elastic bodies in the presence of dry friction (1967), appendix;
//         also Kalker, Three-Dimensional Elastic Bodies in Rolling Contact (1990), table E3.
#pragma once
#include <array>

#include "rollerrig/math/lane.hpp"

namespace rollerrig {

template <Scalar T>
struct KalkerCoefficients {
  T c11, c22, c23, c33;
};

class KalkerTable {
 public:
  static constexpr int knots = 19;
  explicit KalkerTable(double poisson_ratio);

  /// @param log_aspect  ln(a/b), a along the rolling direction
  template <Scalar T>
  KalkerCoefficients<T> at(T const& log_aspect) const {
    T const clipped =
        select(log_aspect < lowest(), T(lowest()), select(log_aspect > highest(), T(highest()), log_aspect));
    auto const i = piece_of(value_of(clipped));
    T const t = clipped - gather(knot_.data(), i);
    auto const value = [&](std::size_t c) {
      auto const p = [&](std::size_t power) { return gather(&piece_[0][c][power], i, 16); };
      return ((p(3) * t + p(2)) * t + p(1)) * t + p(0);
    };
    return {value(0), value(1), value(2), value(3)};
  }
  bool covers(double log_aspect) const { return log_aspect >= lowest() && log_aspect <= highest(); }

 private:
  double lowest() const { return knot_.front(); }
  double highest() const { return knot_.back(); }
  template <class Number>
  Index<Number> piece_of(Number const& x) const {
    if constexpr (lanes_of<Number> == 1) {
      int i = 0;
      for (std::size_t k = 1; k + 1 < knots; ++k) i += x >= knot_[k];
      return i;
    } else {
      Number i(0.0);
      for (std::size_t k = 1; k + 1 < knots; ++k) i += select(x < knot_[k], Number(0.0), Number(1.0));
      return truncated(i);
    }
  }
  std::array<double, knots> knot_;
  std::array<std::array<std::array<double, 4>, 4>, knots - 1> piece_;  // [interval][coefficient][power]
};

}  // namespace rollerrig
