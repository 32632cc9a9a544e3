// multibody/force_laws/springs.hpp - force over deflection: a constant stiffness, or a table.
#pragma once
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/math/piecewise_linear.hpp"
#include "rollerrig/multibody/force_laws/direction_force.hpp"

namespace rollerrig {

struct LinearSpring {
  static constexpr char const* name = "stiffness";
  double stiffness{0.0};
  static constexpr auto fields() {
    return members(Member{"stiffness", &LinearSpring::stiffness, "N/m or N m/rad", "stiffness"});
  }

  template <Scalar T>
  void operator()(DirectionState<T> const& at, DirectionForce<T>& on_b) const {
    on_b.force -= stiffness * at.d;
  }
  double potential(double d, double /*s*/) const { return 0.5 * stiffness * d * d; }
};

/// A nonlinear spring or a bumpstop.
struct TabulatedSpring {
  static constexpr char const* name = "table";
  PiecewiseLinear table{};
  static constexpr auto fields() {
    return members(Member{"table", &TabulatedSpring::table, "N or N m", "force over deflection"});
  }

  template <Scalar T>
  void operator()(DirectionState<T> const& at, DirectionForce<T>& on_b) const {
    on_b.force -= table.at(at.d);
  }
  double potential(double d, double /*s*/) const { return table.integral(d); }
};

}  // namespace rollerrig
