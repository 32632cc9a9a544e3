// contact/creep/kalker_laws.hpp - Kalker's linear theory, and the paper's saturation of it.
//
// Source  Malvezzi, Meli, Pugi (2010), eqs (20)-(24); Kalker (1967); Vermeulen and Johnson (1964) for (23).
#pragma once
#include "rollerrig/contact/creep/creep_query.hpp"
#include "rollerrig/fields.hpp"

namespace rollerrig {

/// Eq. (20): no limit of adhesion.
struct KalkerLinear {
  static constexpr char const* name = "kalker_linear";
  static constexpr bool in_lanes = true;
  static constexpr auto fields() { return members(); }

  template <Scalar T>
  CreepForce<T> operator()(CreepQuery<T> const& query) const {
    return linear_creep_force(query.creepage, query.stiffness);
  }
};

/// Eqs (20), (23), (24): the paper's law. The spin moment stays unsaturated as published unless asked otherwise.
struct KalkerSaturated {
  static constexpr char const* name = "kalker_saturated";
  static constexpr bool in_lanes = true;
  bool saturate_spin_moment{false};
  static constexpr auto fields() {
    return members(Member{"saturate_spin_moment", &KalkerSaturated::saturate_spin_moment});
  }

  template <Scalar T>
  CreepForce<T> operator()(CreepQuery<T> const& query) const {
    auto const linear = linear_creep_force(query.creepage, query.stiffness);  // (20)
    T const epsilon = johnson_vermeulen(demand(linear, query.adhesion));      // (23)
    T const moment = saturate_spin_moment ? epsilon * linear.spin_moment : linear.spin_moment;
    return {epsilon * linear.longitudinal, epsilon * linear.lateral, moment, epsilon};  // (24)
  }
};

}  // namespace rollerrig
