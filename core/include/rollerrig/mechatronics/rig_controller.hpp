// mechatronics/rig_controller.hpp - makes the wheels on dry rollers move as the virtual wheels do on the degraded rail.
//
//   virtual wheel speed, rate and force -> feed-forward  U = J_r (r/R) w_v' - R T_v     (D5)
//   virtual minus real wheel speed      -> feedback      PI, or sliding mode with a boundary layer
//
// Signs   U positive drives the wheel forward, see contact_force_estimator.hpp.
// Source  Malvezzi, Pugi et al.: the law of the rig under the hypothesis of pure rolling.
#pragma once
#include <algorithm>
#include <cmath>

namespace rollerrig {

enum class FeedbackKind : int { none, proportional_integral, sliding_mode };

struct RigFeedback {
  FeedbackKind kind{FeedbackKind::proportional_integral};
  double proportional{0.0};    ///< [N m s/rad]
  double integral{0.0};        ///< [N m/rad]
  double switching{0.0};       ///< of sliding mode: largest torque [N m]
  double boundary_layer{0.1};  ///< of sliding mode [rad/s]
  double largest{1e9};         ///< of the whole command [N m]
};

class RigFeedbackState {
 public:
  void reset() { integral_ = 0.0; }

  /// Roller torque for one axle.
  ///
  /// @param feed_forward  (D5) [N m]
  /// @param error         virtual minus real wheel speed [rad/s]
  double step(RigFeedback const& p, double feed_forward, double error, double period) {
    double torque = feed_forward;
    if (p.kind == FeedbackKind::sliding_mode) torque += p.switching * std::clamp(error / p.boundary_layer, -1.0, 1.0);
    if (p.kind == FeedbackKind::proportional_integral) {
      double const with = torque + p.proportional * error + p.integral * (integral_ + period * error);
      if (std::fabs(with) <= p.largest) integral_ += period * error;  // no winding up at the limit
      torque += p.proportional * error + p.integral * integral_;
    }
    return std::clamp(torque, -p.largest, p.largest);
  }

 private:
  double integral_{0.0};
};

}  // namespace rollerrig
