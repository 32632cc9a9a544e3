// multibody/force_laws/dampers.hpp - force over rate: a constant damping, or a table.
#pragma once
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/math/piecewise_linear.hpp"
#include "rollerrig/multibody/force_laws/direction_force.hpp"

namespace rollerrig {

struct LinearDamper {
  static constexpr char const* name = "damping";
  double damping{0.0};
  static constexpr auto fields() {
    return members(Member{"damping", &LinearDamper::damping, "N s/m or N m s/rad", "damping"});
  }

  template <Scalar T>
  void operator()(DirectionState<T> const& at, DirectionForce<T>& on_b) const {
    T const viscous = damping * at.rate;
    on_b.force -= viscous;
    on_b.dissipated += viscous * at.rate;
  }
};

struct TabulatedDamper {
  static constexpr char const* name = "damping_table";
  PiecewiseLinear damping_table{};
  static constexpr auto fields() {
    return members(Member{"damping_table", &TabulatedDamper::damping_table, "N or N m", "force over rate"});
  }

  template <Scalar T>
  void operator()(DirectionState<T> const& at, DirectionForce<T>& on_b) const {
    T const viscous = damping_table.at(at.rate);
    on_b.force -= viscous;
    on_b.dissipated += viscous * at.rate;
  }
};

}  // namespace rollerrig
