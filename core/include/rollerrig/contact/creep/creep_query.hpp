// contact/creep/creep_query.hpp - what a creep law is asked, and what it answers.
//
// Signs   forces act on the wheel, along i (rolling direction) and t = n x i; the moment about n, out of the roller.
//         Creepage: velocity of the wheel's point relative to the roller's, over the rolling speed.
// Source  Malvezzi, Meli, Pugi (2010), eqs (20)-(22); Kalker (1967).
#pragma once
#include "rollerrig/contact/creep/kalker.hpp"
#include "rollerrig/contact/regularisation.hpp"

namespace rollerrig {

/// Eq. (21), with the corrections stated in docs/theory/contact_forces.md.
template <Scalar T>
struct Creepage {
  T longitudinal;  ///< epsilon_x [-]
  T lateral;       ///< epsilon_y [-]
  T spin;          ///< epsilon_sp [1/m]
};

/// f_ij of eq. (22).
template <Scalar T>
struct KalkerStiffness {
  T f11;  ///< [N]
  T f22;  ///< [N]
  T f23;  ///< [N m], signed with the direction of rolling
  T f33;  ///< [N m^2]
};

/// Eq. (22).
///
/// @param direction  rolling direction: +1 forward, -1 backward, smooth in between; the spin force changes sign with it
template <Scalar T>
KalkerStiffness<T> kalker_stiffness(KalkerCoefficients<T> const& c, double shear_modulus, T const& a, T const& b,
                                    T const& direction) {
  using std::sqrt;
  T const ab = a * b;
  T const g_ab = shear_modulus * ab;
  return {g_ab * c.c11, g_ab * c.c22, g_ab * sqrt(ab) * c.c23 * direction, g_ab * ab * c.c33};
}

/// One patch at one instant. Rolling backward is the mirror image of rolling forward: spin and moment change sign.
template <Scalar T>
struct CreepQuery {
  Creepage<T> creepage;
  KalkerStiffness<T> stiffness;
  T adhesion;    ///< mu N [N]; must be positive
  T a, b;        ///< semi-axes along and across the rolling direction [m]
  T log_aspect;  ///< ln(a/b)
  T direction;   ///< of rolling: +1 forward, -1 backward, smooth in between
};

template <Scalar T>
struct CreepForce {
  T longitudinal;  ///< T_x [N]
  T lateral;       ///< T_y [N]
  T spin_moment;   ///< M_sp [N m]
  T saturation;    ///< force over that of the linear theory: 1 in full adhesion, towards 0 in gross sliding
};

/// The same patch between surfaces that are so much more compliant: `factor` of Kalker's stiffness.
template <Scalar T>
CreepQuery<T> with_reduced_stiffness(CreepQuery<T> query, T const& factor) {
  auto& f = query.stiffness;
  f = {factor * f.f11, factor * f.f22, factor * f.f23, factor * f.f33};
  return query;
}

/// Eq. (20).
template <Scalar T>
CreepForce<T> linear_creep_force(Creepage<T> const& e, KalkerStiffness<T> const& f) {
  return {-(f.f11 * e.longitudinal), -(f.f22 * e.lateral) - f.f23 * e.spin, f.f23 * e.lateral - f.f33 * e.spin, T(1.0)};
}

/// tau = demanded / available.
template <Scalar T>
T demand(CreepForce<T> const& linear, T const& adhesion) {
  return regularisation::length(linear.longitudinal, linear.lateral, regularisation::force) / adhesion;
}

/// Length of a force over that of the linear theory, tau mu N.
template <Scalar T>
T saturation(T const& longitudinal, T const& lateral, T const& linear) {
  return regularisation::length(longitudinal, lateral, regularisation::force) / (linear + regularisation::force);
}

/// Eq. (23), the cubic of Johnson and Vermeulen: force over linear force.
template <Scalar T>
T johnson_vermeulen(T const& tau) {
  return select(tau < 3.0, 1.0 - tau / 3.0 + tau * tau / 27.0, 1.0 / tau);
}

/// Arm of friction against pure spin [m].
template <Scalar T>
T friction_arm(CreepQuery<T> const& query) {
  using std::sqrt;
  return (3.0 * pi / 16.0) * sqrt(0.5 * (query.a * query.a + query.b * query.b));
}

/// About the moment of friction against pure spin [N m]: exact on a circle (3 pi/16 mu N a), 11 % high for a long ellipse.
template <Scalar T>
T friction_moment(CreepQuery<T> const& query) {
  return query.adhesion * friction_arm(query);
}

/// What each creepage alone demands of mu N by the linear theory, per unit of it; spin by its force and its moment.
template <Scalar T>
std::array<T, 3> demand_per_creepage(CreepQuery<T> const& query) {
  using std::sqrt;
  auto const& f = query.stiffness;
  T const torsion = f.f33 / friction_arm(query);
  T const inverse = 1.0 / query.adhesion;
  return {f.f11 * inverse, f.f22 * inverse, sqrt(f.f23 * f.f23 + torsion * torsion) * inverse};
}

/// Where approximations of force and moment together would feed energy in, the moment gives way: (C16).
template <Scalar T>
CreepForce<T> never_drives(CreepQuery<T> const& query, CreepForce<T> const& force) {
  auto const& e = query.creepage;
  T const power = -(force.longitudinal * e.longitudinal + force.lateral * e.lateral + force.spin_moment * e.spin);
  auto const drives = power < 0.0 && !(e.spin * e.spin < square(regularisation::spin));
  T const spin = select(drives, e.spin, T(1.0));
  return {force.longitudinal, force.lateral, select(drives, force.spin_moment + power / spin, force.spin_moment),
          force.saturation};
}

}  // namespace rollerrig
