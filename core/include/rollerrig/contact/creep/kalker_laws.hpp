// contact/creep/kalker_laws.hpp - Kalker's linear theory, the paper's saturation of it, and both with coefficients as given.
//
// Source  Malvezzi, Meli, Pugi (2010), eqs (20)-(24); Kalker (1967); Vermeulen and Johnson (1964) for (23); Cooperrider (1972)
//         for coefficients as given.
#pragma once
#include "rollerrig/contact/adhesion/friction.hpp"
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

/// Eq. (20) with coefficients of a patch as given, whatever its load and material; limited by (23), which here shrinks the
/// moment as well, so that it never drives: the power is epsilon (f11 e_x^2 + f22 e_y^2 + f33 e_sp^2).
///
/// With f11 = pi G a b / phi and f22 = pi G a b / psi (23) is the cubic of Vermeulen and Johnson over their normalised
/// creepages e_x / phi and e_y / psi, as Cooperrider takes it.
struct Coefficients {
  static constexpr char const* name = "coefficients";
  static constexpr bool in_lanes = true;
  double f11{0.0}, f22{0.0}, f23{0.0}, f33{0.0};
  bool saturation{true};
  static constexpr auto fields() {
    return members(Member{"f11", &Coefficients::f11, "N", "longitudinal coefficient", not_negative},
                   Member{"f22", &Coefficients::f22, "N", "lateral coefficient", not_negative},
                   Member{"f23", &Coefficients::f23, "N m", "coefficient of lateral creepage and spin", not_negative},
                   Member{"f33", &Coefficients::f33, "N m^2", "spin coefficient", not_negative},
                   Member{"saturation", &Coefficients::saturation});
  }

  template <Scalar T>
  KalkerStiffness<T> stiffness(CreepQuery<T> const& query) const {
    return {T(f11), T(f22), f23 * query.direction, T(f33)};
  }
  template <Scalar T>
  CreepForce<T> operator()(CreepQuery<T> query) const {
    return limited(query, stiffness(query));
  }
  template <Scalar T>
  CreepForce<T> operator()(CreepQuery<T> query, RailSurface<T> const& rail) const {
    query.stiffness = stiffness(query);
    return limited(query, with_reduced_stiffness(query, mean_reduction(rail)).stiffness);
  }

 private:
  template <Scalar T>
  CreepForce<T> limited(CreepQuery<T> const& query, KalkerStiffness<T> const& f) const {
    auto const linear = linear_creep_force(query.creepage, f);  // (20)
    if (!saturation) return linear;
    T const epsilon = johnson_vermeulen(demand(linear, query.adhesion));  // (23)
    return {epsilon * linear.longitudinal, epsilon * linear.lateral, epsilon * linear.spin_moment, epsilon};
  }
};

}  // namespace rollerrig
