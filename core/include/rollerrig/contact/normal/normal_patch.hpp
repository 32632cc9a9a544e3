// contact/normal/normal_patch.hpp - what every law of normal contact answers: the patches of one wheel, with their load; and the
// force of one patch with its damping.
//
// Signs   gap < 0: the surfaces overlap. gap_rate < 0: they approach. N >= 0 always.
// Source  Malvezzi, Meli, Pugi (2010), eq. (12).
#pragma once
#include <array>
#include <concepts>

#include "rollerrig/contact/normal/hertz.hpp"
#include "rollerrig/contact/patch_strips.hpp"
#include "rollerrig/contact/regularisation.hpp"
#include "rollerrig/fields.hpp"
#include "rollerrig/geometry/contact_point.hpp"
#include "rollerrig/geometry/gap_nodes.hpp"

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

/// Elastic part of one patch, frame b. Forces act on the wheel.
template <Scalar T>
struct NormalPatch {
  ContactPoint<T> point;  ///< centre of the pressures; its gap is the largest approach, negative
  T elastic;              ///< resultant of the pressures along point.n [N]
  T a, b;                 ///< semi-axes along and across the rolling direction, of an equivalent ellipse if need be [m]
  T log_aspect;           ///< ln(a/b)
  T weight{1.0};          ///< blending weight of the patch, 0 to 1: normal/hertz_ellipses.hpp, (S8)
  T damper{1.0};          ///< part of the wheel's normal damper (12) that acts on it [-]
  Vec3<T> pressure_moment{};  ///< about the point, where the pressures' normals differ [N m]
  double peak_pressure{0.0};  ///< [Pa]
  double length{0.0};         ///< loaded length along the rolling direction [m]
  double width{0.0};          ///< loaded width across it [m]
  bool limited{false};        ///< the curvatures were outside Hertz' theory and were limited
  bool refined{false};        ///< the wheel's contact was solved again with many strips: (S5)
};

/// Patches of one wheel: NormalPatch, or what is derived from it.
template <class P>
using PatchList = std::array<P, GapScan::most_minima>;

template <Scalar T>
using WheelStrips = std::array<PatchStrips<T>, GapScan::most_minima>;

/// One wheel on its roller or rail, as a law of normal contact sees it.
struct NormalSetting {
  WheelRollerPair const& pair;
  Material const& material;
  GapNodes const* nodes{nullptr};  ///< of the wheel
};

/// One of several wheels whose normal contacts are computed in one call.
template <Scalar T, std::derived_from<NormalPatch<T>> P>
struct NormalContact {
  NormalSetting wheel;
  RelativePose<T> const* pose;
  PatchList<P>* patches;            ///< result
  int* count;                       ///< result: of them
  WheelStrips<T>* strips{nullptr};  ///< result, if asked for: of each patch; of none by a law that knows no strips
};

}  // namespace rollerrig
