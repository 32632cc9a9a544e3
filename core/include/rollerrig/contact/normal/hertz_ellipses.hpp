// contact/normal/hertz_ellipses.hpp - the paper's normal contact: Hertz' ellipse at each indented minimum of the gap.
//
//   minima of the gap -> contact points -> Hertz (12)-(19) -> patches, weighted by (F4) where two merge
#pragma once
#include "rollerrig/contact/normal/blending_weight.hpp"
#include "rollerrig/contact/normal/hertz.hpp"
#include "rollerrig/contact/normal/normal_force.hpp"
#include "rollerrig/contact/normal/normal_patch.hpp"

namespace rollerrig {

/// Hertz' ellipse and load at patch.point.
template <Scalar T>
void hertz_patch(Material const& material, NormalPatch<T>& patch) {
  using std::sqrt;
  auto const& point = patch.point;
  auto const hertz = hertz_contact(material, point.combined_curvature());  // (13), (14), (16)
  T const root_depth = sqrt(select(point.gap < 0.0, -point.gap, T(regularisation::approach)));
  patch.a = hertz.a_per_root * root_depth;  // (17), (18)
  patch.b = hertz.b_per_root * root_depth;
  patch.log_aspect = hertz.log_aspect;
  patch.limited = hertz.limited;
  patch.elastic = elastic_force(hertz.stiffness, point.gap);  // (12)
  patch.length = 2.0 * hertz.ahead_per_root * value_of(root_depth);
  patch.width = 2.0 * hertz.reach_per_root * value_of(root_depth);
  patch.peak_pressure = 1.5 / pi * value_of(patch.elastic) / (value_of(patch.a) * value_of(patch.b));
}

struct HertzEllipses {
  static constexpr char const* name = "hertz";
  double merging_criterion{0.01};
  static constexpr auto fields() {
    return members(Member{"merging_criterion", &HertzEllipses::merging_criterion, "1",
                          "criterion of normal/blending_weight.hpp; 0: patches appear and vanish at full force",
                          not_negative});
  }

  template <Scalar T, std::derived_from<NormalPatch<T>> P>
  int operator()(NormalSetting const& wheel, RelativePose<T> const& pose, PatchList<P>& patches) const {
    auto const minima = find_minima(wheel.pair, *wheel.nodes, numbers_of(pose));
    std::array<ContactPoint<T>, GapMinima::capacity> points;
    for (std::size_t k = 0; k < minima.count; ++k) points[k] = contact_point(wheel.pair, pose, minima.minimum[k]);
    auto const weight = blending_weights(wheel.pair, pose, minima, points.data(), merging_criterion);
    for (std::size_t k = 0; k < minima.count; ++k) {
      NormalPatch<T>& patch = patches[k];
      patch.point = points[k];
      patch.weight = weight[k];
      hertz_patch(wheel.material, patch);
    }
    return static_cast<int>(minima.count);
  }
};

}  // namespace rollerrig
