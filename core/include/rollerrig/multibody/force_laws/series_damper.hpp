// multibody/force_laws/series_damper.hpp - a damper in series with a spring (Maxwell).
//
// Between them is the inner node s: the force is k_s (d - s), and c s_dot equals it.
#pragma once
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/multibody/force_laws/direction_force.hpp"

namespace rollerrig {

struct SeriesDamper {
  static constexpr char const* name = "damper";
  double damping{0.0}, series_stiffness{0.0};
  static constexpr auto fields() {
    return members(Member{"damping", &SeriesDamper::damping, "N s/m or N m s/rad", "damping, c"},
                   Member{"series_stiffness", &SeriesDamper::series_stiffness, "N/m or N m/rad",
                          "stiffness of the series spring, k_s"});
  }

  InnerNode node() const { return {damping, series_stiffness}; }

  template <Scalar T>
  void operator()(DirectionState<T> const& at, DirectionForce<T>& on_b, T& node_rate) const {
    T const branch = series_stiffness * (at.d - at.s);
    node_rate = branch / damping;
    on_b.force -= branch;
    on_b.dissipated += branch * node_rate;
  }
  double potential(double d, double s) const { return 0.5 * series_stiffness * (d - s) * (d - s); }
};

}  // namespace rollerrig
