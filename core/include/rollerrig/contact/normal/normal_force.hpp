// contact/normal/normal_force.hpp - elastic and damping force between one wheel and one roller.
//
// Signs   gap < 0: the surfaces overlap. gap_rate < 0: they approach. N >= 0 always.
// Source  Malvezzi, Meli, Pugi (2010), eq. (12).
#pragma once
#include "rollerrig/contact/regularisation.hpp"
#include "rollerrig/fields.hpp"

namespace rollerrig {

/// Damping of eq. (12): acts while the surfaces approach.
struct NormalDamping {
  double damping{1e5}, smoothing_speed{1e-4};
  static constexpr auto fields() {
    return members(
        Member{"damping", &NormalDamping::damping, "N s/m", "damping while the surfaces approach, k_v", not_negative},
        Member{"smoothing_speed", &NormalDamping::smoothing_speed, "m/s",
               "approach speed over which the damping sets in", not_negative});
  }

  /// k_v max(0, -gap_rate) with its corner rounded: departs from (12) by at most k_v smoothing_speed / 2 (5 N), so that
  /// the slope at rest exists (k_v/2, the equivalent of the one-sided damper for small oscillations). Never adds energy.
  template <Scalar T>
  T force(T const& gap_rate) const {
    using std::sqrt;
    double const v0 = smoothing_speed;
    return 0.5 * damping * (sqrt(gap_rate * gap_rate + v0 * v0) - v0 - gap_rate);
  }
};

/// Elastic and dissipative part of the normal force [N].
template <Scalar T>
struct NormalForce {
  T elastic;
  T damping;
  T total() const { return elastic + damping; }
};

///     N = k_h |p|^(3/2) + k_v |p_dot| [p_dot < 0]     (12)
///
/// Elastic part, for gap < 0; a contact that is about to open has none.
template <Scalar T>
T elastic_force(T const& stiffness, T const& gap) {
  using std::sqrt;
  T const depth = select(gap < 0.0, -gap, T(regularisation::approach));
  return stiffness * depth * sqrt(depth);
}

/// Both parts. The sum is never negative: a separating wheel is not pulled back.
template <Scalar T>
NormalForce<T> normal_force(T const& elastic, T const& damping) {
  return {elastic, select(elastic + damping > 0.0, damping, -elastic)};
}

}  // namespace rollerrig
