// How far the forces of the strips are from C1 in the pose.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "contact/strip_wheel.hpp"

using namespace rollerrig;
using namespace rollerrig::test;

namespace {

using D = Dual<16>;

/// Derivative of the vertical force over shift (0) or approach (1) [N/m].
double rate(Wheel const& wheel, double y, double depth, int along) {
  auto const shift = along == 0 ? D::variable(y, 0) : D(y), approach = along == 1 ? D::variable(depth, 0) : D(depth);
  auto const found = strip_contact(wheel.setting, pose_of(D(0.0), shift, 0.46 - approach, D(0.0), D(0.0)));
  double sum = 0.0;
  for (int k = 0; k < found.count; ++k) {
    auto const& p = found.patch[static_cast<std::size_t>(k)];
    sum += (p.weight * p.normal * p.direction.z).d[0];
  }
  return sum;
}

/// What remains of a change of the derivative as its interval shrinks to 0.1 nm.
double jump_within(Wheel const& wheel, double a, double b, double depth) {
  double at_a = rate(wheel, a, depth, 0), at_b = rate(wheel, b, depth, 0);
  while (b - a > 1e-10) {
    double const middle = 0.5 * (a + b), at_middle = rate(wheel, middle, depth, 0);
    if (std::abs(at_middle - at_a) > std::abs(at_b - at_middle))
      b = middle, at_b = at_middle;
    else
      a = middle, at_a = at_middle;
  }
  return std::abs(at_b - at_a);
}

}  // namespace

TEST_CASE("the slope of the force over the shift jumps by less than a two-thousandth of the contact's stiffness") {
  // From 15 to 400 kN; the wide patch of the middle and the joining of two regions lie on the way.
  double const depth = 0.25e-3, step = 2e-6;
  for (double inverse_radius : {0.0, 2.0}) {
    Wheel const wheel(inverse_radius);
    double const stiffness = rate(wheel, 0.0, depth, 1);
    double before = rate(wheel, -3e-3, depth, 0), change = 0.0, largest = 0.0;
    for (int i = 1; i <= 3000; ++i) {
      double const y = -3e-3 + step * i, now = rate(wheel, y, depth, 0), last_change = change;
      change = now - before;
      before = now;
      if (i > 1 && std::abs(change - last_change) > 2e-5 * stiffness)
        largest = std::max(largest, jump_within(wheel, y - step, y, depth));
    }
    CAPTURE(inverse_radius);
    CHECK(largest < 5e-4 * stiffness);  // measured 3.1e-4 on a rail, 2.0e-4 on a roller
    CHECK(largest > 1e-6 * stiffness);  // C1 it is not: a contact that becomes so shall say it
  }
}
