// contact/creep/creep_query.hpp - what a creep law is asked, and what it answers.
//
// Signs   forces act on the wheel, along i (rolling direction) and t = n x i; the moment about n, out of the roller.
//         Creepage: velocity of the wheel's point relative to the roller's, over the rolling speed.
// Source  Malvezzi, Meli, Pugi (2010), eqs (20)-(22); Kalker (1967).
#pragma once
#include <array>

#include "rollerrig/contact/regularisation.hpp"
#include "rollerrig/fields.hpp"
#include "rollerrig/math/lane.hpp"

namespace rollerrig {

// Kalker's linear creep coefficients C_ij(nu, a/b).
// Quadratic in nu between the tabulated 0, 1/4, 1/2; a cubic spline with continuous second derivative over ln(a/b), exact
// at the table's knots. Outside 0.1 <= a/b <= 10 the end values hold (the asymptotes of the textbook jump there).
// Source: Kalker, On the rolling contact of two elastic bodies in the presence of dry friction (1967), appendix;
//         also Kalker, Three-Dimensional Elastic Bodies in Rolling Contact (1990), table E3.

/// Kalker's table of creep coefficients {C11, C22, C23, C33} for nu = 0, 1/4, 1/2.
struct KalkerRow {
  double a_over_b;
  std::array<std::array<double, 4>, 3> value;  ///< [nu][coefficient]
};

inline constexpr std::array<KalkerRow, 19> kalker_rows{{
    {0.1, {{{2.51, 2.51, 0.334, 6.42}, {3.31, 2.52, 0.473, 8.28}, {4.85, 2.53, 0.731, 11.7}}}},
    {0.2, {{{2.59, 2.59, 0.483, 3.46}, {3.37, 2.63, 0.603, 4.27}, {4.81, 2.66, 0.809, 5.66}}}},
    {0.3, {{{2.68, 2.68, 0.607, 2.49}, {3.44, 2.75, 0.715, 2.96}, {4.8, 2.81, 0.889, 3.72}}}},
    {0.4, {{{2.78, 2.78, 0.72, 2.02}, {3.53, 2.88, 0.823, 2.32}, {4.82, 2.98, 0.977, 2.77}}}},
    {0.5, {{{2.88, 2.88, 0.827, 1.74}, {3.62, 3.01, 0.929, 1.93}, {4.83, 3.14, 1.07, 2.22}}}},
    {0.6, {{{2.98, 2.98, 0.93, 1.56}, {3.72, 3.14, 1.03, 1.68}, {4.91, 3.31, 1.18, 1.86}}}},
    {0.7, {{{3.09, 3.09, 1.03, 1.43}, {3.81, 3.28, 1.14, 1.5}, {4.97, 3.48, 1.29, 1.6}}}},
    {0.8, {{{3.19, 3.19, 1.13, 1.34}, {3.91, 3.41, 1.25, 1.37}, {5.05, 3.65, 1.4, 1.42}}}},
    {0.9, {{{3.29, 3.29, 1.23, 1.27}, {4.01, 3.54, 1.36, 1.27}, {5.12, 3.82, 1.51, 1.27}}}},
    {1.0, {{{3.4, 3.4, 1.33, 1.21}, {4.12, 3.67, 1.47, 1.19}, {5.2, 3.98, 1.63, 1.16}}}},
    {1.0 / 0.9, {{{3.51, 3.51, 1.44, 1.16}, {4.22, 3.81, 1.59, 1.11}, {5.3, 4.16, 1.77, 1.06}}}},
    {1.0 / 0.8, {{{3.65, 3.65, 1.58, 1.1}, {4.36, 3.99, 1.75, 1.04}, {5.42, 4.39, 1.94, 0.954}}}},
    {1.0 / 0.7, {{{3.82, 3.82, 1.76, 1.05}, {4.54, 4.21, 1.95, 0.965}, {5.58, 4.67, 2.18, 0.852}}}},
    {1.0 / 0.6, {{{4.06, 4.06, 2.01, 1.01}, {4.78, 4.5, 2.23, 0.892}, {5.8, 5.04, 2.5, 0.751}}}},
    {1.0 / 0.5, {{{4.37, 4.37, 2.35, 0.958}, {5.1, 4.9, 2.62, 0.819}, {6.11, 5.56, 2.96, 0.65}}}},
    {1.0 / 0.4, {{{4.84, 4.84, 2.88, 0.912}, {5.57, 5.48, 3.24, 0.747}, {6.57, 6.31, 3.7, 0.549}}}},
    {1.0 / 0.3, {{{5.57, 5.57, 3.79, 0.868}, {6.34, 6.4, 4.32, 0.674}, {7.34, 7.51, 5.01, 0.446}}}},
    {1.0 / 0.2, {{{6.96, 6.96, 5.72, 0.828}, {7.78, 8.14, 6.63, 0.601}, {8.82, 9.79, 7.89, 0.341}}}},
    {1.0 / 0.1, {{{10.7, 10.7, 12.2, 0.795}, {11.7, 12.8, 14.6, 0.526}, {12.9, 16.0, 18.0, 0.228}}}},
}};

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

  static constexpr auto fields() {
    using P = KalkerStiffness;
    return members(Member{"f11", &P::f11, "N", "f_11"}, Member{"f22", &P::f22, "N", "f_22"},
                   Member{"f23", &P::f23, "N m", "f_23"}, Member{"f33", &P::f33, "N m^2", "f_33"});
  }
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
