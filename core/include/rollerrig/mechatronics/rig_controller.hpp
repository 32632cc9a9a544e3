// mechatronics/rig_controller.hpp - makes the wheels on dry rollers turn as the virtual wheels do on the degraded rail.
//
//   measured speeds, drive torque -> estimate T, C -> virtual train -> feed-forward and feedback -> torque of each roller's drive
//
//     U = J_r (r/R) w_v' - R T_v  +  feedback of w_v - w        (D5)
//     U = -R T_v                       while the wheel is locked (D15)
//
// Signs   U positive drives the wheel forward, see estimator/axle_sample.hpp.
// Source  Malvezzi, Pugi et al.: the law of the rig under the pure-rolling assumption; docs/theory/rig_control.md.
#pragma once
#include <string_view>
#include <tuple>

#include "rollerrig/contact/adhesion/recovered_rail.hpp"
#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/estimators.hpp"
#include "rollerrig/mechatronics/feedbacks.hpp"
#include "rollerrig/mechatronics/law_state.hpp"
#include "rollerrig/mechatronics/measurements.hpp"
#include "rollerrig/mechatronics/virtual_rail.hpp"
#include "rollerrig/mechatronics/virtual_train.hpp"

namespace rollerrig {

struct RigController {
  static constexpr char const* name = "rig_control";
  static constexpr Command command = Command::roller_torque;

  AssumedParameters assumed{};
  AnyEstimator estimator{};
  AnyFeedback feedback{};
  double largest{};         ///< torque asked of a roller's drive [N m]
  bool commanded_torque{};  ///< the estimator takes the commanded torque for the one that acts
  bool measured_loads{};    ///< the virtual train's axles carry what is measured, in place of (D9)
  double locked_speed{};    ///< a wheel slower than this on a faster train is locked, (D15) [m/s]
  VirtualTrain train{};
  VirtualRail rail{};

  static constexpr auto fields() {
    using P = RigController;
    return std::tuple{Member{"assumed", &P::assumed},
                      Member{"estimator", &P::estimator},
                      Member{"feedback", &P::feedback},
                      Member{"largest", &P::largest, not_negative},
                      Member{"commanded_torque", &P::commanded_torque},
                      Member{"measured_loads", &P::measured_loads},
                      Member{"locked_speed", &P::locked_speed},
                      Member{"train", &P::train},
                      Member{"rail", &P::rail}};
  }

  struct AxleState {
    StateOf<AnyEstimator> estimator{};
    StateOf<AnyFeedback> feedback{};
    ContactForceEstimate estimate{};
    double feed_forward{};  ///< (D5) [N m]
    double energy{};        ///< dissipated per area of the virtual rail under the axle [J/m^2]
  };
  struct State {
    PerAxle<AxleState> axle{};
    VirtualTrainState train{};
    RecoveredRail rail{};
  };

  State start(Measurements const& now, double train_speed, double period) const;
  /// One sample: torque of each roller's drive [N m].
  void step(State& s, Measurements const& now, double period, PerAxle<double>& torque) const;

 private:
  /// Whether the wheel is locked, and with it that of the virtual train, (D15).
  void lock_or_unlock(State& s, int axle, double axle_speed) const;
  void recover(State& s, int axle, double from) const;
};

}  // namespace rollerrig
