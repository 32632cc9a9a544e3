// contact/creep/fastsim.hpp - Kalker's simplified theory: the surface gives way at each point in proportion to the traction there.
//
//   strips along the rolling direction; in each, from the leading edge on, traction grows until friction limits it
//
// Classic: three flexibilities from C11, C22, C23, parabolic limit of traction. Modified: spin along and across the strip have
// flexibilities of their own (C23 and C33), so that the linear spin moment is right too; and the whole surface may become more
// flexible with slip, as on wet or contaminated rails. In both, a sliding point is pulled along its slip, not along the slip
// weighted with the flexibilities, and the weights of spin fade with slip: in full sliding the tractions are those of Coulomb.
// Equations and what they change: docs/theory/creep_laws.md, (C5)-(C9).
//
// Source  Kalker, A fast algorithm for the simplified theory of rolling contact, Vehicle System Dynamics 11 (1982);
//         Spiryagin, Polach, Cole, Creep force modelling for rail traction vehicles based on the Fastsim algorithm, VSD 51
//         (2013), for the flexibility that grows with slip.
#pragma once
#include <array>

#include "rollerrig/contact/creep/creep_query.hpp"
#include "rollerrig/fields.hpp"
#include "rollerrig/math/dual.hpp"

namespace rollerrig {

/// Strips across the patch, and elements along each.
constexpr int fastsim_strips = 10;
constexpr int fastsim_elements = 10;

/// What a solution depends on, tractions in units of the largest limit, lengths in a and b.
template <class T>
struct FastsimDemand {
  T along, across;            ///< growth of traction over a semi-axis from e_x, e_y
  T spin_along, spin_across;  ///< the same from spin at y = b, and at x = a
  T anisotropy;               ///< flexibility across over flexibility along
};

/// Over mu N: forces, and their moments per b and a.
template <class T>
struct FastsimSums {
  T along, across, along_y, across_x;
};

template <class T, int Strips = fastsim_strips, int Elements = fastsim_elements>
FastsimSums<T> fastsim_sums(FastsimDemand<T> const& d) {
  using std::sqrt;
  FastsimSums<T> sum{T(0.0), T(0.0), T(0.0), T(0.0)};
  double total = 0.0;
  T const half_difference = 0.5 * (1.0 - d.anisotropy);
  T const mean = 0.5 * (1.0 + d.anisotropy);
  for (int strip = 0; strip < Strips; ++strip) {
    double const y = -1.0 + (2.0 * strip + 1.0) / Strips;
    double const half = std::sqrt(1.0 - y * y);
    double const h = 2.0 * half / Elements;
    T const rate_x = d.along - d.spin_along * y;
    T px(0.0);
    T py(0.0);
    T strip_x(0.0);
    T strip_y(0.0);
    T strip_moment(0.0);
    double before = half;
    for (int i = 0; i < Elements; ++i) {
      double const x = half - (i + 0.5) * h;
      double const step = before - x;  // half a step first: tractions stand at the centres of the elements
      before = x;
      double const limit = 1.0 - x * x - y * y;
      px -= step * rate_x;
      py -= step * (d.across + (x + 0.5 * step) * d.spin_across);
      T const size2 = px * px + py * py;
      if (value_of(size2) > limit * limit) {
        // Sliding: p = -limit s/|s| with s = flexibility (p - p*) / step, so that p = (p*_x/(z + delta), m p*_y/(z - delta));
        // z as without anisotropy, then exact where sliding begins and where it is full.
        T const over = sqrt(size2) / limit;
        T const z = mean * over;
        py +=
            (0.5 * step * step) * d.spin_across * (1.0 - 1.0 / over);  // the slip at the element, not on the way to it
        T const tx = px * (z - half_difference);
        T const ty = d.anisotropy * py * (z + half_difference);
        T const shrink = limit / sqrt(tx * tx + ty * ty);
        px = shrink * tx;
        py = shrink * ty;
      }
      strip_x += px;
      strip_y += py;
      strip_moment += x * py;
      total += limit * h;
    }
    sum.along += h * strip_x;
    sum.across += h * strip_y;
    sum.along_y += (h * y) * strip_x;
    sum.across_x += h * strip_moment;
  }
  double const scale = 1.0 / total;
  return {scale * sum.along, scale * sum.across, scale * sum.along_y, scale * sum.across_x};
}

/// The sums in T: derivatives with respect to the five numbers first, then the chain rule, so the cost of a dual number
/// does not multiply with its seeds.
template <Scalar T>
FastsimSums<T> fastsim_sums_of(FastsimDemand<T> const& d) {
  if constexpr (std::is_same_v<T, double>) {
    return fastsim_sums(d);
  } else {
    using D = Dual<5>;
    std::array<T const*, 5> const in{&d.along, &d.across, &d.spin_along, &d.spin_across, &d.anisotropy};
    std::array<D, 5> v;
    for (int i = 0; i < 5; ++i) v[at(i)] = D::variable(value_of(*in[at(i)]), i);
    auto const s = fastsim_sums(FastsimDemand<D>{v[0], v[1], v[2], v[3], v[4]});
    auto const chain = [&](D const& r) {
      T out(r.value);
      for (int i = 0; i < 5; ++i) {
        T const& x = *in[at(i)];
        out += r.d[i] * (x - value_of(x));
      }
      return out;
    };
    return {chain(s.along), chain(s.across), chain(s.along_y), chain(s.across_x)};
  }
}

/// Force and moment with flexibilities from the creepage; `reduction` multiplies the stiffness. (C5)-(C9)
///
/// @param modified  whether spin has flexibilities of its own
template <Scalar T>
CreepForce<T> fastsim_force(CreepQuery<T> const& query, T const& tau, bool modified, T const& reduction) {
  auto const& e = query.creepage;
  auto const& f = query.stiffness;
  T const spin = query.direction * e.spin;
  T const friction_spin = f.f33 * e.spin / friction_moment(query);
  T const inverse = reduction / query.adhesion;
  // Growth of traction by Kalker's coefficients, and by the slip alone; the first at small creepage, the second at large.
  double const k = 3.0 * pi / 16.0;
  T const true_along = k * f.f11 * query.b * spin * inverse;
  T const true_across = k * f.f22 * query.a * spin * inverse;
  T const kalker_across = 2.0 * f.f23 * e.spin * inverse;
  T const kalker_along = modified ? 5.0 * k * f.f33 * spin / query.b * inverse : query.b / query.a * kalker_across;
  T const weight = 1.0 / (1.0 + (tau * tau + friction_spin * friction_spin) / 25.0);
  FastsimDemand<T> const d{k * f.f11 * e.longitudinal * inverse, k * f.f22 * e.lateral * inverse,
                           true_along + weight * (kalker_along - true_along),
                           true_across + weight * (kalker_across - true_across), f.f11 / f.f22};
  auto const s = fastsim_sums_of(d);
  T const tx = query.adhesion * s.along;
  T const ty = query.adhesion * s.across;
  T const moment = query.adhesion * query.direction * (query.a * s.across_x - query.b * s.along_y);
  return never_drives(query, CreepForce<T>{tx, ty, moment, saturation(tx, ty, tau * query.adhesion)});
}

/// Kalker's algorithm with three flexibilities.
struct Fastsim {
  static constexpr char const* name = "fastsim";
  static constexpr auto fields() { return members(); }

