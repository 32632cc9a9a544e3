// mechatronics/rig_controller.hpp - makes the wheels on dry rollers turn as the virtual wheels do on the degraded rail.
//
//   measured speeds, drive torque -> estimate T, C -> torque C of the axle -> virtual train -> feed-forward and feedback -> torque of each roller's drive
//
//     U = J_r (r/R) w_v' - R T_v  +  feedback of w_v - w        (D5)
//     U = -R T_v                       while the wheel is locked (D15)
//
// C comes from the laws of rig_laws.hpp, and the drives are asked for U by another.
//
// Signs   U positive drives the wheel forward, see estimators.hpp.
// Source  Malvezzi, Pugi et al.: the law of the rig under the pure-rolling assumption; docs/theory/rig_control.md.
#pragma once

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/estimators.hpp"
#include "rollerrig/mechatronics/measurements.hpp"
#include "rollerrig/mechatronics/rig_laws.hpp"
#include "rollerrig/mechatronics/virtual_rail.hpp"
#include "rollerrig/mechatronics/virtual_train.hpp"

namespace rollerrig {

struct RigController {
  static constexpr char const* name = "rig_control";
  static constexpr Command command = Command::roller_torque;

  AssumedParameters assumed{};
  AnyEstimator estimator{};
  AnyAxleTorque axle_torque{};
  AnyFeedback feedback{};
  AnyDriveCommand drive_command{};
  double largest{};
  bool commanded_torque{};  ///< the estimator takes the commanded torque for the one that acts
  bool measured_loads{};    ///< the virtual train's axles carry what is measured, in place of (D9)
  double locked_speed{};
  VirtualTrain train{};
  VirtualRail rail{};

  static constexpr auto fields() {
    using P = RigController;
    return members(Member{"assumed", &P::assumed}, Member{"estimator", &P::estimator},
                   Member{"axle_torque", &P::axle_torque}, Member{"feedback", &P::feedback},
                   Member{"drive_command", &P::drive_command},
                   Member{"largest", &P::largest, "N m", "largest torque command of a roller's drive", not_negative},
                   Member{"commanded_torque", &P::commanded_torque}, Member{"measured_loads", &P::measured_loads},
                   Member{"locked_speed", &P::locked_speed, "m/s",
                          "wheel speed below which a wheel of a faster train is locked, (D15)"},
                   Member{"train", &P::train}, Member{"rail", &P::rail});
  }

  struct AxleState {
    StateOf<AnyEstimator> estimator{};
    StateOf<AnyAxleTorque> axle_torque{};
    StateOf<AnyFeedback> feedback{};
    StateOf<AnyDriveCommand> drive_command{};
    ContactForceEstimate estimate{};  ///< its torque the one that the virtual train takes
    double feed_forward{};            ///< (D5) [N m]
    RailUnderAxle rail{};             ///< the virtual one
    void state(auto& archive) {
      archive(estimator, axle_torque, feedback, drive_command, estimate, feed_forward, rail);
    }
  };
  struct State {
    PerAxle<AxleState> axle{};
    VirtualTrainState train{};
    RailCells rail{};
    SandedRail sand{};
    void state(auto& archive) { archive(axle, train, rail, sand); }
  };

  State start(Measurements const& now, double train_speed, double period) const;
  /// One sample: torque of each roller's drive [N m].
  void step(State& s, Measurements const& now, double period, PerAxle<double>& torque) const;

  /// The drive's speed control in place of the law of the rig: its feedback, on the roller's measured speed.
  ///
  /// @param feed_forward  torque asked for beside it [N m]
  /// @param wanted, roller_speed  [rad/s]
  /// @returns torque of the drive [N m]
  double torque_for_speed(StateOf<AnyFeedback>& state, double feed_forward, double wanted, double roller_speed,
                          double period) const;
  bool controls_speed() const { return !std::holds_alternative<NoFeedback>(feedback); }

 private:
  /// Whether the wheel is locked, and with it that of the virtual train, (D15).
  void lock_or_unlock(VirtualAxle& axle, double train_speed, double axle_speed) const;
  /// The torque of an axle that the virtual train takes, from its estimate and what is known of brake and motor.
  double torque_of_axle(AxleState& axle, Measurements const& now, std::size_t k, double period) const;
};

}  // namespace rollerrig
