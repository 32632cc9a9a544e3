// Reciprocals and inverse roots from the processor's estimates.
#include "rollerrig/math/lane.hpp"

#include <doctest/doctest.h>

using namespace rollerrig;

TEST_CASE_TEMPLATE("1/x and 1/sqrt(x) to two units in the last place", T, double, Lanes<native_lanes>,
                   Lanes<(native_lanes > 4 ? 4 : 1)>) {
  auto const first = [](T const& x) {
    if constexpr (std::same_as<T, double>)
      return x;
    else
      return x[0];
  };
  constexpr double two_units = 4.5e-16;
  double worst = 0.0, worst_root = 0.0;
  for (double x = 1.1e-30; x < 1e30; x *= 1.37) {
    worst = std::max(worst, std::abs(first(reciprocal(T(x))) * x - 1.0));
    worst = std::max(worst, std::abs(first(reciprocal(T(-x))) * x + 1.0));
    worst_root = std::max(worst_root, std::abs(first(inverse_root(T(x))) * std::sqrt(x) - 1.0));
  }
  CHECK(worst < two_units);
  CHECK(worst_root < two_units);
}