  template <Scalar T>
  CreepForce<T> operator()(CreepQuery<T> const& query) const {
    T const tau = demand(linear_creep_force(query.creepage, query.stiffness), query.adhesion);
    return fastsim_force(query, tau, false, T(1.0));
  }
};

/// Flexibilities of their own for spin, and a surface that gets more flexible with slip: k_0 (k_inf + (1 - k_inf)/(1 + beta
/// epsilon)) multiplies Kalker's stiffness, epsilon = (pi/4) k_0 tau being Polach's gradient of the tangential stress; 1, 1,
/// 0: clean.
struct ModifiedFastsim {
  static constexpr char const* name = "modified_fastsim";
  double k_0{1.0}, k_inf{1.0}, beta{0.0};
  static constexpr auto fields() {
    return members(Member{"k_0", &ModifiedFastsim::k_0, "1",
                          "factor of roughness and contamination on Kalker's stiffness at small creepage"},
                   Member{"k_inf", &ModifiedFastsim::k_inf, "1", "part of k_0 that is left at large creepage"},
                   Member{"beta", &ModifiedFastsim::beta, "1",
                          "decrease of the factor with eps = pi/4 k_0 times linear force over mu N"});
  }

  template <Scalar T>
  CreepForce<T> operator()(CreepQuery<T> const& query) const {
    T const tau = demand(linear_creep_force(query.creepage, query.stiffness), query.adhesion);
    return fastsim_force(query, tau, true, k_0 * (k_inf + (1.0 - k_inf) / (1.0 + (0.25 * pi * beta * k_0) * tau)));
  }
};

}  // namespace rollerrig
