// contact/normal/normal_patch.hpp - what every law of normal contact answers: the patches of one wheel, with their load.
#pragma once
#include <array>
#include <concepts>

#include "rollerrig/contact/normal/hertz.hpp"
#include "rollerrig/contact/patch_strips.hpp"
#include "rollerrig/geometry/contact_point.hpp"
#include "rollerrig/geometry/gap_nodes.hpp"

namespace rollerrig {

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

/// Strips of the patches of one wheel.
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
