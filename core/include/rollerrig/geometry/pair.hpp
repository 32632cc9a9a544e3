// geometry/pair.hpp - one wheel above one roller or rail: what the contact geometry needs to know.
//
// Frames  b: roller frame of the paper, moved up from the roller axis to the crown level: origin mid-way between the
//            two rollers at the height of the running circle, y along the roller axis, z up. With it a straight rail
//            is the same formula with inverse_radius = 0.
//         r: wheelset frame of the paper (turns with yaw and roll, does not spin).
// Side    everything here is written for a left wheel (y > 0). A right wheel is mirrored before and after.
#pragma once
#include "rollerrig/fields.hpp"
#include "rollerrig/math/curves.hpp"
#include "rollerrig/math/vector.hpp"

namespace rollerrig {

/// What makes a roller differ from a rail. Switching one off answers what it costs, and is no model of any rig; with all
/// of them off a rig is a track. docs/theory/equilibrium_and_linearisation.md, "What a roller changes".
struct RollerEffects {
  bool curvature{true};  ///< Hertz and Kalker see the roller's longitudinal curvature, (15)
  bool conicity{true};   ///< the roller's surface speed follows its local radius; off: crown speed everywhere
  bool spin{true};       ///< the roller's turning counts in the spin creepage
  bool yaw{true};        ///< points and normals lie on a round roller; off: on a straight rail of the same head
  static constexpr auto fields() {
    return members(Member{"curvature", &RollerEffects::curvature}, Member{"conicity", &RollerEffects::conicity},
                   Member{"spin", &RollerEffects::spin}, Member{"yaw", &RollerEffects::yaw});
  }
  bool all() const { return curvature && conicity && spin && yaw; }
};

struct WheelRollerPair {
  UniformSpline const* wheel{nullptr};  ///< z(S), radius increase over the EN abscissa [m]
  UniformSpline const* rail{nullptr};   ///< h(y), height of the generatrix over its abscissa [m]
  double wheel_radius{0.0};             ///< at the tape circle [m]
  double tape_circle_y{0.0};            ///< lateral position of the tape circle on the wheelset [m]
  double rail_origin_y{0.0};            ///< lateral position of the generatrix' highest point in b [m]
  double inverse_radius{0.0};           ///< 1 / crown radius of the roller [1/m]; 0 is a straight rail
  RollerEffects effects{};
  double size{1.0};  ///< over a full-scale wheel and rail: nodes lie in proportion [-]

  /// 1 / radius that points and normals are computed with [1/m].
  double geometry_curvature() const { return effects.yaw ? inverse_radius : 0.0; }
  /// 1 / radius that Hertz sees [1/m].
  double curvature_for_hertz() const { return effects.curvature ? inverse_radius : 0.0; }
};

/// Position and orientation of the wheelset frame seen from b.
template <Scalar T>
struct RelativePose {
  Vec3<T> o;      ///< o_r^b [m], eq. (2)
  Rotation<T> R;  ///< R_br, eq. (2)
};
template <Scalar T>
RelativePose<T> lift(RelativePose<double> const& pose) {
  return {lift<T>(pose.o), lift<T>(pose.R)};
}

}  // namespace rollerrig
